"""``chipbreak tools`` and ``chipbreak inspect`` as they are called."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner, Result

from chipbreak.cli import cli
from chipbreak.inspection.edge_figure import EdgeCurves, edge_figure

SAMPLES = Path(__file__).parents[2] / "samples"
MILL = str(SAMPLES / "fusion-mill.nc")
BEFORE, AFTER = (str(SAMPLES / "tools" / f"ball-6-{when}.csv") for when in ("before", "after"))


def run(*args: str) -> Result:
    return CliRunner().invoke(cli, args, env={"CHIPBREAK_PROFILE": None})


def known(*args: str) -> dict[int, dict[str, object]]:
    done = run("tools", "-p", "fanuc-mill", "--json", MILL, *args)
    assert done.exit_code == 0, done.output
    return {tool["number"]: tool for tool in json.loads(done.stdout)["tools"]}


def test_tools_says_what_is_known_and_what_is_missing() -> None:
    done = run("tools", "-p", "fanuc-mill", MILL)
    assert done.exit_code == 0
    assert re.search(r"^T2 +flat end mill +- +12 ", done.stdout, re.MULTILINE)
    assert "comment in line 4" in done.stdout
    assert "the edge check lacks teeth, helix_deg" in done.stdout


def test_tools_from_two_files_and_comments() -> None:
    library, table = str(SAMPLES / "tools" / "bracket.json"), str(SAMPLES / "tools" / "bracket.csv")
    tools = known("--tools", library, "--tools", table)
    assert list(tools) == [1, 2, 3]
    assert tools[2]["missing"] == {}
    sources = tools[2]["sources"]
    assert isinstance(sources, dict)
    assert sources["length_mm"].endswith("bracket.json, data[1]")
    assert sources["helix_deg"].endswith("bracket.csv, line 4")


def test_files_of_the_profile_stand_beside_it_and_come_after_the_option(tmp_path: Path) -> None:
    head = "number,type,teeth,diameter_mm,length_mm\n"
    (tmp_path / "own.csv").write_text(head + "2,,4,,38\n")
    (tmp_path / "first.csv").write_text(head + "2,,4,,39\n")
    profile = tmp_path / "shop.toml"
    profile.write_text('base = "fanuc-mill"\n[tools]\nfiles = ["own.csv"]\n')
    args = ["tools", "-p", str(profile), "--json", MILL]
    for more, length in (([], 38.0), (["--tools", str(tmp_path / "first.csv")], 39.0)):
        done = run(*args, *more)
        tool = json.loads(done.stdout)["tools"][1]["known"]
        assert (tool["teeth"], tool["length_mm"]) == (4, length)


@pytest.mark.parametrize(("unit", "diameter"), [("mm", 0.5), ("inch", 12.7), ("program", 0.5)])
def test_units_of_a_linuxcnc_table(tmp_path: Path, unit: str, diameter: float) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T2 P2 D0.5\n")
    tool = known("--tools", str(table), "--set", f"tools.table_unit={unit}")[2]["known"]
    assert isinstance(tool, dict)
    assert tool["diameter_mm"] == pytest.approx(diameter)


@pytest.mark.parametrize("name", ["missing.csv", "bad.csv"])
def test_tools_with_a_file_that_cannot_be_used(tmp_path: Path, name: str) -> None:
    (tmp_path / "bad.csv").write_text("number,type,teeth,diameter_mm,length_mm\n2,,four,,\n")
    done = run("tools", "-p", "fanuc-mill", MILL, "--tools", str(tmp_path / name))
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "error TOL00" in done.stderr


def test_a_program_without_tools(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text("G0 X0\n")
    assert run("tools", "-p", "fanuc-mill", str(tmp_path / "a.nc")).stdout == "no tool is called or listed\n"


def test_inspect_before_a_finish_and_before_a_rough() -> None:
    finish = run("inspect", BEFORE, AFTER, "--next", "finish")
    assert finish.exit_code == 1
    assert re.search(
        r"tooth 1: .* fine\n  tooth 2: 0.0353 mm inward at height 0.900 mm, CHIPPED", finish.stdout
    )
    rough = run("inspect", BEFORE, AFTER, "--next", "rough", "--json")
    assert rough.exit_code == 0
    found = json.loads(rough.stdout)
    assert found["chipped"] is False
    assert [tooth["limit_mm"] for tooth in found["teeth"]] == [0.05, 0.05]


@pytest.mark.parametrize(("value", "exit_code"), [(0.04, 0), (0.03, 1)])
def test_the_limit_of_a_tool(value: float, exit_code: int) -> None:
    limits = f"checks.w_mm={{4={value}}}"
    done = run(
        "inspect", BEFORE, AFTER, "--next", "finish", "--tool", "4", "-p", "fanuc-mill", "--set", limits
    )
    assert done.exit_code == exit_code
    assert f"T4, next finish, limit W {value} mm" in done.stdout


def write(path: Path, rows: str) -> str:
    path.write_text(f"tooth,height_mm,radius_mm\n{rows}")
    return str(path)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("2,0,5\n2,1,5\n", "tooth 1, 2 is in one of"),
        ("1,0,5\n", "tooth 1: the new trace has no point from height 0 to 3"),
        ("1,0,x\n", "TOL004"),
        ("1,0,5\n1,0,6\n", "height 0 mm twice"),
        ("1,0\n", "has no radius_mm"),
        ("", "no point in it"),
    ],
)
def test_inspect_trouble(tmp_path: Path, rows: str, message: str) -> None:
    before = write(tmp_path / "b.csv", "1,0,5\n1,1,5\n1,2,5\n1,3,5\n")
    done = run("inspect", before, write(tmp_path / "a.csv", rows), "--next", "rough")
    assert done.exit_code == 2
    assert message in done.stderr
    assert done.stdout == ""


def test_a_single_stored_point_is_trouble(tmp_path: Path) -> None:
    one = write(tmp_path / "b.csv", "1,0,5\n")
    done = run("inspect", one, one, "--next", "rough")
    assert done.exit_code == 2
    assert "at least 2 points" in done.stderr


def test_figures_are_svg_only(tmp_path: Path) -> None:
    target = tmp_path / "edge.png"
    done = run("inspect", BEFORE, AFTER, "--next", "rough", "-o", str(target))
    assert done.exit_code == 2
    assert "figures are SVG" in done.stderr
    assert not target.exists()


def test_the_figure_shows_the_three_lines(tmp_path: Path) -> None:
    target = tmp_path / "edge.svg"
    assert run("inspect", BEFORE, AFTER, "--next", "finish", "--tool", "4", "-o", str(target)).exit_code == 1
    root = ElementTree.fromstring(target.read_text())
    texts = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert "T4, next finish, W 0.02 mm: tooth 2 chipped" in texts
    assert {"before", "limit line", "after", "radius [mm]", "height above the tip [mm]"} <= set(texts)
    assert target.stat().st_size < 60_000


@pytest.mark.parametrize("scale", [1e-4, 1.0, 100.0])
@pytest.mark.parametrize("wear", [0.0, 0.01, -0.01])
def test_figures_of_all_sizes_have_axes(scale: float, wear: float) -> None:
    heights = np.linspace(0.0, 20.0 * scale, 50)
    before = np.column_stack((heights, np.full(50, 5.0 * scale)))
    after = before - np.array([0.0, wear * scale])
    inward = np.full(50, wear * scale)
    curves = [EdgeCurves(tooth, before, after, before, inward, False) for tooth in range(1, 11)]
    root = ElementTree.fromstring(edge_figure(curves, 0.02 * scale, "<&>"))
    texts = [element.text or "" for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert texts[0] == "<&>"
    assert sum(bool(re.fullmatch(r"-?[\d.]+", text)) for text in texts) > 10
    assert "nan" not in edge_figure(curves, 0.02 * scale, "")


def test_a_listed_tool_needs_no_call(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text("(T6 D=3.175 CR=0 - ZMIN=0 - flat end mill)\nG21\nT6\nS18000 M3\n")
    done = run("tools", "-p", "fanuc-mill", str(tmp_path / "a.nc"))
    assert re.search(r"^T6 +flat end mill +- +3.175 ", done.stdout, re.MULTILINE)
