"""Commanded strokes that are larger than the real ones, so that these break the chips.

Behind the filters of the axes a stroke is smaller than its command, and other waves lose other shares of it.
So some vibrations of the cut are run, on this control and in every direction that the path has, until their
weakest one has the margin that is asked for.  The command stays between start and end of the path; what an
axis makes of it, which is a mean of what was commanded before, does too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from chipbreak.kinematics.chip_model import weakest_margin
from chipbreak.kinematics.waveform import WaveformParameters, sample
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.filters import NO_FILTER
from chipbreak.trajectory.law import ControlLaw

_ROUNDS = 8
_SAME_SHARE = 0.002  # of the margin asked for
_MOST_TIMES = 25.0  # what is left of less of a stroke depends on every digit of the machine's numbers
_HALVINGS = 7
_MOST_PERIODS = 150.0  # a filter that settles over more leaves far less than a part in _MOST_TIMES
_NO_MOVE_MM = 1e-9
_MORE = 3  # vibrations, and revolutions, that are looked at once all has settled

Direction = tuple[float, float, float]


@dataclass(frozen=True)
class Asked:
    """What the weakest vibration of a cut should have: its margin, at so many edges."""

    margin: float
    edges: int


def compensated(
    wave: WaveformParameters, asked: Asked, law: ControlLaw, directions: Sequence[Direction]
) -> WaveformParameters:
    """The wave with the stroke, at least its own, that has the margin on this control.

    Where speed or acceleration do not allow it, it is the largest that they allow; where next to nothing is
    left of a stroke, it is its own one.  The verdict tells.
    """
    if all(axis.filter == NO_FILTER for axis in law.axes):
        return wave
    strokes = [_stroke_mm(_probe_of(wave), asked, law.along(way, law.axes), way) for way in set(directions)]
    stroke_mm = max(strokes)
    if stroke_mm <= wave.stroke_mm * (1.0 + _SAME_SHARE):
        return wave
    # The tool goes ahead by half the stroke while this grows; no faster than it feeds besides.
    ramp_s = stroke_mm / (2.0 * wave.speed_mm_s) if wave.ramp_in_s > 0.0 else 0.0
    return replace(wave, stroke_mm=stroke_mm, ramp_in_s=max(wave.ramp_in_s, ramp_s))


def _probe_of(wave: WaveformParameters) -> WaveformParameters:
    """The wave without what tells cuts of one kind apart: length, ramps and ends."""
    return replace(wave, length_mm=1.0, ramp_in_s=0.0, ramp_exponent=1.0, end_revolutions=0.0)


@lru_cache(maxsize=1024)
def _stroke_mm(wave: WaveformParameters, asked: Asked, law: ControlLaw, way: Direction) -> float:
    """The stroke that has the margin in this direction, as far as the control can make it."""
    own_mm = wave.stroke_mm
    if _settling_s(law, way) > _MOST_PERIODS * wave.period_s:
        return own_mm
    reached_mm = own_mm
    stroke_mm = own_mm
    for _ in range(_ROUNDS):
        margin = _margin(replace(wave, stroke_mm=stroke_mm), asked, law, way)
        if margin is None:
            return _largest_mm(wave, asked, law, way, (reached_mm, stroke_mm))
        reached_mm = stroke_mm
        if abs(margin - asked.margin) <= _SAME_SHARE * asked.margin:
            break
        stroke_mm *= asked.margin / max(margin, asked.margin / _MOST_TIMES**2)
        if stroke_mm > _MOST_TIMES * own_mm:
            return own_mm
    return max(own_mm, stroke_mm)


def _largest_mm(
    wave: WaveformParameters, asked: Asked, law: ControlLaw, way: Direction, between_mm: tuple[float, float]
) -> float:
    """The largest stroke that the control can make: the first one can be made, the second one not."""
    low_mm, high_mm = between_mm
    for _ in range(_HALVINGS):
        middle_mm = math.sqrt(low_mm * high_mm)
        if _margin(replace(wave, stroke_mm=middle_mm), asked, law, way) is None:
            high_mm = middle_mm
        else:
            low_mm = middle_mm
    return low_mm


def _margin(wave: WaveformParameters, asked: Asked, law: ControlLaw, way: Direction) -> float | None:
    """The margin of the weakest vibration once all has settled; None where the control cannot make it."""
    settling_s = _settling_s(law, way)
    shown_s = settling_s + _MORE * (wave.period_s + 60.0 / wave.speed_rpm)
    count = math.ceil(shown_s / wave.period_s) + 1
    whole_mm = count * wave.period_s * wave.speed_mm_s
    time_s, distance_mm = sample(replace(wave, length_mm=whole_mm + 2.0 * wave.stroke_mm))
    moves = np.append(True, np.abs(np.diff(distance_mm)) > _NO_MOVE_MM)  # clipped at the end, some may not
    time_s = time_s[moves]
    distance_mm = distance_mm[moves]
    way_mm = np.array(way) / math.sqrt(sum(part * part for part in way))
    ahead_mm = np.diff(distance_mm)
    blocks = law.blocks(np.outer(ahead_mm, way_mm), ahead_mm)
    try:
        feeds = law.feeds_for_spans(blocks, np.diff(time_s), len(ahead_mm))
    except RefusalError:
        return None
    motion = law.motion(distance_mm, blocks, feeds)
    if motion.peak_acceleration_mm_s2 > law.acceleration_mm_s2:
        return None
    return weakest_margin(
        motion.time_s,
        motion.distance_mm,
        speed_rpm=wave.speed_rpm,
        feed_mm_rev=wave.feed_mm_rev,
        edges=asked.edges,
        steady_s=(settling_s, count * wave.period_s),
        waveform=wave.waveform,
        vibration_s=wave.period_s,
    )


def _settling_s(law: ControlLaw, way: Direction) -> float:
    """How long the axes that move in a direction still see a change of the command."""
    return max(axis.filter.settling_s for axis, part in zip(law.axes, way, strict=True) if part)
