"""What every law says of itself, by its numbers and in words, and what it makes of dwells."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan, sqrt
from typing import Any

import numpy as np
import pytest

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.after_interpolation import AfterInterpolation
from chipbreak.trajectory.filters import NO_FILTER, AxisFilter
from chipbreak.trajectory.ideal import Ideal
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.junctions import Parts
from chipbreak.trajectory.law import AxisLimits, ControlLaw, turns_of
from chipbreak.trajectory.laws import LAWS
from chipbreak.trajectory.linuxcnc import LinuxCnc
from chipbreak.trajectory.look_ahead import LookAhead
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.planner import speed_for_time
from chipbreak.trajectory.trapezoid import Trapezoid, trapezoids

WORDS = (
    *("is_assumed", "needs_acceleration", "needs_filters", "needs_feed_per_minute", "keeps_time"),
    *("is_single_precision", "runs_whole_periods", "plans_whole"),
)
SAID: dict[type[ControlLaw], tuple[str, set[str], int]] = {
    Ideal: ("ideal", {"is_assumed", "keeps_time"}, 1),
    AfterInterpolation: ("after-interpolation", {"needs_filters", "keeps_time"}, 1),
    Trapezoid: ("trapezoid", {"needs_acceleration"}, 15),
    LinuxCnc: ("linuxcnc", {"needs_acceleration", "runs_whole_periods"}, 50),
    Junction: ("junction", {"needs_acceleration", "is_single_precision", "plans_whole"}, 1),
    LookAhead: (
        "look-ahead",
        {
            "needs_acceleration",
            "is_single_precision",
            "plans_whole",
            "needs_filters",
            "needs_feed_per_minute",
        },
        1,
    ),
}
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)


@EVERY_LAW
def test_what_a_law_says_of_itself(law: type[ControlLaw]) -> None:
    name, said, costs = SAID[law]
    assert (law.name, law.unlike_stroke_costs) == (name, costs)
    assert {word for word in WORDS if getattr(law, word)} == said


@EVERY_LAW
def test_a_law_without_numbers_has_no_limits(law: type[ControlLaw]) -> None:
    plain = law()
    assert plain == law(
        velocity_mm_s=inf,
        acceleration_mm_s2=inf,
        every_block_stops=False,
        merge_mm=0.0,
        servo_period_s=0.001,
        blocks_per_s=None,
        axis="",
        per_revolution=False,
        dwell_step_s=0.001,
        axes=(),
    )
    assert plain.read_s == 0.0
    assert law(blocks_per_s=250.0).read_s == 0.004
    assert plain.axes_late_s(10.0) == 0.0
    # What LinuxCNC answers otherwise has a test of its own.
    if law is not LinuxCnc:
        assert (plain.late_s, plain.dwell_delay_s, plain.rest_at_crest_s, plain.least_first_s) == (
            0.0,
            0.0,
            None,
            0.0,
        )
        assert plain.late_behind_s(10.0) == 0.0
        assert plain.rounded(0.0123456) == 0.0123456
        assert list(plain.variants()) == [plain]
        blocks = plain.blocks(np.array([[0.0, 0.0, 1.0]]), np.ones(1))
        assert not plain.must_stand_before(blocks, np.ones(1))


def test_what_linuxcnc_answers_otherwise() -> None:
    law = LinuxCnc(servo_period_s=0.002)
    assert (law.late_s, law.dwell_delay_s, law.rest_at_crest_s) == (0.004, 0.002, 0.0)
    assert LinuxCnc(servo_period_s=0.002, per_revolution=True).rest_at_crest_s == 0.006
    assert LinuxCnc(merge_mm=0.1, per_revolution=True).rest_at_crest_s is None
    assert law.rounded(0.0149) == pytest.approx(0.014)
    assert law.rounded(0.0151) == pytest.approx(0.016)
    # A block may have come a quarter of its way when the next one is known, after one or two periods.
    assert law.least_first_s == pytest.approx(0.008)
    assert LinuxCnc(servo_period_s=0.002, per_revolution=True).least_first_s == pytest.approx(0.016)
    overrides = [one.max_feed_override for one in law.variants()]
    assert overrides == [1.0, 1.2, 1.5, 2.0]
    for known in (LinuxCnc(max_feed_override=1.2), LinuxCnc(per_revolution=True)):
        assert known.variants() == (known,)


AXES = (
    AxisLimits("X", 100.0, 300.0, AxisFilter((0.01,), ())),
    AxisLimits("Y", inf, inf),
    AxisLimits("Z", 60.0, 500.0, AxisFilter((0.03,), (0.02,)), 0.001),
)


@EVERY_LAW
def test_the_limits_along_a_direction_are_those_of_the_axis_that_reaches_its_own_first(
    law: type[ControlLaw],
) -> None:
    along = law().along((-6.0, 0.0, 8.0), AXES)
    # X 100 / 0.6 and 300 / 0.6, Z 60 / 0.8 and 500 / 0.8.
    assert (along.velocity_mm_s, along.acceleration_mm_s2, along.axis) == pytest.approx((75.0, 500.0, "X"))
    assert along.axes == AXES
    only_z = law().along((0.0, 0.0, -0.1), AXES)
    assert (only_z.velocity_mm_s, only_z.acceleration_mm_s2, only_z.axis) == (60.0, 500.0, "Z")
    assert (along.limiting, law().limiting) == ("X has", "the axis has")


def test_slower_axes_are_later_and_have_less_acceleration() -> None:
    slow = AXES[2].slower(0.25)
    assert slow == AxisLimits("Z", 60.0, 400.0, AxisFilter((0.0375,), (0.025,)), 0.001)
    law = Ideal(acceleration_mm_s2=500.0, axes=AXES).slower(0.25)
    assert (law.acceleration_mm_s2, law.axes) == (400.0, tuple(axis.slower(0.25) for axis in AXES))
    assert Ideal(acceleration_mm_s2=500.0).slower(-0.2).acceleration_mm_s2 == pytest.approx(625.0)
    assert AxisLimits("X", 1.0, 2.0) == AxisLimits("X", 1.0, 2.0, NO_FILTER, 0.0)
    # The latest of the axes counts: the average, and the lag from what is left at this speed to half a step.
    assert (
        law.late_behind_s(10.0) == law.axes_late_s(10.0) == max(axis.filter.late_s(10.0) for axis in law.axes)
    )


@EVERY_LAW
@pytest.mark.parametrize("bad", [-1.0, 0.0, nan])
@pytest.mark.parametrize("name", ["velocity_mm_s", "acceleration_mm_s2", "servo_period_s"])
def test_limits_lie_above_zero(law: type[ControlLaw], name: str, bad: float) -> None:
    with pytest.raises(ValueError, match=r"^a control needs limits and a period above zero: "):
        law(**{name: bad})


# --- what is refused --------------------------------------------------------------------------------------


def refused(call: Callable[..., Any], *arguments: Any) -> tuple[str, str, str]:
    with pytest.raises(RefusalError) as caught:
        call(*arguments)
    said = caught.value
    return said.code, said.message, said.help


def test_what_is_said_of_a_stroke_that_is_too_short_in_time() -> None:
    """0.1 mm at 1 m/s2 from rest to rest: 20 ms."""
    law = Trapezoid(velocity_mm_s=50.0, acceleration_mm_s2=1000.0, axis="Z")
    assert refused(law.refuse_too_short, 0.1, 0.016) == (
        "VIB030",
        "a stroke of 0.1 mm in 16 ms needs 1.56 m/s2, Z has 1 m/s2",
        "this stroke takes at least 20 ms; ask for a lower frequency or a smaller stroke",
    )
    law.refuse_too_short(0.1, 0.02 * (1.0 - 1e-10))
    refused(law.refuse_too_short, 0.1, 0.02 * (1.0 - 1e-8))
    # However fast the axis is: that is for another message.
    Trapezoid(velocity_mm_s=1.0, acceleration_mm_s2=1000.0).refuse_too_short(0.1, 0.02)


def test_what_is_said_of_blocks_that_come_too_quickly() -> None:
    law = Trapezoid(acceleration_mm_s2=1e6, blocks_per_s=100.0)
    assert refused(law.refuse_too_short, 0.1, 0.008) == (
        "VIB032",
        "a stroke of 0.1 mm in 8 ms needs 125 blocks per second, the control reads 100",
        "ask for a lower frequency, or one block per stroke",
    )
    law.refuse_too_short(0.1, 0.01 * (1.0 - 1e-10))
    refused(law.refuse_too_short, 0.1, 0.01 * (1.0 - 1e-8))


def test_what_is_said_of_a_feed_that_is_too_high() -> None:
    law = Trapezoid(velocity_mm_s=4.0, acceleration_mm_s2=1000.0, axis="Z")
    # 0.1 mm in 25 ms at 1 m/s2: the trapezoid runs at 5 mm/s.
    feed = speed_for_time(0.1, 0.025, 1000.0)
    assert feed == pytest.approx(5.0)
    assert refused(law.feed_for_time, 0.1, 0.025) == (
        "VIB031",
        "needs 5 mm/s for 0.1 mm in 25 ms, Z has 4 mm/s",
        "ask for a lower frequency or a smaller stroke",
    )
    assert Trapezoid(velocity_mm_s=feed, acceleration_mm_s2=1000.0).feed_for_time(-0.1, 0.025) == feed
    assert refused(Ideal(velocity_mm_s=4.0).feed_for_time, 0.1, 0.02)[1].endswith(
        "in 20 ms, the axis has 4 mm/s"
    )


def test_what_is_said_of_a_whole_cut_that_is_too_fast() -> None:
    law = Ideal(velocity_mm_s=10.0, blocks_per_s=100.0, axis="X")
    moved = np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.3]])
    blocks = law.blocks(moved, np.ones(2))
    assert refused(law.feeds_for_spans, blocks, np.array([0.02, 0.0125]), 2) == (
        "VIB031",
        "the strokes need 1440 mm/min, X has 600",
        "ask for a lower frequency, a smaller stroke or less feed",
    )
    assert (
        "the axis has 600"
        in refused(Ideal(velocity_mm_s=10.0).feeds_for_spans, blocks, np.array([0.02, 0.0125]), 2)[1]
    )
    assert refused(law.feeds_for_spans, blocks, np.array([0.03, 0.03]) / 3.75, 2)[0] == "VIB031"
    slow = Ideal(velocity_mm_s=100.0, blocks_per_s=100.0)
    assert refused(slow.feeds_for_spans, blocks, np.array([0.02, 0.008]), 2) == (
        "VIB032",
        "needs 125 blocks per second, the control reads 100",
        'ask for a lower frequency, or take output.segments = "stroke"',
    )
    # At the very limits both are made.
    edge = Ideal(velocity_mm_s=30.0, blocks_per_s=100.0)
    assert edge.feeds_for_spans(blocks, np.array([0.02, 0.01]), 2).tolist() == pytest.approx([5.0, 30.0])
    refused(slow.feeds_for_spans, blocks, np.array([0.02, 0.01 * (1.0 - 1e-8)]), 2)


@EVERY_LAW
def test_what_is_said_of_strokes_that_the_control_would_drop(law: type[ControlLaw]) -> None:
    control = law(velocity_mm_s=50.0, acceleration_mm_s2=1000.0, merge_mm=0.1)
    lengths = np.array([0.3, 0.3, -0.06, -0.04, 0.5])
    told = (
        "VIB033",
        "the control joins points within 0.1 mm of a line and would drop strokes",
        "the smallest stroke is 0.1 mm; switch to G61, or G64 with a smaller P or Q",
    )
    assert refused(control.refuse_lost_strokes, lengths) == told
    assert refused(control.block_times, lengths, 10.0) == told
    blocks = control.blocks(np.outer(lengths, [0.0, 0.0, 1.0]), lengths)
    assert refused(control.feeds_for_spans, blocks, np.full(5, 0.1), 5) == told
    assert refused(control.motion_between_dwells, np.zeros(6), blocks, np.full(5, 10.0)) == told
    # A larger stroke stays, and so does one that does not turn back, or one that nothing joins.
    control.refuse_lost_strokes(np.array([0.3, 0.3, -0.06, -0.041, 0.5]))
    control.refuse_lost_strokes(np.array([0.03, 0.03]))
    law(velocity_mm_s=50.0, acceleration_mm_s2=1000.0).refuse_lost_strokes(lengths)
    # One block from rest to rest has nothing to be joined with.
    assert control.shortest_time(0.01) == law(velocity_mm_s=50.0, acceleration_mm_s2=1000.0).shortest_time(
        0.01
    )


@pytest.mark.parametrize(
    ("length", "time"),
    [(0.0, 1.0), (1e-12, 1.0), (-1e-13, 1.0), (1.0, 0.0), (1.0, -1.0), (1.0, inf), (1.0, nan), (nan, 1.0)],
)
def test_no_way_and_no_time_have_no_feed(length: float, time: float) -> None:
    with pytest.raises(ValueError, match=f"^no feed for {length} mm in {time} s$"):
        Ideal().feed_for_time(length, time)


@pytest.mark.parametrize(
    ("lengths", "feeds"),
    [([0.0], 1.0), ([1.0, 1e-12], 1.0), ([1.0], 0.0), ([1.0, 1.0], [1.0, -1.0]), ([inf], 1.0), ([nan], 1.0)],
)
def test_blocks_have_a_length_and_a_feed(lengths: list[float], feeds: Any) -> None:
    with pytest.raises(ValueError, match=r"^every block needs a length and a feed or time above zero$"):
        Ideal().checked(lengths, feeds)


def test_one_feed_stands_for_all_and_one_length_is_a_block() -> None:
    lengths, feeds = Ideal().checked([1.0, -2.0, 2e-12], 4.0)
    assert (lengths.tolist(), feeds.tolist()) == ([1.0, -2.0, 2e-12], [4.0, 4.0, 4.0])
    assert Ideal().checked(3, 4)[0].tolist() == [3.0]
    assert turns_of(np.array([1.0, 2.0, -1.0, -1.0, 3.0])).tolist() == [2, 4]


# --- the simple laws --------------------------------------------------------------------------------------


def test_an_ideal_control_takes_length_by_feed() -> None:
    law = Ideal(velocity_mm_s=10.0, blocks_per_s=100.0)
    assert law.block_times([1.0, -1.0, 0.02], [5.0, 20.0, 5.0]).tolist() == [0.2, 0.1, 0.01]
    assert (law.shortest_time(-2.0), law.shortest_time(0.05)) == (0.2, 0.01)
    assert law.feed_for_time(1.0, 0.2) == 5.0
    places = np.array([3.0, 4.0, 3.0])
    blocks = law.blocks(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), np.array([1.0, -1.0]))
    motion = law.motion(places, blocks, np.array([5.0, 20.0]))
    assert motion.spans_s.tolist() == [0.2, 0.1]
    assert motion.time_s.tolist() == pytest.approx([0.0, 0.2, 0.3])
    assert motion.distance_mm.tolist() == [3.0, 4.0, 3.0]
    assert motion[3:] == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("length", "feed", "took"),
    [
        (1.0, 5.0, 1.0 / 5.0 + 5.0 / 100.0),
        (1.0, 10.0, 1.0 / 10.0 + 10.0 / 100.0),
        (1.0, 30.0, 2.0 * sqrt(1.0 / 100.0)),  # too short for 30 mm/s, and for the 20 of the axis
        (9.0, 30.0, 9.0 / 20.0 + 20.0 / 100.0),
        (0.001, 5.0, 2.0 * sqrt(0.001 / 100.0)),
    ],
)
def test_a_trapezoid_from_rest_to_rest(length: float, feed: float, took: float) -> None:
    law = Trapezoid(velocity_mm_s=20.0, acceleration_mm_s2=100.0, reversal_stop_s=0.003, blocks_per_s=100.0)
    times = law.block_times([length, -length], feed)
    assert times.tolist() == pytest.approx([max(took + 0.003, 0.01)] * 2)
    assert law.shortest_time(-length) <= times[0] + 1e-12
    at_most = law.block_times([length], 20.0)[0]
    assert law.shortest_time(length) == pytest.approx(at_most)
    if times[0] > law.shortest_time(length) * (1.0 + 1e-9):
        assert law.feed_for_time(length, float(times[0])) == pytest.approx(feed)


def test_trapezoids_through_joints_by_hand() -> None:
    """100 mm/s2: 1 mm from rest to the 4 mm/s of the joint, 2 mm at 4, 0.5 mm that must stop from 4."""
    lengths = np.array([[1.0, 2.0, 0.5], [1.0, 0.01, 0.02]])
    feeds = np.array([[10.0, 4.0, 20.0], [10.0, 10.0, 10.0]])
    times = trapezoids(lengths, feeds, np.array([100.0, 100.0]))
    top = sqrt(100.0 + 8.0)
    assert top > 10.0
    first = (2.0 * 10.0 - 4.0) / 100.0 + (1.0 - (200.0 - 16.0) / 200.0) / 10.0
    last_top = sqrt(50.0 + 8.0)
    last = (2.0 * last_top - 4.0) / 100.0
    assert times[0].tolist() == pytest.approx([first, 0.5, last])
    # To rest within 0.02 mm from 2 mm/s, and from the root of 6 within 0.03.
    second = sqrt(6.0)
    peak = sqrt(100.0 + 3.0)
    assert times[1].tolist() == pytest.approx(
        [(2.0 * 10.0 - second) / 100.0 + (1.0 - (200.0 - 6.0) / 200.0) / 10.0, (second - 2.0) / 100.0, 0.02]
    )
    assert peak > 10.0


def test_what_stops_at_reversals_stands_there() -> None:
    law = Trapezoid(velocity_mm_s=20.0, acceleration_mm_s2=1e9, reversal_stop_s=0.1)
    parts = Parts(np.array([0, 2]), np.array([2, 3]), np.array([0, 1]))
    times_s, places = law.knots(np.array([1.0, 2.0, 4.0, 3.0]), parts, np.array([0.2, 0.4, 0.3]))
    assert times_s.tolist() == pytest.approx([0.0, 0.2, 0.5, 0.6, 0.8, 0.9])
    assert places.tolist() == [1.0, 2.0, 4.0, 4.0, 3.0, 3.0]
    no_stop = Trapezoid(acceleration_mm_s2=1e9).knots(
        np.array([1.0, 2.0, 4.0, 3.0]), parts, np.array([0.2, 0.4, 0.3])
    )
    assert (no_stop[0].tolist(), no_stop[1].tolist()) == (
        pytest.approx([0.0, 0.2, 0.6, 0.9]),
        [1.0, 2.0, 4.0, 3.0],
    )
    told = refused(Trapezoid(acceleration_mm_s2=1000.0, reversal_stop_s=0.1).refuse_too_short, 0.1, 0.11)
    assert "needs 4 m/s2" in told[1] and "at least 120 ms" in told[2]
    for rounding_s in (0.0, 1e-14, -1e-14):
        stops = Trapezoid(acceleration_mm_s2=1000.0, reversal_stop_s=0.1 + rounding_s)
        told = refused(stops.refuse_too_short, 0.1, 0.1)
        assert told[1] == "a stroke of 0.1 mm in 100 ms leaves no time to move: the control stops as long"


def test_the_peak_of_a_trapezoid_is_between_the_ends_of_its_blocks() -> None:
    law = Trapezoid(velocity_mm_s=20.0, acceleration_mm_s2=100.0)
    moved = np.array([[0.0, 0.0, 0.25], [0.0, 0.0, -9.0]])
    blocks = law.blocks(moved, np.array([1.0, -1.0]))
    assert law.peak_speed_mm_s(blocks, np.array([50.0, 3.0])) == pytest.approx(5.0)
    assert law.peak_speed_mm_s(blocks, np.array([4.0, 3.0])) == 4.0
    assert law.peak_speed_mm_s(blocks, np.array([4.0, 50.0])) == 20.0
    assert law.counted(7.0, 1.0) == 0.0 and law.befores_mm_s == (0.0,)
    assert law.slack_s(3.0) == pytest.approx(0.006)


@pytest.mark.parametrize(
    ("length", "time", "acceleration", "speed"),
    [(0.1, 0.05, inf, 2.0), (1.0, 0.7, 10.0, 2.0), (1.0, 0.6, 10.0, 3.0), (1.0, 0.3, 10.0, 1.5)],
)
def test_the_speed_that_takes_a_time(length: float, time: float, acceleration: float, speed: float) -> None:
    """v + L/v... from L = v·t - v²/a; half of a·t where no time is left at an even speed."""
    assert speed_for_time(length, time, acceleration) == pytest.approx(speed)


# --- dwells -----------------------------------------------------------------------------------------------


def test_a_motion_with_dwells_by_hand() -> None:
    """Two blocks and a dwell, one and a dwell, one; and the same with a dwell at the end."""
    law = Ideal()
    moved = np.zeros((4, 3))
    moved[:, 2] = [1.0, 1.0, 2.0, 2.0]
    blocks = law.blocks(moved, np.ones(4))
    places = np.array([10.0, 11.0, 12.0, 14.0, 16.0])
    feeds = np.array([10.0, 5.0, 10.0, 10.0])
    motion = law.commanded_motion(places, blocks, feeds, np.array([0.0, 0.5, 0.25, 0.0]))
    assert motion.spans_s.tolist() == pytest.approx([0.1, 0.2, 0.2, 0.2])
    assert motion.time_s.tolist() == pytest.approx([0.0, 0.1, 0.3, 0.8, 1.0, 1.25, 1.45])
    assert motion.distance_mm.tolist() == pytest.approx([10.0, 11.0, 12.0, 12.0, 14.0, 14.0, 16.0])
    at_end = law.commanded_motion(places, blocks, feeds, np.array([0.0, 0.0, 0.0, 0.5]))
    assert at_end.time_s.tolist() == pytest.approx([0.0, 0.1, 0.3, 0.5, 0.7, 1.2])
    assert at_end.distance_mm.tolist() == pytest.approx([10.0, 11.0, 12.0, 14.0, 16.0, 16.0])
    for none in (None, np.zeros(4)):
        plain = law.commanded_motion(places, blocks, feeds, none)
        assert plain.time_s.tolist() == pytest.approx([0.0, 0.1, 0.3, 0.5, 0.7])


def test_alike_parts_between_dwells_are_worked_out_once_and_others_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[list[float]] = []
    original = Ideal.motion_between_dwells

    def counted(self: Ideal, distance_mm: Any, blocks: Any, feeds_mm_s: Any) -> Motion:
        asked.append(blocks.moved_mm.ravel().tolist())
        return original(self, distance_mm, blocks, feeds_mm_s)

    monkeypatch.setattr(Ideal, "motion_between_dwells", counted)
    law = Ideal()
    moved = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0 + 1e-12], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    blocks = law.blocks(moved, np.ones(4))
    law.commanded_motion(np.arange(5.0), blocks, np.array([1.0, 1.0, 1.0, 2.0]), np.ones(4))
    assert len(asked) == 3


def test_a_motion_that_ends_late_is_over_before_the_next_one() -> None:
    """LinuxCNC's interpolator goes on two periods behind its blocks: a shorter dwell is made longer."""
    law = LinuxCnc(servo_period_s=0.001, acceleration_mm_s2=1000.0, max_feed_override=1.0).along(
        (0.0, 0.0, 1.0), (*AXES[:2], AxisLimits("Z", 100.0, 1000.0))
    )
    moved = np.zeros((2, 3))
    moved[:, 2] = 1.0
    blocks = law.blocks(moved, np.ones(2))
    for dwell_s in (0.0001, 0.5):
        motion = law.commanded_motion(np.arange(3.0), blocks, np.full(2, 10.0), np.array([dwell_s, 0.0]))
        alone = law.commanded_motion(np.arange(2.0), blocks.part(slice(0, 1)), np.full(1, 10.0))
        assert (np.diff(motion.time_s) > 0.0).all()
        # The planner finds its queue empty in the next period.
        assert motion.spans_s.tolist() == pytest.approx([alone.spans_s[0] + 0.001, alone.spans_s[0]])
        begins_s = max(motion.spans_s[0] + dwell_s, alone.time_s[-1] + 1e-9)
        assert motion.time_s[-1] == pytest.approx(begins_s + alone.time_s[-1])
        assert motion.distance_mm[len(alone.time_s) - 1] == 1.0


