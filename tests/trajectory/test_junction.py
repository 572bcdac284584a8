"""Controls with junction deviation: corners, limits along the path, look-ahead, feeds of whole cuts."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.junction_plan import Moves, planned_smoothly
from chipbreak.trajectory.law import AxisLimits
from chipbreak.trajectory.motion import Motion

Floats = NDArray[np.float64]
AXES = (AxisLimits("X", 40.0, 300.0), AxisLimits("Y", inf, inf), AxisLimits("Z", 60.0, 500.0))


def law_of(**more: object) -> Junction:
    return Junction(**more).along((1.0, 0.0, 1.0), AXES)  # type: ignore[arg-type]


def motion_of(law: Junction, points_mm: list[tuple[float, float]], feeds_mm_s: float) -> Motion:
    """Of straight moves through points (x, z) at these feeds."""
    points = np.array([(x, 0.0, z) for x, z in points_mm])
    moved = np.diff(points, axis=0)
    ahead = np.sqrt((moved**2).sum(axis=1))
    blocks = law.blocks(moved, ahead)
    return law.motion(
        np.append(0.0, np.cumsum(ahead)), blocks, np.broadcast_to(feeds_mm_s, ahead.shape).copy()
    )


def single_cosine(one: tuple[float, float], two: tuple[float, float]) -> float:
    """Of the joint of two moves, x and z, in the single precision of these controls."""
    ways = []
    for x, z in (one, two):
        way = np.array([x, z], np.float32)
        ways.append(way * (np.float32(1.0) / np.sqrt(way[1] * way[1] + way[0] * way[0])))
    return float(-(ways[0][1] * ways[1][1]) - ways[0][0] * ways[1][0])


def stepped(points_mm: list[tuple[float, float]], feed_mm_s: float, deviation_mm: float) -> Floats:
    """Times of moves by the rules as they are written, one joint after the other."""
    limits = {0: (300.0, 40.0), 1: (500.0, 60.0)}
    moves = []
    for (x0, z0), (x1, z1) in pairwise(points_mm):
        length = sqrt((x1 - x0) ** 2 + (z1 - z0) ** 2)
        way = ((x1 - x0) / length, (z1 - z0) / length)
        has = min(limits[k][0] / abs(way[k]) for k in (0, 1) if way[k])
        top = min([feed_mm_s, *(limits[k][1] / abs(way[k]) for k in (0, 1) if way[k])])
        moves.append((length, way, has, top, (x1 - x0, z1 - z0)))
    entries = [0.0]
    for (_, one, _, top_1, moved_1), (_, two, _, top_2, moved_2) in pairwise(moves):
        cosine = single_cosine(moved_1, moved_2)
        speed = min(top_1, top_2)
        if cosine > np.float32(0.999999):
            speed = 0.0
        elif cosine >= np.float32(-0.999999):
            turn = (two[0] - one[0], two[1] - one[1])
            size = sqrt(turn[0] ** 2 + turn[1] ** 2)
            round_it = min(limits[k][0] / abs(turn[k] / size) for k in (0, 1) if turn[k])
            half = sqrt((1.0 - cosine) / 2.0)
            speed = min(speed, sqrt(round_it * deviation_mm * half / (1.0 - half)))
        entries.append(speed)
    entries.append(0.0)
    for i in reversed(range(len(moves))):
        entries[i] = min(entries[i], sqrt(entries[i + 1] ** 2 + 2.0 * moves[i][2] * moves[i][0]))
    for i in range(len(moves)):
        entries[i + 1] = min(entries[i + 1], sqrt(entries[i] ** 2 + 2.0 * moves[i][2] * moves[i][0]))
    times = []
    for (length, _, has, top, _), start, end in zip(moves, entries[:-1], entries[1:], strict=True):
        peak = min(top, sqrt(has * length + (start**2 + end**2) / 2.0))
        ramps = (2.0 * peak**2 - start**2 - end**2) / (2.0 * has)
        times.append((2.0 * peak - start - end) / has + max(0.0, length - ramps) / peak)
    return np.array(times)


points = st.lists(
    st.tuples(st.integers(-400, 400), st.integers(-400, 400)), min_size=2, max_size=30, unique=True
).map(lambda drawn: [(x / 250.0, z / 250.0) for x, z in drawn])


@pytest.mark.few(80)
@settings(max_examples=300, deadline=None)
@given(drawn=points, feed=st.floats(0.5, 80.0), deviation=st.sampled_from([0.0, 0.01, 0.2]))
def test_the_whole_motion_is_what_one_joint_after_the_other_gives(
    drawn: list[tuple[float, float]], feed: float, deviation: float
) -> None:
    motion = motion_of(law_of(junction_deviation_mm=deviation), drawn, feed)
    assert motion.spans_s == pytest.approx(stepped(drawn, feed, deviation), rel=1e-6, abs=1e-9)
    assert motion.time_s[-1] == pytest.approx(motion.spans_s.sum())
    assert (np.diff(motion.time_s) > 0.0).all()


@pytest.mark.parametrize("angle", [10.0, 45.0, 90.0, 150.0])
def test_a_corner_is_passed_at_the_speed_of_its_circle(angle: float) -> None:
    """a·δ·s/(1 − s), with s the sine of half the angle that is left between the moves."""
    law = Junction(junction_deviation_mm=0.02).along((1.0, 0.0, 1.0), (AxisLimits("", inf, 400.0),) * 3)
    turn = radians(angle)
    motion = motion_of(law, [(0.0, 0.0), (0.0, 5.0), (5.0 * sin(turn), 5.0 + 5.0 * cos(turn))], 30.0)
    half = sin((pi - turn) / 2.0)
    way = np.array([sin(turn), cos(turn) - 1.0])
    has = 400.0 / np.abs(way / np.sqrt((way**2).sum())).max()
    corner = min(30.0, sqrt(has * 0.02 * half / (1.0 - half)))
    at = int(np.flatnonzero(np.isclose(motion.distance_mm, 5.0))[0])
    slow = np.diff(motion.distance_mm)[at - 1 : at + 1] / np.diff(motion.time_s)[at - 1 : at + 1]
    assert slow.min() == pytest.approx(corner, rel=0.2) or slow.min() > corner


def test_a_bent_reversal_is_no_rest() -> None:
    """On steps of 4 µm a taper does not go back exactly as it came."""
    exact = motion_of(law_of(), [(0.0, 0.0), (0.02, 0.08), (0.0, 0.0)], 20.0)
    bent = motion_of(law_of(), [(0.0, 0.0), (0.02, 0.08), (0.004, 0.0)], 20.0)
    assert bent.spans_s[0] < exact.spans_s[0] * 0.99


def test_the_limits_along_the_path_count_in_every_direction() -> None:
    free = (AxisLimits("X", inf, inf),) * 3
    law = Junction(path_velocity_mm_s=20.0, path_acceleration_mm_s2=200.0).along((1.0, 0.0, 1.0), free)
    (span,) = motion_of(law, [(0.0, 0.0), (6.0, 8.0)], 100.0).spans_s
    assert span == pytest.approx(10.0 / 20.0 + 20.0 / 200.0)
    assert (law.axis, law.acceleration_mm_s2, law.velocity_mm_s) == ("the path", 200.0, 20.0)


@pytest.mark.parametrize(("ratio", "share"), [(0.5, 0.5), (0.75, 0.25)])
def test_the_cruise_ratio_bounds_the_peak_of_a_short_move(ratio: float, share: float) -> None:
    """The peak is at most sqrt(L·a·(1 − ratio))."""
    free = (AxisLimits("X", inf, inf),) * 3
    law = Junction(corner_velocity_mm_s=5.0, min_cruise_ratio=ratio, path_acceleration_mm_s2=1000.0)
    law = law.along((0.0, 0.0, 1.0), free)
    (span,) = motion_of(law, [(0.0, 0.0), (0.0, 0.4)], 500.0).spans_s
    peak = sqrt(0.4 * 1000.0 * share)
    assert span == pytest.approx(0.4 / peak + peak / 1000.0)


def test_a_short_look_ahead_keeps_the_speed_down() -> None:
    """Short moves in a row: what the control knows is all it may need to stop."""
    line = [(0.0, 0.01 * i) for i in range(400)]
    seen = motion_of(law_of(look_ahead_blocks=15), line, 30.0)
    fastest = (np.diff(seen.distance_mm) / np.diff(seen.time_s)).max()
    assert fastest == pytest.approx(sqrt(2.0 * 500.0 * 14 * 0.01), rel=0.06)
    assert motion_of(law_of(), line, 30.0).spans_s.sum() < seen.spans_s.sum() * 0.9


def strokes_of(count: int, seed: int) -> tuple[Floats, Floats, Floats]:
    """Moves of a taper on steps of 4 µm, how far each leads, and how long each should take."""
    random = np.random.default_rng(seed)
    along = np.cumsum(np.where(np.arange(count) % 2 == 0, 0.08, -0.05))
    places = np.concatenate([np.zeros((1, 3)), np.outer(along, (0.3, 0.0, 0.954))])
    moved = np.diff(np.rint(places * 250.0) / 250.0, axis=0)
    spans = np.where(np.arange(count) % 2 == 0, 0.042, 0.036) * random.uniform(0.98, 1.02, count)
    return moved, np.diff(along, prepend=0.0), spans


@pytest.mark.parametrize("more", [{}, {"corner_velocity_mm_s": 5.0, "min_cruise_ratio": 0.5}])
def test_every_stroke_takes_its_time(more: dict[str, float]) -> None:
    law = law_of(path_acceleration_mm_s2=700.0, **more)
    moved, ahead, spans = strokes_of(400, seed=3)
    blocks = law.blocks(moved, ahead)
    feeds = law.feeds_for_spans(blocks, spans, len(spans))
    motion = law.motion(np.append(0.0, np.cumsum(ahead)), blocks, feeds)
    assert motion.spans_s == pytest.approx(spans, rel=1e-5)


def test_a_stroke_that_no_feed_makes_is_refused_with_what_is_missing() -> None:
    law = law_of()
    moved, ahead, spans = strokes_of(20, seed=3)
    blocks = law.blocks(moved, ahead)
    with pytest.raises(RefusalError, match=r"needs .* m/s2, Z has") as refused:
        law.feeds_for_spans(blocks, spans / 3.0, len(spans))
    assert refused.value.code == "VIB030"
    slow = Junction().along((0.0, 0.0, 1.0), (*AXES[:2], AxisLimits("Z", 1.0, 500.0)))
    with pytest.raises(RefusalError, match="mm/s") as refused:
        slow.feeds_for_spans(slow.blocks(moved, ahead), spans, len(spans))
    assert refused.value.code == "VIB031"


def test_a_move_of_few_steps_is_no_slower_than_its_steps() -> None:
    """A timer that cannot count longer makes the step early; the next stroke gets what is left."""
    axes = (*AXES[:2], AxisLimits("Z", 60.0, 500.0, step_mm=0.01))
    law = Junction(least_steps_per_s=30.5).along((0.0, 0.0, 1.0), axes)
    lengths = np.array([0.09, -0.02, 0.09, -0.02])
    moved = np.column_stack([np.zeros(4), np.zeros(4), lengths])
    spans = np.array([0.1, 0.1, 0.1, 0.1])
    blocks = law.blocks(moved, lengths)
    feeds = law.feeds_for_spans(blocks, spans, 4)
    motion = law.motion(np.append(0.0, np.cumsum(lengths)), blocks, feeds)
    slow = 2.0 / 30.5
    assert motion.spans_s == pytest.approx([0.1, slow, 0.2 - slow, slow], rel=1e-5)


@pytest.mark.parametrize(("way_mm", "took_s"), [(0.27, 0.1449115), (0.26, 0.140112)])
def test_a_slow_start_of_coarse_steps_takes_longer(way_mm: float, took_s: float) -> None:
    """What Grbl 1.1h took on a clock of its timer ticks; the ramps alone would be 0.0049 s less."""
    axes = (*AXES[:2], AxisLimits("Z", 50.0, 200.0, step_mm=0.01))
    law = Junction(segment_s=0.01, least_steps_per_s=30.5).along((0.0, 0.0, 1.0), axes)
    (span,) = motion_of(law, [(0.0, 0.0), (0.0, way_mm)], 125.0 / 60.0).spans_s
    assert span == pytest.approx(took_s, rel=1e-3)


def test_no_stroke_ends_with_a_segment_of_time() -> None:
    """There Grbl 1.1h has now and then a step left, at no speed: 20.39 ms, and 16.27 in place of 16."""
    axes = (*AXES[:2], AxisLimits("Z", 130.0, 1000.0, step_mm=0.00125))
    law = Junction(segment_s=0.01).along((0.0, 0.0, 1.0), axes)
    lengths = np.tile([-0.08125, 0.06, -0.02, 0.045], 10)
    spans = np.tile([0.020, 0.016, 0.010, 0.0140], 10)
    blocks = law.blocks(np.column_stack([0.0 * lengths, 0.0 * lengths, lengths]), lengths)
    feeds = law.feeds_for_spans(blocks, spans, len(spans))
    motion = law.motion(np.append(0.0, np.cumsum(lengths)), blocks, feeds)
    off_s = motion.spans_s - 0.01 * np.rint(motion.spans_s / 0.01)
    assert np.abs(off_s).min() > 3e-6
    assert motion.spans_s == pytest.approx(spans, abs=1e-5)


def test_a_quick_start_takes_what_its_ramps_do() -> None:
    axes = (*AXES[:2], AxisLimits("Z", 50.0, 500.0, step_mm=0.004))
    law = Junction(segment_s=0.01).along((0.0, 0.0, 1.0), axes)
    (span,) = motion_of(law, [(0.0, 0.0), (0.0, 0.27)], 10.0).spans_s
    assert span == pytest.approx(0.27 / 10.0 + 10.0 / 500.0)


@pytest.mark.parametrize("steps", range(60, 92))
def test_a_first_segment_on_the_edge_of_a_step_goes_by_lost_digits(steps: int) -> None:
    """10 ms at 100 mm/s² are a step and a quarter; Grbl 1.1h and grblHAL both take just the ramps."""
    axes = (*AXES[:2], AxisLimits("Z", 50.0, 100.0, step_mm=0.004))
    law = Junction(segment_s=0.01).along((0.0, 0.0, 1.0), axes)
    feed_mm_s = 98.0 / 60.0
    way_mm = steps / 250.0
    (span,) = motion_of(law, [(0.0, 0.0), (0.0, way_mm)], feed_mm_s).spans_s
    assert span == pytest.approx(way_mm / feed_mm_s + feed_mm_s / 100.0, abs=1e-5)


@pytest.mark.parametrize("corner_mm_s", [1.0, 3.0, 8.0])
@pytest.mark.parametrize("angle", [30.0, 90.0, 140.0])
def test_a_corner_is_passed_at_the_speed_that_is_given_for_a_right_angle(
    angle: float, corner_mm_s: float
) -> None:
    """The circle that a right angle is rounded with at this speed rounds the others, too."""
    free = (AxisLimits("X", inf, inf),) * 3
    law = Junction(
        path_velocity_mm_s=100.0, path_acceleration_mm_s2=400.0, corner_velocity_mm_s=corner_mm_s
    ).along((1.0, 0.0, 1.0), free)
    turn = radians(angle)
    motion = motion_of(law, [(0.0, 0.0), (0.0, 5.0), (5.0 * sin(turn), 5.0 + 5.0 * cos(turn))], 30.0)
    half = sin((pi - turn) / 2.0)
    right = sin(pi / 4.0)
    # v^2 = a d s / (1 - s), with the same a d.
    passed = min(30.0, corner_mm_s * sqrt(half / (1.0 - half) * (1.0 - right) / right))
    # From rest up to 30 mm/s, down to the corner; and the other way round.
    took = (2.0 * 30.0 - passed) / 400.0 + (5.0 - (2.0 * 900.0 - passed**2) / 800.0) / 30.0
    assert motion.spans_s == pytest.approx([took, took], rel=1e-6)
    assert angle != 90.0 or passed == pytest.approx(corner_mm_s)


# --- the plan with less acceleration, one move after the other --------------------------------------------


def below(tops: list[float], gains: list[float], limits: list[float]) -> list[float]:
    """The highest squared speeds at joints, from the last one to the first and back."""
    joints = [0.0, *(min(limit, *pair) for limit, pair in zip(limits, pairwise(tops), strict=True)), 0.0]
    for at in reversed(range(len(gains))):
        joints[at] = min(joints[at], joints[at + 1] + gains[at])
    for at, gain in enumerate(gains):
        joints[at + 1] = min(joints[at + 1], joints[at] + gain)
    return joints


def smoothly(
    tops: list[float], gains: list[float], slow_gains: list[float], limits: list[float]
) -> list[float]:
    """Squared peaks by the rule as it is said: no move is faster than the next peak of the slower plan.

    One that only brakes there has none before it: it is no faster than it begins, or the one before it was.
    """
    joints = below(tops, gains, limits)
    slow = below(tops, slow_gains, joints[1:-1])
    brakes = [slow[at] == slow[at + 1] + gain for at, gain in enumerate(slow_gains)]
    peaks: list[float] = []
    for at, (start, end) in enumerate(pairwise(joints)):
        if brakes[at] and peaks:
            peaks.append(min(peaks[-1], start))
            continue
        top = at
        while slow[top] + slow_gains[top] == slow[top + 1] and not brakes[top + 1]:
            top += 1
        peak = min(tops[top], (slow[top] + slow[top + 1] + slow_gains[top]) / 2.0)
        peaks.append(min((start + end + gains[at]) / 2.0, tops[at], peak))
    return peaks


# Halves and quarters, so that no digit is lost and what is equal is equal.
drawn_moves = st.lists(
    st.tuples(
        st.sampled_from([0.25, 0.5, 1.0, 4.0, 16.0]),  # mm
        st.sampled_from([2.0, 8.0]),  # mm/s2
        st.sampled_from([1.0, 2.0, 4.0, 8.0, 16.0]),  # mm/s
        st.sampled_from([0.25, 1.0, 4.0, 64.0, 1024.0]),  # mm2/s2 at the joint behind it
    ),
    min_size=1,
    max_size=12,
)


@pytest.mark.few(100)
@settings(max_examples=500, deadline=None)
@given(drawn_moves, st.sampled_from([1.0, 4.0]))
def test_a_plan_with_less_acceleration_is_what_one_move_after_the_other_gives(
    drawn: list[tuple[float, float, float, float]], smooth_mm_s2: float
) -> None:
    lengths, has, nominal, limits = map(list, zip(*drawn, strict=True))
    moves = Moves(np.array(lengths), np.array(has), np.tile([1.0, 0.0, 0.0], (len(drawn), 1)))
    gains = [2.0 * a * way for way, a in zip(lengths, has, strict=True)]
    slow_gains = [min(2.0 * smooth_mm_s2 * way, gain) for way, gain in zip(lengths, gains, strict=True)]
    wanted = smoothly([feed**2 for feed in nominal], gains, slow_gains, limits[:-1])
    ends = np.array([0.0, *limits[:-1], 0.0])
    speeds = planned_smoothly(moves, ends, np.array(nominal), smooth_mm_s2)
    assert speeds.peaks.tolist() == pytest.approx(wanted, rel=1e-9)
    joints = np.array(below([feed**2 for feed in nominal], gains, limits[:-1]))
    assert speeds.starts.tolist() == pytest.approx(np.minimum(joints[:-1], wanted).tolist(), rel=1e-9)
    assert speeds.ends.tolist() == pytest.approx(np.minimum(joints[1:], wanted).tolist(), rel=1e-9)


def test_a_move_is_no_faster_than_the_feed_of_the_next_peak() -> None:
    """From rest 0.5 mm at 200 mm/s, then 5 mm at 5 mm/s: the first one goes no faster than 5 mm/s either.

    With 10 mm/s2 the slower plan speeds up all along the first and on in the second, which is its peak.
    """
    moves = Moves(np.array([0.5, 5.0]), np.full(2, 1000.0), np.tile([1.0, 0.0, 0.0], (2, 1)))
    speeds = planned_smoothly(moves, np.array([0.0, 1000.0, 0.0]), np.array([200.0, 5.0]), 10.0)
    assert speeds.peaks.tolist() == [25.0, 25.0]


def test_no_digits_are_lost_on_the_way() -> None:
    """What a move may do is the same wherever it is: here behind a kilometre at full speed."""
    short = [0.25, 0.5, 0.0625, 0.25]
    alone = peaks_behind([], short)
    for far in (1e3, 1e6):
        assert peaks_behind([far], short)[-4:] == pytest.approx(alone[-4:], rel=1e-6)


def peaks_behind(before: list[float], short: list[float]) -> list[float]:
    lengths = np.array([*before, 1.0, *short])
    limits = np.full(len(lengths) + 1, 1e12)
    limits[[0, -5, -1]] = 0.0
    moves = Moves(lengths, np.full(len(lengths), 300.0), np.tile([1.0, 0.0, 0.0], (len(lengths), 1)))
    return planned_smoothly(moves, limits, np.full(len(lengths), 40.0), 77.7).peaks.tolist()
