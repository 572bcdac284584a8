"""What the emitted blocks do, read back from their text by the tests' own machine."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import assume, event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from machine_reader import Move, filtered, fit, points, run_program, times, vibration_of

TICK_S = 0.008  # of the drawn cuts
FINE = ("output.decimals=6", "output.feed_decimals=8")
WORKED = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"


# --- the worked example -----------------------------------------------------------------------------------


def test_the_worked_example_runs_as_promised() -> None:
    run = run_program(filtered(WORKED))
    (cut,) = run.cuts
    vibration = vibration_of(cut)
    assert {move.speed_rpm for move in cut} == {2500.0}
    # Feeds are printed with a resolution; over 900 vibrations nothing may add up.
    assert len(vibration.crest_s) > 900
    assert 1.0 / vibration.period_s == pytest.approx(62.5, rel=1e-4)
    assert cut[-1].end == (10.0, 0.0, -30.0)
    assert run.state.speed == 3000.0
    assert times(cut)[-1] == pytest.approx(32.0 / (0.05 * 2500.0) * 60.0, rel=1e-4)


def test_the_first_block_begins_where_the_tool_stands() -> None:
    """Z0.0787 lies between two steps of the output: its way, and so its F, is that from there."""
    program = "G20\nG97 S300 M3\nG95\nG0 X.7874 Z.0787\nG1 Z-.0394 F.0039 E2.5 f50.\nM30\n"
    sets = ("output.decimals=2", "vibration.ramp_vibrations=0", "vibration.alpha=0.75")
    text = filtered(program, "fanuc-lathe", *sets)
    cut = run_program(text).cuts[0]
    first, second = cut[:2]
    assert second.span_s + first.span_s == pytest.approx(0.02, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "sets", "speed_rpm", "per_rev"),
    [
        pytest.param("N1.5", (), 2500.0, 1.5, id="S and N"),
        pytest.param("f62.5", (), 2500.0, 1.5, id="S and f, no tolerance"),
        pytest.param("N1.5 f62.5", (), 2500.0, 1.5, id="N and f"),
        pytest.param(
            "f62.5",
            ("vibration.mn=0.05", "spindle.resolution_rpm=0.1"),
            2586.2,
            1.45,
            id="S and f, tolerance, tenths of rpm",
        ),
        pytest.param(
            "f62.5", ("vibration.mn=0.05",), 2586.0, 3750 / 2586, id="S and f, tolerance, whole rpm"
        ),
        pytest.param("f62.5", ("vibration.alpha=0.75",), 3000.0, 1.25, id="N of 3 ticks forward and 1 back"),
        pytest.param("E2", (), 3000.0, 0.5, id="S and revolutions per vibration"),
        pytest.param("f62.5", ("vibration.rounding=claim-7",), 2500.0, 1.5, id="claim 7"),
        pytest.param("N1.5", ("vibration.correct=count",), 3000.0, 1.25, id="S stays, N gives way"),
    ],
)
def test_speed_and_count(words: str, sets: tuple[str, ...], speed_rpm: float, per_rev: float) -> None:
    program = WORKED.replace("N1.5", words)
    (cut,) = run_program(filtered(program, "generic-lathe", *sets)).cuts
    assert cut[-1].speed_rpm == speed_rpm
    assert vibration_of(cut).per_rev == pytest.approx(per_rev, rel=2e-4)


# --- ramp, share and stroke, fitted back ------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 3.0])
@pytest.mark.parametrize("segments", ["tick", "stroke"])
def test_ramp_exponent(exponent: float, segments: str) -> None:
    ramp = ("vibration.ramp_vibrations=20", f"vibration.ramp_exponent={exponent}")
    sets = (*ramp, f"output.segments={segments}", "output.decimals=5")
    vibration = vibration_of(run_program(filtered(WORKED, "generic-lathe", *sets)).cuts[0])
    ramp_s = 20 * 0.016
    inside = (vibration.crest_s < ramp_s * 0.99) & (vibration.crest_mm > 1e-4)
    assert inside.sum() > 9
    share = vibration.crest_mm[inside] / vibration.stroke_mm
    fitted, scale = np.polyfit(np.log(vibration.crest_s[inside] / ramp_s), np.log(share), 1)
    assert fitted == pytest.approx(exponent, abs=0.03)
    assert scale == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("exponent", [1.0, 3.0])
def test_the_way_out_mirrors_the_way_in(exponent: float) -> None:
    ramp = ("vibration.ramp_vibrations=20", f"vibration.ramp_exponent={exponent}")
    cut = run_program(filtered(WORKED, "generic-lathe", *ramp, *FINE)).cuts[0]
    vibration = vibration_of(cut)
    end_s = times(cut)[-2]
    assert vibration.crest_mm[-18:][::-1] == pytest.approx(
        [np.interp(end_s - t, vibration.crest_s, vibration.crest_mm) for t in vibration.crest_s[-18:][::-1]],
        abs=2e-5,
    )
    assert times(cut)[-1] - times(cut)[-2] >= 60.0 / 2500.0 - 1e-4, "one revolution without vibration"


def test_no_ramp_starts_with_the_full_stroke() -> None:
    cut = run_program(filtered(WORKED, "generic-lathe", "vibration.ramp_vibrations=0")).cuts[0]
    vibration = vibration_of(cut)
    assert vibration.crest_mm[0] == pytest.approx(vibration.stroke_mm, abs=0.0011)


@pytest.mark.parametrize(("alpha", "base_ms", "share"), [(0.5, 4, 0.5), (0.75, 4, 0.75), (0.66, 2, 0.625)])
def test_forward_share(alpha: float, base_ms: int, share: float) -> None:
    sets = (f"vibration.alpha={alpha}", f"command.base_period_ms={base_ms}", "command.min_multiple=8")
    sets = sets if base_ms == 2 else sets[:2]
    cut = run_program(filtered(WORKED, "generic-lathe", *sets, "output.decimals=5")).cuts[0]
    assert vibration_of(cut).forward_share == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(
    ("asks", "stroke_mm"),
    [
        pytest.param("(VIB N1.5 A0.13)", 0.13, id="A is mm"),
        pytest.param("(VIB N1.5 Q1.4)", 0.07, id="Q is a multiple of the feed"),
        pytest.param("(VIB N1.5)", 0.06, id="else 1.2 times the least"),
        pytest.param("(VIB E2)", 0.06, id="half a vibration per revolution"),
        pytest.param("(VIB N1.5 F62.5 ALPHA0.75)", 0.09, id="N 1.5 stands badly for 3 forward, 1 back"),
        pytest.param("(VIB N1.25 F62.5 ALPHA0.75)", 0.06, id="N 1.25 is best for 3 forward, 1 back"),
        pytest.param("(VIB N3 EDGES2)", 0.03, id="two edges share the feed"),
    ],
)
def test_stroke(asks: str, stroke_mm: float) -> None:
    program = WORKED.replace("G1", f"{asks}\nG1").replace(" N1.5\nM30", "\nM30")
    cut = run_program(filtered(program, "generic-lathe", "output.decimals=5")).cuts[0]
    assert vibration_of(cut).stroke_mm == pytest.approx(stroke_mm, abs=1e-4)


def test_a_sine_is_a_sine() -> None:
    sets = ("vibration.waveform=sine", "command.base_period_ms=1", "command.min_multiple=16")
    cut = run_program(filtered(WORKED, "generic-lathe", *sets, *FINE)).cuts[0]
    time_s, vibration = times(cut), vibration_of(cut)
    ahead = (points(cut)[0, 2] - points(cut)[:, 2]) - 0.05 * 2500.0 / 60.0 * time_s
    middle = (time_s > 1.0) & (time_s < 2.0)
    wanted = vibration.stroke_mm / 2 * (1.0 - np.cos(2 * math.pi * time_s[middle] / 0.016))
    assert ahead[middle] == pytest.approx(wanted, abs=2e-5)


# --- any cut ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shape:
    """A drawn program with what is known of its path.  ``corners`` are (x, z) in mm, X as radius."""

    program: str
    corners: tuple[tuple[float, float], ...]
    bulges: tuple[int, ...]
    radius_mm: float
    sets: tuple[str, ...]
    diameter: bool
    unit: float
    step_mm: float
    feed_mm_rev: float
    feed_mode: str
    incremental: bool

    def polyline(self) -> np.ndarray:
        """The path as dense points (x, z)."""
        parts = [np.array([self.corners[0]])]
        for a, b, bulge in zip(self.corners, self.corners[1:], self.bulges, strict=False):
            parts.append(arc_points(a, b, self.radius_mm, bulge) if bulge else np.array([b]))
        return np.concatenate(parts)


def arc_points(a: tuple[float, float], b: tuple[float, float], radius: float, turn: int) -> np.ndarray:
    """Points of the shorter arc from a to b, +1 for G3 (from Z to X counter-clockwise), -1 for G2."""
    a, b = np.array(a[::-1]), np.array(b[::-1])  # (z, x): the order of the plane
    chord = b - a
    length = np.linalg.norm(chord)
    normal = np.array([-chord[1], chord[0]]) / length
    centre = (a + b) / 2 + turn * math.sqrt(radius**2 - length**2 / 4) * normal
    first = math.atan2(*(a - centre)[::-1])
    sweep = (math.atan2(*(b - centre)[::-1]) - first) % (2 * math.pi)
    sweep = sweep if turn > 0 else sweep - 2 * math.pi
    angle = first + sweep * np.linspace(0, 1, 301)[1:]
    return np.column_stack((centre[1] + radius * np.sin(angle), centre[0] + radius * np.cos(angle)))


KINDS = {
    "turning": [(0.0, -1.0)],
    "facing": [(-1.0, 0.0)],
    "taper": [(0.3, -1.0)],
    "boring": [(0.0, 1.0)],
    "chain": [(0.0, -0.5), (0.25, -0.25), (0.0, -0.25)],
    "shoulder": [(0.0, -0.6), (0.4, 0.0)],
    "arc out": [(0.3, -0.3)],
    "arc in": [(0.25, -0.6)],
    "line and arc": [(0.0, -0.5), (0.3, -0.3), (0.2, 0.0)],
}
BULGES = {"arc out": (1,), "arc in": (-1,), "line and arc": (0, 1, 0)}


Words = tuple[Decimal, Decimal]


def block_of(one: Words, other: Words, bulge: int, radius: Decimal, style: str) -> str:
    """A line or an arc from one place to another."""
    words = [f"G{ {0: 1, 1: 3, -1: 2}[bulge] }"]
    for letter, was, now in zip("UW" if style == "UW" else "XZ", one, other, strict=True):
        if now != was or bulge:
            words.append(f"{letter}{now if style == 'absolute' else now - was}")
    words += [f"R{radius}"] if bulge else []
    return " ".join(words)


@st.composite
def shapes(draw: st.DrawFn) -> Shape:
    kind = draw(st.sampled_from(sorted(KINDS)))
    inch = draw(st.booleans())
    unit, digits = (25.4, 4) if inch else (1.0, 3)
    diameter = draw(st.sampled_from([True, True, False]))
    style = draw(st.sampled_from(["absolute", "G91", "UW"]))
    mode = draw(st.sampled_from(["rev", "minute"]))
    written_in = draw(st.sampled_from(["rev", "inverse", "minute"]))
    segments = draw(st.sampled_from(["tick", "stroke", "auto"]))
    wave = "triangle" if segments == "stroke" else draw(st.sampled_from(["triangle", "sine"]))
    per_rev = draw(st.sampled_from(["N0.5", "N1.5", "N2.4", "N1.25", "E3"]))
    bulges = BULGES.get(kind, (0,) * len(KINDS[kind]))
    size = draw(st.floats(6.0, 20.0))
    feed_mm = draw(st.sampled_from([0.05, 0.1, 0.2, 0.31]))
    speed = draw(st.integers(600, 3000))
    start = (draw(st.floats(9.0, 30.0)), draw(st.floats(-5.0, 5.0)))

    def to_grid(mm: float, half: bool) -> Decimal:
        return Decimal(mm / unit * (2 if half else 1)).quantize(Decimal(1).scaleb(-digits))

    def words_of(point: tuple[float, float]) -> tuple[Decimal, Decimal]:
        return to_grid(point[0], diameter), to_grid(point[1], False)

    corner = start
    written = [words_of(start)]
    for dx, dz in KINDS[kind]:
        corner = (corner[0] + dx * size, corner[1] + dz * size)
        written.append(words_of(corner))
    in_mm = tuple((float(x) * unit / (2 if diameter else 1), float(z) * unit) for x, z in written)
    radius = Decimal(round(size * 0.5 / unit, digits)) if any(bulges) else Decimal(0)
    radius = radius.quantize(Decimal(1).scaleb(-digits))
    for a, b, bulge in zip(in_mm, in_mm[1:], bulges, strict=False):
        assume(not bulge or math.dist(a, b) < 1.99 * float(radius) * unit)

    legs = zip(written, written[1:], bulges, strict=False)
    blocks = [block_of(one, other, bulge, radius, style) for one, other, bulge in legs]
    feed = feed_mm / unit * (speed if mode == "minute" else 1)
    blocks[0] += f" F{feed:.6f}"
    head = f"G{20 if inch else 21} G{97} S{speed} M3\nG{94 if mode == 'minute' else 95}\n"
    head += f"G0 X{written[0][0]} Z{written[0][1]}\n" + ("G91\n" if style == "G91" else "")
    body = f"(VIB {per_rev})\n" + "\n".join(blocks) + "\n(VIB OFF)\n"
    tail = "G90 G0 X100. Z100.\nG1 X101. F0.2\nM30\n"
    sets = (
        f"control.x_diameter={str(diameter).lower()}",
        f"output.feed_mode={written_in}",
        f"output.segments={segments}",
        f"vibration.waveform={wave}",
        f"command.base_period_ms={TICK_S * 1000}",
    )
    step = 10.0**-digits * unit
    real_feed = float(f"{feed:.6f}") * unit / (1 if mode == "rev" else speed)
    is_relative = style != "absolute"
    return Shape(
        head + body + tail,
        in_mm,
        bulges,
        float(radius) * unit,
        sets,
        diameter,
        unit,
        step,
        real_feed,
        mode,
        is_relative,
    )


def on_path(shape: Shape, cut: list[Move]) -> tuple[np.ndarray, np.ndarray, float]:
    """For every knot: distance along and off the path; and the length of the path."""
    line = shape.polyline()
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    ends = np.concatenate(([0.0], np.cumsum(lengths)))
    knots = points(cut)[:, [0, 2]]
    direction = np.diff(line, axis=0)
    share = ((knots[:, None, :] - line[None, :-1]) * direction).sum(axis=2) / lengths**2
    share = np.clip(share, 0.0, 1.0)
    feet = line[None, :-1] + share[:, :, None] * direction
    off = np.linalg.norm(feet - knots[:, None, :], axis=2)
    best = off.argmin(axis=1)
    rows = np.arange(len(knots))
    return ends[best] + share[rows, best] * lengths[best], off[rows, best], float(ends[-1])


@pytest.mark.few(15)
@given(shapes())
@hypothesis_settings(max_examples=80)
def test_any_cut_stays_on_its_path_and_in_its_time(shape: Shape) -> None:
    try:
        out = filtered(shape.program, "generic-lathe", *shape.sets, allow_unbroken=True)
        event("taken")
    except chipbreak.ProgramRejectedError as error:
        event(str({d.code for d in error.diagnostics}))
        # N may round to a worse one at a slow spindle; what must not be is any other refusal.
        assert {d.code for d in error.diagnostics if d.severity.value == "error"} <= {"VIB013", "VIB008"}
        return
    run = run_program(out, diameter=shape.diameter)
    assume(run.cuts)  # too short a cut may stay plain here
    (cut,) = run.cuts
    along, off, length_mm = on_path(shape, cut)
    half = 0.5 * shape.step_mm
    corner = math.hypot(half / (2.0 if shape.diameter else 1.0), half)
    assert off.max() <= corner + (0.0011 if any(shape.bulges) else 1e-6)

    # Both ends are exact; no zero-length move; nothing before the start (on lines the foot shows it).
    last = shape.corners[-1]
    assert points(cut)[-1, [0, 2]] == pytest.approx(last, abs=1e-9)
    assert all(math.dist(move.start, move.end) > 1e-7 for move in cut)
    start, first_step = np.array(shape.corners[0]), np.subtract(shape.corners[1], shape.corners[0])
    if not any(shape.bulges):
        back = (points(cut)[:, [0, 2]] - start) @ first_step / np.linalg.norm(first_step)
        assert back.min() >= -corner - 1e-9
        end_step = np.subtract(shape.corners[-1], shape.corners[-2])
        beyond = (points(cut)[:, [0, 2]] - np.array(last)) @ end_step / np.linalg.norm(end_step)
        assert beyond.max() <= corner + 1e-9

    # The time is that of the cut without vibration.
    time_s = times(cut)
    speed = cut[-1].speed_rpm
    feed_mm_s = shape.feed_mm_rev * speed / 60.0
    if shape.feed_mode == "minute":
        programmed = float(shape.program.split(" S")[1].split()[0])
        feed_mm_s = shape.feed_mm_rev * programmed / 60.0
    assert time_s[-1] == pytest.approx(length_mm / feed_mm_s, rel=0.005)

    # The vibration is the promised one, and the stroke never exceeds its title.
    title = dict(zip("NFS", run.titles[0].replace("VIB ", "").split()[:3], strict=True))
    vibration = fit(time_s, along, speed, feed_mm_s)
    period_s = 1.0 / float(title["F"][1:])
    stroke_mm = float(run.titles[0].split()[-1])
    tolerance = 2.0 * shape.step_mm + (0.002 if any(shape.bulges) else 0.0)
    ahead = along - feed_mm_s * time_s
    # Feeds have digits too: what the whole cut is late at its end it may be on the way.
    tolerance += 2.0 * abs(float(ahead[-1]))
    assert ahead.max() <= stroke_mm + tolerance
    assert ahead.min() >= -tolerance
    strong_s = vibration.crest_s[vibration.crest_mm > 0.9 * stroke_mm]
    # Rounding can split a crest in several, and lower one below nine tenths.
    apart = np.flatnonzero(np.diff(strong_s) > 0.5 * period_s) + 1
    middles_s = np.array([part.mean() for part in np.split(strong_s, apart) if len(part)])
    if len(middles_s) > 6 and stroke_mm > 10 * tolerance:
        counted = np.rint(np.diff(middles_s) / period_s).sum()
        # Rounding moves a crest by one tick at most.
        slack_s = 2 * TICK_S / counted + 0.01 * period_s
        assert (middles_s[-1] - middles_s[0]) / counted == pytest.approx(period_s, abs=slack_s)


def test_the_time_of_a_move_that_rounds_to_nothing_is_kept() -> None:
    """The last return stroke ends where its forward stroke did: its 16 ms must not go to the plain end."""
    program = "G94 G97 S600 M3\nG0 X18. Z0.\nG3 X21.6 Z-1.8 R3. F60. N2.4\nG0 X50.\nM30\n"
    sets = ("output.feed_mode=minute", "command.base_period_ms=8")
    (cut,) = run_program(filtered(program, "generic-lathe", *sets)).cuts
    arc_mm = 3.0 * 2.0 * math.asin(math.hypot(1.8, 1.8) / 6.0)
    assert times(cut)[-1] == pytest.approx(arc_mm, rel=0.001)


@pytest.mark.few(15)
@given(shapes().filter(lambda s: s.incremental))
@hypothesis_settings(max_examples=40)
def test_incremental_words_sum_exactly(shape: Shape) -> None:
    try:
        out = filtered(shape.program, "generic-lathe", *shape.sets, allow_unbroken=True)
    except chipbreak.ProgramRejectedError:
        assume(False)
    cuts = run_program(out, diameter=shape.diameter).cuts
    assume(cuts)  # too short a cut may stay plain here
    (cut,) = cuts
    total = {"X": Decimal(0), "Z": Decimal(0)}
    for move in cut:
        for letter, text in move.words.items():
            total[{"U": "X", "W": "Z"}.get(letter, letter)] += Decimal(text)
    wanted = {"X": Decimal(0), "Z": Decimal(0)}
    for line in shape.program.split("(VIB OFF)")[0].splitlines()[3:]:
        for word in line.split():
            letter = {"U": "X", "W": "Z"}.get(word[0], word[0])
            if letter in wanted and line.startswith("G") and line[1] in "123":
                wanted[letter] += Decimal(word[1:])
    assert total == wanted


@pytest.mark.few(15)
@given(shapes())
@hypothesis_settings(max_examples=40)
def test_the_control_is_as_it_was_at_every_line_of_the_original(shape: Shape) -> None:
    try:
        out = filtered(shape.program, "generic-lathe", *shape.sets, allow_unbroken=True)
    except chipbreak.ProgramRejectedError:
        assume(False)
    was = run_program(shape.program, diameter=shape.diameter)
    now = run_program(out, diameter=shape.diameter)
    before = dict(was.outside)
    arc_last = bool(shape.bulges[-1])
    for line, state in now.outside:
        other = before[line]
        point, other_point = state.point, other.point
        assert point == pytest.approx(other_point, abs=1e-9), line
        # The new speed may stay while nothing cuts; behind an arc the next move says its own code.
        free = {"point": other_point}
        if line.startswith(("(VIB OFF", "G90 G0")):
            free |= {"speed": other.speed} | ({"motion": other.motion} if arc_last else {})
        assert replace(state, **free) == replace(other, point=other_point), line
    assert now.moves[-1].speed_rpm == was.moves[-1].speed_rpm


# --- the verdict against the closed form ------------------------------------------------------------------


@given(
    wave=st.sampled_from(["triangle", "sine"]),
    alpha=st.sampled_from([0.5, 0.75]),
    per_rev=st.floats(0.3, 3.4).map(lambda n: round(n, 2)),
    ratio=st.floats(0.6, 3.0).map(lambda q: round(q, 2)),
    edges=st.sampled_from([1, 1, 2]),
)
@hypothesis_settings(max_examples=40)
def test_verdict_is_the_closed_form(
    wave: str, alpha: float, per_rev: float, ratio: float, edges: int
) -> None:
    alpha = 0.5 if wave == "sine" else alpha
    delta = per_rev / edges % 1.0
    assume(0.02 < delta < 0.98)
    drop = math.sin(math.pi * delta)
    if wave == "triangle":
        drop = min(delta / (1.0 - alpha), (1.0 - delta) / alpha)
    margin = ratio * edges * drop
    assume(abs(margin - 1.0) > 0.05)
    period_ms = 1 if wave == "sine" else 4
    asks = f"(VIB F62.5 N{per_rev} Q{ratio} ALPHA{alpha} EDGES{edges})"
    program = f"G97 S1000 M3\nG0 X20. Z2.\n{asks}\nG1 Z-18. F0.2\nM30\n"
    sets = (
        f"vibration.waveform={wave}",
        "command.periods_ms=[16]",
        f"command.base_period_ms={period_ms}",
        "output.decimals=5",
        "spindle.resolution_rpm=0.001",
        "vibration.phase=0.5",
    )
    settings = chipbreak.load("generic-lathe", sets)
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    (checked,) = result.cuts
    assert checked.verdict.breaks == (margin > 1.0)
    assert checked.verdict.margin == pytest.approx(margin, rel=0.03)


# --- words, modes and numbers -----------------------------------------------------------------------------


def test_radius_and_diameter_words_are_the_same_cut() -> None:
    facing = "G97 S2500 M3\nG0 X{0} Z0.\nG1 X{1} F0.1 N1.5\nM30\n"
    by_diameter = run_program(filtered(facing.format("40.", "2.")))
    by_radius = run_program(
        filtered(facing.format("20.", "1."), "generic-lathe", "control.x_diameter=false"), diameter=False
    )
    one, other = (points(run.cuts[0])[:, 0] for run in (by_diameter, by_radius))
    assert one == pytest.approx(other, abs=0.0008)


def test_every_decimal_point_rule_gives_what_its_control_reads() -> None:
    plain = WORKED
    for rule, z in (("calculator", "-30"), ("increment", "-30000"), ("required", "-30.")):
        out = filtered(plain.replace("-30.", z), "generic-lathe", f"control.decimal_point={rule}")
        cut = run_program(out).cuts[0]
        assert cut[-1].end[2] == -30.0
        assert all("." in text for move in cut for text in move.words.values()), "no number without its point"


@pytest.mark.parametrize(
    ("codes", "there", "back"),
    [(("G98",), "G99", "G98"), (("G94",), "G95", "G94"), (("G95", "G94"), "G95", "G94")],
    ids=["lathe codes", "mill codes", "both in the program"],
)
def test_feed_mode_codes_are_those_of_the_program(codes: tuple[str, ...], there: str, back: str) -> None:
    head = "".join(f"{code}\n" for code in codes)
    out = filtered("G97 S3000 M3\n" + head + "G0 X20. Z2.\nG1 Z-30. F150. N1.5\nG0 X30.\nM30\n")
    inside = out.split("BEGIN VIB")[1].split("(CHIPBREAK END")[0].splitlines()
    assert there in inside
    assert inside[-1] == f"{back} F150."


def test_words_that_act_first_stand_before_the_cut() -> None:
    out = filtered("G97 S3000\nG0 X20. Z2.\nN30 G1 M3 Z-30. F0.05 N1.5 M8 (ROUGH)\nM30\n")
    lines = out.splitlines()
    first_move = next(i for i, line in enumerate(lines) if line.startswith("G1 "))
    assert "M3 M8" in lines[:first_move]
    assert any(line.startswith("N30 (CHIPBREAK BEGIN") for line in lines), "a jump to N30 finds it"


def test_comments_between_the_blocks_of_a_chain_stay() -> None:
    out = filtered(
        "G97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-5. F0.05\n(the groove)\n\nX30.\n(VIB OFF)\nM30\n"
    )
    assert out.count("\n(the groove)\n") == 1
    assert len(run_program(out).cuts) == 1


@pytest.mark.parametrize(
    "between",
    ["G0 X30.", "M0", "M8", "S2000", "T0202\nG0 X20. Z-5.", "(VIB OFF)\nG1 X30. F0.1\n(VIB N1.5)", "G4 X1."],
)
def test_a_chain_ends_at(between: str) -> None:
    again = "(VIB N1.5)\n" if between.startswith("T") else ""
    program = f"G97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-5. F0.05\n{between}\n{again}G1 Z-10. F0.05\nM30\n"
    assert len(run_program(filtered(program)).cuts) == 2


def test_a_chain_runs_over_the_joints() -> None:
    program = "G97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-5. F0.05\nX22. Z-6.\nX30.\nM30\n"
    assert len(run_program(filtered(program)).cuts) == 1


def test_a_full_circle_needs_no_end_words() -> None:
    program = "G97 S3000 M3\nG0 X20. Z2.\nG2 I10. F0.05 N1.5\nG1 X30.\nM30\n"
    (cut,) = run_program(filtered(program)).cuts
    knots = points(cut)
    radius = np.hypot(knots[:, 0] - 20.0, knots[:, 2] - 2.0)
    assert radius == pytest.approx(np.full(len(knots), 10.0), abs=0.002)
    assert times(cut)[-1] == pytest.approx(20 * math.pi / (0.05 * 2500.0) * 60.0, rel=0.003)


def test_a_long_arc_by_negative_radius() -> None:
    program = "G97 S3000 M3\nG0 X20. Z2.\nG2 X20. Z-8. R-6. F0.05 N1.5\nG1 X30.\nM30\n"
    (cut,) = run_program(filtered(program)).cuts
    length_mm = 6.0 * (2 * math.pi - 2 * math.asin(5.0 / 6.0))
    assert times(cut)[-1] == pytest.approx(length_mm / (0.05 * 2500.0) * 60.0, rel=0.003)
