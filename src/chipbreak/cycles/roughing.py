"""Passes at levels (G71, G72): straight cuts, each deeper by the depth of cut, then one along the contour.

Where the contour has pockets, one pocket after the other is cleared, in the direction of cutting.
"""

from __future__ import annotations

import math
from functools import lru_cache

from chipbreak.cycles.contour import Point, Segment, filled, parts_of
from chipbreak.cycles.stock import Stock
from chipbreak.text.named_tuple import NamedTuple

_NOTHING_MM = 1e-6


class Motion(NamedTuple):
    """A move of the tool to ``end``: rapid or cutting, straight or round ``centre`` (see Segment)."""

    cuts: bool
    end: Point
    centre: Point | None = None
    turn: int = 0


class Pass(NamedTuple):
    """One pass: its number, what it does in a few words, and its moves."""

    number: int
    title: str
    moves: tuple[Motion, ...]


class Roughing(NamedTuple):
    """What a roughing cycle is told; lengths in mm, depths as radii.

    ``start``     where the tool stands before the cycle
    ``contour``   the finished shape, from its first point on, without the move to it
    ``depth_mm``  depth of cut of a pass;  ``retract_mm`` how far the tool goes back under 45 degrees
    ``t_allowance_mm``, ``h_allowance_mm``  what stays for finishing, against the direction of cutting and
                  towards the stock
    ``t_first_mm``, ``h_first_mm``  what the levels leave beyond that, for a pass of its own along the contour
    ``feeds_in``  the tool is fed, and does not rush, from one level to the next
    ``only_pockets`` only the pockets are cleared: what stands over the rest is gone
    ``stays_at_h_mm`` where the tool stays over the end of the contour; None where it goes back to the start
    ``finishes``  the last pass runs along the contour
    ``narrow_mm`` a pass shorter than this is not made: the one along the contour takes the rest
    """

    start: Point
    contour: tuple[Segment, ...]
    depth_mm: float
    retract_mm: float
    t_allowance_mm: float = 0.0
    h_allowance_mm: float = 0.0
    feeds_in: bool = False
    t_first_mm: float = 0.0
    h_first_mm: float = 0.0
    narrow_mm: float = 1e-6
    only_pockets: bool = False
    stays_at_h_mm: float | None = None
    finishes: bool = True

    @property
    def ends_along_contour(self) -> bool:
        """True where the last pass runs along the contour: always where I or K leave something for it."""
        return self.finishes or self.t_first_mm > 0.0 or self.h_first_mm > 0.0

    @property
    def rough_contour(self) -> tuple[Segment, ...]:
        """The contour with the allowances."""
        return tuple(one.shifted(-self.t_allowance_mm, self.h_allowance_mm) for one in self.contour)

    @property
    def level_contour(self) -> tuple[Segment, ...]:
        """How far the levels reach."""
        return tuple(one.shifted(-self.t_first_mm, self.h_first_mm) for one in self.rough_contour)

    @property
    def departure(self) -> Point:
        """Where the passes begin: the start, moved by what stays against the direction of cutting."""
        return Point(self.start.t - self.t_allowance_mm - self.t_first_mm, self.start.h)


# Programs rough the same contour from the same start for one part after the other.
@lru_cache(maxsize=4)
def roughing_passes(cycle: Roughing) -> tuple[Pass, ...]:
    """The passes of a cycle, in order.

    Raises SelfCheckError when one of them would take more than the depth of cut or rush through stock.
    """
    return tuple(_Cutter(cycle).passes())


class _Span(NamedTuple):
    """A stretch along t in which a level lies above the contour; ``is_open`` where no wall is before it."""

    first_mm: float
    last_mm: float
    is_open: bool


def _below(part: Segment, level_mm: float) -> tuple[float, float] | None:
    """The stretch along t in which a part of the contour, that does not turn back, lies below a level."""
    low_mm, high_mm = sorted((part.start.h, part.end.h))
    if high_mm <= level_mm + _NOTHING_MM:
        return part.start.t, part.end.t
    if low_mm >= level_mm - _NOTHING_MM:
        return None
    t_mm = part.t_at(level_mm)
    return (part.start.t, t_mm) if part.end.h > part.start.h else (t_mm, part.end.t)


def _is_inside(span: _Span, within: _Span, narrow_mm: float) -> bool:
    is_long = span.last_mm > span.first_mm + narrow_mm
    after = span.first_mm >= within.first_mm - _NOTHING_MM
    return is_long and after and span.last_mm <= within.last_mm + _NOTHING_MM


