"""Brackets in a file beside the program: nothing is lost, nothing is guessed, and both files fit together."""

from __future__ import annotations

import json
import os
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from chipbreak import program_files, whole_files
from chipbreak.cli import cli
from chipbreak.editing.beside import parted, with_brackets
from chipbreak.editing.diff import compare
from chipbreak.editing.diff_items import items_of
from chipbreak.editing.diff_output import as_json
from editing.test_restore import CUT, PROGRAMS
from linuxcnc import rs274
from longer import every_second
from test_cases import CASES, DIVIDER, FLAGS

NONE = "output.brackets=none"
SETTINGS = chipbreak.load("generic-lathe", [NONE])
COMMENTS = chipbreak.load("generic-lathe")
OURS = re.compile(rb"CHIPBREAK (?:BEGIN|WAS|HEX|END \w|UNROLLED|ROLLED|COMPENSATED|OFFSET)")
# What is unrolled, offset under G41, and changed inside: brackets of all layers.
LAYERS = (
    b"T0101\nG97 S800 M3\nG0 X64. Z5.\nG70 P10 Q20\nG28 U0 W0\nM30\n"
    b"N10 G42 G0 X30. F0.15\nG1 Z-20.\nX40. Z-30.\nZ-40.\nX62.\nN20 G40 G1 X64.\n"
)
LAYERED = (
    'planner.model="trapezoid"',
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
    "vibration.n=1.5",
    'vibration.only=["rough","semi-finish","finish","unknown"]',
    "tools.nose_radius_mm.1=0.8",
    "tools.nose_tip.1=3",
    NONE,
)


def bare(program: bytes, settings: chipbreak.Settings = SETTINGS) -> chipbreak.Result:
    """Filtered without comments; all that must hold of it holds."""
    result = chipbreak.rewrite(program, settings)
    assert result.beside is not None
    assert not OURS.search(result.data)
    assert chipbreak.restore(result.data, beside=result.beside) == program
    again = chipbreak.rewrite(result.data, settings, beside=result.beside)
    assert (again.data, again.beside, again.changed) == (result.data, result.beside, False)
    return result


@pytest.mark.parametrize("program", every_second(PROGRAMS))
def test_there_and_back(program: bytes) -> None:
    result = bare(program)
    with_comments = chipbreak.rewrite(program, COMMENTS).data
    assert result.bracketed == with_comments
    assert chipbreak.rewrite(result.data, COMMENTS, beside=result.beside).data == with_comments
    assert chipbreak.rewrite(with_comments, SETTINGS).data == result.data


@pytest.mark.parametrize("end", [b"", b"\n", b"\r\n"])
def test_a_file_without_a_last_line_end_keeps_none(end: bytes) -> None:
    line_end = end or b"\n"
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5".replace(b"\n", line_end) + end
    result = bare(program)
    assert result.data.count(line_end) > 10
    assert re.sub(rb".*[^\r\n]", b"", result.data, flags=re.DOTALL) == end
    # And so does one whose last line is none of ours.
    below = bare(program.removesuffix(end) + line_end + b"M30" + end)
    assert below.data.endswith(line_end + b"M30" + end)


def settings_of(program: str) -> chipbreak.Settings:
    words = shlex.split(program.splitlines()[0].removeprefix(FLAGS)) if program.startswith(FLAGS) else []
    pairs = list(zip(words[::2], words[1::2], strict=True))
    profile = next((value for option, value in pairs if option == "-p"), "generic-lathe")
    return chipbreak.load(profile, [NONE, *(value for option, value in pairs if option == "--set")])


@pytest.mark.parametrize("file", every_second(CASES), ids=lambda file: file.stem)
def test_the_cases(file: Path) -> None:
    program, divider, _ = file.read_bytes().decode("latin-1").partition(DIVIDER)
    if divider:
        bare(program.encode("latin-1"), settings_of(program))


