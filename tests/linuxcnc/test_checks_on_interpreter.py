"""A check changes nothing but itself, as LinuxCNC's own interpreter sees it.

The proof inside the filter reads programs with the interpreter that planned the check, and so shares its
mistakes.  Here ``rs274`` runs the program and the result.  The macros are made of wood: they go away and
come back to nothing, as real ones do, and give modes back with M72.
"""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import pytest
from hypothesis import Phase, event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from beam import BEAM

from . import rs274
from .actions import actions, difference

TOOLS = tuple(
    rs274.Tool(number, z_mm=100.0 + 7 * number, diameter_mm=4.0, orientation=0) for number in range(100)
)
_MACRO = """o<{name}> sub
{noted}#<feed_before> = #<_feed>
#<speed_before> = #<_rpm>
M70
M5
G90 G94 G97 G61
G53 G0 Z0
G53 G0 X-300 Y-200
S777 M3
G91 G1 X1 F333
M5
G90 G53 G0 Z0
{back}M72
S#<speed_before>
o99 if [#<feed_before> GT 0]
  F#<feed_before>
o99 endif
o<{name}> endsub
M2
"""
_MACROS = ("cb_calibrate", "cb_tool_check", "cb_trace", "cb_chip_check")
# CALIBRATE comes back over where it was called; behind the others the filter sends the tool back.
_BACK = {
    "cb_calibrate": {
        "noted": "#<x_before> = #<_abs_x>\n#<y_before> = #<_abs_y>\n",
        "back": "G53 G0 X#<x_before> Y#<y_before>\n",
    }
}
_STAYS = {"noted": "", "back": ""}
_DATA = ("cb_tool", "cb_length")


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    folder = tempfile.TemporaryDirectory(prefix="wood-")
    for name in _MACROS:
        (Path(folder.name) / f"{name}.ngc").write_text(_MACRO.format(name=name, **_BACK.get(name, _STAYS)))
    for name in _DATA:
        (Path(folder.name) / f"{name}.ngc").write_text(f"o<{name}> sub\no<{name}> endsub\nM2\n")
    rows = [f"{number},flat end mill,4,10,50,80,30" for number in range(100)]
    head = "number,type,teeth,diameter_mm,length_mm,holder_mm,helix_deg"
    (Path(folder.name) / "tools.csv").write_text("\n".join([head, *rows, ""]))
    return folder


def wooden_macros() -> Path:
    """The folder of the macros that do nothing, and of the data of all tools."""
    return Path(_folder().name)


def compared(program: bytes, *options: str, block_delete: bool = False) -> str:
    """ "checked" for a program with checks that does what it did; else why there is nothing to compare."""
    folder = wooden_macros()
    profile = chipbreak.load("linuxcnc-mill", [*BEAM, f'tools.files=["{folder / "tools.csv"}"]', *options])
    result = chipbreak.rewrite(program, profile, "program.ngc")
    if not result.edits:
        return "no check"
    before, after = (
        rs274.judge(data, lathe=False, subroutines=folder, tools=TOOLS, block_delete=block_delete)
        for data in (program, result.data)
    )
    if not before.accepted:
        return "not taken by LinuxCNC"
    assert after.accepted, f"{after.message}\n{program.decode()}"
    assert not difference(before.canon, after.canon), program.decode()
    return "checked"


