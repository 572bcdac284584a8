"""This machine's control along the path of a cut: its law, the limits of its axes, the path mode."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields
from functools import lru_cache
from math import inf
from typing import Any

from chipbreak.dialects.path_mode import tolerances_mm
from chipbreak.kinematics.toolpath import Path
from chipbreak.model.modal import State
from chipbreak.settings.sections import Axis, Planner, Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.filters import NO_FILTER, AxisFilter, axis_filter
from chipbreak.trajectory.law import AxisLimits, ControlLaw
from chipbreak.trajectory.laws import LAWS, law_named
from chipbreak.units import MS_PER_S, S_PER_MIN

_CODE = re.compile(r"G\s*(\d+(?:\.\d)?)", re.IGNORECASE)
_WITHOUT_ACCELERATION = " or ".join(f'"{law.name}"' for law in LAWS if not law.needs_acceleration)


def law_of(settings: Settings) -> type[ControlLaw]:
    """The law of the profile's control."""
    return law_named(settings.planner.model)


def control_along(settings: Settings, path: Path, state: State, feed_mode: str = "") -> ControlLaw:
    """The control and its axes along a path: the limits of the direction that is limited most.

    ``state`` is that before the cut; its path mode counts where the profile switches to none.  ``feed_mode``
    is that of the blocks where it is not the profile's.  Errors: VIB035
    when a law that speeds up and brakes needs an acceleration that the profile does not have.
    """
    law = law_of(settings)
    directions = tuple(directions_of(path))
    if law.needs_acceleration and settings.planner.path_acceleration_mm_s2 is None:
        _require_accelerations(settings, directions)
    if law.needs_filters:
        _require_filters(settings, directions)
    feed_mode = feed_mode or settings.output.feed_mode
    numbers = _Numbers(
        settings.planner,
        feed_mode == "rev",
        _least_feed_mm_min(settings, state, feed_mode) / S_PER_MIN,
        *_path_mode(settings, state),
    )
    return _along(law, numbers, tuple(settings.axes.items()), directions)


class _Numbers(NamedTuple):
    """What the profile and the state before a cut say of its control."""

    planner: Planner
    per_revolution: bool
    least_feed_mm_s: float
    every_block_stops: bool
    merge_mm: float


@lru_cache(maxsize=256)
def _along(
    law: type[ControlLaw],
    numbers: _Numbers,
    axes: tuple[tuple[str, Axis], ...],
    directions: tuple[tuple[float, float, float], ...],
) -> ControlLaw:
    """The law in the direction that is limited most: the same for many cuts, and each asks for it often."""
    control = _with_numbers(law, numbers)
    limits = [_limits(name, axis) for name, axis in axes]
    # An axis that rests has nothing to follow.
    moves = [any(direction[index] for direction in directions) for index in range(len(limits))]
    limits = [a if m else a._replace(filter=NO_FILTER) for a, m in zip(limits, moves, strict=True)]
    laws = [control.along(direction, limits) for direction in directions]
    return min(laws, key=lambda one: (one.acceleration_mm_s2, one.velocity_mm_s))


def axes_follow_exactly(settings: Settings) -> bool:
    """True where the profile says nothing of what the axes make of their command."""
    return all(_filter(axis) == NO_FILTER for axis in settings.axes.values())


def _with_numbers(law: type[ControlLaw], said: _Numbers) -> ControlLaw:
    """The law with what the profile says; what means nothing to it is left out."""
    planner = said.planner
    numbers: dict[str, Any] = {
        "servo_period_s": planner.servo_period_ms / MS_PER_S,
        "blocks_per_s": planner.max_blocks_per_s,
        "per_revolution": said.per_revolution,
        "max_feed_override": planner.max_feed_override,
        "reversal_stop_s": planner.reversal_stop_ms / MS_PER_S,
        "joint_speed_mm_s": (planner.joint_speed_mm_min or 0.0) / S_PER_MIN,
        "junction_deviation_mm": planner.junction_deviation_mm,
        "corner_velocity_mm_s": planner.corner_velocity_mm_s,
        "min_cruise_ratio": planner.min_cruise_ratio,
        "path_velocity_mm_s": _limit(planner.path_velocity_mm_min) / S_PER_MIN,
        "path_acceleration_mm_s2": _limit(planner.path_acceleration_mm_s2),
        "look_ahead_blocks": planner.look_ahead_blocks,
        "least_steps_per_s": planner.least_steps_per_s,
        "segment_s": (planner.segment_ms or 0.0) / MS_PER_S,
        "least_feed_mm_s": said.least_feed_mm_s,
        "dwell_step_s": None if planner.dwell_step_ms is None else planner.dwell_step_ms / MS_PER_S,
    }
    own = {field.name for field in fields(law)}
    known = {name: number for name, number in numbers.items() if name in own and number is not None}
    return law(**known, every_block_stops=said.every_block_stops, merge_mm=said.merge_mm)


