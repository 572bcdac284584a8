"""Figures show what the verdict says; the page needs nothing but itself."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import chipbreak
from chipbreak.figures.cut_data import DrawnCut
from chipbreak.figures.of_run import OF_CUT, figure_of_times, figures_of_cut
from chipbreak.figures.speeds import SpeedChart, SpeedPoint, _breaks, _curves_hz
from chipbreak.figures.style import KINDS, apart, kind_of
from chipbreak.figures.times import cut_names
from chipbreak.kinematics.speed_solver import CommandGroup
from chipbreak.page.of_run import page_of_run
from chipbreak.settings import load
from chipbreak.text.diagnostics import RefusalError
from warm import FIGURES, cold, warm_text

LATHE = load("generic-lathe")
TURNED = b"(<b>&)\nG97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG1 X30. F0.05\nG0 Z2.\nM30\n"
MAGIC = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}


@pytest.fixture(scope="module")
def turned() -> chipbreak.Result:
    return chipbreak.rewrite(TURNED, LATHE, "turned.nc")


def drawn_cut(words: str) -> DrawnCut:
    program = f"G97 S2500 M3\nG0 X20. Z2.\nG1 Z-20. F0.05{words}\nM30\n".encode()
    result = chipbreak.rewrite(program, LATHE)
    (motion,) = chipbreak.motions(result, LATHE)
    return DrawnCut(chipbreak.explain(result, LATHE).cuts[0], motion)


@pytest.mark.parametrize("words", [" N1.5", " N0.5 Q1.5", " N2.25 Q3.", " N1.5 Q2.4"])
def test_the_thickness_that_is_drawn_is_that_of_the_verdict(words: str) -> None:
    cut = drawn_cut(words)
    turns = np.linspace(0.0, 20.0, 20 * 3600 + 1)
    height = cut.thickness_mm(cut.middle_s() + (turns - 10.0) * cut.turn_s) / cut.feed_mm
    verdict = cut.told.verdict
    assert height.max() == pytest.approx(verdict.peak_thickness, rel=0.02)
    assert (height > 1e-6).mean() == pytest.approx(verdict.cut_share, abs=0.01)


# Each figure in one kind and one figure in each; the others in the long form.
_EACH = [
    pytest.param(name, kind, marks=() if name == "ramp" or kind == "svg" else pytest.mark.long)
    for name in OF_CUT
    for kind in KINDS
]


@pytest.mark.parametrize(("name", "kind"), _EACH)
def test_a_figure_of_each_kind(name: str, kind: str, turned: chipbreak.Result) -> None:
    figure = next(one for one in figures_of_cut(turned, LATHE, 1) if one.name == name)
    data = figure.file(kind)
    assert data.startswith(MAGIC[kind])
    assert data == figure.file(kind)


def test_what_figures_say(turned: chipbreak.Result) -> None:
    texts = {one.name: one.file("svg").decode() for one in figures_of_cut(turned, LATHE, 1)}
    assert "edge in air: here a chip ends" in texts["chips"]
    assert "4th revolution" in texts["chips"]
    assert "as it runs" in texts["speeds"]
    assert "in the bands chips break with this stroke" in texts["speeds"]
    assert "without vibration:" in texts["thickness"]
    assert "62.5 Hz" in texts["speeds"]
    assert "as programmed" in texts["speeds"]
    assert ">1.0<" in texts["thickness"]
    times = figure_of_times(chipbreak.explain(turned, LATHE))
    assert times is not None
    assert "line 4" in times.file("svg").decode()
    assert " s as written" in times.file("svg").decode()


def test_passes_of_one_line_have_names_of_their_own() -> None:
    program = b"G97 S800 M3\nT0101\nG0 X30. Z2.\n(VIB N1.5)\nG90 X28. Z-20. F0.1\nX26.\nM30\n"
    settings = chipbreak.load("fanuc-lathe")
    report = chipbreak.explain(chipbreak.rewrite(program, settings), settings)
    names = cut_names([*report.cuts, report.cuts[0]])
    assert len(set(names)) == len(names) > 2
    assert names[0] == f"line {report.cuts[0].first_line}, pass 1"


@pytest.mark.parametrize(
    ("places", "wanted"),
    [
        ([], []),
        ([1.0, 2.0], [1.0, 2.0]),
        ([1.0, 1.0], [0.5, 1.5]),
        ([0.0, 0.1, 0.2, 5.0], [-0.9, 0.1, 1.1, 5.0]),
        ([0.0, 0.9, 1.8], [-0.1, 0.9, 1.9]),
    ],
)
def test_names_beside_a_diagram_do_not_run_into_each_other(places: list[float], wanted: list[float]) -> None:
    assert apart(places, 1.0) == pytest.approx(wanted)


def test_a_cut_that_is_not_there(turned: chipbreak.Result) -> None:
    with pytest.raises(RefusalError) as caught:
        figures_of_cut(turned, LATHE, 7)
    assert caught.value.code == "FIG002"
    nothing = chipbreak.rewrite(b"G0 X1.\n", LATHE)
    assert figure_of_times(chipbreak.explain(nothing, LATHE)) is None


def test_matplotlib_is_an_extra(turned: chipbreak.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(RefusalError, match="which is not installed") as caught:
        figures_of_cut(turned, LATHE, 1)[0].file("svg")
    assert caught.value.code == "FIG001"


def test_the_bands_of_speeds_are_where_chips_break() -> None:
    point = SpeedPoint(2500, 1.5)
    chart = SpeedChart(CommandGroup(), "triangle", 0.5, 1, stroke_ratio=1.25, chosen=point)
    # A triangle breaks where min(d, 1 - d) * 2 * ratio >= 1, d the fraction of N.
    for per_rev in np.linspace(0.03, 3.97, 198):
        fraction = per_rev % 1.0
        assert _breaks(chart, float(per_rev)) == (2 * min(fraction, 1 - fraction) * 1.25 >= 1.0)


def test_only_frequencies_of_the_control_are_drawn() -> None:
    curves = _curves_hz(CommandGroup(), 62.5)
    assert 62.5 in curves
    assert all(np.isclose(1000.0 / (4.0 * hz) % 1.0, 0.0) for hz in curves)
    assert _curves_hz(CommandGroup(periods_s=(0.02,)), 62.5) == [50.0]


def test_names_of_figures() -> None:
    assert [kind_of(name) for name in ("a.SVG", "b.png", "c.pdf", "d.jpg", "svg")] == [
        "svg",
        "png",
        "pdf",
        None,
        None,
    ]


# --- the page ---------------------------------------------------------------------------------------------


class Page(HTMLParser):
    """Tags that are open, ids, and what the page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: Counter[str] = Counter()
        self.loads: list[str] = []
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in {"meta", "br", "link"}:
            self.open.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids[value or ""] += 1
            if name in {"src", "href", "xlink:href"} and not (value or "").startswith("#"):
                self.loads.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def page_of(program: bytes, name: str = "part.nc") -> tuple[str, Page]:
    html = page_of_run(chipbreak.rewrite(program, LATHE, name), LATHE)
    page = Page()
    page.feed(html)
    page.close()
    assert page.open == []
    return html, page


