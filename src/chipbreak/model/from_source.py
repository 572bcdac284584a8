"""A program interpreted from its text, under the profile and under what the program shows of its control."""

from __future__ import annotations

from chipbreak.model.code_systems import shown_system
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.paths import work_spindles
from chipbreak.model.shown_points import shown_rule
from chipbreak.settings.sections import SHOWN, Settings, Shown
from chipbreak.syntax.parse import Program, parse
from chipbreak.text.source import Source


def interpret_source(source: Source, settings: Settings) -> InterpretedProgram:
    """Read and interpret; what the program shows of its control is looked for first."""
    program = parse(source, settings.dialect)
    if settings.shown == Shown():
        shown = _shown_by(program, settings)
        settings = settings.as_shown(shown)
        program = parse(source, settings.dialect) if shown.system else program
    return interpret(program, settings)


def _shown_by(program: Program, settings: Settings) -> Shown:
    """What a program shows: of numbers and code systems where the profile leaves that to it (``"shown"``)."""
    control = settings.control
    rule = shown_rule(program) if control.decimal_point == SHOWN else ""
    system = shown_system(program) if control.lathe_system == SHOWN else ""
    return Shown(rule, system, work_spindles(program))
