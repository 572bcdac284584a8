"""The inserted blocks: they change nothing that the program does, and would crash no machine."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from hypothesis import given

import chipbreak
from beam import BEAM
from checks.filtered import Filtered, check, filtered
from checks.programs import mill_programs
from chipbreak.editing.restore import regions
from chipbreak.text.source import read

CASES = sorted((Path(__file__).parents[1] / "cases" / "check_tools").glob("*.nc"))
DIVIDER = b"; --- output\n"
FLAGS = b"; flags: "


def options_of(flags: str) -> tuple[str, list[str]]:
    """``-p PROFILE --set KEY=VALUE ...``."""
    words = shlex.split(flags)
    profile, options = "", []
    for flag, value in zip(words[::2], words[1::2], strict=True):
        if flag == "-p":
            profile = value
        else:
            assert flag == "--set"
            options.append(value)
    return profile, options


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.stem)
def test_case(case: Path) -> None:
    """``; --- output`` divides what goes in from what comes out; without it nothing may change."""
    first, _, rest = case.read_bytes().partition(b"\n")
    assert first.startswith(FLAGS)
    profile, options = options_of(first.removeprefix(FLAGS).decode())
    program, divider, expected = rest.partition(DIVIDER)
    result = filtered(program, profile, *options)
    assert result.output.decode("latin-1") == (expected if divider else program).decode("latin-1")
    check(result)


def test_there_are_cases() -> None:
    assert len(CASES) >= 10


def is_not_silent(result: Filtered) -> bool:
    """Checks, or a word about why there are none."""
    return bool(result.edits or result.diagnostics)


@pytest.mark.few(12)
@given(mill_programs(waits=False))
def test_fanuc_programs_do_what_they_did(program: bytes) -> None:
    result = filtered(program, "fanuc-mill")
    check(result)
    assert is_not_silent(result)


@pytest.mark.few(12)
@given(mill_programs(waits=False))
def test_a_cycle_that_ends_the_length_offset_changes_nothing_either(program: bytes) -> None:
    result = filtered(program, "fanuc-mill", "checks.calls=renishaw")
    check(result)
    assert is_not_silent(result)


@pytest.mark.few(12)
@given(mill_programs(waits=True))
def test_linuxcnc_programs_do_what_they_did(program: bytes) -> None:
    result = filtered(program, "linuxcnc-mill")
    check(result)
    assert is_not_silent(result)


def test_a_tool_waiting_in_the_magazine_is_kept() -> None:
    cut = b"G0 X1. Y1.\nZ1.\nS1000 M3\nG1 Z-1. F9.\nG0 Z9.\n"
    result = filtered(b"T1\nM6\nT2\n" + cut + b"M5\nM6\n" + cut, "fanuc-mill")
    assert len(result.edits) > 3
    check(result)


@pytest.mark.large_is_long
def test_real_programs_do_what_they_did(corpus_file: Path) -> None:
    """All programs of the corpus under both mills; most are none, and must not hurt."""
    for profile in ("fanuc-mill", "linuxcnc-mill"):
        result = filtered(corpus_file.read_bytes(), profile)
        assert is_not_silent(result)
        if result.edits:
            check(result)
        else:
            assert result.output == result.data


def test_real_mill_programs_get_checks(corpus: list[Path]) -> None:
    """Those without: most call no tool at all (a post for a machine without a changer)."""
    mills = [file for file in corpus if file.parent.name in ("mill-cam", "mill-hand")]
    found = [filtered(file.read_bytes(), "fanuc-mill") for file in mills]
    assert sum(bool(result.edits) for result in found) >= 18
    assert sum(len(result.edits) for result in found) >= 95
    without = [result for result in found if not result.edits]
    calls_none = [result for result in without if "CHK001" in result.codes]
    assert len(calls_none) >= 0.7 * len(without)
    # No place, no speed that is known, or no tool: each is said.
    assert all({"CHK002", "CHK003", "CHK006"} & set(r.codes) for r in without if r not in calls_none)


def test_brackets_hold_nothing_but_insertions() -> None:
    sample = Path(__file__).parents[2] / "samples" / "fusion-mill.nc"
    result = filtered(sample.read_bytes())
    found = regions(read(result.output))
    assert [region.original for region in found] == [b""] * len(result.edits)
    assert b"\r\n" in result.output and result.output.count(b"\n") == result.output.count(b"\r\n")


@pytest.mark.parametrize("code", ["G54.1", "G154"])
def test_a_place_in_another_work_offset_is_not_gone_back_to(code: str) -> None:
    """Y0 of the first offset is somewhere else in the second: there the check would have come down."""
    program = (
        f"G21 G90 {code} P1\nT1 M6\nS3000 M3\nG0 X0. Y0.\nG43 H1 Z20.\n(ROUGH)\n"
        f"G98 G81 X10. Y0. Z-5. R2. F100.\n(FINISH)\n{code} P2\nG80 G0 X5.\nZ20.\n"
        "G1 Z-1. F100.\nG0 Z20.\nM30\n"
    )
    result = filtered(program.encode())
    check(result)
    assert result.titles == ["CALIBRATE", "TOOL CHECK T1, TRACE T1", "CHIP CHECK T1 W0.05"]
    assert result.codes == ["CHK002"]


@pytest.mark.parametrize(
    ("lead_out", "is_known"), [("G40", False), ("G1 G40 X0.", True), ("G40\nG0 Y1.", True)]
)
def test_where_compensation_ended_without_a_move_the_tool_stands_beside_its_numbers(
    lead_out: str, is_known: bool
) -> None:
    program = (
        "G21 G90 G17 G54\nT1 M6\nS3000 M3\nG0 X0. Y0.\nG43 H1 Z20.\n(ROUGH)\n"
        f"G1 Z-1. F100.\nG41 D1 X9.\nY9.\n{lead_out}\nG0 Z20.\n(FINISH)\nG0 Z5.\nG1 Z-1.\nG0 Z20.\nM30\n"
    )
    result = filtered(program.encode())
    check(result)
    assert ("CHIP CHECK T1 W0.02" in result.titles) == is_known
    assert ("CHK002" in result.codes) != is_known


@pytest.mark.parametrize(("angle", "is_safe"), [("45", False), ("0", True)])
def test_no_check_stands_in_a_work_offset_that_linuxcnc_has_turned(angle: str, is_safe: bool) -> None:
    program = (
        "G21 G90 G17\nT1 M6\nS3000 M3\nG0 X0 Y0\nG43 H1 Z20\n(ROUGH)\nG1 Z-1 F100\n"
        "G83 X1 Z-2 R3 Q1\n(FINISH)\n"
        f"G10 L2 P1 R{angle}\nG80\nG0 X0 Y0\nG0 Z5\nG1 Z-1\nG0 Z20\nM2\n"
    )
    result = filtered(program.encode(), "linuxcnc-mill")
    check(result)
    assert ("CHIP CHECK T1 W0.02" in result.titles) == is_safe
    turned = [d for d in result.diagnostics if "rotated (G10 with R, line 10)" in d.message]
    assert bool(turned) != is_safe


# What comes behind a check, and what it gives back of S, spindle and coolant.
NEXT = [
    ("G0 X5. Y5.", ["M8", "S1000 M3"]),
    ("M5", ["M8"]),  # coolant is not ended
    ("M9\nM5", []),
    ("M9", ["S1000 M3"]),
    ("M5 M9", []),
    ("(A COMMENT)\n\nM5\nM9", []),
    ("G28 G91 Z0.\nG90\nM5\nM9", []),
    ("S8000 M3", ["M8"]),
    ("S8000 M3 G4 X2.", ["M8"]),
    ("G4 X2.\nS8000 M3", ["M8", "S1000 M3"]),
    ("M5\nM3", ["M8", "S1000"]),  # it starts with the S from before
    ("M3", ["M8", "S1000"]),
    ("S8000", ["M8", "S1000 M3"]),  # the spindle turns on at another speed
    ("M42\nM5\nM9", ["M8", "S1000 M3"]),  # nobody knows what M42 wants
    ("M1\nM5\nM9", ["M8", "S1000 M3"]),  # an operator may look
    ("/M5\nM9", ["M8", "S1000 M3"]),
    ("#1=2\nM5", ["M8", "S1000 M3"]),
    ("M98 P5\nM5", ["M8", "S1000 M3"]),
    # What stands beside G66 is for the macro.
    ("G66 P5 M9\nG67", ["M8", "S1000 M3"]),
    ("G66 P5 S900 M3\nG67", ["M8", "S1000 M3"]),
    ("M5 G66 P5\nG67", ["M8", "S1000 M3"]),
    ("M30 G66 P5\nG67", ["M8", "S1000 M3"]),
]


@pytest.mark.parametrize(("blocks", "given_back"), NEXT, ids=[blocks for blocks, _ in NEXT])
def test_what_the_next_blocks_say_themselves_is_not_given_back(blocks: str, given_back: list[str]) -> None:
    head = "%\nO1\nG90 G21 G40 G80\n(ROUGH)\nT1 M6\nS1000 M3\nM8\nG54 G0 X1. Y1.\nG43 H1 Z15.\n"
    cut = "G1 Z-1. F100.\nX30.\nG0 Z15.\n"
    again = "G90 G0 X1. Y1. S1000 M3\nM8\nG43 H1 Z15.\n"
    program = f"{head}{cut}(FINISH)\n{blocks}\n{again}{cut}M30\n%\n"
    result = filtered(program.encode(), "fanuc-mill")
    check(result)
    (edit,) = [one for one in result.edits if one.title == "CHIP CHECK T1 W0.02"]
    assert edit.first == (head + cut).count("\n")
    texts = list(map(str, edit.content))
    assert sorted(text for text in texts if text.startswith("S") or text == "M8") == given_back
    assert chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-mill", BEAM)).changed
