"""A vibrated cut as the output really commands it: its path, its time on this control, its chips."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from chipbreak.editing.restore import Region
from chipbreak.kinematics.chip_model import Verdict, judge, weakest_margin
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.machine_demand import flank_clearance_deg, least_acceleration_mm_s2
from chipbreak.kinematics.remembered import remembered
from chipbreak.kinematics.waveform import WaveformParameters, feed_override_band, full_window
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.law import ControlLaw
from chipbreak.trajectory.motion import Motion
from chipbreak.vibration.axis_steps import axis_steps_mm, end_reached, reached, rounding_mm
from chipbreak.vibration.blocks import Expansion
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.plan import CutPlan
from chipbreak.vibration.programmed import programmed
from chipbreak.vibration.readback import ReadBack, read_moves
from chipbreak.vibration.tolerances import TIME_SHARE

_COUNT_TOLERANCE = 0.01
_SAME_DWELL_S = 1e-6
# A control that stops at both ends of the cut and of its plain end needs a little longer.
_STOP_TOLERANCE_S = 0.2
_ALMOST = 1.01  # of what the axes have is not too much
_MOST_TIMES_OFF = 10.0  # its uncertainty: further no margin goes
_SETTLED_VIBRATIONS = 3.0  # of full stroke are enough to judge it by


class Clearance(NamedTuple):
    """Flank clearance used up at a diameter."""

    diameter_mm: float
    degrees: float


class Following(NamedTuple):
    """How the axes follow: their share of the commanded stroke (None of a dwell), how late, how far off.

    ``looks`` is how often a vibration their motion was looked at: less often in very long cuts.
    """

    stroke_share: float | None
    delay_s: float
    path_error_mm: float
    looks: float


@dataclass(frozen=True, eq=False)
class CutReport:
    """A vibrated cut with what its emitted moves do: seconds, and the verdict on its chips.

    ``control`` is the law by which the moves were timed; ``is_unproven``: no control is known to follow it.
    ``misses_plan``: by it the cut takes another time than planned, or has another N.
    ``acceleration_mm_s2`` is the least that can run it, behind filters that of the motion itself, and
    ``allowed_mm_s2`` what the axes have.  ``following`` says how the axes follow their command, None where
    they are taken to follow it exactly.  ``clearances`` are the flank clearance that the forward stroke uses
    up at the largest and the smallest diameter, none where the diameter is not known.  ``holds_override``:
    the operator's overrides do not count in it.  ``margin_off``: so far the margin may be off, as the numbers
    of the machine may be (``planner.uncertainty``); worked out where it is near 1.
    """

    plan: CutPlan
    expansion: Expansion
    control: str
    is_unproven: bool
    duration_s: float
    move_count: int
    verdict: Verdict
    misses_plan: bool
    acceleration_mm_s2: float
    allowed_mm_s2: float
    following: Following | None
    clearances: tuple[Clearance, ...]
    holds_override: bool = False
    margin_off: float = 0.0

    def __repr__(self) -> str:
        chips = "chips break" if self.verdict.breaks else "chips do not break"
        chips += " (unproven)" if self.is_unproven else ""
        return f"<CutReport of {self.plan!r}: {self.move_count} moves, {chips}>"

    @property
    def wave(self) -> WaveformParameters:
        """The waveform as it was planned."""
        return self.plan.wave

    @property
    def is_overloaded(self) -> bool:
        """True where the motion behind filters needs more acceleration than the axes have."""
        return self.following is not None and self.acceleration_mm_s2 > _ALMOST * self.allowed_mm_s2

    @property
    def is_on_edge(self) -> bool:
        """True where the margin is nearer to 1 than it is known."""
        return abs(self.verdict.margin - 1.0) < self.margin_off

    @property
    def is_early(self) -> bool:
        """True where the control runs the cut in less time than planned: it makes no move so slow."""
        return self.duration_s < self.expansion.planned_s * (1.0 - TIME_SHARE)

    @property
    def holds(self) -> bool:
        """True where the cut breaks its chips, runs as planned, and asks of the axes what they have."""
        return self.verdict.breaks and not self.misses_plan and not self.is_overloaded

    @property
    def programmed_s(self) -> float | None:
        """How long the cut would have taken as it was written, None where nobody knows."""
        was = programmed(self.plan)
        return None if was is None else was.duration_s

    @property
    def override_band(self) -> tuple[float, float] | None:
        """From which to which feed override its chips break; None where the tool never turns back."""
        return _override_band(self.plan, self.verdict)

    @property
    def each_dwell_s(self) -> float:
        """How long the tool dwells in each vibration, 0 where it swings."""
        return float(self.expansion.dwell_s[0]) if self.plan.expander.keeps_feed else 0.0


def _override_band(plan: CutPlan, verdict: Verdict) -> tuple[float, float] | None:
    wave = plan.wave
    if not wave.shape.turns_back or not verdict.breaks or verdict.per_rev <= 0.0:
        return None
    ratio = verdict.stroke_mm / wave.feed_mm_rev
    return feed_override_band(
        wave.waveform, verdict.per_rev, ratio, alpha_share=wave.alpha_share, edges=plan.edges
    )


def _speed_band_rpm(plan: CutPlan, verdict: Verdict, law: ControlLaw) -> tuple[float, float] | None:
    """From which to which spindle speed its chips break at this frequency.

    Where blocks take their times whatever the spindle does, a slower one has more feed in a revolution: the
    same as a higher override at its own speed.
    """
    if law.per_revolution or verdict.speed_band_rpm is None:
        return verdict.speed_band_rpm
    band = _override_band(plan, verdict)
    if band is None:
        return None
    least, most = band
    return plan.solution.speed_rpm / most, plan.solution.speed_rpm / least


class CutMotion(NamedTuple):
    """How a cut runs on its control: seconds from its start, and where on the path the tool then is [mm].

    Both have the shape (n,); between two points the tool moves evenly.
    """

    time_s: Floats
    distance_mm: Floats

    def __repr__(self) -> str:
        return f"<CutMotion: {len(self.time_s)} points>"


class _Timed(NamedTuple):
    """The moves of a cut as they stand in the output, and when the control makes them.

    ``distance_mm``, (n + 1,), is where on the path they end; ``uncertainty`` by which share the numbers of
    the control may be off.
    """

    moves: ReadBack
    law: ControlLaw
    blocks: Blocks
    motion: Motion
    distance_mm: Floats
    uncertainty: float


def measured_motion(
    result: InterpretedProgram, region: Region, plan: CutPlan, expansion: Expansion
) -> CutMotion:
    """The motion of a cut, read from the output.  Raises SelfCheckError when it is not what was planned."""
    timed = _timed(result, region, plan, expansion)
    worst = next(timed)
    found = _rank(_report(plan, expansion, worst))
    for other in timed:
        if (rank := _rank(_report(plan, expansion, other))) < found:
            worst = other
            found = rank
    # Who gets it may do with it what he likes.
    return CutMotion(worst.motion.time_s.copy(), worst.motion.distance_mm.copy())


def _timed(
    result: InterpretedProgram, region: Region, plan: CutPlan, expansion: Expansion
) -> Iterator[_Timed]:
    moves = read_moves(result, region.body, region.last)
    _check_speed(result, region, plan)
    return _in_time(moves, result.settings, plan, expansion)


def _in_time(moves: ReadBack, settings: Settings, plan: CutPlan, expansion: Expansion) -> Iterator[_Timed]:
    """The moves in time, for each law that the profile leaves open: one after the other, as each is large."""
    moves = _reached(moves, settings, plan)
    count = len(moves.feed_mm_s)
    if count != len(expansion.distance_mm):
        raise SelfCheckError(f"{len(expansion.distance_mm)} moves were planned, {count} stand in the output")
    if moves.strangers:
        raise SelfCheckError("a move that is no cut stands in a vibrated cut")
    distance_mm = _check_path(settings, moves, plan, expansion)
    moved = np.diff(np.vstack((plan.path.legs[0].start, moves.points_mm)), axis=0)
    law = control_along(settings, plan.path, plan.chain.before, _feed_mode(settings, plan))
    blocks = law.blocks(moved, np.diff(distance_mm))
    variants = law.variants()
    known = set[bytes]()
    for one in variants:
        motion = _motion(one, distance_mm, blocks, moves.feed_mm_s, moves.dwell_s)
        if not np.all(motion.spans_s > 0.0):
            raise SelfCheckError("a move takes no time")
        # What the profile leaves open often makes no difference.
        fingerprint = motion.fingerprint if len(variants) > 1 else b""
        if fingerprint not in known:
            known.add(fingerprint)
            yield _Timed(moves, one, blocks, motion, distance_mm, settings.planner.uncertainty)
        del motion  # before the next one is made


@remembered
def _motion(
    law: ControlLaw, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats, dwell_s: Floats
) -> Motion:
    return law.motion(distance_mm, blocks, feeds_mm_s, dwell_s)


def measure_cut(result: InterpretedProgram, region: Region, plan: CutPlan, expansion: Expansion) -> CutReport:
    """Read a cut back from the output.  Raises SelfCheckError when it is not what was planned."""
    return _worst(_timed(result, region, plan, expansion), plan, expansion)


def measure_planned(settings: Settings, plan: CutPlan, expansion: Expansion) -> CutReport:
    """What :func:`measure_cut` will find of a cut that is not yet written, from the numbers of its blocks.

    Raises SelfCheckError.
    """
    assert expansion.printed is not None
    return _worst(_in_time(expansion.printed, settings, plan, expansion), plan, expansion)


def _worst(timed: Iterable[_Timed], plan: CutPlan, expansion: Expansion) -> CutReport:
    """The worst that the control may make of a cut, where the profile leaves it open."""
    return min((_report(plan, expansion, one) for one in timed), key=_rank)


def _rank(report: CutReport) -> tuple[bool, float]:
    """The worse a cut, the smaller."""
    return not report.misses_plan, report.verdict.margin


def _report(plan: CutPlan, expansion: Expansion, timed: _Timed) -> CutReport:
    moves, law, blocks, motion, *_ = timed
    _check_dwells(moves.dwell_s, expansion.dwell_s)
    time_s = _ends_s(motion, moves)
    # Between dwells, and at the end, blocks may be as short as that: of others it is refused before.
    waits = bool((motion.spans_s <= law.read_s).any())
    is_late = _is_late(law, float(time_s[-1]), expansion.planned_s, waits=waits)
    largest_mm, smallest_mm = _diameters(np.append(plan.path.legs[0].start[0], moves.points_mm[:, 0]))
    verdict = _judged(plan, expansion, time_s, motion, largest_mm if largest_mm > 0.0 else None)
    margin_off = _margin_off(plan, expansion, timed, verdict.margin)
    verdict = replace(verdict, speed_band_rpm=_speed_band_rpm(plan, verdict, law))
    is_filtered = motion.delay_s > 0.0
    peak_mm_s = law.peak_speed_mm_s(blocks, moves.feed_mm_s)
    if peak_mm_s is not None and not is_filtered:
        verdict = replace(verdict, peak_speed_mm_s=peak_mm_s)
    clearances = [
        Clearance(d, flank_clearance_deg(verdict.peak_speed_mm_s, d, plan.solution.speed_rpm))
        for d in dict.fromkeys((largest_mm, smallest_mm))
        if largest_mm > 0.0
    ]
    per_rev = plan.solution.per_rev
    # Where blocks take their own times, just checked, a crest moved by rounding is no other N.
    off_count = not law.keeps_time and abs(verdict.per_rev - per_rev) > _COUNT_TOLERANCE * per_rev
    return CutReport(
        plan,
        expansion,
        law.name,
        law.is_assumed,
        float(time_s[-1]),
        len(moves.feed_mm_s),
        verdict,
        # A dwell ends the chip whatever N is; legs along axes that are not alike take other times.
        plan.wave.shape.turns_back and (is_late or (off_count and verdict.per_rev > 0.0)),
        motion.peak_acceleration_mm_s2
        if is_filtered
        else least_acceleration_mm_s2(plan.wave, plan.solution.per_rev),
        law.acceleration_mm_s2,
        Following(
            verdict.stroke_mm / plan.wave.stroke_mm if plan.wave.shape.turns_back else None,
            motion.delay_s,
            motion.path_error_mm,
            plan.wave.period_s / motion.look_s,
        )
        if is_filtered
        else None,
        tuple(clearances),
        margin_off=margin_off,
    )


def _ends_s(motion: Motion, moves: ReadBack) -> Floats:
    """When each block ends, and the dwell behind it, from 0 on."""
    spans_s = motion.spans_s + moves.dwell_s if len(moves.dwell_s) else motion.spans_s
    return np.concatenate(([0.0], np.cumsum(spans_s)))


def _judged(
    plan: CutPlan, expansion: Expansion, time_s: Floats, motion: Motion, diameter_mm: float | None
) -> Verdict:
    return judge(
        motion.time_s,
        motion.distance_mm,
        speed_rpm=plan.solution.speed_rpm,
        feed_mm_rev=plan.wave.feed_mm_rev,
        edges=plan.edges,
        diameter_mm=diameter_mm,
        steady_s=_steady_s(plan, expansion, time_s, motion),
        waveform=plan.wave.waveform,
        alpha_share=plan.wave.alpha_share,
        vibration_s=plan.wave.period_s,
        meant_s=(time_s, _planned_s(expansion)),
    )


def _planned_s(expansion: Expansion) -> Floats:
    """When the blocks begin and end by the plan."""
    return np.concatenate(([0.0], expansion.time_s))


def _margin_off(plan: CutPlan, expansion: Expansion, timed: _Timed, margin: float) -> float:
    """How far the margin goes where the numbers of the control are off, all to one side; 0 far from 1."""
    share = timed.uncertainty
    if share <= 0.0 or abs(margin - 1.0) > _MOST_TIMES_OFF * share:
        return 0.0
    moves = timed.moves
    off = [0.0]
    for one in (share, -share):
        law = timed.law.slower(one)
        blocks = law.blocks(timed.blocks.moved_mm, timed.blocks.lengths_mm)
        motion = law.motion(timed.distance_mm, blocks, moves.feed_mm_s, moves.dwell_s)
        time_s = _ends_s(motion, moves)
        weakest = weakest_margin(
            motion.time_s,
            motion.distance_mm,
            speed_rpm=plan.solution.speed_rpm,
            feed_mm_rev=plan.wave.feed_mm_rev,
            edges=plan.edges,
            steady_s=_steady_s(plan, expansion, time_s, motion),
            waveform=plan.wave.waveform,
            vibration_s=plan.wave.period_s,
            meant_s=(time_s, _planned_s(expansion)),
        )
        off.append(abs(weakest - margin))
    return max(off)


def _feed_mode(settings: Settings, plan: CutPlan) -> str:
    """That of the blocks: a cut that dwells keeps the program's own."""
    return plan.expander.feed_mode(plan.chain.before.modes.feed_mode, settings.output.feed_mode)


