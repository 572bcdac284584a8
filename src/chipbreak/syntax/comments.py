"""Comments that are not closed, and comments inside comments: controls do not agree on them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity

OPEN_COMMENT = "SYN003"
NESTED_COMMENT = "SYN004"
_ACTS = re.compile(
    r"\s*(?:(?:MSG|DEBUG|PRINT|LOG|LOGOPEN|LOGAPPEND|PY)\s*,|LOGCLOSE|PROBEOPEN|PROBECLOSE)", re.IGNORECASE
)


def said_of_comments(program: Program, changes: Sequence[tuple[int, int]]) -> list[Diagnostic]:
    """What is to be said of comments; ``changes`` are first and last lines (exclusive) of what is changed."""
    return _open_comments(program, changes) + _nested_comments(program)


def _open_comments(program: Program, changes: Sequence[tuple[int, int]]) -> list[Diagnostic]:
    """A warning for every comment that is not closed on its line.

    It is an error where something is changed in its line or behind it, and it matters where the comment ends:
    the comment of a change would close what the program left open.
    """
    found = []
    for block in program.event_blocks():
        column = _open_at(block)
        if column is None:
            continue
        message = "this comment is not closed: the control stops here, or reads on to the next ) as comment"
        severity = Severity.WARNING
        if _is_closed_by_one(program, block, changes):
            message += "; the comments of a change behind it would close it"
            severity = Severity.ERROR
        at = (column, len(block.text))
        help_text = "close it with ) on its line"
        closed = (f"{block.text[column:]})",)
        found.append(
            program.diagnose(
                block.line, OPEN_COMMENT, message, help_text, at=at, severity=severity, instead=closed
            )
        )
    return found


def _is_closed_by_one(program: Program, block: Block, changes: Sequence[tuple[int, int]]) -> bool:
    """True where a change stands behind an open comment, or in it, and other blocks may be comment there."""
    if not any(last > block.line for _, last in changes):
        return False
    end = _harmless_end(program, block)
    return end is None or any(block.line < first <= end for first, _ in changes)


def leaves_blocks_open(program: Program, line: int) -> bool:
    """True for a comment that is not closed on its line, where the blocks behind it may be comment, too."""
    block = program.block(line)
    return _open_at(block) is not None and _harmless_end(program, block) is None


def _harmless_end(program: Program, block: Block) -> int | None:
    """The line of the next ), where nothing but comments stands up to there.

    Then the same blocks run wherever the control ends the comment.  None where others would.
    """
    if block.opaque:
        return None
    for line in range(block.line + 1, program.source.body.stop):
        behind = program.block(line)
        if not behind.is_empty or behind.mark or behind.sequence is not None:  # a number may be gone to
            return None
        if ")" in behind.text:
            return line
    return None


def _open_at(block: Block) -> int | None:
    """Where a comment begins that its line does not close."""
    if block.opaque:
        tail = block.text.find("(", block.text.rfind(")") + 1)
        return tail if tail >= 0 and ";" not in block.text else None
    for comment in block.comments:
        if block.text[comment.start] == "(" and not block.text[: comment.end].endswith(")"):
            return comment.start
    return None


def _nested_comments(program: Program) -> list[Diagnostic]:
    """A warning at the first comment in a comment that the control stops on, or ends early."""
    found = [one for block in program.event_blocks() for one in _nested_in(block, program)]
    if len(found) > 1:
        more = f"{found[0].message}; {len(found) - 1} more like it"
        return [found[0]._replace(message=more)]
    return found


def _nested_in(block: Block, program: Program) -> Iterator[Diagnostic]:
    for comment in block.comments:
        if block.text[comment.start] != "(" or "(" not in comment.text:
            continue
        behind = block.text[comment.end :].strip()
        if program.dialect.takes_nested_comments and (not behind or behind.startswith((";", "("))):
            continue
        message = "this control stops on a comment inside a comment"
        if program.dialect.takes_nested_comments:
            message = f"the comment ends at its first ), and the control acts on {behind[:30]} behind it"
        help_text = "take the inner parentheses out"
        at = (comment.start, comment.end)
        yield program.diagnose(
            block.line, NESTED_COMMENT, message, help_text, at=at, severity=Severity.WARNING
        )


def acting_comments(block: Block) -> str:
    """The comments of a block in a row, where one is more than a comment: LinuxCNC shows ``(MSG, ...)``.

    All of them, for of several it acts on the last one.  Empty where all are plain.
    """
    if not any(_ACTS.match(one.text) for one in block.comments):
        return ""
    return " ".join(block.text[one.start : one.end] for one in block.comments)
