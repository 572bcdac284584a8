"""The modal groups of a control: which there are, which values each may have, and what is in force.

A misspelt group or value does not pass mypy where code reads one (``state.modes.feed_mode == "rev"``), and
a misspelt value does not pass ``check_value`` where a dialect's table names one.  A dialect may bring groups
that are not known here: they are kept, compared and given back like the rest, and nothing reads a meaning
into them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args

from chipbreak.text.named_tuple import NamedTuple

Motion = Literal[
    "none",
    "rapid",
    "line",
    "cw",
    "ccw",
    "thread",
    "spline",
    "probe",
    "cycle",
    "turning-cycle",
    "threading-cycle",
    "thread-cycle",
]
Plane = Literal["XY", "ZX", "YZ"]
Distance = Literal["absolute", "incremental"]
FeedMode = Literal["minute", "rev", "inverse"]
Units = Literal["mm", "inch"]
Compensation = Literal["off", "left", "right"]
LengthOffset = Literal["off", "on", "by-axes"]
SpeedMode = Literal["rpm", "surface"]
Switch = Literal["off", "on"]
# "switched": the code switches the group, and the words beside it say which way.
Cylinder = Literal["off", "on", "switched"]
# What a control does at power-on differs here, so a program that has said nothing is not read as if it had.
UNSAID: Literal[""] = ""
Path = Literal["", "exact", "exact-stop", "corner", "tapping", "blend"]
ReturnLevel = Literal["", "initial", "r-plane"]
LookAhead = Literal["", "switched"]
Diameter = Literal["", "diameter", "radius"]

# The groups by name, for tables that go through several of them.
Group = Literal[
    "motion",
    "plane",
    "distance",
    "arc_distance",
    "feed_mode",
    "units",
    "compensation",
    "length_offset",
    "speed_mode",
    "work_offset",
    "path",
    "return_level",
    "diameter",
    "look_ahead",
    "rotation",
    "scaling",
    "mirror",
    "polar",
    "interpolation",
    "cylinder",
    "polygon",
    "modal_macro",
]


class Modes(NamedTuple):
    """The value of each modal group; a group that a control does not have is at rest.

    ``work_offset``  its code with the words that belong to it (``G54.1 P3``)
    ``diameter``     unsaid where X is as the profile says
    ``others``       (group, value) of the groups that only the dialect knows, sorted
    """

    motion: Motion = "none"
    plane: Plane = "XY"
    distance: Distance = "absolute"
    arc_distance: Distance = "incremental"
    feed_mode: FeedMode = "minute"
    units: Units = "mm"
    compensation: Compensation = "off"
    length_offset: LengthOffset = "off"
    speed_mode: SpeedMode = "rpm"
    work_offset: str = "G54"
    path: Path = UNSAID
    return_level: ReturnLevel = UNSAID
    diameter: Diameter = UNSAID
    look_ahead: LookAhead = UNSAID
    rotation: Switch = "off"
    scaling: Switch = "off"
    mirror: Switch = "off"
    polar: Switch = "off"
    interpolation: Switch = "off"
    cylinder: Cylinder = "off"
    polygon: Switch = "off"
    modal_macro: Switch = "off"
    others: tuple[tuple[str, str], ...] = ()

    def value(self, group: str) -> str:
        """The value of a group by its name, ``UNSAID`` for one that nobody has set."""
        if group in VALUES:
            found: str = getattr(self, group)
            return found
        return dict(self.others).get(group, UNSAID)

    def items(self) -> Iterator[tuple[str, str]]:
        """All groups with their values, in a fixed order."""
        yield from zip(VALUES, self[:-1], strict=True)
        yield from self.others

    def changed(self, other: Modes) -> tuple[str, ...]:
        """The groups that have another value in ``other``, in a fixed order."""
        if self is other or self == other:
            return ()
        known = tuple(g for g, one, two in zip(self._fields[:-1], self, other, strict=False) if one != two)
        return (*known, *self._foreign_changed(other)) if self.others != other.others else known

    def _foreign_changed(self, other: Modes) -> list[str]:
        groups = sorted({*dict(self.others), *dict(other.others)})
        return [group for group in groups if self.value(group) != other.value(group)]

    def replace(self, changes: Mapping[str, str]) -> Modes:
        """The same with some groups set, as a dialect's table says; the table's values have been checked."""
        # Most blocks change nothing, and then nothing is made anew.
        new = {g: value for g, value in changes.items() if self.value(g) != value}
        if not new:
            return self
        values: list[Any] = list(self)
        foreign = {}
        for group, value in new.items():
            if group in _PLACES:
                values[_PLACES[group]] = value
            else:
                foreign[group] = value
        if foreign:
            values[-1] = tuple(sorted({**dict(self.others), **foreign}.items()))
        return Modes._make(values)


def _values() -> dict[str, frozenset[str]]:
    """The values that the annotations of ``Modes`` name: each is an alias of this module, or ``str``."""
    kinds = {group: globals().get(kind) for group, kind in Modes.__annotations__.items() if group != "others"}
    return {group: frozenset(get_args(kind)) for group, kind in kinds.items()}


# Group -> the values it may have; a group of none is open (an offset's code with its words).
VALUES: Mapping[str, frozenset[str]] = _values()
_PLACES: Mapping[str, int] = {group: place for place, group in enumerate(VALUES)}


def check_value(group: str, value: str) -> None:
    """Refuse a value that a known group does not have.  Raises ValueError."""
    known = VALUES.get(group)
    if known and value not in known:
        raise ValueError(f"the modal group {group} has no value {value!r}; it has {', '.join(sorted(known))}")
