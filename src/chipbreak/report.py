"""What a run did, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from chipbreak.editing.edits import Edit
from chipbreak.passes import CHECK_TOOLS
from chipbreak.pipeline import Result
from chipbreak.settings import Settings
from chipbreak.units import MS_PER_S, S_PER_MIN

if TYPE_CHECKING:
    from chipbreak.vibration.loop import Loop
    from chipbreak.vibration.measure import CutReport


# Chips of the ramps are said where they are thicker than the others by more than rounding makes them.
_MUCH_THICKER = 1.01
_MEMBERS = {1: "the tool (tool post)", -1: "the work (spindle carrier)"}


def explain_text(result: Result, settings: Settings) -> Iterator[str]:
    """Every vibrated cut, operation and check, with the reasons."""
    yield f"{result.source.name}, profile {settings.name}"
    yield ""
    yield f"Vibrated cuts: {len(result.cuts) or 'none'}"
    for cut in result.cuts:
        yield from _cut_text(result, cut, settings)
    yield ""
    yield f"Operations: {len(result.operations) or 'none'}"
    for index, operation in enumerate(result.operations, 1):
        tool = f"T{operation.tool}" if operation.tool is not None else "no tool"
        first = _line_number(result, operation.first_line)
        last = _line_number(result, operation.last_line - 1)
        label = f" {operation.label!r}" if operation.label else ""
        yield f"  {index}. {tool}, {operation.kind.value}{label}, lines {first} to {last}: {operation.reason}"
    yield ""
    checks = _checks(result)
    yield f"Tool checks: {len(checks) or 'none'}"
    for edit in checks:
        yield f"  {_before(result, edit)}: {edit.title}: {edit.reason}"


def _before(result: Result, edit: Edit) -> str:
    is_end = edit.first == result.source.line_count
    return "at the end" if is_end else f"before line {_line_number(result, edit.first)}"


def _line_number(result: Result, line: int) -> int:
    """The line in the user's file; one behind the last where a change stands at the end of the program."""
    count = result.source.line_count
    return result.source.place(line).line if line < count else result.source.place(count - 1).line + 1


def _checks(result: Result) -> list[Edit]:
    return [edit for edit in result.edits if edit.pass_name == CHECK_TOOLS]


def _cut_text(result: Result, checked: CutReport, settings: Settings) -> Iterator[str]:
    cut, verdict, solution = checked.plan, checked.verdict, checked.plan.solution
    block = cut.chain.requests[0].effect.block.text.strip()
    yield f"  {_lines(result, checked)}: {block}"
    asked = ", ".join(f"{'f' if k == 'F' else k} {g.value:g} ({g.origin})" for k, g in cut.given.items())
    yield f"    asked    {asked}"
    for reason in cut.reasons:
        yield f"    because  {reason}"
    yield (
        f"    runs     S {solution.speed_rpm:g} rpm, N {solution.per_rev:.4g},"
        f" f {solution.frequency_hz:.5g} Hz ({solution.period.period_s * MS_PER_S:g} ms)"
    )
    yield _wave(checked)
    if verdict.per_rev > 0.0:
        reached_hz = verdict.per_rev * solution.speed_rpm / S_PER_MIN
        yield f"    reaches  N {verdict.per_rev:.4g}, {reached_hz:.5g} Hz (planner model {checked.control})"
    elif told := cut.expander.told_without_count():
        yield f"    reaches  {told}"
    chips = "chips break" if verdict.breaks else "CHIPS DO NOT BREAK"
    longest = _chip(verdict.longest_chip_rev, verdict.longest_chip_mm)
    first = _chip(verdict.first_chip_rev, verdict.first_chip_mm)
    yield (
        f"    verdict  {chips}, margin {verdict.margin:.2f}, {verdict.chips_per_rev:.3g} per revolution,"
        f" longest {longest}, first {first}"
    )
    ramps = ""
    if verdict.ramp_peak_thickness > _MUCH_THICKER * verdict.peak_thickness:
        ramps = f" ({verdict.ramp_peak_thickness:.2f} while the stroke grows or shrinks)"
    yield (
        f"    load     {verdict.cut_share:.0%} of the time in the cut, peak chip {verdict.peak_thickness:.2f}"
        f" x feed{ramps}, theoretical roughness x {verdict.roughness_factor:.1f}"
    )
    if verdict.speed_band_rpm:
        low, high = verdict.speed_band_rpm
        yield f"    band     breaks from {low:.0f} to {high:.0f} rpm at this frequency"
    needs = f"    machine  {cut.expander.told_need(checked.acceleration_mm_s2)}"
    if checked.servo_share is not None:
        needs += f", the servo leaves {checked.servo_share:.0%} of the stroke"
    if checked.clearances:
        used = ", ".join(f"{c.degrees:.2f} at {c.diameter_mm:.4g} mm" for c in checked.clearances)
        needs += f"; degrees of flank clearance that the forward stroke uses: {used}"
    yield needs
    if members := _members(checked, settings):
        said = ", ".join(f"{axis} ({letter} words) by {_MEMBERS[sign]}" for axis, letter, sign in members)
        yield f"    moved    {said}"
    ends = f", stands {cut.end_dwell_s * MS_PER_S:.0f} ms at its end" if cut.end_dwell_s else ""
    yield (
        f"    output   {checked.move_count} moves, {checked.duration_s:.2f} s,"
        f" axis up to {verdict.peak_speed_mm_s * 60.0:.0f} mm/min{ends}"
    )
    loops = checked.expansion.loops
    if loops is not None:
        yield f"    loop     {_loops(loops, checked.move_count)}"


