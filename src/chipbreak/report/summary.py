"""A run in one line, for the end of ``filter``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from chipbreak.units import S_PER_MIN

if TYPE_CHECKING:
    from chipbreak.report.model import Report


_IF_EXACT = "on a control that follows the blocks exactly"


def summary_line(report: Report) -> str:
    """``5 cuts vibrate, all break; 3 left as they were; these cuts take 12:40 -> 13:05``."""
    return "; ".join(text for rule in _RULES if (text := rule(report)))


def _cuts(report: Report) -> str:
    count = len(report.cuts)
    if not count:
        return "" if report.checks and not report.left else "no cut vibrates"
    whole = sum(not cut.verdict.breaks for cut in report.cuts)
    vibrate = f"{count} cuts vibrate" if count > 1 else "1 cut vibrates"
    if whole:
        return f"{vibrate}, {f'{whole} DO' if count > 1 else 'it DOES'} NOT BREAK chips"
    if any(cut.unproven for cut in report.cuts):
        return f"{vibrate}, unproven: {'all' if count > 1 else 'it'} would break {_IF_EXACT}"
    return f"{vibrate}, {'all break' if count > 1 else 'it breaks'}"


def _left(report: Report) -> str:
    count = sum(cut.is_cut for cut in report.left)
    if not count:
        return ""
    return f"{count} left as they were" if count > 1 else "1 left as it was"


def _checks(report: Report) -> str:
    count = len(report.checks)
    if not count:
        return ""
    return f"{count} checks" if count > 1 else "1 check"


def _time(report: Report) -> str:
    """Of the vibrated cuts: how long the rest of a program takes is not known."""
    was = [cut.programmed_s for cut in report.cuts]
    known = [one for one in was if one is not None]
    if not known or len(known) < len(was):
        return ""
    before = _clock(sum(known))
    after = _clock(sum(cut.duration_s for cut in report.cuts))
    return f"these cuts take {before} -> {after}"


def _clock(time_s: float) -> str:
    """``0:07.4`` below ten minutes, where tenths can be seen, and ``12:40`` above."""
    if time_s < 10.0 * S_PER_MIN:
        minutes, tenths = divmod(round(time_s * 10.0), 600)
        return f"{minutes}:{tenths // 10:02}.{tenths % 10}"
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes}:{seconds:02}"


def _axis_data(report: Report) -> str:
    return "profile names no axis data" if report.without_axis_data else ""


_RULES: tuple[Callable[[Report], str], ...] = (_cuts, _left, _checks, _time, _axis_data)
