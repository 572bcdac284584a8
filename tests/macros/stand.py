"""A test stand: the Fanuc macros in the project's interpreter, in front of the simulated laser."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from chipbreak.dialects import FANUC_MILL, MacroSet
from chipbreak.dialects.check_programs import MACRO_B
from chipbreak.macros import MacroSettings, ToolValues, macro_files
from chipbreak.syntax.numbers import print_number
from laser_simulator.barrier import Beam, Station
from laser_simulator.tool import Kind, SimulatedTool
from macro_interpreter import FANUC_0I_F, FanucControl, Interpreter, Library, Machine, Outcome

BEAM = Beam(x_mm=120.0, y_mm=-35.0, z_mm=-400.0)
BAR = SimulatedTool(Kind.BAR, diameter_mm=20.0, length_mm=150.0, holder_mm=0.0)
BAR_NUMBER = 90
SETTINGS = MacroSettings(
    beam_x_mm=BEAM.x_mm,
    beam_y_mm=BEAM.y_mm + 0.3,  # as well as somebody measured it: CALIBRATE must find the rest
    beam_z_mm=BEAM.z_mm - 0.5,
    safe_z_mm=0.0,
    master_length_mm=BAR.length_mm,
    master_diameter_mm=BAR.diameter_mm,
    master_tool=BAR_NUMBER,
    trace_step_mm=2.0,
    gap_ms=15.0,
    gap_on="M75",
    gap_off="M76",
)
KINDS = {Kind.FLAT: 1, Kind.BALL: 2, Kind.DRILL: 3, Kind.REAMER: 4}
ALARMS = {
    0: "", 100: "CALL", 101: "RUNOUT", 102: "SHORT", 103: "LONG", 104: "THIN", 105: "THICK", 106: "CHIP",
    107: "NO CONTACT", 108: "BEAM", 109: "NOT CALIBRATED", 110: "NO EDGE", 111: "NO ROOM", 112: "MODES",
    113: "ENTRY", 114: "LOCKED", 115: "NOT THE BAR", 116: "NOT AS STORED",
}  # fmt: skip


@cache
def library(settings: MacroSettings) -> Library:
    return Library(macro_files(FANUC_MILL, settings).values())


@dataclass(frozen=True)
class Nominal:
    """What CAM says about a tool."""

    kind: Kind = Kind.FLAT
    diameter_mm: float = 10.0
    tip: float = 0.0  # corner radius, or the point angle of a drill
    length_mm: float = 50.0
    holder_mm: float = 80.0
    teeth: int = 4
    helix_deg: float = 0.0

    def real(self, **changes: object) -> SimulatedTool:
        """A tool as it should be, 1 mm longer than CAM asks, clamped at any angle."""
        made = SimulatedTool(
            kind=self.kind,
            diameter_mm=self.diameter_mm,
            length_mm=self.length_mm + 1.0,
            teeth=self.teeth,
            corner_mm=self.tip if self.kind is not Kind.DRILL else 0.0,
            helix_deg=self.helix_deg,
            point_deg=(self.tip or 118.0) if self.kind is Kind.DRILL else 118.0,
            holder_mm=self.holder_mm,
            phase_deg=37.3,
        )
        return replace(made, **changes)  # type: ignore[arg-type]

    def data(self, number: int, macros: MacroSet = MACRO_B) -> str:
        """The blocks that hand it to the macros."""
        values = ToolValues(
            number, KINDS[self.kind], self.diameter_mm, self.tip, self.length_mm, self.holder_mm,
            self.teeth, self.helix_deg,
        )  # fmt: skip
        return "\n".join(values.blocks(macros))


FLAT_OK = Nominal()


class Stand:
    """A machine with a magazine; tool 1 is the one under test."""

    def __init__(
        self,
        nominal: Nominal,
        real: SimulatedTool,
        *,
        settings: MacroSettings = SETTINGS,
        beam: Beam = BEAM,
        control: FanucControl = FANUC_0I_F,
        is_inch: bool = False,
        rpm: int = 5000,
        reads_ahead: bool = True,
        programs: Library | None = None,
    ) -> None:
        self.nominal, self.rpm = nominal, rpm
        self.station = Station(beam, {1: real, BAR_NUMBER: BAR})
        self.machine = Machine(self.station, at=(10.0, 20.0, 0.0), control=control, reads_ahead=reads_ahead)
        self.machine.work_mm = (-200.0, -150.0, -300.0)
        settings = replace(settings, increment_mm=control.increment_mm)
        self.control = Interpreter(programs or library(settings), self.machine)
        self.unit_mm = 25.4 if is_inch else 1.0
        if is_inch:
            self.control.run("G20")

    def run(self, text: str) -> str:
        """Run blocks; the name of the alarm, empty when there was none."""
        outcome = self.outcome(text)
        assert not self.machine.crossings, f"the beam was broken by another move at {self.machine.crossings}"
        return ALARMS[outcome.alarm]

    def outcome(self, text: str) -> Outcome:
        return self.control.run(text)

    def calibrate(self) -> None:
        assert self.run("T90 M6\nG65 P8900") == ""

    def check_alone(self) -> str:
        """Tool change and TOOL CHECK."""
        return self.run(f"T1 M6\n{self.nominal.data(1)}\nG65 P8901 T1. S{self.rpm}.")

    def trace(self, height: float = 20.0) -> str:
        height_in_units = self._number(height)
        return self.run(f"{self.nominal.data(1)}\nG65 P8902 T1. Z{height_in_units} S{self.rpm}.")

    def chip_check(self, limit: float, depth: int = 1) -> str:
        return self.run(f"G65 P8903 T1. W{self._number(limit)} D{depth}.")

    def _number(self, length_mm: float) -> str:
        """A length as the filter writes it, in units of the program."""
        return print_number(length_mm / self.unit_mm, 6)

    def seconds(self, text: str) -> float:
        """How long blocks take; they must not alarm."""
        begin = self.machine.clock_s
        assert self.run(text) == ""
        return self.machine.clock_s - begin

    def stored(self) -> tuple[np.ndarray, np.ndarray]:
        """Heights (n,) and radii (n, teeth) of the first record, in mm."""
        commons = self.control.variables.commons
        first = self.control.variables.commons[145]
        assert first is not None
        at = int(first) + 4
        steps, height, teeth = (float(commons[at + n] or 0.0) for n in (10, 11, 6))
        heights = 0.1 + (height - 0.1) * np.linspace(0.0, 1.0, int(steps) + 1) ** 2
        count = len(heights) * int(teeth)
        differs = np.array([commons[at + 12 + n] for n in range(count)], np.float64)
        profile = self.nominal.real().profile(heights)
        return heights, differs.reshape(len(heights), -1) + profile[:, np.newaxis]

    def change(self, real: SimulatedTool) -> None:
        """Something happens to the tool."""
        self.station.tools[1] = real
