"""G74 and G75 break chips by their pecks: they stay, until a wish says PECK OFF."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.settings import load
from chipbreak.text.diagnostics import ProgramRejectedError

HEAD = "G21 G99\nT0101\nG97 S1200 M3\n"
TAIL = "G0 X100. Z100.\nM30\n"
GROOVE = "G0 X42. Z-10.\nG75 R0.5\nG75 X20. Z-18. P2000 Q3000 F0.1\n"
DRILL = "G0 X0. Z3.\nG74 R1.\nG74 Z-40. Q5000 F0.12\n"


def moves_of(program: str, *options: str) -> list[str]:
    """The blocks that stand for the cycle, its cuts as they were before they vibrated."""
    result = chipbreak.rewrite(program.encode(), load("fanuc-lathe", options))
    assert chipbreak.restore(result.data) == program.encode()
    output = result.data.decode()
    body = output[output.index("(PASS 1") : output.index("(CHIPBREAK ROLLED")]
    lines = re.sub(
        r"\(CHIPBREAK BEGIN.*?\n\(CHIPBREAK WAS (.*?)\)\n.*?\(CHIPBREAK END.*?\)", r"\1", body, flags=re.S
    )
    return [line for line in lines.splitlines() if not line.startswith("(")]


def test_a_groove_in_steps() -> None:
    assert moves_of(f"{HEAD}(VIB N1.5 PECK OFF)\n{GROOVE}{TAIL}") == [
        *("G1 X20. F0.1", "G0 X42.", "G0 Z-13.", "G1 X20.", "G0 X42.", "G0 Z-16.", "G1 X20.", "G0 X42."),
        *("G0 Z-18.", "G1 X20.", "G0 X42.", "G0 Z-10."),
    ]


def test_a_groove_the_other_way() -> None:
    groove = GROOVE.replace("Z-10.", "Z@").replace("Z-18.", "Z-10.").replace("Z@", "Z-18.")
    assert moves_of(f"{HEAD}(VIB N1.5 PECK OFF)\n{groove}{TAIL}") == [
        *("G1 X20. F0.1", "G0 X42.", "G0 Z-15.", "G1 X20.", "G0 X42.", "G0 Z-12.", "G1 X20.", "G0 X42."),
        *("G0 Z-10.", "G1 X20.", "G0 X42.", "G0 Z-18."),
    ]


@pytest.mark.parametrize("wish", ["(VIB N1.5 PECK OFF)", "(VIB PECK OFF N1.5)", "(VIB N1.5, PECK=OFF)"])
def test_a_hole(wish: str) -> None:
    assert moves_of(f"{HEAD}{wish}\n{DRILL}{TAIL}") == ["G1 Z-40. F0.12", "G0 Z3."]


def test_steps_in_the_words_of_one_block() -> None:
    one = GROOVE.replace("G75 R0.5\n", "").replace("P2000 Q3000", "I2. K3. D0")
    two = f"{HEAD}(VIB N1.5 PECK OFF)\n{GROOVE}{TAIL}"
    assert moves_of(f"{HEAD}(VIB N1.5 PECK OFF)\n{one}{TAIL}") == moves_of(two)


@pytest.mark.parametrize("wish", ["", "(VIB N1.5)\n"])
@pytest.mark.parametrize("cycle", [GROOVE, DRILL])
def test_without_the_request_they_stay(wish: str, cycle: str) -> None:
    program = f"{HEAD}{wish}{cycle}{TAIL}".encode()
    for options in (['cycles.unroll="always"'], ["vibration.n=1.5"]):
        assert chipbreak.rewrite(program, load("fanuc-lathe", options)).data == program


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("Q3000", "", "CYC004"),
        ("Q3000", "Q0", "CYC004"),
        ("F0.1", "F0.1 R0.5", "CYC007"),
        ("X20.", "X#1", "CYC007"),
        ("X20.", "X42.", "CYC007"),
        ("G0 X42.", "G42 G0 X42.", "CYC007"),
    ],
)
def test_what_cannot_be_written_out_is_an_error(old: str, new: str, code: str) -> None:
    program = f"{HEAD}(VIB N1.5 PECK OFF)\n{GROOVE.replace(old, new, 1)}{TAIL}".encode()
    with pytest.raises(ProgramRejectedError) as caught:
        chipbreak.rewrite(program, load("fanuc-lathe"))
    assert code in {d.code for d in caught.value.diagnostics}


DEEP = "G0 X0. Z3.\nG83 Z-40. Q5000 F0.12\nG80\n"


def test_a_deep_hole_with_the_block_that_ends_it() -> None:
    program = f"{HEAD}(VIB N1.5 PECK OFF)\n{DEEP}{TAIL}"
    assert moves_of(program) == ["G1 Z-40. F0.12", "G0 Z3.", "G80"]
    at_x = program.replace("G83 Z", "G83 X0. Z").replace("G80", "M9\nG80 M5")
    assert moves_of(at_x) == ["G1 Z-40. F0.12", "G0 Z3.", "M9", "G80 M5"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Q5000", "Q5000 R-2."),
        ("Q5000", "Q5000 P500"),
        ("G83 Z", "G83 X5. Z"),
        ("G80\n", ""),
        ("G80\n", "Z-60.\nG80\n"),
        ("G80\n", "G80 G0 Z50.\n"),
        ("G80\n", "IF[#1EQ1]GOTO9\nG80\nN9\n"),
        ("G80\n", "M30\nG80\n"),
        ("G80\n", "/M9\nG80\n"),
    ],
)
def test_a_deep_hole_that_stays_is_an_error(old: str, new: str) -> None:
    program = f"{HEAD}(VIB N1.5 PECK OFF)\n{DEEP.replace(old, new, 1)}{TAIL}".encode()
    with pytest.raises(ProgramRejectedError) as caught:
        chipbreak.rewrite(program, load("fanuc-lathe"))
    assert "CYC007" in {d.code for d in caught.value.diagnostics}
    asked = program.replace(b" PECK OFF", b"")
    assert chipbreak.rewrite(asked, load("fanuc-lathe")).data == asked
