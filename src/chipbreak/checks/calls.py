"""How a check is asked for: blocks with named fields, shipped or from the profile.

::

    [calls.renishaw]
    chip_check = ["G65 P9858 T{tool} H{limit}"]
"""

from __future__ import annotations

import enum
import string
from collections.abc import Iterable, Mapping
from typing import Final

from chipbreak.checks.left_behind import left_behind
from chipbreak.checks.tool_values import DATA_FIELDS, data_texts
from chipbreak.checks.touch_plate import PLATE_FIELDS, TouchPlate, touch_plate_of
from chipbreak.dialects import BUILT_IN, DIALECTS, CallTemplates
from chipbreak.dialects.check_programs import SETTER
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.syntax.parse import read_block
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.nearest import nearest
from chipbreak.tools.data import ToolData
from chipbreak.units import mm_per_unit

UNKNOWN_SET: Final = "SET030"
UNKNOWN_CHECK: Final = "SET031"
UNKNOWN_FIELD: Final = "SET032"
UNREADABLE_BLOCK: Final = "SET033"
LONG_BLOCK: Final = "SET034"
NOT_HANDED_OVER: Final = "SET035"
LEFT_BEHIND: Final = "SET036"
PLATE_ABOVE: Final = "SET037"
# How much of an edge a CHIP CHECK looks at; its calls count these from 0.  Where a value that is left out
# reads as 0, the shortest one is -1.
DEPTHS: Final = ("breakage", "limit-line", "full")
# No inserted block is longer, whatever the control takes: people read them on its screen.
LONGEST_BLOCK = 80
_DECIMALS = 6  # of a limit: 0.02 mm in inches is 0.000787


class CheckKind(enum.Enum):
    """The checks that can be called; the values are the keys of a set of calls."""

    CALIBRATE = "calibrate"
    TOOL_CHECK = "tool_check"
    TRACE = "trace"
    CHIP_CHECK = "chip_check"

    @property
    def title(self) -> str:
        """The name in comments and reports."""
        return self.value.upper().replace("_", " ")


class CallValues(NamedTuple):
    """The values of the fields of a call; None where a check has no such value.

    ``every`` is 1 where each workpiece is checked, ``sister`` 0 where no tool may take this one's place,
    ``depth`` the place of ``checks.depth`` in DEPTHS, ``work_offset`` the code of the one in force.
    """

    tool: int | None = None
    speed_rpm: float | None = None
    height_mm: float | None = None
    limit_mm: float | None = None
    operation: str | None = None
    data: ToolData | None = None
    every: int = 1
    sister: int = 0
    depth: int = DEPTHS.index("limit-line")
    plate: TouchPlate | None = None
    work_offset: str = ""

    def fields(self, *, is_inch: bool) -> dict[str, str]:
        """The texts of all fields that have a value; lengths without ``_mm`` are in program units."""
        scale = mm_per_unit(is_inch=is_inch)
        texts = data_texts(self.data, is_inch=is_inch) if self.data else {}
        for name, value in (("height", self.height_mm), ("limit", self.limit_mm)):
            if value is not None:
                texts[f"{name}_mm"] = print_number(value, _DECIMALS)
                texts[name] = print_number(value / scale, _DECIMALS)
        texts |= {"every": str(self.every), "sister": str(self.sister), "depth": str(self.depth)}
        texts["depth_signed"] = str(self.depth or -1)
        if self.tool is not None:
            texts["tool"] = str(self.tool)
        if self.speed_rpm is not None:
            texts["speed_rpm"] = print_number(self.speed_rpm, 0, point=False)
        if self.operation is not None:
            texts["operation"] = self.operation
        # Where a profile names no plate, what is planned is thrown away, and the missing keys are said.
        plate = self.plate.texts(is_inch=is_inch) if self.plate else dict.fromkeys(PLATE_FIELDS, "")
        return texts | plate | {"work_offset": self.work_offset}


