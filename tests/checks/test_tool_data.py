"""Tool data on its way into the calls of a program: by file, by profile, by comment, or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from beam import BEAM
from chipbreak.cli import cli
from chipbreak.tools.data import ToolFileError

SAMPLES = Path(__file__).parents[2] / "samples"
SAMPLE = (SAMPLES / "fusion-mill.nc").read_bytes()
FILES = [str(SAMPLES / "tools" / name) for name in ("bracket.json", "bracket.csv")]
TOOLS = f"tools.files={FILES}".replace("'", '"')


def result(*options: str, data: bytes = SAMPLE, profile: str = "fanuc-mill") -> chipbreak.Result:
    return chipbreak.rewrite(data, chipbreak.load(profile, (*BEAM, *options)), "part.nc")


@pytest.mark.parametrize(
    ("profile", "block"),
    [
        ("fanuc-mill", b"G65 P8904 T3. K3. D6.8 R118. H62. E60. Q2. B30."),
        ("linuxcnc-mill", b"o<cb_tool> call [3] [3] [6.8] [118.] [2] [30.]"),
    ],
)
def test_the_macros_are_told_about_the_tool(profile: str, block: bytes) -> None:
    found = result(TOOLS, profile=profile)
    assert block in found.data
    assert not [d for d in found.diagnostics if d.code.startswith("TOL")]


def test_what_nobody_gave_is_left_to_the_control() -> None:
    found = result()
    assert found.data.count(b"P8901") == 3
    assert b"P8904" not in found.data
    said = [d for d in found.diagnostics if d.code == "CHK007"]
    assert [d.severity.value for d in said] == ["warning"] * 3
    assert "length_mm, holder_mm, teeth, helix_deg of T1" in said[0].message


def test_or_rejects_the_program() -> None:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        result("checks.missing=error")
    errors = [d for d in caught.value.diagnostics if d.code == "TOL010"]
    assert len(errors) == 12  # length, holder, teeth and helix of three tools
    assert errors[0].place is not None
    assert errors[0].place.line == 21
    assert "T1 needs its length below the holder" in errors[0].message
    assert "checks.missing=skip" in errors[0].help


def test_or_leaves_the_check_out() -> None:
    found = result("checks.missing=skip")
    assert b"P8901" not in found.data
    assert b"P8903" not in found.data
    missing = [d for d in found.diagnostics if d.code == "TOL010"]
    assert missing
    assert {d.severity.value for d in missing} == {"warning"}


def test_one_tool_that_is_known_is_checked_all_the_same(tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("number,type,teeth,diameter_mm,length_mm,helix_deg,holder_mm\n2,,4,,38,45,70\n")
    found = result(f'tools.files=["{table}"]', "checks.missing=skip")
    assert b"G65 P8901 T2. S5300." in found.data
    assert found.data.count(b"P8901") == 1
    assert found.data.count(b"P8903 T2.") == 2


def test_a_call_that_says_nothing_of_the_tool_needs_nothing() -> None:
    found = result("checks.calls=shop", 'calls.shop={chip_check=["G65 P9858 T{tool} H{limit}"]}')
    assert found.data.count(b"P9858") == 4


def test_a_check_of_edges_may_need_tool_data_too() -> None:
    shop = ["checks.calls=shop", 'calls.shop={chip_check=["G65 P9858 T{tool} D{diameter} Q{teeth}"]}']
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        result(*shop)
    errors = [d for d in caught.value.diagnostics if d.code == "TOL010"]
    assert len(errors) == 3
    assert "CHIP CHECK of T1 needs its number of teeth" in errors[0].message
    assert b"G65 P9858 T2 D12. Q4" in result(*shop, TOOLS).data


def test_what_stands_still_is_not_checked() -> None:
    probing = SAMPLE.replace(b"ZMIN=-17.043 - DRILL", b"ZMIN=-17.043 - TURNING TOOL")
    found = result(f'tools.files=["{FILES[0]}"]', "checks.only=[3]", data=probing)
    assert b"P8901" not in found.data


def test_ignored_tools_need_nothing() -> None:
    assert b"P8901" not in result("checks.ignore=[1,2,3]").data


def test_a_bad_file_is_an_error_even_where_no_check_is_made(tmp_path: Path) -> None:
    with pytest.raises(ToolFileError):
        result("checks.enabled=false", 'tools.files=["no/such.csv"]')


@pytest.mark.parametrize("command", ["filter", "check", "explain"])
def test_the_option_reaches_every_command(command: str) -> None:
    source = str(SAMPLES / "fusion-mill.nc")
    args = [command, "-p", "fanuc-mill", "--set", "checks.missing=error", source]
    bare = CliRunner().invoke(cli, args)
    assert bare.exit_code == (1 if command == "check" else 3)
    given = CliRunner().invoke(cli, [*args, "--tools", FILES[0], "--tools", FILES[1]])
    assert given.exit_code == 0, given.output
    missing = CliRunner().invoke(cli, [*args, "--tools", "no/such.csv"])
    assert missing.exit_code == 2
    assert "TOL001" in missing.stderr
    assert missing.stdout == ""
