"""G90 and G94: each block is a pass of four moves, from the start and back to it."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.settings import load
from chipbreak.text.diagnostics import ProgramRejectedError

HEAD = b"G21 G99\nT0101\nG97 S1200 M3\nG0 X52. Z2.\n"
TAIL = b"G0 X100. Z100.\nM30\n"
ALWAYS = 'cycles.unroll="always"'


def blocks_of(cycle: bytes, *options: str) -> list[str]:
    """What stands for the cycle, without comments."""
    program = HEAD + cycle + TAIL
    output = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS, *options])).data
    assert chipbreak.restore(output) == program
    assert chipbreak.rewrite(output, load("fanuc-lathe", [ALWAYS, *options])).data == output
    head = HEAD.count(b"\n")
    lines = output.decode().splitlines()[head : -TAIL.count(b"\n")]
    return [line for line in lines if not line.startswith("(")]


def test_along_z() -> None:
    assert blocks_of(b"G90 X48. Z-20. F0.2\nX46.\n") == [
        *("G0 X48.", "G1 Z-20. F0.2", "G1 X52.", "G0 Z2."),
        *("G0 X46.", "G1 Z-20.", "G1 X52.", "G0 Z2."),
    ]


def test_passes_are_counted() -> None:
    program = HEAD + b"G90 X48. Z-20. F0.2\nX46.\n" + TAIL
    output = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS])).data.decode()
    assert re.findall(r"\((PASS .*)\)", output) == ["PASS 1", "PASS 2"]


def test_along_x() -> None:
    assert blocks_of(b"G94 X20. Z0. F0.2\nZ-1.\n") == [
        *("G0 Z0.", "G1 X20. F0.2", "G1 Z2.", "G0 X52."),
        *("G0 Z-1.", "G1 X20.", "G1 Z2.", "G0 X52."),
    ]


def test_a_taper_begins_off_its_corner() -> None:
    assert blocks_of(b"G90 X48. Z-20. R-1. F0.2\n") == ["G0 X46.", "G1 X48. Z-20. F0.2", "G1 X52.", "G0 Z2."]
    assert blocks_of(b"G94 X20. Z0. R-1. F0.2\n") == ["G0 Z-1.", "G1 X20. Z0. F0.2", "G1 Z2.", "G0 X52."]


def test_distances_count_from_the_start() -> None:
    assert blocks_of(b"G90 U-4. W-22. F0.2\nU-6.\n") == blocks_of(b"G90 X48. Z-20. F0.2\nX46.\n")


def test_a_move_without_length_is_none() -> None:
    """A pass at the height of the start, or at the diameter of it, is cut as the control cuts it."""
    assert blocks_of(b"G94 X20. Z2. F0.2\nZ1.\n") == [
        *("G1 X20. F0.2", "G0 X52."),
        *("G0 Z1.", "G1 X20.", "G1 Z2.", "G0 X52."),
    ]
    assert blocks_of(b"G90 X52. Z-20. F0.2\nX50.\n") == [
        *("G1 Z-20. F0.2", "G0 Z2."),
        *("G0 X50.", "G1 Z-20.", "G1 X52.", "G0 Z2."),
    ]


def test_what_stands_between_passes_stays() -> None:
    assert "S1000 M8" in blocks_of(b"G90 X48. Z-20. F0.2\nS1000 M8\nX46.\n")


def test_one_cycle_follows_the_other() -> None:
    both = blocks_of(b"G90 X48. Z-20. F0.2\nG94 X20. Z0.\n")
    assert both[:4] == blocks_of(b"G90 X48. Z-20. F0.2\n")
    assert both[4:] == ["G0 Z0.", "G1 X20.", "G1 Z2.", "G0 X52."]


@pytest.mark.parametrize(("system", "codes"), [("B", (b"G77", b"G79")), ("C", (b"G20", b"G24"))])
def test_other_code_systems(system: str, codes: tuple[bytes, bytes], monkeypatch: pytest.MonkeyPatch) -> None:
    cycle = b"G90 X48. Z-20. F0.2\nG94 X20. Z0.\n"
    wanted = blocks_of(cycle)
    monkeypatch.setitem(globals(), "HEAD", HEAD.replace(b"G99", b"G95 G90"))
    mine = cycle.replace(b"G90", codes[0]).replace(b"G94", codes[1])
    assert blocks_of(mine, f"control.lathe_system={system}") == wanted


def test_the_cuts_of_passes_vibrate_where_the_profile_asks() -> None:
    program = HEAD + b"G90 X48. Z-20. F0.2\nX46.\n" + TAIL
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    asked = [line for cut in result.cuts for line in range(cut.plan.chain.first, cut.plan.chain.last)]
    assert {result.source.text(line) for line in asked} >= {"G1 Z-20. F0.2", "G1 Z-20."}
    assert chipbreak.restore(result.data) == program
    only = ["vibration.n=1.5", 'vibration.only=["drill"]']
    assert chipbreak.rewrite(program, load("fanuc-lathe", only)).data == program


@pytest.mark.parametrize(
    "cycle",
    [
        b"G90 X48. F0.2\n",
        b"G90 X48. Z-20. F0.2 M8\n",
        b"G90 X48. Z2. F0.2\n",
        b"G42\nG90 X48. Z-20. F0.2\n",
        b"G90 X48. Z-20. F0.2\nX#1\n",
        b"G90 X48. Z-20. F0.2\n/X46.\n",
        b"G0 X#1\nG90 X48. Z-20. F0.2\n",
    ],
)
def test_what_is_no_plain_pass_stays(cycle: bytes) -> None:
    program = HEAD + cycle + TAIL
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert b"UNROLLED" not in result.data
    assert "CYC007" in {d.code for d in result.diagnostics}
    with pytest.raises(ProgramRejectedError):
        chipbreak.rewrite(program.replace(b"T0101", b"T0101\n(VIB N1.5)"), load("fanuc-lathe"))


@pytest.mark.parametrize(
    "cycle",
    [
        b"G90 X1.8 Z-0.8 F0.008\n",
        b"G94 X0.8 Z0. F0.008\n",
        b"G71 U0.06 R0.02\nG71 P10 Q20 U0.01 W0.004 F0.008\nN10 G0 X0.8\nG1 Z-0.8\nN20 X2.2\n",
    ],
)
def test_no_cycle_ends_at_a_place_with_more_digits_than_are_written(cycle: bytes) -> None:
    """Its start was said in millimetres, and is no whole number of the steps of inches."""
    head = b"O1\nG21 G99 G40\nT0101\nG97 S600 M3\nG0 X55.01 Z2.003\nG20\n"
    program = head + cycle + b"G0 X4. Z4.\nM30\n"
    result = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS]))
    assert result.data == program
    (said,) = [d for d in result.diagnostics if d.code == "CYC007"]
    assert "has more digits than are written" in said.message
    on_grid = program.replace(b"G20\n", b"G20\nG0 X2.1657 Z0.0789\n")
    assert chipbreak.rewrite(on_grid, load("fanuc-lathe", [ALWAYS])).changed


@pytest.mark.parametrize("end", ["M30", "M2", "M99"])
def test_a_pass_whose_block_ends_the_program_stays(end: str) -> None:
    program = f"G97 S800 M3\nG99\nG0 X20. Z1.\nG90 X18. Z-20. F0.1 {end}\n".encode()
    for profile in ("fanuc-lathe", "haas-lathe"):
        settings = chipbreak.load(profile, ["cycles.unroll=always"])
        result = chipbreak.rewrite(program, settings)
        assert result.data == program
        assert [one.message for one in result.diagnostics if one.code == "CYC007"] == [
            "the program ends in the block of this cycle; the cycle stays as it was"
        ]
        assert chipbreak.explain(result, settings).as_dict()


@pytest.mark.parametrize("mark", ["!2L1", "$1"])
def test_a_mark_between_two_passes_lets_them_stay(mark: str) -> None:
    program = f"G97 S800 M3\nG99\nG0 X30. Z1.\nG90 X28. Z-20. F0.1\n{mark}\nX27.\nG0 X80.\nM30\n".encode()
    for profile in ("fanuc-lathe", "haas-lathe", "mitsubishi-lathe"):
        result = chipbreak.rewrite(program, chipbreak.load(profile, ["cycles.unroll=always"]))
        assert result.data == program
        said = next(one.message for one in result.diagnostics if one.code == "CYC007")
        assert said.startswith(f"{mark} is no plain pass of this cycle")
