"""The dwell form: what stands in the output, what chips it makes, what is refused."""

from __future__ import annotations

import math
import re
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import assume, event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.editing import bracket
from chipbreak.editing.restore import restore
from chipbreak.kinematics.piecewise import rests_of
from chipbreak.pipeline import verify_filtered
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.source import read
from machine_reader import filtered, run_program

DWELL = "vibration.waveform=dwell"
WORKED = "G97 S1200 M3\nG0 X20. Z2.\nG1 Z-28. F0.1 E2.4\nG0 X30.\nM30\n"


def result(program: str, profile: str, *sets: str) -> chipbreak.Result:
    return chipbreak.rewrite(program.encode(), chipbreak.load(profile, sets))


def knots(text: str, speed_rpm: float, feed_mm_rev: float) -> tuple[np.ndarray, np.ndarray]:
    """Time and Z of a cut along Z on a control without limits, from the text alone: moves at F, and G4 X."""
    time_s, z, now_s = [0.0], [2.0], 0.0
    for line in text.split("BEGIN")[1].splitlines():
        stand, move = re.fullmatch(r"G4 X([0-9.]+)", line), re.fullmatch(r"(?:G1 )?Z(\S+)(?: F\S+)?", line)
        if stand or move:
            way_mm = abs(float(move[1]) - z[-1]) if move else 0.0
            now_s += float(stand[1]) if stand else way_mm / feed_mm_rev / speed_rpm * 60.0
            time_s.append(now_s)
            z.append(float(move[1]) if move else z[-1])
    return np.array(time_s), np.array(z)


def thinnest(time_s: np.ndarray, z: np.ndarray, speed_rpm: float) -> np.ndarray:
    """Chip thickness of one edge, every thousandth of a revolution, over every earlier one."""
    turn_s = 60.0 / speed_rpm
    turns = int(time_s[-1] / turn_s)
    grid = np.arange(turns * 1000) * turn_s / 1000.0
    tool = np.interp(grid, time_s, z[0] - z).reshape(turns, 1000)
    wall = np.maximum.accumulate(np.vstack([np.zeros(1000), tool]))[:-1]
    return (tool - wall).ravel()


def test_the_worked_example() -> None:
    done = result(WORKED, "fanuc-lathe", DWELL)
    text = done.data.decode()
    (cut,) = done.cuts
    # 120 ms a vibration, half of it standing; 0.1 mm/rev at 1200 rpm is 2 mm/s for the other half.
    assert text.count("G4 X0.06\n") == 249
    assert "G1 Z1.88 F0.1\nG4 X0.06\nZ1.760\nG4 X0.06\n" in text
    assert re.findall(r"(?m)^[GZ].* F\S+", text) == ["G1 Z1.88 F0.1"]
    time_s, z = knots(text, 1200.0, 0.1)
    assert z[-1] == -28.0
    assert time_s[-1] == pytest.approx(15.0 + 249 * 0.06) == cut.duration_s
    thick = thinnest(time_s, z, 1200.0)
    ends = np.flatnonzero((thick[:-1] > 1e-9) & (thick[1:] <= 1e-9))
    assert len(ends) == 249
    assert (
        thick.max()
        == pytest.approx(0.1, rel=1e-3)
        == pytest.approx(cut.verdict.peak_thickness * 0.1, rel=1e-3)
    )
    assert np.diff(ends).max() / 1000.0 == pytest.approx(2.4, abs=0.002)
    assert cut.verdict.longest_chip_rev == pytest.approx(2.4 - 0.2, abs=0.01)
    assert cut.verdict.margin == pytest.approx(1.2)
    assert cut.verdict.chips_per_rev == pytest.approx(1 / 2.4, rel=1e-3)


def test_a_dwell_as_long_as_the_vibration_is_refused() -> None:
    """In 50 ms there is one of 50 ms, and nothing is left to feed in: not even a way of 1e-18 mm."""
    program = "G97 S3000 M3\nG98\nG0 X60. Z1.\nG1 Z-5. F120. f20.\nG0 X80.\nM30\n"
    sets = (DWELL, "planner.dwell_step_ms=50", "command.base_period_ms=10")
    with pytest.raises(chipbreak.ProgramRejectedError, match="leaves no time to feed in 50 ms") as caught:
        result(program, "linuxcnc-lathe", *sets)
    assert "VIB086" in [one.code for one in caught.value.diagnostics]


