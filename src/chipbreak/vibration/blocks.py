"""A vibrated cut as blocks: rounded positions, and the feed that carries the time.

Positions are rounded as absolutes, so no error adds up; incremental words are differences of the rounded
positions.  The feed of each block follows from the rounded points and the time between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from chipbreak.editing.edits import MoveTable
from chipbreak.editing.render import can_be_written, print_moves
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.remembered import remembered
from chipbreak.kinematics.toolpath import split_at
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.law import ControlLaw
from chipbreak.units import S_PER_MIN, typed_feed
from chipbreak.vibration.axis_steps import (
    axis_steps_mm,
    end_reached,
    off_halves,
    reached,
    steps_per_unit,
    units_per_mm,
)
from chipbreak.vibration.block_text import END_DECIMALS, Columns, Words, block_text
from chipbreak.vibration.dwell import printed_s
from chipbreak.vibration.forms import WRITTEN_OUT, OutputForm, form_with
from chipbreak.vibration.least_stroke import TOO_FINE, moving_axes, too_fine
from chipbreak.vibration.loop import Loop, among_kept, same_feeds
from chipbreak.vibration.loop_names import LoopNames
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.plan import CutPlan
from chipbreak.vibration.readback import ReadBack
from chipbreak.vibration.small_returns import Crests, lost_returns, raise_crests, with_rests
from chipbreak.vibration.tolerances import PLANNED_TIME_SHARE

_LINE_END = b"\n"  # what senders put behind a block
_SAME_MM = 1e-6
_SAME_STEP_MM = 1e-9
_SAME_S = 1e-12


@dataclass(frozen=True, eq=False)
class Expansion:
    """The moves of a cut: a first block with G1, a table, and a last block that ends exactly at the end.

    ``distance_mm`` is where on the path each block ends, ``time_s`` when it should, both of shape (blocks,);
    a block of a loop counts in every pass.  ``loops`` are those of ``content``, None where none were asked.
    ``dwell_s`` is how long the tool dwells behind each block, which belongs to its time but at the end; empty
    where it never does.  ``planned_s``: how long all of it should take.  ``printed`` are the moves as the
    blocks will say them, None where nobody asks any more.  ``from_stand``: the control must stand before it,
    with nothing left to do.
    """

    content: tuple[str | MoveTable, ...]
    distance_mm: Floats
    time_s: Floats
    dwell_s: Floats
    planned_s: float
    loops: Sequence[Loop] | None = None
    printed: ReadBack | None = None
    from_stand: bool = False

    def __repr__(self) -> str:
        return f"<Expansion: {len(self.distance_mm)} moves>"


def moves_of(cut: CutPlan, settings: Settings, names: LoopNames | None = None) -> Expansion:
    """Turn the knots of a cut into blocks; with ``names`` its steady parts into loops.

    Errors: VIB023 when the whole cut rounds to nothing, VIB032 for blocks that come in too slowly,
    VIB058 for distances finer than the output's digits, VIB059 for a stroke or feeds too fine for them.
    """
    form = form_with(names)
    ends = _ends(cut, form, settings)
    dwell_s, end_dwell_s = _dwells(cut, ends.dwells, settings)
    columns = Columns(ends.words, dwell_s, form)
    planned_s = cut.wave.duration_s + end_dwell_s
    _check_rate(len(ends.time_s) - 1 + int(np.count_nonzero(dwell_s)), planned_s, settings)
    from_stand = False
    if not cut.expander.keeps_feed:
        _check_bytes_without_feeds(cut, columns, planned_s, settings)
        feeds, from_stand = _feed_words(cut, ends, settings)
        columns = replace(columns, feeds=feeds, feed_decimals=_feed_decimals(cut, settings))
    distance_mm = ends.distance_mm[1:].copy()
    distance_mm[-1] = cut.path.length_mm
    text = block_text(columns, cut.chain, settings, plain_end=_tail_is_programmed(cut, settings))
    _check_bytes(text, float(ends.time_s[-1] - ends.time_s[0]), settings)
    printed = _printed(cut, columns, settings)
    loops = form.told(ends.words.loops)
    return Expansion(text, distance_mm, ends.time_s[1:], dwell_s, planned_s, loops, printed, from_stand)


def _check_rate(count: int, time_s: float, settings: Settings) -> None:
    """Refuse a cut of more blocks than the control reads in its time; laws look at each of them besides."""
    most = settings.planner.max_blocks_per_s
    if most is not None and count > most * time_s * (1.0 + 1e-9):
        message = f"needs {count / time_s:z.0f} blocks per second, the control reads {most:g}"
        help_text = 'ask for a lower frequency, or take output.segments = "stroke"'
        raise RefusalError("VIB032", message, help_text)


def _check_bytes_without_feeds(cut: CutPlan, columns: Columns, time_s: float, settings: Settings) -> None:
    """Refuse blocks that are too long even with the shortest F: to find the right ones takes far longer."""
    if settings.planner.max_bytes_per_s is None:
        return
    ones = np.ones(len(columns.words.absolute) - 1)
    shortest = replace(columns, feeds=ones, feed_decimals=_feed_decimals(cut, settings))
    _check_bytes(block_text(shortest, cut.chain, settings, plain_end=False), time_s, settings)


def _check_bytes(text: Sequence[str | MoveTable], time_s: float, settings: Settings) -> None:
    """Refuse a cut whose blocks come in slower than they run: the control would wait for each of them."""
    most = settings.planner.max_bytes_per_s
    if most is None:
        return
    count = sum(
        len(print_moves(item, _LINE_END)) if isinstance(item, MoveTable) else len(item) + len(_LINE_END)
        for item in text
    )
    if count > most * time_s:
        message = f"needs {count / time_s:z.0f} bytes per second, the control gets {most:g}"
        help_text = "ask for a lower frequency, or fewer output.decimals and output.feed_decimals"
        raise RefusalError("VIB032", message, help_text)


def _printed(cut: CutPlan, columns: Columns, settings: Settings) -> ReadBack:
    """The moves with the numbers that will be printed of them."""
    points_mm = columns.words.points_mm
    moved = np.diff(points_mm, axis=0)
    lengths_mm = np.sqrt(np.einsum("ij,ij->i", moved, moved))
    if columns.feeds is None:
        feeds_mm_s = np.full(len(lengths_mm), cut.wave.feed_speed_mm_s)
    else:
        feeds = np.round(columns.feeds, columns.feed_decimals)
        if _tail_is_programmed(cut, settings):
            feeds[-1] = columns.feeds[-1]
        feeds_mm_s = _feeds_mm_s(cut, feeds, lengths_mm, settings)
    return ReadBack(points_mm[1:], lengths_mm, feeds_mm_s, columns.dwell_s)


class _Ends(NamedTuple):
    """Where blocks end: when [s], how far along the path [mm], their words; behind which how many dwells."""

    time_s: Floats
    distance_mm: Floats
    words: Words
    dwells: NDArray[np.intp]


def _ends(cut: CutPlan, form: OutputForm, settings: Settings) -> _Ends:
    """The knots that stay apart when they are rounded; (n,) each, the start included."""
    rest_s = None
    if not cut.expander.keeps_feed:
        rest_s = control_along(settings, cut.path, cut.chain.before).rest_at_crest_s
    knots = with_rests(cut.wave, *_knots(cut, settings.vibration.chord_mm), rest_s or 0.0)
    time_s, distance_mm, dwells = cut.expander.knots(*knots)
    words = _axis_words(cut, time_s, distance_mm, form, settings)
    if rest_s is not None:
        crests = lost_returns(cut.wave, time_s, words, rest_s, _feed_step_mm_s(cut, settings))
        distance_mm = _raised(cut, crests, distance_mm, words, settings)
    # Of knots that round to one point the last stays, so that the time goes to the move towards it and not
    # to the one behind it, which may be the plain end with a feed of its own.
    keep = np.append(np.any(np.diff(words.absolute, axis=0) != 0.0, axis=1), True)
    keep[-2:-1] &= not _is_at_end(cut, words, settings)
    keep[1 : 1 + _left_out_first(cut, time_s, distance_mm, settings)] = False
    # What was left out there may have been all that stood at the start.
    keep[0] |= bool((words.absolute[keep.argmax()] != words.absolute[0]).any())
    times = time_s[keep]
    counts = dwells[keep].astype(np.intp)
    if dwells.any():
        # Where knots have become one point, the last of them takes over how often the tool dwells.
        counts = np.add.reduceat(dwells.astype(np.intp), np.append(0, np.flatnonzero(keep)[:-1] + 1))
    if (counts > 1).any():
        raise too_fine(cut.wave, cut.path, cut.chain.before, cut.expander.larger, settings)
    _check_end(cut, words)
    if len(times) == 1:
        message = f"the cut rounds to nothing at {words.decimals} decimals"
        raise RefusalError("VIB023", message, "a vibrated cut needs a distance to travel")
    times[0] = time_s[0]
    points_mm = words.points_mm[keep]
    points_mm[0] = words.points_mm[0]
    kept = replace(
        words,
        absolute=words.absolute[keep],
        points_mm=points_mm,
        loops=among_kept(words.loops, keep),
    )
    return _Ends(times, distance_mm[keep], _ending_exactly(kept, cut, settings), counts)


def _left_out_first(cut: CutPlan, time_s: Floats, distance_mm: Floats, settings: Settings) -> int:
    """How many knots of a line before the first crest go to the first block: a control would rest behind a
    shorter one.  No loop reaches there.
    """
    wave = cut.wave
    if wave.form != "tick" or cut.expander.keeps_feed or cut.path.arcs[0] is not None:
        return 0
    law = control_along(settings, cut.path, cut.chain.before)
    soon_s = min(law.least_first_s, wave.alpha_share * wave.period_s) - _SAME_S
    soon = (time_s[1:-1] - time_s[0] < soon_s) & (distance_mm[2:] > distance_mm[1:-1])
    soon &= distance_mm[1:-1] < min(cut.path.corners_mm(), default=np.inf)
    return int(np.append(soon, False).argmin())


def _is_at_end(cut: CutPlan, words: Words, settings: Settings) -> bool:
    """True when the axes reach the programmed end before the last block, whose words may still differ."""
    origin_mm = np.array(cut.path.legs[0].start) if words.incremental else np.zeros(3)
    end_mm = cut.path.points(np.array([cut.path.length_mm]))[0]
    end_mm = end_reached(end_mm, origin_mm, settings, cut.chain.before)
    return bool(np.abs(words.points_mm[-2] - end_mm).max() <= _SAME_STEP_MM)


def _feed_step_mm_s(cut: CutPlan, settings: Settings) -> float:
    """What the last digit of F is worth; next to nothing in inverse time."""
    if settings.output.feed_mode == "inverse":
        return 0.0
    per_minute = 10.0 ** -_feed_decimals(cut, settings) * cut.chain.before.mm_per_unit
    if settings.output.feed_mode == "rev":
        per_minute *= cut.solution.speed_rpm
    return float(per_minute / S_PER_MIN)


def _raised(cut: CutPlan, crests: Crests, distance_mm: Floats, words: Words, settings: Settings) -> Floats:
    """Crests a little further, in ``words``; the distances along the path then."""
    if not len(crests.knots):
        return distance_mm
    scale = units_per_mm(settings, cut.chain.before)
    per_unit = steps_per_unit(axis_steps_mm(settings, cut.chain.before), scale, words.decimals)
    axes = np.array([AXES.index(axis) for axis in moving_axes(cut.path)])
    tangents = cut.path.tangents(distance_mm[crests.knots])[:, axes]
    steps = 1.0 / per_unit[axes]
    ahead_mm = raise_crests(words, crests, steps, axes, per_mm=scale[axes], tangents=tangents)
    raised_mm = distance_mm.copy()
    raised_mm[crests.knots] += ahead_mm
    return raised_mm


def _ending_exactly(words: Words, cut: CutPlan, settings: Settings) -> Words:
    """The words with the end that the program wrote, in as many digits: what follows starts from there."""
    if words.incremental:
        return words
    axes = [AXES.index(axis) for axis in moving_axes(cut.path)]
    end_mm = cut.path.points(np.array([cut.path.length_mm]))[0]
    words.absolute[-1] = np.round((end_mm * units_per_mm(settings, cut.chain.before))[axes], END_DECIMALS)
    words.points_mm[-1] = end_mm
    return words


def _dwells(cut: CutPlan, counts: NDArray[np.intp], settings: Settings) -> tuple[Floats, float]:
    """How long the tool dwells behind each block, (n,); empty where it never does.

    Also how much longer it dwells at the end than its last vibration makes it.
    """
    if not cut.expander.keeps_feed and cut.end_dwell_s <= 0.0:
        return np.empty(0), 0.0
    law = control_along(settings, cut.path, cut.chain.before)
    each_s = cut.expander.dwell_s(cut.wave, law, cut.edges, cut.solution.per_rev)
    dwell_s = np.where(counts[1:] > 0, each_s, 0.0)
    last_s = float(dwell_s[-1])
    dwell_s[-1] = max(last_s, printed_s(cut.end_dwell_s, law.dwell_step_s))
    return dwell_s, float(dwell_s[-1]) - last_s


def _check_end(cut: CutPlan, words: Words) -> None:
    """Refuse an end that incremental words cannot reach."""
    if words.incremental and np.abs(words.points_mm[-1] - cut.path.legs[-1].end).max() > _SAME_MM:
        message = f"this cut is incremental, and its end lies between two steps of {words.decimals} decimals"
        raise RefusalError("VIB058", message, f"write {words.decimals} decimals, or absolute positions")


def _knots(cut: CutPlan, chord_mm: float) -> tuple[Floats, Floats]:
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


def _check_digits(cut: CutPlan, by_feed_s: float, end_s: float, settings: Settings) -> None:
    """Refuse numbers that lose so many digits that the cut would take another time.

    ``by_feed_s`` is how long it takes with the digits of F.  ``end_s`` is how much longer its plain end then
    takes, which begins at a rounded place and has a feed of its own.
    """
    planned_s = cut.wave.duration_s
    digits = _feed_decimals(cut, settings)
    took_s = by_feed_s + end_s
    if abs(took_s - planned_s) <= PLANNED_TIME_SHARE * planned_s:
        return
    takes = f"this cut of {planned_s:z.3f} s would take {took_s:z.3f} s"
    if abs(end_s) > abs(took_s - planned_s) / 2.0:
        places = settings.output.decimals_of(is_inch=cut.chain.before.is_inch)
        raise RefusalError(TOO_FINE, f"with {places} decimals of a place {takes}", "raise output.decimals")
    help_text = "raise output.feed_decimals, or take another output.feed_mode"
    raise RefusalError(TOO_FINE, f"with {digits} decimals of F {takes}", help_text)


def _axis_words(
    cut: CutPlan, time_s: Floats, distance_mm: Floats, form: OutputForm, settings: Settings
) -> Words:
    chain = cut.chain
    state = cut.chain.before
    points = cut.path.points(distance_mm)
    decimals = settings.output.decimals_of(is_inch=state.is_inch)
    names = settings.axis_words
    scale = units_per_mm(settings, cut.chain.before)
    moving = moving_axes(cut.path)
    axes = [AXES.index(axis) for axis in moving]
    letters = [names.letters[axis] for axis in moving]
    incremental = all(move.incremental for move in chain.moves)
    if incremental and state.modes.distance == "absolute":
        distances = [d for d in map(names.distance_letter, moving) if d]
        incremental = len(distances) == len(moving)
        letters = distances if incremental else letters
    # The start is a position the program gave; incremental words count from it, whatever its digits.
    origin: Floats = points[0] * scale if incremental else np.zeros(3)
    distance_letters = _distance_letters(letters, moving, settings, incremental=incremental)
    steps = steps_per_unit(axis_steps_mm(settings, state), scale, decimals)
    rounded = (points * scale - origin) * steps
    form = form if distance_letters else WRITTEN_OUT
    loops = form.round_steps(cut, time_s, rounded, axes, settings)
    rounded /= steps
    # The end is the programmed one, whatever the axes make of it.
    rounded[-1] = np.rint((points[-1] * scale - origin) * 10.0**decimals) / 10.0**decimals
    if axis_steps_mm(settings, state).any():
        # A step need not end with the digits; what is printed is what adds up, and where the axes go by.
        step = axis_steps_mm(settings, state) * np.abs(scale)
        rounded[:-1] = off_halves(np.round(rounded, decimals), rounded, step, decimals)[:-1]
        np.round(rounded, decimals, out=rounded)
    places_mm = (rounded + origin) / scale
    if axis_steps_mm(settings, state).any():
        places_mm[:-1] = reached(places_mm[:-1], axis_steps_mm(settings, state), origin / scale)
    places_mm[0] = points[0]  # the tool stands where the program has put it, whatever the digits
    return Words(tuple(letters), rounded[:, axes], places_mm, decimals, incremental, distance_letters, loops)


def _distance_letters(
    letters: Sequence[str], axes: str, settings: Settings, *, incremental: bool
) -> tuple[str, ...]:
    """Letters for distances along the axes of a cut, under G91 where there is that; none where neither is."""
    if incremental or settings.dialect.can("distance", "incremental"):
        return tuple(letters)
    distances = tuple(d for d in map(settings.axis_words.distance_letter, axes) if d)
    return distances if len(distances) == len(axes) else ()


def _feed_words(cut: CutPlan, ends: _Ends, settings: Settings) -> tuple[Floats, bool]:
    """F of every block, (n - 1,), from the rounded points and the time that each block should really take.

    And whether the control must stand before them.

    The plain revolutions at the end run at the programmed feed itself, not at one with rounding in it.
    """
    moved = np.diff(ends.words.points_mm, axis=0)
    spans = np.diff(ends.time_s)
    _refuse_no_time(cut, spans, settings)
    plain_from = int(np.searchsorted(ends.time_s[:-1], cut.time_s[-2] - _SAME_S))
    law = control_along(settings, cut.path, cut.chain.before)
    digits = _feed_decimals(cut, settings)
    blocks = law.blocks(moved, np.diff(ends.distance_mm))
    step = np.full(len(spans), 10.0**-digits)
    blocks = replace(blocks, feed_steps_mm_s=_feeds_mm_s(cut, step, blocks.lengths_mm, settings))
    feeds_mm_s = _feeds_for_spans(law, blocks, spans, plain_from).copy()
    same_feeds(feeds_mm_s, ends.words.loops, blocks, law, cut.wave.period_s)
    state = cut.chain.before
    exact = _typed_feeds(cut, feeds_mm_s, blocks.lengths_mm, settings)
    end_s = 0.0
    if _tail_is_programmed(cut, settings):
        assert state.feed is not None
        exact[plain_from:] = typed_feed(state.feed.value, is_inch=state.is_inch)
        if law.keeps_time:
            end_mm = float(np.abs(blocks.lengths_mm[plain_from:]).sum())
            end_s = end_mm / cut.wave.feed_speed_mm_s - float(spans[plain_from:].sum())
    feeds: Floats = np.maximum(exact, 10.0**-digits)
    if not can_be_written(feeds, digits):
        message = f"a block would need F{feeds.max():.3g}, which no program can say"
        raise RefusalError("VIB031", message, "ask for a lower frequency or a smaller stroke")
    printed = np.round(feeds, digits)
    if _tail_is_programmed(cut, settings):
        # The F of the last block is printed as the program has it, whatever the digits of others.
        printed[-1] = feeds[-1] = exact[-1]
    with np.errstate(divide="ignore"):
        by_feed_s = float((spans * exact / printed).sum())
    _check_digits(cut, by_feed_s, end_s, settings)
    return feeds, law.must_stand_before(blocks, feeds_mm_s)


def _refuse_no_time(cut: CutPlan, spans_s: Floats, settings: Settings) -> None:
    """A corner and the crest beside it, which coarse digits set apart, may be one moment.  Errors: VIB059."""
    if spans_s.min() <= 0.0:
        places = settings.output.decimals_of(is_inch=cut.chain.before.is_inch)
        message = f"with {places} decimals of a place a block beside a corner would take no time"
        raise RefusalError(TOO_FINE, message, "raise output.decimals")


@remembered
def _feeds_for_spans(law: ControlLaw, blocks: Blocks, spans_s: Floats, plain_from: int) -> Floats:
    return law.feeds_for_spans(blocks, spans_s, plain_from)


def _typed_feeds(cut: CutPlan, feeds_mm_s: Floats, lengths_mm: Floats, settings: Settings) -> Floats:
    """Feeds as numbers of F words, in the feed mode and the units of the output."""
    mode = settings.output.feed_mode
    if mode == "inverse":
        return feeds_mm_s / np.abs(lengths_mm) * S_PER_MIN
    per_minute = feeds_mm_s / cut.chain.before.mm_per_unit * S_PER_MIN
    return per_minute if mode == "minute" else per_minute / cut.solution.speed_rpm


def _feeds_mm_s(cut: CutPlan, feeds: Floats, lengths_mm: Floats, settings: Settings) -> Floats:
    """What the numbers of F words are in mm/s: :func:`_typed_feeds` the other way round."""
    mode = settings.output.feed_mode
    if mode == "inverse":
        return feeds * np.abs(lengths_mm) / S_PER_MIN
    per_minute = feeds if mode == "minute" else feeds * cut.solution.speed_rpm
    return per_minute * cut.chain.before.mm_per_unit / S_PER_MIN


def _feed_decimals(cut: CutPlan, settings: Settings) -> int:
    return settings.output.feed_decimals_of(is_inch=cut.chain.before.is_inch)


def _tail_is_programmed(cut: CutPlan, settings: Settings) -> bool:
    """True when the cut ends plainly and the output's feed mode is the program's own."""
    same_mode = cut.chain.before.modes.feed_mode == settings.output.feed_mode
    return same_mode and settings.output.feed_mode != "inverse" and cut.wave.end_revolutions > 0.0