# The longest text that each field may have: tools of 2 m, and places as far off.
_LONGEST: Final[Mapping[str, str]] = {
    "tool": "99999999",
    "speed_rpm": "100000",
    "every": "9999",
    "sister": "99999999",
    "depth": "2",
    "depth_signed": "-1",
    "operation": "SEMI-FINISH",
    **dict.fromkeys(("limit", "limit_mm", "height", "height_mm"), "20.123457"),
    "type": "BULL NOSE END MILL",
    "kind": "1",
    "teeth": "99",
    **dict.fromkeys(("tip", "corner_radius", "corner_radius_mm"), "999.9999"),
    "helix": "-84.99",
    "point": "118.99",
    **dict.fromkeys(
        ("diameter", "diameter_mm", "length", "length_mm", "holder", "holder_mm", "setter_depth"), "1999.9999"
    ),
    **dict.fromkeys(("setter_x", "setter_y", "safe_z"), "-1999.9999"),
    "clear": "99.9999",
    "fast_feed": "99999.9999",
    "slow_feed": "9999.9999",
    "work_offset": "G54",
}
_DEPTH = ("depth", "depth_signed")
_HEIGHT = ("height", "height_mm")
_LIMIT = ("limit", "limit_mm", "operation")
_FIELDS_OF: Final[Mapping[CheckKind, tuple[str, ...]]] = {
    CheckKind.CALIBRATE: ("every",),
    CheckKind.TOOL_CHECK: ("tool", "speed_rpm", "every", "sister", *_LIMIT, *DATA_FIELDS),
    CheckKind.TRACE: ("tool", "speed_rpm", *_DEPTH, "every", "sister", *_LIMIT, *_HEIGHT, *DATA_FIELDS),
    CheckKind.CHIP_CHECK: ("tool", *_DEPTH, "every", "sister", *_LIMIT, *_HEIGHT, *DATA_FIELDS),
}


class CallSet(NamedTuple):
    """The blocks of every check that is called; see :class:`CallTemplates`."""

    name: str
    blocks: Mapping[CheckKind, tuple[str, ...]]
    tails: Mapping[CheckKind, str]
    ends_offset: bool
    returning: frozenset[CheckKind] = frozenset()
    in_line: bool = False
    keeps: str = ""

    def has(self, kind: CheckKind) -> bool:
        """True when this set has a call for a check."""
        return kind in self.blocks

    def needs(self, kind: CheckKind, field: str) -> bool:
        """True when a call uses a field."""
        return any(field in _fields(block) for block in self.blocks.get(kind, ()))

    def counts_on(self, kind: CheckKind) -> tuple[CheckKind, ...]:
        """The checks whose values a call needs: a TRACE counts on what the TOOL CHECK before it said."""
        return (CheckKind.TOOL_CHECK, kind) if kind is CheckKind.TRACE else (kind,)

    def lacking(self, kind: CheckKind, values: CallValues) -> list[str]:
        """The fields about the tool that a call uses and that have no value."""
        known = values.fields(is_inch=False)
        blocks = [block for one in self.counts_on(kind) for block in self.blocks.get(one, ())]
        used = [field for block in blocks for field in _fields(block)]
        return [field for field in dict.fromkeys(used) if field in DATA_FIELDS and field not in known]

    def hands_over(self, field: str) -> bool:
        """True when any call says a field."""
        return any(
            self.needs(kind, field) or field in _fields(self.tails.get(kind, "")) for kind in CheckKind
        )

    def hands_over_depth(self) -> bool:
        """True when a call says how much of an edge is looked at."""
        return self.hands_over("depth") or self.hands_over("depth_signed")

    def uses_tool_data(self) -> bool:
        """True when any call says something about the tool but its number."""
        return any(self.needs(kind, field) for kind in self.blocks for field in DATA_FIELDS)

    def text(self, kind: CheckKind, values: CallValues, *, is_inch: bool) -> tuple[str, ...]:
        """The blocks of a check with its values; one that needs a value that is not known is left out."""
        fields = values.fields(is_inch=is_inch)
        unsaid = set(DATA_FIELDS) - fields.keys()
        kept = [block for block in self.blocks[kind] if not unsaid.intersection(_fields(block))]
        if kept and (values.every > 1 or values.sister):
            kept[-1] += self.tails.get(kind, "")
        return tuple(block.format_map(fields) for block in kept)


