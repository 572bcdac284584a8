"""Reads profiles: TOML files, shipped or the user's, and ``--set section.key=value``."""

from __future__ import annotations

import dataclasses
import difflib
import re
import tomllib
import types
import typing
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from chipbreak.diagnostics import Diagnostic, Severity
from chipbreak.dialects import DIALECTS, find
from chipbreak.settings.sections import OPEN_SECTIONS, SECTIONS, Settings
from chipbreak.span import Place

UNKNOWN_KEY, WRONG_TYPE, IMPOSSIBLE = "SET001", "SET002", "SET003"
UNREADABLE, UNKNOWN_PROFILE = "SET004", "SET005"


class SettingsError(Exception):
    """A profile or an option that cannot be used; ``diagnostic`` says why and where."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


@dataclass(frozen=True)
class _Layer:
    """One source of values: a file's text, or an option."""

    name: str
    text: str
    values: Mapping[str, Any]

    def fail(self, code: str, key: str, message: str, help_text: str) -> SettingsError:
        line, start, end, shown = _find_key(self.text, key)
        place = Place(self.name, line, start + 1, end + 1)
        return SettingsError(Diagnostic(code, Severity.ERROR, message, help_text, place, shown))

    def origin(self, key: str) -> str:
        line = _find_key(self.text, key)[0]
        return self.name if self.name.startswith("--") else f"profile {self.name}, line {line}"


def profile_names() -> list[str]:
    """The shipped profiles."""
    folder = resources.files("chipbreak") / "profiles"
    return sorted(p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml"))


def profile_text(profile: str) -> tuple[str, str]:
    """Name and text of a profile: a shipped name, or the path of a TOML file.

    Raises SettingsError when there is neither.
    """
    if profile in profile_names():
        text = (resources.files("chipbreak") / "profiles" / f"{profile}.toml").read_text("utf-8")
        return profile, text
    path = Path(profile)
    if path.suffix != ".toml" and not path.is_file():
        near = difflib.get_close_matches(profile, profile_names(), 1)
        hint = f"did you mean {near[0]}? " if near else ""
        message = f"there is no profile {profile!r}"
        known = f"{hint}shipped: {', '.join(profile_names())}; or give the path of a TOML file"
        raise SettingsError(Diagnostic(UNKNOWN_PROFILE, Severity.ERROR, message, known))
    try:
        return profile, path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        message = f"profile {profile} cannot be read: {_os_reason(error)}"
        help_text = "check the path; a profile is a TOML file in UTF-8"
        raise SettingsError(Diagnostic(UNREADABLE, Severity.ERROR, message, help_text)) from None


def load(profile: str, options: Sequence[str] = ()) -> Settings:
    """Settings of a profile with ``section.key=value`` options over it.

    A profile may name another as ``base``; its own keys win.  Raises SettingsError.
    """
    layers = list(_profile_layers(profile, set()))
    layers += [_option_layer(option) for option in options]
    values: dict[str, dict[str, Any]] = {name: {} for name in (*SECTIONS, *OPEN_SECTIONS)}
    origins: dict[str, str] = {}
    for layer in layers:
        _check_sections(layer)
        for section, table in layer.values.items():
            for key, value in table.items():
                values[section][key] = _checked(layer, section, key, value)
                origins[f"{section}.{key}"] = layer.origin(f"{section}.{key}")
    return _build(layers[-1], profile, values, origins)


def _build(
    layer: _Layer, profile: str, values: dict[str, dict[str, Any]], origins: dict[str, str]
) -> Settings:
    sections = {name: cls(**values[name]) for name, cls in SECTIONS.items()}
    control = sections["control"]
    try:
        dialect = find(control.dialect, control.lathe_system)
    except KeyError:
        names = sorted({d.name for d in DIALECTS})
        message = f"control.dialect {control.dialect!r} is not known"
        raise layer.fail(IMPOSSIBLE, "control.dialect", message, f"one of {', '.join(names)}") from None
    return Settings(
        name=profile,
        call_sets=values["calls"],
        operations=values["operations"],
        dialect=dialect,
        origins=origins,
        **sections,
    )


def _profile_layers(profile: str, seen: set[str]) -> Iterable[_Layer]:
    name, text = profile_text(profile)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        where = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(where[1]), int(where[2])) if where else (1, 1)
        lines = text.split("\n")
        place = Place(name, line, column, column + 1)
        message = f"profile {name} is not TOML: {str(error).split(' (at', maxsplit=1)[0].lower()}"
        shown = lines[line - 1] if line <= len(lines) else ""
        hint = 'sections are [name], values are key = value, text stands in "quotes"'
        raise SettingsError(Diagnostic(UNREADABLE, Severity.ERROR, message, hint, place, shown)) from None
    layer = _Layer(name, text, values)
    base = values.pop("base", None)
    if base is not None:
        if not isinstance(base, str) or base in seen:
            raise layer.fail(IMPOSSIBLE, "base", f"base = {base!r} is not another profile", "name a profile")
        yield from _profile_layers(base, seen | {profile})
    yield layer


def _option_layer(option: str) -> _Layer:
    key, equals, text = option.partition("=")
    section, dot, name = key.strip().partition(".")
    layer = _Layer("--set", option, {})
    if not (equals and dot and name):
        message = f"--set {option} is not section.key=value"
        raise layer.fail(UNKNOWN_KEY, key, message, "for example --set vibration.margin=1.3")
    try:
        value = tomllib.loads(f"v = {text}")["v"]
    except tomllib.TOMLDecodeError:
        value = text.strip()
    if "." in name:
        name, _, inner = name.partition(".")
        value = {inner: value}
    return _Layer("--set", option, {section: {name: value}})


