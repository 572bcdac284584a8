"""What is said of a cycle that stays: the line, the code, every word of it, and the way out."""

from __future__ import annotations

import pytest

from .planned import HEAD, TAIL, noted, refused

LENGTHS = "G71 U2. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.3\n"
SHAPE = "N10 G0 X16. F0.1\nG1 Z-15.\nX30. Z-30.\nN20 X52.\n"
ACROSS = "N10 G0 Z-20.\nG1 X40. F0.1\nX30. Z-10.\nN20 Z2.\n"
PROGRAMS = {
    "G71": HEAD + LENGTHS + SHAPE + TAIL,
    "G71 in one block": f"{HEAD}G71 P10 Q20 U0.4 W0.1 D2. F0.3\n{SHAPE}{TAIL}",
    "G71 and G70": f"{HEAD}{LENGTHS}{SHAPE}G70 P10 Q20\n{TAIL}",
    "G70": f"{HEAD}G70 P10 Q20\n{SHAPE}{TAIL}",
    "G72": f"{HEAD}G72 W2. R0.5\nG72 P10 Q20 U0.4 W0.1 F0.3\n{ACROSS}{TAIL}",
    "G72 in one block": f"{HEAD}G72 P10 Q20 U0.4 W0.1 D2. F0.3\n{ACROSS}{TAIL}",
    "G73": f"{HEAD}G73 U4. W1. R3\nG73 P10 Q20 U0.4 W0.1 F0.3\n{SHAPE}{TAIL}",
    "G73 in one block": f"{HEAD}G73 P10 Q20 U0.4 W0.1 I4. K1. D3 F0.3\n{SHAPE}{TAIL}",
    "G90": f"{HEAD}G90 X48. Z-20. F0.2\nN5 X46.\n{TAIL}",
    "G75": f"{HEAD}G0 X42. Z-10.\nG75 R0.5\nG75 X20. Z-18. P2000 Q3000 F0.1\n{TAIL}",
    "G74": f"{HEAD}G0 X42. Z3.\nG74 R1.\nG74 X20. Z-40. P2000 Q5000 F0.12\n{TAIL}",
    "G83": f"{HEAD}G0 X0. Z3.\nG83 Z-40. Q5000 F0.12\nG80\n{TAIL}",
    "linuxcnc": (
        "G8 G18 G21 G90 G94 G40\nF200 S800 M3\no100 sub\n"
        "G0 X8\nG1 Z-15\nG1 X12\nG1 X15 Z-22\nG1 Z-30\nG1 X26\n"
        "o100 endsub\nG0 X28 Z2\nG71 Q100 I2 R0.5\nG0 X40 Z10\nM2\n"
    ),
}
POINTS = ("control.decimal_point=required",)
COMPENSATED = ("cycles.nose_in_roughing=compensated",)

TAKE_IT_OUT = "take it out"
END_IT = "end it before the cycle"
ALONE = "write the cycle alone in its block, with plain numbers"
THE_POINT = 'write the point, or set control.decimal_point to "calculator" or "increment"'
PLAIN = "a contour has G0, G1, G2 and G3 with plain numbers"
FOREIGN = f"{PLAIN} (a Fanuc stops here with alarm PS0325)"
NUMBER_IT = (
    "number the first and the last block of the shape as P and Q say (a Fanuc stops here with alarm PS0063)"
)
OUTSIDE = "start the cycle outside the stock, before the contour"
UNDERCUT = "take the undercut out of the contour, or cut it by itself"
MOVE_THERE = "move to its start with G0 X Z in plain absolute numbers before it"
ABOVE_ZERO = "give the depth of a pass as a number above zero (a Fanuc stops here with alarm PS0062)"
NUMBERED = "write a whole number up to 500"
SHAPED = "write the contour with G1, G2 and G3 to plain points"
ONE_AXIS = "name one axis beside the angle"
PASSES = "write its passes with X, Z, U, W, R and F as plain numbers"
AS_G1 = "write its cuts as G1, or take PECK OFF out"
OVER_IT = "move over the hole before it, or take PECK OFF out"
WIDE = "give the step as a number above zero, for 500 cuts at most"
BY_ITSELF = "the cycle does not stand alone in its block, with plain numbers"
READ_OTHERWISE = "cannot be read, has block delete or is worked out on the control"
CANNOT_BE_DELETED = "a cycle with block delete, a variable or another G code in its block is not written out"

