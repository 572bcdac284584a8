"""One value of a tool: the right kind, possible, in mm; or a ValueError that says what was expected."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from chipbreak.operations import kind_words as words
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.nearest import nearest

_NUMBER: Final = LazyPattern(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?")
LONGEST_NAME = 80  # characters that are kept of a name


class _Rule(NamedTuple):
    """``least`` itself is possible only where ``or_equal`` is set."""

    expected: str
    least: float
    most: float
    or_equal: bool = False
    is_whole: bool = False


_RULES: Final = {
    "number": _Rule("a whole number from 0 to 99999999", 0, 99_999_999, or_equal=True, is_whole=True),
    "teeth": _Rule("a whole number from 1 to 200", 0, 200, is_whole=True),
    "diameter_mm": _Rule("mm above 0, at most 2000", 0.0, 2000.0),
    "length_mm": _Rule("mm above 0, at most 2000", 0.0, 2000.0),
    "corner_radius_mm": _Rule("mm from 0 to 1000", 0.0, 1000.0, or_equal=True),
    "helix_deg": _Rule("degrees between -85 and 85", -85.0, 85.0, or_equal=True),
    "point_deg": _Rule("degrees above 0, at most 180", 0.0, 180.0),
    "holder_mm": _Rule("mm from 0 to 2000", 0.0, 2000.0, or_equal=True),
    "nose_tip": _Rule("a whole number from 0 to 9", 0, 9, or_equal=True, is_whole=True),
    "gauge_mm": _Rule("mm above 0, at most 4000", 0.0, 4000.0),
    # Of a traced edge.
    "tooth": _Rule("a whole number from 1 to 200", 0, 200, is_whole=True),
    "height_mm": _Rule("mm from -1000 to 1000", -1000.0, 1000.0, or_equal=True),
    "radius_mm": _Rule("mm from 0 (no contact) to 1000", 0.0, 1000.0, or_equal=True),
}

TYPES: Final = (
    *(name for name, _ in words.TOOL_TYPES),
    "boring head",
    "counter bore",
    "form mill",
    "lollipop mill",
    "radius mill",
    "tapered mill",
)
# How CAM systems name what our own list calls otherwise.
_ALIASES: Final = {
    "endmill": "flat end mill",
    "ballend": "ball end mill",
    "bullnose": "bull nose end mill",
    "chamfer": "chamfer mill",
    "v-bit": "chamfer mill",
    "vbit": "chamfer mill",
    "slittingsaw": "slot mill",
    "threadmill": "thread mill",
    "thread-mill": "thread mill",
    "dovetail": "dovetail mill",
    "radius": "radius mill",
    "fillet": "radius mill",
    "taperedballnose": "tapered mill",
    "turning general": "turning tool",
    "turning boring": "boring bar",
    "turning grooving": "grooving tool",
    "turning threading": "threading tool",
}


def number_of(field: str, value: Any) -> float | int:
    """A number of a field, from text or as a number, in the field's own unit."""
    rule = _RULES[field]
    shown = repr(value) if len(repr(value)) <= 40 else repr(value)[:39] + "…"
    wrong = ValueError(f"{field} = {shown} is not possible: expected {rule.expected}")
    if isinstance(value, str):
        if not _NUMBER.fullmatch(value.strip()):
            raise wrong
        number = float(value)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        # An integer may be too long for a float.
        number = float(value) if abs(value) < 1e12 else float("inf")
    else:
        raise wrong
    inside = rule.least <= number <= rule.most if rule.or_equal else rule.least < number <= rule.most
    if not inside or (rule.is_whole and number != int(number)):
        raise wrong
    return int(number) if rule.is_whole else number


def type_of(text: str) -> str | None:
    """The type that a CAM system's own word means, None where it is none of ours."""
    said = " ".join(text.lower().split())
    if said in TYPES:
        return said
    if said in _ALIASES:
        return _ALIASES[said]
    hit = words.TOOL_WORDS.search(said[:LONGEST_NAME])
    return words.TOOL_TYPES[int((hit.lastgroup or "t0")[1:])][0] if hit else None


def name_of(text: str) -> str | None:
    """A name without line ends and control characters, not too long; None for an empty one."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return " ".join(printable.split())[:LONGEST_NAME] or None


def hint_at(name: str, known: Iterable[str]) -> str:
    """A hint at the known name that was probably meant."""
    names = list(known)
    near = nearest(name.lower(), names, 0.5)
    return f"did you mean {near}?" if near else f"known: {', '.join(names)}"
