"""What the emitted moves of a vibrated cut do not do, said with what would work."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.kinds import Kind
from chipbreak.operations.operations import Operation
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.units import MS_PER_S
from chipbreak.vibration.judged import Judged
from chipbreak.vibration.large_changes import LARGE_CHANGES
from chipbreak.vibration.little_to_spare import little_to_spare
from chipbreak.vibration.measure import CutReport
from chipbreak.vibration.on_the_edge import on_the_edge
from chipbreak.vibration.unproven import unproven
from chipbreak.vibration.wish import AskedBy

UNBROKEN = "VIB060"
FINISHING = "VIB061"
SERVO = "VIB062"
OVERLOADED = "VIB030"
MISSED = "VIB034"
TOO_FAST = "VIB064"
_ADVISED = (UNBROKEN, MISSED, SERVO, OVERLOADED)  # say what works instead
_MOST_ADVISED = 3  # what works is tried for the first of many cuts that fail alike
# How much more surface speed than G96 asked for is said aloud.
_MUCH_FASTER = 1.25


def findings_of_cuts(
    interpreted: InterpretedProgram,
    operations: Sequence[Operation],
    reports: Sequence[object],
    *,
    allow_unbroken: bool,
) -> list[Diagnostic]:
    """What is wrong with the vibrated cuts among the reports, in their order."""
    found: list[Diagnostic] = []
    cuts = [report for report in reports if isinstance(report, CutReport)]
    weak = 0
    for _, steps in groupby(cuts, lambda report: report.plan.chain.first):
        advise = weak < _MOST_ADVISED
        said = _of_block(Judged(interpreted, operations, one, allow_unbroken, advise) for one in steps)
        weak += any(one.code in _ADVISED for one in said)
        found += said
    said_of_all = (little_to_spare, unproven, on_the_edge)
    return [*found, *(said for rule in said_of_all for said in rule(interpreted, cuts))]


def _of_block(steps: Iterable[Judged]) -> list[Diagnostic]:
    """What is wrong with the steps of one block, each thing once: of the step that needs most."""
    hardest_first = sorted(steps, key=lambda one: -one.report.acceleration_mm_s2)
    said = (next(filter(None, map(rule, hardest_first)), None) for rule in _RULES)
    return [diagnostic for diagnostic in said if diagnostic is not None]


def errors_of_cuts(
    interpreted: InterpretedProgram,
    operations: Sequence[Operation],
    reports: Sequence[object],
    *,
    allow_unbroken: bool,
) -> dict[int, Diagnostic]:
    """The first error of each cut that may stay as it was, by the first line of the cut."""
    found: dict[int, Diagnostic] = {}
    key = interpreted.settings.vibration.refused
    for report in reports:
        if not isinstance(report, CutReport) or not report.plan.chain.may_be_left(key):
            continue
        advise = len(found) < _MOST_ADVISED
        error = first_error(Judged(interpreted, operations, report, allow_unbroken, advise))
        if error is not None:
            found[report.plan.chain.first] = error
    return found


def first_error(judged: Judged) -> Diagnostic | None:
    """What stops a cut; None where nothing does."""
    said = (rule(judged) for rule in _CAN_BE_ERRORS)
    return next((one for one in said if one is not None and one.severity is Severity.ERROR), None)


def _missed(judged: Judged) -> Diagnostic | None:
    """The control cannot keep to the plan: corners and bends of the path cost it time."""
    report = judged.report
    plan = judged.report.plan
    if not report.misses_plan:
        return None
    planned_s = report.expansion.planned_s
    message = (
        f"the control would take {report.duration_s:z.2f} s for this cut of {planned_s:z.2f} s"
        f" and make N {report.verdict.per_rev:z.3f} of {plan.solution.per_rev:z.3f}"
    )
    message += _why_missed(report)
    works = judged.ways_out()
    help_text = f"works: {works}" if works else _what_may_help(report)
    return judged.diagnose(MISSED, message, help_text, Severity.ERROR)


def _why_missed(report: CutReport) -> str:
    plan = report.plan
    if report.is_early:
        return ": it runs no move as slowly as this cut asks"
    if plan.path.corners_mm().size or any(arc is not None for arc in plan.path.arcs):
        return ": it slows down at bends of the path"
    if plan.wave.form == "tick":
        return ": strokes of several blocks do not keep their times"
    return ""


def _what_may_help(report: CutReport) -> str:
    if report.is_early:
        return "give a higher feed, or cut this block without vibration"
    return "ask for a lower frequency, or vibrate each block on its own"


def _unbroken(judged: Judged) -> Diagnostic | None:
    """Why the chips stay whole, and what would break them."""
    plan = judged.report.plan
    verdict = judged.report.verdict
    if verdict.breaks or judged.report.misses_plan or judged.report.following is not None:
        return None
    message = (
        f"this cut would not break chips: with a stroke of {plan.wave.stroke_mm:z.4f} mm at N"
        f" {verdict.per_rev or plan.solution.per_rev:z.3f} the weakest vibration has a margin of"
        f" {verdict.margin:z.2f}, 1 is needed"
    )
    # Who lets whole chips pass does not wait for what would break them.
    works = "" if judged.allow_unbroken else judged.ways_out()
    way_out = f"works: {works}" if works else "take another N, less feed, or leave Q and A out"
    help_text = f"{way_out}; --allow-unbroken lets it pass"
    return judged.diagnose(UNBROKEN, message, help_text, judged.unbroken_severity)


def _weak_axes(judged: Judged) -> Diagnostic | None:
    """The axes make too little of the strokes that they are commanded."""
    report = judged.report
    if report.following is None or report.verdict.breaks or report.misses_plan:
        return None
    share = report.following.stroke_share
    makes = f"are {report.following.delay_s * MS_PER_S:.3g} ms late behind the dwell"
    if share is not None:
        makes = f"make {share:.0%} of the commanded stroke of {report.plan.wave.stroke_mm:z.4f} mm"
    message = (
        f"the axes {makes} at {report.plan.solution.frequency_hz:.4g} Hz:"
        f" a margin of {report.verdict.margin:z.2f} is left, 1 is needed"
    )
    works = "" if judged.allow_unbroken else judged.ways_out()
    help_text = f"works: {works}" if works else "take a lower f with the same N"
    return judged.diagnose(
        SERVO, message, f"{help_text}; --allow-unbroken lets it pass", judged.unbroken_severity
    )


def _surface_speed(judged: Judged) -> Diagnostic | None:
    """A cut of G96 grows in diameter, and the speed of its start is far too high for that."""
    report = judged.report
    state = judged.report.plan.chain.before
    if state.modes.speed_mode != "surface" or not report.clearances or state.speed is None:
        return None
    asked_m_min = state.speed.value
    diameter_mm = report.clearances[0].diameter_mm
    speed_rpm = report.plan.solution.speed_rpm
    made_m_min = math.pi * diameter_mm * speed_rpm / 1000.0
    if made_m_min <= _MUCH_FASTER * asked_m_min:
        return None
    message = (
        f"G96 S{state.speed.text} runs as S{speed_rpm:g}: at diameter {diameter_mm:.4g} mm"
        f" that is {made_m_min:z.0f} m/min, {asked_m_min:z.0f} were asked for"
    )
    help_text = "cut towards the centre, or give this cut N and a lower f, or a lower clamp (G50 S)"
    return judged.diagnose(TOO_FAST, message, help_text, Severity.WARNING)


def _finishing(judged: Judged) -> Diagnostic | None:
    """Vibration on a finishing operation leaves its marks."""
    line = judged.report.plan.chain.first
    verdict = judged.report.verdict
    kinds = [o.kind for o in judged.operations if o.first_line <= line < o.last_line]
    if not kinds or kinds[0] not in (Kind.FINISH, Kind.SEMI_FINISH):
        return None
    peak = max(verdict.peak_thickness, verdict.ramp_peak_thickness)
    message = (
        f"vibration on a finishing operation: peak chip {peak:z.2f} times the feed,"
        f" theoretical roughness {verdict.roughness_factor:z.1f} times as high"
    )
    asked_by = judged.report.plan.chain.requests[0].asked_by
    share = 100.0 / math.sqrt(verdict.roughness_factor)  # theoretical roughness goes with the feed squared
    help_text = f"{_WITHOUT[asked_by]}; with {share:z.0f}% of the feed it is as smooth as without vibration"
    return judged.diagnose(FINISHING, message, help_text, Severity.WARNING)


_WITHOUT: dict[AskedBy, str] = {
    "word": "take the words that ask for it out of this block",
    "directive": "write (VIB OFF) before this cut",
    "profile": 'write (VIB OFF) before this cut, or leave "finish" and "semi-finish" out of vibration.only',
}


def _overloaded(judged: Judged) -> Diagnostic | None:
    """The motion that the axes make of their command needs more than they have."""
    report = judged.report
    needs = report.acceleration_mm_s2
    if not report.is_overloaded:
        return None
    axes = " and ".join(report.plan.chain.axes)
    message = (
        f"the strokes need {needs / 1000.0:.3g} m/s2 behind the filters of the axes,"
        f" {axes} has {report.allowed_mm_s2 / 1000.0:.3g}"
    )
    works = judged.ways_out()
    help_text = f"works: {works}" if works else "take a smaller stroke or a lower f"
    return judged.diagnose(OVERLOADED, message, help_text, Severity.ERROR)


_CAN_BE_ERRORS: tuple[Callable[[Judged], Diagnostic | None], ...] = (
    _missed,
    _unbroken,
    _weak_axes,
    _overloaded,
)
_RULES = (*_CAN_BE_ERRORS, _surface_speed, _finishing, *LARGE_CHANGES)