def test_all_layers() -> None:
    settings = chipbreak.load("fanuc-lathe", LAYERED)
    result = bare(LAYERS, settings)
    kinds = set(re.findall(rb"CHIPBREAK ([A-Z]+)", result.bracketed))
    assert {b"BEGIN", b"UNROLLED", b"COMPENSATED"} <= kinds
    verified = chipbreak.verify(result.data, settings, beside=result.beside)
    assert len(verified.cuts) == len(result.cuts) > 0


@pytest.mark.skipif(not rs274.available(), reason="LinuxCNC is not installed")
@pytest.mark.parametrize("form", ["expanded", "loop"])
def test_linuxcnc_runs_the_same(form: str) -> None:
    program = b"G7 G95 G97 S3000 M3\nG0 X20. Z2.\nN30 G1 Z-3. F0.05 N1.5\nX30. N2.5\nG0 Z5.\nM2\n"
    sets = ["planner.model=ideal", f"output.form={form}"]
    both = [
        rs274.judge(chipbreak.rewrite(program, chipbreak.load("linuxcnc-lathe", more)).data, lathe=True)
        for more in (sets, [*sets, NONE])
    ]
    moves = [[call for call in one.canon if "COMMENT" not in call and "MESSAGE" not in call] for one in both]
    strip = [[re.sub(r"^\s*\d+\s+N\S+\s+", "", call) for call in one] for one in moves]
    assert both[0].accepted and both[1].accepted, both[1].message
    assert len(moves[0]) > 100
    assert strip[0] == strip[1]


@pytest.mark.parametrize("program", [CUT, CUT.replace(b"\n", b"\r\n"), CUT.replace(b"G1", b"N10 G1")])
@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_other_line_ends_after_transmission(program: bytes, end: bytes) -> None:
    result = bare(program)
    sent = result.data.replace(b"\r\n", b"\n").replace(b"\n", end)
    assert chipbreak.restore(sent, beside=result.beside) == program.replace(b"\r\n", b"\n").replace(
        b"\n", end
    )


def test_the_lines_of_messages_are_those_of_the_file() -> None:
    filtered = bare(CUT.replace(b"M30", b"G1 Z-5. F0.05\nM30"))
    line = filtered.data.split(b"\n").index(b"G1 Z-5. F0.05") + 1
    settings = chipbreak.load("generic-lathe", [NONE, "vibration.n=2", "vibration.refused=error"])
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(filtered.data, settings, beside=filtered.beside)
    assert line in {one.place.line for one in caught.value.diagnostics if one.place}


def test_a_comparison_says_the_lines_of_the_file() -> None:
    """Behind a cut of hundreds of blocks a line is that in the file, which has no bracket lines."""
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nG0 X30.\nM30\n"
    one, other = bare(program), bare(program.replace(b"X30.", b"X31."))
    hunks = compare(*(items_of(result.data, "part.nc", beside=result.beside) for result in (one, other)))
    (changed,) = as_json(hunks)
    line = one.data[: one.data.index(b"G0 X30.")].count(b"\n") + 1
    assert line > 100
    assert changed == {"a": [{"line": line, "text": "G0 X30."}], "b": [{"line": line, "text": "G0 X31."}]}


# --- what is not guessed ----------------------------------------------------------------------------------
def refused(data: bytes, beside: bytes) -> str:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.restore(data, beside=beside)
    (said,) = caught.value.diagnostics
    return said.code


def test_a_program_that_was_changed_is_said() -> None:
    result = bare(CUT)
    assert result.beside is not None
    assert refused(result.data.replace(b"X20.", b"X21."), result.beside) == "RES003"
    assert refused(result.data + b"\n", result.beside) == "RES003"
    assert chipbreak.restore(CUT, beside=result.beside) == CUT, "posted again as it was, it is known"


ENTRY = '{"chipbreak": 1, "programs": [{"sha256": "%s", "brackets": [%s]}]}'