def visit(before: str = "", between: str = "", *, cut: str = "G1 Z-1 F100\nX9", call: str = "T1 M6") -> bytes:
    """A program with one tool, something before its first cut and something behind it."""
    lines = ["G21 G17 G90 G94", call, "S1000 M3", "G0 X3 Y4", before, "G43 H1 Z20", cut, "G0 Z21"]
    return "\n".join(
        filter(None, [*lines, between, "(FINISH)", "G0 X1 Y2", "Z3", "G1 Z-2", "M2", ""])
    ).encode()


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    "program",
    [
        visit("G10 L20 P1 X1 Y1 Z10"),  # a work offset from where the tool stands
        visit(between="G10 L20 P2 X0"),
        visit(between="#5 = #5422\nG0 Z[#5 + 1]"),
        visit(between="G0 X[#<_x> + 2]"),
        visit("M70\nG91\nM72"),
        visit(between="M70\nG91\nM72\nG53 G0 Z0"),
        visit(between="G28.1\nG0 Z30\nG28"),
        visit(between="G91\nG49 G0 Z200\nG90"),
        visit(between="G96 D3000 S120\nG0 Z22"),
        visit(between="G43.1 Z60\nG1 X5\nG0 Z25"),
        visit().replace(b"G43 H1 Z20", b"G43.1 Z61").replace(b"Z-1 F100", b"F100"),
        visit().replace(
            b"M6\nS1000 M3\nG0 X3 Y4", b"M6\nG0 Z8\nS1000 M3\nX3 Y4"
        ),  # down where the tool stands
        visit(between="T2 M6\nG0 Z23\nS900 M3"),
        visit(between="T2 M6\nG38.3 Z-9 F50\nG0 Z23\nS900 M3"),
        visit("G20\nG0 X1"),
        b"F290\n" + visit("G20\nG0 X1"),
        b"G64 P0.05\n" + visit("G20\nG0 X1"),
        b"g64 p0.05\n" + visit("G20\nG0 X1"),
        visit(cut="G1 Z-1 F100\nG94\nG28", between="T2 M6\nG0 X5 Y5\nS900 M3\nF100"),
        b"o<away> sub\nG91\no<away> endsub\n" + visit("G91").replace(b"T1 M6", b"o<away> call\nT1 M6"),
        visit(between="/G91\nG0 X7\nZ25\nG90\n(ROUGH)\nG1 X9 F90\nG0 Z26"),
        visit(cut="G1 Z-1 F100\nG94\n/F90\nG28", between="G53 G0 Z0"),
    ],
)
def test_what_a_check_must_know(program: bytes) -> None:
    compared(program)
    compared(program, block_delete=True)


@pytest.mark.linuxcnc
def test_a_g91_that_a_slash_leaves_out() -> None:
    program = visit(between="G91 G0 Z5\n/G90\nG0 Z25\nG90")
    compared(program, block_delete=True)
    compared(program)


@pytest.mark.linuxcnc
@pytest.mark.parametrize("shift", ["G52 X3", "G92 X7", "G10 L2 P1 X3", "G10 L2 P2 X3\nG55"])
def test_the_judge_counts_from_the_offsets_in_force(shift: str) -> None:
    """The same number is another place where an offset has changed, also after a tool change."""
    program = f"G0 X10 Y4 Z5\n{shift}\nT2 M6\nG0 X10\nM2\n"
    judged = rs274.judge(program.encode(), lathe=False, tools=TOOLS)
    rapids = [action for action in actions(judged.canon) if action.name == "STRAIGHT_TRAVERSE"]
    assert [(rapid.start[0], rapid.end[0]) for rapid in rapids] == [(0.0, 10.0), (10.0, 13.0)]