def _reached(moves: ReadBack, settings: Settings, plan: CutPlan) -> ReadBack:
    """The moves with the points that the axes reach in their steps."""
    steps_mm = axis_steps_mm(settings, plan.chain.before)
    if not steps_mm.any():
        return moves
    is_incremental = all(move.incremental for move in plan.chain.moves)
    origin_mm = np.array(plan.path.legs[0].start) if is_incremental else np.zeros(3)
    points_mm = reached(moves.points_mm, steps_mm, origin_mm)
    points_mm[-1] = end_reached(moves.points_mm[-1], origin_mm, settings, plan.chain.before)
    if _feed_mode(settings, plan) != "inverse":
        return replace(moves, points_mm=points_mm)
    # Inverse time is that of the way which the axes really go.
    moved = np.diff(np.vstack((plan.path.legs[0].start, points_mm)), axis=0)
    lengths_mm = np.sqrt(np.einsum("ij,ij->i", moved, moved))
    feed_mm_s = moves.feed_mm_s * lengths_mm / moves.lengths_mm
    return replace(moves, points_mm=points_mm, lengths_mm=lengths_mm, feed_mm_s=feed_mm_s)


def _diameters(radii_mm: Floats) -> tuple[float, float]:
    """The largest and the smallest diameter of a cut from its signed radii; past the centre it is 0."""
    low = float(radii_mm.min())
    high = float(radii_mm.max())
    smallest_mm = 0.0 if low < 0.0 < high else min(abs(low), abs(high))
    return 2.0 * max(abs(low), abs(high)), 2.0 * smallest_mm


