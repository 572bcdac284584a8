"""Programs as shops write them: what they rough with vibrates, all comes back, a second run adds nothing.

Those in ``STAYS`` cannot have a vibrated cut, each for the reason that is said.  A profile beside a program
says of its machine what the program shows.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import chipbreak
from chipbreak.settings import load

PROGRAMS = sorted((Path(__file__).parents[1] / "shop").glob("*.nc"))
MACHINE = (
    'planner.model="trapezoid"',
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
    'vibration.n="auto"',
)
# A second run takes as long as the first: one of each kind will do.
AGAIN = frozenset({"O1234.nc", "O0207.nc", "O00100.nc", "O0106.nc", "O0777.nc"})
STAYS = {
    "O1119.nc": "the control works out where line 8 goes",
}
# The last cut stands behind the loop, and what it needs is known there.
ONLY_BEHIND_THE_LOOP = {"O0105.nc": "the control works out where line 8 goes"}
# What is true of them without the profile beside them.
WITHOUT_FACTS = {
    "O0008.nc": "line 7 chooses a spindle (M203)",
}
FACTS = sorted(PROGRAMS[0].parent.glob("*.toml"))


# Of each kind one, and every tenth; the others in the long form.
_SHORT = {*AGAIN, *STAYS, *ONLY_BEHIND_THE_LOOP, *(path.name for path in PROGRAMS[::10])} - {
    "O0009.nc",
    "O1106.nc",
}
_EACH = [
    pytest.param(path, id=path.stem, marks=() if path.name in _SHORT else pytest.mark.long)
    for path in PROGRAMS
]


@pytest.mark.parametrize("path", _EACH)
def test_a_program_of_a_shop(path: Path) -> None:
    facts = path.with_suffix(".toml")
    settings = load(facts if facts.is_file() else "fanuc-lathe", MACHINE)
    program = path.read_bytes()
    result = chipbreak.rewrite(program, settings)
    assert chipbreak.restore(result.data) == program
    if path.name in AGAIN:
        assert chipbreak.rewrite(result.data, settings).data == result.data
    if path.name in STAYS:
        assert not result.cuts
        assert any(STAYS[path.name] in left.said.message for left in result.left)
    else:
        assert result.cuts
    if path.name in ONLY_BEHIND_THE_LOOP:
        assert len(result.cuts) == 1
        assert any(ONLY_BEHIND_THE_LOOP[path.name] in left.said.message for left in result.left)


@pytest.mark.parametrize("name", WITHOUT_FACTS)
def test_what_the_profile_of_a_program_is_for(name: str) -> None:
    result = chipbreak.rewrite((FACTS[0].parent / name).read_bytes(), load("fanuc-lathe", MACHINE))
    assert not result.cuts
    assert any(WITHOUT_FACTS[name] in left.said.message for left in result.left)


@pytest.mark.parametrize("path", FACTS, ids=lambda path: path.stem)
def test_a_profile_beside_a_program_says_nothing_but_its_control_spindle_and_offsets(path: Path) -> None:
    text = path.read_text("utf-8")
    assert text.startswith("# "), "by what the program shows it"
    assert tomllib.loads(text).keys() <= {"base", "control", "spindle", "tools"}
    assert path.with_suffix(".nc").is_file()
