"""What a program makes LinuxCNC do, with all that is in force at each step: for programs of mills.

Two habits of ``rs274`` are hidden here.  It counts places from the work offset, the G92 offset (G52 sets it
as well) and the tool in force; here they are places of the machine.  And after a tool change or a probe it
takes its last place in the numbers of the old tool for the new one: an axis whose number does not change
there has not moved.  Its last numbers do follow the work offset and the G92 offset.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import dist
from typing import NamedTuple

from . import rs274

Place = tuple[float, float, float]
_PLANES = {"CANON_PLANE_XY": (0, 1, 2), "CANON_PLANE_XZ": (2, 0, 1), "CANON_PLANE_YZ": (1, 2, 0)}
_MOVES = ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE", "STRAIGHT_PROBE", "RIGID_TAP")
_OTHERS = ("DWELL", "CHANGE_TOOL", "PROGRAM_STOP", "OPTIONAL_PROGRAM_STOP", "PROGRAM_END", "PALLET_SHUTTLE")
_OFFSETS = ("SET_G5X_OFFSET", "SET_G92_OFFSET", "USE_TOOL_LENGTH_OFFSET")
_FOLLOWED = ("SET_G5X_OFFSET", "SET_G92_OFFSET")
_LENGTHS = ("SET_FEED_RATE", "SET_MOTION_CONTROL_MODE", "SET_NAIVECAM_TOLERANCE")
_NEED_NO_SPINDLE = ("STRAIGHT_TRAVERSE", "DWELL", "CHANGE_TOOL", "PROGRAM_END")  # M6 stops it
_SAME_MM = 1.01e-4 * rs274.MM_PER_INCH  # in inches the interpreter says four decimals, here too


class Action(NamedTuple):
    """A move from ``start`` to ``end`` [mm], or a dwell, a stop, a tool change."""

    name: str
    start: Place
    end: Place
    arguments: tuple[str, ...]
    in_force: Mapping[str, tuple[str, ...]]
    inserted: bool


class _Machine:
    def __init__(self) -> None:
        self.in_force: dict[str, tuple[str, ...]] = {
            "SET_SPINDLE_SPEED": ("0.000", "0.000"),
            "SET_MOTION_CONTROL_MODE": ("CANON_CONTINUOUS", "0.000"),
            "SET_NAIVECAM_TOLERANCE": ("0.000",),
            "SET_FEED_RATE": ("0.000",),
            "SPINDLE": ("STOP_SPINDLE_TURNING",),
            "MIST": ("MIST_OFF",),
            "FLOOD": ("FLOOD_OFF",),
        }
        self.scale, self.is_adrift = 1.0, False
        self.at: Place = (0.0, 0.0, 0.0)
        self.numbers: Place = self.at
        self.offsets: dict[str, Sequence[float]] = {}

    def set(self, name: str, arguments: Sequence[str]) -> None:
        if name.startswith(("START_SPINDLE", "STOP_SPINDLE")):
            self.in_force["SPINDLE"] = (name,)
        elif name.startswith(("MIST", "FLOOD")):
            self.in_force[name.partition("_")[0]] = (name,)
        elif name in _OFFSETS:
            self._offset(name, arguments)
        else:
            if name == "USE_LENGTH_UNITS":
                self.scale = rs274.MM_PER_INCH if arguments[0] == "CANON_UNITS_INCHES" else 1.0
            scale = self.scale if name in _LENGTHS else 1.0
            self.in_force[name] = tuple(_text(argument, scale) for argument in arguments)

    def _offset(self, name: str, arguments: Sequence[str]) -> None:
        numbers = arguments[1:4] if name == "SET_G5X_OFFSET" else arguments[:3]
        old = self.offsets.get(name, (0.0, 0.0, 0.0))
        new = [float(number) * self.scale for number in numbers]
        self.offsets[name] = new
        if name in _FOLLOWED:
            x, y, z = (self.numbers[axis] + old[axis] - new[axis] for axis in range(3))
            self.numbers = x, y, z
        self.in_force[name] = (arguments[0], *(_text(mm) for mm in new))

    def move(self, name: str, arguments: Sequence[str]) -> None:
        numbers = [float(argument) * self.scale for argument in arguments[:3]]
        if name == "ARC_FEED":
            first, second, across = _PLANES[self.in_force["SELECT_PLANE"][0]]
            ends = {first: 0, second: 1, across: 5}
            numbers = [float(arguments[ends[axis]]) * self.scale for axis in range(3)]
        moved = [
            self.at[axis]
            if self.is_adrift and abs(number - self.numbers[axis]) < _SAME_MM
            else number + sum(offset[axis] for offset in self.offsets.values())
            for axis, number in enumerate(numbers)
        ]
        self.at, self.numbers = (moved[0], moved[1], moved[2]), (numbers[0], numbers[1], numbers[2])
        self.is_adrift = name == "STRAIGHT_PROBE"


def _text(value: object, scale: float = 1.0) -> str:
    try:
        return f"{float(str(value)) * scale:.3f}".replace("-0.000", "0.000")
    except ValueError:
        return str(value)


def actions(canon: Iterable[str]) -> Iterator[Action]:
    """All that moves, waits or stops."""
    machine, inserted = _Machine(), False
    for name, arguments in rs274.calls(canon):
        start = machine.at
        if name == "COMMENT":
            inserted = (inserted or "CHIPBREAK BEGIN" in arguments[0]) and "CHIPBREAK END" not in arguments[0]
            continue
        if name in _MOVES or name == "ARC_FEED":
            machine.move(name, arguments)
        elif name not in _OTHERS:
            machine.set(name, arguments)
            continue
        machine.is_adrift |= name == "CHANGE_TOOL"
        yield Action(name, start, machine.at, arguments, dict(machine.in_force), inserted)


def difference(before: Iterable[str], after: Iterable[str], free: frozenset[str] = frozenset()) -> str:
    """What two programs do otherwise outside their brackets, "" where nothing.

    An insertion may leave the tool elsewhere; then X and Y come back in rapid, and Z behind them.  What is
    ``free`` counts for cuts and stops only; where something is, a feed may be given back in other units.
    """
    old = [action for action in actions(before) if not action.inserted]
    new = [action for action in actions(after) if not action.inserted]
    if [action.name for action in old] != [action.name for action in new]:
        return f"{[action.name for action in old]} became {[action.name for action in new]}"
    for was, now in zip(old, new, strict=True):
        changed = _changed(was, now) - (free if _needs_no_spindle(was) else frozenset())
        if "SET_FEED_RATE" in changed and free and _is_same_feed(was, now):
            changed -= {"SET_FEED_RATE"}
        if changed:
            return f"at {was.name}{was.arguments}: {sorted(changed)} of {was.in_force} became {now.in_force}"
        why = _moves_otherwise(was, now)
        if why:
            return f"{was.name} from {was.start} to {was.end} goes from {now.start} to {now.end}: {why}"
    return ""


def _changed(was: Action, now: Action) -> frozenset[str]:
    return frozenset(name for name, value in was.in_force.items() if now.in_force.get(name) != value)


def _is_same_feed(was: Action, now: Action) -> bool:
    """The interpreter says four decimals of a feed, in the units in which it was set."""
    one, other = (float(action.in_force["SET_FEED_RATE"][0]) for action in (was, now))
    return abs(one - other) <= _SAME_MM


def _needs_no_spindle(action: Action) -> bool:
    stays = action.name == "STRAIGHT_FEED" and dist(action.start, action.end) < _SAME_MM
    return stays or action.name in _NEED_NO_SPINDLE


def _rapid_otherwise(was: Action, now: Action) -> str:
    moved = [axis for axis in range(3) if abs(now.end[axis] - now.start[axis]) > _SAME_MM]
    off = [axis for axis in range(2) if abs(was.start[axis] - now.start[axis]) > _SAME_MM]
    if any(abs(was.end[axis] - now.end[axis]) > _SAME_MM for axis in moved):
        return "a rapid to elsewhere"
    return "down or up at another place" if 2 in moved and off and abs(now.end[2]) > _SAME_MM else ""


def _moves_otherwise(was: Action, now: Action) -> str:
    if was.name in _OTHERS:
        is_same = was.name != "DWELL" or was.arguments == now.arguments
        return "" if is_same else "another dwell"
    if was.name == "STRAIGHT_TRAVERSE":
        return _rapid_otherwise(was, now)
    if dist(was.start, was.end) < _SAME_MM and dist(now.start, now.end) < _SAME_MM:
        return ""  # a bare G1
    is_same = dist(was.start, now.start) < _SAME_MM and dist(was.end, now.end) < _SAME_MM
    return "" if is_same else "a cut elsewhere"
