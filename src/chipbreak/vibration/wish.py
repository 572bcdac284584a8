"""A wish for vibration by a directive or the profile: what it reached, and what it passed over.

A wish that nothing answers is never silent.  What it passed over is a move that the control makes itself: a
cycle, a thread, a call.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal

from chipbreak.model.block_effect import BlockEffect
from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.directive import Directive

UNANSWERED = "VIB065"
PASSED_OVER = "VIB067"
AskedBy = Literal["word", "directive", "profile"]

_CONTOUR_CYCLES = frozenset({"rough-cycle", "finish-cycle"})
_CALLS = ("call", "local-call", "external-call")
_CYCLES = ("cycle", "turning-cycle")
_THREADS = ("thread", "threading-cycle", "thread-cycle")


class Passed(NamedTuple):
    """A block that a wish passed over: what it is, its text, its line from 0, and why where that is plain."""

    what: str
    text: str
    line: int
    why: str = ""


@dataclass(eq=False, repr=False)
class Wish:
    """Who asks, with which values, from ``line`` (from 0) on; ``blocked`` is why nothing there can vibrate.

    ``reached`` counts the cuts that it asked, ``unasked`` those of operations that it is not for, ``named``
    the cycles that it passed over and of which something better is said.
    """

    asked_by: AskedBy
    directive: Directive
    line: int = 0
    at: tuple[int, int] | None = None
    reached: int = 0
    unasked: int = 0
    named: int = 0
    passed: list[Passed] = field(default_factory=list)
    ended_at: int | None = None
    blocked: Diagnostic | None = None

    @property
    def on(self) -> bool:
        """False for ``(VIB OFF)``, and for a profile that asks for nothing."""
        return self.directive.on

    def pass_over(self, effect: BlockEffect, *, is_named: bool) -> None:
        """Note a block that the control moves by itself; ``is_named``: it is said why it stays."""
        what = next((what for what, rule in _OBSTACLES if rule(effect)), None)
        if what is not None and is_named:
            self.named += 1
        elif what is not None:
            text = effect.block.text.strip()[:40]
            self.passed.append(Passed(what, text, effect.block.line, _why(what, effect)))


def said_of(wish: Wish, program: Program, *, is_strict: bool) -> Diagnostic | None:
    """What is to be said of a wish at its end; None where it was answered, or had nothing to answer to."""
    if not wish.on or wish.blocked is not None:
        return None
    if not wish.reached:
        return _unanswered(wish, program, Severity.ERROR if is_strict else Severity.WARNING)
    if any(one.what != "thread" for one in wish.passed):
        first = wish.passed[0]
        message = f"{_counted(wish.passed)} not vibrated: only G1, G2 and G3 are; the first is {first.text}"
        return _at(wish, program, PASSED_OVER, message + first.why, Severity.WARNING)
    return None


def _unanswered(wish: Wish, program: Program, severity: Severity) -> Diagnostic | None:
    """The wish reached no cut at all."""
    if not wish.passed and not wish.unasked and (wish.asked_by == "profile" or wish.named):
        return None  # a program without a cut, or all is said of its cycles
    why = "; ".join(_reasons(wish, program))
    who = "this wish for vibration" if wish.asked_by == "directive" else "the profile's wish for vibration"
    return _at(wish, program, UNANSWERED, f"{who} reached no cut: {why}", severity)


def _reasons(wish: Wish, program: Program) -> Iterator[str]:
    if wish.passed:
        first = wish.passed[0]
        where = program.source.place(first.line).line
        yield f"{_counted(wish.passed)} not vibrated (the first in line {where}, {first.text}{first.why})"
    if wish.unasked:
        cuts = "1 cut is" if wish.unasked == 1 else f"{wish.unasked} cuts are"
        yield f"{cuts} of finishing operations, or of others that vibration.only does not name"
    if not wish.passed and not wish.unasked:
        ended = wish.ended_at
        yield (
            "no cut stands behind it"
            if ended is None
            else f"line {program.source.place(ended).line} ends it before any cut"
        )


def _at(wish: Wish, program: Program, code: str, message: str, severity: Severity) -> Diagnostic:
    is_directive = wish.asked_by == "directive"
    line = wish.line if is_directive or not wish.passed else wish.passed[0].line
    return program.diagnose(line, code, message, _way_out(wish), at=wish.at, severity=severity)


def _way_out(wish: Wish) -> str:
    if wish.passed:
        off = "write (VIB OFF) before it" if wish.asked_by == "profile" else "take the wish out"
        if wish.passed[0].why:
            return f"start the spindle before it (M3, M4), or {off}"
        return f"write these passes as G1 where their chips must break, or {off}"
    if wish.unasked:
        return "name the kind of these operations, or their tool, in vibration.only"
    return "write it straight before the cuts, behind the tool call, or take it out"


def _why(what: str, effect: BlockEffect) -> str:
    """Why a cycle is passed over that else would be written out: nothing is cut while the spindle stands."""
    known = not any(state.turns or state.spindle_why for state in (effect.before, effect.after))
    return ", while the spindle stands" if what == "cycle" and known else ""


def _counted(passed: list[Passed]) -> str:
    """``12 cycles, 3 threads were``."""
    counts = Counter(one.what for one in passed)
    said = ", ".join(f"{n} {what}{'s' * (n > 1)}" for what, n in counts.items())
    return f"{said} {'was' if len(passed) == 1 else 'were'}"


def _is_thread(effect: BlockEffect) -> bool:
    if "thread-cycle" in effect.non_modal:
        return effect.block.has_any("XYZUW")  # the block before it only sets its values
    return _begins(effect, _THREADS)


def _is_cycle(effect: BlockEffect) -> bool:
    if effect.non_modal & _CONTOUR_CYCLES:
        return effect.block.has("Q")
    if "peck-cycle" in effect.non_modal:
        return effect.block.has_any("XYZUW")
    return _begins(effect, _CYCLES)


def _begins(effect: BlockEffect, motions: tuple[str, ...]) -> bool:
    """True for a move of such a kind that does not go on with the block before it."""
    is_such = effect.after.modes.motion in motions and effect.move is not None
    return is_such and effect.before.modes.motion != effect.after.modes.motion


def _is_call(effect: BlockEffect) -> bool:
    by_word = any(control.keyword == "O-CALL" for control in effect.block.controls)
    return by_word or "macro-call" in effect.non_modal or effect.does("subprogram", *_CALLS)


_OBSTACLES: tuple[tuple[str, Callable[[BlockEffect], bool]], ...] = (
    ("thread", _is_thread),
    ("cycle", _is_cycle),
    ("call", _is_call),
)