@pytest.mark.parametrize(
    "beside",
    [
        "",
        "[]",
        "{",
        "[" * 100_000,
        '{"chipbreak": 2, "programs": []}',
        '{"chipbreak": 1}',
        '{"chipbreak": 1, "programs": [1]}',
        '{"chipbreak": 1, "programs": [{"sha256": "0", "brackets": [[1, 0]]}]}',
        '{"chipbreak": 1, "programs": [{"sha256": "0", "brackets": [[1e999, 0, "x"]]}]}',
        '{"chipbreak": 1, "programs": [{"sha256": "0", "brackets": [[1, 0, 5]]}]}',
        '{"chipbreak": 1, "programs": [{"sha256": "0", "brackets": [[1, 0, "\\u8352"]]}]}',
    ],
)
def test_a_file_that_cannot_be_read_is_said(beside: str) -> None:
    assert refused(CUT, beside.encode()) == "RES004"


@pytest.mark.parametrize(
    "brackets",
    ['[99, 0, "x"]', '[1, 99, "x"]', '[0, 0, "x"]', '[1, -1, "x"]', '[2, 0, "x"], [1, 0, "y"]'],
)
@pytest.mark.parametrize("program", [CUT, b""])
def test_places_that_are_not_there_are_said(brackets: str, program: bytes) -> None:
    import hashlib

    beside = ENTRY % (hashlib.sha256(program).hexdigest(), brackets)
    assert refused(program, beside.encode()) == "RES004"


def test_a_broken_bracket_in_the_file_is_said() -> None:
    result = bare(CUT)
    assert result.beside is not None
    assert refused(result.data, result.beside.replace(b"F0.05", b"F0.06")) == "RES001"
    assert refused(result.data, re.sub(rb"CHIPBREAK END \w+", b"CHIPBREAK", result.beside)) == "RES002"


# --- on the disk ------------------------------------------------------------------------------------------
@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CHIPBREAK_PROFILE", raising=False)
    (tmp_path / "a.nc").write_bytes(CUT)
    (tmp_path / "chipbreak.toml").write_text('base = "generic-lathe"\n[output]\nbrackets = "none"\n')
    whole_files.SWEPT.clear()
    return tmp_path


def run(*arguments: str, code: int = 0, stdin: bytes | None = None) -> str:
    done = CliRunner().invoke(cli, list(arguments), input=stdin)
    assert done.exit_code == code, done.output
    return done.output


def names(folder: Path) -> set[str]:
    return {one.name for one in folder.iterdir()} - {"chipbreak.toml"}


def test_in_place_and_back(folder: Path) -> None:
    run("filter", "-i", "a.nc")
    assert names(folder) == {"a.nc", "a.nc.chipbreak"}
    was = {one.name: (one.read_bytes(), one.stat().st_mtime_ns) for one in folder.iterdir()}
    run("filter", "-i", "a.nc")
    run("filter", "--check", "a.nc")
    assert was == {one.name: (one.read_bytes(), one.stat().st_mtime_ns) for one in folder.iterdir()}
    assert "1 cut" in run("verify", "a.nc") or "Vibrated cuts: 1" in run("verify", "a.nc")
    assert "Vibrated cuts: 1" in run("explain", "a.nc")
    run("check", "a.nc")
    run("restore", "a.nc", "-o", "a.nc")
    assert names(folder) == {"a.nc"}
    assert (folder / "a.nc").read_bytes() == CUT


def test_a_link_leads_to_the_file_beside_what_it_links(folder: Path) -> None:
    (folder / "there").mkdir()
    (folder / "a.nc").rename(folder / "there" / "real.nc")
    (folder / "a.nc").symlink_to("there/real.nc")
    run("filter", "-i", "a.nc")
    assert names(folder / "there") == {"real.nc", "real.nc.chipbreak"}
    assert run("restore", "there/real.nc").encode() == CUT


def test_to_another_file_and_what_was_there_before(folder: Path) -> None:
    run("filter", "a.nc", "-o", "b.nc")
    assert names(folder) == {"a.nc", "b.nc", "b.nc.chipbreak"}
    run("diff", "b.nc", "b.nc")
    assert "[VIB" in run("diff", "a.nc", "b.nc", code=1)
    run("filter", "-p", "generic-lathe", "a.nc", "-o", "b.nc")  # with comments: the file beside it is no more
    assert names(folder) == {"a.nc", "b.nc"}
    assert run("restore", "b.nc").encode() == CUT