@pytest.mark.few(8)
@given(
    turns=st.floats(0.6, 6.0).map(lambda e: round(e, 2)),
    alpha=st.sampled_from([0.25, 0.4, 0.5, 0.6, 0.75]),
    speed=st.integers(300, 2000),
    edges=st.sampled_from([1, 1, 2]),
)
@hypothesis_settings(max_examples=60)
def test_it_breaks_where_it_stands_a_revolution_and_is_refused_elsewhere(
    turns: float, alpha: float, speed: int, edges: int
) -> None:
    program = f"G97 S{speed} M3\nG0 X20. Z2.\n(VIB E{turns} ALPHA{alpha} EDGES{edges})\nG1 Z-18. F0.1\nM30\n"
    sets = (DWELL, "command.base_period_ms=1")
    try:
        done = result(program, "fanuc-lathe", *sets)
    except chipbreak.ProgramRejectedError as error:
        event("refused")
        codes = {d.code for d in error.diagnostics}
        assume(not codes & {"VIB005", "VIB008", "VIB013"})
        assert codes == {"VIB086"}
        # A whole number of milliseconds may take a little from what was asked.
        assert turns * (1.0 - alpha) < 1.0 / edges + 1.0 * speed / 60_000.0 + 0.01
        return
    event("taken")
    (cut,) = done.cuts
    stand_s = float(re.findall(r"G4 X([0-9.]+)", done.data.decode())[0])
    rev_s = 60.0 / cut.plan.solution.speed_rpm
    assert cut.verdict.breaks
    assert cut.verdict.margin == pytest.approx(stand_s / rev_s * edges)
    assert cut.verdict.margin >= 1.0 - 1e-9  # a stand of exactly a revolution will do
    assert stand_s / rev_s == pytest.approx(turns * (1.0 - alpha), abs=2.0 * speed / 60_000.0 + 0.02)
    assert cut.verdict.per_rev == pytest.approx(1.0 / turns, rel=0.02)
    assert {move.span_s > 0.0 for move in run_program(done.data.decode()).moves} == {True}


@pytest.mark.parametrize("form", [(), ("output.form=loop",)])
@pytest.mark.parametrize("size", [3.0, 6.0, 0.36])
def test_a_stand_at_the_end_takes_in_that_of_the_last_vibration(size: float, form: tuple[str, ...]) -> None:
    """The cut is a whole number of moves long, so it ends with one of its stands, and that is long enough."""
    program = f"G97 S1200 M3\nG98\nG0 X60. Z2.\nG1 Z{2.0 - size:.2f} F120. E2.5\nG0 X80.\nM30\n"
    done = result(program, "fanuc-lathe", DWELL, "vibration.end=dwell", *form)
    (cut,) = done.cuts
    each_s = cut.each_dwell_s
    count = round(size / 0.12)
    assert list(cut.expansion.dwell_s) == [each_s] * count
    assert cut.plan.end_dwell_s < each_s
    assert cut.expansion.planned_s == pytest.approx(count * 0.124)
    assert cut.duration_s == pytest.approx(count * 0.124, abs=1e-9)