def _check_dwells(dwell_s: Floats, wanted_s: Floats) -> None:
    alike = len(dwell_s) == len(wanted_s)
    if not (alike and np.abs(dwell_s - wanted_s).max(initial=0.0) <= _SAME_DWELL_S):
        raise SelfCheckError("the tool does not stand where, or as long as, it should")


def _steady_s(plan: CutPlan, expansion: Expansion, time_s: Floats, motion: Motion) -> tuple[float, float]:
    """The part of full stroke, from the time of the plan to that of the machine.

    Behind filters it begins when they no longer show what was before, in a short cut as late as they are.
    """
    first, last = np.interp(full_window(plan.wave), _planned_s(expansion), time_s).tolist()
    if last - first >= motion.settling_s + _SETTLED_VIBRATIONS * plan.wave.period_s:
        return first + motion.settling_s, last
    return first + motion.delay_s, last + motion.delay_s


def _is_late(law: ControlLaw, duration_s: float, planned_s: float, *, waits: bool) -> bool:
    """True when the control needs another time than planned; where it ``waits``, for blocks to be read.

    Raises SelfCheckError when F is to blame.
    """
    tolerance_s = TIME_SHARE * planned_s
    if law.keeps_time and not (waits and duration_s > planned_s):
        if abs(duration_s - planned_s) > tolerance_s:
            raise SelfCheckError(f"a cut planned to take {planned_s:z.3f} s takes {duration_s:z.3f} s")
        return False
    return abs(duration_s - planned_s) > tolerance_s + _STOP_TOLERANCE_S


