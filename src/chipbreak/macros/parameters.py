"""What the macros must know about a machine and its laser barrier."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from chipbreak.diagnostics import RefusalError

NOT_SET, IMPOSSIBLE, UNKNOWN = "MCR001", "MCR002", "MCR003"
# Names as they stand in a profile, with what people need to measure or look up for each.
_NEEDED = {
    "beam_x_mm": "machine X of the beam's focus",
    "beam_y_mm": "machine Y of the beam, which runs along X",
    "beam_z_mm": "machine Z of the spindle nose if it stood in the beam",
    "safe_z_mm": "machine Z where the longest tool is clear of everything",
    "master_length_mm": "from the spindle nose to the end of the master bar",
    "master_diameter_mm": "diameter of the master bar",
}


class UnsetError(RefusalError):
    """The settings lack something that nobody may guess."""


def _above(default: float | None, limit: float = 0.0) -> Any:
    return dataclasses.field(default=default, metadata={"above": limit})


def _at_least(default: float, limit: float = 0.0) -> Any:
    return dataclasses.field(default=default, metadata={"at_least": limit})


@dataclass(frozen=True)
class MacroSettings:
    """Settings of the macros; lengths in mm and machine coordinates, feeds in mm/min.

    ``beam_input`` is the number of the signal variable (#1000 and up) or of LinuxCNC's digital input.
    ``master_tool`` 0: the master bar is in the spindle already.  ``orient`` stops the spindle at ``{angle}``.
    ``turn_sign`` is -1 where the angle counts against M3.  ``clear_mm`` is how far beside and above the beam
    the tool waits, ``search_mm`` how much shorter than said a tool may be and still be found, ``above_mm``
    how far above the lower end, a corner or a point the radius is measured, ``inset_mm`` how far inside the
    outer edge the length is.  ``store_first`` and ``store_last`` bound the variables of the stored edges.
    """

    beam_x_mm: float | None = None
    beam_y_mm: float | None = None
    beam_z_mm: float | None = None
    safe_z_mm: float | None = None
    master_length_mm: float | None = _above(None)
    master_diameter_mm: float | None = _above(None)
    master_tool: int = _at_least(0)
    beam_input: int = _at_least(0)
    alarm_base: int = _at_least(100, 1)
    retries: int = _at_least(1)
    entry_feed: float = _above(3000.0)
    fast_feed: float = _above(600.0)
    slow_feed: float = _above(12.0)
    clear_mm: float = _above(2.0)
    back_mm: float = _above(0.2)
    search_mm: float = _above(10.0)
    above_mm: float = _above(0.1)
    inset_mm: float = _above(0.2)
    resolution_mm: float = _above(0.001)
    runout_mm: float = _above(0.005)
    long_mm: float = _above(3.0)
    diameter_mm: float = _above(0.5)
    trace_step_mm: float = _above(0.5)
    turn_sign: int = 1
    store_first: int = _at_least(500, 1)
    store_last: int = _at_least(999, 1)
    orient: str = "M19 R{angle}"
    laser_on: str = ""
    laser_off: str = ""

    def checked(self) -> MacroSettings:
        """These settings; raises UnsetError (MCR001) or RefusalError (MCR002) when they cannot be used."""
        missing = [name for name in _NEEDED if getattr(self, name) is None]
        if missing:
            lines = "; ".join(f"macros.{name}: {_NEEDED[name]}" for name in missing)
            raise UnsetError(NOT_SET, f"the macros need {len(missing)} more values", lines)
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            low, least = field.metadata.get("above"), field.metadata.get("at_least")
            if (low is not None and not value > low) or (least is not None and not value >= least):
                bound = f"above {low:g}" if low is not None else f"at least {least:g}"
                raise RefusalError(IMPOSSIBLE, f"macros.{field.name} = {value} cannot be", f"it is {bound}")
        if self.turn_sign not in (-1, 1):
            raise RefusalError(IMPOSSIBLE, f"macros.turn_sign = {self.turn_sign} cannot be", "it is 1 or -1")
        if "{angle}" not in self.orient:
            message = f'macros.orient = "{self.orient}" names no {{angle}}'
            raise RefusalError(IMPOSSIBLE, message, 'for example "M19 R{angle}"')
        if self.store_last < self.store_first + 20:
            message = f"macros.store_last = {self.store_last} leaves no room behind store_first"
            raise RefusalError(
                IMPOSSIBLE, message, "one tool takes 12 values and its teeth times its heights"
            )
        return self


def from_options(options: dict[str, Any]) -> MacroSettings:
    """Settings from keys and values; raises RefusalError MCR003 for a key there is not, MCR002 for a type."""
    fields = {field.name: field for field in dataclasses.fields(MacroSettings)}
    given: dict[str, Any] = {}
    for key, value in options.items():
        if key not in fields:
            raise RefusalError(UNKNOWN, f"there is no key macros.{key}", f"known: {', '.join(fields)}")
        kind = str(fields[key].type)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        fits = isinstance(value, str) if kind == "str" else is_number
        if not fits or (kind == "int" and value != int(value)):
            raise RefusalError(IMPOSSIBLE, f"macros.{key} = {value!r} cannot be", f"it is of type {kind}")
        given[key] = value if kind == "str" else int(value) if kind == "int" else float(value)
    return MacroSettings(**given)


def split_options(options: Sequence[str]) -> tuple[MacroSettings, tuple[str, ...]]:
    """Settings from the ``macros.key=value`` among options, and the other options."""
    own: dict[str, Any] = {}
    others = []
    for option in options:
        key, _, text = option.partition("=")
        section, _, name = key.strip().partition(".")
        if section != "macros":
            others.append(option)
            continue
        try:
            own[name] = tomllib.loads(f"v = {text}")["v"]
        except tomllib.TOMLDecodeError:
            own[name] = text.strip()
    return from_options(own), tuple(others)
