"""What the macros must know: the section [macros] of a profile, and the limits in [checks]."""

from __future__ import annotations

import dataclasses

from chipbreak.dialects.check_programs import BUILT_IN, SETTER
from chipbreak.settings.sections import Checks, Control, Macros, Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.units import MM_PER_INCH

NOT_SET = "MCR001"
# Names as they stand in a profile, with what people need to measure or look up for each.
_NEEDED = {
    "beam_x_mm": "machine X of the beam's focus",
    "beam_y_mm": "machine Y of the beam, which runs along X",
    "beam_z_mm": "machine Z of the spindle nose if it stood in the beam",
    "safe_z_mm": "machine Z where the longest tool is clear of everything",
    "master_length_mm": "from the spindle nose to the end of the master bar",
    "master_diameter_mm": "diameter of the master bar",
}
_SETTER = {
    "setter_x_mm": "machine X of the touch plate",
    "setter_y_mm": "machine Y of the touch plate",
    "setter_z_mm": "lowest machine Z of the spindle nose at which a tool must have met the plate",
    "safe_z_mm": _NEEDED["safe_z_mm"],
}


def missing_of(macros: Macros, calls: str = BUILT_IN) -> list[str]:
    """The keys of [macros] that a set of calls cannot do without and that have no value, in their order."""
    needed = {BUILT_IN: _NEEDED, SETTER: _SETTER}.get(calls, {})
    return [name for name in needed if getattr(macros, name) is None]


class UnsetError(RefusalError):
    """The settings lack something that nobody may guess."""


class MacroSettings(Macros):
    """All values that are written into the macros."""

    alarm_base: int = Checks.alarm_base
    retries: int = Checks.retries
    runout_mm: float = Checks.runout_mm
    length_over_mm: float = Checks.length_over_mm
    diameter_mm: float = Checks.diameter_mm
    trace_step_mm: float = Checks.trace_step_mm
    trace_chip_mm: float = Checks.trace_chip_mm
    increment_mm: float = Control.increment_mm

    @property
    def inch_step_mm(self) -> float:
        """What can be commanded in inches: a tenth of the number in mm [mm]."""
        return self.increment_mm / 10.0 * MM_PER_INCH

    @property
    def gap_s(self) -> float:
        """``gap_ms`` in seconds."""
        return self.gap_ms / 1000.0

    @classmethod
    def of(cls, settings: Settings) -> MacroSettings:
        """Those of a profile."""
        given = {
            field.name: getattr(section, field.name)
            for section in (settings.macros, settings.checks, settings.control)
            for field in dataclasses.fields(section)
        }
        return cls(**{field.name: given[field.name] for field in dataclasses.fields(cls)})

    def checked(self) -> MacroSettings:
        """These settings; raises UnsetError (MCR001) when something is missing that nobody may guess."""
        missing = missing_of(self) if missing_of(self, SETTER) else []
        if missing:
            lines = "; ".join(f"macros.{name}: {_NEEDED[name]}" for name in missing)
            raise UnsetError(NOT_SET, f"the macros need {len(missing)} more values", lines)
        return self