def test_the_page_is_whole_and_alone() -> None:
    html, page = page_of(TURNED, "<part>&\x1b[31m.nc")
    assert page.loads == []
    assert "<script" not in html
    assert max(page.ids.values()) == 1
    assert "\x1b" not in html
    assert "&lt;part&gt;&amp;" in html
    used = set(re.findall(r"url\(#([\w.-]+)\)", html)) | set(re.findall(r'href="#([\w.-]+)"', html))
    assert used <= set(page.ids)
    assert "G1 Z-30. F0.05 N1.5" in page.texts
    assert "would break (unproven)" in page.texts


def test_a_page_without_cuts() -> None:
    html, _ = page_of(b"G0 X1.\nM30\n")
    assert "no cut vibrates" in html
    assert "<figure" not in html


def test_cuts_that_are_alike_are_drawn_once() -> None:
    cuts = b"".join(b"G0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG0 X30.\n" for _ in range(5))
    html, _ = page_of(b"G97 S3000 M3\n" + cuts + b"M30\n")
    assert html.count('<section class="cut">') == 1
    assert "4 more cuts are not drawn" in html
    assert html.count("<td>G1") == 0


# --- the commands -----------------------------------------------------------------------------------------


def run(*args: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return warm_text(*args, cwd=cwd, loads=FIGURES)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "part.nc").write_bytes(TURNED)
    rows = [f"1,{0.1 * i:.1f},5.0" for i in range(20)]
    (tmp_path / "before.csv").write_text("tooth,height_mm,radius_mm\n" + "\n".join(rows) + "\n")
    (tmp_path / "after.csv").write_text("tooth,height_mm,radius_mm\n" + "\n".join(rows) + "\n")
    return tmp_path


def test_a_figure_of_a_cut(folder: Path) -> None:
    command = ["plot", "-p", "generic-lathe", "part.nc", "-f", "ramp", "-o", "ramp.svg"]
    done = cold(command, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "The stroke grows" in (folder / "ramp.svg").read_text()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["part.nc", "-o", "x.jpg"], "name it .svg, .png, .pdf"),
        (["part.nc", "-c", "9", "-o", "x.svg"], "error FIG002: there is no vibrated cut 9"),
        (["plain.nc", "-f", "times", "-o", "x.svg"], "error FIG003"),
    ],
)
def test_a_figure_that_cannot_be(folder: Path, args: list[str], said: str) -> None:
    (folder / "plain.nc").write_bytes(b"G0 X1.\n")
    done = run("plot", "-p", "generic-lathe", *args, cwd=folder)
    assert done.returncode == 2
    assert said in done.stderr
    assert not list(folder.glob("x.*"))


def test_a_page_with_edges(folder: Path) -> None:
    edges = ("--edges", "before.csv", "after.csv", "finish")
    done = run("report", "-p", "generic-lathe", "part.nc", "-o", "part.html", *edges, cwd=folder)
    assert done.returncode == 0, done.stderr
    html = (folder / "part.html").read_text("utf-8")
    assert "Edges against their limit line" in html
    assert "no tooth is chipped" in html


def test_a_browser_shows_the_page(folder: Path) -> None:
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("needs Chromium")
    run("report", "-p", "generic-lathe", "part.nc", "-o", "part.html", cwd=folder)
    shot = folder / "part.png"
    page = f"file://{folder / 'part.html'}"
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1000,1600"]
    command = [browser, *flags, f"--screenshot={shot}", page]
    subprocess.run(command, capture_output=True, check=True, timeout=120, cwd=folder)
    image = pytest.importorskip("matplotlib.image").imread(shot)
    assert image.shape[:2] == (1600, 1000)
    # Text at the top, and the blue and green of the figures below.
    assert image[:200].std() > 0.05
    blue = (image[..., 2] > 0.6) & (image[..., 0] < 0.2)
    assert blue.sum() > 1000
