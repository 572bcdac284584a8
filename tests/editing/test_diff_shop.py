"""Pairs of programs as a shop has them: what a careful machinist would call the same, and what not.

Each pair is a program that was typed again, renumbered, posted by another system or changed by hand at the
machine.  A wrong "the same" lets a wrong program to the machine, so where a control could read two programs
differently they differ.
"""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.editing.diff import compare, differs, items_of

INCREMENTS = ('control.decimal_point="increment"',)
CALCULATOR = ('control.decimal_point="calculator"',)


def same(a: str, b: str, profile: str = "", sets: tuple[str, ...] = (), tolerance: float = 0.0) -> bool:
    """Asked in both directions, which must agree."""
    settings = chipbreak.load(profile, sets) if profile else None
    one, other = (items_of(text.encode(), "x", settings) for text in (a, b))
    found = [not differs(compare(*sides, tolerance=tolerance)) for sides in ((one, other), (other, one))]
    assert found[0] == found[1]
    return found[0]


SAME: list[tuple[str, str, tuple[str, ...], str, str]] = [
    ("linuxcnc dwell", "linuxcnc-lathe", (), "G4 P1\n", "G4 P1.0\n"),
    ("signs", "fanuc-lathe", (), "#1=+5.\nG0 X-0.\n", "#1=5\nG0 X0\n"),
    ("needless brackets", "fanuc-lathe", (), "#1=1+[2*3]\n", "#1=1+2*3\n"),
    ("tool with a leading zero", "fanuc-lathe", (), "T0101\n", "T101\n"),
    ("byte order mark", "", (), "\ufeffG0 X1.\n", "G0 X1.\n"),
    ("line ends", "", (), "G0 X1.\r\nM30", "G0X1.\nM30\n"),
    ("tab", "", (), "G0\tX1.\n", "G0 X1.\n"),
    ("program number", "", (), "O0001\nG0 X1.\n", "O1\nG0 X1.\n"),
    ("speed with a point", "fanuc-mill", (), "G84 Z-10. R2. F1.5 S300\n", "G84 Z-10. R2. F1.5 S300.\n"),
    ("increments", "fanuc-mill", INCREMENTS, "G83 Z-10. R2. Q3.\n", "G83 Z-10. R2. Q3000\n"),
    ("arguments, calculator", "fanuc-lathe", CALCULATOR, "G65 P9001 A5. B2.\n", "G65 P9001 A5 B2\n"),
    ("feed a minute, same block", "fanuc-lathe", (), "G98 G1 X1. F200\n", "G98 G1 X1. F200.\n"),
    ("threading takes no contour", "fanuc-lathe", (),
     "N10 G0 X1.\nG76 P010060 Q10\n", "G0 X1.\nG76 P010060 Q10\n"),
    ("spaces of IF", "fanuc-lathe", (), "IF[#1EQ0]THEN#2=1.\n", "IF [#1 EQ 0] THEN #2 = 1\n"),
    ("spaces of a variable", "fanuc-lathe", (), "#[#1+1]=5\n", "#[#1 + 1.]=5.\n"),
    ("leading zeros of GOTO", "fanuc-lathe", (),
     "IF[#1EQ1]GOTO0010\nN10 M30\n", "IF[#1EQ1]GOTO10\nN0010 M30\n"),
    ("start of a subprogram", "fanuc-lathe", (),
     "M98 P8 Q20\nM30\nO8\nN10 G0 X1.\nN20 G0 X2.\nM99\n", "M98 P8 Q4\nM30\nO8\nN2 G0 X1.\nN4 G0 X2.\nM99\n"),
]  # fmt: skip

