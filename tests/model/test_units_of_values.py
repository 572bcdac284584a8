"""F and S of an inch program are held in mm and m/min, and come back as they were typed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.model.interpreted_program import interpret
from chipbreak.model.modal import Setting, State
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from chipbreak.units import MM_PER_INCH, surface_speed_m_min, typed_feed, typed_surface_speed


def after(*lines: str) -> State:
    settings = chipbreak.load("generic-lathe")
    program = parse(read("\n".join(lines).encode(), "inches.nc"), settings.dialect)
    return interpret(program, settings).end()


def known(setting: Setting | None) -> tuple[float, str]:
    assert setting is not None
    return setting.value, setting.text


@pytest.mark.parametrize(
    ("lines", "value"),
    [
        (("G21 G95", "F.2"), 0.2),
        (("G20 G95", "F.01"), 0.01 * MM_PER_INCH),
        (("G20 G94", "F10"), 10.0 * MM_PER_INCH),
        (("G20 G93", "F10"), 10.0),
        (("G20 G95", *["X1. Z1. F.01"] * 20), 0.01 * MM_PER_INCH),
        (("G20 G95 G91", *["X1. Z1. F.01"] * 20), 0.01 * MM_PER_INCH),
    ],
)
def test_a_feed_is_in_mm_but_for_inverse_time(*, lines: tuple[str, ...], value: float) -> None:
    assert known(after("G1", *lines).feed) == (value, lines[-1].split("F")[1])


def test_a_surface_speed_of_an_inch_program_is_in_metres_per_minute() -> None:
    assert known(after("G20", "G96 S400").speed) == (pytest.approx(121.92), "400")
    assert known(after("G21", "G96 S120").speed) == (120.0, "120")
    assert known(after("G20", "G97 S400").speed) == (400.0, "400")


def test_a_limit_of_the_spindle_is_in_rpm_also_under_surface_speed() -> None:
    assert known(after("G20", "G96 S400", "G50 S2000").speed_limit) == (2000.0, "2000")


@given(st.decimals(min_value="0.000001", max_value="9999", places=6))
def test_what_was_typed_comes_back_as_typed(number: object) -> None:
    typed = float(str(number))
    assert typed_feed(typed * MM_PER_INCH, is_inch=True) == typed
    assert typed_surface_speed(surface_speed_m_min(typed, is_inch=True), is_inch=True) == typed
    assert typed_feed(typed, is_inch=False) == typed
