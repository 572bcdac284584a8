"""Safe points: lines before which a check can be inserted, and what has to be put back after it."""

from __future__ import annotations

from chipbreak.insertion.candidate_rules import INSERTION_RULES, Case, Surroundings
from chipbreak.insertion.candidates import Candidate, Mover, candidates
from chipbreak.insertion.clearance import Clearance
from chipbreak.insertion.obstacles import Obstacles
from chipbreak.insertion.retract import Retract
from chipbreak.insertion.ways_out import MAKE_A_PLACE
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.text.named_tuple import NamedTuple

# How far around the obvious line a safe one is looked for.
REACH = 500


class SafePoint(NamedTuple):
    """A line before which a check can be inserted.

    ``state``          the state there
    ``axes``           axes that have to be again where they were, in the order X, Y, Z
    ``length_offset``  words that bring the length offset back into force, such as ``G43 H2``, or ""
    ``restarts``       True when the spindle turns there and must turn again
    ``needs_speed``    True when S must be in force again, because the spindle must turn, or starts without S
    ``coolant``        what must flow again
    """

    line: int
    state: State
    axes: str
    length_offset: str
    restarts: bool
    needs_speed: bool
    coolant: frozenset[str]


class NoSafePoint(NamedTuple):
    """Why there is none: what is wrong at the obvious line, and what would help."""

    line: int
    why: str
    help: str = MAKE_A_PLACE


class Range(NamedTuple):
    """Where to look: forward from ``obvious`` to ``last``, then back to ``first`` (all of them lines).

    The line before ``first`` is a cut, a tool call or nothing (``at_start``).
    """

    first: int
    obvious: int
    last: int
    at_start: bool = False


class SafePointFinder:
    """Looks for safe points in one program.

    ``calls_end_offset`` is True for calls that may end the length offset, as some makers' cycles do,
    ``calls_in_line`` for blocks that are the check itself: they set F, modes and the work offset.
    """

    def __init__(
        self,
        interpreted: InterpretedProgram,
        obstacles: Obstacles,
        *,
        calls_end_offset: bool = False,
        calls_in_line: bool = False,
    ) -> None:
        is_lathe = interpreted.settings.dialect.is_lathe
        clearance = Clearance(interpreted, obstacles.main) if is_lathe else None
        retract = Retract(interpreted.settings)
        self._surroundings = Surroundings(
            interpreted, obstacles, retract, clearance, calls_end_offset, calls_in_line
        )
        self._main = obstacles.main

    def find(self, where: Range, *, comes_back: bool = False) -> SafePoint | NoSafePoint:
        """The first safe line of a range; ``comes_back``: what is called goes back to X and Y by itself."""
        found = self._candidates(where)
        forward = [candidate for candidate in found if candidate.line >= where.obvious]
        back = [candidate for candidate in found if candidate.line < where.obvious][::-1]
        first_refusal: NoSafePoint | None = None
        for candidate in forward + back:
            judged = self._judge(candidate, comes_back=comes_back)
            if isinstance(judged, SafePoint):
                return judged
            first_refusal = first_refusal or judged
        return first_refusal or NoSafePoint(where.obvious, "there is no block between")

    def _candidates(self, where: Range) -> list[Candidate]:
        first = max(where.first, where.obvious - REACH)
        is_at_start = where.at_start and first == where.first
        start = first if is_at_start else max(first - 1, self._main.first)
        last = min(where.last, where.obvious + REACH, self._end())
        if last < start:
            return []
        mover: Mover = "nothing" if where.at_start else "cut"
        around = self._surroundings
        found = candidates(around.interpreted, around.retract, start, last, mover)
        return [candidate for candidate in found if candidate.line >= first]

    def _end(self) -> int:
        """The last line before which something can be inserted."""
        source = self._surroundings.interpreted.program.source
        is_open = source.data[-1:] not in (b"\n", b"\r")
        return min(self._main.last, source.line_count - 1 if is_open else source.line_count)

    def _judge(self, candidate: Candidate, *, comes_back: bool) -> SafePoint | NoSafePoint:
        case = Case(self._surroundings, candidate, comes_back=comes_back)
        for rule in INSERTION_RULES:
            obstacle = rule(case)
            if obstacle is not None:
                return NoSafePoint(candidate.line, obstacle.why, obstacle.way_out)
        axes = "".join(axis for axis in "XYZ" if axis in case.axes)
        words = case.offset_words or ""
        now = (case.restarts, case.needs_speed, case.coolant)
        return SafePoint(candidate.line, candidate.state, axes, words, *now)
