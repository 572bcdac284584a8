"""Values of a profile: the right type, possible, under a key that exists; or an error with its line."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

from chipbreak.settings.key_places import find_key
from chipbreak.settings.sections import OPEN_SECTIONS, SECTIONS
from chipbreak.text.diagnostics import ChipbreakError, Diagnostic, RefusalError, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.nearest import nearest
from chipbreak.text.span import Place

UNKNOWN_KEY = "SET001"
WRONG_TYPE = "SET002"
IMPOSSIBLE = "SET003"
UNREADABLE = "SET004"
UNKNOWN_PROFILE = "SET005"
BACKSLASH = (
    "in double quotes a \\ begins an escape: write 'C:\\tools.csv' in single quotes, or \"C:/tools.csv\""
)


# No machine has a value nearer to zero or larger; arithmetic with them would leave the numbers.
_SMALLEST = 1e-9
_LARGEST = 1e12


class SettingsError(ChipbreakError):
    """A profile or an option that cannot be used; ``diagnostic`` says why and where."""

    __module__ = "chipbreak"

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic)
        self.diagnostic = diagnostic

    @classmethod
    def of(cls, error: RefusalError, profile: str) -> SettingsError:
        """A rule or a call of a profile that was refused when it was used."""
        message = f"{profile}: {error.message}"
        return cls(Diagnostic(error.code, Severity.ERROR, message, error.help))

    def __str__(self) -> str:
        return self.diagnostic.message


class Layer(NamedTuple):
    """One source of values: a file's text, or an option."""

    name: str
    text: str
    values: Mapping[str, Any]

    def fail(self, code: str, key: str, message: str, help_text: str) -> SettingsError:
        """The error of one key, at its place in the text."""
        found = find_key(self.text, key)
        place = Place(self.name, found.line, found.start + 1, found.end + 1)
        return SettingsError(Diagnostic(code, Severity.ERROR, message, help_text, place, found.text))

    def origin(self, key: str) -> str:
        """Where a value came from, for messages."""
        line = find_key(self.text, key).line
        return self.name if self.name.startswith("--") else f"profile {self.name}, line {line}"


def checked_value(layer: Layer, section: str, key: str, value: Any) -> Any:
    """The value in its final type, or a SettingsError that names the key and what is possible."""
    full = f"{section}.{key}"
    if section in OPEN_SECTIONS:
        return _checked_open(layer, section, key, value)
    fields = {f.name: f for f in dataclasses.fields(SECTIONS[section])}
    if key not in fields:
        raise layer.fail(UNKNOWN_KEY, full, f"there is no key {full}", hint_at(key, fields))
    hints = _hints(section)
    meta = fields[key].metadata
    if meta.get("table"):
        return _checked_table(layer, full, value, typing.get_args(hints[key])[1], meta)
    kinds = _kinds(hints[key])
    if tuple in kinds:
        items = value if isinstance(value, list) else [value]
        inner = typing.get_args(next(a for a in _options(hints[key]) if typing.get_origin(a) is tuple))[0]
        return tuple(_checked_value(layer, full, item, (inner,), meta) for item in items)
    return _checked_value(layer, full, value, kinds, meta)


@cache
def _hints(section: str) -> Mapping[str, Any]:
    """The types of the keys of a section."""
    return typing.get_type_hints(SECTIONS[section])


def _checked_table(
    layer: Layer, full: str, value: Any, kind: type, meta: Mapping[str, Any]
) -> dict[str, Any]:
    """A table with a line for each tool: number -> value."""
    if not isinstance(value, dict):
        raise layer.fail(WRONG_TYPE, full, f"{full} is a table", f"write [{full}] with a line for each")
    for tool in value:
        if not tool.isdecimal():
            message = f"{full}: {tool!r} is no tool number"
            raise layer.fail(IMPOSSIBLE, f"{full}.{tool}", message, "one line a tool, such as 4 = ...")
    return {k: _checked_value(layer, f"{full}.{k}", v, (kind,), meta) for k, v in value.items()}


