"""A program interpreted from its text, under the profile and under what the program shows of its control."""

from __future__ import annotations

from chipbreak.model.code_systems import shown_system
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.shown_points import shown_rule
from chipbreak.settings.sections import SHOWN, Settings, Shown
from chipbreak.syntax.parse import parse
from chipbreak.text.source import Source


def interpret_source(source: Source, settings: Settings) -> InterpretedProgram:
    """Read and interpret; what the profile leaves to the program (``"shown"``) is looked for first."""
    control = settings.control
    program = parse(source, settings.dialect)
    if SHOWN in (control.decimal_point, control.lathe_system) and settings.shown == Shown():
        rule = shown_rule(program) if control.decimal_point == SHOWN else ""
        system = shown_system(program) if control.lathe_system == SHOWN else ""
        settings = settings.as_shown(Shown(rule, system))
        program = parse(source, settings.dialect) if system else program
    return interpret(program, settings)