_PLACE = st.integers(-3900, 3900).map(lambda number: f"{number / 100:g}")
_HEIGHT = st.integers(1500, 3900).map(lambda number: f"{number / 100:g}")
_TOOL = st.integers(1, 5)
_SPEED = st.integers(300, 8000)
_MODES = (
    "M8 M7 M9 M3 M4 M5 G90 G91 G17 G18 G98 G99 G40 G61 G61.1 G64 G80 G49 G43 G54 G55 G59.3 G0 G1 M1 G92.1",
    "/M8 /G91 G28.1 (FINISH) (ROUGH)",
)
_BLOCKS = (
    "G94|F300; G95|F0.2; G64 P0.02 Q0.01; G96 D3000 S120; G97 S1500; G92 Z10; G52 X3; /G0 Z30; /S900",
    "G4 P0.1; G53 G0 Z0; G28 Z5; G91 G28 Z0|G90; M70|G91|M72; #1=7|G0 X#1; G0 Z[#5422+2]; F[#<_feed>+1]",
    "o<sub> call [3]; o<sub> call [1]",
)
_ANYTHING = st.one_of(
    st.sampled_from(" ".join(_MODES).split(" ")),
    st.sampled_from("; ".join(_BLOCKS).replace("|", "\n").split("; ")),
    st.builds("G0 X{} Y{}".format, _PLACE, _PLACE),
    st.builds("G0 Z{}".format, _HEIGHT),
    st.builds("S{} M3".format, _SPEED),
    st.builds("G43 H{} Z{}".format, _TOOL, _HEIGHT),
    st.builds("G43.1 Z{}".format, _HEIGHT),
    st.builds("G10 L20 P1 X{} Z{}".format, _PLACE, _HEIGHT),
    st.builds("G10 L2 P2 Y{}".format, _PLACE),
)
_CUT = st.one_of(
    st.builds("G0 X{} Y{}\nZ3\nG1 Z-1 F{}\nX{}".format, _PLACE, _PLACE, _SPEED, _PLACE),
    st.builds("G81 X{} Y{} Z-4 R2 F{}\nY{}\nG80".format, _PLACE, _PLACE, _SPEED, _PLACE),
    st.builds("G0 X{}\nG1 Z-2 F{}\nG2 I4".format, _PLACE, _SPEED),
    st.builds("G0 X0 Y0 Z2\nG1 Z-2 F200\nG41 D{} X20\nY30\nG40 X{}".format, _TOOL, _PLACE),
    st.builds("G91\nG1 Z-2 F{}\nG0 Z8\nG90".format, _SPEED),
)
_VISIT = st.builds(
    lambda tool, speed, place, height, noise, operations: "\n".join(
        [
            f"T{tool} M6",
            *noise[:1],
            f"S{speed} M3",
            f"G0 X{place} Y4",
            *noise[1:],
            f"G43 H{tool} Z{height}",
            *(line for one in operations for line in one),
        ]
    ),
    _TOOL,
    _SPEED,
    _PLACE,
    _HEIGHT,
    st.lists(_ANYTHING, max_size=2),
    st.lists(
        st.tuples(_CUT, st.builds("G0 Z{}".format, _HEIGHT), _ANYTHING, st.just("(FINISH)")),
        min_size=1,
        max_size=2,
    ),
)
# G52 lasts over the tool changes: after them is another place than it was before.
_SHIFTED = [
    f"T{tool} M6\nS{speed} M3\nG0 X{x} Y4\nG43 H{tool} Z{first}\n"
    f"G91\nG1 Z-2 F432\nG0 Z8\nG90\nG0 Z{last}\nG52 X3\n(FINISH)"
    for tool, speed, x, first, last in (
        (1, 401, -25.42, 39, 16.03),
        (4, 401, -25.42, 39, 16.03),
        (1, 889, -10.81, 20.76, 39),
    )
]
_SUB = "o<sub> sub\no7 if [#1 GT 2]\nG0 X#1\nM8\no7 endif\no<sub> endsub"


def _program(visits: list[str]) -> bytes:
    return "\n".join([_SUB, "G21 G17 G40 G80 G90 G94 G54", *visits, "M5", "M2", ""]).encode()


_OPTIONS = (
    "checks.every=2",
    "checks.retries=3",
    'checks.last_use="none"',
    "checks.only=[1,2]",
    "checks.sister.1=51",
)


@pytest.mark.few(10)
@pytest.mark.linuxcnc
@given(st.lists(_VISIT, min_size=1, max_size=3), st.sampled_from(_OPTIONS), st.booleans())
@hypothesis_settings(max_examples=90, phases=[Phase.explicit, Phase.reuse, Phase.generate])
def test_programs_do_what_they_did(visits: list[str], option: str, block_delete: bool) -> None:
    event(compared(_program(visits), option, block_delete=block_delete))


@pytest.mark.linuxcnc
def test_a_place_after_g52_is_another_one() -> None:
    assert compared(_program(_SHIFTED), "checks.only=[1,2]", block_delete=True) == "checked"
