"""Changes so large that nobody should find them out at the machine are said, each with its limit."""

from __future__ import annotations

import re

import pytest

import chipbreak
from machine_reader import beside_unproven

CUT = "G97 S{s} M3\nG0 X20. Z2.\n(VIB {wish})\nG1 Z-30. F{f}\nM30\n"
AXES = ("axes.Z.max_acceleration_mm_s2=50000",)


def said(
    wish: str, *sets: str, s: str = "3000", f: str = "0.05", profile: str = "generic-lathe"
) -> list[chipbreak.Diagnostic]:
    program = CUT.format(wish=wish, s=s, f=f)
    return beside_unproven(chipbreak.rewrite(program.encode(), chipbreak.load(profile, sets)).diagnostics)


def codes(*args: str, **values: str) -> list[str]:
    return [found.code for found in said(*args, **values)]


@pytest.mark.parametrize(
    ("n", "s", "is_said"),
    [
        pytest.param("1.5", "3000", False, id="3000 becomes 2500"),
        pytest.param("1.5", "3125", False, id="a fifth less"),
        pytest.param("1.5", "3200", True, id="more than a fifth less"),
        pytest.param("1.5 F62.5", "2000", True, id="N and f fix another speed"),
    ],
)
def test_spindle_speed(n: str, s: str, is_said: bool) -> None:
    found = said(f"N{n}", *AXES, s=s)
    assert [one.code for one in found] == ["VIB074"] * is_said
    assert all("instead of" in one.message and one.place and one.place.line == 4 for one in found)


def test_speed_under_constant_surface_speed() -> None:
    """What counts is the speed at the diameter where the cut starts."""
    program = "G96 S{s} M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-30. F0.05\nM30\n"
    for surface, is_said in (("188", False), ("157", False), ("220", True)):
        data = program.format(s=surface).encode()
        found = chipbreak.check(data, chipbreak.load("generic-lathe", AXES))
        assert [one.code for one in found if one.code == "VIB074"] == ["VIB074"] * is_said, surface


def test_time() -> None:
    assert codes("N1.5", *AXES) == []
    dwell = said("E2.4 WAVE DWELL", *AXES, s="1000")
    assert [one.code for one in dwell] == ["VIB075"]
    assert "instead of 38.4 s" in dwell[0].message


def test_acceleration_that_nobody_says_the_axis_has() -> None:
    assert codes("N1.5", f="0.05") == []
    assert codes("N1.5", f="0.2") == ["VIB076"]
    assert codes("N1.5", *AXES, f="0.2") == []
    assert codes("N1.5", "axes.X.max_acceleration_mm_s2=50000", f="0.2") == ["VIB076"]


@pytest.mark.parametrize(
    ("wish", "f", "is_said"),
    [
        pytest.param("N1.5 A4.9", "0.5", False, id="a large stroke"),
        pytest.param("N1.5 A6.5", "0.5", True, id="a stroke of another unit"),
        pytest.param("N1.5", "5.2", True, id="a feed of another unit"),
    ],
)
def test_sizes(wish: str, f: str, is_said: bool) -> None:
    ramps = ("vibration.ramp_vibrations=1", "vibration.end_revolutions=0")
    found = codes(wish, "axes.Z.max_acceleration_mm_s2=5e8", *ramps, f=f, s="500")
    assert [code for code in found if code == "VIB077"] == ["VIB077"] * is_said


def test_explain_says_them_too() -> None:
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(CUT.format(wish="N1.5", s="3200", f="0.2").encode(), settings)
    report = chipbreak.explain(result, settings).as_dict()
    assert [one["code"] for one in report["diagnostics"]] == ["VIB074", "VIB076", "VIB079"]
    assert report["without_axis_data"]
    assert report["cuts"][0]["programmed_s"] == pytest.approx(32.0 / (0.2 * 3200) * 60.0)


