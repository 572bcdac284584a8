"""What a comment says: the kind of an operation, its title, a directive of ours, or a tool.

Text in, values out.  Text is a comment's inside as latin-1; Japanese in it is found whether the bytes are
Shift-JIS or UTF-8.  A kind that is missed costs only the stricter limit, a roughing that is none would
loosen it: ROUGH is read with the most care.
"""

from __future__ import annotations

import enum
import re
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

from chipbreak.operations import kind_words as words
from chipbreak.operations.linear_pattern import LinearPattern, TooDifficultError
from chipbreak.text.any_case import AnyCase, Hit
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.nearest import nearest
from chipbreak.units import MM_PER_INCH, mm_per_unit

UNKNOWN_KIND = "SET020"
UNUSABLE_EXPRESSION = "SET021"
MISSPELT_DIRECTIVE = "OPS001"

LONGEST_TEXT = 400  # characters; what follows belongs to a manual or a picture
LONGEST_NAME = 14  # words; more are a sentence even without a verb
LONGEST_TITLE = 10  # words
_CACHE = 4096
# So little "to leave" makes up for the cutter, and leaves nothing for another operation.
_HAIR_MM = 0.02


class Kind(enum.Enum):
    """What an operation does to the edge, as far as anybody said so."""

    ROUGH = "rough"
    SEMI_FINISH = "semi-finish"
    FINISH = "finish"
    DRILL = "drill"
    THREAD = "thread"
    PROBE = "probe"
    UNKNOWN = "unknown"


class KindFinding(NamedTuple):
    """A kind and the words it was read from; ``by_rule`` where a rule of the user's says it."""

    kind: Kind
    reason: str
    by_rule: bool = False


class OperationMark(NamedTuple):
    """A title of an operation (``is_start``), or the mark some CAM systems put after one."""

    is_start: bool
    label: str


class ToolNote(NamedTuple):
    """What a comment says about a tool; ``None`` where it says nothing.

    ``diameter`` and ``corner_radius`` are in the unit the text itself names, ``unit`` ("mm" or "in"); a
    ``unit`` of ``None`` means the units of the program, as CAM systems write them.  ``type`` uses the
    words of Fusion's tool library.
    """

    number: int | None
    diameter: float | None
    corner_radius: float | None
    taper_deg: float | None
    type: str | None
    text: str
    unit: str | None = None


class KindRules(NamedTuple):
    """The user's regular expressions per kind, tried in their order before the built-in words."""

    patterns: tuple[tuple[Kind, LinearPattern], ...] = ()

    @classmethod
    def from_profile(cls, rules: Mapping[str, Sequence[str]]) -> KindRules:
        """Compile ``{"rough": ["REGEX", …], …}``; upper and lower case are the same.

        Raises :class:`RefusalError` SET020 for a name that is no kind, SET021 for an expression that
        cannot be read or that matches every comment.
        """
        patterns: list[tuple[Kind, LinearPattern]] = []
        names = [kind.value for kind in Kind if kind is not Kind.UNKNOWN]
        for name, expressions in rules.items():
            if name not in names:
                message = f'operations: "{name}" is no kind of operation'
                raise RefusalError(UNKNOWN_KIND, message, f"kinds are {', '.join(names)}")
            if isinstance(expressions, str):  # a string is a sequence too, of single letters
                message = f"operations.{name} is one text"
                raise RefusalError(UNUSABLE_EXPRESSION, message, f'write a list: ["{expressions}"]')
            patterns.extend((Kind(name), _user_pattern(name, text)) for text in expressions)
        return cls(tuple(patterns))


def _user_pattern(name: str, text: str) -> LinearPattern:
    where = f'operations.{name}: "{text}"'
    try:
        pattern = LinearPattern(text)
    except TooDifficultError as error:
        raise RefusalError(
            UNUSABLE_EXPRESSION,
            f"{where} cannot be read: {error}",
            "see Python's re syntax, without (?= and alike and without \\1; a list may hold several",
        ) from error
    if pattern.search("") is not None:
        raise RefusalError(
            UNUSABLE_EXPRESSION, f"{where} matches every comment", "name a letter it must find"
        )
    return pattern


