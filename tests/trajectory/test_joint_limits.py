"""What limits the speed at joints, number by number, and what the plans of junction deviation make of it."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, pi, sin, sqrt

import numpy as np
import pytest

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory import junction_plan
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.junction_plan import (
    Moves,
    Speeds,
    _carried_down,
    _peaks_behind,
    corner_speed_limits,
    cosines,
    deviation_limits,
    late_in_first_segments,
    planned,
    planned_smoothly,
    reachable,
    seen_ahead,
    single_cosines,
)
from chipbreak.trajectory.junctions import (
    Blocks,
    blocks_of,
    exact_blocks,
    four_digits,
    least_of_parts,
    parts_of,
)
from chipbreak.trajectory.law import AxisLimits
from chipbreak.trajectory.look_ahead import LookAhead

AXES = (AxisLimits("X", 100.0, 400.0), AxisLimits("Y", inf, inf), AxisLimits("Z", 150.0, 1000.0))


def moves_of(lengths: list[float], angles: list[float], has: float | list[float] = 100.0) -> Moves:
    """Moves in the plane of Z and X, each turned by so much from Z."""
    ways = np.array([[sin(angle), 0.0, cos(angle)] for angle in angles])
    return Moves(np.array(lengths), np.broadcast_to(np.array(has, dtype=float), (len(lengths),)).copy(), ways)


# --- joints -----------------------------------------------------------------------------------------------


def test_cosines_of_joints() -> None:
    moves = moves_of([1.0, 2.0, 3.0, 4.0, 5.0], [0.0, pi / 2.0, pi / 2.0, -pi / 2.0, -pi / 2.0 + 1.0])
    assert cosines(moves.ways).tolist() == pytest.approx([0.0, -1.0, 1.0, -cos(1.0)], abs=1e-15)
    assert single_cosines(moves).tolist() == pytest.approx([0.0, -1.0, 1.0, -cos(1.0)], abs=1e-6)
    assert single_cosines(moves_of([1.0], [0.3])).tolist() == []
    assert single_cosines(Moves(np.empty(0), np.empty(0), np.empty((0, 3)))).tolist() == []


def test_a_cosine_in_single_precision_is_that_of_the_ways_themselves() -> None:
    """1.5 mm in X and 2 mm in Z, and 0.7 and 2.4: no digit of a length counts."""
    way = np.array([[1.5, 0.0, 2.0], [0.7, 0.0, -2.4]])
    size = np.sqrt((way**2).sum(axis=1))
    moves = Moves(size, np.ones(2), way / size[:, np.newaxis])
    assert single_cosines(moves)[0] == pytest.approx((2.0 * 2.4 - 1.5 * 0.7) / (2.5 * 2.5), abs=1e-6)


@pytest.mark.parametrize("turn", [0.2, 1.0, 2.0, 3.0, -1.2])
def test_a_joint_of_junction_deviation(turn: float) -> None:
    """v² = a·δ·s/(1 - s), with the acceleration that both axes have along the change of direction."""
    moves = moves_of([1.0, 1.0], [0.4, 0.4 + turn])
    axes = np.array([400.0, inf, 1000.0])
    change = np.abs([sin(0.4 + turn) - sin(0.4), cos(0.4 + turn) - cos(0.4)])
    change /= sqrt(float(change @ change))
    has = min(400.0 / change[0], 1000.0 / change[1])
    half = sin((pi - abs(turn)) / 2.0)
    limits = deviation_limits(moves, 0.02, axes)
    assert limits.tolist() == pytest.approx([0.0, has * 0.02 * half / (1.0 - half), 0.0], rel=1e-4)


@pytest.mark.parametrize("limits_of", [deviation_limits, corner_speed_limits])
def test_straight_on_has_no_limit_and_back_again_is_a_rest(limits_of: object) -> None:
    moves = moves_of([1.0, 1.0, 1.0, 1.0], [0.4, 0.4, 0.4 + pi, 0.4 + pi])
    if limits_of is deviation_limits:
        limits = deviation_limits(moves, 0.02, np.full(3, 100.0))
    else:
        limits = corner_speed_limits(moves, 5.0, 100.0)
    assert limits.tolist() == [0.0, 1e12, 0.0, 1e12, 0.0]


@pytest.mark.parametrize(("off", "is_turned"), [(0.0012, True), (0.0016, False)])
def test_how_near_to_straight_on_is_straight_on(off: float, is_turned: bool) -> None:
    """A cosine of 0.999999 is an angle of 1.41 thousandths."""
    ahead = corner_speed_limits(moves_of([1.0, 1.0], [0.0, off]), 5.0, 100.0)[1]
    back = corner_speed_limits(moves_of([1.0, 1.0], [0.0, pi - off]), 5.0, 100.0)[1]
    assert bool(ahead == 1e12) is is_turned
    assert bool(back == 0.0) is is_turned
    deviation = deviation_limits(moves_of([1.0, 1.0], [0.0, pi - off]), 0.02, np.full(3, 100.0))[1]
    assert bool(deviation == 0.0) is is_turned


@pytest.mark.parametrize("turn", [0.3, 1.0, pi / 2.0, 2.5])
@pytest.mark.parametrize(
    ("lengths", "has"),
    [([4.0, 4.0], [100.0, 50.0]), ([0.02, 4.0], [100.0, 50.0]), ([4.0, 0.03], [50.0, 100.0])],
)
def test_a_joint_of_a_corner_speed(turn: float, lengths: list[float], has: list[float]) -> None:
    """The circle of a right angle, with the lower acceleration; it touches each move within its half.

    There it has the radius of half the length times the tangent of half the angle between the moves, and the
    speed that the acceleration of that move allows on it.
    """
    inner = (pi - turn) / 2.0
    deviation = 5.0**2 * (sqrt(2.0) - 1.0) / 80.0
    round_it = min(has) * deviation * sin(inner) / (1.0 - sin(inner))
    halves = min(has[k] * lengths[k] / 2.0 * sin(inner) / cos(inner) for k in (0, 1))
    (_, limit, _) = corner_speed_limits(moves_of(lengths, [0.2, 0.2 + turn], has), 5.0, 80.0)
    assert limit == pytest.approx(min(round_it, halves), rel=1e-9)


@pytest.mark.parametrize(
    ("blocks", "wanted"),
    [
        (2, [2.0, 6.0, 8.0, 4.0, 0.0]),
        (3, [8.0, 9.0, 9.0, 4.0, 0.0]),
        (5, [9.0, 9.0, 9.0, 4.0, 0.0]),
        (9, [9.0, 9.0, 9.0, 4.0, 0.0]),
    ],
)
def test_of_so_many_blocks_the_last_one_must_end_at_rest(blocks: int, wanted: list[float]) -> None:
    limits = np.array([9.0, 9.0, 9.0, 9.0, 0.0])
    assert seen_ahead(limits, np.array([2.0, 6.0, 8.0, 4.0]), blocks).tolist() == wanted


def test_reachable_speeds_gain_no_more_than_moves_give() -> None:
    limits = np.array([0.0, 100.0, 7.0, 100.0, 100.0, 0.0])
    assert reachable(limits, np.array([3.0, 2.0, 50.0, 9.0, 4.0])).tolist() == [0.0, 3.0, 5.0, 13.0, 4.0, 0.0]
    assert reachable(np.array([50.0, 100.0]), np.array([8.0])).tolist() == [50.0, 58.0]
    assert reachable(np.zeros(1), np.empty(0)).tolist() == [0.0]


# --- plans ------------------------------------------------------------------------------------------------


def test_a_plan_by_hand() -> None:
    """Gains of 40, 20 and 80 mm²/s²; the second move is slower than both joints would allow."""
    moves = Moves(np.array([2.0, 1.0, 4.0]), np.full(3, 10.0), np.tile([0.0, 0.0, 1.0], (3, 1)))
    speeds = planned(moves, np.array([0.0, 30.0, 50.0, 0.0]), np.array([10.0, 4.0, 6.0]))
    assert speeds.starts.tolist() == [0.0, 16.0, 16.0]
    assert speeds.ends.tolist() == [16.0, 16.0, 0.0]
    assert speeds.peaks.tolist() == [28.0, 16.0, 36.0]
    # Up to the root of 28 and down to 4; at 4 all along; up from 4 to 6, on, and down.
    took = [
        (2.0 * sqrt(28.0) - 4.0) / 10.0,
        1.0 / 4.0,
        (2.0 * 6.0 - 4.0) / 10.0 + (4.0 - (2.0 * 36.0 - 16.0) / 20.0) / 6.0,
    ]
    assert speeds.times_s(moves).tolist() == pytest.approx(took)
    assert len(moves) == 3 and moves.gains.tolist() == [40.0, 20.0, 80.0]


def test_a_move_at_no_speed_takes_no_endless_time() -> None:
    moves = moves_of([1.0], [0.0])
    assert np.isfinite(Speeds(np.zeros(1), np.zeros(1), np.zeros(1)).times_s(moves)).all()


TRUE_FALSE = {"u": (True, False), "d": (False, True), "p": (True, True), "-": (False, False)}


@pytest.mark.parametrize(
    ("shape", "wanted"),
    [
        # Up, a peak, down: those that climb are on the way to the next peak, the last ones to none.
        ("upd", [1.0, 1.0, 0.0]),
        ("uupdd", [2.0, 2.0, 2.0, 0.0, 0.0]),
        ("pdup", [0.0, 3.0, 3.0, 3.0]),
        # Where the next one does not climb, or none is there, this is the peak.
        ("ud", [0.0, 0.0]),
        ("u", [0.0]),
        ("uu-u", [1.0, 1.0, 0.0, 0.0]),
        ("dd", [0.0, 0.0]),
    ],
)
def test_on_the_way_to_which_peak_moves_are(shape: str, wanted: list[float]) -> None:
    climbs, falls = (
        np.array(column) for column in zip(*(TRUE_FALSE[letter] for letter in shape), strict=True)
    )
    assert _peaks_behind(climbs, falls, np.arange(len(shape), dtype=float)).tolist() == wanted


@pytest.mark.parametrize(
    ("climbs", "fastest", "starts", "wanted"),
    [
        # Behind a climb each is no faster than the one before, and than it begins.
        ("udd", [5.0, 9.0, 9.0], [0.0, 8.0, 7.0], [5.0, 5.0, 5.0]),
        ("udd", [9.0, 9.0, 9.0], [0.0, 8.0, 7.0], [9.0, 8.0, 7.0]),
        ("uddud", [5.0, 9.0, 9.0, 6.0, 9.0], [0.0, 9.0, 9.0, 9.0, 9.0], [5.0, 5.0, 5.0, 6.0, 6.0]),
        ("uudu", [5.0, 4.0, 9.0, 9.0], [0.0, 3.0, 9.0, 9.0], [5.0, 4.0, 4.0, 9.0]),
        # In front of the first climb they are as they are.
        ("ddu", [5.0, 9.0, 7.0], [1.0, 2.0, 3.0], [5.0, 9.0, 7.0]),
        ("uddudd", [3.0, 9.0, 9.0, 8.0, 9.0, 9.0], [9.0] * 6, [3.0, 3.0, 3.0, 8.0, 8.0, 8.0]),
        ("dud", [5.0, 4.0, 9.0], [1.0, 9.0, 9.0], [5.0, 4.0, 4.0]),
        ("u", [5.0], [0.0], [5.0]),
    ],
)
def test_what_brakes_in_the_slow_plan_is_no_faster_than_what_came_before(
    climbs: str, fastest: list[float], starts: list[float], wanted: list[float]
) -> None:
    given = np.array(fastest)
    is_up = np.array([letter == "u" for letter in climbs])
    assert _carried_down(given, is_up, np.array(starts)).tolist() == wanted
    assert given.tolist() == fastest, "what was given stays"


def test_the_slow_plan_of_a_single_move() -> None:
    """v² = L·a of the slow acceleration at most, and the ramps have the whole one."""
    moves = moves_of([0.5], [0.0], 1000.0)
    speeds = planned_smoothly(moves, np.zeros(2), np.array([100.0]), 300.0)
    assert speeds.peaks.tolist() == pytest.approx([150.0])
    assert planned_smoothly(moves, np.zeros(2), np.array([10.0]), 300.0).peaks.tolist() == pytest.approx(
        [100.0]
    )
    # No slower than with the acceleration that it has.
    assert planned_smoothly(moves, np.zeros(2), np.array([100.0]), 3000.0).peaks.tolist() == pytest.approx(
        [500.0]
    )


# --- first segments ---------------------------------------------------------------------------------------


def late_one_by_one(row: tuple[float, ...], segment_s: float) -> float:
    """What is told of one move: its first segment is longer until it has a step and a quarter, or is all."""
    length, has, start, peak, steps = row
    ramp_s = (peak - start) / has
    if ramp_s <= segment_s:
        return 0.0
    needed_mm = min(1.25 * length / steps, length) if steps else length
    segments = 1
    while True:
        time_s = segments * segment_s
        gone_mm = start * time_s + has * time_s**2 / 2.0
        if gone_mm >= needed_mm:
            return 0.0
        if ramp_s <= time_s + segment_s:
            # The ramp ends in what is added: the way behind it counts twice, at the mean speed from there.
            return gone_mm / ((start + has * time_s + peak) / 2.0)
        segments += 1


def test_moves_that_start_slowly_are_late_by_what_one_after_the_other_says() -> None:
    rows = [
        (length, has, start, start + gain, steps)
        for length in (0.3, 1.0)
        for has in (50.0, 200.0)
        for start in (0.0, 0.6)
        for gain in (1.7, 3.1, 5.9)
        for steps in (7.0, 30.0, 101.0, 0.0)
    ]
    length, has, start, peak, steps = np.array(rows).T
    moves = Moves(length, has, np.tile([0.0, 0.0, 1.0], (len(rows), 1)))
    late = late_in_first_segments(moves, Speeds(start**2, peak**2, start**2), steps, 0.01)
    wanted = [late_one_by_one(row, 0.01) for row in rows]
    assert late.tolist() == pytest.approx(wanted, abs=1e-9)
    assert sum(one > 0.0 for one in wanted) > 10
    assert sum(one == 0.0 for one in wanted) > 10


# --- laws of joints ---------------------------------------------------------------------------------------


def zigzag(law: Junction, points: list[tuple[float, float]]) -> tuple[Floats, Blocks]:
    """Places along the path, and the blocks between points in X and Z."""
    moved = np.zeros((len(points) - 1, 3))
    moved[:, [0, 2]] = np.diff(np.array(points), axis=0)
    ahead = np.hypot(moved[:, 0], moved[:, 2])
    return np.append(0.0, np.cumsum(ahead)), law.blocks(moved, ahead)


@pytest.mark.parametrize("kind", [Junction, LookAhead])
def test_in_exact_stop_every_block_ends_at_rest(kind: type[Junction]) -> None:
    law = kind(every_block_stops=True).along((0.0, 0.0, 1.0), AXES)
    places, blocks = zigzag(law, [(0.0, 0.0), (0.0, 1.0), (0.0, 3.0), (1.5, 3.0), (1.5, 3.001)])
    motion = law.motion_between_dwells(places, blocks, np.full(4, 20.0))
    # Z has 1000 mm/s2, X 400; the last one does not reach its feed.
    wanted = [1.0 / 20.0 + 0.02, 2.0 / 20.0 + 0.02, 1.5 / 20.0 + 0.05, 2.0 * sqrt(0.001 / 1000.0)]
    assert motion.spans_s.tolist() == pytest.approx(wanted)
    assert law.block_times([1.0, 2.0], 20.0).tolist() == pytest.approx(wanted[:2])
    assert law.peak_speed_mm_s(blocks, np.full(4, 20.0)) == pytest.approx(20.0)


@pytest.mark.parametrize("turn", [0.0, 0.4, pi / 2.0, 2.0, pi])
def test_a_joint_that_no_axis_may_step_by_more(turn: float) -> None:
    """The step of the axis that steps most is the joint speed; straight on there is none."""
    law = LookAhead(joint_speed_mm_s=3.0).along((0.0, 0.0, 1.0), AXES)
    moves = moves_of([1.0, 1.0], [0.0, turn])
    first, joint, last = law._limits(moves)
    step = max(abs(sin(turn)), abs(cos(turn) - 1.0))
    assert (first, last) == (0.0, 0.0)
    if step:
        assert joint == pytest.approx((3.0 / step) ** 2)
    else:
        assert joint > 1e12


def test_slower_is_slower_in_all_that_was_given() -> None:
    law = LookAhead(joint_speed_mm_s=3.0).along((0.0, 0.0, 1.0), AXES).slower(0.25)
    assert (law.joint_speed_mm_s, law.acceleration_mm_s2) == (2.4, 800.0)
    assert [axis.acceleration_mm_s2 for axis in law.axes] == [320.0, inf, 800.0]
    faster = law.slower(-0.2)
    assert (faster.joint_speed_mm_s, faster.acceleration_mm_s2) == pytest.approx((3.0, 1000.0))


# --- blocks and parts -------------------------------------------------------------------------------------


def test_blocks_from_their_moves() -> None:
    moved = np.array([[3.0, 0.0, 4.0], [0.0, 5.0, 0.0], [-3.0, 0.0, 4.0], [0.0, 0.0, -2.0]])
    blocks = blocks_of(moved, np.array([1.0, 1.0, 1.0, -1.0]), [60.0, inf, 100.0])
    assert blocks.lengths_mm.tolist() == [5.0, 5.0, 5.0, -2.0]
    assert blocks.corners.tolist() == pytest.approx([1.0, 1.0, 1.8, 0.0])
    assert blocks.acceleration_mm_s2.tolist() == pytest.approx([100.0, inf, 100.0, 100.0])
    part = blocks.part(slice(1, 3))
    assert (part.lengths_mm.tolist(), part.moved_mm.tolist()) == ([5.0, 5.0], moved[1:3].tolist())
    assert part.corners.tolist() == pytest.approx([1.0, 1.8])
    assert part.acceleration_mm_s2.tolist() == pytest.approx([inf, 100.0])
    # The longest axis need not be the one that limits, and one without a limit never does.
    steep = blocks_of(np.array([[3.0, 0.0, 4.0]]), np.ones(1), [30.0, 1.0, 100.0])
    assert steep.acceleration_mm_s2.tolist() == pytest.approx([50.0])
    exact = exact_blocks(moved, np.array([1.0, 1.0, 1.0, -1.0]))
    assert exact.lengths_mm.tolist() == [5.0, 5.0, 5.0, -2.0]
    assert exact.corners.tolist() == [0.0] * 4 and exact.acceleration_mm_s2.tolist() == [inf] * 4


def test_noise_behind_nine_digits_is_no_other_length() -> None:
    moved = np.array([[0.0, 0.0, 0.1 + 3e-11], [0.0, 0.0, 0.1 + 7e-10]])
    assert exact_blocks(moved, np.ones(2)).lengths_mm.tolist() == [0.1, 0.100000001]


@pytest.mark.parametrize("corner", range(7))
@pytest.mark.parametrize("last", [0, 2, 3, 4, 5, 7])
def test_a_corner_at_its_limit_ends_a_part_where_a_stroke_goes_on(corner: int, last: int) -> None:
    """Two blocks ahead, two back, three ahead; of strokes that end before a block."""
    lengths = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    shares = np.zeros(7)
    shares[corner] = 1.0
    strokes = [one for one in ((0, 2), (2, 4), (4, 7)) if one[1] <= last]
    wanted = []
    for number, (first, stop) in enumerate(strokes):
        cuts = [first, *([corner + 1] if first <= corner < stop - 1 else []), stop]
        wanted += [(begin, end, number) for begin, end in pairwise(cuts)]
    parts = parts_of(lengths, shares, last)
    assert (
        list(zip(parts.starts.tolist(), parts.stops.tolist(), parts.strokes.tolist(), strict=True)) == wanted
    )
    if wanted:
        least = least_of_parts(parts, np.array([7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]))
        assert least.tolist() == [8.0 - end - 0.0 for _, end, _ in wanted]


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (12344.9, 12340.0),
        (12345.1, 12350.0),
        (9999.6, 10000.0),
        (0.999949, 0.9999),
        (1000.4, 1000.0),
        (999.96, 1000.0),
    ],
)
def test_four_digits_of_what_lies_at_an_edge(value: float, wanted: float) -> None:
    assert four_digits(np.array([value])).tolist() == [wanted]


def test_the_bounds_of_a_turn_are_those_of_the_control() -> None:
    """In single precision 0.999999 is a little less."""
    assert junction_plan._SINGLE_TURNS_BACK == float(np.float32(0.999999)) != 0.999999


def test_what_is_said_of_a_stroke_of_several_blocks_that_no_feed_makes() -> None:
    """In exact stop 0.3 mm in three blocks take three times what 0.1 mm take; of two strokes the later."""
    law = Junction(every_block_stops=True).along((0.0, 0.0, 1.0), AXES)
    lengths = np.array([0.1, 0.1, -0.05, -0.05, 0.1, 0.1, 0.1, -0.1])
    moved = np.zeros((8, 3))
    moved[:, 2] = lengths
    spans = np.array([0.03, 0.03, 0.03, 0.03, 0.05 / 3.0, 0.05 / 3.0, 0.05 / 3.0, 0.03])
    with pytest.raises(RefusalError) as caught:
        law.feeds_for_spans(law.blocks(moved, lengths), spans, 8)
    said = caught.value
    assert (said.code, said.message) == (
        "VIB030",
        "a stroke of 0.3 mm in 3 blocks takes 60 ms at any feed, 50 ms are wanted",
    )
    assert said.help == "take one block per stroke (WAVE TRIANGLE), or a lower frequency"
    # Of one block, what it lacks: 0.3 mm in 30 ms.
    with pytest.raises(RefusalError, match=r"^a stroke of 0.3 mm in 30 ms needs 1.33 m/s2, Z has 1 m/s2$"):
        law.feeds_for_spans(law.blocks(moved, lengths), np.where(np.arange(8) < 4, spans, 0.01), 7)
    feeds = law.feeds_for_spans(law.blocks(moved, lengths), np.full(8, 0.03), 8)
    took = law.motion_between_dwells(
        np.append(0.0, np.cumsum(lengths)), law.blocks(moved, lengths), feeds
    ).spans_s
    assert [took[:2].sum(), took[2:4].sum(), took[4:7].sum(), took[7]] == pytest.approx(
        [0.06, 0.06, 0.09, 0.03], rel=1e-3
    )
