"""A lathe program that is written for another code system than the profile says.

Code systems A, B and C of Fanuc-type lathes give one number different meanings: G92 S2500 is a thread of
system A that moves nowhere, and the limit of the spindle in B and C.  Read under the wrong one, a program
loses its limit, its feed mode or its place, so what only the other one can mean is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple

OTHER_SYSTEM = "MOD004"
_AXES = "XYZUVW"
_WORDS_OF_CYCLES = "XYZUVWPQRIKD"
_Codes = frozenset[float]


class _Sign(NamedTuple):
    """What shows one of the systems ``shown`` where it is read under one of ``under``, and what it means."""

    under: str
    shown: str
    means: str
    codes: _Codes
    is_it: Callable[[Block], bool]


def _is_bare(block: Block) -> bool:
    return not block.has_any(_WORDS_OF_CYCLES)


def _is_bare_limit(block: Block) -> bool:
    return _is_bare(block) and block.has("S")


def _is_bare_beside_others(block: Block) -> bool:
    return _is_bare(block) and len(block.numbers("G")) > 1


def _moves(block: Block) -> bool:
    return block.has_any(_AXES)


def _is_thread(block: Block) -> bool:
    return _moves(block) and block.has("F")


def _names_a_shape(block: Block) -> bool:
    return block.has("P") and block.has("Q")


def _always(_: Block) -> bool:
    return True


_SIGNS = (
    _Sign("A", "BC", "limits the spindle", frozenset({92.0}), _is_bare_limit),
    _Sign("A", "BC", "sets the feed mode", frozenset({95.0}), _always),
    _Sign("A", "BC", "sets distances", frozenset({91.0}), _always),
    _Sign("A", "BC", "sets places or the feed mode", frozenset({90.0, 94.0}), _is_bare_beside_others),
    _Sign("A", "B", "is a turning or threading cycle", frozenset({77.0, 78.0, 79.0}), _moves),
    _Sign("AB", "C", "sets the units", frozenset({70.0, 71.0}), _is_bare),
    _Sign("BC", "A", "is a threading cycle", frozenset({92.0}), _is_thread),
    _Sign("C", "AB", "sets the units", frozenset({20.0, 21.0}), _is_bare),
    _Sign("C", "AB", "is a cycle", frozenset({70.0, 71.0}), _names_a_shape),
)
# In B and C these say where a drilling cycle goes back to, in A what F is.
_FEED_OF_A: _Codes = frozenset({98.0, 99.0})
_FEED_OF_B: _Codes = frozenset({94.0, 95.0})
_DRILLING: _Codes = frozenset({83.0, 84.0, 85.0, 87.0, 88.0, 89.0})
_FINISHING: _Codes = frozenset({70.0, 71.0})
_ALL = frozenset().union(*(sign.codes for sign in _SIGNS), _FEED_OF_A, _FEED_OF_B, _DRILLING)


def codes_of_another_system(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """A warning at the first block that only another code system gives a meaning."""
    system = interpreted.settings.dialect.lathe_system
    if not system:
        return []
    if interpreted.settings.shown.system:
        return [_read_as_shown(interpreted)]
    blocks = [b for b in interpreted.program.event_blocks() if not _ALL.isdisjoint(b.numbers("G"))]
    signs = [sign for sign in _SIGNS if system in sign.under]
    found = next((one for block in blocks for one in _shown_by(block, signs)), None)
    if found is None and system != "A":
        found = _feed_mode_of_a(blocks)
    return [] if found is None else [_warning(interpreted, *found)]


def shown_system(program: Program) -> str:
    """``B`` or ``C`` where codes of a program mean something in that system alone, and none in A alone.

    Empty where it does not show that: then it is read under A.
    """
    blocks = [b for b in program.event_blocks() if b.numbers("G")]
    others = [sign for sign in _SIGNS if "A" in sign.under]
    shown = [set(found[3]) for block in blocks for found in _shown_by(block, others)]
    own = [sign for sign in _SIGNS if "A" not in sign.under and "A" in sign.shown and sign.shown != "AB"]
    if not shown or any(_is_of_a(block, own) for block in blocks):
        return ""
    left = set.intersection(*shown)
    if any(_names_a_shape(block) and not _FINISHING.isdisjoint(block.numbers("G")) for block in blocks):
        left &= {"B"}
    return min(left, default="")


def _is_of_a(block: Block, own: Iterable[_Sign]) -> bool:
    """True for a block that only system A gives a meaning: a thread with G92, the feed mode, a limit."""
    numbers = block.numbers("G")
    sets_feed = _is_bare(block) and not _FEED_OF_A.isdisjoint(numbers)
    limits = _is_bare_limit(block) and 50.0 in numbers
    return sets_feed or limits or bool(_shown_by(block, own))


def _shown_by(block: Block, signs: Iterable[_Sign]) -> list[tuple[Block, float, str, str]]:
    """The block, its code, what that means and in which systems, for each sign."""
    return [
        (block, code, sign.means, sign.shown)
        for code in block.numbers("G")
        for sign in signs
        if code in sign.codes and sign.is_it(block)
    ]


def _feed_mode_of_a(blocks: list[Block]) -> tuple[Block, float, str, str] | None:
    """G98 or G99 in a program without a drilling cycle, and without the codes by which B and C say it."""
    codes = {code for block in blocks for code in block.numbers("G")}
    if not codes.isdisjoint(_FEED_OF_B | _DRILLING):
        return None
    said = ((block, code) for block in blocks for code in block.numbers("G") if code in _FEED_OF_A)
    first = next(said, None)
    return None if first is None else (*first, "sets the feed mode", "A")


def _read_as_shown(interpreted: InterpretedProgram) -> Diagnostic:
    """Which code shows the system under which the program is read, for nobody said it."""
    system = interpreted.settings.shown.system
    signs = [sign for sign in _SIGNS if "A" in sign.under and system in sign.shown]
    blocks = (b for b in interpreted.program.event_blocks() if not _ALL.isdisjoint(b.numbers("G")))
    found = next((one for block in blocks for one in _shown_by(block, signs)), None)
    line = interpreted.program.source.body.start if found is None else found[0].line
    why = "" if found is None else f": G{found[1]:g} {found[2]} here"
    message = f"the program is read in code system {system}{why}"
    help_text = f'set control.lathe_system = "{system}", or "A" where the control has that one'
    return interpreted.program.diagnose(line, OTHER_SYSTEM, message, help_text, severity=Severity.WARNING)


def _warning(
    interpreted: InterpretedProgram, block: Block, code: float, means: str, shown: str
) -> Diagnostic:
    system = interpreted.settings.dialect.lathe_system
    word = next(word for word in block.words_of("G") if word.number == code)
    names = " and ".join(shown)
    message = f"{block.text_of(word)} {means} here in code system {names}, and the profile says {system}"
    values = " or ".join(f'"{one}"' for one in shown)
    help_text = f"if the control has that system, set control.lathe_system = {values}"
    return interpreted.program.diagnose(
        block.line, OTHER_SYSTEM, message, help_text, at=(word.start, word.end), severity=Severity.WARNING
    )
