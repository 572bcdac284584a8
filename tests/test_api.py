"""The names that other programs use: there, documented, light, and short to look at."""

from __future__ import annotations

import ast
import doctest
import json
import pickle
import pkgutil
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import chipbreak

CHECKOUT = Path(__file__).parents[1]
PAGE = CHECKOUT / "docs" / "api.md"
PROGRAM = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"


@pytest.mark.parametrize("name", chipbreak.__all__)
def test_a_public_name(name: str) -> None:
    value = getattr(chipbreak, name)
    assert name == "__version__" or value.__doc__.strip()
    assert name in dir(chipbreak)
    assert f"`{name}`" in PAGE.read_text("utf-8").partition("## Every name")[2]
    # A module of this name would take its place as soon as somebody imports it.
    assert name not in {module.name for module in pkgutil.iter_modules(chipbreak.__path__)}


def test_the_page_lists_nothing_else() -> None:
    table = PAGE.read_text("utf-8").partition("## Every name")[2]
    first_cells = "\n".join(line.split("|")[1] for line in table.splitlines() if line.startswith("|"))
    assert set(re.findall(r"`(\w+)`", first_cells)) == set(chipbreak.__all__)


def test_type_checkers_see_what_is_there() -> None:
    """Names that are imported for type checkers, listed, and loaded on first use are the same ones."""
    tree = ast.parse(Path(chipbreak.__file__).read_text("utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {a.name: i.module for i in block.body if isinstance(i, ast.ImportFrom) for a in i.names}
    assert imported == {name: home for home, names in chipbreak._HOMES.items() for name in names}
    assert {*imported, "__version__"} == set(chipbreak.__all__)


def test_the_page_works(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(CHECKOUT)
    test = doctest.DocTestParser().get_doctest(PAGE.read_text("utf-8"), {}, PAGE.name, str(PAGE), 0)
    assert len(test.examples) > 20
    failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test)
    assert failed == 0


def test_the_version() -> None:
    assert chipbreak.__version__ == version("chipbreak")


def test_there_is_no_other_name() -> None:
    with pytest.raises(AttributeError, match="'chipbreak' has no attribute 'rewite'"):
        _ = chipbreak.rewite  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", [name for name in chipbreak.__all__ if name.endswith("Error")])
def test_a_traceback_shows_the_public_name(name: str) -> None:
    error = getattr(chipbreak, name)
    assert (error.__module__, error.__qualname__) == ("chipbreak", name)
    assert issubclass(error, chipbreak.ChipbreakError)


@pytest.mark.parametrize("code", ["", "chipbreak.__version__; dir(chipbreak); chipbreak.ToolFileError"])
def test_importing_is_light(code: str) -> None:
    shown = "print(*{module.split('.')[0] for module in sys.modules} & {'numpy', 'lark', 'click'})"
    whole = f"import chipbreak, sys; {code}\n{shown}"
    done = subprocess.run([sys.executable, "-c", whole], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_long_program_is_short_to_look_at() -> None:
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(PROGRAM, settings, "part.nc")
    (cut,) = result.cuts
    edits = list(result.edits)
    tables = [part for part in edits[0].content if not isinstance(part, str)]
    report = chipbreak.explain(result, settings)
    shown = [settings, result, result.source, cut, cut.plan, cut.expansion, report, *edits, *tables]
    assert tables
    for value in shown:
        assert repr(value).startswith(f"<{type(value).__name__} ") or "Expansion" in repr(value)
        assert len(repr(value)) < 200
    assert repr(result).startswith("<Result of 'part.nc': changed, ")


def test_a_result_pickles() -> None:
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(PROGRAM, settings, "part.nc")
    other = pickle.loads(pickle.dumps(result))
    assert (other.data, other.diagnostics, repr(other)) == (result.data, result.diagnostics, repr(result))
    before, after = (chipbreak.explain(one, settings) for one in (result, other))
    assert before == after
    assert str(before) == str(after)


def test_a_report_is_json() -> None:
    settings = chipbreak.load("generic-lathe")
    report = chipbreak.explain(chipbreak.rewrite(PROGRAM, settings), settings)
    facts = report.as_dict()
    assert json.loads(json.dumps(facts)) == facts
    assert facts["schema"] == 1
    assert pickle.loads(pickle.dumps(report)) == report


@pytest.mark.parametrize("profile", ["generic-lathe", "fanuc-lathe", "linuxcnc-lathe"])
@pytest.mark.parametrize("form", ["expanded", "loop"])
def test_the_motion_of_each_cut(profile: str, form: str) -> None:
    """A million points would take more memory than a result may keep: they are worked out when asked for."""
    options = [f"output.form={form}"] if profile != "generic-lathe" else []
    settings = chipbreak.load(profile, options)
    program = b"G97 S1000 M3\nG0 X20. Z2.\nG95 G1 Z-8. F0.05 N1.5\nG0 Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"
    if profile == "fanuc-lathe":
        program = program.replace(b"G95", b"G99")
    result = chipbreak.rewrite(program, settings, allow_unbroken=True)
    motions = list(chipbreak.motions(result, settings))
    assert [round(float(one.distance_mm[-1]), 3) for one in motions] == [10.0, 5.0]
    for motion, cut in zip(motions, result.cuts, strict=True):
        assert float(motion.time_s[-1]) == pytest.approx(cut.duration_s, abs=0.003)  # servo periods
        assert (motion.time_s[1:] >= motion.time_s[:-1]).all()
    unchanged = chipbreak.rewrite(b"G0 X20. Z2.\nM30\n", settings)
    assert list(chipbreak.motions(unchanged, settings)) == []


def test_checking_a_good_and_a_bad_program() -> None:
    settings = chipbreak.load("generic-lathe")
    known = ["planner.model=trapezoid", "axes.Z.max_acceleration_mm_s2=20000"]
    assert chipbreak.check(PROGRAM, chipbreak.load("generic-lathe", known)) == ()
    assert [found.code for found in chipbreak.check(PROGRAM, settings)] == ["VIB079"]
    (found,) = chipbreak.check(PROGRAM.replace(b"N1.5", b"N2"), settings)
    assert found.code == "VIB005"


def test_macro_programs() -> None:
    where = ["beam_x_mm=0", "beam_y_mm=0", "beam_z_mm=0", "safe_z_mm=0", "master_length_mm=100"]
    options = [f"macros.{one}" for one in [*where, "master_diameter_mm=10"]]
    files = chipbreak.macro_programs(chipbreak.load("fanuc-mill", options))
    assert "O8900.nc" in files
    with pytest.raises(chipbreak.SettingsError, match="fanuc-mill: "):
        chipbreak.macro_programs(chipbreak.load("fanuc-mill"))


def test_a_program_is_explained_as_the_result_of_its_run() -> None:
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(PROGRAM, settings, "part.nc")
    assert str(chipbreak.explain(PROGRAM, settings, "part.nc")) == str(chipbreak.explain(result, settings))


def test_motions_may_be_changed() -> None:
    """Who changes what he was given changes nothing for who asks next."""
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(b"G97 S1200 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n", settings)
    (first,) = chipbreak.motions(result, settings)
    end_s, end_mm = float(first.time_s[-1]), float(first.distance_mm[-1])
    first.time_s[:] *= 1000.0
    first.distance_mm[:] = 0.0
    (again,) = chipbreak.motions(result, settings)
    assert (float(again.time_s[-1]), float(again.distance_mm[-1])) == (end_s, end_mm)
