"""The whole way of a program, once, in order: read, interpret, plan, apply, verify."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from chipbreak.editing.edits import Edit
from chipbreak.editing.render import render
from chipbreak.editing.restore import restore
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.operations.kinds import Kind, KindRules
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import Operation, operations_of
from chipbreak.passes import check_tools, speeds
from chipbreak.settings import Settings, SettingsError
from chipbreak.syntax.parse import UNREADABLE, parse
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, RefusalError, Severity, has_errors
from chipbreak.text.source import Source, read
from chipbreak.tools.program import tool_table_for_checks
from chipbreak.units import MM_PER_INCH
from chipbreak.verify import verify
from chipbreak.vibration.request import requests_of

if TYPE_CHECKING:
    from chipbreak.vibration.cut_edit import PlannedCut
    from chipbreak.vibration.measure import CutReport

UNBROKEN, FINISHING, SERVO, UNREAD_WORD = "VIB060", "VIB061", "VIB062", "MOD001"
MISSED, TOO_FAST = "VIB034", "VIB064"
_MOST_ALIKE = 5
_MOST_ADVISED = 3  # what works is tried for the first of many cuts that fail alike
# How much more surface speed than G96 asked for is said aloud.
_MUCH_FASTER = 1.25


class Result(NamedTuple):
    """What became of a program.

    ``data`` is the new program.  ``changed`` says whether it differs from what came in.
    """

    source: Source
    data: bytes
    changed: bool
    diagnostics: tuple[Diagnostic, ...]
    cuts: tuple[CutReport, ...]
    operations: tuple[Operation, ...]
    edits: tuple[Edit, ...]


def rewrite(
    data: bytes, settings: Settings, name: str = "<stdin>", *, allow_unbroken: bool = False
) -> Result:
    """Filter a program.

    A program that was filtered before is put back first, so a second run with the same profile changes
    nothing.  Raises ProgramRejectedError when it has an error in it, and SelfCheckError when the result does
    not do what was promised; then nothing may be written.  Raises SettingsError for a profile whose rules or
    calls cannot be used, and ToolFileError for a file of tools that cannot be read.
    """
    source = restore(read(data, name))
    return _run(source, data, settings, output=None, allow_unbroken=allow_unbroken)


def verify_filtered(data: bytes, settings: Settings, name: str = "<stdin>") -> Result:
    """Judge a filtered program as it stands, instead of writing a new one.

    Raises what :func:`rewrite` raises; SelfCheckError also for a program that another profile or version has
    written, whose changes are not those that would be made now.
    """
    source = restore(read(data, name))
    return _run(source, data, settings, output=data, allow_unbroken=True)


def _run(
    source: Source, data: bytes, settings: Settings, *, output: bytes | None, allow_unbroken: bool
) -> Result:
    """All stages on an unfiltered source; ``output`` is the program to judge, None to write one."""
    interpreted = interpret(parse(source), settings)
    diagnostics = interpreted.program.unreadable() + unread_words(interpreted)
    operations, check_edits, found = _tool_checks(interpreted, settings)
    diagnostics += found
    speed_edits, found = speeds.plan(interpreted, settings)
    diagnostics += found
    checks_at = [edit.first for edit in check_edits]
    planned, vibration_edits, found = _vibration(
        interpreted, settings, checks_at, allow_unbroken=allow_unbroken
    )
    diagnostics += found
    if has_errors(diagnostics):
        raise ProgramRejectedError(in_place_order(diagnostics))
    edits = [*speed_edits, *vibration_edits, *check_edits]
    if output is None:
        output = b"".join(render(interpreted.program, edits, settings)) if edits else source.data
    cuts = verify(interpreted, output, edits, planned) if edits or output != source.data else []
    diagnostics += _chip_diagnostics(interpreted, cuts, operations, allow_unbroken=allow_unbroken)
    if has_errors(diagnostics):
        raise ProgramRejectedError(in_place_order(diagnostics))
    return Result(
        source=source,
        data=output,
        changed=output != data,
        diagnostics=in_place_order(diagnostics),
        cuts=tuple(cuts),
        operations=tuple(operations),
        edits=tuple(edits),
    )


def _tool_checks(
    interpreted: InterpretedProgram, settings: Settings
) -> tuple[list[Operation], list[Edit], list[Diagnostic]]:
    """Operations and the checks between them.  Raises SettingsError for unusable rules or calls."""
    try:
        main = main_program(interpreted)
        operations = operations_of(interpreted, main, KindRules.from_profile(settings.operations))
        tools = tool_table_for_checks(interpreted)
        edits, diagnostics = check_tools.plan(interpreted, main, operations, settings, tools)
        diagnostics = [*tools.diagnostics, *diagnostics] if settings.checks.enabled else diagnostics
    except RefusalError as error:
        wrong = Diagnostic(error.code, Severity.ERROR, f"{settings.name}: {error.message}", error.help)
        raise SettingsError(wrong) from None
    return operations, edits, diagnostics


def _vibration(
    interpreted: InterpretedProgram, settings: Settings, checks_at: Sequence[int], *, allow_unbroken: bool
) -> tuple[Sequence[PlannedCut], Sequence[Edit], list[Diagnostic]]:
    """The vibrated cuts and their edits; a program that asks for none does not load what plans them."""
    requests, diagnostics = requests_of(interpreted)
    if not requests:
        return (), (), diagnostics
    from chipbreak.passes import vibrate

    plan = vibrate.plan(interpreted, settings, requests, checks_at=checks_at, allow_unbroken=allow_unbroken)
    return plan.cuts, plan.edits, diagnostics + list(plan.diagnostics)


def in_place_order(diagnostics: list[Diagnostic]) -> tuple[Diagnostic, ...]:
    """By line; of many alike warnings the first few stand for all."""
    # An unreadable line, or a word, that is an error anyway need not be warned of as well.
    errors = {d.place for d in diagnostics if d.place and d.severity is Severity.ERROR}
    lines = {place.line for place in errors}
    known = {UNREADABLE: lambda d: d.place.line in lines, UNREAD_WORD: lambda d: d.place in errors}
    said = [d for d in diagnostics if not (d.place and d.code in known and known[d.code](d))]
    ordered = sorted(said, key=lambda d: d.place.line if d.place else 0)
    seen: dict[str, int] = {}
    kept: list[Diagnostic] = []
    for diagnostic in ordered:
        seen[diagnostic.code] = seen.get(diagnostic.code, 0) + 1
        if diagnostic.severity is Severity.ERROR or seen[diagnostic.code] <= _MOST_ALIKE:
            kept.append(diagnostic)
    for index, diagnostic in enumerate(kept):
        more = seen[diagnostic.code] - _MOST_ALIKE
        if more > 0 and diagnostic.severity is not Severity.ERROR:
            is_last = all(d.code != diagnostic.code for d in kept[index + 1 :])
            if is_last:
                message = f"{diagnostic.message} (and {more} more like this)"
                kept[index] = diagnostic._replace(message=message)
    return tuple(kept)


def unread_words(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """Words in plain moves that nothing reads: passed through, but said."""
    found = []
    for effect in interpreted.effects:
        for word in effect.unread:
            shown = effect.block.text[word.start : word.end]
            found.append(
                interpreted.program.diagnose(
                    effect.block.line,
                    UNREAD_WORD,
                    f"{shown} has no meaning here that this profile knows",
                    "it is passed through as it is; check the letter",
                    at=(word.start, word.end),
                    severity=Severity.WARNING,
                )
            )
    return found


def _chip_diagnostics(
    interpreted: InterpretedProgram,
    cuts: list[CutReport],
    operations: list[Operation],
    *,
    allow_unbroken: bool,
) -> list[Diagnostic]:
    """Cuts that were asked to break chips and do not, and vibration on a finishing operation."""
    found = list[Diagnostic]()
    for checked in cuts:
        cut, verdict = checked.plan, checked.verdict
        line = cut.chain.first
        advise = sum(d.code in (UNBROKEN, MISSED) for d in found) < _MOST_ADVISED
        if checked.misses_plan:
            found.append(_missed(interpreted, checked, advise=advise))
        elif not verdict.breaks:
            # Who lets whole chips pass does not wait for what would break them.
            advise = advise and not allow_unbroken
            found.append(_unbroken(interpreted, checked, allow_unbroken=allow_unbroken, advise=advise))
        found += _servo_diagnostics(interpreted, checked, allow_unbroken=allow_unbroken)
        found += _surface_speed(interpreted, checked)
        kind = next((o.kind for o in operations if o.first_line <= line < o.last_line), Kind.UNKNOWN)
        if kind in (Kind.FINISH, Kind.SEMI_FINISH):
            peak = max(verdict.peak_thickness, verdict.ramp_peak_thickness)
            message = (
                f"vibration on a finishing operation: peak chip {peak:.2f} times the feed,"
                f" theoretical roughness {verdict.roughness_factor:.1f} times as high"
            )
            help_text = "write (VIB OFF) before the finishing cut, or lower its feed"
            found.append(
                interpreted.program.diagnose(line, FINISHING, message, help_text, severity=Severity.WARNING)
            )
    return found


def _surface_speed(interpreted: InterpretedProgram, checked: CutReport) -> list[Diagnostic]:
    """A warning where a cut of G96 grows in diameter, and the speed of its start is far too high for that."""
    cut, state = checked.plan, checked.plan.chain.before
    if state.modes.speed_mode != "surface" or not checked.clearances or state.speed is None:
        return []
    asked_m_min = state.speed.value * (MM_PER_INCH * 12.0 / 1000.0 if state.is_inch else 1.0)
    diameter_mm = checked.clearances[0].diameter_mm
    made_m_min = math.pi * diameter_mm * cut.solution.speed_rpm / 1000.0
    if made_m_min <= _MUCH_FASTER * asked_m_min:
        return []
    message = (
        f"G96 S{state.speed.text} runs as S{cut.solution.speed_rpm:g}: at diameter {diameter_mm:.4g} mm"
        f" that is {made_m_min:.0f} m/min, {asked_m_min:.0f} were asked for"
    )
    help_text = "cut towards the centre, or give this cut N and a lower f, or a lower clamp (G50 S)"
    return [
        interpreted.program.diagnose(cut.chain.first, TOO_FAST, message, help_text, severity=Severity.WARNING)
    ]


def _missed(interpreted: InterpretedProgram, checked: CutReport, *, advise: bool) -> Diagnostic:
    """The control cannot keep to the plan: corners and bends of the path cost it time."""
    from chipbreak.vibration.ways_out import ways_out

    cut, verdict = checked.plan, checked.verdict
    planned_s = cut.wave.duration_s + cut.end_stand_s
    message = (
        f"the control would take {checked.duration_s:.2f} s for this cut of {planned_s:.2f} s"
        f" and make N {verdict.per_rev:.3f} of {cut.solution.per_rev:.3f}"
    )
    if len(cut.path.legs) > 1 or cut.path.arcs[0] is not None:
        message += ": it rests at bends of the path"
    elif cut.wave.form == "tick":
        message += ": strokes of several blocks do not keep their times"
    works = ways_out(interpreted, interpreted.settings, checked) if advise else ""
    help_text = f"works: {works}" if works else "ask for a lower frequency, or vibrate each block on its own"
    return interpreted.program.diagnose(cut.chain.first, MISSED, message, help_text)


def _unbroken(
    interpreted: InterpretedProgram, checked: CutReport, *, allow_unbroken: bool, advise: bool
) -> Diagnostic:
    """Why the chips stay whole, and what would break them."""
    from chipbreak.vibration.ways_out import ways_out

    cut, verdict = checked.plan, checked.verdict
    message = (
        f"this cut would not break chips: with a stroke of {cut.wave.stroke_mm:.4f} mm at N"
        f" {verdict.per_rev or cut.solution.per_rev:.3f} the weakest vibration has a margin of"
        f" {verdict.margin:.2f}, 1 is needed"
    )
    works = ways_out(interpreted, interpreted.settings, checked) if advise else ""
    way_out = f"works: {works}" if works else "take another N, less feed, or leave Q and A out"
    help_text = f"{way_out}; --allow-unbroken lets it pass"
    severity = Severity.WARNING if allow_unbroken else Severity.ERROR
    return interpreted.program.diagnose(cut.chain.first, UNBROKEN, message, help_text, severity=severity)


def _servo_diagnostics(
    interpreted: InterpretedProgram, checked: CutReport, *, allow_unbroken: bool
) -> list[Diagnostic]:
    """A cut whose stroke would break chips, if the servo did not leave too little of it."""
    share, margin = checked.servo_share, checked.verdict.margin
    if share is None or margin < 1.0 or margin * share >= 1.0:
        return []
    message = (
        f"the servo leaves {share:.0%} of the stroke at {checked.plan.solution.frequency_hz:.4g} Hz:"
        f" the margin of {margin:.2f} becomes {margin * share:.2f}, and the chips do not break"
    )
    help_text = f"take a lower f, or vibration.margin {1.05 / share:.2f}, if the machine allows such a stroke"
    severity = Severity.WARNING if allow_unbroken else Severity.ERROR
    line = checked.plan.chain.first
    return [interpreted.program.diagnose(line, SERVO, message, help_text, severity=severity)]
