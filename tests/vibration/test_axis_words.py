"""Axis letters and signs: a program and its twin for another control must stay twins when both are filtered.

The drawn programs are lines, tapers, arcs and chains, absolute, in G91 and in U and W, in mm and inches, on
diameter and radius; those by hand add centres, full circles, helices, planes, and tool checks.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import assume, event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from test_expansion import Shape, shapes

import chipbreak
from chipbreak.model.interpreted_program import interpret
from chipbreak.settings import SettingsError
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from machine_reader import filtered
from twin import Mapping, twin

CHECK_CASES = sorted((Path(__file__).parents[1] / "cases" / "check_tools").glob("*.nc"))
_BRACKETS = re.compile(r"(?m)^(.*\(CHIPBREAK )(?:WAS|HEX|END)[^()]*\)\n")
signs = st.tuples(*[st.sampled_from([1, -1])] * 3)


def bare(text: str) -> str:
    """A filtered program without what depends on the bytes of the original."""
    return _BRACKETS.sub("", text)


# The lathe's distances belong to X, Y, Z and C; A and B have none.
WITH_DISTANCES = ["XYZ", "ZYX", "YXZ", "XZY", "YZX", "ZXY", "XYC", "CYZ"]
WITHOUT = ["XYA", "BYZ", "AYB", "XAY"]


@pytest.mark.few(12)
@given(shapes(), st.sampled_from(WITH_DISTANCES + WITHOUT), signs)
@hypothesis_settings(max_examples=80)
def test_a_drawn_program_and_its_twin(shape: Shape, letters: str, sign: tuple[int, int, int]) -> None:
    assume(letters in WITH_DISTANCES or not re.search(r"[UW][-0-9]", shape.program))
    mapping = Mapping(letters, sign)
    program = "G18\n" + shape.program
    try:
        out = filtered(program, "generic-lathe", *shape.sets, allow_unbroken=True)
    except chipbreak.ProgramRejectedError as error:
        event("refused")
        sets = (*shape.sets, *mapping.sets)
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            filtered(twin(program, mapping, "ZX"), "generic-lathe", *sets, allow_unbroken=True)
        assert [d.message for d in error.diagnostics] == [d.message for d in caught.value.diagnostics]
        return
    event("taken")
    sets = (*shape.sets, *mapping.sets)
    twin_out = filtered(twin(program, mapping, "ZX"), "generic-lathe", *sets, allow_unbroken=True)
    assert bare(twin_out) == twin(bare(out), mapping, "ZX")


BY_HAND = {
    "centre": ("generic-lathe", "G18\nS800 M3\nG0 X20. Z0.\nG3 X24. Z-2. I0. K-2. F0.05 N1.5\nM30\n"),
    "full circle": ("generic-lathe", "G18\nS800 M3\nG0 X20. Z0.\nG2 I3. K1. F0.1 N1.5\nG1 X26. F.1\nM30\n"),
    "chain in three planes": (
        "fanuc-mill",
        "G17 S800 M3\nG0 X20. Y5. Z0.\nG95\n"
        "(VIB N1.5)\nG1 X25. F0.1\nG2 X28. Y2. I0. J-3.\nG1 Y0.\n(VIB OFF)\n"
        "G18 G0 X0.\n(VIB N1.5)\nG3 X4. Z-4. R4. F0.1\nG1 Z-8.\n(VIB OFF)\n"
        "G19 G0 Y0.\n(VIB N1.5)\nG2 Y4. Z-4. J0. K4. F0.1\nG1 Z0.\n(VIB OFF)\nG0 Z50.\nM30\n",
    ),
    "helix": (
        "fanuc-mill",
        "G17 G95 S800 M3\nG0 X20. Y5. Z0.\nG91\nG2 X3. Y-3. Z-1. J-3. F0.1 N1.5\nG90 G1 X0. F.1\nM30\n",
    ),
    "radii on the longer way": (
        "fanuc-mill",
        "G19 G95 S800 M3\nG0 X20. Y5. Z0.\nG3 Y9. Z-2. R-4. F0.1 N1.5\nG1 Y0. F.1\nM30\n",
    ),
    "constant surface speed": (
        "fanuc-lathe",
        "G50 S2000\nG96 S100 M3\nG0 X40. Z2.\nG1 X-1. F0.05 N1.5\nG0 Z5.\nM30\n",
    ),
}


@pytest.mark.few(8)
@given(st.data())
@hypothesis_settings(max_examples=60)
def test_a_program_by_hand_and_its_twin(data: st.DataObject) -> None:
    profile, program = BY_HAND[data.draw(st.sampled_from(sorted(BY_HAND)))]
    letters = ["XYZ", "ZYX", "YXZ", "XZY", "YZX", "ZXY", "XYC", "XYA", "BYZ", "AYB"]
    mapping = Mapping(data.draw(st.sampled_from(letters)), data.draw(signs))
    out = filtered(program, profile, allow_unbroken=True)
    assert "BEGIN VIB" in out
    plane = "XY" if profile == "fanuc-mill" else "ZX"
    program = program if "G1" in program.split("\n")[0] else f"G18\n{program}"
    out = filtered(program, profile, allow_unbroken=True)
    twin_out = filtered(twin(program, mapping, plane), profile, *mapping.sets, allow_unbroken=True)
    assert bare(twin_out) == twin(bare(out), mapping, plane)


ON_A_MILL = Mapping("XWZ", (1, -1, 1))
CARRIER = Mapping("XYZ", (-1, 1, -1))


def check_cases() -> Iterator[tuple[Path, Mapping]]:
    """Programs with their mappings; W is a distance on lathes, own calls name axes by their letters."""
    for file in CHECK_CASES:
        flags = file.read_text("latin-1").split("\n")[0]
        if "calls.shop" not in flags:
            yield file, CARRIER
            if "lathe" not in flags:
                yield file, ON_A_MILL


@pytest.mark.parametrize(("file", "mapping"), list(check_cases()), ids=lambda v: getattr(v, "stem", None))
def test_checks_come_back_in_the_controls_own_words(file: Path, mapping: Mapping) -> None:
    program = file.read_text("latin-1").partition("; --- output\n")[0]
    flags = shlex.split(program.split("\n")[0].removeprefix("; flags:"))
    name, sets = flags[1], flags[3::2]
    assert flags[0] == "-p"
    if name.endswith("lathe"):  # whatever comes with the profile is for tools that turn
        sets += ["checks.calls=shop", 'calls.shop={chip_check=["G65 P9858 T{tool}"]}']
    out = filtered(program, name, *sets)
    other = filtered(twin(program, mapping, "XY"), name, *sets, *mapping.sets)
    assert bare(other) == twin(bare(out), mapping, "XY")


# --- the fast road ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("style", ["", "G91\n"])
def test_long_runs_are_read_in_the_same_words(style: str) -> None:
    blocks = "".join(f"X{0.5 + i % 7 / 10:.1f} B{-1.0 - i / 10:.1f}\n" for i in range(200))
    program = f"G0 X10. B5. F0.2\n{style}G1 X0.5 B1.\n{blocks}M30\n"
    sets = ['axes.Z.letter="B"', "axes.Z.sign=-1"]
    settings = chipbreak.load("generic-lathe", sets)
    interpreted = interpret(parse(read(program.encode(), "run.nc"), settings.dialect), settings)
    state = interpreted.before(0)
    for effect in interpreted.effects_of(0, 202 + bool(style)):
        state = effect.after
    fast = interpreted.before(202 + bool(style))
    assert fast.position.x == pytest.approx(state.position.x)
    assert fast.position.z == pytest.approx(state.position.z)
    if not style:
        assert fast.position.z == pytest.approx(1.0 + 199 / 10)


# --- what a profile may say -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("profile", "sets", "key"),
    [
        ("generic-lathe", ['axes.Z.letter="Q"'], "axes.Z.letter"),
        ("generic-lathe", ['axes.Z.letter="E"'], "axes.Z.letter"),
        ("generic-lathe", ['axes.Z.letter="z"'], "axes.Z.letter"),
        ("generic-lathe", ['axes.Z.letter="X"'], "axes.Z.letter"),
        ("generic-lathe", ['axes.X.letter="W"'], "axes.X.letter"),
        ("fanuc-mill", ['axes.X.letter="V"'], "axes.X.letter"),
        ("linuxcnc-lathe", ['axes.Z.letter="B"'], "axes.Z.letter"),
        ("linuxcnc-lathe", ['axes.X.letter="U"'], "axes.X.letter"),
        ("fanuc-lathe", ['axes.X.letter="A"', "checks.enabled=true"], "checks.enabled"),
        ("generic-lathe", ["axes.Z.sign=0"], "axes.Z.sign"),
        ("generic-lathe", ["axes.Z.sign=-2"], "axes.Z.sign"),
        ("generic-lathe", ["axes.Z.sign=true"], "axes.Z.sign"),
    ],
)
def test_what_cannot_be(profile: str, sets: list[str], key: str) -> None:
    with pytest.raises(SettingsError) as caught:
        chipbreak.load(profile, sets)
    found = caught.value.diagnostic
    assert found.code in ("SET002", "SET003")
    assert key in found.message or key in found.line_text
    assert found.help


CUTS = ("G1 Z-5. B-3. F.1 N1.5", "G1 Z-5. F.1 N1.5", "G1 Z-5. F.1 f62.5", "G1 Z-5. F.1")


@pytest.mark.parametrize("cut", CUTS)
def test_a_letter_that_no_axis_has_is_not_passed_over(cut: str) -> None:
    program = f"G97 S3000 M3\nG0 X20. B2. (VIB N1.5)\n{cut}\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        filtered(program, "generic-lathe", 'axes.Z.letter="B"')
    (error,) = [d for d in caught.value.diagnostics if d.severity.value == "error"]
    assert error.code == "VIB048"
    assert error.place is not None
    assert (error.place.line, error.place.column) == (3, 4)


def explained(*sets: str) -> tuple[str, dict[str, object]]:
    settings = chipbreak.load("generic-lathe", sets)
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 X22. Z-3. F0.05 N1.5\nM30\n"
    result = chipbreak.rewrite(program, settings)
    report = chipbreak.explain(result, settings)
    data = json.loads(json.dumps(report.as_dict()))
    return str(report), data["cuts"][0]["moved"]


@pytest.mark.parametrize(
    ("sign_x", "sign_z", "words"),
    [
        (1, -1, ["X (X words) by the tool (tool post)", "Z (Z words) by the work (spindle carrier)"]),
        (1, 1, ["X (X words) by the tool (tool post)", "Z (Z words) by the tool (tool post)"]),
        (-1, -1, ["X (X words) by the work (spindle carrier)", "Z (Z words) by the work (spindle carrier)"]),
    ],
    ids=["carrier in Z, post in X", "post in both", "carrier in both"],
)
def test_explain_says_which_member_moves(sign_x: int, sign_z: int, words: list[str]) -> None:
    text, data = explained(f"axes.X.sign={sign_x}", f"axes.Z.sign={sign_z}")
    assert ", ".join(words) in text
    by = {1: "tool", -1: "work"}
    assert data == {"X": {"letter": "X", "by": by[sign_x]}, "Z": {"letter": "Z", "by": by[sign_z]}}


def test_explain_says_nothing_where_the_profile_does_not() -> None:
    text, data = explained()
    assert "moved" not in text
    assert data == {}


def test_a_loop_needs_words_for_distances() -> None:
    """B has none on a lathe of code system A; B and C say G91."""
    sets = ["output.form=loop", "axes.Z.letter=B"]
    with pytest.raises(SettingsError, match="no word for distances"):
        chipbreak.load("fanuc-lathe", sets)
    settings = chipbreak.load("fanuc-lathe", [*sets, "control.lathe_system=B"])
    program = b"G97 S1200 M3\nG0 X20. B2.\nG1 B-20. F0.1 N1.5\nM30\n"
    assert b"WHILE" in chipbreak.rewrite(program, settings).data