@pytest.mark.few(10)
@given(
    size=st.floats(3.0, 20.0).map(lambda d: round(d, 3)),
    taper=st.sampled_from([0.0, 0.3, -0.2]),
    style=st.sampled_from(["absolute", "UW", "loop"]),
    end=st.sampled_from(["feed", "dwell"]),
    mode=st.sampled_from(["G99", "G98"]),
)
@hypothesis_settings(max_examples=40)
def test_any_cut_ends_at_its_end_and_keeps_its_feed(
    size: float, taper: float, style: str, end: str, mode: str
) -> None:
    x, z = round(2 * taper * size, 3), -size
    where = f"U{x:.3f} W{z:.3f}" if style == "UW" else f"X{60 + x:.3f} Z{2 + z:.3f}"
    feed = "F0.1" if mode == "G99" else "F120."
    program = f"G97 S1200 M3\n{mode}\nG0 X60. Z2.\nG1 {where} {feed} E2.5\nG0 X80.\nM30\n"
    sets = (DWELL, f"vibration.end={end}", *(["output.form=loop"] if style == "loop" else []))
    done = result(program, "fanuc-lathe", *sets)
    text = done.data.decode()
    (cut,) = done.cuts
    assert restore(read(done.data)).data.decode() == program
    assert chipbreak.rewrite(done.data, chipbreak.load("fanuc-lathe", sets)).data == done.data
    inside = text.split("DWELL)\n")[1].split("(CHIPBREAK END")[0].split("E2.5)\n")[1]
    assert re.findall(r"\bF\S+", inside) == [feed]  # once, as it was written
    assert ("G98" in inside) == ("G99" in inside) == False  # noqa: E712
    length = math.hypot(x / 2, z)
    stands = [float(s) for s in re.findall(r"G4 X([0-9.]+)", inside)]
    if style != "loop":
        speed_rpm = cut.plan.solution.speed_rpm
        feed_mm_s = 2.0 if mode == "G98" else 0.1 * speed_rpm / 60.0
        assert cut.duration_s == pytest.approx(length / feed_mm_s + sum(stands), rel=1e-3)
        (moves,) = run_program(text).cuts
        assert moves[-1].end == pytest.approx((30 + x / 2, 0.0, 2 + z), abs=1e-9)
        along = [-move.end[2] for move in moves]
        assert along == sorted(along)
    if style == "UW":
        for letter, wanted in (("U", x), ("W", z)):
            words = [Decimal(t) for t in re.findall(rf"{letter}(-?[0-9.]+)", inside)]
            assert sum(words) == Decimal(f"{wanted:.3f}")
    turn_s = 60.0 / cut.plan.solution.speed_rpm
    assert inside.splitlines()[-1].startswith("G4") == (end == "dwell")
    assert stands[-1] >= turn_s


def test_the_shoulder_may_be_cleaned_by_standing() -> None:
    program = WORKED.replace("E2.4", "N1.5")
    plain, standing = (filtered(program, "fanuc-lathe", f"vibration.end={end}") for end in ("feed", "dwell"))
    assert "G4" not in plain
    # 1.5 vibrations in a revolution of 1250 rpm: it stands for that at the end.
    assert re.search(r"\nZ-28\. F\S+\nG4 X0\.048\nF0\.1\n\(CHIPBREAK END", standing)
    assert len(run_program(standing).cuts[0]) > len(run_program(plain).cuts[0])
    (cut,) = result(program, "fanuc-lathe", "vibration.end=dwell").cuts
    assert cut.duration_s == pytest.approx(cut.wave.duration_s + 0.048, rel=1e-4)
    none = filtered(program, "fanuc-lathe", "vibration.end=dwell", "vibration.end_revolutions=0")
    assert "G4" not in none


def test_a_dwell_that_is_not_the_planned_one_is_found() -> None:
    out = filtered(WORKED, "fanuc-lathe", DWELL)
    for text, other in (("G4 X0.06\n", "G4 X0.05\n"), ("G4 X0.06\n", ""), ("Z1.760\n", "Z1.760\nG4 X1.\n")):
        head, body, tail = re.split(r"(?<=DWELL\)\n)(.*?)(?=\(CHIPBREAK END)", out, maxsplit=1, flags=re.S)
        body = body.replace(text, other, 1)
        tail = re.sub("END [0-9A-F]{8}", f"END {bracket.checksum(body.encode())}", tail, count=1)
        with pytest.raises(SelfCheckError, match="stand"):
            verify_filtered((head + body + tail).encode(), chipbreak.load("fanuc-lathe", [DWELL]))


@pytest.mark.parametrize(
    ("profile", "head", "wish"),
    [
        ("fanuc-lathe", "G97 S1200 M3\nG0 X20. Z2.\n", "N0.75"),
        ("fanuc-lathe", "G97 S777 M3\nG0 X20. Z2.\n", "E1.1"),
        ("linuxcnc-lathe", "G21 G18 G90 G8 G97 G95 S1250 M3\nG0 X10 Z2\n", "E2"),
        ("linuxcnc-lathe", "G21 G18 G90 G8 G97 G95 S400 M3\nG0 X10 Z2\n", "E3 ALPHA0.75"),
    ],
)
def test_the_way_out_of_a_short_stand_works(profile: str, head: str, wish: str) -> None:
    program = head + "(VIB {})\nG1 Z-10. F0.1\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        result(program.format(wish), profile, DWELL)
    (refusal,) = caught.value.diagnostics
    assert refusal.code == "VIB086"
    turns = re.search(r"take E ([0-9.]+)", refusal.help)
    assert turns
    alpha = wish.partition(" ")[2]
    (cut,) = result(program.format(f"E{turns[1]} {alpha}"), profile, DWELL).cuts
    assert cut.verdict.breaks


