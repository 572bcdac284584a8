"""A report as lines of text.  What is said of a cut is a tuple of small rules, each a line or none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from chipbreak.report.summary import clock
from chipbreak.text.encoding import escaped
from chipbreak.units import MS_PER_S, S_PER_MIN

if TYPE_CHECKING:
    from chipbreak.report.model import (
        CycleTime,
        ExplainedCheck,
        ExplainedCut,
        ExplainedCycle,
        ExplainedLeft,
        ExplainedLoop,
        ExplainedOperation,
        ExplainedUnasked,
        Report,
    )

# Chips of the ramps are said where they are thicker than the others by more than rounding makes them.
_FUZZ = 1e-6
_ENOUGH_LOOKS = 60  # a vibration
_OTHER_STROKE = 0.03  # of the planned stroke, from which on the reached one is told
_MUCH_THICKER = 1.01
_LEAST_DRIFT_STEPS = 0.001
_MOST_UNTIMED = 20
_LONG_CHECKS_S = 120.0  # together, from which on settings are named by which they take less
_MUCH_SHORTER = 0.8
_MEMBERS = {"tool": "the tool (tool post)", "work": "the work (spindle carrier)"}


def report_lines(report: Report) -> Iterator[str]:
    """Every vibrated cut, operation and check, with the reasons; nothing in them that a terminal obeys."""
    return map(escaped, _lines_of(report))


def _lines_of(report: Report) -> Iterator[str]:
    yield f"{report.file}, profile {report.profile}"
    yield ""
    yield f"Vibrated cuts: {len(report.cuts) or 'none'}{_nothing_asks(report)}"
    for cut in report.cuts:
        yield from _cut(cut)
    yield from _cycles(report)
    if report.left:
        yield ""
        yield f"Left as they were: {len(report.left)}"
        for left in report.left:
            yield from _left(left)
    if report.unasked and (report.cuts or report.left):
        yield ""
        yield "Not asked to vibrate:"
        yield from map(_unasked, report.unasked)
    yield ""
    yield f"Operations: {len(report.operations) or 'none'}"
    for number, operation in enumerate(report.operations, 1):
        yield f"  {number}. {_operation(operation)}"
    yield ""
    yield f"Tool checks: {len(report.checks) or 'none'}{_together(report)}"
    yield from _shorter(report)
    for check in report.checks:
        yield f"  {_check(check)}"
    if report.time is not None:
        yield ""
        yield from _time(report.time)


def about_line(report: Report, line: int) -> Iterator[str]:
    """What is said of the cuts and the operation at a line of the program."""
    said: list[str] = []
    for cut in report.cuts:
        if cut.first_line <= line <= cut.last_line:
            said += _cut(cut)
    for left in report.left:
        if left.first_line <= line <= left.last_line:
            said += _left(left)
    for operation in report.operations if said else ():
        if operation.first_line <= line <= operation.last_line:
            said.append(f"  {_operation(operation)}")
    return map(escaped, (one.removeprefix("  ") for one in said))


def _cycles(report: Report) -> Iterator[str]:
    if report.cycles:
        yield ""
        yield f"Cycles written out: {len(report.cycles)}"
        yield from map(_cycle, report.cycles)


def _nothing_asks(report: Report) -> str:
    """How to ask, where nobody does: no silent nothing."""
    if report.cuts or report.left:
        return ""
    return "; nothing asks: N1.5 in a cut, (VIB N1.5) before it, or vibration.n in the profile would"


def _unasked(unasked: ExplainedUnasked) -> str:
    blocks = f"{unasked.blocks} blocks that cut" if unasked.blocks > 1 else "1 block that cuts"
    lines = _lines(unasked.first_line, unasked.last_line)
    return f"  {unasked.operation}, {lines}: {blocks}: {unasked.reason}"


def _time(time: CycleTime) -> Iterator[str]:
    yield f"Time of the program: {clock(time.before_s)} as programmed, {clock(time.after_s)} filtered"
    for part in time.parts:
        changed = clock(part.before_s) != clock(part.after_s)
        after = f" -> {clock(part.after_s)}" if changed else ""
        yield f"  {part.name:14}{clock(part.before_s)}{after}"
    for assumed in time.assumed:
        key = f": {assumed.key} in the profile says yours" if assumed.key else ""
        yield f"  {'assumed':14}{assumed.what}{key}"
    for one in time.untimed[:_MOST_UNTIMED]:
        yield f"  {'not timed':14}line {one.line}: {one.why}"
    if len(time.untimed) > _MOST_UNTIMED:
        yield f"  {'not timed':14}and {len(time.untimed) - _MOST_UNTIMED} more lines"


def _left(left: ExplainedLeft) -> Iterator[str]:
    why = f"{left.code}, {left.reason}" if left.code else left.reason
    yield f"  {_lines(left.first_line, left.last_line)}: {left.block}"
    yield f"    {'asked':9}by {'a comment' if left.asked_by == 'directive' else 'the profile'}"
    yield f"    {'because':9}{why}"
    yield f"    {'way out':9}{left.way_out}"


def _cycle(cycle: ExplainedCycle) -> str:
    """``line 7: G71 P10 Q20: 9 passes of 2 mm, 8 vibrated cuts, 1:02.0 as programmed, 1:05.0 filtered``."""
    passes = f"{cycle.passes} passes" if cycle.passes > 1 else "1 pass"
    depth = "" if cycle.depth_mm is None else f" of {cycle.depth_mm:g} mm"
    cuts = f"{cycle.vibrated} vibrated cuts" if cycle.vibrated != 1 else "1 vibrated cut"
    times = f"{clock(cycle.before_s)} as programmed, {clock(cycle.after_s)} filtered"
    return f"  line {cycle.line}: {cycle.block}: {passes}{depth}, {cuts}, {times}"


def _lines(first: int, last: int) -> str:
    return f"line {first}" if first == last else f"lines {first} to {last}"


def _operation(operation: ExplainedOperation) -> str:
    tool = f"T{operation.tool}" if operation.tool is not None else "no tool"
    label = f" {operation.label!r}" if operation.label else ""
    lines = f"lines {operation.first_line} to {operation.last_line}"
    return f"{tool}, {operation.kind}{label}, {lines}: {operation.reason}"


def _check(check: ExplainedCheck) -> str:
    where = "at the end" if check.is_at_end else f"before line {check.line}"
    takes = "" if check.duration_s is None else f" (about {check.duration_s:z.0f} s)"
    return f"{where}: {check.title}{takes}: {check.reason}"


def _together(report: Report) -> str:
    """How long all checks take, and which share of the cycle that is."""
    known = [check.duration_s for check in report.checks if check.duration_s is not None]
    if not known:
        return ""
    whole = sum(known)
    said = f", about {whole:z.0f} s together"
    if report.time is None:
        return said
    share = whole / report.time.after_s
    return f"{said}, {100.0 * share:z.0f} % of the filtered program ({report.time.after_s:z.0f} s)"


def _shorter(report: Report) -> Iterator[str]:
    """Settings by which long checks would take less."""
    whole_s = sum(check.duration_s or 0.0 for check in report.checks)
    if whole_s < _LONG_CHECKS_S:
        return
    for setting in report.checks[0].otherwise_s:
        seconds = sum(check.otherwise_s[setting] for check in report.checks)
        if seconds < _MUCH_SHORTER * whole_s:
            yield f"  about {seconds:z.0f} s with {setting}"


def _cut(cut: ExplainedCut) -> Iterator[str]:
    yield f"  {_lines(cut.first_line, cut.last_line)}: {cut.block}"
    for word, rule in _RULES:
        yield from (f"    {word or cut.motion.name:9}{text}" for text in rule(cut))


def _asked(cut: ExplainedCut) -> Iterator[str]:
    yield ", ".join(f"{'f' if k == 'F' else k} {v.value:g} ({v.origin})" for k, v in cut.given.items())


def _because(cut: ExplainedCut) -> Iterator[str]:
    yield from cut.reasons


def _runs(cut: ExplainedCut) -> Iterator[str]:
    period_ms = cut.period_s * MS_PER_S
    yield f"S {cut.speed_rpm:g} rpm, N {cut.per_rev:.4g}, f {cut.frequency_hz:.5g} Hz ({period_ms:g} ms)"


def _motion(cut: ExplainedCut) -> Iterator[str]:
    yield cut.motion.size


def _reaches(cut: ExplainedCut) -> Iterator[str]:
    per_rev = cut.verdict.per_rev
    if per_rev > 0.0:
        reached_hz = per_rev * cut.speed_rpm / S_PER_MIN
        stroke_mm = cut.verdict.stroke_mm
        is_other = abs(stroke_mm - cut.stroke_mm) > _OTHER_STROKE * cut.stroke_mm
        stroke = f", stroke {stroke_mm:.4g} mm" if is_other else ""
        yield f"N {per_rev:.4g}, {reached_hz:.5g} Hz{stroke} (planner model {cut.control})"
    elif cut.motion.without_count:
        yield cut.motion.without_count


def _verdict(cut: ExplainedCut) -> Iterator[str]:
    verdict = cut.verdict
    chips = "chips break" if verdict.breaks else "CHIPS DO NOT BREAK"
    if cut.unproven and verdict.breaks:
        chips = "unproven: chips would break on a control that follows the blocks exactly"
    if cut.on_edge:
        chips = f"unproven: chips {'would' if verdict.breaks else 'would not'} break by as little as is known"
    off = f" +- {cut.margin_off:z.2f}" if cut.margin_off else ""
    longest = _chip(verdict.longest_chip_rev, verdict.longest_chip_mm)
    first = _chip(verdict.first_chip_rev, verdict.first_chip_mm)
    yield (
        f"{chips}, margin {verdict.margin:z.2f}{off}, {verdict.chips_per_rev:.3g} per revolution,"
        f" longest {longest}, first {first}"
    )


def _chip(revolutions: float, length_mm: float | None) -> str:
    return f"{revolutions:z.2f} rev" + ("" if length_mm is None else f" ({length_mm:z.0f} mm)")


def _load(cut: ExplainedCut) -> Iterator[str]:
    verdict = cut.verdict
    ramps = ""
    if verdict.ramp_peak_thickness > _MUCH_THICKER * verdict.peak_thickness:
        ramps = f" ({verdict.ramp_peak_thickness:z.2f} while the stroke grows or shrinks)"
    yield (
        f"{verdict.cut_share:.0%} of the time in the cut, peak chip {verdict.peak_thickness:z.2f}"
        f" x feed{ramps}, theoretical roughness x {verdict.roughness_factor:z.1f}"
    )


def _band(cut: ExplainedCut) -> Iterator[str]:
    if cut.verdict.speed_band_rpm:
        low, high = cut.verdict.speed_band_rpm
        ties = ", which feed per revolution ties to the spindle: N stays"
        # Rounded towards the speed of the cut: what is said breaks.
        yield (
            f"breaks from {math.ceil(low - _FUZZ)} to {math.floor(high + _FUZZ)} rpm at this frequency"
            f"{ties if cut.follows_spindle else ' and feed per minute'}"
        )
    if cut.override_band:
        least, most = cut.override_band
        # Rounded towards 100 %: what is said breaks.
        percents = f"{math.ceil(100.0 * least - _FUZZ)}% to {math.floor(100.0 * most + _FUZZ)}%"
        with_it = "which this cut holds at 100%" if cut.holds_override else "which takes N with it"
        yield f"breaks from {percents} of feed override, {with_it}"


def _machine(cut: ExplainedCut) -> Iterator[str]:
    needs = cut.motion.need
    if cut.acceleration_share is not None and cut.acceleration_share > 0.0:
        needs += f", {cut.acceleration_share:.0%} of what there is"
    if cut.servo_share is not None:
        real_mm = cut.verdict.stroke_mm
        needs += f", the axes make {real_mm:.4g} mm of the stroke ({cut.servo_share:.0%})"
    if cut.delay_s is not None:
        needs += f", {cut.delay_s * MS_PER_S:.3g} ms late"
    if cut.path_error_mm:
        needs += f" and up to {cut.path_error_mm:z.4f} mm off the path"
    if cut.looks is not None and cut.looks < _ENOUGH_LOOKS:
        needs += f", looked at {cut.looks:z.0f} times a vibration only, for its length"
    if cut.flank_clearance:
        used = ", ".join(f"{c.deg:z.2f} at {c.diameter_mm:.4g} mm" for c in cut.flank_clearance)
        needs += f"; degrees of flank clearance that the forward stroke uses: {used}"
    yield needs


def _moved(cut: ExplainedCut) -> Iterator[str]:
    if cut.moved:
        moved = cut.moved.items()
        yield ", ".join(f"{axis} ({one.letter} words) by {_MEMBERS[one.by]}" for axis, one in moved)


def _output(cut: ExplainedCut) -> Iterator[str]:
    ends = f", stands {cut.end_stand_s * MS_PER_S:z.0f} ms at its end" if cut.end_stand_s else ""
    peak_mm_min = cut.verdict.peak_speed_mm_s * S_PER_MIN
    was = "" if cut.programmed_s is None else f" ({cut.programmed_s:z.2f} s as programmed)"
    yield f"{cut.moves} moves, {cut.duration_s:z.2f} s{was}, axis up to {peak_mm_min:z.0f} mm/min{ends}"


def _loop(cut: ExplainedCut) -> Iterator[str]:
    """What repeats, and how many blocks that leaves."""
    if cut.output_form != "loop":
        return
    if not cut.loops:
        yield "none: no straight part of full stroke repeats often enough"
        return
    drift = max(loop.drift_steps for loop in cut.loops)
    is_off = drift > _LEAST_DRIFT_STEPS
    off = f", points up to {0.5 + drift / 2.0:z.2f} steps from the exact motion" if is_off else ""
    yield f"{', '.join(map(_repeats, cut.loops))}; {cut.written_moves} blocks of motion{off}"


def _repeats(loop: ExplainedLoop) -> str:
    return f"{loop.vibrations} vibration{'s' * (loop.vibrations > 1)} {loop.passes} times"


# A rule without a word is under the name of the cut's motion.
_RULES: tuple[tuple[str, Callable[[ExplainedCut], Iterator[str]]], ...] = (
    ("asked", _asked),
    ("because", _because),
    ("runs", _runs),
    ("", _motion),
    ("reaches", _reaches),
    ("verdict", _verdict),
    ("load", _load),
    ("band", _band),
    ("machine", _machine),
    ("moved", _moved),
    ("output", _output),
    ("loop", _loop),
)