def test_an_acceleration_along_the_path_is_known_too() -> None:
    program = "G21\nG90\nM3 S2500\nG0 X10. Z2.\nG1 Z-20. F500. N1.5\nG0 X30.\n"
    profile = chipbreak.load("klipper", ["planner.path_acceleration_mm_s2=60000"])
    result = chipbreak.rewrite(program.encode(), profile)
    (cut,) = result.cuts
    assert cut.acceleration_mm_s2 > 10_000
    assert not [one for one in result.diagnostics if one.code == "VIB076"]
    assert "no axis data" not in chipbreak.explain(result, profile).summary()
    with pytest.raises(chipbreak.ProgramRejectedError, match=r"the path has 20 m/s2") as caught:
        chipbreak.rewrite(
            program.encode(), chipbreak.load("klipper", ["planner.path_acceleration_mm_s2=20000"])
        )
    need = re.search(r"needs ([0-9.]+) m/s2", caught.value.diagnostics[-1].message)
    assert need
    enough = chipbreak.load("klipper", [f"planner.path_acceleration_mm_s2={float(need[1]) * 1000.0}"])
    assert chipbreak.rewrite(program.encode(), enough).cuts


def test_a_cut_that_leaves_hardly_any_acceleration() -> None:
    program = CUT.format(wish="N1.5", s="3000", f="0.05").encode()

    def shares(has: int, *more: str) -> list[str]:
        sets = ["planner.model=trapezoid", f"axes.Z.max_acceleration_mm_s2={has}", *more]
        return [one.message for one in chipbreak.check(program, chipbreak.load("generic-lathe", sets))]

    assert shares(5000) == ["this cut uses 96% of the acceleration that the profile gives Z"]
    assert shares(6000) == []
    for has in (4830, 4900, 5000):
        sets = ["planner.model=trapezoid", f"axes.Z.max_acceleration_mm_s2={has}"]
        (one,) = chipbreak.check(program, chipbreak.load("generic-lathe", sets))
        named = one.help.rsplit("set ", 1)[1].replace(" ", "")
        assert shares(has, named) == []
        assert shares(has, f"vibration.reserve={float(named.split('=')[1]) + 0.011}")


def test_of_many_such_cuts_one_warning_is_given() -> None:
    program = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG0 X30.\nZ2.\nX19.\nG1 Z-30. F0.05 N1.5\nM30\n"
    sets = ["planner.model=trapezoid", "axes.Z.max_acceleration_mm_s2=5000"]
    (one,) = chipbreak.check(program.encode(), chipbreak.load("generic-lathe", sets))
    assert one.code == "VIB090"
    assert one.message.startswith("this and one more cut use up to 96%")


def test_the_steps_of_one_block_are_told_of_once() -> None:
    face = "G50 S2500\nG96 S200 M3\nG0 X100. Z0.\n(VIB N1.5)\nG1 X10. F0.2\nM30\n"
    found = chipbreak.check(face.encode(), chipbreak.load("generic-lathe"))
    assert len({one.code for one in found}) == len(found)
    (load,) = [one for one in found if one.code == "VIB076"]
    cuts = chipbreak.rewrite(face.encode(), chipbreak.load("generic-lathe")).cuts
    needs = [cut.acceleration_mm_s2 for cut in cuts]
    assert len(needs) > 1
    assert f"need {max(needs) / 1000.0:.1f} m/s2" in load.message


@pytest.mark.parametrize("n", ["1.5", "auto"])
def test_what_no_machine_makes_stays_where_the_profile_asks(n: str) -> None:
    """A way to the work in G1 at 6 mm a revolution among cuts."""
    program = "G97 S500 M3\nG0 X20. Z400.\nG1 Z2. F6.\nZ-30. F0.1\nM30\n"
    sets = (f"vibration.n={n}", "axes.X.max_acceleration_mm_s2=5e8", "axes.Z.max_acceleration_mm_s2=5e8")
    result = chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe", sets))
    (cut,) = result.cuts
    assert cut.plan.wave.feed_mm_rev == pytest.approx(0.1)
    (left,) = [one for one in result.left if one.is_cut]
    assert left.said.code == "VIB077"
    assert chipbreak.restore(result.data) == program.encode()