# The program, what of it is written otherwise, options; the line, the code, what is said, and the way out.
Case = tuple[str, tuple[str, ...], tuple[str, ...], int, str, str, str]
CALLS: list[Case] = [
    ("G71", ("T0101", "T0101\nG66 P9000"), (), 7, "CYC007", "modal macro is in force at this cycle", END_IT),
    (
        "G71",
        ("G21", "G17 G21"),
        (),
        6,
        "CYC007",
        "another plane, G91 or G90.1 is in force at this cycle",
        END_IT,
    ),
    (
        "G71",
        ("Q20", "Q21"),
        (),
        6,
        "CYC001",
        "this cycle looks for N21 (Q21), and no block behind the first one of its shape has that number",
        NUMBER_IT,
    ),
    (
        "G71",
        ("P10", "P11"),
        (),
        6,
        "CYC001",
        "this cycle looks for N11 (P11), and no block has that number",
        NUMBER_IT,
    ),
    ("G71", ("F0.3", "F0.3 B5."), (), 6, "CYC007", "B5. has no known meaning in this cycle", TAKE_IT_OUT),
    ("G71", ("R0.5", "R0.5 F0.2"), (), 6, "CYC007", "F0.2 has no known meaning in this cycle", TAKE_IT_OUT),
    ("G71", ("F0.3", "F0.2 F0.3"), (), 6, "CYC007", "F0.2 has no known meaning in this cycle", TAKE_IT_OUT),
    ("G72", ("R0.5", "U2. R0.5"), (), 6, "CYC007", "U2. has no known meaning in this cycle", TAKE_IT_OUT),
    ("G73", ("F0.3", "R2. F0.3"), (), 6, "CYC007", "R2. has no known meaning in this cycle", TAKE_IT_OUT),
    ("G70", ("Q20", "Q20 U1."), (), 5, "CYC007", "U1. has no known meaning in this cycle", TAKE_IT_OUT),
    ("G71", ("G71 P", "/G71 P"), (), 6, "CYC007", CANNOT_BE_DELETED, ALONE),
    ("G71", ("U0.4", "U#1"), (), 6, "CYC007", CANNOT_BE_DELETED, ALONE),
    ("G71", ("F0.3", "F0.3 G99"), (), 6, "CYC007", CANNOT_BE_DELETED, ALONE),
    ("G71", ("G71 U", "/G71 U"), (), 6, "CYC007", CANNOT_BE_DELETED, ALONE),
    *(
        (
            "G71",
            ("F0.3", f"{word} F0.3"),
            (),
            6,
            "CYC007",
            "I, K or R stands in a cycle that says no D",
            "say the whole cycle in one block, with D",
        )
        for word in ("I1.", "K1.", "R1")
    ),
    (
        "G71",
        ("G71 U2. R0.5\n", ""),
        (),
        5,
        "CYC004",
        "nothing says the depth of this cycle",
        "write the block with the depth straight before it: G71 U2. R0.5",
    ),
    (
        "G71",
        ("G71 U2. R0.5\n", "G71 U2. R0.5\nS900\n"),
        (),
        7,
        "CYC004",
        "nothing says the depth of this cycle",
        "write the block with the depth straight before it: G71 U2. R0.5",
    ),
    (
        "G72",
        ("G72 W2. R0.5\n", ""),
        (),
        5,
        "CYC004",
        "nothing says the depth of this cycle",
        "write the block with the depth straight before it: G72 W2. R0.5",
    ),
    (
        "G73",
        ("G73 U4. W1. R3\n", ""),
        (),
        5,
        "CYC004",
        "nothing says the passes of this cycle",
        "write the block with the passes straight before it: G73 U4. W1. R3",
    ),
    (
        "G71 in one block",
        ("F0.3", "R2 F0.3"),
        (),
        5,
        "CYC007",
        "R of a cycle in one block is the type of its contour: R1 with pockets",
        "take R out, or write the cycle in two blocks",
    ),
    *(
        (
            "G73",
            ("R3", said),
            (),
            6,
            "CYC007",
            "R of this cycle is not the number of its passes",
            f"{NUMBERED}: R3",
        )
        for said in ("R2.5", "", "R501")
    ),
    (
        "G73 in one block",
        ("D3", "D501"),
        (),
        5,
        "CYC007",
        "D of this cycle is not the number of its passes",
        f"{NUMBERED}: D3",
    ),
    (
        "G73",
        ("R3", "R0"),
        (),
        6,
        "CYC004",
        "0 passes of a pattern cannot be",
        "give R as a number above zero (a Fanuc stops here with alarm PS0321)",
    ),
    (
        "G73 in one block",
        ("D3", "D-1"),
        (),
        5,
        "CYC004",
        "-1 passes of a pattern cannot be",
        "give D as a number above zero (a Fanuc stops here with alarm PS0321)",
    ),
    ("G71", ("U2.", "U0."), (), 6, "CYC004", "a depth of 0 mm cannot be", ABOVE_ZERO),
    ("G71", ("U2.", "U-1.5"), (), 6, "CYC004", "a depth of -1.5 mm cannot be", ABOVE_ZERO),
    ("G71 in one block", ("D2.", "D0"), (), 5, "CYC004", "a depth of 0 mm cannot be", ABOVE_ZERO),
    ("G71", ("R0.5", "R-0.1"), (), 6, "CYC004", "a retract of -0.1 mm cannot be", "give R as zero or more"),
    ("G71", ("U2.", "U2"), POINTS, 6, "CYC007", "U2 of this cycle has no decimal point", THE_POINT),
    ("G73", ("U4.", "U4"), POINTS, 6, "CYC007", "U4 of this cycle has no decimal point", THE_POINT),
    (
        "G73 in one block",
        ("K1.", "K1"),
        POINTS,
        5,
        "CYC007",
        "K1 of this cycle has no decimal point",
        THE_POINT,
    ),
]
CONTOURS: list[Case] = [
    (
        "G71",
        ("X30. Z-30.", ",A90.\nX30. ,A135."),
        (),
        6,
        "CYC002",
        "the contour block ,A90. has an angle, and the next block does not say X, Z and an angle",
        ONE_AXIS,
    ),
    *(
        ("G71", ("X30.", said), (), 6, "CYC002", f"the contour block {said} Z-30. {READ_OTHERWISE}", PLAIN)
        for said in ("?X30.", "/X30.", "X#1")
    ),
    (
        "G71",
        ("X30.", "G53 X30."),
        (),
        6,
        "CYC002",
        "the contour block G53 X30. Z-30. has a G code that does not belong into a contour",
        FOREIGN,
    ),
    (
        "G71",
        ("X30.", "G20 X30."),
        (),
        6,
        "CYC002",
        "the contour block G20 X30. Z-30. has a G code that does not belong into a contour",
        FOREIGN,
    ),
    (
        "G71",
        ("X30.", "G28 U0\nX30."),
        (),
        6,
        "CYC002",
        "the contour block G28 U0 has a G code that does not belong into a contour",
        FOREIGN,
    ),
    (
        "G71",
        ("Z-30.", "Z-30. N1.5"),
        (),
        6,
        "CYC002",
        "the contour block X30. Z-30. N1.5 has a word that is not read here",
        PLAIN,
    ),
    (
        "G71",
        ("X30.", "G94 X30."),
        (),
        6,
        "CYC002",
        "the contour block G94 X30. Z-30. is no line and no arc",
        PLAIN,
    ),
    (
        "G71",
        ("X30.", "G32 X30."),
        (),
        6,
        "CYC002",
        "the contour block G32 X30. Z-30. is no line and no arc",
        PLAIN,
    ),
    (
        "G70",
        ("X30.", "T0202 X30."),
        (),
        5,
        "CYC002",
        "the contour block T0202 X30. Z-30. changes the tool, stops or leaves the program",
        PLAIN,
    ),
    *(
        (
            "G71",
            ("X30.", f"{said} X30."),
            (),
            6,
            "CYC002",
            f"the contour block {said} X30. Z-30. changes the tool, stops or leaves the program",
            PLAIN,
        )
        for said in ("M0", "M1", "M30")
    ),
    (
        "G71",
        ("X30. Z-30.", "M98 P9"),
        (),
        6,
        "CYC002",
        "the contour block M98 P9 changes the tool, stops or leaves the program",
        PLAIN,
    ),
    (
        "G71",
        ("X30. Z-30.", "G53 X30. Z-30. (A COMMENT THAT IS QUITELONG)"),
        (),
        6,
        "CYC002",
        "the contour block G53 X30. Z-30. (A COMMENT THAT IS QUITEL has a G code"
        " that does not belong into a contour",
        FOREIGN,
    ),
    (
        "G71",
        (SHAPE, "N10 G0 X16. F0.1\nM8\nN20 M9\n"),
        (),
        6,
        "CYC002",
        "the contour of this cycle has fewer than two moves",
        "give it its shape",
    ),
    *(
        (
            "G71",
            ("G0 X16.", said),
            (),
            6,
            "CYC002",
            "the first block of the contour is an arc, or says a corner",
            "begin the contour with G0 or G1 (a Fanuc stops here with alarm PS0065)",
        )
        for said in ("G2 X16. Z0. R20.", "G1 X16. ,C1.")
    ),
    ("G71", ("Z-15.", "Z-15"), POINTS, 6, "CYC002", "Z-15 in the contour has no decimal point", THE_POINT),
    (
        "G70",
        ("Z-15.", "Z-15"),
        POINTS,
        5,
        "CYC002",
        "a point of the contour cannot be known",
        "write it with plain numbers",
    ),
    *(
        (
            "G71",
            (SHAPE, shape),
            (),
            6,
            "CYC006",
            "the contour begins at the height of the start point, or has no extent along the passes",
            OUTSIDE,
        )
        for shape in (
            "N10 G0 X16. F0.1\nN20 G1 X52.\n",
            "N10 G0 X52. F0.1\nN20 G1 Z-30.\n",
            "N10 G0 X16.\nN20 G1 X16.\n",
        )
    ),
    (
        "G71",
        ("N10 G0 X16.", "N10 G0 X16. Z3."),
        (),
        6,
        "CYC006",
        "the contour begins before the start point of the cycle, seen along the passes",
        "start the cycle before the contour",
    ),
    (
        "G71",
        ("X30. Z-30.", "X30. Z-10."),
        (),
        6,
        "CYC003",
        "the contour turns back along the passes: an undercut",
        f"{UNDERCUT} (a Fanuc stops here with alarm PS0064)",
    ),
    (
        "G72",
        ("X30. Z-10.", "X44. Z-10."),
        (),
        6,
        "CYC003",
        "the contour turns back along the passes: an undercut",
        f"{UNDERCUT} (a Fanuc stops here with alarm PS0329)",
    ),
    (
        "G71",
        ("X30. Z-30.", "X30.\nX26. Z-30."),
        (),
        6,
        "CYC003",
        "the contour goes down again, which a cycle whose first contour block moves one axis does not cut",
        "name X and Z in the first block of the contour, where the control has pockets (type II)"
        " (a Fanuc stops here with alarm PS0329)",
    ),
    (
        "G71",
        (LENGTHS + SHAPE, SHAPE + LENGTHS),
        (),
        10,
        "CYC002",
        "the contour in line 5 stands before its cycle, and the control cuts along it there",
        "write the contour behind the cycle",
    ),
    (
        "G71",
        ("X30. Z-30.", "X30. Z-30. ,R1. C2."),
        (),
        6,
        "CYC002",
        "the contour block X30. Z-30. ,R1. C2. says two corners",
        "a block has one of C and R",
    ),
    (
        "G71",
        ("X30. Z-30.", "X30. Z-30. ,C2"),
        POINTS,
        6,
        "CYC002",
        "the contour block X30. Z-30. ,C2 has a corner of unknown size",
        THE_POINT,
    ),
    (
        "G71",
        ("X30. Z-30.", "X30. Z-30. ,A45."),
        (),
        6,
        "CYC002",
        "the contour block X30. Z-30. ,A45. has an angle beside both axes or none",
        ONE_AXIS,
    ),
    (
        "G71",
        ("X30. Z-30.", "Z-30. ,A135. A135."),
        (),
        6,
        "CYC002",
        "the contour block Z-30. ,A135. A135. has an angle beside both axes or none",
        ONE_AXIS,
    ),
    (
        "G71",
        ("N20 X52.", "X52.\nN20 ,A90."),
        (),
        6,
        "CYC002",
        "the contour block N20 ,A90. has an angle beside no axis",
        ONE_AXIS,
    ),
    (
        "G71",
        ("X30. Z-30.", "X30. ,A180."),
        (),
        6,
        "CYC002",
        "the contour block X30. ,A180. has an angle that never gets there",
        "write X and Z of its end",
    ),
    (
        "G71",
        ("X30. Z-30.", "Z-30. ,A90."),
        (),
        6,
        "CYC002",
        "the contour block Z-30. ,A90. has an angle that never gets there",
        "write X and Z of its end",
    ),
    (
        "G71",
        ("X30. Z-30.", "Z-30. ,A135"),
        POINTS,
        6,
        "CYC002",
        "the contour block Z-30. ,A135 says ,A135 without a decimal point",
        THE_POINT,
    ),
    (
        "G71",
        ("X30. Z-30.", ",A90.\nX30."),
        (),
        6,
        "CYC002",
        "the contour block ,A90. has an angle, and the next block does not say X, Z and an angle",
        ONE_AXIS,
    ),
    (
        "G71",
        ("X30. Z-30.", ",A135.\nX30. Z-30. ,A135."),
        (),
        6,
        "CYC002",
        "the contour block X30. Z-30. ,A135. does not meet the line before it",
        "write X and Z of its start",
    ),
    (
        "G71",
        ("N20 X52.", "N20 X52. ,C1."),
        (),
        6,
        "CYC002",
        "the last block of the contour says a corner, and no move follows it",
        f"{SHAPED} (a Fanuc stops here with alarm PS0069)",
    ),
    (
        "G71",
        ("X30. Z-30.", "X30. ,C1.\nG3 X40. Z-20. R5.\nG1 Z-30."),
        (),
        6,
        "CYC002",
        "a corner stands beside an arc",
        SHAPED,
    ),
    (
        "G71",
        ("G1 Z-15.", "G1 Z-15. ,R100."),
        (),
        6,
        "CYC002",
        "a corner of 100 mm is larger than the moves beside it",
        SHAPED,
    ),
    (
        "G71",
        ("G1 Z-15.", "G1 Z2. ,C1."),
        (),
        6,
        "CYC002",
        "a corner stands beside a move without length",
        SHAPED,
    ),
]
LIMITS: list[Case] = [
    *(
        (
            name,
            change,
            (),
            line,
            "CYC005",
            f"the allowance {letter} of this cycle lies inside the finished part",
            f"give {letter} the sign that points to the stock",
        )
        for name, change, line, letter in (
            ("G71", ("U0.4", "U-0.4"), 6, "U"),
            ("G71", ("W0.1", "W-0.1"), 6, "W"),
            ("G71 in one block", ("F0.3", "I-0.4 F0.3"), 5, "I"),
            ("G71 in one block", ("F0.3", "K-0.4 F0.3"), 5, "K"),
            ("G72", ("U0.4", "U-0.4"), 6, "U"),
            ("G72", ("W0.1", "W-0.1"), 6, "W"),
            ("G72 in one block", ("F0.3", "I-0.4 F0.3"), 5, "I"),
            ("G72 in one block", ("F0.3", "K-0.4 F0.3"), 5, "K"),
        )
    ),
    (
        "G71 in one block",
        ("F0.3", "I1.2 K0.9 F0.3"),
        (),
        5,
        "CYC004",
        "I and K of this cycle leave more than the depth of a pass",
        "give less than D for the pass before the last one",
    ),
    (
        "G71",
        ("U2.", "U0.035"),
        (),
        6,
        "CYC004",
        "passes of 0.035 mm would be 514 in this cycle",
        "check the unit of D (cycles.depth_unit), or give a greater depth",
    ),
    *(
        (
            "G71",
            ("G0 X52. Z2.", start),
            (),
            6,
            "CYC007",
            "where this cycle starts is not known: a tool or its offset changed",
            MOVE_THERE,
        )
        for start in ("G0 X52.", "G0 Z2.")
    ),
    (
        "G71",
        ("G0 X52. Z2.", "G0 X52. Z2"),
        POINTS,
        6,
        "CYC007",
        "where this cycle starts is not known: Z2 in line 4 has no decimal point",
        THE_POINT,
    ),
    *(
        (
            "G71",
            change,
            COMPENSATED,
            6,
            "CYC007",
            "this control compensates the nose in this cycle (cycles.nose_in_roughing)",
            "rough under G40, and take G41 and G42 out of the contour",
        )
        for change in (("G0 X16.", "G42 G0 X16."), ("G0 X52.", "G41 G0 X52."))
    ),
    *(
        (
            "G71",
            ("G0 X100.", f"{jump}\nG0 X100."),
            (),
            6,
            "CYC007",
            "a jump leads into this cycle or its contour",
            "take the jump out",
        )
        for jump in ("IF[#1EQ1]GOTO10", "M97 P10", "M97 P20", "G70 P10 Q#1")
    ),
    *(
        (
            "G71",
            ("G1 Z-15.", f"({comment})\nG1 Z-15."),
            (),
            6,
            "CYC007",
            "a directive stands inside this cycle or its contour",
            "write it before the first block of the cycle",
        )
        for comment in ("VIB OFF", "vib n1.5", " OP ROUGH")
    ),
    (
        "G71 and G70",
        ("N20 X52.", "N20 X52. M8"),
        (),
        11,
        "CYC007",
        "the contour leaves another coolant in force behind this cycle",
        "end in the contour what it begins",
    ),
    (
        "G71 and G70",
        ("N20 X52.", "N20 X52. M4 M8"),
        (),
        11,
        "CYC007",
        "the contour leaves another coolant, spindle in force behind this cycle",
        "end in the contour what it begins",
    ),
    (
        "G71 and G70",
        ("N20 X52.", "N20 G42 X52."),
        (),
        11,
        "CYC007",
        "the contour leaves another compensation in force behind this cycle",
        "end in the contour what it begins: G40 in its last block",
    ),
    (
        "G71 and G70",
        ("G0 X100.", "G1 X50. Z1. (THE NEXT CUT, WITH A COMMENT)\nG0 X100."),
        (),
        11,
        "CYC007",
        "G1 X50. Z1. (THE NEXT CUT, WITH A COMMEN behind this cycle says no F,"
        " and which is in force there is not known",
        "give F on that block, or before it",
    ),
    ("G71 and G70", ("F0.1", "F0.1 S900"), (), 0, "", "", ""),
    (
        "G73",
        ("N20 X52.", "X60.\nZ-40.\nN20 X26."),
        (),
        6,
        "CYC006",
        "a rapid of this cycle would cross its contour",
        OUTSIDE,
    ),
]
SINGLE: list[Case] = [
    *(
        (
            "G90",
            ("X48. Z-20.", said),
            (),
            5,
            "CYC007",
            "X, Z or R of this cycle is missing, or worked out on the control",
            "give X and Z of the pass as plain numbers",
        )
        for said in ("X48.", "Z-20.")
    ),
    (
        "G90",
        ("F0.2", "F0.2 M8"),
        (),
        5,
        "CYC007",
        "G90 X48. Z-20. F0.2 M8 is no plain pass of this cycle",
        PASSES,
    ),
    ("G90", ("N5 X46.", "X#1"), (), 5, "CYC007", "X#1 is no plain pass of this cycle", PASSES),
    ("G90", ("N5 X46.", "/X46."), (), 5, "CYC007", "/X46. is no plain pass of this cycle", PASSES),
    ("G90", ("N5 X46.", "X46. N1.5"), (), 5, "CYC007", "X46. N1.5 is no plain pass of this cycle", PASSES),
    (
        "G90",
        ("N5 X46.", "S900 F0.3\nX46."),
        (),
        5,
        "CYC007",
        "S900 F0.3 is no plain pass of this cycle",
        PASSES,
    ),
    (
        "G90",
        ("G0 X100.", "IF[#1EQ1]GOTO5\nG0 X100."),
        (),
        5,
        "CYC007",
        "N5 X46. is no plain pass of this cycle",
        PASSES,
    ),
    (
        "G90",
        ("F0.2", "F0.2 M8 (A COMMENT THAT IS QUITELONG)"),
        (),
        5,
        "CYC007",
        "G90 X48. Z-20. F0.2 M8 (A COMMENT THAT I is no plain pass of this cycle",
        PASSES,
    ),
    (
        "G90",
        ("Z-20.", "Z2."),
        (),
        5,
        "CYC007",
        "a pass of this cycle has a cut without length",
        "start the cycle away from where the pass ends",
    ),
    (
        "G90",
        ("G90", "G42\nG90"),
        (),
        6,
        "CYC007",
        "nose compensation is in force at this cycle",
        "write G40 and a move to its start before the cycle",
    ),
    (
        "G90",
        ("G90", "G0 X#1\nG90"),
        (),
        6,
        "CYC007",
        "where this cycle starts is not known: the control works out where line 5 goes",
        MOVE_THERE,
    ),
    (
        "G90",
        ("G21", "G17 G21"),
        (),
        5,
        "CYC007",
        "another plane, G91 or G90.1 is in force at this cycle",
        END_IT,
    ),
    ("G90", ("X48.", "X48"), POINTS, 5, "CYC007", "X48 of this cycle has no decimal point", THE_POINT),
    ("G90", ("F0.2", "R1 F0.2"), POINTS, 5, "CYC007", "R1 of this cycle has no decimal point", THE_POINT),
]
PECKS: list[Case] = [
    *(
        ("G75", ("Q3000", said), (), 7, "CYC004", "Q of this cycle is no step from one cut to the next", WIDE)
        for said in ("", "Q0", "Q15", "Q3000 K3.", "K-1.")
    ),
    ("G74", ("P2000", ""), (), 7, "CYC004", "P of this cycle is no step from one cut to the next", WIDE),
    *(
        (
            "G75",
            ("F0.1", f"F0.1 {said}"),
            (),
            7,
            "CYC007",
            "the cycle moves aside at the bottom of its cuts",
            AS_G1,
        )
        for said in ("R0.5", "D0.5")
    ),
    *(
        ("G75", change, (), 7, "CYC007", BY_ITSELF, AS_G1)
        for change in (("X20.", "X#1"), ("G75 X", "/G75 X"), ("F0.1", "F0.1 S5"), ("G75 X", "G99 G75 X"))
    ),
    ("G75", ("X20.", "X42."), (), 7, "CYC007", "this cycle has no depth", "give the end of its cuts"),
    (
        "G75",
        ("G0 X42.", "G0 X#1"),
        (),
        7,
        "CYC007",
        "where this cycle starts is not known: the control works out where line 5 goes",
        AS_G1,
    ),
    (
        "G75",
        ("G0 X42.", "G42 G0 X42."),
        (),
        7,
        "CYC007",
        "nose compensation, an arc or a cycle is in force at this cycle",
        AS_G1,
    ),
    (
        "G75",
        ("Z-10.\n", "Z-9.\nG2 X42. Z-10. R5.\n"),
        (),
        8,
        "CYC007",
        "nose compensation, an arc or a cycle is in force at this cycle",
        AS_G1,
    ),
    (
        "G75",
        ("X20.", "X20"),
        POINTS,
        7,
        "CYC007",
        "where this cycle ends is not known",
        "write its points with decimals",
    ),
    (
        "G75",
        ("G21", "G17 G21"),
        (),
        7,
        "CYC007",
        "another plane, G91 or G90.1 is in force at this cycle",
        END_IT,
    ),
    *(
        ("G83", change, (), 6, "CYC007", f"{BY_ITSELF} and without P and R", OVER_IT)
        for change in (
            ("Q5000", "Q5000 P500"),
            ("Q5000", "Q5000 R1."),
            ("G83", "/G83"),
            ("Z-40.", "Z#1"),
            ("G83", "G99 G83"),
        )
    ),
    (
        "G83",
        ("Z3.", "Z#1"),
        (),
        6,
        "CYC007",
        "where this cycle starts or ends is not known: the control works out where line 5 goes",
        OVER_IT,
    ),
    *(
        ("G83", change, (), 6, "CYC007", "the tool does not wait over its hole", OVER_IT)
        for change in (("G83 Z", "G83 X5. Z"), ("Z-40.", "Z3."))
    ),
    (
        "G83",
        ("G0 X0.", "G42 G0 X0."),
        (),
        6,
        "CYC007",
        "nose compensation, an arc or a cycle is in force at this cycle",
        OVER_IT,
    ),
    *(
        (
            "G83",
            ("G80\n", said),
            (),
            6,
            "CYC007",
            "a G80 without a move does not stand behind the one hole of this cycle",
            "end it with a block G80 after one hole, or take PECK OFF out",
        )
        for said in ("", "Z-60.\nG80\n", "/G80\n", "M30\nG80\n", "G80 G0 Z50.\n", "?\nG80\n")
    ),
    (
        "G83",
        ("G21", "G17 G21"),
        (),
        6,
        "CYC007",
        "another plane, G91 or G90.1 is in force at this cycle",
        END_IT,
    ),
]
LX = "linuxcnc"
CYCLE = "G71 Q100 I2 R0.5"
MODES = "another plane, G91 or G90.1 is in force at this cycle"
SUB = "write o100 sub ... o100 endsub before the cycle that says Q100"
SUBROUTINES: list[Case] = [
    (LX, (CYCLE, f"G91\n{CYCLE}\nG90"), (), 13, "CYC007", MODES, END_IT),
    (LX, ("G0 X28", "G90.1 G0 X28"), (), 12, "CYC007", MODES, END_IT),
    (LX, (CYCLE, f"G17\n{CYCLE}"), (), 13, "CYC007", MODES, END_IT),
    *(
        (LX, (CYCLE, said), (), 12, "CYC007", BY_ITSELF, "write it so, with the numbers themselves")
        for said in ("G71 Q100 I2 B5", "G71 Q100 I#1", "/G71 Q100 I2", "G71 G95 Q100 I2")
    ),
    (
        LX,
        ("G0 X28 Z2", "G42.1 D1 G0 X28 Z2"),
        (),
        12,
        "CYC007",
        "nose compensation is in force at this cycle",
        "write G40 and a move to its start before the cycle",
    ),
    (
        LX,
        ("G0 X28 Z2\n", ""),
        (),
        11,
        "CYC007",
        "where this cycle starts is not known: no block has moved there yet",
        "say X and Z in the cycle, or move there with G0 before it",
    ),
    (
        LX,
        ("G0 X40 Z10", "X40 Z10"),
        (),
        12,
        "CYC007",
        "the next move behind this cycle says no motion code of its own",
        "write G0 or G1 into it",
    ),
    (
        LX,
        ("Q100", "Q101"),
        (),
        12,
        "CYC001",
        "the subroutine o101 with the contour does not stand before this cycle",
        SUB,
    ),
    (
        LX,
        ("o100 endsub\n", ""),
        (),
        11,
        "CYC001",
        "the subroutine o100 with the contour does not stand before this cycle",
        SUB,
    ),
    *(
        (
            LX,
            (CYCLE, said),
            (),
            12,
            "CYC004",
            "I of this cycle is not above zero",
            "give the depth of a pass as a number above zero",
        )
        for said in ("G71 Q100 I0", "G71 Q100 I-1")
    ),
    *(
        (
            LX,
            (CYCLE, f"G70 Q100 {said}"),
            (),
            12,
            "CYC004",
            "P of this cycle is not the number of its passes",
            "write a whole number from 1 to 100",
        )
        for said in ("P0", "P-1", "P1.5", "P101")
    ),
    *(
        (
            LX,
            (CYCLE, f"G71 Q100 {said}"),
            (),
            12,
            "CYC007",
            "D, E, R, U or W of this cycle is negative",
            "give each of them as zero or more",
        )
        for said in ("D-1", "E-1", "R-1", "U-1", "W-1")
    ),
    (
        LX,
        ("G1 X26", "G2 X20 Z-32 R6\nX26 Z-35 R6"),
        (),
        13,
        "CYC002",
        "an arc of the contour does not say G2 or G3 itself, which this control reads as G2",
        "write G2 or G3 into each arc of the contour",
    ),
    (
        LX,
        (f"G0 X28 Z2\n{CYCLE}", "G0 X20 Z-10\nG71 Q100 X28 Z2 I2"),
        (),
        12,
        "CYC006",
        "the way to the start of this cycle may lead through stock",
        "move there with G0 before the cycle",
    ),
    (
        LX,
        (CYCLE, "G71 Q100 I0.0399"),
        (),
        12,
        "CYC004",
        "this cycle would have too many passes",
        "give a greater I",
    ),
    (
        LX,
        ("X26\no100 endsub\nG0 X28 Z2\nG71", "X26\nG1 X20 Z-35\no100 endsub\nG0 X28 Z2\nG71.1"),
        (),
        13,
        "CYC003",
        "the contour ends in a pocket, behind whose edge this cycle cuts nothing",
        "end the contour as far out as its outermost point, or clear the pocket too (G71, G72)",
    ),
    (
        LX,
        ("G1 Z-30", "G1 Z-18"),
        (),
        12,
        "CYC003",
        "the contour turns back along the passes: an undercut",
        UNDERCUT,
    ),
    (
        LX,
        ("G1 Z-15\nG1 X12\nG1 X15 Z-22\nG1 Z-30\n", ""),
        (),
        8,
        "CYC006",
        "the contour begins at the height of the start point, or has no extent along the passes",
        OUTSIDE,
    ),
    (
        LX,
        (
            "G1 X15 Z-22\nG1 Z-30\nG1 X26\no100 endsub\nG0 X28 Z2\nG71 Q100 I2 R0.5",
            "G1 Z-16\nG1 X15\nG1 Z-30\nG1 X26\no100 endsub\nG0 X28 Z2\nG71 Q100 I2 D3",
        ),
        (),
        13,
        "CYC002",
        "something in the contour is smaller than the distance at which the cycle leaves it",
        "give a smaller D, or leave what is so small out",
    ),
]
CASES = [*CALLS, *CONTOURS, *LIMITS, *SINGLE, *PECKS, *SUBROUTINES]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}: {case[1][1][:30]!r}")
def test_what_stays_and_why(case: Case) -> None:
    name, (old, new), options, *said = case
    program = PROGRAMS[name]
    assert old in program
    profile = "linuxcnc-lathe" if name == LX else "fanuc-lathe"
    found = refused(program.replace(old, new, 1), *options, profile=profile)
    assert found == ([tuple(said)] if said[0] else [])


