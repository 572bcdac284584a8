"""What LinuxCNC's INI file says of a machine.

LinuxCNC keeps values as text under a section; a name may stand several times, a comment has a line of its own
or follows a number, and ``#INCLUDE`` takes in another file.  Speeds are in machine units a second, periods in
nanoseconds (LinuxCNC user manual, "INI Configuration").
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from chipbreak.dialects.modes import Units
from chipbreak.dialects.path_mode import path_mode_in
from chipbreak.machine_files.found import Found, Machine, first_of, plain
from chipbreak.settings.axis_words import AXES
from chipbreak.text.bounds import MOST_PROFILE_BYTES, read_bounded
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.existence import is_file
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import MM_PER_INCH, S_PER_MIN

# Of lines without blanks at their ends.
_LINE = re.compile(r"([A-Za-z0-9_]+)\s*=\s*(.*)")
_SECTION = re.compile(r"\[([^\]]*)\].*")
_INCLUDE = re.compile(r"#INCLUDE\s+(.+)")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_PATH_MODE = re.compile(r"(G6[14](?:\.1)?)(?![\d.])((?:\s*[PQ]\s*\d*\.?\d+)*)", re.IGNORECASE)
_TOLERANCE = re.compile(r"([PQ])\s*([\d.]+)", re.IGNORECASE)
_UNITS = re.compile(r"G2([01])(?![\d.])", re.IGNORECASE)
_MM_PER_UNIT = {"mm": 1.0, "metric": 1.0, "inch": MM_PER_INCH, "in": MM_PER_INCH, "imperial": MM_PER_INCH}
_MOST_INCLUDES = 16
_MOST_FILES = 200
_NO_LIMIT = 1e6  # units a second
_NS_PER_MS = 1e6
_AXIS_KEYS = (
    ("MAX_VELOCITY", "max_velocity_mm_min", S_PER_MIN),
    ("MAX_ACCELERATION", "max_acceleration_mm_s2", 1.0),
)
_TRUE = ("1", "yes", "true", "on")


class _Entry(NamedTuple):
    """A value and where it stands."""

    section: str
    name: str
    text: str
    place: str

    @property
    def number(self) -> float | None:
        """What it starts with, where that is a number."""
        match = _NUMBER.match(self.text)
        return float(match[0]) if match else None

    @property
    def is_limit(self) -> bool:
        """True where it limits anything: some files say 1e99 for "no limit"."""
        return self.number is not None and 0.0 < self.number < _NO_LIMIT

    @property
    def source(self) -> str:
        """For a comment of the profile."""
        return plain(f"[{self.section}] {self.name} = {self.text} ({self.place})")


class _Ini(NamedTuple):
    """All entries, by section and name in capitals; of several the first, as the control reads it."""

    folder: Path
    entries: Mapping[tuple[str, str], _Entry]

    def get(self, section: str, name: str) -> _Entry | None:
        """The entry of a name, if it is there."""
        return self.entries.get((section, name))

    def number(self, section: str, name: str) -> float | None:
        """The number of a name, if it is there and one."""
        entry = self.get(section, name)
        return None if entry is None else entry.number

    def is_on(self, section: str, name: str) -> bool:
        """True for a switch that is on."""
        entry = self.get(section, name)
        return entry is not None and entry.text.lower() in _TRUE

    @property
    def mm_per_unit(self) -> float:
        """Millimetres in a machine unit.  Errors: INI002."""
        entry = self.get("TRAJ", "LINEAR_UNITS")
        if entry is None:
            raise RefusalError("INI002", "the INI file does not say [TRAJ] LINEAR_UNITS", "mm or inch")
        known = _MM_PER_UNIT.get(entry.text.lower())
        size = known if known is not None else (entry.number and 1.0 / entry.number)
        if not size or size < 0:
            message = plain(f"[TRAJ] LINEAR_UNITS = {entry.text} ({entry.place}) is no unit")
            raise RefusalError("INI002", message, "mm or inch")
        return float(size)

    @property
    def axes(self) -> list[str]:
        """The letters of the joints in their order, as trivkins has them."""
        entry = self.get("TRAJ", "COORDINATES")
        return re.findall(r"[A-Z]", entry.text.upper()) if entry else ["X", "Y", "Z"]


def machine_of_ini(path: str | Path) -> Machine:
    """The machine that an INI file describes.  Errors: INI001 no such file, INI002 no unit."""
    ini = _read(Path(path))
    base = "linuxcnc-lathe" if _is_lathe(ini) else "linuxcnc-mill"
    found = first_of(one for rule in _RULES for one in rule(ini))
    there = {one.key for one in found}
    missing = [
        f"axes.{axis}.max_acceleration_mm_s2: no [AXIS_{axis}] MAX_ACCELERATION"
        for axis in AXES
        if axis in ini.axes and f"axes.{axis}.max_acceleration_mm_s2" not in there
    ]
    return Machine(base, found, (*missing, *_missing_table(ini)))


def _missing_table(ini: _Ini) -> Iterator[str]:
    table = _table_of(ini)
    if table is not None and not is_file(table):
        yield plain(f"tools.files: {table}, the TOOL_TABLE of [EMCIO], is not there")


def _is_lathe(ini: _Ini) -> bool:
    return ini.is_on("DISPLAY", "LATHE") or ini.is_on("DISPLAY", "BACK_TOOL_LATHE") or "Y" not in ini.axes


def _read(path: Path) -> _Ini:
    entries: dict[tuple[str, str], _Entry] = {}
    section = ""
    for place, line in _all_lines(path, 0, []):
        if header := _SECTION.fullmatch(line):
            section = header[1].strip().upper()
        elif match := _LINE.fullmatch(line):
            entry = _Entry(section, match[1].upper(), match[2], place)
            entries.setdefault((section, entry.name), entry)
    if not entries:
        raise RefusalError("INI001", plain(f"{path} is no INI file of LinuxCNC"), "it has lines NAME = VALUE")
    return _Ini(path.parent, entries)


def _all_lines(path: Path, depth: int, read: list[Path]) -> Iterator[tuple[str, str]]:
    """Lines with their places, those of included files where they are included; ``read`` grows by each."""
    read.append(path)
    if depth > _MOST_INCLUDES or len(read) > _MOST_FILES:
        raise RefusalError("INI001", plain(f"{path} includes itself"), "look at its #INCLUDE lines")
    try:
        text = read_bounded(path, MOST_PROFILE_BYTES).decode("utf-8-sig", "surrogateescape")
    except OSError as error:
        message = plain(f"cannot read {path}: {error.strerror}")
        raise RefusalError("INI001", message, "name the INI file that LinuxCNC is started with") from None
    for number, bare in enumerate(text.splitlines(), 1):
        line = bare.strip()
        # LinuxCNC takes an include only where the line begins with it.
        if bare[:1] == "#" and (include := _INCLUDE.fullmatch(line)):
            yield from _all_lines(path.parent / _at_home(include[1]), depth + 1, read)
        elif line[:1] not in ("#", ";"):
            yield f"{path.name}, line {number}", line


def _at_home(name: str) -> Path:
    """``~/common.ini``; a name that begins so and is of nobody stays as it is."""
    try:
        return Path(name).expanduser()
    except RuntimeError:
        return Path(name)


def _limits(ini: _Ini) -> Iterator[Found]:
    """Of an axis and its joints the lesser limit: the planner keeps to the one, the joint to the other."""
    mm = ini.mm_per_unit
    for axis in AXES:
        sections = [f"AXIS_{axis}", *(f"JOINT_{i}" for i, letter in enumerate(ini.axes) if letter == axis)]
        for name, key, factor in _AXIS_KEYS:
            entries = [e for s in sections if (e := ini.get(s, name)) and e.is_limit]
            if entries:
                least = min(entries, key=lambda entry: entry.number or 0.0)
                value = (least.number or 0.0) * mm * factor
                yield Found(f"axes.{axis}.{key}", value, least.source)


def _period(ini: _Ini) -> Iterator[Found]:
    entry = ini.get("EMCMOT", "SERVO_PERIOD")
    if entry is not None and entry.number:
        yield Found("planner.servo_period_ms", entry.number / _NS_PER_MS, entry.source)


def _override(ini: _Ini) -> Iterator[Found]:
    """How far the feed can be turned up, which its planner reckons with."""
    entry = ini.get("DISPLAY", "MAX_FEED_OVERRIDE")
    if entry is not None and entry.number is not None and entry.number >= 1.0:
        yield Found("planner.max_feed_override", entry.number, entry.source)


def _start_up_codes(ini: _Ini) -> Iterator[Found]:
    """The path mode that is in force where a program says none."""
    entry = ini.get("RS274NGC", "RS274NGC_STARTUP_CODE") or ini.get("EMC", "RS274NGC_STARTUP_CODE")
    modes = _PATH_MODE.findall(entry.text) if entry else []
    if entry and modes:
        code, tolerances = modes[-1]
        words = " ".join([code, *map("".join, _TOLERANCE.findall(tolerances))]).upper()
        yield Found("planner.usual_path_mode", path_mode_in(words, _units_of(entry, ini), "mm"), entry.source)


def _units_of(entry: _Entry, ini: _Ini) -> Units:
    """Those of its G20 or G21, else those of the machine."""
    said = _UNITS.findall(entry.text)
    is_inch = said[-1] == "0" if said else abs(ini.mm_per_unit - MM_PER_INCH) < 1e-9
    return "inch" if is_inch else "mm"


def _spindle(ini: _Ini) -> Iterator[Found]:
    keys = {"MAX_FORWARD_VELOCITY": "spindle.max_rpm", "MIN_FORWARD_VELOCITY": "spindle.min_rpm"}
    for name, key in keys.items():
        entry = ini.get("SPINDLE_0", name)
        if entry is not None and entry.number is not None and entry.number >= 1.0:
            yield Found(key, entry.number, entry.source)


def _table_of(ini: _Ini) -> Path | None:
    entry = ini.get("EMCIO", "TOOL_TABLE")
    return (ini.folder / entry.text).absolute() if entry is not None and entry.text else None


def _tool_table(ini: _Ini) -> Iterator[Found]:
    """The tool table, where there is one: a profile that names a file that is not there cannot be used."""
    entry = ini.get("EMCIO", "TOOL_TABLE")
    table = _table_of(ini)
    if entry is not None and table is not None and is_file(table):
        unit = "inch" if abs(ini.mm_per_unit - MM_PER_INCH) < 1e-9 else "mm"
        yield Found("tools.files", [str(table)], entry.source)
        yield Found("tools.table_unit", unit, "[TRAJ] LINEAR_UNITS")


_RULES: tuple[Callable[[_Ini], Iterator[Found]], ...] = (
    _period,
    _override,
    _start_up_codes,
    _limits,
    _spindle,
    _tool_table,
)
