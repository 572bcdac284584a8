"""What a run did, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from chipbreak.edits import Edit
from chipbreak.passes import CHECK_TOOLS
from chipbreak.pipeline import Result
from chipbreak.units import MS_PER_S, S_PER_MIN

if TYPE_CHECKING:
    from chipbreak.measure import CheckedCut


def explain_text(result: Result, profile: str) -> Iterator[str]:
    """Every vibrated cut, operation and check, with the reasons."""
    yield f"{result.source.name}, profile {profile}"
    yield ""
    yield f"Vibrated cuts: {len(result.cuts) or 'none'}"
    for cut in result.cuts:
        yield from _cut_text(result, cut)
    yield ""
    yield f"Operations: {len(result.operations) or 'none'}"
    for index, operation in enumerate(result.operations, 1):
        tool = f"T{operation.tool}" if operation.tool is not None else "no tool"
        first, last = operation.first_line + 1, operation.last_line
        label = f" {operation.label!r}" if operation.label else ""
        yield f"  {index}. {tool}, {operation.kind.value}{label}, lines {first} to {last}: {operation.reason}"
    yield ""
    checks = _checks(result)
    yield f"Tool checks: {len(checks) or 'none'}"
    for edit in checks:
        yield f"  before line {result.source.place(edit.first).line}: {edit.title}: {edit.reason}"


def _checks(result: Result) -> list[Edit]:
    return [edit for edit in result.edits if edit.pass_name == CHECK_TOOLS]


def _cut_text(result: Result, checked: CheckedCut) -> Iterator[str]:
    cut, verdict, solution = checked.planned.cut, checked.verdict, checked.planned.cut.solution
    block = cut.chain.requests[0].step.block.text.strip()
    yield f"  {_lines(result, checked)}: {block}"
    asked = ", ".join(f"{'f' if k == 'F' else k} {g.value:g} ({g.origin})" for k, g in cut.given.items())
    yield f"    asked    {asked}"
    for reason in cut.reasons:
        yield f"    because  {reason}"
    yield (
        f"    runs     S {solution.speed_rpm:g} rpm, N {solution.per_rev:.4g},"
        f" f {solution.frequency_hz:.5g} Hz ({solution.period.period_s * MS_PER_S:g} ms)"
    )
    ratio = cut.cut.stroke_mm / cut.cut.feed_mm_rev
    yield (
        f"    stroke   {cut.cut.stroke_mm:.4g} mm = {ratio:.3g} x feed {cut.cut.feed_mm_rev:.4g} mm/rev,"
        f" {cut.cut.waveform}, forward share {cut.cut.alpha_share:.3g}"
    )
    if verdict.per_rev > 0.0:
        reached_hz = verdict.per_rev * solution.speed_rpm / S_PER_MIN
        yield f"    reaches  N {verdict.per_rev:.4g}, {reached_hz:.5g} Hz (planner model {checked.control})"
    chips = "chips break" if verdict.breaks else "CHIPS DO NOT BREAK"
    longest = _chip(verdict.longest_chip_rev, verdict.longest_chip_mm)
    first = _chip(verdict.first_chip_rev, verdict.first_chip_mm)
    yield (
        f"    verdict  {chips}, margin {verdict.margin:.2f}, {verdict.chips_per_rev:.3g} per revolution,"
        f" longest {longest}, first {first}"
    )
    yield (
        f"    load     {verdict.cut_share:.0%} of the time in the cut, peak chip {verdict.peak_thickness:.2f}"
        f" x feed, theoretical roughness x {verdict.roughness_factor:.1f}"
    )
    if verdict.speed_band_rpm:
        low, high = verdict.speed_band_rpm
        yield f"    band     breaks from {low:.0f} to {high:.0f} rpm at this frequency"
    needs = f"    machine  needs {checked.acceleration_mm_s2:.0f} mm/s2"
    if checked.servo_share is not None:
        needs += f", the servo leaves {checked.servo_share:.0%} of the stroke"
    if checked.clearance_deg is not None:
        needs += f"; the forward stroke uses {checked.clearance_deg:.2f} degrees of flank clearance"
    yield needs
    yield (
        f"    output   {checked.move_count} moves, {checked.duration_s:.2f} s,"
        f" axis up to {verdict.peak_speed_mm_s * 60.0:.0f} mm/min"
    )


def _chip(revolutions: float, length_mm: float | None) -> str:
    return f"{revolutions:.2f} rev" + ("" if length_mm is None else f" ({length_mm:.0f} mm)")


def _lines(result: Result, checked: CheckedCut) -> str:
    chain = checked.planned.cut.chain
    first = result.source.place(chain.first).line
    last = result.source.place(chain.last - 1).line
    return f"line {first}" if first == last else f"lines {first} to {last}"


def explain_json(result: Result, profile: str) -> dict[str, Any]:
    """The same facts for a program to read; lengths in mm, speeds in rpm and mm/s, times in s."""
    return {
        "file": result.source.name,
        "profile": profile,
        "changed": result.changed,
        "cuts": [_cut_json(result, cut) for cut in result.cuts],
        "operations": [
            {
                "tool": o.tool,
                "kind": o.kind.value,
                "label": o.label,
                "reason": o.reason,
                "first_line": o.first_line + 1,
                "last_line": o.last_line,
            }
            for o in result.operations
        ],
        "checks": [
            {"line": result.source.place(e.first).line, "title": e.title, "reason": e.reason}
            for e in _checks(result)
        ],
        "diagnostics": [d.as_json() for d in result.diagnostics],
    }


def _cut_json(result: Result, checked: CheckedCut) -> dict[str, Any]:
    cut, verdict, solution = checked.planned.cut, checked.verdict, checked.planned.cut.solution
    return {
        "first_line": result.source.place(cut.chain.first).line,
        "last_line": result.source.place(cut.chain.last - 1).line,
        "given": {k: {"value": g.value, "origin": g.origin} for k, g in cut.given.items()},
        "reasons": list(cut.reasons),
        "speed_rpm": solution.speed_rpm,
        "per_rev": solution.per_rev,
        "frequency_hz": solution.frequency_hz,
        "feed_mm_rev": cut.cut.feed_mm_rev,
        "stroke_mm": cut.cut.stroke_mm,
        "waveform": cut.cut.waveform,
        "alpha_share": cut.cut.alpha_share,
        "moves": checked.move_count,
        "duration_s": checked.duration_s,
        "control": checked.control,
        "acceleration_mm_s2": checked.acceleration_mm_s2,
        "servo_share": checked.servo_share,
        "clearance_deg": checked.clearance_deg,
        "verdict": {name: getattr(verdict, name) for name in verdict.__dataclass_fields__},
    }
