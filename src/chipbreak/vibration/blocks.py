"""A vibrated cut as blocks: rounded positions, and the feed that carries the time.

Positions are rounded as absolutes, so no error adds up; incremental words are differences of the rounded
positions.  The feed of each block follows from the rounded points and the time between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.diagnostics import RefusalError
from chipbreak.edits import MoveTable
from chipbreak.model.modal import Setting, State
from chipbreak.model.motion import AXES
from chipbreak.model.words import is_diameter
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.units import MM_PER_INCH, S_PER_MIN
from chipbreak.vibration.bends import blocks_of
from chipbreak.vibration.control import control_model
from chipbreak.vibration.path import split_at
from chipbreak.vibration.plan import VibratedCut
from chipbreak.vibration.timing import feeds_for_spans

Floats = NDArray[np.float64]
_SAME_MM = 1e-6
_LEAST_STEPS = 4
_TIME_SHARE = 0.004
_SAME_S = 1e-12


@dataclass(frozen=True, eq=False)
class _Words:
    """Axis words of every knot, in program units, rounded; (n, axes)."""

    letters: tuple[str, ...]
    absolute: Floats
    points_mm: Floats
    decimals: int
    incremental: bool


@dataclass(frozen=True, eq=False)
class Expansion:
    """The moves of a cut: a first block with G1, a table, and a last block that ends exactly at the end.

    ``distance_mm`` is where on the path each block ends, ``time_s`` when it should, both of shape (blocks,).
    """

    content: tuple[str | MoveTable, ...]
    distance_mm: Floats
    time_s: Floats


def moves_of(cut: VibratedCut, settings: Settings) -> Expansion:
    """Turn the knots of a cut into blocks.

    Errors: VIB023 when the whole cut rounds to nothing, VIB058 for distances finer than the output's digits,
    VIB059 for a stroke or feeds too fine for them.
    """
    chain = cut.chain
    time_s, distance_mm = _knots(cut, settings.vibration.chord_mm)
    words = _axis_words(cut, distance_mm, settings)
    step_mm = 10.0**-words.decimals * (MM_PER_INCH if chain.before.is_inch else 1.0)
    if cut.cut.stroke_mm < _LEAST_STEPS * step_mm:
        stroke = f"the stroke of {cut.cut.stroke_mm:.4g} mm"
        message = f"{stroke} has fewer than {_LEAST_STEPS} steps of {step_mm:g} mm"
        raise RefusalError("VIB059", message, "raise output.decimals, or give a larger Q or A")
    # Of knots that round to one point the last stays, so that the time goes to the move towards it and not
    # to the one behind it, which may be the plain end with a feed of its own.
    keep = np.append(np.any(np.diff(words.absolute, axis=0) != 0.0, axis=1), True)
    times = time_s[keep]
    if len(times) == 1:
        message = f"the cut rounds to nothing at {words.decimals} decimals"
        raise RefusalError("VIB023", message, "a vibrated cut needs a distance to travel")
    if words.incremental and np.abs(words.points_mm[-1] - cut.path.legs[-1].end).max() > _SAME_MM:
        message = f"this cut is incremental, and its end lies between two steps of {words.decimals} decimals"
        raise RefusalError("VIB058", message, f"write {words.decimals} decimals, or absolute positions")
    times[0] = time_s[0]
    absolute, points = words.absolute[keep], words.points_mm[keep]
    feeds = _feed_words(cut, times, distance_mm[keep], points, settings)
    values = np.diff(absolute, axis=0) if words.incremental else absolute[1:]
    decimals = (words.decimals,) * len(words.letters) + (feed_decimals(chain.before, settings),)
    table = MoveTable((*words.letters, "F"), (*values.T, feeds), decimals)
    ends = distance_mm[keep][1:]
    ends[-1] = cut.path.length_mm
    blocks = _as_blocks(table, chain.after, _tail_is_programmed(cut, settings))
    return Expansion(blocks, ends, times[1:])


def _knots(cut: VibratedCut, chord_mm: float) -> tuple[Floats, Floats]:
    """The knots of the cut, and more at corners and in moves that would leave an arc.

    A stroke without a knot inside is one block, which a control runs best; so a joint without a corner gets
    none of its own.
    """
    time_s, distance_mm = split_at(cut.time_s, cut.distance_mm, cut.path.corners_mm())
    pieces = cut.path.pieces(distance_mm[:-1], distance_mm[1:], chord_mm)
    if pieces.max() == 1:
        return time_s, distance_mm
    place = np.append(np.repeat(np.arange(len(pieces)), pieces), len(pieces)).astype(np.float64)
    ranks = np.arange(len(place)) - np.append(np.repeat(np.cumsum(pieces) - pieces, pieces), len(place) - 1)
    place += ranks / np.append(np.repeat(pieces, pieces), 1)
    knots = np.arange(len(time_s))
    return np.interp(place, knots, time_s), np.interp(place, knots, distance_mm)


def _check_feed_digits(cut: VibratedCut, spans: Floats, feeds: Floats, settings: Settings) -> None:
    """Refuse feeds that lose so many digits that the cut would take another time."""
    digits, planned_s = feed_decimals(cut.chain.before, settings), cut.cut.duration_s
    with np.errstate(divide="ignore"):
        took_s = float((spans * feeds / np.round(feeds, digits)).sum())
    if abs(took_s - planned_s) > _TIME_SHARE * planned_s:
        message = f"with {digits} decimals of F this cut of {planned_s:.3f} s would take {took_s:.3f} s"
        raise RefusalError("VIB059", message, "raise output.feed_decimals, or take another output.feed_mode")


def _axis_words(cut: VibratedCut, distance_mm: Floats, settings: Settings) -> _Words:
    chain, state = cut.chain, cut.chain.before
    points = cut.path.points(distance_mm)
    decimals = settings.output.decimals + (1 if state.is_inch else 0)
    scale = np.ones(3) / (MM_PER_INCH if state.is_inch else 1.0)
    if is_diameter(state, settings.control):
        scale[0] *= 2.0
    axes = [AXES.index(axis) for axis in _moving_axes(cut)]
    absolute_mode = state.modes.get("distance") == "absolute"
    incremental = all(move.incremental for move in chain.moves)
    # The start is a position the program gave; incremental words count from it, whatever its digits.
    origin: Floats = points[0] * scale if incremental else np.zeros(3)
    rounded = np.round(points * scale - origin, decimals)
    letters = AXES
    if incremental and absolute_mode:
        by_axis = {axis: letter for letter, axis in settings.dialect.incremental.items()}
        letters = "".join(by_axis[axis] for axis in AXES)
    return _Words(
        tuple(letters[a] for a in axes), rounded[:, axes], (rounded + origin) / scale, decimals, incremental
    )


def _moving_axes(cut: VibratedCut) -> str:
    """The axes whose position changes anywhere in the chain."""
    legs = cut.path.legs
    moved = {axis for i, axis in enumerate(AXES) if any(leg.start[i] != leg.end[i] for leg in legs)}
    moved |= {AXES[i] for arc in cut.path.arcs if arc is not None for i in arc.axes}
    return "".join(axis for axis in AXES if axis in moved)


def feed_decimals(state: State, settings: Settings) -> int:
    """Decimals of F: fine for feed per revolution, three fewer for the larger numbers of the other modes.

    Inch programs get one more, as positions do.
    """
    fine = settings.output.feed_decimals + (1 if state.is_inch else 0)
    return fine if settings.output.feed_mode == "rev" else max(1, fine - 3)


def _feed_words(
    cut: VibratedCut, times: Floats, distance_mm: Floats, points: Floats, settings: Settings
) -> Floats:
    """F of every block, (n - 1,), from the rounded points and the time that each block should really take.

    The plain revolutions at the end run at the programmed feed itself, not at one with rounding in it.
    """
    moved = np.diff(points, axis=0)
    spans = np.diff(times)
    plain_from = int(np.searchsorted(times[:-1], cut.time_s[-2] - _SAME_S))
    model = control_model(settings, cut.path, cut.chain.before)
    blocks = blocks_of(moved, np.diff(distance_mm), settings)
    feeds_mm_s = feeds_for_spans(blocks, spans, model, plain_from)
    unit = MM_PER_INCH if cut.chain.before.is_inch else 1.0
    mode = settings.output.feed_mode
    if mode == "inverse":
        words = feeds_mm_s / np.abs(blocks.lengths_mm) * S_PER_MIN
    elif mode == "minute":
        words = feeds_mm_s / unit * S_PER_MIN
    else:
        words = feeds_mm_s / unit * S_PER_MIN / cut.solution.speed_rpm
    feeds: Floats = np.maximum(words, 10.0 ** -feed_decimals(cut.chain.before, settings))
    if _tail_is_programmed(cut, settings):
        feed = cut.chain.before.feed
        assert feed is not None
        feeds[plain_from:] = feed.value
    _check_feed_digits(cut, spans, feeds, settings)
    return feeds


def _tail_is_programmed(cut: VibratedCut, settings: Settings) -> bool:
    """True when the cut ends plainly and the output's feed mode is the program's own."""
    same_mode = cut.chain.before.modes["feed_mode"] == settings.output.feed_mode
    return same_mode and settings.output.feed_mode != "inverse" and cut.cut.end_revolutions > 0.0


def _as_blocks(table: MoveTable, after: State, plain_end: bool) -> tuple[str | MoveTable, ...]:
    """First and last block as text, the rest as a table."""
    first = "G1 " + _row(table, 0, None)
    count = len(table)
    if count == 1:
        return (first,)
    middle = MoveTable(table.letters, tuple(c[1 : count - 1] for c in table.columns), table.decimals)
    last = _row(table, count - 1, after.feed if plain_end else None)
    return (first, middle, last) if len(middle) else (first, last)


def _row(table: MoveTable, row: int, feed: Setting | None) -> str:
    """One block; with ``feed`` its F is the program's own text."""
    words = [
        letter + print_number(float(column[row]), decimals)
        for letter, column, decimals in zip(table.letters, table.columns, table.decimals, strict=True)
    ]
    if feed is not None:
        words[-1] = f"F{feed.text}"
    return " ".join(words)
