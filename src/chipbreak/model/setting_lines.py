"""Lines that set the control up (``$120=500``), beside what the profile says of the same."""

from __future__ import annotations

import re
from math import isclose
from typing import Any

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import Diagnostic, Severity

OTHER_SETTING = "MOD011"
_SETTING = re.compile(r"\s*\$(\d+)\s*=\s*(-?\d*\.?\d+)")


def other_settings(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """A warning for every setting that the profile has otherwise, or not at all."""
    keys = interpreted.settings.dialect.settings
    if not keys:
        return []
    found = []
    for block in interpreted.program.event_blocks():
        match = _SETTING.match(block.text)
        key = keys.get(int(match[1])) if match else None
        if match is None or key is None:
            continue
        has = _value(interpreted.settings, key)
        if has is not None and isclose(has, float(match[2]), rel_tol=1e-6, abs_tol=1e-9):
            continue
        has_text = "does not say it" if has is None else f"has {has:g}"
        message = f"${match[1]} sets {match[2]}, and the profile {has_text} ({key}), by which cuts are judged"
        help_text = f"give {key} = {float(match[2]):g} in the profile"
        at = (match.start(1) - 1, match.end())
        found.append(
            interpreted.program.diagnose(
                block.line, OTHER_SETTING, message, help_text, at=at, severity=Severity.WARNING
            )
        )
    return found


def _value(settings: Settings, key: str) -> float | None:
    section, _, name = key.rpartition(".")
    table: Any = settings.axes[section[-1]] if section.startswith("axes.") else getattr(settings, section)
    value: float | None = getattr(table, name)
    return value