def _wave(checked: CutReport) -> str:
    """The stroke, or how far the tool feeds and how long it then dwells."""
    name, told = checked.plan.expander.told(checked.wave, checked.each_dwell_s)
    return f"    {name:8} {told}"


def _loops(loops: Sequence[Loop], move_count: int) -> str:
    """What repeats, and how many blocks that leaves."""
    if not loops:
        return "none: no straight part of full stroke repeats often enough"
    each = [f"{one.vibrations} vibration{'s' * (one.vibrations > 1)} {one.passes} times" for one in loops]
    written = move_count - sum(loop.count * (loop.passes - 1) for loop in loops)
    drift = max(loop.drift_steps for loop in loops)
    off = f", points up to {0.5 + drift / 2.0:.2f} steps from the exact motion" if drift > 0.001 else ""
    return f"{', '.join(each)}; {written} blocks of motion{off}"


def _members(checked: CutReport, settings: Settings) -> list[tuple[str, str, int]]:
    """Axis, letter and sign of the axes of a cut, where the profile says which member moves."""
    is_said = any(key.startswith("axes.") and key.endswith((".letter", ".sign")) for key in settings.origins)
    words = settings.axis_words
    axes = checked.plan.chain.axes if is_said else ""
    return [(axis, words.letters[axis], words.signs[axis]) for axis in axes]


def _chip(revolutions: float, length_mm: float | None) -> str:
    return f"{revolutions:.2f} rev" + ("" if length_mm is None else f" ({length_mm:.0f} mm)")


def _lines(result: Result, checked: CutReport) -> str:
    chain = checked.plan.chain
    first = result.source.place(chain.first).line
    last = result.source.place(chain.last - 1).line
    return f"line {first}" if first == last else f"lines {first} to {last}"


def explain_json(result: Result, settings: Settings) -> dict[str, Any]:
    """The same facts for a program to read; lengths in mm, speeds in rpm and mm/s, times in s."""
    return {
        "file": result.source.name,
        "profile": settings.name,
        "changed": result.changed,
        "cuts": [_cut_json(result, cut, settings) for cut in result.cuts],
        "operations": [
            {
                "tool": o.tool,
                "kind": o.kind.value,
                "label": o.label,
                "reason": o.reason,
                "first_line": _line_number(result, o.first_line),
                "last_line": _line_number(result, o.last_line - 1),
            }
            for o in result.operations
        ],
        "checks": [
            {"line": _line_number(result, e.first), "title": e.title, "reason": e.reason}
            for e in _checks(result)
        ],
        "diagnostics": [d.as_json() for d in result.diagnostics],
    }


def _cut_json(result: Result, checked: CutReport, settings: Settings) -> dict[str, Any]:
    cut, verdict, solution = checked.plan, checked.verdict, checked.plan.solution
    return {
        "first_line": result.source.place(cut.chain.first).line,
        "last_line": result.source.place(cut.chain.last - 1).line,
        "given": {k: {"value": g.value, "origin": g.origin} for k, g in cut.given.items()},
        "reasons": list(cut.reasons),
        "speed_rpm": solution.speed_rpm,
        "per_rev": solution.per_rev,
        "frequency_hz": solution.frequency_hz,
        "feed_mm_rev": cut.wave.feed_mm_rev,
        "stroke_mm": cut.wave.stroke_mm,
        "waveform": cut.wave.waveform,
        "alpha_share": cut.wave.alpha_share,
        "stand_s": checked.each_dwell_s,
        "end_stand_s": cut.end_dwell_s,
        "moves": checked.move_count,
        "loops": [
            {"vibrations": loop.vibrations, "passes": loop.passes, "drift_steps": loop.drift_steps}
            for loop in checked.expansion.loops or ()
        ],
        "duration_s": checked.duration_s,
        "control": checked.control,
        "acceleration_mm_s2": checked.acceleration_mm_s2,
        "servo_share": checked.servo_share,
        "flank_clearance": [{"diameter_mm": c.diameter_mm, "deg": c.degrees} for c in checked.clearances],
        "moved": {
            axis: {"letter": letter, "by": "tool" if sign > 0 else "work"}
            for axis, letter, sign in _members(checked, settings)
        },
        "verdict": {name: getattr(verdict, name) for name in verdict.__dataclass_fields__},
    }
