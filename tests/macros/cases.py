"""Tools, each with at most one fault, and what every check must say; for both sets of macros."""

from __future__ import annotations

from dataclasses import dataclass, replace

from chipbreak.macros import MacroSettings
from laser_simulator.barrier import Beam
from laser_simulator.tool import Chip, Kind, SimulatedTool

from .stand import BEAM, SETTINGS, Nominal

FLAT = Nominal(helix_deg=30.0)
STRAIGHT = Nominal()
BULL = Nominal(tip=1.0, teeth=3, helix_deg=35.0)
BALL = Nominal(Kind.BALL, teeth=2, helix_deg=20.0)
DRILL = Nominal(Kind.DRILL, diameter_mm=8.0, tip=140.0, teeth=2, helix_deg=30.0)
REAMER = Nominal(Kind.REAMER, diameter_mm=8.0, teeth=6)
ONE_FLUTE = Nominal(diameter_mm=6.0, teeth=1, helix_deg=25.0)

ROUGH_W, FINISH_W = 0.05, 0.02
PHASE = 37.3  # the first edge of a tool of ``Nominal.real``


@dataclass(frozen=True)
class Case:
    """One tool at TOOL CHECK, and where ``later`` is given, TRACE and then CHIP CHECK of what became of it.

    ``expected`` is the alarm of TOOL CHECK; ``rough`` and ``finish`` those of CHIP CHECK with either limit.
    ``wide_runout``: the limit of the runout check is 1 mm, so that a thick tool gets past it.
    """

    name: str
    nominal: Nominal
    real: SimulatedTool
    expected: str = ""
    later: SimulatedTool | None = None
    rough: str = ""
    finish: str = ""
    is_blocked: bool = False
    wide_runout: bool = False

    @property
    def beam(self) -> Beam:
        return replace(BEAM, is_blocked=self.is_blocked)

    @property
    def settings(self) -> MacroSettings:
        return replace(SETTINGS, runout_mm=1.0) if self.wide_runout else SETTINGS


def _length(extra_mm: float, expected: str = "") -> Case:
    name = f"length L{extra_mm:+.3f}"
    return Case(name, FLAT, FLAT.real(length_mm=50.0 + extra_mm, dish_mm=0.1), expected)


def _runout(runout_mm: float, expected: str = "") -> Case:
    real = STRAIGHT.real(runout_mm=runout_mm, runout_deg=PHASE)
    return Case(f"runout {runout_mm:.3f}", STRAIGHT, real, expected)


def _diameter(extra_mm: float, expected: str = "", *, wide_runout: bool = False) -> Case:
    name = f"diameter OD{extra_mm:+.3f}" + (" with a wide runout limit" if wide_runout else "")
    real = STRAIGHT.real(diameter_mm=10.0 + extra_mm)
    return Case(name, STRAIGHT, real, expected, wide_runout=wide_runout)


def _chip(
    name: str, nominal: Nominal, chip: Chip | None, rough: str = "", finish: str = "", **changes: float
) -> Case:
    real = nominal.real()
    later = nominal.real(chips=(chip,) if chip else (), **changes)
    return Case(f"chip: {name}", nominal, real, later=later, rough=rough, finish=finish)


