"""Cuts that a directive or the profile asks to vibrate, and that stay as they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple

# Codes of moves that remove nothing: leaving them is no wish refused.
UNKNOWN_SPEED = "VIB053"
NO_SPINDLE = "VIB046"
NO_LENGTH = "VIB023"
UNASKED_FINISHING = "VIB068"
_NO_CUTS = (NO_SPINDLE, NO_LENGTH)


class LeftCut(NamedTuple):
    """A cut that stays as it was: lines ``first`` to ``last`` (exclusive), and what stood in its way.

    ``said`` has the code, the reason and the way out at the place of the cut; its code is empty for a move
    through air, which is no news.  ``asked_by`` is ``directive`` or ``profile``.
    """

    first: int
    last: int
    said: Diagnostic
    asked_by: str

    @property
    def is_cut(self) -> bool:
        """False for a move that cuts nothing, and so breaks no chip."""
        return bool(self.said.code) and self.said.code not in _NO_CUTS


def said_of_left(program: Program, left: Iterable[LeftCut]) -> Iterator[Diagnostic]:
    """One warning a reason, at the first cut, with the number of cuts that it stands for."""
    by_code: dict[str, list[LeftCut]] = {}
    for cut in left:
        if cut.said.code:
            by_code.setdefault(cut.said.code, []).append(cut)
    for cuts in by_code.values():
        first = cuts[0].said
        stays = "it stays as it was"
        if len(cuts) > 1:
            where = program.source.place(cuts[-1].first).line
            stays = f"it stays as it was, and {_more(len(cuts) - 1)} up to line {where} for such a reason"
        yield first._replace(severity=Severity.WARNING, message=f"{first.message}; {stays}")


def _more(count: int) -> str:
    return "one more" if count == 1 else f"{count} more"


def joined(left: Iterable[LeftCut]) -> list[LeftCut]:
    """Blocks in a row that stay for one reason as one cut."""
    found: list[LeftCut] = []
    for cut in left:
        before = found[-1] if found else None
        same = before is not None and before.last == cut.first and before.asked_by == cut.asked_by
        if before is not None and same and before.said.code == cut.said.code:
            found[-1] = before._replace(last=cut.last)
        else:
            found.append(cut)
    return found
