"""A long cut that fails is refused for its beginning, and one that does not is written."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.vibration import beginning, blocks, cuts
from chipbreak.vibration.blocks import Expansion
from chipbreak.vibration.loop_names import LoopNames
from chipbreak.vibration.plan import CutPlan
from longer import short_where

LATHE = "G21 G18 G99 G97 S2500 M3\n"
CENTRE = "G21 G18 G7 G90 G95 G97 S2500 M3\n"
LINE = "G0 X40. Z2.\nG1 Z-{}. F0.02"
ARC = "G0 X40. Z0.\nG3 X240. Z-100. R100. F0.02"
CHAIN = "G0 X20. Z2.\nG1 Z-{}. F0.02\nX60."
FOLLOWED = tuple(
    f"axes.{axis}.{number}" for axis in "XZ" for number in ("acc_dec_ms=8", "position_gain_1_s=90")
)
LOOKING = ("planner.model=look-ahead", "planner.joint_speed_mm_min=600", "output.feed_mode=minute", *FOLLOWED)
CASES = {
    # profile, head, cut, wish, settings, the refusal
    "too slow axes": ("linuxcnc-lathe", CENTRE, ARC, "N1.5 WAVE SINE", (2000,), "VIB030"),
    "too many bytes": (
        "linuxcnc-lathe",
        CENTRE,
        LINE,
        "N1.5",
        (9000, "planner.max_bytes_per_s=900"),
        "VIB032",
    ),
    "little is left": (
        "fanuc-lathe",
        LATHE,
        LINE,
        "N1.5",
        (1500, "planner.model=after-interpolation", *FOLLOWED),
        "VIB062",
    ),
    "nor of a look-ahead": ("fanuc-lathe", LATHE, CHAIN, "N1.5", (2000, *LOOKING), "VIB062"),
    "too small a stroke": ("linuxcnc-lathe", CENTRE, LINE, "N1.5 Q1.02", (9000,), "VIB060"),
    "it breaks": ("linuxcnc-lathe", CENTRE, LINE, "N1.5", (9000,), ""),
    "it breaks round a corner": ("fanuc-lathe", LATHE, CHAIN, "E6", (20000, *LOOKING), ""),
}


def codes_of(case: str, length: int) -> list[str]:
    """What a cut of this length is refused for."""
    profile, head, cut, wish, (acceleration, *sets), _ = CASES[case]
    limits = [f"axes.{axis}.max_acceleration_mm_s2={acceleration}" for axis in "XZ"]
    settings = chipbreak.load(profile, [*map(str, sets), *limits])
    program = f"{head}(VIB {wish})\n{cut.format(length)}\nG0 X300.\nM30\n"
    try:
        chipbreak.rewrite(program.encode(), settings)
    except chipbreak.ProgramRejectedError as error:
        return [one.code for one in error.diagnostics if one.severity.value == "error"]
    return []


@pytest.mark.parametrize("case", short_where(CASES, lambda case: case != "nor of a look-ahead"))
def test_the_beginning_of_a_cut_fails_as_all_of_it_does(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []

    def counted(cut: CutPlan, settings: chipbreak.Settings, names: LoopNames | None = None) -> Expansion:
        made.append(0)
        expansion = blocks.moves_of(cut, settings, names)
        made[-1] = len(expansion.distance_mm)
        return expansion

    monkeypatch.setattr(cuts, "moves_of", counted)
    code = CASES[case][-1]
    early = codes_of(case, 300)
    # Where it fails none of its blocks are made, but for those of its beginning.
    assert bool(made) == (not code)
    monkeypatch.setattr(beginning, "beginnings", lambda plan, settings: ())
    late = codes_of(case, 300)
    assert made
    assert early == late[: len(early)] == ([code] if code else [])
