"""``chipbreak advise``: every row is what a program with that cut does."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from chipbreak.advise.of_cut import Advice, CutAsked, advice_for, program_of
from chipbreak.cli import cli

MACHINE = (
    "planner.model=trapezoid",
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
)
CUT = CutAsked(0.2, 50.0, 30.0, 1500.0)
ASKED = ["--feed", "0.2", "--diameter", "50", "--length", "30", "--speed", "1500"]
OPTIONS = ["-p", "fanuc-lathe", *(word for one in MACHINE for word in ("--set", one))]


def advised(
    cut: CutAsked = CUT, profile: str = "fanuc-lathe", *sets: str
) -> tuple[Advice, chipbreak.Settings]:
    settings = chipbreak.load(profile, [*MACHINE, *sets])
    return advice_for(cut, settings, 5), settings


@pytest.mark.parametrize(
    "cut",
    [CUT, CutAsked(0.15, 60.0, 20.0, 900.0, axis="X"), CutAsked(0.1, 10.0, 25.0, 1200.0, edges=2)],
    ids=["turning", "facing", "drilling with two edges"],
)
def test_a_program_that_asks_for_a_row_gets_it(cut: CutAsked) -> None:
    advice, settings = advised(cut)
    assert len(advice.rows) > 2
    for row in advice.rows:
        lines = program_of(cut, settings).decode().splitlines()
        program = "\n".join([*lines[:3], row.directive, *lines[3:]]) + "\n"
        (report,) = chipbreak.rewrite(program.encode(), settings).cuts
        assert report.verdict.breaks
        assert report.verdict.margin == pytest.approx(row.margin, abs=0.01)
        assert report.plan.solution.speed_rpm == row.speed_rpm
        assert report.plan.wave.stroke_mm == pytest.approx(row.stroke_mm, rel=1e-3)
        assert report.acceleration_mm_s2 == pytest.approx(row.acceleration_mm_s2, rel=1e-2)
        assert row.acceleration_share == pytest.approx(row.acceleration_mm_s2 / 5000.0)
        assert row.acceleration_share <= 0.9


def test_the_first_row_is_what_the_machine_chooses() -> None:
    advice, settings = advised()
    program = b"G21 G99\nG97 S1500 M3\nG0 X50. Z2.\n(VIB AUTO)\nG1 Z-28. F0.2\nM30\n"
    (report,) = chipbreak.rewrite(program, settings).cuts
    best = advice.rows[0]
    assert report.plan.solution.per_rev == best.per_rev
    assert report.plan.solution.speed_rpm == best.speed_rpm


@pytest.mark.parametrize("profile", ["linuxcnc-lathe", "generic-lathe", "haas-lathe", "fanuc-mill"])
def test_every_control_gets_a_program_in_its_words(profile: str) -> None:
    advice = advice_for(CutAsked(0.1, 20.0, 15.0, 1000.0), chipbreak.load(profile), 2)
    assert all(row.margin >= 1.0 for row in advice.rows)
    assert advice.is_unproven == (advice.control == "ideal")


def test_the_command_says_it_as_text_and_as_json() -> None:
    shown = CliRunner().invoke(cli, ["advise", *OPTIONS, *ASKED, "--rows", "3"])
    assert shown.exit_code == 0
    assert "(VIB N" in shown.output
    assert "S1500" in shown.output
    found = json.loads(CliRunner().invoke(cli, ["advise", *OPTIONS, *ASKED, "--rows", "3", "--json"]).output)
    assert len(found["rows"]) == 3
    assert found["rows"][0]["margin"] >= 1.1


def test_what_no_condition_breaks_is_refused_with_the_numbers() -> None:
    slow = [*OPTIONS, "--set", "axes.Z.max_acceleration_mm_s2=20"]
    shown = CliRunner().invoke(cli, ["advise", *slow, *ASKED])
    assert shown.exit_code == 3
    assert "VIB036" in shown.output


@pytest.mark.parametrize(
    "words", [[], ["--speed", "1500", "--surface", "200"]], ids=["no speed", "two speeds"]
)
def test_one_speed_is_given(words: list[str]) -> None:
    shown = CliRunner().invoke(cli, ["advise", *OPTIONS, *ASKED[:6], *words])
    assert shown.exit_code == 2
    assert "--speed and --surface" in shown.output


def test_the_figure(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for kind in ("svg", "png"):
        target = tmp_path / f"f.{kind}"
        shown = CliRunner().invoke(cli, ["advise", *OPTIONS, *ASKED, "--rows", "2", "-o", str(target)])
        assert shown.exit_code == 0
        assert target.stat().st_size > 5000
    assert CliRunner().invoke(cli, ["advise", *OPTIONS, *ASKED, "-o", "f.bmp"]).exit_code == 2
