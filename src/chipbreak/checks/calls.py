"""How a check is asked for: blocks with named fields, built in per dialect or from the profile.

::

    [calls.renishaw]
    chip_check = ["G65 P9858 T{tool} H{limit}"]
"""

from __future__ import annotations

import enum
import string
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

from chipbreak.checks.tool_values import DATA_FIELDS, data_texts
from chipbreak.diagnostics import RefusalError
from chipbreak.nearest import nearest
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.syntax.parse import read_block
from chipbreak.tools.data import ToolData
from chipbreak.units import MM_PER_INCH

UNKNOWN_SET, UNKNOWN_EVENT, UNKNOWN_FIELD = "SET030", "SET031", "SET032"
UNREADABLE_BLOCK, LONG_BLOCK = "SET033", "SET034"
# No inserted block is longer, whatever the control takes: people read them on its screen.
LONGEST_BLOCK = 80
_DECIMALS = 6  # of a limit: 0.02 mm in inches is 0.000787


class Event(enum.Enum):
    """What can be called; the values are the keys of a set of calls."""

    CALIBRATE = "calibrate"
    TOOL_CHECK = "tool_check"
    TRACE = "trace"
    CHIP_CHECK = "chip_check"

    @property
    def title(self) -> str:
        """The name in comments and reports."""
        return self.value.upper().replace("_", " ")


class CallValues(NamedTuple):
    """What the fields of a call stand for; None where an event has no such value."""

    tool: int | None = None
    speed_rpm: float | None = None
    height_mm: float | None = None
    limit_mm: float | None = None
    operation: str | None = None
    data: ToolData | None = None

    def fields(self, *, is_inch: bool) -> dict[str, str]:
        """The texts of all fields that have a value; lengths without ``_mm`` are in program units."""
        scale = MM_PER_INCH if is_inch else 1.0
        texts = data_texts(self.data, is_inch=is_inch) if self.data else {}
        for name, value in (("height", self.height_mm), ("limit", self.limit_mm)):
            if value is not None:
                texts[f"{name}_mm"] = print_number(value, _DECIMALS)
                texts[name] = print_number(value / scale, _DECIMALS)
        if self.tool is not None:
            texts["tool"] = str(self.tool)
        if self.speed_rpm is not None:
            texts["speed_rpm"] = print_number(self.speed_rpm, 3, point=False)
        if self.operation is not None:
            texts["operation"] = self.operation
        return texts


# The point angle stands where another tool has its radius, and needs no more room.
_LONGEST_DATA = ToolData(
    number=99999999,
    type="bull nose end mill",
    teeth=200,
    diameter_mm=1999.9999,
    length_mm=1999.9999,
    corner_radius_mm=999.9999,
    helix_deg=-84.99,
    point_deg=118.99,
    holder_mm=1999.9999,
)
_LONGEST = CallValues(99999999, 99999.999, 20.123457, 20.123457, "SEMI-FINISH", _LONGEST_DATA)
_EVENT_FIELDS: Final[Mapping[Event, tuple[str, ...]]] = {
    Event.CALIBRATE: (),
    Event.TOOL_CHECK: ("tool", "speed_rpm", *DATA_FIELDS),
    Event.TRACE: ("tool", "speed_rpm", "height", "height_mm", *DATA_FIELDS),
    Event.CHIP_CHECK: ("tool", "limit", "limit_mm", "height", "height_mm", "operation", *DATA_FIELDS),
}
# Tool data is in mm, whatever the program counts in; it lasts for the TRACE straight behind the check.
_FANUC = {
    "calibrate": ("G65 P9810",),
    "trace": ("G65 P9812 T{tool} Z{height}",),
    "chip_check": ("G65 P9813 T{tool} W{limit} Z{height}",),
}
_LINUXCNC = {
    "calibrate": ("o<cb_calibrate> call",),
    "trace": ("o<cb_trace> call [{tool}] [{height}]",),
    "chip_check": ("o<cb_chip_check> call [{tool}] [{limit}] [{height}]",),
}
_FANUC_CHECK = (
    "G65 P9814 T{tool} K{kind} D{diameter_mm} R{tip} H{length_mm} E{holder_mm} Q{teeth} B{helix}",
    "G65 P9811 T{tool} S{speed_rpm}",
)
_LINUXCNC_CHECK = (
    "o<cb_tool> call [{tool}] [{kind}] [{diameter_mm}] [{tip}] [{teeth}] [{helix}]",
    "o<cb_length> call [{tool}] [{length_mm}] [{holder_mm}]",
    "o<cb_tool_check> call [{tool}] [{speed_rpm}]",
)
# A turning tool stands still: no runout, so no speed.  The shop's own macros know what is to be measured.
BUILT_IN: Final[Mapping[str, Mapping[str, Sequence[str]]]] = {
    "fanuc-mill": _FANUC | {"tool_check": _FANUC_CHECK},
    "fanuc-lathe": _FANUC | {"tool_check": ("G65 P9811 T{tool}",)},
    "linuxcnc-mill": _LINUXCNC | {"tool_check": _LINUXCNC_CHECK},
    "linuxcnc-lathe": _LINUXCNC | {"tool_check": ("o<cb_tool_check> call [{tool}]",)},
}


