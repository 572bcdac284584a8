"""Contours in subroutines (LinuxCNC): what a block need not say, and what it must."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest

import chipbreak

SAID = "G0 X8\nG1 Z-15\nG1 X12\nG1 X15 Z-22\nG1 Z-30\nG1 X26"
ARC = "G0 X8\nG1 Z-5\nG2 X12 Z-9 I4 K0\nG1 X26"
CYCLES = ("G71 Q100 I2 R0.5", "G70 Q100", "G70 Q100 D0.6 E0.2 P3")


def filtered(shape: str, cycle: str, before: str = "X28 Z2") -> chipbreak.Result:
    program = (
        "G8 G18 G21 G90 G94 G40\nF200 S800 M3\no100 sub\n"
        f"{shape}\no100 endsub\nG0 {before}\n{cycle}\nG0 X40 Z10\nM2\n"
    )
    settings = chipbreak.load("linuxcnc-lathe", ['cycles.unroll="always"'])
    return chipbreak.rewrite(program.encode(), settings)


def unrolled(shape: str, cycle: str) -> str:
    return filtered(shape, cycle).data.decode().partition(cycle)[2]


@pytest.mark.parametrize("cycle", CYCLES)
def test_a_line_need_not_say_g1_again(cycle: str) -> None:
    modal = "G0 X8\nG1 Z-15\nX12\nX15 Z-22\nZ-30\nX26"
    assert "G1" in unrolled(SAID, cycle)
    assert unrolled(modal, cycle) == unrolled(SAID, cycle)


@pytest.mark.parametrize("cycle", CYCLES)
def test_an_arc_says_its_own_code(cycle: str) -> None:
    said = filtered(ARC, cycle)
    assert said.changed and not said.diagnostics
    left = filtered(ARC.replace("G1 X26", "X16 Z-13 I0 K-4\nG1 X26"), cycle)
    assert not left.changed
    assert ["does not say G2 or G3 itself" in one.message for one in left.diagnostics] == [True]


def test_finishing_passes_are_counted() -> None:
    passes = [line for line in unrolled(SAID, CYCLES[-1]).split("\n") if line.startswith("(PASS")]
    # From D to E, evenly: 0.6 - 0.4 / 3 and so on.
    assert passes == [
        f"(PASS {number} {off} MM OFF THE CONTOUR)"
        for number, off in ((1, "0.4667"), (2, "0.3333"), (3, "0.2"))
    ]


@pytest.mark.parametrize(
    ("end", "is_cut"),
    [("X26", True), ("X26\nG1 Z-20", True), ("X20\nX18 Z-20\nX26", True), ("X26\nG1 X20 Z-20", False)],
)
def test_the_last_block_says_whether_a_contour_ends_in_a_pocket(end: str, is_cut: bool) -> None:
    """Pockets stay, so the edge of one that no wall ends would stay with all that is behind it."""
    said = filtered(f"G0 X8\nG1 Z-15\n{end}", "G71.1 Q100 I2 R0.5")
    assert said.changed == is_cut
    assert [one.code for one in said.diagnostics] == ([] if is_cut else ["CYC003"])


def test_a_cycle_that_leaves_pockets_ends_each_pass_at_their_edge_or_at_the_wall() -> None:
    """A pocket of 4 mm before the wall at X26: passes above it go on to the wall, the one in it does not."""
    blocks = unrolled("G0 X8\nG1 Z-15\nX20\nX16 Z-20\nX26", "G71.1 Q100 I2 R0.5").split("\n")
    ends = [after for block, after in pairwise(blocks) if re.fullmatch(r"G0 X(10|14|18|22|26)\.", block)]
    assert ends == ["G1 Z-20.", "G1 Z-20.", "G1 Z-15.", "G1 Z-15.", "G1 Z-15."]


@pytest.mark.parametrize(
    ("before", "is_free"),
    [("X40 Z-10", True), ("X28 Z-10", True), ("X27 Z-10", False), ("X20 Z-10", False), ("X20 Z2", True)],
)
def test_the_way_to_the_start_leads_over_the_stock_or_in_front_of_it(before: str, is_free: bool) -> None:
    """The stock reaches from X28 Z2 to the contour: over it and before it are ways, beside it is none."""
    said = filtered(SAID, "G71 Q100 X28 Z2 I2 R0.5", before)
    assert said.changed == is_free
    assert ["way to the start" in one.message for one in said.diagnostics] == ([] if is_free else [True])


@pytest.mark.parametrize("cycle", CYCLES)
def test_what_a_comment_of_the_cycle_does_is_done_before_it(cycle: str) -> None:
    """What a comment in the contour says may be done each time that it is read; how often, nobody knows."""
    lines = filtered(SAID, f"{cycle} (MSG, ROUGHING)").data.decode().splitlines()
    assert "(MSG, ROUGHING)" in lines
    stays = filtered(SAID.replace("X12", "X12 (LOG,#5420)"), cycle)
    assert not stays.changed
    assert any("(LOG,#5420) stands in the contour" in one.message for one in stays.diagnostics)


def test_y_of_a_mill_stays_where_it_was_through_several_cycles() -> None:
    shape = "o100 sub\nG0 X2. Z2.\nG1 Z-3.\nX11. Z-6.\nZ-10.\nX22.\no100 endsub\n"
    cycles = "G71 Q100 X20. Z2. I2. R0.5 F60.\nG70 Q100 X20. Z2. F40.\n"
    program = f"{shape}G18 G21 G94\nS500 M3\nG0 Y0.\nG0 X20. Z2.\n{cycles}G0 X80.\nM30\n"
    result = chipbreak.rewrite(program.encode(), chipbreak.load("linuxcnc-mill", ["cycles.unroll=always"]))
    assert result.data.count(b"UNROLLED") == 2
    assert chipbreak.restore(result.data) == program.encode()


@pytest.mark.parametrize(
    "cycle", ["$1 G71 Q100 X40. Z2. I1.", "G70 Q100 X40. Z2. $0", "G71 Q100 X40. Z2. I1. R0.5$1"]
)
@pytest.mark.parametrize("inner", ["X20.", "X20. $1"])
def test_a_spindle_named_in_a_cycle_or_its_contour_lets_it_stay(cycle: str, inner: str) -> None:
    for line in (cycle, "G71 Q100 X40. Z2. I1."):
        program = (
            f"o100 sub\nG0 X10. Z2.\nG1 Z-5.\n{inner}\nX40.\no100 endsub\n"
            f"G21\nG97 S800 M3\nG94 F100\nG0 X40. Z2.\n{line}\nG0 X80.\nM2\n"
        ).encode()
        result = chipbreak.rewrite(program, chipbreak.load("linuxcnc-lathe", ["cycles.unroll=always"]))
        is_plain = "$" not in line + inner
        assert (result.data == program) is not is_plain
        assert [one.code for one in result.diagnostics if one.code == "CYC007"] == ["CYC007"] * (not is_plain)


@pytest.mark.parametrize("end", ["M2", "G20\nM30", "G7\nM2\n(DONE)"])
@pytest.mark.parametrize("cycle", ["G71.2 Q100 X30. Z1. I2. R0.5 F100.", "G70 Q100 X30. Z1. F100."])
def test_a_cycle_behind_the_end_of_the_program_stays(end: str, cycle: str) -> None:
    """Nothing runs it, and of units and places nothing is known any more."""
    contour = "o100 sub\nG0 X2. Z1.\nG1 Z-4.\nX32.\no100 endsub\n"
    program = f"{contour}G18 G21 G94\nG97 S800 M3\nG0 X1. Z1.\n{end}\n{cycle}\nG0 X80.\nM30\n".encode()
    settings = chipbreak.load("linuxcnc-lathe", ("cycles.unroll=always",))
    result = chipbreak.rewrite(program, settings)
    assert result.data == program
    (said,) = (one for one in result.diagnostics if one.code == "CYC007")
    assert "behind the end of the program" in said.message
