"""A cut under constant surface speed in steps, each at a spindle speed that suits its diameters.

A vibrated cut has one spindle speed.  Where its diameters ask for more than one, as in facing and on a long
taper, it is cut at diameters between which one speed stays within the tolerance of the profile.  There the
chip ends anyway: each step vibrates on its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from chipbreak.model.block_effect import Move
from chipbreak.settings.sections import Settings
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.request import Request
from chipbreak.vibration.surface_speed import SurfaceSpeed, bounds_rpm, surface_speed_of

_LEAST_SHARE = 1e-3  # of a move: what is shorter goes with its neighbour
_SPARE = 0.98
_FUZZ = 1e-9


def diameter_steps(chain: Chain, settings: Settings, *, is_open: bool, widening: float = 1.0) -> list[Chain]:
    """The chain, or the steps in which it vibrates.

    ``is_open``: the machine chooses, and can take the very speed that suits; elsewhere a step is shorter,
    because the frequencies of the control move its speed.  ``widening`` makes the steps longer.
    """
    asked = surface_speed_of(chain, settings)
    fixes_speed = "S" in chain.requests[0].values or {"N", "F"} <= chain.requests[0].values.keys()
    if asked is None or fixes_speed:
        return [chain]
    tolerance = settings.spindle.surface_tolerance
    most = (1.0 + tolerance) / (1.0 - tolerance) * _SPARE if is_open else 1.0 + tolerance
    low, high = bounds_rpm(chain, asked)
    if high / low <= 1.0 + tolerance:
        return [chain]
    most = most**widening
    steps = math.ceil(math.log(high / low) / math.log(most) - _FUZZ)
    if steps <= 1:
        return [chain]
    splitter = _Splitter(asked, (high / low) ** (1.0 / steps) * (1.0 + _FUZZ), settings)
    return [replace(step, whole=chain) for step in splitter.steps(chain)]


class _Splitter:
    """Cuts a chain where its speed has changed by ``most``."""

    def __init__(self, asked: SurfaceSpeed, most: float, settings: Settings) -> None:
        self.asked = asked
        self.most = most
        self.splits_blocks = settings.output.form == "expanded"
        self.settings = settings
        self.low = math.inf
        self.high = 0.0

    def steps(self, chain: Chain) -> Iterator[Chain]:
        """The steps, in order."""
        step: list[Request] = []
        waiting = list(reversed(chain.requests))
        while waiting:
            request = waiting.pop()
            move = request.effect.move
            assert move is not None
            if not step:
                self.low = self.high = self.asked.rpm(move.start.x)
            rest = self._over(request, move)
            if rest is None:
                self._take(move.end.x)
                step.append(request)
                continue
            part, behind = rest
            if part is not None:
                step.append(part)
            elif not step:  # an arc, or what cannot be cut: a step of its own
                step.append(behind)
                yield Chain(tuple(step))
                step = []
                continue
            yield Chain(tuple(step))
            step = []
            waiting.append(behind)
        if step:
            yield Chain(tuple(step))

    def _take(self, radius_mm: float) -> None:
        speed = self.asked.rpm(radius_mm)
        self.low = min(self.low, speed)
        self.high = max(self.high, speed)

    def _over(self, request: Request, move: Move) -> tuple[Request | None, Request] | None:
        """None where the whole move fits the step; else the part that does, if any, and the rest."""
        end_rpm = self.asked.rpm(move.end.x)
        if move.kind == "line" and move.end.x == move.start.x:
            return None
        if max(self.high, end_rpm) / min(self.low, end_rpm) <= self.most * (1.0 + _FUZZ):
            return None
        if move.kind != "line" or not self.splits_blocks:
            return None, request
        bound_rpm = self.low * self.most if end_rpm > self.high else self.high / self.most
        radius_mm = math.copysign(self.asked.radius_mm(bound_rpm), move.start.x or move.end.x)
        share = (radius_mm - move.start.x) / (move.end.x - move.start.x)
        if not _LEAST_SHARE < share < 1.0 - _LEAST_SHARE:
            return (None, request) if share <= _LEAST_SHARE else None
        return self._cut(request, move, share)

    def _cut(self, request: Request, move: Move, share: float) -> tuple[Request, Request]:
        """The request in two, at a point that the output can print."""
        step_mm = self.settings.output.step_mm(is_inch=request.effect.after.is_inch)
        ways = [end - start for start, end in zip(move.start, move.end, strict=True)]
        rounded = [0.0 if math.isnan(way) else round(way * share / step_mm) * step_mm for way in ways]
        place = type(move.start)(*(start + way for start, way in zip(move.start, rounded, strict=True)))
        effect = request.effect
        first = effect._replace(move=move._replace(end=place), after=effect.after._replace(position=place))
        second = effect._replace(
            move=move._replace(start=place), before=effect.before._replace(position=place)
        )
        return request._replace(effect=first), request._replace(effect=second)
