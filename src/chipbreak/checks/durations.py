"""About how long a check takes with the built-in macros: turns of the tool, stops of the spindle, touches.

Fitted to the interpreter that runs the macros on a machine with rapids of 24 m/min and a spindle that starts
and stops in 0.6 s and is oriented in 0.4 s; it comes within a fifth there.  Another machine has times of
its own, but the ratios stay.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from chipbreak.checks.calls import DEPTHS, CallValues, CheckKind
from chipbreak.settings.sections import Settings
from chipbreak.units import S_PER_MIN

_CALIBRATE_S: Final = 15.0
_BREAKAGE_S, _BREAKAGE_TURNS = 2.0, 5.0
_TOOL_CHECK_S, _TOOL_CHECK_TOOTH_S, _TOOL_CHECK_TURNS = 22.0, 2.2, 73.0
_LENGTH_S = 5.0
_TRACE_S, _TRACE_TOUCH_S, _TRACE_TURNS = 20.0, 1.27, 36.0
_STANDING_EDGE_S: Final = 0.8
_SCAN_S: Final = 2.0
# The limit line is followed by so much of the shortest chip a turn, standing teeth in such steps of it.
_SCAN_SHARE, _STEP_SHARE = 0.8, 0.9
_FEWEST_TEETH: Final = 4  # where nobody has said how many there are
_FEWEST_RPM: Final = 1000.0
# What is offered where checks take long.
_GAP_MS: Final = 15.0
_LOW_MM: Final = 5.0


def check_s(kind: CheckKind, values: CallValues, settings: Settings) -> float:
    """About how long a check takes [s]."""
    return _RULES[kind](values, settings)


def otherwise_s(kind: CheckKind, values: CallValues, settings: Settings) -> tuple[tuple[str, float], ...]:
    """Settings that can make checks shorter, as they are written, with the time of this one by each [s]."""
    gap = replace(settings, macros=replace(settings.macros, gap_ms=settings.macros.gap_ms or _GAP_MS))
    height_mm = values.height_mm and min(values.height_mm, _LOW_MM)
    low = values._replace(height_mm=height_mm)
    # Where the length alone counts, no edge is stored.
    stored_mm = 0.0 if kind is CheckKind.TRACE else values.height_mm
    length = values._replace(depth=DEPTHS.index("breakage"), height_mm=stored_mm)
    return (
        (f"macros.gap_ms={_GAP_MS:g} and a barrier that notices a missing edge", check_s(kind, values, gap)),
        (f"checks.trace_height_mm={_LOW_MM:g}, where no tool cuts higher", check_s(kind, low, settings)),
        ("checks.depth=breakage, which looks at the length alone", check_s(kind, length, settings)),
    )


def _turns_s(values: CallValues, turns: float) -> float:
    return turns * S_PER_MIN / (values.speed_rpm or _FEWEST_RPM)


def _teeth(values: CallValues) -> int:
    return (values.data.teeth if values.data else None) or _FEWEST_TEETH


def _calibrate_s(values: CallValues, settings: Settings) -> float:
    return _CALIBRATE_S


def _tool_check_s(values: CallValues, settings: Settings) -> float:
    return _TOOL_CHECK_S + _TOOL_CHECK_TOOTH_S * _teeth(values) + _turns_s(values, _TOOL_CHECK_TURNS)


def _trace_s(values: CallValues, settings: Settings) -> float:
    height_mm = values.height_mm or 0.0
    # Where not every workpiece is checked, what the last one has stored is compared with first.
    compared_s = _chip_check_s(values, settings) if values.every > 1 else 0.0
    if not height_mm:
        return compared_s + _LENGTH_S + _turns_s(values, _TRACE_TURNS)
    heights = math.ceil(height_mm / settings.checks.trace_step_mm) + 1
    return compared_s + _TRACE_S + _TRACE_TOUCH_S * _teeth(values) * heights + _turns_s(values, _TRACE_TURNS)


def _chip_check_s(values: CallValues, settings: Settings) -> float:
    length_s = _BREAKAGE_S + _turns_s(values, _BREAKAGE_TURNS)
    if values.depth == DEPTHS.index("breakage"):
        return length_s
    chips = (values.height_mm or 0.0) / settings.checks.trace_chip_mm
    if values.depth == DEPTHS.index("limit-line") and settings.macros.gap_ms:
        turn_s = _teeth(values) * settings.macros.gap_ms / 1000.0 / 1.3
        return length_s + _SCAN_S + chips / _SCAN_SHARE * turn_s
    return length_s + _SCAN_S + _STANDING_EDGE_S * _teeth(values) * (chips / _STEP_SHARE + 1.0)


_RULES: Final[Mapping[CheckKind, Callable[[CallValues, Settings], float]]] = {
    CheckKind.CALIBRATE: _calibrate_s,
    CheckKind.TOOL_CHECK: _tool_check_s,
    CheckKind.TRACE: _trace_s,
    CheckKind.CHIP_CHECK: _chip_check_s,
}