def test_a_control_that_cannot_swing_is_told_of_the_dwell() -> None:
    program = "G21 G18 G90 G8 G97 G95 S2500 M3\nG0 X10 Z2\n(VIB {})\nG1 Z-3 F0.1\nM2\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        result(program.format("N1.5"), "linuxcnc-lathe")
    (refusal,) = caught.value.diagnostics
    assert refusal.code == "VIB030"
    way_out = re.search(r"WAVE DWELL with E ([0-9.]+)", refusal.help)
    assert way_out
    (cut,) = result(program.format(f"E{way_out[1]} WAVE DWELL"), "linuxcnc-lathe").cuts
    assert cut.verdict.breaks
    assert cut.verdict.margin > 1.0


def test_the_control_takes_what_it_needs_from_the_stand() -> None:
    """Speeding up and braking make the move longer; N stays, and the tool stands for less."""
    program = "G21 G18 G90 G8 G97 G95 S1200 M3\nG0 X10 Z2\n(VIB E2.5 WAVE DWELL)\nG1 Z-10 F0.1\nM2\n"
    times = {}
    for acceleration in (500, 5000):
        limit = f"axes.Z.max_acceleration_mm_s2={acceleration}"
        (cut,) = result(program, "linuxcnc-lathe", limit).cuts
        times[acceleration] = float(cut.expansion.dwell_s[0])
        assert cut.verdict.per_rev == pytest.approx(cut.plan.solution.per_rev, rel=1e-3)
    assert times[500] == pytest.approx(times[5000] - 0.004, abs=0.0011)


