"""Some of the cuts drawn at random, on the simulated machine; ``benchmarks/real_control.py`` runs more."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from . import drawn as drawn_cuts
from .drawn import NOTHING_KEPT, PATHS, Cut, Kept, Ran, drawn, kept, run_cuts
from .settled import UNSETTLED

SEEDS = (2, 3, 4, 8, 9, 10, 12, 16, 37, 58)
# A stroke of two blocks, of many blocks across a corner, and a sine: what the reader must keep up with.
FEW = (2, 4, 10)


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    ("seeds", "least"), [(FEW, 3), pytest.param(SEEDS, 6, marks=pytest.mark.long)], ids=["few", "all"]
)
def test_drawn_cuts_keep_what_they_promise(seeds: tuple[int, ...], least: int) -> None:
    ran, refused = run_cuts([drawn(seed) for seed in seeds])
    assert len(ran) >= least, refused
    assert [f"{one.cut}: {one.misses} {one.kept}" for one in ran if one.misses] == []


def test_a_number_is_a_cut() -> None:
    assert drawn(7).program == drawn(7).program
    assert len({drawn(seed).program for seed in range(50)}) == 50
    assert {drawn(seed).kind.split(",")[0] for seed in range(len(PATHS))} == set(PATHS)


GOOD = Kept(0.0, 0.0, 0.0, 0.0, True, 0.0, 0.0)
LATE, LATER = replace(GOOD, time_error=0.04), replace(GOOD, time_error=0.03)


@pytest.mark.parametrize(
    ("runs", "misses", "tries"),
    [
        ((GOOD,), [], 1),
        ((LATE, LATER, GOOD), [], 3),
        ((LATE, LATE), ["time"], 2),
        ((LATE, LATER, LATE), ["time"], 3),
        ((NOTHING_KEPT, NOTHING_KEPT), NOTHING_KEPT.misses(), 2),
        (tuple(replace(GOOD, time_error=0.1 + 0.01 * n) for n in range(9)), ["time", UNSETTLED], 5),
    ],
    ids=["good", "stalled twice", "wrong", "stalled and wrong", "no motion", "never the same"],
)
def test_a_stalled_run_is_told_from_a_wrong_program(
    runs: tuple[Kept, ...], misses: list[str], tries: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = list(runs)
    cut = drawn(10)

    def run_at(waiting: Iterable[Cut], speed: float) -> dict[Cut, Ran]:
        return {one: Ran(one, True, left.pop(0), ()) for one in waiting}

    monkeypatch.setattr(drawn_cuts, "_run_at", run_at)
    (ran,), refused = run_cuts([cut])
    assert not refused
    assert ran.misses == misses
    assert len(runs) - len(left) == tries


def test_one_chip_of_a_cut_that_dwells_is_missed() -> None:
    """Feeding evenly and standing behind each step it keeps all; of one stand that is too short N tells."""
    cut = drawn(11, "turning")
    (promise,) = cut.filtered().cuts
    wave, (leg,) = promise.wave, cut.legs
    step_mm = wave.speed_mm_s * wave.period_s
    for moved_s, misses in ((0.0, []), (0.028, ["N"])):
        begin_s = wave.period_s * np.arange(wave.vibrations + 1)
        begin_s[20] -= moved_s  # the stand before it is shorter, and the one behind it longer
        stand_s = begin_s[:-1] + wave.period_s - promise.each_dwell_s
        places_mm = step_mm * np.arange(wave.vibrations + 1)
        time_s = np.append(
            np.column_stack([begin_s[:-1], stand_s]).ravel(), [begin_s[-1], promise.duration_s]
        )
        along_mm = np.append(np.repeat(places_mm, 2)[1:], leg.length_mm)
        found = kept(cut, promise, time_s, leg.at(along_mm))
        assert found.misses() == misses, found
