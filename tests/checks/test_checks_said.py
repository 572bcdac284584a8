"""What stands where and why, and what is said of checks that are left out: each word and line of it."""

from __future__ import annotations

import pytest

import chipbreak
from beam import BEAM
from checks.filtered import filtered
from chipbreak.checks import findings as codes
from chipbreak.checks.findings import Findings
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

from .test_plan import END, HEAD, visit

Said = tuple[str, str, int, str, str]
CALIBRATED = (5, "CALIBRATE", "the beam is measured once a workpiece, before the first tool is called")
UP = ("G91 G28 Z0.", "G90")
MAKE_A_PLACE = "make a place for it: G0 to a known position, G40, G80, the spindle with S"
ROUGH = visit(1, "ROUGH")
BOTH = visit(1, "ROUGH", "FINISH")


def planned(text: str, *options: str) -> list[tuple[int, str, str]]:
    """The line (from 1) before which each insertion stands, its title and its reason."""
    found = filtered((HEAD + text + END).encode(), "fanuc-mill", *options)
    return [(edit.first + 1, edit.title, edit.reason) for edit in found.edits]


def checked(call: int, tool: int) -> tuple[int, str, str]:
    return (
        call + 1,
        f"TOOL CHECK T{tool}, TRACE T{tool}",
        f"T{tool} is called in line {call} and has not cut yet;"
        f" the edge of T{tool}, called in line {call}, is stored before its first cut",
    )


def of(kind: str, line: int) -> str:
    return f'{kind} ("{kind}" in the comment "{kind}", line {line})'


STRICTER = "neither rough nor finish, so the stricter W 0.02 mm"
REASONS: list[tuple[str, tuple[str, ...], list[tuple[int, str, str]]]] = [
    (
        BOTH + visit(2, "DRILL"),
        (),
        [
            checked(5, 1),
            (13, "CHIP CHECK T1 W0.02", f"T1 is used next for {of('FINISH', 13)}: W 0.02 mm"),
            (
                23,
                "CHIP CHECK T1 W0.05",
                f"last use of T1; the next workpiece starts with {of('ROUGH', 7)}: W 0.05 mm",
            ),
            checked(23, 2),
            (
                37,
                "CHIP CHECK T2 W0.02",
                f"last use of T2; the next workpiece starts with {of('DRILL', 25)}: {STRICTER}",
            ),
        ],
    ),
    (
        BOTH,
        ("checks.last_use=0.1",),
        [
            checked(5, 1),
            (13, "CHIP CHECK T1 W0.02", f"T1 is used next for {of('FINISH', 13)}: W 0.02 mm"),
            (25, "CHIP CHECK T1 W0.1", "last use of T1: checks.last_use gives W 0.1 mm"),
        ],
    ),
    (ROUGH, ("checks.last_use=none",), [checked(5, 1)]),
    (
        visit(1, "ROUGH", "DRILL"),
        ("checks.w_mm.1=0.04",),
        [
            checked(5, 1),
            (
                13,
                "CHIP CHECK T1 W0.04",
                f"T1 is used next for {of('DRILL', 13)}: checks.w_mm gives T1 W 0.04 mm",
            ),
            (
                25,
                "CHIP CHECK T1 W0.04",
                f"last use of T1; the next workpiece starts with {of('ROUGH', 7)}: checks.w_mm gives"
                " T1 W 0.04 mm",
            ),
        ],
    ),
    (
        ROUGH + visit(2, "ROUGH").replace("T2 M6", "/T2 M6") + visit(1, "FINISH"),
        (),
        [
            checked(5, 1),
            (17, "CHIP CHECK T1 W0.02", f"T1 is used next for {of('FINISH', 31)}: W 0.02 mm"),
            (30, "TOOL CHECK T1", "T1 is called in line 29 and has not cut yet"),
            (
                43,
                "CHIP CHECK T1 W0.05",
                f"last use of T1; the next workpiece starts with {of('ROUGH', 7)}: W 0.05 mm",
            ),
        ],
    ),
    (
        ROUGH + visit(2, "FINISH").replace("T2 M6", "/T2 M6"),
        (),
        [
            checked(5, 1),
            (
                17,
                "CHIP CHECK T1 W0.02",
                "T1 may be used next, if block delete (/) leaves out the call of T2, for"
                f" {of('FINISH', 19)}: W 0.02 mm",
            ),
        ],
    ),
]


