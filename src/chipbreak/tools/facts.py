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
# The designation of an insert ends with its corner: "CNMG 12 04 08", "DCMT 11T304" (ISO 1832, tenths of a
# millimetre), "CNMG432" (ANSI B212.4, 1/64 in), and "VBMT R0.4" by hand.
_INSERT: Final = r"\b[ACDEHKLMOPSTVW][A-GNOP][A-HJ-NU][AFGHJMNQRTUWX]"
_METRIC_INSERT: Final = AnyCase(rf"{_INSERT}[\s-]?\d\d[\s-]?(?:\d\d|T\d)[\s-]?(?P<corner>\d\d)(?![\d.])")
_INCH_INSERT: Final = AnyCase(rf"{_INSERT}[\s-]?\d\d(?:\.5)?(?P<corner>\d(?:\.5)?)(?![\d.])")
_NOSE_OF_INSERT: Final = AnyCase(rf"{_INSERT}\s+R{_LENGTH}")
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
    """The nose radius of a turning tool, as a comment names it, or the designation of its insert."""
    text = text[:LONGEST_TEXT]
    return _length(_NOSE.search(text) or _NOSE_BEHIND.search(text)) or _corner_of_insert(text)


def _corner_of_insert(text: str) -> Length | None:
    by_hand = _length(_NOSE_OF_INSERT.search(text))
    if by_hand is not None:
        return by_hand
    metric = _METRIC_INSERT.search(text)
    inch = _INCH_INSERT.search(text)
    found = Length(float(metric["corner"]) / 10.0, "mm") if metric else None
    if found is None and inch is not None:
        found = Length(float(inch["corner"]) / 64.0, "in")
    return found if found is not None and found.value > 0.0 else None


def tip_said(text: str) -> int | None:
    """The tip number of a turning tool's nose, as a comment names it."""
    hit = _TIP.search(text[:LONGEST_TEXT])
    return int(hit["tip"]) if hit else None


def _length(hit: Hit | None) -> Length | None:
    if hit is None or not float(hit["length"]) > 0.0:
        return None
    unit = (hit["unit"] or "").lower()
    return Length(float(hit["length"]), ("mm" if unit == "mm" else "in") if unit else None)