def test_rests() -> None:
    time_s, way = np.array([0.0, 1.0, 3.0, 4.0, 4.5, 5.0, 9.0]), np.array([0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    rests = rests_of(time_s, way, 1e-9)
    assert rests.begin.tolist() == [1, 3]  # what it does behind the last move is no rest between two
    assert rests.dwell_s.tolist() == [2.0, 0.5]
    assert rests.shortest_s(np.array([1])) == 2.0
    assert rests.shortest_s(np.array([], dtype=np.intp)) == 0.0


GRBL = ("axes.X.max_acceleration_mm_s2=500", "axes.Z.max_acceleration_mm_s2=500", DWELL)
ON_GRBL = "G21 G90 G94\nS1250 M3\nG0 X10. Z2.\nG1 Z-8. F125. E6\nG0 X30.\nM30\n"


@pytest.mark.parametrize(("step_ms", "profile"), [(50, "grbl"), (50, "grblhal-lathe"), (20, "grbl")])
def test_a_dwell_takes_whole_steps_of_the_control_and_the_vibration_keeps_its_time(
    step_ms: int, profile: str
) -> None:
    filtered_by = result(ON_GRBL, profile, *GRBL, f"planner.dwell_step_ms={step_ms}")
    (cut,) = filtered_by.cuts
    dwells = {Decimal(found) for found in re.findall(r"G4 P([0-9.]+)", filtered_by.data.decode())}
    assert dwells
    assert all(dwell * 1000 % step_ms == 0 for dwell in dwells)
    assert cut.verdict.breaks
    assert cut.verdict.per_rev == pytest.approx(cut.plan.solution.per_rev, rel=0.003)


def test_a_step_of_a_dwell_that_leaves_no_time_to_feed_is_refused() -> None:
    with pytest.raises(chipbreak.ProgramRejectedError, match="whole 500 ms") as caught:
        result(ON_GRBL, "grbl", *GRBL, "planner.dwell_step_ms=500")
    assert "VIB086" in str(caught.value.diagnostics)


def test_klipper_counts_milliseconds() -> None:
    program = "G21\nG90\nM3 S1250\nG0 X10. Z2.\nG1 Z-8. F125. E6\nG0 X30.\n"
    sets = (DWELL, "planner.path_acceleration_mm_s2=500")
    filtered_by = result(program, "klipper", *sets)
    (cut,) = filtered_by.cuts
    text = filtered_by.data.decode()
    (each,) = {float(found) for found in re.findall(r"G4 P([0-9.]+)", text)}
    assert each == pytest.approx(1000.0 * cut.each_dwell_s)


def test_legs_along_axes_that_are_not_alike_take_their_own_times() -> None:
    """As long a way takes longer along the slower axis, also where it looks like one before."""
    program = "G21 G90 G94\nS1250 M3\nG0 X10. Z2.\n(VIB E6)\nG1 Z-3. F125.\nX13.\n(VIB OFF)\nG0 X30.\nM30\n"
    slow = ("axes.X.max_acceleration_mm_s2=100", "axes.Z.max_acceleration_mm_s2=1000", DWELL)
    (cut,) = result(program, "grbl", *slow).cuts
    ways_mm = np.diff(cut.expansion.distance_mm, prepend=0.0)
    feed_mm_s = 125.0 / 60.0
    spans_s = []
    rest = True
    for end_mm, way_mm, dwell_s in zip(
        cut.expansion.distance_mm, ways_mm, cut.expansion.dwell_s, strict=True
    ):
        has = 1000.0 if end_mm <= 5.0 + 1e-6 else 100.0
        ramps = (1.0 if rest else 0.0) + (1.0 if dwell_s > 0.0 else 0.0)
        spans_s.append(way_mm / feed_mm_s + ramps * feed_mm_s / has / 2.0 + dwell_s)
        rest = dwell_s > 0.0
    assert cut.duration_s == pytest.approx(sum(spans_s), rel=0.003)


@pytest.mark.parametrize("unit", ["G94", "G95"])
def test_a_dwell_cut_is_timed_in_the_feed_mode_of_its_program(unit: str) -> None:
    """Its blocks keep the program's feed, so the one of the profile says nothing of them."""
    feed = {"G94": "F417", "G95": "F0.139"}[unit]
    program = (
        f"G21 G18 G90 G8 G97 {unit} S3000 M3\nG0 X8 Z0.5\n(VIB E4 WAVE DWELL)\n"
        f"G1 Z-4.753 {feed}\nG2 X10.336 Z-7.089 I2.336 K0\nG1 X13.\nM2\n"
    )

    def duration_s(mode: str) -> float:
        sets = ["axes.X.max_acceleration_mm_s2=5000", "axes.Z.max_acceleration_mm_s2=5000"]
        sets += ["planner.max_feed_override=1.2", f"output.feed_mode={mode}"]
        (cut,) = chipbreak.rewrite(program.encode(), chipbreak.load("linuxcnc-lathe", sets)).cuts
        return cut.duration_s

    assert duration_s("rev") == duration_s("minute")


@pytest.mark.parametrize("form", ["expanded", "loop"])
def test_a_dwell_at_a_corner_is_as_long_as_others(form: str) -> None:
    """Z-2.4 is fifty moves of 0.048 mm away and X35.2 a hundred more, so the tool dwells at both corners."""
    program = "G97 S1200 M3\nG94\nG0 X40. Z0.\n(VIB N0.5)\nG1 Z-2.4 F60.\nX35.2\nZ-3.36\nG0 X80.\nM30\n"
    sets = (DWELL, "vibration.edges=4", "output.feed_mode=minute", f"output.form={form}")
    done = result(program, "haas-mill", *sets)
    (cut,) = done.cuts
    # One revolution at the end is cut plainly.
    assert np.diff(cut.expansion.time_s, prepend=0.0)[:-1] == pytest.approx(np.full(168, 0.1))
    assert cut.expansion.dwell_s[:-1] == pytest.approx(np.full(168, cut.each_dwell_s))
    if form == "loop":
        assert done.data.count(b"WHILE") == 3
        return
    places = [move.end for move in run_program(done.data.decode()).cuts[0] if move.span_s > 0.0]
    corner = min(places, key=lambda end: abs(end[2] + 2.4) + abs(end[0] - 20.0))
    assert corner == pytest.approx((20.0, 0.0, -2.4), abs=1e-6)