CHECKS = [
    Case("good flat end mill", FLAT, FLAT.real(dish_mm=0.1)),
    Case("good bull nose", BULL, BULL.real(dish_mm=0.1)),
    Case("good ball", BALL, BALL.real()),
    Case("good drill", DRILL, DRILL.real()),
    Case("good reamer", REAMER, REAMER.real()),
    Case("good single flute", ONE_FLUTE, ONE_FLUTE.real()),
    _runout(0.005),
    _runout(0.006, "RUNOUT"),
    _length(-0.001, "SHORT"),
    _length(0.0, "SHORT"),
    _length(0.001),
    _length(3.0),
    _length(3.001, "LONG"),
    # A machine that counts micrometres tells radii by whole ones.
    _diameter(-0.5, "THIN"),
    _diameter(-0.498),
    # Half a millimetre thicker is a quarter more than the runout check lets pass, and that comes first.
    _diameter(0.5, "RUNOUT"),
    _diameter(0.5, "THICK", wide_runout=True),
    _diameter(0.498, wide_runout=True),
    Case("ball, exactly L", BALL, BALL.real(length_mm=50.0), "SHORT"),
    Case("ball, a little longer", BALL, BALL.real(length_mm=50.001)),
    Case("ball, runout", BALL, BALL.real(diameter_mm=10.02), "RUNOUT"),
    Case("drill, exactly L", DRILL, DRILL.real(length_mm=50.0), "SHORT"),
    Case("drill, a little longer", DRILL, DRILL.real(length_mm=50.001)),
    Case("drill, too long", DRILL, DRILL.real(length_mm=53.001), "LONG"),
    Case("wrong tool, thinner", FLAT, FLAT.real(diameter_mm=6.0), "THIN"),
    Case("wrong tool, thicker", FLAT, FLAT.real(diameter_mm=16.0), "RUNOUT"),
    Case("wrong tool, longer", FLAT, FLAT.real(length_mm=90.0), "LONG"),
    Case("broken off", FLAT, FLAT.real(length_mm=30.0), "NO CONTACT"),
    Case("missing tool", FLAT, FLAT.real(is_missing=True), "NO CONTACT"),
    Case("beam blocked", FLAT, FLAT.real(), "BEAM", is_blocked=True),
]
CHIPS = [
    _chip("none", BULL, None),
    _chip("0.03 on one of four", STRAIGHT, Chip(1, 5.0, 0.03, 2.2), finish="CHIP"),
    _chip("0.03 on a helix", FLAT, Chip(0, 3.0, 0.03, 2.2), finish="CHIP"),
    _chip("exactly 0.02", STRAIGHT, Chip(3, 8.0, 0.02, 2.2), finish="CHIP"),
    _chip("0.019", STRAIGHT, Chip(3, 8.0, 0.019, 2.2)),
    _chip("exactly 0.05", STRAIGHT, Chip(3, 8.0, 0.05, 2.2), rough="CHIP", finish="CHIP"),
    _chip("0.049", STRAIGHT, Chip(3, 8.0, 0.049, 2.2), finish="CHIP"),
    _chip("tooth 3 at 12 mm", FLAT, Chip(2, 12.0, 0.08, 2.2), rough="CHIP", finish="CHIP"),
    _chip("at the top", FLAT, Chip(1, 19.9, 0.03, 2.2), finish="CHIP"),
    _chip("at the lower end", FLAT, Chip(1, 0.3, 0.03, 2.2), finish="CHIP"),
    _chip("on a ball", BALL, Chip(1, 2.0, 0.03, 2.2), finish="CHIP"),
    _chip("too small on a ball", BALL, Chip(1, 2.0, 0.018, 2.2)),
    _chip("on a bull nose", BULL, Chip(2, 4.0, 0.03, 2.2), finish="CHIP"),
    _chip("on a drill", DRILL, Chip(1, 6.0, 0.03, 2.2), finish="CHIP"),
    _chip("on a reamer", REAMER, Chip(5, 10.0, 0.03, 2.2), finish="CHIP"),
    _chip("shortened by 0.03", FLAT, None, finish="CHIP", length_mm=50.97),
    _chip("shortened by 0.019", FLAT, None, length_mm=50.981),
    _chip("broken off", FLAT, None, rough="NO CONTACT", finish="NO CONTACT", length_mm=35.0),
]
CASES = CHECKS + CHIPS
# Each much like another.
WITH_A_TWIN = {
    *("good bull nose", "diameter OD-0.498", "ball, runout"),
    *("drill, too long", "wrong tool, longer", "broken off"),
    *("diameter OD+0.498 with a wide runout limit", "good single flute", "good reamer"),
    *("chip: none", "chip: 0.03 on a helix", "chip: exactly 0.05", "chip: 0.049", "chip: at the top"),
    *("chip: at the lower end", "chip: too small on a ball", "chip: on a bull nose", "chip: on a reamer"),
    *("chip: shortened by 0.019", "chip: on a drill"),
}


def verdict_table() -> str:
    """The table of ``docs/measured-tools.md``."""
    rows = [
        "| tool | TOOL CHECK | CHIP CHECK, rough next | CHIP CHECK, finish next |",
        "| --- | --- | --- | --- |",
    ]
    for case in CASES:
        if case.later is None:
            rows.append(f"| {case.name} | {case.expected or 'passes'} | | |")
        else:
            rows.append(f"| {case.name} | | {case.rough or 'passes'} | {case.finish or 'passes'} |")
    return "\n".join(rows)