@lru_cache(maxsize=_CACHE)
def kind_of_text(text: str, rules: KindRules, unit_mm: float = MM_PER_INCH) -> KindFinding | None:
    """The kind a comment names, or ``None``; the user's rules first.

    ``unit_mm`` is what its lengths are in: mm per unit of the program.
    Finishing counts before roughing (its limit is the stricter one), both before drilling ("FINISH BORE").
    """
    readings = _readings(text[:LONGEST_TEXT])
    for kind, pattern in rules.patterns:
        for reading in readings:
            if (hit := pattern.search(reading)) is not None:
                source = f" (profile, operations.{kind.value})"
                return KindFinding(kind, _reason(hit, reading, source), by_rule=True)
    title = operation_title(text)
    if title is not None and not title.is_start:
        return None
    if by_stock := _kind_by_stock(readings[0], unit_mm):
        return by_stock
    if _is_prose_or_code(readings[0]):
        return None
    return next((found for reading in readings if (found := _built_in_kind(reading))), None)


def _kind_by_stock(reading: str, unit_mm: float) -> KindFinding | None:
    """By how much is left; a size in mm or inches beside it says which of them it is."""
    stock = max(words.STOCK_TO_LEAVE.finditer(reading), key=lambda said: float(said[1]), default=None)
    if stock is None:
        return None
    unit = _diameter(reading)[1]
    own_mm = mm_per_unit(is_inch=unit == "in") if unit else unit_mm
    kind = Kind.ROUGH if float(stock[1]) * own_mm > _HAIR_MM else Kind.FINISH
    return KindFinding(kind, _reason(stock.group(), reading))


# The first found of these wins, wherever it is; after them the first in the text.
_ORDER = (Kind.SEMI_FINISH, Kind.FINISH, Kind.ROUGH, Kind.PROBE)


def _cleared(reading: str) -> str:
    return words.FALSE_FRIENDS.sub(" ", reading)


def _built_in_kind(reading: str) -> KindFinding | None:
    found: dict[Kind, str] = {}  # in the order of the text
    for hit in words.KIND_WORDS.finditer(_cleared(reading)):
        found.setdefault(Kind[hit.lastgroup or "UNKNOWN"], hit.group())
    kind = next((kind for kind in (*_ORDER, *found) if kind in found), None)
    return KindFinding(kind, _reason(found[kind], reading)) if kind else None


def _reason(word: str, reading: str, source: str = "") -> str:
    shown = "".join(c if c.isprintable() else "?" for c in reading)
    if len(shown) > 80:
        shown = shown[:79] + "…"
    return f'"{word.strip()}" in the comment "{shown}"{source}'


@lru_cache(maxsize=_CACHE)
def _readings(text: str) -> tuple[str, ...]:
    """The text as people may have meant its bytes: UTF-8, or else latin-1 and Shift-JIS."""
    text = text.strip()
    if text.isascii() or max(text) > "\xff":  # nothing to guess, or decoded already
        return (text,)
    data = text.encode("latin-1")
    for encodings in (("utf-8",), ("latin-1", "cp932")):
        try:
            return tuple(data.decode(encoding) for encoding in encodings)
        except UnicodeDecodeError:
            continue
    return (text,)


def _is_prose_or_code(reading: str) -> bool:
    if words.ACTIVE_OR_CODE.search(reading):
        return True
    length = len(reading.split())
    return length > LONGEST_NAME or (length > 4 and words.PROSE_WORDS.search(reading) is not None)


@lru_cache(maxsize=_CACHE)
def operation_title(text: str) -> OperationMark | None:
    """The operation a comment starts or ends, or ``None`` when it is no title."""
    reading = _readings(text)[0].strip(" -*")
    if labelled := words.LABELLED.match(reading):
        label = next(value for value in labelled.groups() if value is not None)
        return OperationMark(labelled.lastgroup != "finish", label.strip())
    if not reading or len(reading.split()) > LONGEST_TITLE or _is_prose_or_code(reading):
        return None
    if words.STRATEGY_TITLE.match(reading):
        return OperationMark(True, reading)
    if words.NOT_A_TITLE.search(reading):
        return None
    if tool_text(text) is not None and not _names_work_first(reading):
        return None
    if words.HAND_TITLE.match(reading):
        return OperationMark(True, reading)
    readings = (other for other in _readings(text) if words.JAPANESE_KIND.search(_cleared(other)))
    return next((OperationMark(True, other) for other in readings), None)