class CallSet(NamedTuple):
    """The blocks of every event that is called."""

    name: str
    blocks: Mapping[Event, tuple[str, ...]]

    def has(self, event: Event) -> bool:
        """True when this set has a call for an event."""
        return event in self.blocks

    def needs(self, event: Event, field: str) -> bool:
        """True when a call uses a field."""
        return any(field in _fields(block) for block in self.blocks.get(event, ()))

    def lacking(self, event: Event, values: CallValues) -> list[str]:
        """The fields about the tool that a call uses and that have no value.

        A TRACE stands straight behind a TOOL CHECK and counts on what that one said about the tool.
        """
        known = values.fields(is_inch=False)
        events = (Event.TOOL_CHECK, event) if event is Event.TRACE else (event,)
        blocks = [block for one in events for block in self.blocks.get(one, ())]
        used = [field for block in blocks for field in _fields(block)]
        return [field for field in dict.fromkeys(used) if field in DATA_FIELDS and field not in known]

    def uses_tool_data(self) -> bool:
        """True when any call says something about the tool but its number."""
        return any(self.needs(event, field) for event in self.blocks for field in DATA_FIELDS)

    def text(self, event: Event, values: CallValues, *, is_inch: bool) -> tuple[str, ...]:
        """The blocks of an event with its values; one that says of the tool what nobody gave is left out."""
        fields = values.fields(is_inch=is_inch)
        unsaid = set(DATA_FIELDS) - fields.keys()
        kept = [block for block in self.blocks[event] if not unsaid.intersection(_fields(block))]
        return tuple(block.format_map(fields) for block in kept)


def calls_of(settings: Settings) -> CallSet:
    """The calls that the profile asks for, all of them checked.

    Raises RefusalError: SET030 unknown set, SET031 unknown event, SET032 unknown field, SET033 a block that
    cannot be read, SET034 a block that may become too long.
    """
    name = settings.checks.calls
    if name == "builtin":
        given = BUILT_IN.get(settings.dialect.name)
        if given is None:
            message = f"there are no built-in calls for the dialect {settings.dialect.name}"
            raise RefusalError(UNKNOWN_SET, message, "describe them in [calls.NAME], and set checks.calls")
    elif name in settings.call_sets:
        given = settings.call_sets[name]
    else:
        message = f'checks.calls: there is no set of calls "{name}"'
        raise RefusalError(UNKNOWN_SET, message, _nearest(name, ["builtin", *settings.call_sets]))
    limit = min(LONGEST_BLOCK, settings.control.max_line_chars)
    blocks = {}
    for key, templates in given.items():
        where = f"calls.{name}.{key}"
        names = [event.value for event in Event]
        if key not in names:
            raise RefusalError(UNKNOWN_EVENT, f"{where}: there is no such event", _nearest(key, names))
        for template in templates:
            _check(where, template, Event(key), limit)
        blocks[Event(key)] = tuple(templates)
    return CallSet(name, blocks)


def _check(where: str, template: str, event: Event, limit: int) -> None:
    """Refuse a template that could write something the control does not read."""
    known = _EVENT_FIELDS[event]
    try:
        fields = _fields(template)
    except ValueError as error:
        message = f'{where}: "{template}" cannot be read: {error}'
        raise RefusalError(UNREADABLE_BLOCK, message, "fields stand in braces, such as {tool}") from None
    for field in fields:
        if field not in known:
            message = f'{where}: "{template}" has a field {{{field}}}, which {event.value} does not have'
            raise RefusalError(UNKNOWN_FIELD, message, _nearest(field, known))
    text = template.format_map(_LONGEST.fields(is_inch=False))
    block = read_block(0, text)
    why = block.opaque or ("it holds no words" if block.is_empty else "")
    if not (text.isascii() and text.isprintable()):
        why = "it holds characters that no control reads"
    if why:
        message = f'{where}: "{template}" is no block: {why}'
        raise RefusalError(UNREADABLE_BLOCK, message, "write one block a line, as it stands in a program")
    if len(text) > limit:
        message = f'{where}: "{template}" can become {len(text)} characters long, the limit is {limit}'
        raise RefusalError(LONG_BLOCK, message, "split it into two blocks")


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
    return f"known: {', '.join(names)}" if names else "this event has no fields"