BACKWARDS = visit(1, "FINISH", "ROUGH")
FINISH_AGAIN = f"last use of T1; the next workpiece starts with {of('FINISH', 7)}: W 0.02 mm"


def left_out(text: str, block: str, count: int) -> str:
    """The program with block delete before the nth of a block."""
    before, behind = text.split(block)[:count], text.split(block)[count:]
    return f"{block.join(before)}/{block}{block.join(behind)}"


@pytest.mark.parametrize(
    ("text", "limit", "reason"),
    [
        (BACKWARDS, "0.05", f"T1 is used next for {of('ROUGH', 13)}: W 0.05 mm"),
        # The roughing may be left out, jumped over, or done by another tool: then the next part comes first.
        (left_out(BACKWARDS, "G1 Z-1.", 2), "0.02", FINISH_AGAIN),
        (
            BACKWARDS.replace("(ROUGH)", "IF [#1 EQ 1] GOTO 77\n(ROUGH)").replace("M5\n", "N77 M5\n"),
            "0.02",
            FINISH_AGAIN,
        ),
        (visit(1, "FINISH") + visit(1, "ROUGH").replace("T1", "/T1"), "0.02", FINISH_AGAIN),
        # What may be left out before does not matter, nor does a jump.
        (left_out(BACKWARDS, "G1 Z-1.", 1), "0.05", f"T1 is used next for {of('ROUGH', 13)}: W 0.05 mm"),
        (
            BACKWARDS.replace("(FINISH)", "IF [#1 EQ 1] GOTO 77\nN77\n(FINISH)"),
            "0.05",
            f"T1 is used next for {of('ROUGH', 15)}: W 0.05 mm",
        ),
        # With its call the first cut of T2 may be left out too: then T1 finishes.
        (
            ROUGH + left_out(visit(2, "ROUGH", "FINISH").replace("T2 M6", "/T2 M6"), "G1 Z-1.", 1),
            "0.02",
            f"T1 may be used next, if block delete (/) leaves out the call of T2, for {of('FINISH', 25)}:"
            " W 0.02 mm",
        ),
    ],
)
def test_the_limit_is_that_of_what_may_come_next(text: str, limit: str, reason: str) -> None:
    first = next(one for one in planned(text) if one[1].startswith("CHIP"))
    assert first[1:] == (f"CHIP CHECK T1 W{limit}", reason)


@pytest.mark.parametrize(("text", "options", "wanted"), REASONS)
def test_what_stands_where_and_why(
    text: str, options: tuple[str, ...], wanted: list[tuple[int, str, str]]
) -> None:
    assert planned(text, *options) == [CALIBRATED, *wanted]


@pytest.mark.parametrize(
    ("every", "more"),
    [("1", ""), ("2", "; the control counts, and checks every 2 workpieces")],
)
def test_that_the_control_counts_workpieces_is_said(every: str, more: str) -> None:
    calls = (
        'calls.own={calibrate="G65 P1 K{every}", tool_check="G65 P2 T{tool} K{every} U{sister}"}',
        "checks.calls=own",
    )
    found = planned(ROUGH, *calls, f"checks.every={every}", "checks.sister.1=12")
    assert found[0] == (5, "CALIBRATE", CALIBRATED[2] + more)
    assert found[1][2] == "T1 is called in line 5 and has not cut yet; T12 may take its place"
    none = planned(ROUGH, *calls, "checks.sister.2=12")
    assert none[1][2] == "T1 is called in line 5 and has not cut yet"


