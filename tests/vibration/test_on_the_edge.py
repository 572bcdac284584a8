"""A margin that is nearer to 1 than the machine is known is said to be unproven."""

from __future__ import annotations

import pytest

import chipbreak

PROGRAM = b"G97 S1000 M3\nG0 X20. Z2.\nG1 Z-20. F0.05 N1.5 f25 Q%s\nM30\n"
MODEL = 'planner.model="after-interpolation"'


def run(stroke: str, share: float, kind: str = "linear", *, slower: float = 1.0) -> chipbreak.Result:
    sets = [
        f"planner.uncertainty={share}",
        f"axes.Z.acc_dec={kind}",
        f"axes.Z.acc_dec_ms={12.0 * slower}",
        f"axes.Z.position_gain_1_s={60.0 / slower}",
    ]
    return chipbreak.rewrite(
        PROGRAM % stroke.encode(), chipbreak.load("fanuc-lathe", [MODEL, *sets]), allow_unbroken=True
    )


@pytest.mark.parametrize(("kind", "stroke"), [("linear", "4.1"), ("exponential", "7.5")])
def test_the_margin_goes_as_far_as_that_of_other_machines(kind: str, stroke: str) -> None:
    """A law that keeps the time of its blocks gets the same program on each of these machines."""
    (cut,) = run(stroke, 0.03, kind).cuts
    others = [run(stroke, 0.0, kind, slower=slower).cuts[0].verdict.margin for slower in (1.03, 1.0 / 1.03)]
    furthest = max(abs(margin - cut.verdict.margin) for margin in others)
    assert cut.margin_off == pytest.approx(furthest, rel=0.05)
    assert furthest > 0.01


@pytest.mark.parametrize(
    ("stroke", "share", "edge"), [("4.1", 0.03, True), ("4.1", 0.001, False), ("5", 0.03, False)]
)
def test_what_is_on_the_edge(*, stroke: str, share: float, edge: bool) -> None:
    result = run(stroke, share)
    (cut,) = result.cuts
    assert cut.is_on_edge == edge
    assert ("VIB097" in [said.code for said in result.diagnostics]) == edge


def test_what_is_not_measured_is_taken_as_it_is() -> None:
    assert run("4.1", 0.0).cuts[0].margin_off == 0.0