def test_stdout_has_no_place_for_a_file(folder: Path) -> None:
    assert "--beside" in run("filter", "a.nc", code=2)
    assert names(folder) == {"a.nc"}
    out = run("filter", "a.nc", "--beside", "x.chipbreak", "-q").encode()
    assert not OURS.search(out)
    assert names(folder) == {"a.nc", "x.chipbreak"}
    assert run("restore", "--beside", "x.chipbreak", stdin=out).encode() == CUT
    assert run("filter", "--beside", "x.chipbreak", "-q", stdin=out).encode() == out
    assert "RES003" in run("filter", "--beside", "x.chipbreak", stdin=out + b"\n", code=3)


def test_a_backup_takes_its_file_along(folder: Path) -> None:
    run("filter", "-i", "a.nc")
    run("filter", "-i", "a.nc", "--backup", ".bak", "--set", "vibration.margin=1.3")
    assert names(folder) == {"a.nc", "a.nc.chipbreak", "a.nc.bak", "a.nc.bak.chipbreak"}
    assert run("restore", "a.nc.bak").encode() == run("restore", "a.nc").encode() == CUT


def test_a_program_that_is_posted_again(folder: Path) -> None:
    run("filter", "-i", "a.nc")
    posted = CUT.replace(b"Z-3.", b"Z-4.")
    (folder / "a.nc").write_bytes(posted)
    assert "RES003" in run("filter", "-i", "a.nc", code=3)
    assert (folder / "a.nc").read_bytes() == posted
    run("filter", "-i", "--fresh", "a.nc")
    assert run("restore", "a.nc").encode() == posted
    run("filter", "-i", "--fresh", "a.nc")  # the same again is known as filtered
    assert run("restore", "a.nc").encode() == posted


def test_batch_and_the_stamp(folder: Path) -> None:
    run("batch", "a.nc", "-o", "out", "-j", "1", "--set", "output.stamp=true")
    assert names(folder / "out") == {"a.nc", "a.nc.chipbreak"}
    assert not OURS.search((folder / "out" / "a.nc").read_bytes())
    assert b"STAMP" in (folder / "out" / "a.nc.chipbreak").read_bytes()
    run("verify", "out/a.nc")
    run("batch", "a.nc", "-o", "other", "-j", "1", "--set", "output.stamp=true", "--set", "output.decimals=5")
    assert "by chipbreak" in run("verify", "other/a.nc", code=2), (
        "the stamp names a profile with another value"
    )
    run("verify", "-p", "chipbreak.toml", "--set", "output.stamp=true", "out/a.nc")
    (folder / "out" / "a.nc").write_bytes((folder / "out" / "a.nc").read_bytes() + b"(EDITED)\n")
    assert "RES003" in run("batch", "out", "-o", "again", "-j", "1", "-p", "chipbreak.toml", code=3)


def test_a_start_in_the_middle(folder: Path) -> None:
    program = (
        b"%\nO1000 (SHAFT)\nG21 G40 G99\nG54\nT0101\nG50 S2500\nG97 S1200 M3\nG0 X52. Z2. M8\nG0 X46.\n"
        b"G1 Z-30. F0.2 N1.5\nG0 X50.\nZ2.\nG28 U0 W0 M9\nM1\nT0202\nG97 S1800 M3\nG0 X40. Z2. M8\n"
        b"G1 Z-30. F0.08 N1.5\nG0 X60.\nG28 U0 W0 M9\nM5\nM30\n%\n"
    )
    (folder / "a.nc").write_bytes(program)
    (folder / "chipbreak.toml").write_text(
        'base = "fanuc-lathe"\n[output]\nbrackets = "none"\n[planner]\nmodel = "ideal"\n'
    )
    run("filter", "-i", "a.nc")
    lines = (folder / "a.nc").read_bytes().split(b"\n")
    number = lines.index(b"T0202") + 1
    run("resume", "a.nc", "--line", str(number), "-o", "b.nc")
    with_comments = chipbreak.rewrite(program, chipbreak.load("fanuc-lathe", ['planner.model="ideal"'])).data
    (folder / "c.nc").write_bytes(with_comments)
    wanted = with_comments.split(b"\n").index(b"T0202") + 1
    run("resume", "c.nc", "--line", str(wanted), "-o", "d.nc")
    start = (folder / "b.nc").read_bytes()
    assert not re.search(rb"\(CHIPBREAK", start)
    rest = with_brackets(start, "b.nc", (folder / "b.nc.chipbreak").read_bytes()).data
    other = re.sub(rb"\(CHIPBREAK RESUME[^)]*\)\n", b"", (folder / "d.nc").read_bytes())
    assert rest == other
    inside = lines.index(b"G0 X60.")  # the last block of the second cut
    said = run("resume", "a.nc", "--line", str(inside), "-o", "e.nc")
    assert re.search(
        rf"starts at line (\d+); line {inside} is in what chipbreak wrote, lines \d+ to {inside}", said
    )
    assert f"no line {len(lines) + 9}" in run("resume", "a.nc", "--line", str(len(lines) + 9), code=2)


