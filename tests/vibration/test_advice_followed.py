"""Every way out that a refusal names is followed, and the cut breaks its chips."""

from __future__ import annotations

import re

import pytest

import chipbreak
from longer import short_where

SHAPES = {
    "line": "G0 X20. Z2.\nG1 Z-20. {}",
    "facing": "G0 X60. Z0.\nG1 X20. {}",
    "taper": "G0 X20. Z2.\nG1 X30. Z-20. {}",
    "corner": "G0 X20. Z2.\nG1 Z-15. {}\nX40.",
    "chamfer": "G0 X20. Z2.\nG1 Z-15. {}\nX24. Z-17.\nZ-30.",
    "arc": "G0 X20. Z0.\nG3 X40. Z-10. R10. {}",
}
CONTROLS = {
    "trapezoid": ("fanuc-lathe", "planner.model=trapezoid"),
    "stopping": ("fanuc-lathe", "planner.model=trapezoid", "planner.reversal_stop_ms=2"),
    "linuxcnc": ("linuxcnc-lathe",),
}
HEADS = {"fanuc-lathe": "G21 G18 G99 G97 S{} M3\n", "linuxcnc-lathe": "G21 G18 G7 G90 G95 G97 S{} M3\n"}
REFUSALS = [
    (control, shape, speed, feed, wish)
    for control, shape, speed, feed, wish in [
        *((c, s, 3000, 0.2, "N1.5") for c in CONTROLS for s in SHAPES),
        *(
            (c, "line", 2400, 0.3, w)
            for c in CONTROLS
            for w in ("N0.5", "N2.5", "N1.5 Q1.8", "N1.25 ALPHA0.75")
        ),
        ("trapezoid", "line", 1800, 0.25, "N1.5 EDGES2"),
        ("trapezoid", "line", 3000, 0.2, "N1.5 WAVE SINE"),
    ]
]
TURNS = ("N1.5", "N0.5", "N2.5", "N1.5 EDGES2", "N1.5 Q1.8", "N1.25 ALPHA0.75")
_SLOWER = re.compile(r"N ([0-9.]+) with the same feed works at f ([0-9.]+) Hz")
_NEEDS = re.compile(r"needs ([0-9.e+]+) m/s2")
_DWELL = re.compile(r"WAVE DWELL with E ([0-9.]+)")
_LARGER = re.compile(r"Q ([0-9.]+) with the same S, N and f")
_LOWER = re.compile(r"N ([0-9.]+) f ([0-9.]+) Hz \(S [0-9.]+\) with the same feed and stroke")


def is_short(case: tuple[str, str, float, float, str]) -> bool:
    """Wishes along a line on the controls in turn, and every shape on the one whose ways are soon found."""
    control, shape, *_, wish = case
    if shape != "line" or wish not in TURNS:
        return control == "linuxcnc"
    return list(CONTROLS)[TURNS.index(wish) % len(CONTROLS)] == control


def run(control: str, program: str, *sets: str) -> chipbreak.Result:
    profile, *own = CONTROLS[control]
    limits = [f"axes.{axis}.max_acceleration_mm_s2=2000" for axis in "XZ"]
    return chipbreak.rewrite(program.encode(), chipbreak.load(profile, [*own, *limits, *sets]))


def program_of(control: str, shape: str, speed: int, feed: float, directive: str) -> str:
    head = HEADS[CONTROLS[control][0]].format(speed)
    return f"{head}(VIB {directive})\n{SHAPES[shape].format(f'F{feed}')}\nG0 X80.\nM30\n"


def ways_of(wish: str, text: str) -> list[tuple[str, tuple[str, ...]]]:
    """What a refusal names: a directive, and settings."""
    kept = " ".join(re.findall(r"(?:ALPHA|EDGES)[0-9.]+|Q[0-9.]+|WAVE [A-Z]+", wish))
    unstroked = " ".join(re.findall(r"(?:ALPHA|EDGES)[0-9.]+", wish))
    ways: list[tuple[str, tuple[str, ...]]] = []
    ways += [(f"N{n} F{f} {kept}", ()) for n, f in _SLOWER.findall(text) + _LOWER.findall(text)]
    ways += [(f"E{e} WAVE DWELL {unstroked}", ()) for e in _DWELL.findall(text)]
    ways += [(f"{wish} Q{q}", ()) for q in _LARGER.findall(text)]
    if "(VIB AUTO)" in text:
        ways.append((f"AUTO {kept}", ()))
    for need in _NEEDS.findall(text):
        limit = float(need) * 1000.0
        ways.append((wish, tuple(f"axes.{axis}.max_acceleration_mm_s2={limit}" for axis in "XZ")))
    return ways


@pytest.mark.parametrize(("control", "shape", "speed", "feed", "wish"), short_where(REFUSALS, is_short))
def test_what_is_named_works(control: str, shape: str, speed: int, feed: float, wish: str) -> None:
    program = program_of(control, shape, speed, feed, wish)
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        run(control, program)
    errors = [d for d in caught.value.diagnostics if d.severity.value == "error"]
    text = " ".join(f"{d.message} {d.help}" for d in errors)
    ways = ways_of(wish, text)
    assert ways, text
    for directive, sets in ways:
        result = run(control, program_of(control, shape, speed, feed, directive), *sets)
        assert result.cuts, (directive, text)
        assert all(cut.verdict.breaks for cut in result.cuts), (directive, text)


CLAMPED = ("spindle.max_rpm=2000",)


def refusals(control: str, directive: str, *sets: str, cuts: int = 1) -> list[chipbreak.Diagnostic]:
    program = HEADS[CONTROLS[control][0]].format(3000) + f"(VIB {directive})\n"
    program += cuts * "G0 X20. Z2.\nG1 Z-20. F0.3\n" + "G0 X80.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        run(control, program, *sets)
    return [d for d in caught.value.diagnostics if d.severity.value == "error"]


@pytest.mark.parametrize("acceleration", [300, 1000, 3000, 30000])
@pytest.mark.parametrize(("directive", "code"), [("N1.5 F62.5", "VIB006"), ("N5 F31.25", "VIB005")])
def test_what_the_solver_names_works(directive: str, code: str, acceleration: int) -> None:
    limits = [f"axes.{axis}.max_acceleration_mm_s2={acceleration}" for axis in "XZ"]
    (error,) = refusals("trapezoid", directive, *CLAMPED, *limits)
    assert error.code == code
    slower = _SLOWER.findall(error.help)
    named = re.findall(r"f ([0-9.]+) Hz or a larger", error.help)
    ways = [f"N{n} F{f}" for n, f in slower] + [f"N1.5 F{f}" for f in named]
    for counts in re.findall(r"N ([0-9.]+)(?: or ([0-9.]+))? breaks best", error.help):
        ways += [f"N{count} F31.25" for count in counts if count]
    assert ways, error.help
    for way in ways:
        program = HEADS["fanuc-lathe"].format(3000) + f"(VIB {way})\nG0 X20. Z2.\nG1 Z-20. F0.3\nM30\n"
        (cut,) = run("trapezoid", program, *CLAMPED, *limits).cuts
        assert cut.verdict.breaks


@pytest.mark.parametrize("directive", ["N1.5 F62.5", "E1.5 WAVE DWELL", "N3"])
@pytest.mark.parametrize("sets", [(), CLAMPED])
def test_from_the_fourth_cut_on_no_number_is_named(directive: str, sets: tuple[str, ...]) -> None:
    fourth = refusals("trapezoid", directive, "vibration.refused=error", *sets, cuts=4)[3]
    assert not re.search(r"\b(?:N|f|E|S|Q) [0-9]", fourth.help)