def calls_of(settings: Settings) -> CallSet:
    """The calls that the profile asks for; :func:`check_blocks` says whether the control reads them.

    Raises RefusalError: SET030 unknown set, SET031 unknown check, SET035 a set that does not tell the control
    what the profile asks for, SET037 a plate that is not below the safe height.
    """
    found = _read(settings.checks.calls, settings)
    _check_plate(found, settings)
    checks = settings.checks
    # The length is what every set looks at, and "limit-line" is what a profile has that says nothing.
    unsaid = {
        "every": checks.every > 1 and not found.hands_over("every"),
        "sister": bool(checks.sister) and not found.hands_over("sister"),
        "depth": checks.depth == "full" and not found.hands_over_depth(),
    }
    for field, is_unsaid in unsaid.items():
        if is_unsaid:
            message = f"checks.{field} is set, but no call of the set {found.name} hands {{{field}}} over"
            help_text = f"use calls that take it, or leave checks.{field} out"
            raise RefusalError(NOT_HANDED_OVER, message, help_text)
    return found


def check_sets(settings: Settings) -> None:
    """All sets that a profile describes, and the one it uses; raises what the functions above raise.

    The blocks of a set that comes with the control are looked at when a check is put in: a block of a macro
    call is read by the grammar, which takes longer to load than all else of a small program.
    """
    for name in settings.call_sets:
        check_blocks(name, settings)
    if settings.checks.enabled:
        calls_of(settings)


def check_blocks(name: str, settings: Settings) -> None:
    """Every block of a set, with the longest values it may get.

    Raises RefusalError: SET030 unknown set, SET031 unknown check, SET032 unknown field, SET033 a block that
    cannot be read, SET034 a block that may become too long, SET036 a block that leaves something behind.
    """
    calls = _read(name, settings)
    limit = min(LONGEST_BLOCK, settings.control.max_line_chars)
    for kind, templates in calls.blocks.items():
        where = f"calls.{name}.{kind.value}"
        for template in templates:
            whole = template + (calls.tails.get(kind, "") if template == templates[-1] else "")
            _check(where, whole, kind, limit, settings, is_in_line=calls.in_line)


def _read(name: str, settings: Settings) -> CallSet:
    """The set of a name."""
    shipped = _shipped(name, settings)
    names = [one.value for one in CheckKind]
    for key in shipped.blocks:
        if key not in names:
            message = f"calls.{name}.{key}: there is no such check"
            raise RefusalError(UNKNOWN_CHECK, message, _nearest(key, names))
    blocks = {CheckKind(key): tuple(templates) for key, templates in shipped.blocks.items()}
    tails = {CheckKind(key): tail for key, tail in shipped.tails.items()}
    returning = frozenset(map(CheckKind, shipped.returning))
    return CallSet(name, blocks, tails, shipped.ends_offset, returning, shipped.in_line, shipped.keeps)


def _shipped(name: str, settings: Settings) -> CallTemplates:
    """The set of a name; the profile's own come first, then those of the control."""
    if name in settings.call_sets:
        return CallTemplates(settings.call_sets[name])
    dialect = settings.dialect
    if name in dialect.call_sets:
        return _moved(dialect.call_sets[name], settings) if name == BUILT_IN else dialect.call_sets[name]
    others = {one: other.name for other in DIALECTS for one in other.call_sets}
    if name not in others:
        message = f'checks.calls: there is no set of calls "{name}"'
        known = dict.fromkeys([BUILT_IN, *settings.call_sets, *dialect.call_sets, *others])
        raise RefusalError(UNKNOWN_SET, message, _nearest(name, known))
    message = f'checks.calls: the set "{name}" is for the dialect {others[name]}, not for {dialect.name}'
    if name == BUILT_IN:
        message = f"there are no built-in calls for the dialect {dialect.name}: {dialect.no_macros}"
    way_out = "describe your own in [calls.NAME], and set checks.calls"
    if SETTER in dialect.call_sets:
        way_out = f"set checks.calls={SETTER} where a touch plate finds broken tools; or {way_out}"
    raise RefusalError(UNKNOWN_SET, message, way_out)