# --- motions ----------------------------------------------------------------------------------------------


def test_the_peak_acceleration_of_a_motion() -> None:
    """Steps of 1, 2 and 1 s at 1, 3 and -1 mm/s: changes of 2 and 4 within 1.5 s."""
    motion = Motion(np.array([4.0]), np.array([0.0, 1.0, 3.0, 4.0]), np.array([0.0, 1.0, 7.0, 6.0]))
    assert motion.peak_acceleration_mm_s2 == pytest.approx(4.0 / 1.5)
    still = Motion(np.array([1.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    assert still.peak_acceleration_mm_s2 == 0.0
    quick = Motion(np.array([1.0]), np.array([0.0, 1e-7, 2e-7]), np.array([0.0, 1e-7, 3e-7]))
    assert quick.peak_acceleration_mm_s2 == pytest.approx(1.0 / 1e-6)


def test_a_peak_is_found_wherever_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("chipbreak.trajectory.motion._KNOTS_AT_ONCE", 4)
    for count in range(3, 14):
        for at in range(1, count - 1):
            places = np.zeros(count)
            places[at + 1 :] = 1.0
            motion = Motion(np.array([1.0]), np.arange(float(count)), places)
            assert motion.peak_acceleration_mm_s2 == 1.0, (count, at)


@pytest.mark.parametrize("field", range(7))
def test_a_fingerprint_tells_motions_apart(field: int) -> None:
    fields: list[Any] = [
        np.array([1.0, 2.0]),
        np.array([0.0, 1.0, 3.0]),
        np.array([0.0, 4.0, 5.0]),
        0.1,
        0.2,
        0.3,
        0.4,
    ]
    was = Motion(*fields).fingerprint
    assert Motion(*fields).fingerprint == was
    fields[field] = fields[field] + 1e-9
    assert Motion(*fields).fingerprint != was