def _names_work_first(reading: str) -> bool:
    """True for work that ends with the size and type of its tool: "FINISH WALLS WITH 3/8 E.M."."""
    tool = words.TOOL_WORDS.search(reading)
    size = words.SIZE.search(reading)
    if tool is None or size is None:
        return False
    head = reading[: min(tool.start(), size.start())]
    return words.WORK_BEFORE_TOOL.match(head) is not None


_DIRECTIVE = LazyPattern(r"^\s*OP\s+([A-Z]+(?:[\s-]+[A-Z]+)?)\s*$", re.IGNORECASE)
# "(OP ROUGH)" or "(OP ROUGHING)"
_DIRECTIVES = {
    word: kind
    for kind, value in ((kind, kind.value.replace("-", "")) for kind in Kind)
    for word in (value, value.rstrip("e") + "ing")
}


def directive(text: str) -> Kind | None:
    """The kind a directive ``(OP ROUGH)`` sets, or ``None`` for every other comment.

    Raises :class:`RefusalError` OPS001 when the word is nearly one of ours (``OP ROUHG``): the user meant
    a directive.  Anything else after OP ("OP 10", "OP STOP", "OP FACE") is an ordinary comment.
    """
    hit = _DIRECTIVE.match(text)
    if hit is None:
        return None
    word = re.sub(r"[\s-]+", "", hit[1]).lower()
    if word in _DIRECTIVES:
        return _DIRECTIVES[word]
    one_word = " " not in hit[1].strip() and word != "finished"  # "(OP FINISHED)" is news for the operator
    near = nearest(word, _DIRECTIVES, 0.75) if one_word else None
    if near:
        meant = _DIRECTIVES[near].value.upper()
        raise RefusalError(
            MISSPELT_DIRECTIVE,
            f'"{text.strip()}" is no kind of operation',
            f"write (OP {meant})",
            (f"(OP {meant})",),
        )
    return None


@lru_cache(maxsize=_CACHE)
def tool_text(text: str) -> ToolNote | None:
    """What a comment says about a tool, or ``None`` when it does not describe one."""
    reading = _readings(text)[0]
    if len(reading) > LONGEST_TEXT or words.ACTIVE_OR_CODE.search(reading):
        return None
    label = words.LABELLED.match(reading)
    if label and not words.TOOL_AHEAD.match(reading):
        return None  # the name of an operation, whatever tool it speaks of
    is_sentence = _is_prose_or_code(reading)
    for pattern, note_of in _POST_FORMS if is_sentence else (*_POST_FORMS, *_HAND_FORMS):
        if hit := pattern.match(reading):
            return note_of(hit, reading)
    return None if is_sentence else _unnumbered_tool(reading)


def _fusion_tool(hit: Hit, reading: str) -> ToolNote:
    said = hit["type"] or ""
    tool_type = _tool_type(said) or said.lower() or None
    return ToolNote(
        int(hit["n"]), float(hit["d"]), _number(hit["cr"]), _number(hit["taper"]), tool_type, reading
    )


def _mastercam_tool(hit: Hit, reading: str) -> ToolNote:
    return _described(int(hit["n"]), hit["name"], reading)


def _cambam_tool(hit: Hit, reading: str) -> ToolNote:
    return ToolNote(int(hit["n"]), float(hit["d"]), None, None, None, reading)


def _tool_fact(hit: Hit, reading: str) -> ToolNote:
    if hit["d"] or hit["cr"]:
        return ToolNote(None, _number(hit["d"]), _number(hit["cr"]), None, None, reading)
    return _described(None, hit["name"], reading)


def _tool_ahead(hit: Hit, reading: str) -> ToolNote | None:
    note = _described(None, hit["tool"], reading)
    return note if note.type or note.diameter else None