def said_of(text: str, *options: str) -> list[Said]:
    """Code, severity, line, message and help of each finding; all is known of the tools."""
    found = filtered(text.encode(), "fanuc-mill", *options)
    return [
        (one.code, one.severity.value, one.place.line if one.place else 0, one.message, one.help)
        for one in found.diagnostics
    ]


NUMBERED = "call the tool with its number before it cuts"
NO_CALL = "no tool is called in the main program, so there is nothing to check"
ITS_NUMBER = "a check needs the tool's number from its call"
CUT = "S1000 M3\nG0 X1. Y2.\nG43 Z15. H1\nG1 Z-1. F100.\nG0 Z15.\n"
NO_SPEED = "the spindle speed of this cut is not known"
GIVE_IT = "give S and M3 or M4 before the cut, after any block that a jump or a loop reaches"
SEE_WHY = "see why its TRACE was left out"
SAID: list[tuple[str, list[Said]]] = [
    (HEAD + "G0 X1.\nG1 Z-1. F100.\n" + END, [("CHK001", "warning", 1, NO_CALL, ITS_NUMBER)]),
    (
        HEAD + "M98 P5\nG1 Z-1. F100.\n" + END + "O5\nT1 M6\nM99\n",
        [
            (
                "CHK001",
                "warning",
                1,
                NO_CALL,
                f"{ITS_NUMBER}, and the call in line 11 is not in the main program",
            )
        ],
    ),
    (
        HEAD + "T3\nS1000 M3\nG1 Z-1. F100.\n" + END,
        [
            (
                "CHK001",
                "warning",
                1,
                NO_CALL,
                f"{ITS_NUMBER}: T in line 5 prepares a tool, and M6 would bring it into the spindle",
            ),
        ],
    ),
    (
        HEAD + "G65 P9000 T3\nG1 Z-1. F100.\n" + END,
        [("CHK001", "warning", 1, NO_CALL, ITS_NUMBER)],
    ),
    (
        HEAD + ROUGH + "T0 M6\n" + CUT + CUT.replace("S1000 M3", "(FINISH)") + END,
        [
            (
                "CHK006",
                "warning",
                21,
                "this operation cuts after T0, which calls no tool; it is not checked",
                NUMBERED,
            ),
        ],
    ),
    (
        HEAD + ROUGH + "T#1 M6\n" + CUT + END,
        [
            (
                "CHK006",
                "warning",
                21,
                "this operation cuts with a tool whose number cannot be known; it is not checked",
                NUMBERED,
            ),
        ],
    ),
    (
        HEAD + ROUGH.replace("G1 Z-1. F100.\nX9.\n", "") + END,
        [("CHK005", "note", 1, "no tool that is called here cuts, so none is checked", "")],
    ),
    (
        HEAD + ROUGH + END + "O2\nT2 M6\nG1 X1. F1.\nM30\n",
        [
            (
                "CHK005",
                "note",
                22,
                "another program or a subprogram starts after the end; its tools are not checked",
                "",
            ),
        ],
    ),
    (
        HEAD + visit(1, "ROUGH", speed="M3\n") + END,
        [
            (
                "CHK002",
                "warning",
                5,
                "left out: CALIBRATE before T1, which is measured by the beam as it was last found,"
                " if ever; nothing"
                " can be inserted here, because the spindle speed must be put back, and S cannot be known",
                MAKE_A_PLACE,
            ),
            ("CHK003", "warning", 10, f"left out: TOOL CHECK T1; {NO_SPEED}", GIVE_IT),
            ("CHK003", "warning", 10, f"left out: TRACE T1; {NO_SPEED}", GIVE_IT),
            (
                "CHK004",
                "warning",
                11,
                "left out: CHIP CHECK T1 until it is called again; no shape of its edge was stored",
                SEE_WHY,
            ),
        ],
    ),
    (
        HEAD + visit(1, "ROUGH", "FINISH").replace("T1 M6", "T1 M6\nG68 X0. Y0. R30.") + END,
        [
            (
                "CHK002",
                "warning",
                5,
                "left out: CALIBRATE before T1, which is measured by the beam as it was last found,"
                " if ever; nothing"
                " can be inserted here, because the next blocks rely on where X is, which is not"
                " known: a reference"
                " return (G28, G30) leaves the program's coordinates",
                MAKE_A_PLACE,
            ),
            (
                "CHK002",
                "warning",
                6,
                "left out: TOOL CHECK T1, TRACE T1; nothing can be inserted here, because the next"
                " blocks rely on"
                " where X is, which is not known: a tool change moves the machine",
                MAKE_A_PLACE,
            ),
            (
                "CHK004",
                "warning",
                12,
                "left out: CHIP CHECK T1 until it is called again; no shape of its edge was stored",
                SEE_WHY,
            ),
        ],
    ),
]