class _Cutter:
    """Makes the moves of all passes, and keeps the stock."""

    def __init__(self, cycle: Roughing) -> None:
        self.cycle = cycle
        self.parts = parts_of(cycle.level_contour)
        self.top_mm = cycle.start.h
        self.first_mm = cycle.departure.t
        self.stock = Stock(self.first_mm, math.inf, self.top_mm)
        self.at = cycle.start
        self.moves: list[Motion] = []
        self.made: list[Pass] = []

    def passes(self) -> list[Pass]:
        """All passes."""
        self._rapid(self.cycle.departure)
        if self.cycle.only_pockets:
            self._clear_pockets()
        else:
            self._clear(_Span(-math.inf, math.inf, is_open=True), 1)
        if self.cycle.t_first_mm > 0.0 or self.cycle.h_first_mm > 0.0:
            self._follow(self.cycle.level_contour)
        if self.cycle.ends_along_contour:
            self._follow(self.cycle.rough_contour)
        self._go_home()
        return self.made

    def _clear_pockets(self) -> None:
        """The levels of each pocket, below its rim."""
        for pocket in filled(self.cycle.level_contour).pockets:
            self.stock.cut(pocket.first_mm, pocket.last_mm, pocket.rim_mm)
            over = math.floor((self.top_mm - pocket.rim_mm) / self.cycle.depth_mm + _NOTHING_MM)
            self._clear(_Span(pocket.first_mm, pocket.last_mm, is_open=False), max(over, 0) + 1)

    def _clear(self, within: _Span, number: int) -> None:
        """All levels of a stretch, from the ``number``th down; the pockets that a level opens one by one."""
        level_mm = self.top_mm - number * self.cycle.depth_mm
        lowest_mm = self._lowest(within)
        if lowest_mm >= self.top_mm - (number - 1) * self.cycle.depth_mm - _NOTHING_MM:
            return
        if level_mm <= lowest_mm + _NOTHING_MM:
            if self.cycle.ends_along_contour:
                return  # the pass along the contour takes the rest
            level_mm = lowest_mm
        for span in self._spans(level_mm, within):
            self._cut(span, level_mm)
            self._clear(span, number + 1)

    def _lowest(self, within: _Span) -> float:
        """The lowest point of the contour in a stretch."""
        heights = [
            min(part.start.h, part.end.h)
            for part in self.parts
            if part.end.t > within.first_mm - _NOTHING_MM and part.start.t < within.last_mm + _NOTHING_MM
        ]
        return min(heights, default=self.top_mm)

    def _spans(self, level_mm: float, within: _Span) -> list[_Span]:
        """Where a level lies above the contour, in the direction of cutting."""
        is_open = within.is_open and self.parts[0].start.h < level_mm + _NOTHING_MM
        free = [(self.first_mm, self.parts[0].start.t)] if is_open else []
        free += [found for part in self.parts if (found := _below(part, level_mm)) is not None]
        spans = list[_Span]()
        for first_mm, last_mm in free:
            if spans and first_mm <= spans[-1].last_mm + _NOTHING_MM:
                spans[-1] = spans[-1]._replace(last_mm=last_mm)
            else:
                spans.append(_Span(first_mm, last_mm, is_open=is_open and not spans))
        return [span for span in spans if _is_inside(span, within, self.cycle.narrow_mm)]

    def _cut(self, span: _Span, level_mm: float) -> None:
        """One straight pass: there, in, along, and back under 45 degrees."""
        if span.is_open:
            self._approach(Point(span.first_mm, level_mm))
        else:
            self._enter(span, level_mm)
        self._feed(Point(span.last_mm, level_mm))
        self.stock.cut(span.first_mm, span.last_mm, level_mm, self.cycle.depth_mm)
        back_mm = min(self.cycle.retract_mm, span.last_mm - span.first_mm)
        self._rapid(Point(span.last_mm - back_mm, level_mm + self.cycle.retract_mm))
        self._rapid(Point(span.first_mm, level_mm + self.cycle.retract_mm))
        self._end_pass(f"level {self.top_mm - level_mm:.4g} mm below the start")

    def _approach(self, to: Point) -> None:
        """In front of the stock, from the height of the last pass to the next level."""
        self._rapid(Point(to.t, self.at.h))
        if self.cycle.feeds_in:
            self._feed(to)
        else:
            self._rapid(to)

    def _enter(self, span: _Span, level_mm: float) -> None:
        """Into a pocket: above all stock, down to what the last pass has left, then fed into the stock."""
        floor_mm = self.stock.highest(span.first_mm, span.last_mm)
        over_mm = max(self.top_mm, self.at.h)
        is_above = self.stock.highest(self.at.t, span.first_mm) <= self.at.h
        if not is_above:
            self._rapid(Point(self.at.t, over_mm))
        self._rapid(Point(span.first_mm, self.at.h))
        self._rapid(Point(span.first_mm, min(self.at.h, floor_mm + self.cycle.retract_mm)))
        self._feed(Point(span.first_mm, level_mm))

    def _follow(self, contour: tuple[Segment, ...]) -> None:
        """Along the contour with what it leaves, from its first point to its last."""
        self._over(Point(self.first_mm, self.top_mm))
        first = contour[0].start
        self._approach(Point(self.first_mm, first.h))
        self._feed(first)
        for segment in contour:
            self._add(Motion(True, segment.end, segment.centre, segment.turn))
        self._end_pass("along the contour")

    def _over(self, to: Point) -> None:
        """Rapid to a place in front of the stock, above all of it."""
        over_mm = max(to.h, self.at.h)
        self._rapid(Point(self.at.t, over_mm))
        self._rapid(Point(to.t, over_mm))

    def _go_home(self) -> None:
        """Back to the start, away from the part first."""
        start = self.cycle.start
        if self.cycle.stays_at_h_mm is None:
            self._rapid(Point(self.at.t, max(self.at.h, start.h)))
            self._rapid(Point(start.t, self.at.h))
            self._rapid(start)
        else:
            self._feed(Point(self.at.t, max(self.at.h, self.cycle.stays_at_h_mm)))
        if self.moves and self.made:
            last = self.made.pop()
            self.made.append(last._replace(moves=(*last.moves, *self.moves)))
            self.moves = []

    def _end_pass(self, title: str) -> None:
        self.made.append(Pass(len(self.made) + 1, title, tuple(self.moves)))
        self.moves = []

    def _rapid(self, to: Point) -> None:
        if math.dist(self.at, to) > _NOTHING_MM:
            if not self._has_followed():
                self.stock.check_rapid(self.at, to)
            self._add(Motion(False, to))

    def _has_followed(self) -> bool:
        return bool(self.made) and self.made[-1].title == "along the contour"

    def _feed(self, to: Point) -> None:
        if math.dist(self.at, to) > _NOTHING_MM:
            self._add(Motion(True, to))

    def _add(self, motion: Motion) -> None:
        self.moves.append(motion)
        self.at = motion.end
