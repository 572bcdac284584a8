"""A run in one line, for the end of ``filter``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from chipbreak.units import S_PER_MIN

if TYPE_CHECKING:
    from chipbreak.report.model import Report


_IF_EXACT = "on a control that follows the blocks exactly"


def summary_line(report: Report) -> str:
    """``5 cuts vibrate, all break; 3 left as they were; cycle 12:40 -> 13:05``."""
    return "; ".join(text for rule in _RULES if (text := rule(report)))


def _cuts(report: Report) -> str:
    count = len(report.cuts)
    if not count:
        return "" if report.checks and not report.left else "no cut vibrates" + _why_none(report)
    whole = sum(not cut.verdict.breaks for cut in report.cuts)
    vibrate = f"{count} cuts vibrate" if count > 1 else "1 cut vibrates"
    if whole:
        return f"{vibrate}, {f'{whole} DO' if count > 1 else 'it DOES'} NOT BREAK chips"
    if any(cut.unproven for cut in report.cuts):
        return f"{vibrate}, unproven: {'all' if count > 1 else 'it'} would break {_IF_EXACT}"
    if any(cut.on_edge for cut in report.cuts):
        which = "some" if count > 1 else "it"
        return f"{vibrate}, unproven: {which} would break with less to spare than is known"
    return f"{vibrate}, {'all break' if count > 1 else 'it breaks'}"


def _why_none(report: Report) -> str:
    return "" if report.left else ": nothing asks for it"


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
    """The whole program before and after, with what that is built on."""
    time = report.time
    if time is None or not (report.cuts or report.checks):
        return ""
    told = [f"assumed: {', '.join(one.what for one in time.assumed)}"] if time.assumed else []
    count = len(time.untimed)
    told += [f"{count} lines not timed" if count > 1 else "1 line not timed"] if count else []
    rests_on = f" ({'; '.join(told)})" if told else ""
    return f"cycle {clock(time.before_s)} -> {clock(time.after_s)}{rests_on}"


def clock(time_s: float) -> str:
    """``0:07.4`` below ten minutes, where tenths can be seen, and ``12:40`` above."""
    if time_s < 10.0 * S_PER_MIN:
        minutes, tenths = divmod(round(time_s * 10.0), 600)
        return f"{minutes}:{tenths // 10:02}.{tenths % 10}"
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes}:{seconds:02}"


def _axis_data(report: Report) -> str:
    return "profile names no axis data" if report.without_axis_data else ""


_RULES: tuple[Callable[[Report], str], ...] = (_cuts, _left, _checks, _time, _axis_data)