def _check_sections(layer: _Layer) -> None:
    for section, table in layer.values.items():
        if section not in SECTIONS and section not in OPEN_SECTIONS:
            known = [*SECTIONS, *OPEN_SECTIONS]
            message = f"there is no section [{section}]"
            raise layer.fail(UNKNOWN_KEY, section, message, _nearest(section, known))
        if not isinstance(table, dict):
            message = f"{section} is a section, not a value"
            raise layer.fail(WRONG_TYPE, section, message, f"write [{section}]")


def _checked(layer: _Layer, section: str, key: str, value: Any) -> Any:
    """The value in its final type, or a SettingsError that names the key and what is possible."""
    full = f"{section}.{key}"
    if section in OPEN_SECTIONS:
        return _checked_open(layer, section, key, value)
    fields = {f.name: f for f in dataclasses.fields(SECTIONS[section])}
    if key not in fields:
        raise layer.fail(UNKNOWN_KEY, full, f"there is no key {full}", _nearest(key, fields))
    hints = typing.get_type_hints(SECTIONS[section])
    meta = fields[key].metadata
    if meta.get("table"):
        if not isinstance(value, dict):
            raise layer.fail(WRONG_TYPE, full, f"{full} is a table", f"write [{full}] with a line for each")
        return {k: _checked_value(layer, full, v, (float,), meta) for k, v in value.items()}
    kinds = _kinds(hints[key])
    if tuple in kinds:
        items = value if isinstance(value, list) else [value]
        inner = typing.get_args(next(a for a in _options(hints[key]) if typing.get_origin(a) is tuple))[0]
        return tuple(_checked_value(layer, full, item, (inner,), meta) for item in items)
    return _checked_value(layer, full, value, kinds, meta)


def _options(hint: Any) -> tuple[Any, ...]:
    return typing.get_args(hint) if typing.get_origin(hint) in (typing.Union, types.UnionType) else (hint,)


def _kinds(hint: Any) -> tuple[type, ...]:
    return tuple(typing.get_origin(option) or option for option in _options(hint))


def _checked_value(
    layer: _Layer, full: str, value: Any, kinds: tuple[type, ...], meta: Mapping[str, Any]
) -> Any:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if float in kinds and number:
        value = float(value)
    elif type(value) not in kinds:
        raise layer.fail(WRONG_TYPE, full, f"{full} = {value!r} is of the wrong type", _expected(kinds, meta))
    fits = True
    if isinstance(value, str):
        fits = "choices" not in meta or value in meta["choices"]
    elif number:
        fits = (
            ("above" not in meta or value > meta["above"])
            and ("below" not in meta or value < meta["below"])
            and ("at_least" not in meta or value >= meta["at_least"])
            and abs(value) < float("inf")
        )
    if not fits:
        raise layer.fail(IMPOSSIBLE, full, f"{full} = {value!r} is not possible", _expected(kinds, meta))
    return value


def _checked_open(layer: _Layer, section: str, key: str, value: Any) -> Any:
    full = f"{section}.{key}"
    if section == "operations":
        if isinstance(value, str):
            value = [value]
        if not (isinstance(value, list) and all(isinstance(v, str) for v in value)):
            raise layer.fail(WRONG_TYPE, full, f"{full} is not a list of regular expressions", '["ROUGH.*"]')
        return tuple(value)
    if not isinstance(value, dict):
        raise layer.fail(WRONG_TYPE, full, f"{full} is a table of calls", f"write [{full}]")
    calls = {}
    for name, given in value.items():
        lines = [given] if isinstance(given, str) else given
        if not (isinstance(lines, list) and all(isinstance(line, str) for line in lines)):
            message = f"{full}.{name} is not a list of blocks"
            raise layer.fail(WRONG_TYPE, f"{full}.{name}", message, '["G65 ..."]')
        calls[name] = tuple(lines)
    return calls


def _expected(kinds: tuple[type, ...], meta: Mapping[str, Any]) -> str:
    parts = []
    if "choices" in meta:
        parts.append("one of " + ", ".join(meta["choices"]))
    if float in kinds or int in kinds:
        parts.append("a whole number" if float not in kinds else "a number")
        limits = [("above", "above"), ("at_least", "of at least"), ("below", "below")]
        parts[-1] += "".join(f" {word} {meta[name]:g}" for name, word in limits if name in meta)
    if bool in kinds:
        parts.append("true or false")
    if str in kinds and "choices" not in meta:
        parts.append("text")
    return "expected " + ", or ".join(parts)


def _nearest(key: str, known: Iterable[str]) -> str:
    names = list(known)
    near = difflib.get_close_matches(key, names, 1, 0.5)
    return f"did you mean {near[0]}?" if near else f"known: {', '.join(names)}"


def _find_key(text: str, key: str) -> tuple[int, int, int, str]:
    """Line (from 1), first and last column (from 0) and text of a key in TOML text."""
    section, _, name = key.rpartition(".")
    inside = not section
    fallback = (1, 0, 1, text.split("\n", 1)[0])
    for number, line in enumerate(text.split("\n"), 1):
        header = re.match(r"\s*\[\s*([^\]]+?)\s*\]", line)
        if header:
            inside = header[1] == section
            if header[1] == key:
                return number, header.start(1), header.end(1), line
            if inside:
                fallback = (number, header.start(1), header.end(1), line)
        elif inside or "." in line:
            match = re.match(rf"\s*({re.escape(name)}|{re.escape(key)})\s*=", line)
            if match:
                return number, match.start(1), match.end(1), line
    return fallback


def _os_reason(error: Exception) -> str:
    return (error.strerror or str(error)) if isinstance(error, OSError) else "it is not UTF-8 text"
