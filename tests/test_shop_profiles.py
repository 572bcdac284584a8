"""The shipped profiles of shop controls: no number of an axis is invented, and what they ask for exists."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import pytest

import chipbreak

SHOP = ("fanuc-lathe", "haas-lathe", "mitsubishi-lathe")
PROGRAM = b"G21 G99\nG97 S1000 M3\nG0 X20. Z2.\nG1 Z-20. F0.1 N0.5\nM30\n"
_LEFT_OUT = re.compile(r"^# (?=[a-z0-9_]+ = )", re.MULTILINE)
_OF_AN_AXIS = re.compile(r"^(acc_dec|position_gain|feed_forward|max_|joint_speed)", re.MULTILINE)


def text_of(name: str) -> str:
    return resources.files("chipbreak.profiles").joinpath(f"{name}.toml").read_text("utf-8")


@pytest.mark.parametrize("name", SHOP)
def test_no_number_of_an_axis_is_said_and_all_that_are_left_out_can_be_set(name: str, tmp_path: Path) -> None:
    text = text_of(name)
    assert not _OF_AN_AXIS.search(text)
    profile = tmp_path / "mine.toml"
    # The speed at a joint belongs to look-ahead.
    mine = _LEFT_OUT.sub("", text).replace("after-interpolation", "look-ahead")
    profile.write_text(mine, "utf-8")
    settings = chipbreak.load(str(profile))
    assert settings.axes["Z"].max_acceleration_mm_s2 or settings.axes["Z"].position_gain_1_s


@pytest.mark.parametrize("name", SHOP)
def test_the_profile_filters_as_it_is(name: str) -> None:
    (cut,) = chipbreak.rewrite(PROGRAM, chipbreak.load(name)).cuts
    assert cut.verdict.breaks
    assert cut.control == "ideal"


@pytest.mark.parametrize(
    ("name", "place"),
    [("fanuc-lathe", "1825 position_gain_1_s"), ("mitsubishi-lathe", "2203 PGN1"), ("haas-lathe", "measure")],
)
def test_a_missing_number_is_named_with_its_place_on_the_control(name: str, place: str) -> None:
    for model in ("after-interpolation", "trapezoid"):
        settings = chipbreak.load(name, [f"planner.model={model}"])
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            chipbreak.rewrite(PROGRAM, settings)
        (error,) = [d for d in caught.value.diagnostics if d.severity.value == "error"]
        assert error.code == "VIB035"
        assert place in error.help


def test_haas_dwells_in_p() -> None:
    settings = chipbreak.load("haas-lathe", ["vibration.end=dwell"])
    assert b"G4 P" in chipbreak.rewrite(PROGRAM, settings).data