def _least_feed_mm_min(settings: Settings, state: State, feed_mode: str) -> float:
    own = settings.planner.least_feed_mm_min or 0.0
    if feed_mode != "inverse":
        return own
    return max(own, settings.dialect.least_inverse_feed * state.mm_per_unit)


def numbers_at(settings: Settings) -> str:
    """Where the numbers of the machine are kept on its control, to be put behind a help; or nothing."""
    return f" ({settings.planner.numbers_at})" if settings.planner.numbers_at else ""


def _require_accelerations(settings: Settings, directions: Sequence[tuple[float, float, float]]) -> None:
    """Errors: VIB035 where the profile does not say how fast an axis that moves can speed up."""
    for index, (name, axis) in enumerate(settings.axes.items()):
        is_unknown = _limit(axis.max_acceleration_mm_s2) == inf
        if is_unknown and any(direction[index] for direction in directions):
            key = f"axes.{name}.max_acceleration_mm_s2"
            message = f"{name} moves, and the profile does not say how fast it can speed up ({key})"
            help_text = f"give {key}, or planner.model = {_WITHOUT_ACCELERATION}{numbers_at(settings)}"
            raise RefusalError("VIB035", message, help_text)


def _require_filters(settings: Settings, directions: Sequence[tuple[float, float, float]]) -> None:
    """Errors: VIB035 where the profile does not say how an axis that moves follows its command."""
    for index, (name, axis) in enumerate(settings.axes.items()):
        if not any(direction[index] for direction in directions):
            continue
        missing = [
            f"axes.{name}.{key}" for key in ("acc_dec_ms", "position_gain_1_s") if getattr(axis, key) is None
        ]
        if missing:
            message = (
                f"{name} moves, and the profile does not say what the control leaves of its strokes"
                f" ({' and '.join(missing)})"
            )
            help_text = f"give {' and '.join(missing)}{numbers_at(settings)}; see docs/control-laws.md"
            raise RefusalError("VIB035", message, help_text)


def _path_mode(settings: Settings, state: State) -> tuple[bool, float]:
    """Exact stop, and how far from a line points may lie that are joined: Q, or P where there is no Q."""
    planner = settings.planner
    is_own = state.path_words and not planner.path_mode
    words = state.path_words if is_own else planner.path_mode or planner.usual_path_mode
    code = _CODE.match(words)
    group = settings.dialect.g_codes.get(round(float(code[1]) * 10)) if code else None
    if group is None:
        return False, 0.0
    given = tolerances_mm(words, state.path_units if is_own else "mm")
    merge_mm = given.get("Q", given.get("P", 0.0))
    return group.value == "exact-stop", merge_mm if group.value == "blend" else 0.0


def _limits(name: str, axis: Axis) -> AxisLimits:
    velocity = _limit(axis.max_velocity_mm_min) / S_PER_MIN
    return AxisLimits(name, velocity, _limit(axis.max_acceleration_mm_s2), _filter(axis), axis.step_mm)


def _filter(axis: Axis) -> AxisFilter:
    return axis_filter(
        axis.acc_dec,
        None if axis.acc_dec_ms is None else axis.acc_dec_ms / MS_PER_S,
        None if axis.bell_ms is None else axis.bell_ms / MS_PER_S,
        axis.position_gain_1_s,
        axis.feed_forward,
    )


def _limit(number: float | None) -> float:
    return inf if number is None else number


def directions_of(path: Path) -> list[tuple[float, float, float]]:
    """The directions of the lines; an arc takes every direction of its plane, its axes limit most."""
    directions = []
    for leg, arc in zip(path.legs, path.arcs, strict=True):
        if arc is None:
            x, y, z = (e - s for s, e in zip(leg.start, leg.end, strict=True))
            directions.append((x, y, z))
            continue
        for axis in arc.axes:
            directions.append((float(axis == 0), float(axis == 1), float(axis == 2)))
    return directions