def _check_plate(calls: CallSet, settings: Settings) -> None:
    plate = touch_plate_of(settings)
    if calls.in_line and plate is not None and plate.depth_mm <= 0.0:
        places = f"macros.safe_z_mm ({plate.safe_z_mm:z.6g}) is not above macros.setter_z_mm"
        message = f"{places} ({plate.safe_z_mm - plate.depth_mm:z.6g})"
        help_text = "setter_z_mm is the lowest Z of the spindle nose at which a tool must have met the plate"
        raise RefusalError(PLATE_ABOVE, message, help_text)


def _moved(templates: CallTemplates, settings: Settings) -> CallTemplates:
    """The built-in calls with the program numbers of the profile."""
    macros, own = settings.dialect.macros, settings.macros
    if macros is None:
        return templates
    blocks = {
        kind: tuple(macros.moved(text, own.first_program, own.first_variable) for text in texts)
        for kind, texts in templates.blocks.items()
    }
    return templates._replace(blocks=blocks)


def _check(
    where: str, template: str, kind: CheckKind, limit: int, settings: Settings, *, is_in_line: bool
) -> None:
    """Refuse a template that could write something the control does not read.

    One that is written out in the program may set F: that is given back.
    """
    known = (*_FIELDS_OF[kind], *((*PLATE_FIELDS, "work_offset") if is_in_line else ()))
    try:
        fields = _fields(template)
    except ValueError as error:
        message = f'{where}: "{template}" cannot be read: {error}'
        raise RefusalError(UNREADABLE_BLOCK, message, "write fields in braces, such as {tool}") from None
    for field in fields:
        if field not in known:
            message = f'{where}: "{template}" has a field {{{field}}}, which {kind.value} does not have'
            raise RefusalError(UNKNOWN_FIELD, message, _nearest(field, known))
        if field == "speed_rpm" and settings.dialect.is_lathe:
            message = f'{where}: "{template}": S of a lathe turns the workpiece, not the tool'
            raise RefusalError(UNKNOWN_FIELD, message, "write the speed of a driven tool as a number")
    _check_block(where, template, limit, settings)
    if not is_in_line:
        _check_left_behind(where, template, settings)


def _check_block(where: str, template: str, limit: int, settings: Settings) -> None:
    """Refuse what is no block, or a block that would do more than a call may."""
    text = template.format_map(_LONGEST)
    block = read_block(0, text, settings.dialect)
    why = block.opaque or ("it holds no words" if block.is_empty else "")
    if not (text.isascii() and text.isprintable()):
        why = "it holds characters that no control reads"
    if why:
        message = f'{where}: "{template}" is no block: {why}'
        raise RefusalError(UNREADABLE_BLOCK, message, "write one block a line, as in a program")
    if len(text) > limit:
        message = f'{where}: "{template}" can become {len(text)} characters long, the limit is {limit}'
        raise RefusalError(LONG_BLOCK, message, "split it into two blocks")


def _check_left_behind(where: str, template: str, settings: Settings) -> None:
    """Refuse what nobody gives back."""
    text = template.format_map(_LONGEST)
    lasting = left_behind(read_block(0, text, settings.dialect), settings)
    if lasting:
        message = f'{where}: "{template}" {lasting}, and nothing gives back what was before it'
        raise RefusalError(LEFT_BEHIND, message, "do that in the macro that is called, which gives it back")


def _fields(template: str) -> list[str]:
    """The field names of a template; a ValueError for braces that do not match or hold more than a name."""
    names = []
    for _, name, form, conversion in string.Formatter().parse(template):
        if name is not None and (form or conversion):
            raise ValueError(f"{{{name}}} takes no format")
        names += [name] if name is not None else []
    return names


def _nearest(name: str, known: Iterable[str]) -> str:
    names = list(known)
    near = nearest(name, names, 0.5)
    if near:
        return f"did you mean {near}?"
    return f"known: {', '.join(names)}" if names else "this check has no fields"
