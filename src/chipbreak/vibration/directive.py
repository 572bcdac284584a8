"""The comment that asks for vibration: ``(VIB N1.5 Q1.4)``, modal until ``(VIB OFF)`` or the next tool."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.kinematics.wave_names import WAVE_NAMES
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.nearest import nearest

WAVE_WORDS = tuple(map(str.upper, WAVE_NAMES))
# What each key means, for messages and the manual.
KEYS = {
    "S": "spindle speed [rpm]",
    "N": "vibrations per revolution",
    "E": "revolutions per vibration",
    "F": "frequency [Hz]",
    "Q": "stroke / feed per revolution",
    "A": "stroke [mm]",
    "K": "ramp exponent",
    "ALPHA": "forward share",
    "RAMP": "ramp length [vibrations]",
    "EDGES": "cutting edges",
    "WAVE": f"{', '.join(WAVE_WORDS[:-1])} or {WAVE_WORDS[-1]}",
}
# What AUTO chooses.
_CHOSEN = "SNEF"
_PECK_OFF = LazyPattern(r"\bPECK\s*=?\s*OFF\b[\s,]*")
_AUTO = LazyPattern(r"AUTO(?![A-Z])[\s,]*")
_DIRECTIVE = LazyPattern(r"\s*VIB(?:[\s,]+(.*?))?\s*$", re.IGNORECASE | re.DOTALL)
_VALUE = rf"{'|'.join(WAVE_WORDS)}|[-+]?(?:\d+\.?\d*|\.\d+)"
_ITEM = LazyPattern(rf"\s*([A-Z]+?)\s*(?:=\s*)?({_VALUE})(?=[\s,A-Z]|$)[\s,]*")


class Directive(NamedTuple):
    """What one directive says; ``on`` is False for ``(VIB OFF)``, ``auto`` True for ``(VIB AUTO)``.

    ``peck_off``: cycles that break chips by pecks are written out without them.
    """

    on: bool
    values: Mapping[str, SourcedValue] = FrozenTable({})
    waveform: str = ""
    auto: bool = False
    peck_off: bool = False


def read_directive(text: str, line_number: int) -> Directive | None:
    """Read a comment's text; None when it is no directive.

    ``(VIB)`` and ``(VIB ON)`` ask for vibration with the profile's values, ``(VIB AUTO)`` for N, f and S that
    the machine chooses.  Errors: VIB014 for a key or a
    value that cannot be read.
    """
    match = _DIRECTIVE.match(text)
    if match is None:
        return None
    rest = (match[1] or "").upper()
    peck_off = _PECK_OFF.search(rest) is not None
    rest = _PECK_OFF.sub("", rest).strip() if peck_off else rest
    if rest in ("", "ON"):
        return Directive(True, peck_off=peck_off)
    if rest == "OFF":
        return Directive(False)
    is_auto = _AUTO.match(rest)
    rest = rest[is_auto.end() :] if is_auto else rest
    said: dict[str, str] = {}
    for key, value in _items(rest):
        if key in said:
            raise RefusalError("VIB014", f"the directive gives {key} twice", "give each key once")
        if is_auto and key in _CHOSEN:
            message = f"AUTO lets the machine choose N, f and S, and the directive gives {key} too"
            raise RefusalError("VIB014", message, f"take {key} out, or AUTO")
        said[key] = value
    waveform = said.pop("WAVE", "").lower()
    origin = f"directive, line {line_number}"
    values = {key: SourcedValue(float(value), origin) for key, value in said.items()}
    return Directive(True, values, waveform, auto=bool(is_auto), peck_off=peck_off)


def _items(text: str) -> Iterator[tuple[str, str]]:
    """Keys and values in order.  Errors: VIB014 at the first that is none."""
    at = 0
    while at < len(text):
        item = _ITEM.match(text, at)
        key = item[1] if item else ""
        if item is None or key not in KEYS or (key == "WAVE") != (item[2] in WAVE_WORDS):
            rest = text[at:]
            raise _unreadable(rest.split()[0] if rest.split() else text, key)
        yield key, item[2]
        at = item.end()


def _unreadable(found: str, key: str) -> RefusalError:
    if found in KEYS:
        needed = KEYS["WAVE"] if found == "WAVE" else f"a number: {KEYS[found]}"
        return RefusalError("VIB014", f"{found} has no value that can be read", f"{found} needs {needed}")
    near = nearest(key or found, KEYS)
    hint = f"did you mean {near}? " if near and near != key else ""
    known = "; ".join(f"{name} {meaning}" for name, meaning in KEYS.items())
    message = f"the directive says {found!r}, which cannot be read"
    return RefusalError("VIB014", message, f"{hint}keys: {known}; or (VIB AUTO), (VIB OFF)")
