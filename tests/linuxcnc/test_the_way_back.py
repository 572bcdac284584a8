"""Every program of the grid and every sample goes back to its bytes, and a second run changes nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.restore import restore
from chipbreak.text.source import read
from longer import short_where

from .vibrated import Job, few_of_the_grid, grid

FEW = few_of_the_grid()
SAMPLES = Path(__file__).parents[2] / "samples"
PROFILES = {
    "cookbook.ngc": str(SAMPLES / "cookbook-lathe.toml"),
    "fusion-mill.nc": str(SAMPLES / "mill-with-laser.toml"),
    "linuxcnc-lathe.ngc": "linuxcnc-lathe",
    "roughing.nc": "fanuc-lathe",
    "shaft.ngc": "linuxcnc-lathe",
    "turning.nc": "generic-lathe",
}
# What its machine reaches.
SETS = {"shaft.ngc": [f"axes.{axis}.max_acceleration_mm_s2=10000" for axis in "XZ"]}


def goes_back(program: bytes, result: chipbreak.Result, settings: chipbreak.Settings) -> bool:
    assert result.data != program
    assert restore(read(result.data)).data == program
    again = chipbreak.rewrite(result.data, settings, allow_unbroken=True)
    return again.data == result.data and not again.changed


@pytest.mark.parametrize("job", short_where(grid(), FEW.__contains__), ids=str)
def test_program_of_the_grid(job: Job) -> None:
    limits = [f"axes.{axis}.max_acceleration_mm_s2={job.acceleration_mm_s2:g}" for axis in "XZ"]
    # As the job itself says it.
    settings = chipbreak.load("linuxcnc-lathe", [*limits, "planner.max_feed_override=1", *job.sets])
    assert goes_back(job.program(), job.filtered(), settings)


def test_there_is_a_profile_for_every_sample() -> None:
    assert {file.name for file in SAMPLES.iterdir() if file.suffix in (".nc", ".ngc")} == set(PROFILES)


@pytest.mark.parametrize("name", PROFILES)
def test_sample(name: str) -> None:
    settings = chipbreak.load(PROFILES[name], SETS.get(name, []))
    program = (SAMPLES / name).read_bytes()
    assert goes_back(program, chipbreak.rewrite(program, settings, name), settings)