@pytest.mark.parametrize(("text", "wanted"), SAID)
def test_what_is_said_of_checks_that_are_left_out(text: str, wanted: list[Said]) -> None:
    assert said_of(text) == wanted


def rewritten(text: str, *options: str, profile: str = "fanuc-mill") -> tuple[list[Said], bytes]:
    try:
        result = chipbreak.rewrite(text.encode(), chipbreak.load(profile, options))
        found, data = list(result.diagnostics), result.data
    except chipbreak.ProgramRejectedError as error:
        found, data = list(error.diagnostics), b""
    return [
        (one.code, one.severity.value, one.place.line if one.place else 0, one.message, one.help)
        for one in found
    ], data


PART = HEAD + BOTH + END
ALL = "left out: all checks; "
MAKERS = (
    "choose the cycles of that maker with checks.calls (haas, renishaw, ...), or describe calls of programs"
    " that have other numbers in [calls.NAME]"
)
OURS = "and the macros they call use #100 to #179 and #500 to #999"
USE_OTHERS = "let the program use other variables"
MOVE_THE_STORE = ", or the macros: macros.store_first and macros.store_last say which"
CLASHES: list[tuple[str, str, tuple[str, ...], Said]] = [
    (
        "G21\n",
        "G21\n#105=4.\n",
        (),
        ("CHK009", "warning", 3, f"{ALL}this program uses #105, {OURS}", USE_OTHERS),
    ),
    (
        "G21\n",
        "G21\n#100=4.\n",
        (),
        ("CHK009", "warning", 3, f"{ALL}this program uses #100, {OURS}", USE_OTHERS),
    ),
    (
        "G21\n",
        "G21\n#179=4.\n",
        (),
        ("CHK009", "warning", 3, f"{ALL}this program uses #179, {OURS}", USE_OTHERS),
    ),
    *(
        (
            "G21\n",
            f"G21\n#{number}=4.\n",
            (),
            (
                "CHK009",
                "warning",
                3,
                f"{ALL}this program uses #{number}, {OURS}",
                USE_OTHERS + MOVE_THE_STORE,
            ),
        )
        for number in (500, 600, 999)
    ),
    (
        "G21\n",
        "G21\n#[#1+1]=4.\n",
        (),
        (
            "CHK009",
            "warning",
            3,
            f"{ALL}this program uses a variable by a number worked out, {OURS}",
            USE_OTHERS,
        ),
    ),
    (
        "M30\n",
        "M30\nO8901\nM99\n",
        (),
        (
            "CHK010",
            "warning",
            26,
            f"{ALL}O8901 is defined in this program, and the checks would call a program of that name",
            "give that program another number or name, or choose other calls with checks.calls or"
            " [calls.NAME]",
        ),
    ),
    (
        "T1 M6",
        "G65 P8900 Z10. F3000\nT1 M6",
        (),
        (
            "CHK010",
            "warning",
            5,
            f"{ALL}this program calls P8900 with F, Z, as no check does: another program has that number",
            MAKERS,
        ),
    ),
    (
        "T1 M6",
        "M98 P28901\nT1 M6",
        (),
        (
            "CHK010",
            "warning",
            5,
            f"{ALL}this program calls P8901 without arguments, as no check does: another program"
            " has that number",
            MAKERS,
        ),
    ),
    (
        "T1 M6",
        "G65 P9843\nT1 M6",
        ("macros.first_program=9810",),
        (
            "CHK010",
            "warning",
            5,
            f"{ALL}this program calls P9843, a number of probe makers (Renishaw, Blum, Haas),"
            " whose programs also take"
            " P9810 to P9842",
            MAKERS,
        ),
    ),
]


