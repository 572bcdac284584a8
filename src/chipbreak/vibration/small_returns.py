"""Return strokes so small that they would be lost: while the stroke grows or shrinks, and N is near a half.

One that rounds to nothing has no block of its own: its time would go to the stroke before it.  And one that
still goes forward, only slower, is no reversal: a control that learns of a slower feed only in the block
itself has by then run over most of it.  In both a step back, the smallest there is, keeps the vibration.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.block_text import Words

_LEAST_FEED_STEPS = 10.0
_SMALL_SHARE = 0.03
_SAME_S = 1e-9
_SAME_SHARE = 1e-6
_SAME_MM = 1e-9


def with_rests(
    wave: WaveformParameters, time_s: Floats, distance_mm: Floats, rest_s: float
) -> tuple[Floats, Floats]:
    """The knots, (n,) each, with a rest at each crest behind which the tool goes on forward.

    ``rest_s`` is how long, 0 for a control that needs none.  A wave without corners slows down by itself, and
    between a crest and a knot that follows sooner there is no time to rest.
    """
    if rest_s <= 0.0 or wave.shape.is_even or rest_s >= _return_s(wave):
        return time_s, distance_mm
    number = np.arange(wave.vibrations)
    crest = _at((number + wave.alpha_share) * wave.period_s, time_s)
    trough = _at((number + 1.0) * wave.period_s, time_s)
    goes_on = (distance_mm[trough] > distance_mm[crest] + _SAME_MM) & (trough > crest) & (crest > 0)
    has_time = time_s[np.minimum(crest + 1, len(time_s) - 1)] > time_s[crest] + rest_s + _SAME_S
    rests = crest[goes_on & has_time] + 1
    return np.insert(time_s, rests, time_s[rests - 1] + rest_s), np.insert(
        distance_mm, rests, distance_mm[rests - 1]
    )


class Crests(NamedTuple):
    """Crests by their knots, and how far each is raised [mm]; (m,)."""

    knots: NDArray[np.intp]
    raised_mm: Floats


def lost_returns(
    wave: WaveformParameters, time_s: Floats, words: Words, rest_s: float, feed_step_mm_s: float
) -> Crests:
    """The crests that round to one point with the end of their return stroke, or with a rest behind them.

    ``feed_step_mm_s`` is the last digit of F: the step back is so long that its feed can be told.  Where that
    would be no small part of the stroke, a crest stays.
    """
    moved = np.any(np.diff(words.absolute, axis=0) != 0.0, axis=1)
    last = np.append(np.flatnonzero(moved), len(moved))
    first = np.append(0, last[:-1] + 1)
    inner = (last > first) & (first > 0) & (last < len(moved))
    first, last = first[inner], last[inner]
    in_vibration = time_s[first] / wave.period_s % 1.0
    is_crest = np.abs(in_vibration - wave.alpha_share) < _SAME_SHARE
    is_whole = time_s[last] - time_s[first] > _return_s(wave) * (1.0 - _SAME_SHARE)
    rests = (rest_s > 0.0) & (np.abs(time_s[first + 1] - time_s[first] - rest_s) < _SAME_S)
    behind = np.where(rests, first + 1, last)
    raised_mm = _LEAST_FEED_STEPS * feed_step_mm_s * (time_s[behind] - time_s[first])
    lost = is_crest & (is_whole | rests) & (raised_mm <= _SMALL_SHARE * wave.stroke_mm)
    return Crests(first[lost], raised_mm[lost])


def raise_crests(
    words: Words,
    found: Crests,
    steps: Floats,
    axes: NDArray[np.intp],
    *,
    per_mm: Floats,
    tangents: Floats,
) -> Floats:
    """Raise crests along the path, in ``words``; how far that is [mm], (m,).

    ``steps`` (columns,) are those of the axis words, ``axes`` their axes, ``per_mm`` (columns,) words per mm,
    ``tangents`` (m, columns) the directions of the path.  By one step the axis that moves most goes alone.
    """
    per_step = np.abs(per_mm) / steps
    row = np.arange(len(found.knots))
    column = np.abs(tangents * per_step).argmax(axis=1)
    count = np.maximum(np.ceil(found.raised_mm * per_step[column]), 1.0)
    counts = np.rint(count[:, None] * tangents * per_step / np.abs(tangents * per_step).max(axis=1)[:, None])
    counts[count == 1.0] = 0.0
    counts[row, column] = count * np.sign(tangents[row, column])
    moved_mm = counts / per_step
    words.absolute[found.knots] += moved_mm * per_mm
    words.points_mm[np.ix_(found.knots, axes)] += moved_mm
    ahead_mm: Floats = np.einsum("ij,ij->i", moved_mm, tangents)
    return ahead_mm


def _return_s(wave: WaveformParameters) -> float:
    return (1.0 - wave.alpha_share) * wave.period_s


def _at(moments_s: NDArray[np.floating[Any]], time_s: Floats) -> NDArray[np.intp]:
    """The knots at these moments."""
    return np.minimum(np.searchsorted(time_s, moments_s - _SAME_S), len(time_s) - 1)