def _check_speed(result: InterpretedProgram, region: Region, plan: CutPlan) -> None:
    state = result.behind(region.last)
    wanted = plan.solution.speed_rpm
    speed = state.speed.value if state.speed else math.nan
    if state.modes.speed_mode != "rpm" or not abs(speed - wanted) <= 1e-6 * wanted:
        raise SelfCheckError(f"the cut needs {wanted:g} rpm, the output commands {speed:g}")


def _check_path(settings: Settings, moves: ReadBack, plan: CutPlan, expansion: Expansion) -> Floats:
    """Distance along the path at every knot; never off it, before its start or past its end."""
    state = plan.chain.before
    step_mm = rounding_mm(settings, state)
    along, away = moves.along(plan.path, expansion.distance_mm)
    # Half an increment in each of up to three axes, and in a loop half of what its passes add up to.
    drift = max((loop.drift_steps for loop in expansion.loops or ()), default=0.0)
    tolerance = math.sqrt(3.0) * 0.5 * (1.0 + drift) * step_mm + 1e-6
    if away.max() > tolerance + settings.vibration.chord_mm:
        raise SelfCheckError(f"a point lies {away.max():z.4f} mm off the path")
    astray = float(np.abs(along - expansion.distance_mm).max())
    if astray > tolerance:
        raise SelfCheckError(f"a point lies {astray:z.4f} mm from where it was planned")
    if along.min() < -tolerance or along.max() > plan.path.length_mm + tolerance:
        raise SelfCheckError("a point lies before the start or past the end of the cut")
    if not abs(along[-1] - plan.path.length_mm) <= tolerance:
        raise SelfCheckError("the cut does not end at its programmed end")
    return np.concatenate(([0.0], along))