DIFFERENT: list[tuple[str, str, tuple[str, ...], str, str]] = [
    ("5 is no #5", "fanuc-lathe", (), "#1=#5\n", "#1=5\n"),
    ("5 is no #5, in a sum", "fanuc-lathe", (), "G0 X[#1+#5]\n", "G0 X[#1+5]\n"),
    ("#0 is empty, not 0", "fanuc-lathe", (), "#1=#0\n", "#1=0\n"),
    ("lost point", "", (), "G0 X50.\n", "G0 X50\n"),
    ("lost point of a chamfer", "fanuc-lathe", (), "G1 X10. ,C1.\n", "G1 X10. ,C1\n"),
    ("lost point of a corner, no profile", "", (), "G1 X10. ,R1.\n", "G1 X10. ,R1\n"),
    ("lost comma", "fanuc-lathe", (), "G1 X10. ,C1.\n", "G1 X10. C1.\n"),
    ("lost point of a feed", "fanuc-lathe", (), "G99 G1 X1. F.2\n", "G99 G1 X1. F2\n"),
    ("lost point of a peck", "fanuc-mill", (), "G83 Z-10. R2. Q3.\n", "G83 Z-10. R2. Q3\n"),
    ("lost point of an argument", "", (), "G65 P9001 A5.\n", "G65 P9001 A5\n"),
    ("milliseconds and seconds", "haas-lathe", (), "G04 P1.\n", "G04 P1\n"),
    ("milliseconds and seconds, no profile", "", (), "G04 P500\n", "G04 P500.\n"),
    ("seconds", "fanuc-lathe", (), "G04 X2.\n", "G04 X2\n"),
    ("inch in the same block", "fanuc-lathe", INCREMENTS, "G20 G0 X10000\n", "G20 G0 X10.\n"),
    ("inch and mm", "fanuc-lathe", INCREMENTS, "G20\nG1 X10000\n", "G21\nG1 X10000\n"),
    ("computed jump", "fanuc-lathe", (),
     "#1=20\nGOTO#1\nN20 G0 X1.\nN30 G0 X2.\n", "#1=20\nGOTO#1\nN30 G0 X1.\nN20 G0 X2.\n"),
    ("computed jump, condition", "", (),
     "IF[#1GT2]GOTO[#1*10]\nN30 G0 X1.\n", "IF[#1GT2]GOTO[#1*10]\nN40 G0 X1.\n"),
    ("computed jump to a number alone", "", (), "GOTO#1\nN30\nG0 X1.\n", "GOTO#1\nN40\nG0 X1.\n"),
    ("computed return", "fanuc-lathe", (),
     "N10 G0 X1.\nM98 P8\nM30\nO8\nM99 P#4\n", "N20 G0 X1.\nM98 P8\nM30\nO8\nM99 P#4\n"),
    ("computed contour", "fanuc-lathe", (),
     "G71 P#1 Q#2 U.4\nN10 G0 X1.\nN20 X2.\n", "G71 P#1 Q#2 U.4\nN11 G0 X1.\nN20 X2.\n"),
    ("start of a subprogram that moved", "fanuc-lathe", (),
     "M98 P8 Q20\nM30\nO8\nN10 G0 X1.\nN20 G0 X2.\nM99\n",
     "M98 P8 Q20\nM30\nO8\nN20 G0 X1.\nN30 G0 X2.\nM99\n"),
    ("start by H", "mitsubishi-lathe", (),
     "M98 P8 H20\nM30\nO8\nN10 G0 X1.\nN20 G0 X2.\nM99\n",
     "M98 P8 H20\nM30\nO8\nN20 G0 X1.\nN30 G0 X2.\nM99\n"),
    ("end of a contour that moved", "fanuc-lathe", (),
     "G71 P10 Q20 U.4\nN10 G0 X1.\nN20 G1 X2.\nX3.\n", "G71 P10 Q20 U.4\nN10 G0 X1.\nG1 X2.\nN20 X3.\n"),
    ("local subprogram that moved", "haas-lathe", (),
     "M97 P100 L3\nM30\nN100 G0 X1.\nX2.\nM99\n", "M97 P100 L3\nM30\nG0 X1.\nN100 X2.\nM99\n"),
    ("a target that is gone", "fanuc-lathe", (), "GOTO20\nN20 M30\n", "GOTO20\nM30\n"),
    ("brackets that count", "fanuc-lathe", (), "#1=[1+2]*3\n", "#1=1+2*3\n"),
    ("comparison", "fanuc-lathe", (), "WHILE[#1LE3]DO1\nEND1\n", "WHILE[#1LT3]DO1\nEND1\n"),
    ("function", "fanuc-lathe", (), "#1=ROUND[#2]\n", "#1=FIX[#2]\n"),
    ("offset", "fanuc-lathe", (), "T0101\n", "T0100\n"),
    ("vibrations per revolution", "fanuc-lathe", (), "G1 Z-3. F0.05 N1.5\n", "G1 Z-3. F0.05 N2.5\n"),
    ("a wish that is gone", "fanuc-lathe", (), "G1 Z-3. F0.05 N1.5\n", "G1 Z-3. F0.05\n"),
    ("a whole wish that is gone", "fanuc-lathe", (), "N10 G1 Z-3. F0.05 N2\n", "N10 G1 Z-3. F0.05\n"),
    ("sign", "", (), "G1 Z-5.\n", "G1 Z5.\n"),
    ("thread depth", "fanuc-lathe", (), "G76 X18. Z-20. P1200 Q400 F2.\n", "G76 X18. Z-20. P1100 Q400 F2.\n"),
    ("block skip", "", (), "/M1\n", "M1\n"),
    ("order", "", (), "M8\nG0 X1.\n", "G0 X1.\nM8\n"),
    ("one of three", "", (), "G0 X1.\nG0 X1.\nG0 X1.\n", "G0 X1.\nG0 X1.\n"),
    ("another drill", "", (), "T1 M6 (DRILL 8.5)\n", "T1 M6 (DRILL 8.6)\n"),
]  # fmt: skip