# --- killed -----------------------------------------------------------------------------------------------
STEPS = {
    "new": [("a.nc", NONE)],
    "other settings": [("a.nc", NONE), ("a.nc", NONE, "vibration.margin=1.3")],
    "comments after": [("a.nc", NONE), ("a.nc", "output.brackets=comments")],
    "comments before": [("a.nc", "output.brackets=comments"), ("a.nc", NONE)],
}


def killed_at(step: int, arguments: list[str]) -> bool:
    """Run the command in a process of its own that dies before its n-th step; whether it did."""
    child = os.fork()
    if child == 0:
        count = 0
        real = Path.replace

        def replace(self: Path, target: Path) -> Path:
            nonlocal count
            if count == step:
                os._exit(9)
            count += 1
            return real(self, target)

        Path.replace = replace  # type: ignore[assignment,method-assign]
        removed = program_files.remove_file

        def remove(target: Path) -> None:
            nonlocal count
            if count == step:
                os._exit(9)
            count += 1
            removed(target)

        program_files.remove_file = remove
        try:
            code = CliRunner().invoke(cli, arguments).exit_code
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.parametrize("name", STEPS)
def test_a_killed_run_leaves_what_fits_together(name: str, folder: Path) -> None:
    *before, last = STEPS[name]
    for step in range(5):
        for one in folder.iterdir():
            if one.name != "chipbreak.toml":
                one.unlink()
        (folder / "a.nc").write_bytes(CUT)
        for _, *sets in before:
            run("filter", "-q", "-i", "a.nc", *(part for one in sets for part in ("--set", one)))
        was = (folder / "a.nc").read_bytes()
        arguments = ["filter", "-q", "-i", "a.nc", *(part for one in last[1:] for part in ("--set", one))]
        dies = killed_at(step, arguments)
        assert run("restore", "a.nc").encode() == CUT
        run("filter", "-q", *arguments[2:])
        assert (folder / "a.nc").read_bytes() != was
        assert run("restore", "a.nc").encode() == CUT
        if not dies:
            break
    assert step >= (2 if NONE in last or before else 1)
    assert not dies


def test_the_program_cannot_be_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run("filter", "-i", "a.nc")
    was = {one.name: one.read_bytes() for one in folder.iterdir()}
    real = program_files.replace_file

    def fails(target: Path, pieces: list[bytes], **more: bytes | None) -> None:
        if target.name == "a.nc":
            raise SystemExit(2)
        real(target, pieces, **more)

    monkeypatch.setattr(program_files, "replace_file", fails)
    run("filter", "-i", "a.nc", "--set", "vibration.margin=1.3", code=2)
    assert was == {one.name: one.read_bytes() for one in folder.iterdir()}


def test_what_is_taken_out_and_where() -> None:
    result = bare(CUT.replace(b"G1", b"N10 G1"))
    new = parted(result.bracketed, "a.nc")
    assert new.beside is not None
    first = json.loads(new.beside)["programs"][0]["brackets"]
    assert first[0][:2] == [3, 3]
    assert first[0][2].startswith(" (CHIPBREAK BEGIN VIB")
    assert parted(CUT, "a.nc") == (CUT, None)