@pytest.mark.parametrize(("old", "new", "options", "wanted"), CLASHES)
def test_what_a_program_shares_with_the_macros(
    old: str, new: str, options: tuple[str, ...], wanted: Said
) -> None:
    program = PART.replace(old, new, 1)
    found, data = rewritten(program, *BEAM, *options)
    assert (found, data) == ([wanted], program.encode())


@pytest.mark.parametrize("text", ["#99=4.", "#180=4.", "#499=4.", "G65 P8933", "O8933", "O8899"])
def test_what_is_beside_is_not_shared(text: str) -> None:
    program = (
        PART.replace("M30\n", f"M30\n{text}\nM99\n")
        if text[0] == "O"
        else PART.replace("G21", f"G21\n{text}")
    )
    found, data = rewritten(program, *BEAM)
    assert data.count(b"CHIPBREAK BEGIN") >= 3
    assert not {one[0] for one in found} & {"CHK009", "CHK010"}


def test_names_of_our_variables_are_shared_on_linuxcnc() -> None:
    program = PART.replace("G28 G91 Z0.\nG90\n", "").replace("G21\n", "G21\n#<_cb_limit>=4\n")
    found, _ = rewritten(program, *BEAM, profile="linuxcnc-mill")
    said = f"{ALL}this program uses #<_cb_limit>, and the macros they call use those that begin with _cb_"
    assert found == [("CHK009", "warning", 3, said, USE_OTHERS)]


def test_a_call_of_our_macros_is_no_definition() -> None:
    program = PART.replace("G28 G91 Z0.\nG90\n", "").replace("G21\n", "G21\no<cb_release> call [1]\n")
    found, data = rewritten(program, *BEAM, profile="linuxcnc-mill")
    assert b"BEGIN CHIP CHECK" in data
    assert "CHK010" not in {one[0] for one in found}


def test_without_a_beam_the_keys_are_named() -> None:
    found, data = rewritten(PART, "checks.enabled=true")
    missing = ("beam_x_mm", "beam_y_mm", "beam_z_mm", "safe_z_mm", "master_length_mm", "master_diameter_mm")
    said = f"{ALL}nothing says where the tool setter is: no {', '.join(f'macros.{key}' for key in missing)}"
    way_out = (
        "give them under [macros] in the profile; or choose the cycles of a maker with checks.calls (haas,"
        " renishaw, ...); or, with no tool setter on the machine, checks.enabled=false"
    )
    assert (found, data) == ([("CHK011", "warning", 5, said, way_out)], PART.encode())


UNKNOWN = "type, diameter_mm, length_mm, holder_mm, teeth, helix_deg"
IN_A_FILE = "give them in a tool file (--tools FILE); with checks.missing=error this is an error"


def left_to_control(tool: int, line: int) -> Said:
    said = (
        f"nobody gave {UNKNOWN} of T{tool}: the call that tells the control is left out,"
        " and the check alarms unless the control knows the tool"
    )
    return ("CHK007", "warning", line, said, IN_A_FILE)


def test_a_sister_that_cuts_itself_is_said_with_every_workpiece_that_is_checked() -> None:
    program = HEAD + ROUGH + visit(12, "ROUGH") + END
    found, data = rewritten(program, *BEAM, "checks.sister.1=12", "checks.every=3")
    sister = "T12 is the sister of T1, and this program cuts with it as well"
    assert found == [
        left_to_control(1, 10),
        ("CHK008", "warning", 22, sister, "keep a sister for the tool whose place it takes"),
        left_to_control(12, 22),
    ]
    assert [line for line in data.decode().splitlines() if line.startswith("G65")] == [
        *("G65 P8900 K3.", "G65 P8901 T1. S1000. K3. U12.", "G65 P8902 T1. Z20. K3. U12. W0.05 D1."),
        *("G65 P8903 T1. W0.05 D1. K3. U12.", "G65 P8901 T12. S1000. K3. U0."),
        *("G65 P8902 T12. Z20. K3. U0. W0.05 D1.", "G65 P8903 T12. W0.05 D1. K3. U0."),
    ]


