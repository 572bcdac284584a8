"""What is said of a program when it is read, whatever is asked of it."""

from __future__ import annotations

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.setting_lines import other_settings
from chipbreak.model.stops import stops
from chipbreak.model.units_of_feed import feeds_in_other_units
from chipbreak.model.unread_words import unread_words
from chipbreak.text.diagnostics import Diagnostic, Severity

MISSING_NUMBER = "MOD003"


def findings(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """All warnings, by kind, and errors for what the control would stop at."""
    return [
        *interpreted.program.unreadable(),
        *unread_words(interpreted),
        *feeds_in_other_units(interpreted),
        *missing_numbers(interpreted),
        *other_settings(interpreted),
        *stops(interpreted),
    ]


def missing_numbers(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """A warning for every shape of a cycle of which an end is not there."""
    return [
        interpreted.program.diagnose(
            one.line,
            MISSING_NUMBER,
            f"this cycle looks for N{one.number} ({one.letter}{one.number}), and no block has that number",
            "number the first and the last block of the shape as P and Q say",
            severity=Severity.WARNING,
        )
        for one in interpreted.flow.missing
    ]
