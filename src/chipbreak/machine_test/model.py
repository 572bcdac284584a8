"""What a control with given numbers makes of the groups: how long they take, and where an axis then is.

A :class:`Kind` is a way in which controls run strokes, with the names of its numbers.  Numbers are lengths in
mm and times in s: acceleration in mm/s², speeds in mm/s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.machine_test.groups import Group
from chipbreak.settings.axis_words import AXES
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.after_interpolation import AfterInterpolation
from chipbreak.trajectory.filters import NO_FILTER, AxisFilter, filtered, times_to_look_at
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.law import AxisLimits, ControlLaw
from chipbreak.trajectory.linuxcnc import LinuxCnc
from chipbreak.trajectory.look_ahead import LookAhead
from chipbreak.trajectory.motion import Motion

Numbers = Mapping[str, float]
# An axis that nobody limits: more than any has, and little enough for plain arithmetic.
_FAST_MM_S = 1e5
_HARD_MM_S2 = 1e9
_NO_JOINT_MM_S = 1e-7
_STEP_S = 0.0005


class Number(NamedTuple):
    """A number of a kind: its name, and from where it is searched for."""

    name: str
    starts: tuple[float, ...]


class Limits(NamedTuple):
    """What is known before: the highest speed of each axis, the servo period, the highest feed override."""

    velocity_mm_s: Mapping[str, float]
    servo_period_s: float = 0.001
    max_feed_override: float = 1.0


@dataclass(frozen=True)
class Kind:
    """A way to run strokes.  ``law`` makes the law from its numbers, with those of every axis.

    ``models`` are the values of ``planner.model`` that say it.  ``stops``: it rests for ``stop_s`` where it
    turns back.  ``steps``: its times are whole servo periods, so that they jump when a number changes.
    """

    name: str
    models: tuple[str, ...]
    numbers: tuple[Number, ...]
    law: Callable[[Numbers, tuple[AxisLimits, ...], Limits], ControlLaw]
    stops: bool = False
    steps: bool = False


_ACCELERATION = Number("acceleration", (500.0, 3000.0, 20000.0))

EXACT = Kind("exact", ("after-interpolation",), (), lambda has, axes, known: AfterInterpolation(axes=axes))
RESTS = Kind(
    "rests",
    ("trapezoid", "junction", "look-ahead"),
    (_ACCELERATION,),
    lambda has, axes, known: LookAhead(axes=axes, joint_speed_mm_s=_NO_JOINT_MM_S),
)
STOPS = Kind(
    "stops",
    ("trapezoid",),
    (_ACCELERATION, Number("stop", (0.005,))),
    lambda has, axes, known: LookAhead(axes=axes, joint_speed_mm_s=_NO_JOINT_MM_S),
    stops=True,
)
RAMPS = Kind(
    "ramps",
    ("look-ahead",),
    (_ACCELERATION, Number("joint_speed", (3.0, 20.0))),
    lambda has, axes, known: LookAhead(axes=axes, joint_speed_mm_s=has["joint_speed"]),
)
CRUISES = Kind(
    "cruises",
    ("junction",),
    (_ACCELERATION, Number("smooth_share", (0.3, 0.7))),
    lambda has, axes, known: Junction(
        axes=axes,
        junction_deviation_mm=0.0,
        min_cruise_ratio=min(max(1.0 - has["smooth_share"], 1e-6), 0.999),
        path_acceleration_mm_s2=has["acceleration"],
    ),
)
PERIODS = Kind(
    "periods",
    ("linuxcnc",),
    (_ACCELERATION,),
    lambda has, axes, known: LinuxCnc(
        axes=axes,
        acceleration_mm_s2=has["acceleration"],
        velocity_mm_s=_FAST_MM_S,
        servo_period_s=known.servo_period_s,
        max_feed_override=known.max_feed_override,
    ),
    steps=True,
)
KINDS = (EXACT, RESTS, RAMPS, CRUISES, STOPS, PERIODS)


class FilterKind(NamedTuple):
    """What may stand behind the command of an axis: how many averages and lags."""

    name: str
    averages: int
    lags: int

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its numbers, times in s."""
        averages = ("average_s", "bell_s")[: self.averages]
        return averages + ("lag_s", "second_lag_s")[: self.lags]

    def filter(self, has: Numbers) -> AxisFilter:
        """The filter with these numbers."""
        times = [has[name] for name in self.names]
        return AxisFilter(tuple(times[: self.averages]), tuple(times[self.averages :]))


NOTHING_BEHIND = FilterKind("none", 0, 0)
FILTER_KINDS = (
    NOTHING_BEHIND,
    FilterKind("lag", 0, 1),
    FilterKind("linear", 1, 0),
    FilterKind("linear, lag", 1, 1),
    FilterKind("two lags", 0, 2),
    FilterKind("bell, lag", 2, 1),
)


def law_of(kind: Kind, has: Numbers, axis: str, known: Limits) -> ControlLaw:
    """The law of a kind with the numbers of one axis; the other axes have no limits."""
    most = has.get("acceleration", _HARD_MM_S2)
    axes = tuple(
        AxisLimits(
            one, known.velocity_mm_s.get(one, _FAST_MM_S), most if one in axis else _HARD_MM_S2, NO_FILTER
        )
        for one in AXES
    )
    return kind.law(has, axes, known)


def blocks_of_group(law: ControlLaw, group: Group) -> tuple[Floats, Blocks, Floats]:
    """The places along the path, (n + 1,), the blocks, and their feeds [mm/s], (n,)."""
    along_mm = group.along_mm
    blocks = law.blocks(group.moves_mm, along_mm)
    return np.append(0.0, np.cumsum(along_mm)), blocks, np.full(len(along_mm), group.feed_mm_s)


def commanded(kind: Kind, law: ControlLaw, has: Numbers, group: Group) -> Motion:
    """The commanded motion of a group."""
    places_mm, blocks, feeds_mm_s = blocks_of_group(law, group)
    dwell_s = None
    if kind.stops:
        dwell_s = np.full(len(feeds_mm_s), has["stop"])
        dwell_s[-1] = 0.0
    return law.commanded_motion(places_mm, blocks, feeds_mm_s, dwell_s)


def time_s(kind: Kind, law: ControlLaw, has: Numbers, group: Group) -> float:
    """How long a group takes."""
    return float(commanded(kind, law, has, group).time_s[-1])


def places_of(motion: Motion, behind: AxisFilter) -> tuple[Floats, Floats]:
    """Times [s] and places [mm] of an axis between which it moves nearly evenly, (m,) each."""
    place_mm = motion.distance_mm
    if behind == NO_FILTER:
        return motion.time_s, place_mm
    at_s = times_to_look_at(motion.time_s, place_mm, [behind], _STEP_S)
    return at_s, filtered(motion.time_s, place_mm, behind, at_s)