@pytest.mark.parametrize(
    ("depth", "trace", "chips"),
    [
        ("breakage", "G65 P8902 T1. Z0.", "G65 P8903 T1. W0.02 D0."),
        ("limit-line", "G65 P8902 T1. Z20.", "G65 P8903 T1. W0.02 D1."),
        ("full", "G65 P8902 T1. Z20.", "G65 P8903 T1. W0.02 D2."),
    ],
)
def test_where_the_length_alone_counts_no_edge_is_stored(depth: str, trace: str, chips: str) -> None:
    _, data = rewritten(PART, *BEAM, f"checks.depth={depth}")
    calls = [line for line in data.decode().splitlines() if line.startswith("G65")]
    assert calls[1:4] == ["G65 P8901 T1. S1000.", trace, chips]


@pytest.mark.parametrize(
    ("missing", "severity", "more"),
    [("error", "error", "; checks.missing=skip leaves the check out"), ("skip", "warning", "")],
)
def test_what_nobody_gave_is_said_once_for_each_field_of_a_tool(
    missing: str, severity: str, more: str
) -> None:
    found, data = rewritten(PART, *BEAM, f"checks.missing={missing}")
    said = [one for one in found if one[0] == "TOL010"]
    assert b"BEGIN" not in data
    assert {(one[1], one[2]) for one in said} == {(severity, 10)}
    assert [one[3].partition(", and nobody gave it")[0] for one in said][:3] == [
        "TOOL CHECK of T1 needs its type",
        "TOOL CHECK of T1 needs its diameter",
        "TOOL CHECK of T1 needs its length below the holder",
    ]
    first = (
        "give type in a tool file (--tools FILE, or files in [tools]); also type of a Fusion"
        " library, the shape of"
        " a FreeCAD bit, or a comment (T2 - FLAT END MILL)"
    )
    assert said[0][4] == first + more
    assert found[-1][0] == "CHK004"


LEFT_OUT = ("CHK002", "CHK003", "CHK004", "CHK006", "CHK009", "CHK010", "CHK011", "CHK012")


def findings(*, is_strict: bool = False) -> Findings:
    settings = chipbreak.load("fanuc-mill")
    return Findings(parse(read(b"G21\nG90\nM30\n"), settings.dialect), is_strict=is_strict)


@pytest.mark.parametrize("number", range(1, 13))
def test_a_strict_profile_makes_an_error_of_what_is_left_out(number: int) -> None:
    code = f"CHK{number:03}"
    assert code in vars(codes).values()
    for is_strict in (False, True):
        collected = findings(is_strict=is_strict)
        collected.say(1, code, "what", "how")
        (one,) = collected.diagnostics
        severity = "note" if code == "CHK005" else "error" if is_strict and code in LEFT_OUT else "warning"
        assert (one.code, one.severity.value, one.message, one.help) == (code, severity, "what", "how")


@pytest.mark.parametrize(("line", "shown"), [(0, 1), (2, 3), (3, 3), (99, 3)])
def test_a_line_behind_the_last_one_means_the_last_one(line: int, shown: int) -> None:
    collected = findings()
    collected.say(line, "CHK001", "what")
    (one,) = collected.diagnostics
    assert one.place is not None and one.place.line == shown


def test_a_program_without_lines_has_no_place() -> None:
    collected = Findings(parse(read(b""), chipbreak.load("fanuc-mill").dialect), is_strict=False)
    collected.say(0, "CHK001", "what", "how")
    assert [(one.place, one.message, one.help) for one in collected.diagnostics] == [(None, "what", "how")]
