"""Some of the cuts drawn at random, on the simulated machine; ``benchmarks/real_control.py`` runs more."""

from __future__ import annotations

import pytest

from .drawn import PATHS, drawn, run_cuts

SEEDS = (2, 3, 4, 8, 9, 10, 12, 16, 37, 58)


@pytest.mark.linuxcnc("machine")
def test_drawn_cuts_keep_what_they_promise() -> None:
    ran, refused = run_cuts([drawn(seed) for seed in SEEDS])
    assert len(ran) >= 6, refused
    assert [f"{one.cut}: {one.misses} {one.kept}" for one in ran if one.misses] == []


def test_a_number_is_a_cut() -> None:
    assert drawn(7).program == drawn(7).program
    assert len({drawn(seed).program for seed in range(50)}) == 50
    assert {drawn(seed).kind.split(",")[0] for seed in range(len(PATHS))} == set(PATHS)