@pytest.mark.parametrize("name", PROGRAMS)
def test_without_the_change_nothing_stays(name: str) -> None:
    assert not refused(PROGRAMS[name], profile="linuxcnc-lathe" if name == LX else "fanuc-lathe")


def test_of_the_limits_the_other_side_is_no_fault() -> None:
    for name, old, new in (
        ("G73", "R3", "R500"),
        ("G73", "R3", "R1"),
        ("G73 in one block", "D3", "D1"),
        ("G71", "R0.5", "R0"),
        ("G71", "U2.", "U0.0361"),
        ("G71 in one block", "F0.3", "I1.2 K0.8 F0.3"),
        ("G71 in one block", "F0.3", "R1 F0.3"),
        ("G71 in one block", "F0.3", "R0 F0.3"),
        ("G71", "N10 G0 X16.", "N10 G0 X16. Z2."),
        ("G71", "G1 Z-15.", "G1 Z-15. ,C16.5"),
        ("G75", "Q3000", "Q16"),
        ("G75", "F0.1", "F0.1 R0 D0"),
        (LX, CYCLE, "G70 Q100 P100"),
        (LX, CYCLE, "G71 Q100 I2 R0 D0 E0 U0 W0"),
        (LX, CYCLE, "G71 Q100 I0.0401"),
    ):
        program = PROGRAMS[name].replace(old, new, 1)
        assert not refused(program, profile="linuxcnc-lathe" if name == LX else "fanuc-lathe"), new


