"""What an expression without variables comes to."""

from __future__ import annotations

import pytest

from chipbreak.dialects import LINUXCNC_MILL
from chipbreak.syntax.evaluate import constant
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read


def value_of(text: str) -> float | None:
    """What an expression in square brackets comes to."""
    program = parse(read(f"G1 X{text}\n".encode()), LINUXCNC_MILL)
    (word,) = program.block(0).words_of("X")
    assert word.expression is not None
    return constant(word.expression)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("[1+2*3]", 7.0),
        ("[[1+2]*3-1]", 8.0),
        ("[2**3/4]", 2.0),
        ("[7 MOD 3]", 1.0),
        ("[6 MOD 0.5]", 0.0),
        ("[0 MOD 3]", 0.0),
        ("[2 EQ 2]", 1.0),
        ("[2 NE 2]", 0.0),
        ("[3 GT 2]", 1.0),
        ("[2 GT 2]", 0.0),
        ("[2 GE 2]", 1.0),
        ("[2 LT 3]", 1.0),
        ("[2 LT 2]", 0.0),
        ("[2 LE 2]", 1.0),
        ("[3 LE 2]", 0.0),
        ("[SIN[30]]", 0.5),
        ("[COS[60]]", 0.5),
        ("[TAN[45]]", 1.0),
        ("[ASIN[0.5]]", 30.0),
        ("[ACOS[0.5]]", 60.0),
        ("[ATAN[1]/[1]]", 45.0),
        ("[ATAN[-1]/[-1]]", -135.0),
        ("[SQRT[9]]", 3.0),
        ("[ABS[-2.5]]", 2.5),
        ("[ROUND[2.5]]", 3.0),
        ("[ROUND[-2.5]]", -3.0),
        ("[ROUND[2.4]]", 2.0),
        ("[LN[1]]", 0.0),
        ("[EXP[0]]", 1.0),
    ],
)
def test_what_every_control_works_out_alike(text: str, value: float) -> None:
    assert value_of(text) == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "[SQRT[-1]]",
        "[ASIN[2]]",
        "[LN[0]]",
        "[1/0]",
        "[0**-1]",
        "[-8**0.5]",
        "[10**200*10**200]",
        "[EXP[1000]]",
    ],
)
def test_what_no_control_can_work_out_has_no_value(text: str) -> None:
    assert value_of(text) is None


@pytest.mark.parametrize(
    "text",
    [
        "#1",
        "[#1+2]",
        "[2+#1]",
        "[SQRT[#1]]",
        "[ATAN[#1]/[1]]",
        "[ATAN[1]/[#1]]",
        "[ATAN[1/0]/[1]]",
        "[FIX[-2.5]]",
        "[FUP[2.5]]",
        "[5 AND 3]",
        "[5 OR 3]",
        "[5 XOR 3]",
        "[-7 MOD 3]",
        "[7 MOD -3]",
    ],
)
def test_what_the_machine_or_its_control_decides_has_no_value(text: str) -> None:
    assert value_of(text) is None
