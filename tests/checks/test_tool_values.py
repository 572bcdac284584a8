"""What a call says of a tool, digit by digit, and what data a tool lacks for it."""

from __future__ import annotations

import pytest

from chipbreak.checks.tool_values import DATA_FIELDS, data_texts, source_field
from chipbreak.tools.data import ToolData

DRILL = ToolData(
    2, "drill", 2, 12.3456, 101.25, corner_radius_mm=0.4, helix_deg=30.25, point_deg=118.75, holder_mm=70.0
)


def test_every_field_has_its_digits() -> None:
    """Lengths to a ten-thousandth, in inches to a hundred-thousandth; angles to a hundredth."""
    millimetres = {
        **{"diameter": "12.3456", "length": "101.25", "corner_radius": "0.4", "holder": "70."},
        **{"helix": "30.25", "point": "118.75"},
        **{"type": "DRILL", "teeth": "2", "kind": "3", "tip": "118.75"},
    }
    metric = data_texts(DRILL, is_inch=False)
    assert {name: metric[name] for name in millimetres} == millimetres
    inches = data_texts(DRILL, is_inch=True)
    # Over 25.4: 0.486047..., 3.986220..., 0.015748..., 2.755905...
    lengths = {"diameter": "0.48605", "length": "3.98622", "corner_radius": "0.01575", "holder": "2.75591"}
    assert inches == metric | lengths
    assert {name: metric[f"{name}_mm"] for name in lengths} == {name: metric[name] for name in lengths}
    assert set(metric) == set(DATA_FIELDS)


@pytest.mark.parametrize(
    ("type_name", "kind", "tip"),
    [
        (None, "type", "type"),
        ("probe", "type", "corner_radius_mm"),
        ("turning tool", "type", "corner_radius_mm"),
        ("flat end mill", "type", "corner_radius_mm"),
        ("bull nose end mill", "type", "corner_radius_mm"),
        ("ball end mill", "type", "diameter_mm"),
        ("drill", "type", "point_deg"),
    ],
)
def test_the_type_gives_the_kind_and_says_what_gives_the_tip(
    type_name: str | None, kind: str, tip: str
) -> None:
    """A ball has half its diameter, a drill its point angle; a tool that is not cut with is none of them."""
    tool = ToolData(2, type_name)
    assert (source_field("kind", tool), source_field("tip", tool)) == (kind, tip)


def test_other_fields_come_from_data_of_their_name() -> None:
    named = {
        **{"type": "type", "teeth": "teeth", "helix": "helix_deg", "point": "point_deg"},
        **{
            "length": "length_mm",
            "length_mm": "length_mm",
            "diameter_mm": "diameter_mm",
            "holder": "holder_mm",
        },
    }
    assert {name: source_field(name, DRILL) for name in named} == named
