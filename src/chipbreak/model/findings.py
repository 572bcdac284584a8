"""What is said of a program when it is read, whatever is asked of it."""

from __future__ import annotations

from collections.abc import Container, Iterator

from chipbreak.model.code_systems import codes_of_another_system
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.setting_lines import other_settings
from chipbreak.model.stops import stops
from chipbreak.model.units_of_feed import feeds_in_other_units
from chipbreak.model.unread_words import unread_words
from chipbreak.text.diagnostics import Diagnostic, Severity

COMPENSATED = "VIB040"  # where G41 and G42 stand in the way
MISSING_NUMBER = "MOD003"
NUMBER_THE_SHAPE = "number the first and the last block of the shape as P and Q say"


def findings(
    interpreted: InterpretedProgram, without_contour: Container[int] = frozenset()
) -> list[Diagnostic]:
    """All warnings, by kind, and errors for what the control would stop at.

    That a cycle in a line of ``without_contour`` has no contour is said elsewhere.
    """
    return [
        *interpreted.program.unreadable(),
        *unread_words(interpreted),
        *feeds_in_other_units(interpreted),
        *(one for line, one in missing_numbers(interpreted) if line not in without_contour),
        *other_settings(interpreted),
        *codes_of_another_system(interpreted),
        *stops(interpreted),
    ]


def missing_numbers(interpreted: InterpretedProgram) -> Iterator[tuple[int, Diagnostic]]:
    """A line and a warning for every shape of a cycle of which an end is not there."""
    for one in interpreted.flow.missing:
        yield (
            one.line,
            interpreted.program.diagnose(
                one.line, MISSING_NUMBER, one.message, NUMBER_THE_SHAPE, severity=Severity.WARNING
            ),
        )
