"""This machine's control along one path: its law, the limits of its axes, and the path mode of the cut."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Literal, cast

from chipbreak.kinematics.toolpath import Path
from chipbreak.model.modal import State
from chipbreak.settings.sections import Axis, Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.units import MM_PER_INCH, MS_PER_S, S_PER_MIN

Law = Literal["ideal", "trapezoid", "linuxcnc"]
_CODE = re.compile(r"G\s*(\d+(?:\.\d)?)", re.IGNORECASE)
_TOLERANCE = re.compile(r"([PQ])\s*(\d*\.?\d+)", re.IGNORECASE)


@dataclass(frozen=True)
class AxisLimits:
    """What one axis can do: speed [mm/s] and acceleration [mm/s²]."""

    axis: str
    velocity_mm_s: float
    acceleration_mm_s2: float


@dataclass(frozen=True)
class ControlModel:
    """A control's law and limits along one path; the numbers are declared in the machine profile.

    ``every_block_stops``: exact stop (G61.1, G9).  ``merge_mm``: the control joins blocks of one feed whose
    points lie within this distance of one line (LinuxCNC G64 with Q, or with P alone).  ``blocks_per_s``:
    the most the control reads, None for no limit.  ``ramp_s``: LinuxCNC's 1/ARC_BLEND_RAMP_FREQ.
    ``reversal_stop_s``: how long a ``trapezoid`` control stands at each rest.
    """

    law: Law
    velocity_mm_s: float = inf
    acceleration_mm_s2: float = inf
    every_block_stops: bool = False
    merge_mm: float = 0.0
    servo_period_s: float = 0.001
    blocks_per_s: float | None = None
    ramp_s: float = 0.01
    axis: str = ""
    per_revolution: bool = False
    reversal_stop_s: float = 0.0

    def __post_init__(self) -> None:
        if not all(n > 0 for n in (self.velocity_mm_s, self.acceleration_mm_s2, self.servo_period_s)):
            raise ValueError(f"a control needs limits and a period above zero: {self}")

    def along(self, direction: Sequence[float], axes: Sequence[AxisLimits]) -> ControlModel:
        """The same control with the limits of ``axes`` on a path of this direction (any length).

        The axis that reaches its limit first sets the limit; ``axis`` names it for the messages.
        """
        size = sqrt(sum(part * part for part in direction))
        shares = [(abs(part) / size, axis) for part, axis in zip(direction, axes, strict=True) if part]
        velocity = min(axis.velocity_mm_s / share for share, axis in shares)
        acceleration, name = min((one.acceleration_mm_s2 / share, one.axis) for share, one in shares)
        return replace(self, velocity_mm_s=velocity, acceleration_mm_s2=acceleration, axis=name)


def control_model(settings: Settings, path: Path, state: State) -> ControlModel:
    """The control and its axes along a path: the limits of the direction that is limited most.

    ``state`` is that before the cut; its path mode counts where the profile switches to none.  Errors: VIB035
    when a law that speeds up and brakes needs an acceleration that the profile does not have.
    """
    planner = settings.planner
    model = ControlModel(
        law=cast(Law, planner.model),
        servo_period_s=planner.servo_period_ms / MS_PER_S,
        blocks_per_s=planner.max_blocks_per_s,
        per_revolution=settings.output.feed_mode == "rev",
        reversal_stop_s=planner.reversal_stop_ms / MS_PER_S,
    )
    model = _in_path_mode(model, settings, state)
    axes = [_limits(name, axis) for name, axis in settings.axes.items()]
    directions = _directions(path)
    if model.law != "ideal":
        _require_accelerations(axes, directions)
    models = [model.along(direction, axes) for direction in directions]
    return min(models, key=lambda m: (m.acceleration_mm_s2, m.velocity_mm_s))


def _require_accelerations(
    axes: Sequence[AxisLimits], directions: Sequence[tuple[float, float, float]]
) -> None:
    for index, axis in enumerate(axes):
        if axis.acceleration_mm_s2 == inf and any(direction[index] for direction in directions):
            key = f"axes.{axis.axis}.max_acceleration_mm_s2"
            message = f"{axis.axis} moves, and the profile does not say how fast it can speed up ({key})"
            raise RefusalError("VIB035", message, f'give {key}, or planner.model = "ideal"')


def _in_path_mode(model: ControlModel, settings: Settings, state: State) -> ControlModel:
    """Exact stop, and how far from a line points may lie that are joined: Q, or P where there is no Q."""
    words = settings.planner.path_mode or state.path_words or settings.planner.usual_path_mode
    code = _CODE.match(words)
    group = settings.dialect.g_codes.get(round(float(code[1]) * 10)) if code else None
    given = {letter.upper(): float(number) for letter, number in _TOLERANCE.findall(words)}
    merge_mm = given.get("Q", given.get("P", 0.0)) * (MM_PER_INCH if state.is_inch else 1.0)
    return replace(
        model,
        every_block_stops=group is not None and group.value == "exact-stop",
        merge_mm=merge_mm if group is not None and group.value == "blend" else 0.0,
    )


def _limits(name: str, axis: Axis) -> AxisLimits:
    velocity = inf if axis.max_velocity_mm_min is None else axis.max_velocity_mm_min / S_PER_MIN
    acceleration = inf if axis.max_acceleration_mm_s2 is None else axis.max_acceleration_mm_s2
    return AxisLimits(name, velocity, acceleration)


def _directions(path: Path) -> list[tuple[float, float, float]]:
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
