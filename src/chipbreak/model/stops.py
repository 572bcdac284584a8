"""What a control stops at, or obeys where nobody means it (``dialect.stops_at``).

A sender that goes on behind a refused line leaves the tool where nobody expects it, so such a program is
refused as a whole.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import Stops
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.syntax.nodes import Block, Word
from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic
from chipbreak.text.named_tuple import NamedTuple

STOPS = "MOD010"
_MOST_TOLD = 20
_NESTED = re.compile(r"\([^()]*\([^)]*\)")
_COMMENT = re.compile(r"\([^)]*\)?|;.*")
_TAKE_OUT = "take it out, or let the post-processor write for this control"


class _Found(NamedTuple):
    """What is wrong with a block, the way out, and where it stands in its text."""

    message: str
    help: str
    at: tuple[int, int]


class _Case(NamedTuple):
    block: Block
    dialect: Dialect
    stops: Stops
    interpreted: InterpretedProgram

    @property
    def ours(self) -> frozenset[int]:
        """Where the words begin that ask for vibration: they never reach the control."""
        return frozenset(word.start for word in self.interpreted.effect(self.block.line).vibration)

    def refuses(self, what: str, start: int, end: int, help_text: str = _TAKE_OUT) -> _Found:
        """The control refuses what stands at these characters."""
        return _Found(f"this control refuses {what}", help_text, (start, end))


Rule = Callable[[_Case], Iterator[_Found]]


def stops(interpreted: InterpretedProgram, within: range | None = None) -> list[Diagnostic]:
    """An error for every block at which the control would stop, or obey what is none of the program.

    ``within`` are the lines to look at, None for all of the program.
    """
    program = interpreted.program
    if program.dialect.stops_at is None:
        return []
    found: list[Diagnostic] = []
    for line in _suspects(program, program.dialect.stops_at, within or program.source.body):
        case = _Case(program.block(line), program.dialect, program.dialect.stops_at, interpreted)
        first = next((one for rule in RULES for one in rule(case)), None)
        if first is not None:
            found.append(program.diagnose(line, STOPS, first.message, first.help, at=first.at))
        if len(found) == _MOST_TOLD:
            break
    return found


def _suspects(program: Program, stops_at: Stops, body: range) -> list[int]:
    """The lines that are more than plain motion, long ones, and those of a shape that is refused."""
    is_wrong = [_is_wrong(shape.letters, shape.motion, stops_at) for shape in program.shapes]
    special = program.special_lines
    lines = set(special[(special >= body.start) & (special < body.stop)].tolist())
    if any(is_wrong):
        plain = program.plain[body.start : body.stop]
        lines.update(
            n + body.start for n, shape in enumerate(plain.tolist()) if shape >= 0 and is_wrong[shape]
        )
    limits = [limit for limit in (stops_at.line_chars, stops_at.code_chars) if limit]
    if limits:
        sizes = np.diff(program.source.starts[body.start : body.stop + 1])
        lines.update((np.flatnonzero(sizes > min(limits)) + body.start).tolist())
    return sorted(lines)


def _is_wrong(letters: str, motion: int | None, stops_at: Stops) -> bool:
    return not set(letters) <= set(stops_at.letters) or (stops_at.one_command and motion is None)


def _tape_marks(case: _Case) -> Iterator[_Found]:
    if case.block.mark and case.stops.tape_mark:
        at = case.block.text.index("%")
        yield case.refuses("%", at, at + 1, "take the line out; it needs no marks at the ends")


def _real_time(case: _Case) -> Iterator[_Found]:
    """Characters that are obeyed as they come in, also in comments."""
    pattern = _real_time_characters(case.stops)
    match = pattern.search(case.block.text) if pattern else None
    if match:
        one = match[0]
        name = repr(one) if one.isascii() and one.isprintable() else f"byte 0x{ord(one):02X}"
        message = f"this control obeys {name} as it comes in, whatever it stands in (a real-time command)"
        yield _Found(message, "take it out, also out of comments", (match.start(), match.end()))


@lru_cache(maxsize=8)
def _real_time_characters(stops_at: Stops) -> re.Pattern[str] | None:
    signs = re.escape(stops_at.real_time)
    high = f"{chr(stops_at.real_time_from)}-\xff" if stops_at.real_time_from else ""
    return re.compile(f"[{signs}{high}]") if signs + high else None


def _comment_in_comment(case: _Case) -> Iterator[_Found]:
    """The comment ends at its first ), and what stands behind it is obeyed."""
    text = case.block.text.partition(";")[0]
    # Behind the last ) nothing ends: to look there from each ( would take hours.
    for comment in _NESTED.finditer(text, 0, text.rfind(")") + 1):
        rest = case.block.text[comment.end() :].strip(" \t)")
        if rest and not rest.startswith(("(", ";")):
            message = f"the comment ends at its first ), and the control acts on {rest[:30]} behind it"
            yield _Found(message, "take the inner parentheses out", (comment.start(), comment.end()))


def _unread(case: _Case) -> Iterator[_Found]:
    if case.block.opaque and not case.stops.has_own_commands:
        at = case.block.opaque_column
        yield case.refuses(f"this line ({case.block.opaque})", at, at + 1)


def _macros(case: _Case) -> Iterator[_Found]:
    """Variables, expressions, loops and jumps."""
    block = case.block
    ends = [(one.start, one.end) for one in block.assignments]
    ends += [(one.start, one.end) for one in block.controls]
    for start, end in ends:
        if block.text[start] != "$":
            yield case.refuses(block.text[start:end].strip(), start, end)
    for word in block.words:
        if word.number is None:
            yield case.refuses(f"{block.text_of(word)}, a value that is no number", word.start, word.end)
    if block.skip > 1:
        at = block.text.index("/")
        yield case.refuses(f"/{block.skip}", at, at + 2, "write / alone")


def _codes(case: _Case) -> Iterator[_Found]:
    """G and M codes, and letters, that it does not know."""
    for word in case.block.words:
        if word.address not in case.stops.letters:
            if word.start not in case.ours:
                yield case.refuses(f"the letter of {case.block.text_of(word)}", word.start, word.end)
        elif not _knows(word, case.dialect):
            yield case.refuses(case.block.text_of(word), word.start, word.end)


def _knows(word: Word, dialect: Dialect) -> bool:
    if word.number is None:
        return True
    tenfold = round(word.number * 10)
    if word.address == "G":
        return tenfold in dialect.g_codes and abs(word.number * 10 - tenfold) < 1e-6
    return word.address != "M" or (tenfold % 10 == 0 and tenfold // 10 in dialect.m_codes)


def _one_command(case: _Case) -> Iterator[_Found]:
    """A line is one command and its words; another code in it is not obeyed."""
    words = case.block.words
    if not (case.stops.one_command and words) or words[0].address == "T":
        return
    if words[0].address not in "GM":
        word = words[0]
        help_text = "write the code in front, G1 Z-5. or M3 S800"
        yield case.refuses("a line without a code in front", word.start, word.end, help_text)
    for word in words[1:]:
        if word.address in "GM":
            what = f"{case.block.text_of(word)} behind another code"
            yield case.refuses(what, word.start, word.end, "write one code a line")


def _lengths(case: _Case) -> Iterator[_Found]:
    text = case.block.text
    stops_at = case.stops
    if stops_at.line_chars and len(text) > stops_at.line_chars:
        most = f"a line of {len(text)} characters: it takes {stops_at.line_chars}, comments included"
        yield case.refuses(most, stops_at.line_chars, len(text), "make the line shorter")
    code = _COMMENT.sub("", text).translate({ord(blank): None for blank in " \t"})
    if stops_at.code_chars and len(code) > stops_at.code_chars:
        most = (
            f"a block of {len(code)} characters: it takes {stops_at.code_chars} without blanks and comments"
        )
        yield case.refuses(most, 0, len(text), "make the block shorter")


RULES: tuple[Rule, ...] = (
    _real_time,
    _tape_marks,
    _comment_in_comment,
    _unread,
    _macros,
    _codes,
    _one_command,
    _lengths,
)
