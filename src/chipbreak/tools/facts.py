"""Facts about a tool that comments say beside its type and diameter: edges, stick-out."""

from __future__ import annotations

from typing import Final

from chipbreak.operations.kinds import LONGEST_TEXT
from chipbreak.text.any_case import AnyCase, Hit
from chipbreak.text.named_tuple import NamedTuple

_DECIMAL: Final = r"\d+(?:\.\d*)?|\.\d+"
# "4 FLUTE", "2-Flute", "3FL", "Number of Flutes: 4"
_TEETH: Final = AnyCase(
    r"(?<![\w./-])(?P<before>\d{1,2})[\s-]*(?:FLUTES?|FLTS?|FL)\b\.?(?!\s*[:=])"
    r"|\b(?:(?:NUMBER|NO\.?)\s+OF\s+(?:FLUTES|TEETH)|FLUTES)\s*[:=]\s*(?P<after>\d{1,2})\b"
)
_LENGTH: Final = rf"\s*[:=]?\s*(?P<length>{_DECIMAL})\s*(?P<unit>MM\b|\"|IN\b|INCH\b)?(?![\w.])"
# "STICKOUT/OVERHANG: 42", "STICK-OUT = 1.5 IN", "OVERHANG 30MM"
_STICK_OUT: Final = AnyCase(rf"\b(?:STICK[\s-]?OUT|OVERHANG)(?:/(?:STICK[\s-]?OUT|OVERHANG))?{_LENGTH}")
_HOLDER: Final = AnyCase(rf"\bHOLDER\s+LENGTH{_LENGTH}")
# "NOSE R0.8", "TNR .8", "NOSE RADIUS = 0.8 MM"; "TIP 3", "TIP NO. 3", "TIP DIRECTION: 3"
_NOSE: Final = AnyCase(
    rf"\b(?:TNR|NOSE(?:\s+RAD(?:IUS)?\.?)?|(?:INSERT|TIP)\s+RAD(?:IUS)?\.?)\s*[:=]?\s*R?{_LENGTH}"
)
# ".031TNR", "0.8 MM NOSE RADIUS", '.030" NR'
_NOSE_BEHIND: Final = AnyCase(
    rf"(?<![\w.])(?P<length>{_DECIMAL})\s*(?P<unit>MM\b|\"|IN\b)?\s*(?:TNR|NR|NOSE\s+RAD(?:IUS)?)\b"
)
_TIP: Final = AnyCase(
    r"\bTIP(?:\s+(?:NO\.?|NUMBER|DIRECTION|ORIENTATION))?\s*[:=#]?\s*T?(?P<tip>\d)(?![\d.])"
)


class Length(NamedTuple):
    """A number, and its unit ("mm", "in") or None for the unit of the program."""

    value: float
    unit: str | None


def teeth_said(text: str) -> int | None:
    """The number of edges that a comment names."""
    hit = _TEETH.search(text[:LONGEST_TEXT])
    count = int(hit["before"] or hit["after"]) if hit else 0
    return count or None


def stick_out_said(text: str) -> Length | None:
    """How far the tool sticks out of its holder, as a comment names it."""
    return _length(_STICK_OUT.search(text[:LONGEST_TEXT]))


def holder_said(text: str) -> Length | None:
    """How long the holder is, as a comment names it."""
    return _length(_HOLDER.search(text[:LONGEST_TEXT]))


def nose_said(text: str) -> Length | None:
    """The nose radius of a turning tool, as a comment names it."""
    return _length(_NOSE.search(text[:LONGEST_TEXT]) or _NOSE_BEHIND.search(text[:LONGEST_TEXT]))


def tip_said(text: str) -> int | None:
    """The tip number of a turning tool's nose, as a comment names it."""
    hit = _TIP.search(text[:LONGEST_TEXT])
    return int(hit["tip"]) if hit else None


def _length(hit: Hit | None) -> Length | None:
    if hit is None or not float(hit["length"]) > 0.0:
        return None
    unit = (hit["unit"] or "").lower()
    return Length(float(hit["length"]), ("mm" if unit == "mm" else "in") if unit else None)
