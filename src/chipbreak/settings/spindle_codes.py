"""M codes of the spindle that only the profile knows: every builder numbers his own."""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import MCode
from chipbreak.settings.checking import IMPOSSIBLE, Layer
from chipbreak.settings.sections import Spindle
from chipbreak.text.frozen_table import FrozenTable

_KEYS: Mapping[str, MCode] = FrozenTable(
    {
        "cw_codes": MCode("spindle", "cw", before_move=True),
        "ccw_codes": MCode("spindle", "ccw", before_move=True),
        "cw_flood_codes": MCode("spindle", "cw", before_move=True, coolant="flood"),
        "ccw_flood_codes": MCode("spindle", "ccw", before_move=True, coolant="flood"),
        "stop_codes": MCode("spindle", "stop"),
    }
)


def with_spindle_codes(layer: Layer, dialect: Dialect, spindle: Spindle) -> Dialect:
    """The dialect with the M codes that a profile gives to the spindle.

    Raises SettingsError for a code that has another meaning on this control, or is named twice.
    """
    codes: dict[int, MCode] = {}
    for key, code in _KEYS.items():
        for number in getattr(spindle, key):
            known = dialect.m_codes.get(number)
            if number in codes or (known is not None and known.group != "other_spindle"):
                what = "is named twice" if number in codes else "has a meaning of its own on this control"
                message = f"spindle.{key}: M{number} {what}"
                hint = "name codes that the builder of the machine has given to the spindle, each once"
                raise layer.fail(IMPOSSIBLE, f"spindle.{key}", message, hint)
            codes[number] = code
    return dialect._replace(m_codes=FrozenTable({**dialect.m_codes, **codes})) if codes else dialect