@pytest.mark.parametrize(("profile", "sets", "a", "b"), [p[1:] for p in SAME], ids=[p[0] for p in SAME])
def test_the_same(profile: str, sets: tuple[str, ...], a: str, b: str) -> None:
    assert same(a, b, profile, sets)


@pytest.mark.parametrize(
    ("profile", "sets", "a", "b"), [p[1:] for p in DIFFERENT], ids=[p[0] for p in DIFFERENT]
)
def test_different(profile: str, sets: tuple[str, ...], a: str, b: str) -> None:
    assert not same(a, b, profile, sets)


@pytest.mark.parametrize(
    ("a", "b", "is_same"),
    [
        ("G1 X1.005 Z-2. ,C.5\n", "G1 X1. Z-2.004 ,C.505\n", True),
        ("G1 X1. F0.1\n", "G1 X1. F0.105\n", False),
        ("G4 X1.\n", "G4 X1.005\n", False),
        ("G43 H1.\n", "G43 H1.005\n", False),
        ("#1=1.\n", "#1=1.005\n", False),
        ("G0 X[#1+1.]\n", "G0 X[#1+1.005]\n", False),
        ("G0 X5.\n", "G0 X5\n", False),
    ],
)
def test_a_tolerance_is_one_of_lengths(a: str, b: str, is_same: bool) -> None:
    assert same(a, b, tolerance=0.006) is is_same


@pytest.mark.parametrize(
    ("a", "b", "is_same"),
    [
        ("(FIRST SIDE)\nG0 X1.\n", "(SECOND SIDE)\nG0 X1.\n", True),
        ("(VIB N1.5)\nG1 Z-1.\n", "(VIB N2.5)\nG1 Z-1.\n", False),
        ("(OP ROUGH)\nT1 M6\n", "T1 M6\n", False),
        ("(OPERATION 1)\nT1 M6\n", "T1 M6\n", True),
        ("(PROBEOPEN a.txt)\n", "(PROBEOPEN b.txt)\n", False),
    ],
)
def test_comments_that_do_something_are_never_ignored(a: str, b: str, is_same: bool) -> None:
    one, other = (items_of(text.encode(), "x", ignore_comments=True) for text in (a, b))
    assert differs(compare(one, other)) is not is_same