def test_a_cycle_that_keeps_others_is_named_with_its_line() -> None:
    """Asked is the G71 alone; because of the G70 both stay, and no block ends the program behind it."""
    program = PROGRAMS["G71 and G70"].replace("N20 X52.", "N20 X52. M8").replace("M30", "/M30")
    assert refused(program) == [
        (
            11,
            "CYC007",
            "the contour leaves another coolant in force behind this cycle",
            "end in the contour what it begins",
        )
    ]


NOTES: list[tuple[str, tuple[str, str], list[tuple[int, str, str, str]]]] = [
    (
        "G71",
        ("M30", "N10 G4 X1.\nM30"),
        [
            (
                6,
                "CYC008",
                "N10 stands on 2 blocks: the next one, in line 7, is taken",
                "give every contour of the program numbers of its own",
            )
        ],
    ),
    (
        "G71",
        ("U2.", "U17.9"),
        [
            (
                6,
                "CYC011",
                "the depth of a pass, 17.9 mm, is more than the 17.8 mm that there is to take:"
                " one pass takes all of it",
                "check its unit and its point; a depth of what there is says the same",
            )
        ],
    ),
    ("G71", ("U2.", "U17.8"), []),
    (
        "G71",
        ("G71 U2.", "G70 P10 Q20\nG71 U17.9"),
        [
            (
                7,
                "CYC011",
                "the depth of a pass, 17.9 mm, is more than the 17.8 mm that there is to take:"
                " one pass takes all of it",
                "check its unit and its point; a depth of what there is says the same",
            )
        ],
    ),
    (
        "G71",
        ("G0 X52.", "G42 G0 X52."),
        [
            (
                6,
                "CYC009",
                "nose compensation is in force at this roughing cycle; its passes are written without it",
                "rough under G40; where the control compensates here, cycles.nose_in_roughing ="
                ' "compensated" lets'
                " the cycle stay",
            )
        ],
    ),
]


@pytest.mark.parametrize(("name", "change", "said"), NOTES)
def test_what_is_said_of_cycles_that_are_written_out(
    name: str, change: tuple[str, str], said: list[tuple[int, str, str, str]]
) -> None:
    assert noted(PROGRAMS[name].replace(*change, 1)) == said


def test_a_depth_in_the_first_line_of_a_program_is_found() -> None:
    """So it is its start that is missing."""
    (said,) = refused(LENGTHS + SHAPE + TAIL)
    assert said[:2] == (2, "CYC007")
    assert said[2].startswith("where this cycle starts is not known: ")
    assert refused(PROGRAMS["G71"]) == []
