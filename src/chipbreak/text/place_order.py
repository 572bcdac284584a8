"""Diagnostics in the order of the program, each thing said once, and a few of many alike."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from chipbreak.text.diagnostics import Diagnostic, Severity

_MOST_ALIKE = 5


def in_place_order(
    diagnostics: Iterable[Diagnostic], *, covers_line: str = "", covers_word: str = ""
) -> tuple[Diagnostic, ...]:
    """By line; of many alike warnings the first few stand for all.

    What is an error anyway need not be warned of as well: a warning with the code ``covers_line`` goes where
    its line has an error, one with ``covers_word`` where its very place has one.
    """
    found = list(dict.fromkeys(diagnostics))
    errors = {d.place for d in found if d.place and d.severity is Severity.ERROR}
    lines = {place.line for place in errors}
    said = [
        d
        for d in found
        if not (d.place and d.code == covers_line and d.place.line in lines)
        and not (d.place and d.code == covers_word and d.place in errors)
    ]
    return _few_alike(sorted(said, key=_line))


def _line(diagnostic: Diagnostic) -> int:
    return diagnostic.place.line if diagnostic.place else 0


def _few_alike(ordered: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    """All errors, and of every other code the first few; the last of them says how many more there are."""
    seen: Counter[str] = Counter()
    kept: list[Diagnostic] = []
    for diagnostic in ordered:
        seen[diagnostic.code] += 1
        if _is_error(diagnostic) or seen[diagnostic.code] <= _MOST_ALIKE:
            kept.append(diagnostic)
    last = {diagnostic.code: index for index, diagnostic in enumerate(kept)}
    return tuple(
        _with_rest(diagnostic, seen[diagnostic.code]) if last[diagnostic.code] == index else diagnostic
        for index, diagnostic in enumerate(kept)
    )


def _with_rest(diagnostic: Diagnostic, count: int) -> Diagnostic:
    more = count - _MOST_ALIKE
    if more <= 0 or _is_error(diagnostic):
        return diagnostic
    return diagnostic._replace(message=f"{diagnostic.message} (and {more} more like this)")


def _is_error(diagnostic: Diagnostic) -> bool:
    return diagnostic.severity is Severity.ERROR