def _options(hint: Any) -> tuple[Any, ...]:
    return typing.get_args(hint) if typing.get_origin(hint) in (typing.Union, types.UnionType) else (hint,)


def _kinds(hint: Any) -> tuple[type, ...]:
    return tuple(typing.get_origin(option) or option for option in _options(hint))


def _checked_value(
    layer: Layer, full: str, value: Any, kinds: tuple[type, ...], meta: Mapping[str, Any]
) -> Any:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if float in kinds and number:
        value = _as_float(value)
    elif type(value) not in kinds:
        raise layer.fail(WRONG_TYPE, full, f"{full} = {value!r} is of the wrong type", _expected(kinds, meta))
    fits = True
    if isinstance(value, str):
        fits = "choices" not in meta or value in meta["choices"]
    elif number:
        fits = (
            ("above" not in meta or value >= meta["above"] + _SMALLEST)
            and ("below" not in meta or value < meta["below"])
            and ("at_least" not in meta or value >= meta["at_least"])
            and ("at_most" not in meta or value <= meta["at_most"])
            and ("values" not in meta or value in meta["values"])
            and abs(value) <= _LARGEST
        )
    if not fits:
        raise layer.fail(IMPOSSIBLE, full, f"{full} = {value!r} is not possible", _expected(kinds, meta))
    return value


def _as_float(number: float) -> float:
    try:
        return float(number)
    except OverflowError:  # of more than 308 digits
        return -math.inf if number < 0 else math.inf


def _checked_open(layer: Layer, section: str, key: str, value: Any) -> Any:
    return _OPEN[section](layer, f"{section}.{key}", value)


def _expressions(layer: Layer, full: str, value: Any) -> tuple[str, ...]:
    expressions = [value] if isinstance(value, str) else value
    if not _is_texts(expressions):
        raise layer.fail(WRONG_TYPE, full, f"{full} is not a list of regular expressions", '["ROUGH.*"]')
    return tuple(expressions)


def _call_set(layer: Layer, full: str, value: Any) -> dict[str, tuple[str, ...]]:
    if not isinstance(value, dict):
        raise layer.fail(WRONG_TYPE, full, f"{full} is a table of calls", f"write [{full}]")
    calls = {}
    for name, given in value.items():
        blocks = [given] if isinstance(given, str) else given
        if not _is_texts(blocks):
            message = f"{full}.{name} is not a list of blocks"
            raise layer.fail(WRONG_TYPE, f"{full}.{name}", message, '["G65 ..."]')
        calls[name] = tuple(blocks)
    return calls


def _is_texts(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(one, str) for one in value)


def _plug_in_options(layer: Layer, full: str, value: Any) -> dict[str, Any]:
    """What a pass of another package reads is its own business."""
    if not isinstance(value, dict):
        raise layer.fail(WRONG_TYPE, full, f"{full} is a table of options", f"write [{full}]")
    return value


_OPEN: Mapping[str, Callable[[Layer, str, Any], Any]] = {
    "operations": _expressions,
    "calls": _call_set,
    "plugins": _plug_in_options,
}


def _expected(kinds: tuple[type, ...], meta: Mapping[str, Any]) -> str:
    parts = []
    if "choices" in meta or "values" in meta:
        parts.append("one of " + ", ".join(map(str, meta.get("choices") or meta["values"])))
    if (float in kinds or int in kinds) and "values" not in meta:
        parts.append("a whole number" if float not in kinds else "a number")
        limits = [("above", "above"), ("at_least", "of at least"), ("below", "below"), ("at_most", "up to")]
        parts[-1] += "".join(f" {word} {meta[name]:g}" for name, word in limits if name in meta)
    if bool in kinds:
        parts.append("true or false")
    if str in kinds and "choices" not in meta:
        parts.append("text")
    return "expected " + ", or ".join(parts)


def hint_at(key: str, known: Iterable[str]) -> str:
    """A hint at the known name that was probably meant."""
    names = list(known)
    near = nearest(key, names, 0.5)
    return f"did you mean {near}?" if near else f"known: {', '.join(names)}"
