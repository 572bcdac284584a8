"""Small programs that once came out wrong, held to their right values (a folder in CHIPBREAK_CASES).

The values stand in ``right_values``.  Every file of the folder has one: a file without is a test that fails.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.restore import regions
from chipbreak.model.interpreted_program import interpret
from chipbreak.model.modal import Setting
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.source import read
from linuxcnc import rs274
from linuxcnc.compared import assert_same_outside
from right_values import BITS, DIFFERENCES, OPERATIONS, RIGHT, STATES, TOOLS, Right

FOLDER = os.environ.get("CHIPBREAK_CASES", "")
# Of any other folder nobody has said what is right; tests/test_cases.py reads those.
IS_OURS = bool(FOLDER) and all((Path(FOLDER) / name).is_dir() for name in ("public", "held", "random"))
pytestmark = pytest.mark.skipif(not IS_OURS, reason="CHIPBREAK_CASES does not name the folder of them")
# Not programs: what the folder says of itself, and cuts that the simulated machine judges.
NO_PROGRAMS = ("README.md", "grid/")
# The families of codes that are findings of reading: none may be said that is not expected.
READING = ("SYN", "MOD")
_MOVES = re.compile(r"(?:N\d+ ?)?(?:G0?[0-3] ?)?[XYZUWIJKR]")
_MODES = re.compile(r"S[\d.]|G9[3-7]|G2[01]\b|M[345]\b|G6[14]|^F[\d.]+$")
_CALLS = ("G65", "o<")


def data_of(name: str) -> bytes:
    return (Path(FOLDER) / name).read_bytes()


def files() -> list[str]:
    """Every file of the folder."""
    if not IS_OURS:
        return ["-"]
    root = Path(FOLDER)
    names = (str(file.relative_to(root)) for file in sorted(root.rglob("*")) if file.is_file())
    return [name for name in names if not name.startswith(NO_PROGRAMS)]


@pytest.mark.parametrize("name", files())
def test_every_file_of_the_folder_has_a_right_value(name: str) -> None:
    of_differences = {file for pair in DIFFERENCES for file in pair[:2]}
    known = {row.file for row in RIGHT} | of_differences | TOOLS.keys() | BITS.keys()
    assert name in known, "nobody has said what is right for this file"


def settings_of(row: Right) -> chipbreak.Settings:
    return chipbreak.load(row.profile, row.sets)


def places(diagnostics: Iterator[Diagnostic] | tuple[Diagnostic, ...]) -> list[str]:
    return [f"{d.code} {d.place.line if d.place else 0}" for d in diagnostics]


def check_said(diagnostics: tuple[Diagnostic, ...], said: tuple[str, ...]) -> None:
    """What must be said is said, and of reading nothing else."""
    found = places(diagnostics)
    codes = {one.split()[0] for one in said}
    relevant = [one for one in found if one.split()[0] in codes or one.startswith(READING)]
    assert sorted(relevant) == sorted(said)


def modes(output: bytes) -> list[str]:
    """Blocks in the brackets that set S, F, units or modes."""
    source = read(output)
    found = []
    for region in regions(source):
        lines = [source.text(line) for line in range(region.first, region.last)]
        found += [one for one in lines if "CHIPBREAK" not in one and not one.startswith(_CALLS)]
    return [one for one in found if _MODES.search(one) and not _MOVES.match(one)]


@pytest.mark.parametrize("row", RIGHT, ids=[row.name for row in RIGHT])
def test_right_values(row: Right) -> None:
    data = data_of(row.file)
    settings = settings_of(row)
    if row.refused:
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            chipbreak.rewrite(data, settings, row.file)
        errors = [d for d in caught.value.diagnostics if d.severity is Severity.ERROR]
        assert places(tuple(errors)) == list(row.refused)
        check_said(tuple(d for d in caught.value.diagnostics if d not in errors), row.said)
        return
    result = chipbreak.rewrite(data, settings, row.file, allow_unbroken=True)
    assert re.findall(r"BEGIN VIB ([^)]*)\)", result.data.decode("latin-1")) == list(row.cuts)
    assert modes(result.data) == list(row.modes)
    checks = chipbreak.explain(result, settings).checks
    assert [f"{check.line} {check.title}" for check in checks] == list(row.checks)
    check_said(result.diagnostics, row.said)
    assert result.changed == bool(row.cuts or row.checks)
    assert chipbreak.restore(result.data) == data
    assert chipbreak.rewrite(result.data, settings, row.file, allow_unbroken=True).data == result.data


LINUXCNC_ROWS = [row for row in RIGHT if row.file.endswith(".ngc") and row.cuts]


@pytest.mark.linuxcnc
@pytest.mark.parametrize("row", LINUXCNC_ROWS, ids=[row.name for row in LINUXCNC_ROWS])
def test_the_control_does_the_same_outside_the_brackets(row: Right) -> None:
    data = data_of(row.file)
    if not re.search(rb"M(2|30)\s*$", data):
        data += b"M2\n"
    lathe = row.profile.endswith("lathe")
    result = chipbreak.rewrite(data, settings_of(row), row.file, allow_unbroken=True)
    assert len(result.cuts) == len(row.cuts)
    if "SYN004 5" in row.said:  # what the filter says of this one: the control does not take it
        assert "Nested comment" in rs274.judge(data, lathe=lathe).message
        return
    assert_same_outside(data, result.data, lathe=lathe)


@pytest.mark.parametrize(("before", "after", "lines"), DIFFERENCES, ids=[row[1] for row in DIFFERENCES])
@pytest.mark.parametrize("profile", [None, "fanuc-lathe"])
def test_differences(before: str, after: str, lines: list[tuple[int, int]], profile: str | None) -> None:
    settings = chipbreak.load(profile) if profile else None
    hunks = chipbreak.diff(data_of(before), data_of(after), settings)
    changed = [hunk for hunk in hunks if hunk.tag != "equal"]
    pairs = [pair for hunk in changed for pair in zip(hunk.a_items, hunk.b_items, strict=True)]
    assert [(a.line, b.line) for a, b in pairs] == lines


@pytest.mark.parametrize("name", TOOLS)
def test_tools(name: str) -> None:
    if name.endswith((".fctb", ".fctl")):
        tools = {tool.number: tool for tool in chipbreak.read_tools(Path(FOLDER) / name)}
    else:
        profile = "linuxcnc-mill" if name.endswith(".ngc") else "fanuc-mill"
        tools = dict(chipbreak.tool_table(data_of(name), chipbreak.load(profile), name).tools)
    found = {
        number: (tool.type, tool.diameter_mm, tool.corner_radius_mm, tool.point_deg, tool.teeth)
        for number, tool in tools.items()
    }
    assert found == TOOLS[name]


@pytest.mark.parametrize("name", BITS)
def test_a_tool_bit_has_the_number_that_its_library_gives(name: str) -> None:
    library = Path(FOLDER) / "public" / "fcad" / "Library" / "lib.fctl"
    (tool,) = [tool for tool in chipbreak.read_tools(library) if tool.number == BITS[name]]
    assert tool.origins["diameter_mm"].endswith(Path(name).name)
    with pytest.raises(chipbreak.ToolFileError, match="a tool bit has no tool number"):
        chipbreak.read_tools(Path(FOLDER) / name)


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations(name: str) -> None:
    row = next(row for row in RIGHT if row.file == name) if "16b" not in name else None
    settings = chipbreak.load(row.profile if row else "linuxcnc-mill")
    found = chipbreak.explain(data_of(name), settings).operations
    assert [(one.tool, one.kind, one.label) for one in found] == OPERATIONS[name]


def value(setting: Setting | None) -> float | None:
    return setting and setting.value


@pytest.mark.parametrize(("name", "profile", "line", "place", "feed", "speed"), STATES)
def test_states(
    *,
    name: str,
    profile: str,
    line: int,
    place: tuple[float, float | None, float],
    feed: float | None,
    speed: float | None,
) -> None:
    settings = chipbreak.load(profile)
    state = interpret(parse(read(data_of(name), name), settings.dialect), settings).before(line)
    wanted = [(have, want) for have, want in zip(state.position, place, strict=True) if want is not None]
    assert [have for have, _ in wanted] == pytest.approx([want for _, want in wanted], abs=1e-6)
    assert (value(state.feed), value(state.speed)) == (pytest.approx(feed), pytest.approx(speed))


@pytest.mark.parametrize("row", [row for row in RIGHT if row.file.startswith("public/32")], ids=str)
def test_every_mark_stays(row: Right) -> None:
    if row.refused:
        return
    data = data_of(row.file)
    result = chipbreak.rewrite(data, settings_of(row), row.file)
    assert re.findall(rb"[$!][^ \n]*", result.data) == re.findall(rb"[$!][^ \n]*", data)


@pytest.mark.parametrize("row", [row for row in RIGHT if row.file.startswith("public/17")], ids=str)
def test_nothing_of_ours_has_a_number_that_the_program_calls(row: Right) -> None:
    data = data_of(row.file)
    source = read(chipbreak.rewrite(data, settings_of(row), row.file).data)
    ours = b"".join(source.raw(line) for one in regions(source) for line in range(one.first, one.last))
    numbers = [set(re.findall(rb"G65 P([0-9]+)", text)) for text in (data, ours)]
    assert numbers[0] and not numbers[0] & numbers[1]
    assert bool(numbers[1]) == bool(row.checks)
