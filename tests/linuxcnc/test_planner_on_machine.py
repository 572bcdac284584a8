"""The planner model against LinuxCNC's simulated machine, block by block and period by period."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.linuxcnc import LinuxCnc
from longer import short_where
from strokes import feeds_for_times, reached, trace

from . import machine

VIBRATIONS = 8
MEAN_FEED_MM = 0.02  # per vibration
CLEAN_MM, CLEAN_MM_S = 0.5, 5.0
FEW_OF_SEVERAL = (("G61", 2000.0), ("G61.1", 20000.0), ("G64", 20000.0))


@dataclass(frozen=True)
class Case:
    """Strokes of ``stroke_mm`` about an even feed; ``forward_share`` of each vibration goes forward."""

    acceleration_mm_s2: float
    stroke_mm: float
    frequency_hz: float
    feed_mode: str = "G94"
    path_mode: str = "G61"
    speed_rpm: float = 1500.0
    forward_share: float = 0.5

    @property
    def model(self) -> LinuxCnc:
        return LinuxCnc(500.0, self.acceleration_mm_s2, every_block_stops=self.path_mode == "G61.1")

    @property
    def lengths_mm(self) -> NDArray[np.float64]:
        """Differences of the rounded points, as the control sees them."""
        ahead = MEAN_FEED_MM * self.forward_share
        ends = MEAN_FEED_MM * np.arange(VIBRATIONS + 1)
        points = np.column_stack([ends[:-1] + ahead + self.stroke_mm, ends[1:]]).ravel().round(3)
        return np.diff(points, prepend=0.0)

    @property
    def times_s(self) -> NDArray[np.float64]:
        shares = np.array([self.forward_share, 1.0 - self.forward_share])
        return np.tile(shares / self.frequency_hz, VIBRATIONS)

    def feasible(self) -> bool:
        strokes = zip(self.lengths_mm, self.times_s, strict=True)
        return all(self.model.shortest_time(length) <= time for length, time in strokes)

    def words(self, feeds_mm_s: NDArray[np.float64]) -> list[str]:
        """The F words, as rounded as a filter would print them."""
        if self.feed_mode == "G93":
            return [f"F{60 * v / abs(d):.2f}" for v, d in zip(feeds_mm_s, self.lengths_mm, strict=True)]
        if self.feed_mode == "G95":
            return [f"F{60 * v / self.speed_rpm:.4f}" for v in feeds_mm_s]
        return [f"F{60 * v:.2f}" for v in feeds_mm_s]

    def program(self, feeds_mm_s: NDArray[np.float64]) -> bytes:
        points = np.cumsum(self.lengths_mm)
        blocks = [f"G1 Z{-z:.3f} {f}" for z, f in zip(points, self.words(feeds_mm_s), strict=True)]
        clean = f"G94 G1 Z{-points[-1] - CLEAN_MM:.3f} F{60 * CLEAN_MM_S:.0f}"
        head = f"G21 G90 G8 G97 S{self.speed_rpm:.0f} M3\n{self.feed_mode} {self.path_mode}\n"
        return (head + "\n".join([*blocks, clean, "M2", ""])).encode()


def run(cases: list[Case], *, steadily: bool = False) -> list[tuple[Case, NDArray[np.float64], machine.Run]]:
    """Each case with the feeds asked for and what the machine did; one start per acceleration and mode."""
    done = []
    for acceleration, path_mode in sorted({(case.acceleration_mm_s2, case.path_mode) for case in cases}):
        group = [c for c in cases if (c.acceleration_mm_s2, c.path_mode) == (acceleration, path_mode)]
        feeds = [feeds_for_times(case.lengths_mm, case.times_s, case.model) for case in group]
        programs = [case.program(feed) for case, feed in zip(group, feeds, strict=True)]
        options = {"acceleration_mm_s2": acceleration, "lathe": True}
        if steadily:
            runs = machine.run_steadily(programs, **options)
        else:
            runs = machine.run(programs, **options, speed_up=5.0 if path_mode == "G64" else 20.0)
        done += list(zip(group, feeds, runs, strict=True))
    return done


def grid() -> list[Case]:
    """Cases that the machine can run; those of slow strokes in G64 take long and show nothing new."""
    drawn = (
        Case(acceleration, stroke, frequency, *modes)
        for acceleration, stroke, frequency, modes in product(
            (2000.0, 5000.0, 20000.0),
            (0.06, 0.3),
            (5.0, 12.5, 31.25, 62.5),
            (("G94", "G61"), ("G93", "G61.1"), ("G95", "G64")),
        )
    )
    return [
        case for case in drawn if case.feasible() and not (case.path_mode == "G64" and case.frequency_hz < 10)
    ]


# Each path mode on a machine of its own.
FEW = (("G61", 20000.0), ("G61.1", 5000.0), ("G64", 2000.0))


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    ("machines", "least"), [(FEW, 10), pytest.param(None, 36, marks=pytest.mark.long)], ids=["few", "all"]
)
def test_strokes_reach_the_frequency_they_were_asked_for(
    machines: tuple[tuple[str, float], ...] | None, least: int
) -> None:
    cases = [c for c in grid() if machines is None or (c.path_mode, c.acceleration_mm_s2) in machines]
    assert len(cases) >= least
    for case, feeds, done in run(cases):
        assert done.errors == (), case
        measured = np.array([done.line_times()[3 + i] for i in range(2 * VIBRATIONS)])
        expected = case.model.block_times(case.lengths_mm, feeds)
        # In G64 the first blocks depend on how far the program has been read when the first one starts.
        first = 4 if case.path_mode == "G64" else 0
        assert measured[first:] == pytest.approx(expected[first:], abs=1e-9), case

        frequency, per_rev = reached(measured[first:], VIBRATIONS - first / 2, case.speed_rpm)
        assert frequency == pytest.approx(case.frequency_hz, rel=0.01), case
        assert per_rev == pytest.approx(60 * case.frequency_hz / case.speed_rpm, rel=0.01), case
        # Not by the clock: on a busy computer the sped-up machine waits for the program now and then.
        whole = sum(done.line_times().values())
        clean = case.model.block_times([CLEAN_MM], [CLEAN_MM_S])[0]
        assert whole == pytest.approx(VIBRATIONS / case.frequency_hz + clean, rel=0.02, abs=0.003), case


@pytest.mark.linuxcnc("machine")
def test_the_commanded_positions_are_the_predicted_ones() -> None:
    cases = [Case(20000.0, 0.06, 62.5), Case(5000.0, 0.1, 31.25, path_mode="G61.1")]
    cases += [Case(5000.0, 0.1, 20.0, forward_share=0.7), Case(2000.0, 0.05, 30.0, "G95")]
    for case, feeds, done in run(cases, steadily=True):
        lengths = np.r_[case.lengths_mm, CLEAN_MM]
        path = trace(lengths, np.r_[feeds, CLEAN_MM_S], case.model)[:, 1]
        seen = -done.moving()[:, 3]
        assert len(seen) == pytest.approx(len(path), abs=3)
        size = min(len(seen), len(path))
        assert seen[:size] == pytest.approx(path[:size], abs=5e-5), case  # F is rounded


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    ("path_mode", "acceleration"),
    short_where(product(("G61", "G61.1", "G64"), (2000.0, 20000.0)), lambda case: case in FEW_OF_SEVERAL),
)
def test_several_blocks_per_stroke_take_the_predicted_time(path_mode: str, acceleration: float) -> None:
    times = np.full(8 * 10, 0.004)
    waves = [np.arange(1, 81) % 8, np.arange(1, 81) % 4]
    shapes = [0.1 * np.minimum(wave, n - wave) / (n // 2) for wave, n in zip(waves, (8, 4), strict=True)]
    model = LinuxCnc(500.0, acceleration, every_block_stops=path_mode == "G61.1")
    blocks = [np.diff((shape + 0.001 * np.arange(1, 81)).round(4), prepend=0.0) for shape in shapes]
    feeds = [(np.abs(ways) / times * 60).round(2) / 60 for ways in blocks]
    programs = [
        f"G21 G90 G94 {path_mode}\n".encode()
        + b"".join(b"G1 Z%.4f F%.2f\n" % (-z, 60 * f) for z, f in zip(np.cumsum(ways), feed, strict=True))
        + b"G1 Z-1 F300\nM2\n"
        for ways, feed in zip(blocks, feeds, strict=True)
    ]
    runs = machine.run_steadily(programs, acceleration_mm_s2=acceleration, lathe=True)
    for ways, feed, done in zip(blocks, feeds, runs, strict=True):
        spent = np.array([done.line_times()[2 + i] for i in range(80)])
        expected = model.block_times(ways, feed)
        assert spent[8:].sum() == pytest.approx(expected[8:].sum(), rel=0.02)
        assert expected.sum() > 1.1 * times.sum()  # so that asking and getting are not the same thing here


@pytest.mark.linuxcnc("machine")
def test_a_wide_tolerance_swallows_the_strokes() -> None:
    case = replace(Case(20000.0, 0.05, 20.0), path_mode="G64 P0.06")
    (done,) = machine.run(
        [case.program(np.full(2 * VIBRATIONS, 4.0))], acceleration_mm_s2=20000.0, lathe=True
    )

    assert done.errors == ()
    assert np.all(np.diff(done.moving()[:, 3]) <= 0)  # never back
    with pytest.raises(RefusalError, match="drop strokes"):
        replace(case.model, merge_mm=0.06).block_times(case.lengths_mm, 4.0)