def _coppercam_tool(hit: Hit, reading: str) -> ToolNote:
    unit = hit["unit"] and ("mm" if hit["unit"].upper() == "MM" else "in")
    diameter = float(hit["d"].replace(",", "."))
    return ToolNote(int(hit["n"]), diameter, None, None, _tool_type(hit["name"]), hit["name"], unit)


def _cutviewer_tool(hit: Hit, reading: str) -> ToolNote:
    diameter = float(hit["d"])
    second = float(hit["second"])
    if not hit["mill"]:
        return ToolNote(None, diameter, None, second, "drill", reading)
    taper = _number(hit["taper"]) or None
    if taper:
        return ToolNote(None, diameter, second, taper, "tapered mill", reading)
    if not second:
        return ToolNote(None, diameter, second, None, "flat end mill", reading)
    kind = "ball end mill" if second * 2.0 >= diameter else "bull nose end mill"
    return ToolNote(None, diameter, second, None, kind, reading)


def _tool_number(hit: Hit, reading: str) -> ToolNote:
    return _described(int(hit["n"]), hit["rest"], reading)


def _hand_tool(hit: Hit, reading: str) -> ToolNote | None:
    digits = hit["n"].upper().replace("O", "0")
    # Four digits may be tool and offset: the caller knows its control.
    note = _described(int(digits) if len(digits) <= 3 else None, hit["rest"], reading)
    return note if note.type or note.diameter or note.corner_radius else None


_Form = tuple[AnyCase, Callable[[Hit, str], ToolNote | None]]
# The first form that a comment has decides what it says; those of posts may be as long as sentences.
_POST_FORMS: tuple[_Form, ...] = (
    (words.FUSION_TOOL, _fusion_tool),
    (words.MASTERCAM_TOOL, _mastercam_tool),
    (words.COPPERCAM_TOOL, _coppercam_tool),
    (words.CUTVIEWER_TOOL, _cutviewer_tool),
)
_HAND_FORMS: tuple[_Form, ...] = (
    (words.CAMBAM_TOOL, _cambam_tool),
    (words.TOOL_FACT, _tool_fact),
    (words.TOOL_AHEAD, _tool_ahead),
    (words.TOOL_NUMBER, _tool_number),
    (words.HAND_TOOL, _hand_tool),
)


def _unnumbered_tool(reading: str) -> ToolNote | None:
    """A tool without a number: a diameter and E.M., "5.75MM DRILL", "BORING BAR", "DRILL 1/4"."""
    if len(reading.split()) > LONGEST_TITLE:
        return None
    note = _described(None, reading, reading)
    if note.type in words.WORK_TOO:
        sure = words.TOOL_FOR_SURE.search(reading) or words.ONLY_A_SIZE.match(reading)
        return note if sure else None
    return note if note.type else None


def _described(number: int | None, name: str, whole: str) -> ToolNote:
    diameter, unit = _diameter(name)
    nose = words.SAID_NOSE.search(name)
    # A radius without a unit is in the unit of the program, which the text's own unit may not be.
    radius = _number(nose["before"] or nose["after"]) if nose and unit is None else None
    return ToolNote(number, diameter, radius, None, _tool_type(name), whole, unit)


def _diameter(name: str) -> tuple[float | None, str | None]:
    """The diameter and the unit the text names; a bare "6." in a tool's name may be either: nothing."""
    if hit := words.SAID_DIAMETER.search(name):
        return float(hit["d"]), None
    hit = words.SIZE.search(name)
    if hit is None:
        return None, None
    if hit["mm"]:
        return float(hit["mm"]), "mm"
    if hit["inch"]:
        return float(hit["inch"]), "in"
    *whole, fraction = re.split(r"[ -]", hit["frac"])
    top, bottom = (int(part) for part in fraction.split("/"))
    return (sum(map(int, whole)) + top / bottom, "in") if bottom else (None, None)


def _tool_type(name: str) -> str | None:
    hit = words.TOOL_WORDS.search(name)
    return words.TOOL_TYPES[int((hit.lastgroup or "t0")[1:])][0] if hit else None


def _number(text: str | None) -> float | None:
    return float(text) if text else None
