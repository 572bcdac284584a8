"""Made-up mill programs: what posts and people write around tool calls and between operations."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

TITLES = ("(ADAPTIVE1)", "(2D CONTOUR2 FINISH)", "(FACE1)", "(DRILL 4X)", "(OP ROUGH)", "(OP FINISH)", "")
NOTHING = ""


def pick(draw: DrawFn, *texts: str) -> str:
    return draw(st.sampled_from(texts))


def point(draw: DrawFn, axes: str) -> str:
    def word(axis: str) -> str:
        value = draw(st.integers(-400, 400)) / 8
        return f"{axis}{value:.3f}"

    return " ".join(map(word, axes))


def tool_call(draw: DrawFn, tool: int, *, waits: bool) -> list[str]:
    """``waits``: the tool may be called into the magazine first, or another one behind it."""
    at_once = [[f"T{tool} M6"], [f"M6 T{tool}"], [f"G91 G28 Z0. T{tool} M6", "G90"]]
    later = [[f"T{tool}", "M6"], [f"T{tool}", "G91 G28 Z0. M6", "G90"], [f"T{tool}", "M6", "T9"]]
    return draw(st.sampled_from(at_once + (later if waits else [])))


def approach(draw: DrawFn, tool: int) -> list[str]:
    speed = pick(draw, "S5000 M3", "M3 S800", "S900 M4", "M3", NOTHING)
    coolant = pick(draw, "M8", "M7", NOTHING, "/M8")
    forms = (
        [f"G0 {point(draw, 'XY')}", f"G43 H{tool} Z20."],
        [f"G0 {point(draw, 'XY')}", "Z20."],
        [f"G0 {point(draw, 'XYZ')}"],
        [f"G0 {point(draw, 'X')}", f"G43 H{tool} Z20."],
        ["G0 Z20.", f"{point(draw, 'XY')}"],
        [f"G91 G0 {point(draw, 'XY')}", "G90"],
        [f"G0 G54 {point(draw, 'XY')} {speed}", "G43 H7", "G0 Z10."],
        [],
    )
    return [speed, "G54", coolant, *draw(st.sampled_from(forms))]


def work(draw: DrawFn) -> list[str]:
    cut = [f"G1 Z-1. F{draw(st.integers(1, 900))}.", f"X{draw(st.integers(0, 90))}."]
    forms = (
        cut,
        [*cut, f"G2 {point(draw, 'XY')} I1. J2.", "G1 Y4."],
        ["G1 G41 D1 X1. F100.", "Z-1.", "Y9.", pick(draw, "G40 X0.", NOTHING)],
        ["G99 G81 Z-5. R2. F80.", f"{point(draw, 'XY')}", pick(draw, "G80", NOTHING)],
        ["G91", *cut, "G90"],
        ["G91", *cut],
        ["M98 P1000"],
        [f"{point(draw, 'XY')}" for _ in range(12)],
        ["(nothing at all)"],
    )
    return draw(st.sampled_from(forms))


def way_out(draw: DrawFn) -> list[str]:
    forms = (
        ["G0 Z20."],
        ["G1 Z20. F900."],
        ["G0 Z20.", "M5", "M9", "G28 G91 Z0.", "G90", "G49"],
        ["G0 Z20.", "G28 G91 Z0.", "G28 X0. Y0.", "G90"],
        ["G0 Z20.", "G53 G0 Z0."],
        ["G0 Z20.", "G91 G30 Z0.", "G90"],
        ["G91 G0 Z30.", "G90"],
        ["G0 Z20.", "M5"],
        ["G0 Z20.", "M9", "M1"],
        ["G0 Z20.", "G53 G0 X-300. Y-20."],
        [],
    )
    return draw(st.sampled_from(forms))


def oddity(draw: DrawFn) -> list[str]:
    forms = (
        [],
        [],
        [],
        ["/G0 X9."],
        ["/M8"],
        ["G68 X0. Y0. R30."],
        ["G69"],
        ["G20"],
        ["IF [#1 EQ 2] GOTO 77"],
        ["N77"],
        ["#100 = 1"],
        ["G10 L2 P1 X1. Y2. Z3."],
        ["G92 X0. Y0."],
        ["G52 X5."],
        ["? what is this"],
        ["G95"],
        ["G93"],
        ["G19"],
        ["G49"],
        ["M29 S500"],
        ["M30"],
        ["S#101"],
        ["G8 P1"],
        ["G8 P0"],
        ["G4 P1."],
        ["G65 P9100 A1."],
    )
    return draw(st.sampled_from(forms))


@st.composite
def mill_programs(draw: DrawFn, *, waits: bool) -> bytes:
    """A program with a few tools, each with a few operations."""
    lines = [
        pick(draw, "%", NOTHING),
        "O1",
        *draw(st.sampled_from([["G90 G21"], [], ["G28 G91 Z0.", "G90"]])),
    ]
    for _ in range(draw(st.integers(0, 4))):
        tool = draw(st.integers(1, 3))
        lines += [pick(draw, *TITLES), *oddity(draw), *tool_call(draw, tool, waits=waits)]
        for at in range(draw(st.integers(1, 3))):
            title = [pick(draw, *TITLES)] if at else []
            parts = (approach(draw, tool), oddity(draw), work(draw), way_out(draw))
            lines += title + [line for part in parts for line in part]
    lines += draw(st.sampled_from([["M30", "%"], ["M2"], [], ["G28 G91 X0. Y0.", "M30"]]))
    end = pick(draw, "\n", "\r\n")
    return end.join(lines).encode("latin-1") + pick(draw, end, NOTHING).encode()
