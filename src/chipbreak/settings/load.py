"""Reads profiles: TOML files, shipped or the user's, and ``--set section.key=value``."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from chipbreak.dialects import Dialect, dialect_names, find
from chipbreak.dialects.modes import UNSAID
from chipbreak.settings.axis_words import AXES, AxisWords, axis_words
from chipbreak.settings.checking import (
    BACKSLASH,
    IMPOSSIBLE,
    UNKNOWN_KEY,
    UNREADABLE,
    WRONG_TYPE,
    Layer,
    SettingsError,
    checked_value,
    hint_at,
)
from chipbreak.settings.plug_ins import check_plug_ins
from chipbreak.settings.profile_files import profile_names, profile_text
from chipbreak.settings.ranges import check_filters, check_only, check_override, check_ranges, check_steps
from chipbreak.settings.sections import OPEN_SECTIONS, SECTIONS, Axis, Control, Planner, Settings
from chipbreak.settings.spindle_codes import with_spindle_codes
from chipbreak.settings.tool_rules import check_macros, check_sisters
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.span import Place
from chipbreak.trajectory.law_names import foreign_keys

_MOST_BASES = 20


def load(profile: str | os.PathLike[str], options: Sequence[str] = ()) -> Settings:
    """Settings of a profile with ``section.key=value`` options over it.

    A profile is the name of a shipped one, the path of a TOML file, or a name that an installed package
    offers.  It may name another as ``base``; its own keys win.  Raises SettingsError.
    """
    profile = os.fspath(profile)
    layers = list(_profile_layers(profile, set()))
    layers += [_option_layer(option) for option in options]
    values: dict[str, dict[str, Any]] = {name: {} for name in (*SECTIONS, *OPEN_SECTIONS)}
    origins: dict[str, str] = {}
    for layer in layers:
        _check_sections(layer)
        for section, table in layer.values.items():
            for key, given in table.items():
                value = checked_value(layer, section, key, given)
                if isinstance(value, dict):
                    value = {**values[section].get(key, {}), **value}
                values[section][key] = value
                origins[f"{section}.{key}"] = layer.origin(f"{section}.{key}")
    return _build(layers[-1], profile, values, origins)


def _build(
    layer: Layer, profile: str, values: dict[str, dict[str, Any]], origins: dict[str, str]
) -> Settings:
    sections = {name: cls(**_frozen(values[name])) for name, cls in SECTIONS.items()}
    axes = {axis: sections.pop(f"axes.{axis}") for axis in AXES}
    control = sections["control"]
    dialect = with_spindle_codes(layer, _dialect(layer, control), sections["spindle"])
    mode = sections["output"].feed_mode
    if not dialect.can("feed_mode", mode) and dialect.initial.feed_mode != mode:
        message = f"output.feed_mode {mode!r}: {dialect.title} has no code for it"
        others = [other for other in ("rev", "inverse", "minute") if dialect.can("feed_mode", other)]
        raise layer.fail(IMPOSSIBLE, "output.feed_mode", message, f"one of {', '.join(others)}")
    words = _axis_words(layer, axes, dialect, checks=sections["checks"].enabled)
    if sections["output"].form == "loop":
        _check_loop(layer, sections["output"].loop_variable, dialect, words)
    _check_law(layer, sections["planner"])
    sections["planner"] = _usual_modes(sections["planner"], dialect, origins)
    _check_modes(layer, sections["planner"], dialect)
    check_ranges(layer, sections["command"], sections["spindle"])
    check_only(layer, sections["vibration"])
    check_steps(layer, axes)
    check_override(layer, sections["planner"], dialect)
    check_filters(layer, axes)
    check_macros(layer, sections["macros"], dialect)
    check_sisters(layer, sections["checks"])
    check_plug_ins(layer, sections["passes"].extra, values["plugins"])
    return Settings(
        name=profile,
        call_sets=_frozen(values["calls"]),
        operations=_frozen(values["operations"]),
        plugins=_frozen(values["plugins"]),
        axes=FrozenTable(axes),
        axis_words=words,
        dialect=dialect,
        origins=FrozenTable(origins),
        **sections,
    )


def _dialect(layer: Layer, control: Control) -> Dialect:
    """The dialect that a profile names, with the profile's own dwell word."""
    try:
        dialect = find(control.dialect, control.lathe_system)
    except KeyError:
        message = f"control.dialect {control.dialect!r} is not known"
        known = f"one of {', '.join(dialect_names())}"
        raise layer.fail(IMPOSSIBLE, "control.dialect", message, known) from None
    except RefusalError as error:
        raise layer.fail(error.code, "control.dialect", error.message, error.help) from error
    if control.decimal_point not in dialect.number_rules:
        message = f"control.decimal_point {control.decimal_point!r}: {dialect.title} does not read numbers so"
        known = f"one of {', '.join(dialect.number_rules)}"
        raise layer.fail(IMPOSSIBLE, "control.decimal_point", message, known)
    return dialect._replace(dwell_word=control.dwell_word) if control.dwell_word else dialect


def _frozen(values: Mapping[str, Any]) -> FrozenTable[str, Any]:
    """Values of a section, with the tables among them."""
    return FrozenTable({k: FrozenTable(v) if isinstance(v, dict) else v for k, v in values.items()})


def _check_law(layer: Layer, planner: Planner) -> None:
    """Refuse a number that has no meaning for the law of this control."""
    for key, laws in foreign_keys(planner.model).items():
        if getattr(planner, key):
            names = " or ".join(f'"{law}"' for law in laws)
            message = f"planner.{key} has no place in planner.model {planner.model!r}"
            hint = f"planner.model = {names}, or leave it out"
            raise layer.fail(IMPOSSIBLE, f"planner.{key}", message, hint)


def _check_loop(layer: Layer, variable: int, dialect: Dialect, words: AxisWords) -> None:
    """Refuse loops where it is not known how, or without a counter or words for distances."""
    if dialect.loop is None:
        message = f"output.form 'loop': how {dialect.title} repeats blocks is not known"
        help_text = 'write form = "expanded", or name the control: fanuc-lathe, linuxcnc-lathe'
        raise layer.fail(IMPOSSIBLE, "output.form", message, help_text)
    there = dialect.loop.variables
    if there and not any(variable in numbers for numbers in there):
        message = f"output.loop_variable {variable}: {dialect.title} has no such variable"
        known = ", ".join(f"{numbers[0]} to {numbers[-1]}" for numbers in there)
        raise layer.fail(IMPOSSIBLE, "output.loop_variable", message, f"one of {known}")
    if dialect.can("distance", "incremental"):
        return
    for axis, letter in words.letters.items():
        if words.distance_letter(axis) is None:
            message = f"output.form 'loop': {letter} of {dialect.title} has no word for distances"
            help_text = f'write form = "expanded", or give axes.{axis}.letter one that has (X, Y or Z)'
            raise layer.fail(IMPOSSIBLE, "output.form", message, help_text)


def _axis_words(layer: Layer, axes: Mapping[str, Axis], dialect: Dialect, *, checks: bool) -> AxisWords:
    """The letters and signs of the axes, where the control can have them."""
    letters = {name: axis.letter or name for name, axis in axes.items()}
    for name in letters:
        _check_letter(layer, name, letters, dialect)
    if letters["X"] != "X" and dialect.can("diameter", "diameter"):
        message = f"axes.X.letter = {letters['X']!r}: G7 and G8 of {dialect.title} know X alone"
        raise layer.fail(IMPOSSIBLE, "axes.X.letter", message, "leave the letter of X as it is")
    words = axis_words(letters, {name: axis.sign for name, axis in axes.items()}, dialect.incremental)
    for text in dialect.machine_retract if checks else ():
        if words.renamed(text, dialect.incremental) is None:
            message = f"tool checks retract with {text}, for which these axis letters leave no word"
            raise layer.fail(IMPOSSIBLE, "checks.enabled", message, "checks.enabled = false")
    return words


def _check_letter(layer: Layer, name: str, letters: Mapping[str, str], dialect: Dialect) -> None:
    """The letter of an axis is one of the control's, and of no other axis."""
    key = f"axes.{name}.letter"
    letter = letters[name]
    if letter not in dialect.axis_letters:
        message = f"{key} = {letter!r}: {dialect.title} has another meaning for this letter"
        raise layer.fail(IMPOSSIBLE, key, message, f"one of {', '.join(dialect.axis_letters)}")
    other = next(axis for axis, one in letters.items() if one == letter)
    if other != name:
        message = f"{key} = {letter!r} is the letter of {other} too"
        way_out = f"give axes.{other}.letter or axes.{name}.letter another one"
        raise layer.fail(IMPOSSIBLE, key, message, way_out)


def _usual_modes(planner: Planner, dialect: Dialect, origins: Mapping[str, str]) -> Planner:
    """The planner without a usual path mode that nobody gave and that the control does not have."""
    is_given = "planner.usual_path_mode" in origins
    if is_given or _is_mode(planner.usual_path_mode, "path", dialect):
        return planner
    return replace(planner, usual_path_mode="")


def _check_modes(layer: Layer, planner: Planner, dialect: Dialect) -> None:
    """What is switched to around a vibrated cut, and what is given back, must be modes of this control."""
    for group, switched, given_back, example in (
        ("path", "path_mode", "usual_path_mode", 'for example "G61" or "G64 P0.01"'),
        ("look_ahead", "smoothing_off", "smoothing_on", 'for example "G5.1 Q0" and "G5.1 Q1"'),
    ):
        if not getattr(planner, switched):
            continue  # where nothing is switched, there is nothing to give back
        for key in (switched, given_back):
            text = getattr(planner, key)
            is_none = not text and key == "usual_path_mode" and dialect.initial.path == UNSAID
            # A control that is always in the one mode has none to be given back.
            if not (is_none or _is_mode(text, group, dialect)):
                message = f"planner.{key} = {text!r} is no such mode of {dialect.title}"
                known = _codes_of_group(group, dialect)
                help_text = f"it has {known}; {example}" if known else f"it has none: leave {switched} out"
                raise layer.fail(IMPOSSIBLE, f"planner.{key}", message, help_text)


def _codes_of_group(group: str, dialect: Dialect) -> str:
    """``G61, G61.1, G64``."""
    numbers = sorted(number for number, code in dialect.g_codes.items() if code.group == group)
    return ", ".join(f"G{number / 10:g}" for number in numbers)


def _is_mode(text: str, group: str, dialect: Dialect) -> bool:
    """``G61`` or ``G64 P0.01 Q0.005``, with a code that the dialect has in this group."""
    code = dialect.code_of(text)
    return code is not None and code.group == group


def _profile_layers(profile: str, seen: set[str]) -> Iterable[Layer]:
    name, text = profile_text(profile)
    try:
        values = tomllib.loads(text)
    except RecursionError:
        raise _too_deep(name) from None
    except ValueError as error:  # no TOML, or a number of thousands of digits
        where = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(where[1]), int(where[2])) if where else (1, 1)
        lines = text.split("\n")
        place = Place(name, line, column, column + 1)
        message = f"profile {name} is not TOML: {str(error).split(' (at', maxsplit=1)[0].lower()}"
        shown = lines[line - 1] if line <= len(lines) else ""
        hint = 'sections are [name], values are key = value, text stands in "quotes"'
        if "\\" in shown:
            hint = BACKSLASH
        raise SettingsError(Diagnostic(UNREADABLE, Severity.ERROR, message, hint, place, shown)) from None
    base = values.pop("base", None)
    layer = Layer(name, text, _flat(values))
    if base is not None:
        seen = seen | {_home(profile)}
        yield from _profile_layers(_base_of(layer, profile, base, seen), seen)
    yield layer


def _base_of(layer: Layer, profile: str, base: object, seen: set[str]) -> str:
    """The profile that another one names as its base; ``seen`` are those that led to it."""
    if len(seen) > _MOST_BASES:
        message = f"{len(seen)} bases of bases are too many"
        raise layer.fail(IMPOSSIBLE, "base", message, "name a profile")
    path = _beside(profile, base) if isinstance(base, str) else ""
    if not path or _home(path) in seen:
        raise layer.fail(IMPOSSIBLE, "base", f"base = {base!r} is not another profile", "name a profile")
    return path


def _beside(profile: str, base: str) -> str:
    """A shipped name, or a path that counts from the profile that says it."""
    return base if base in profile_names() else str(Path(profile).parent / base)


def _home(profile: str) -> str:
    """One name for one profile, however its path is written."""
    is_file = profile not in profile_names() and "\0" not in profile
    return os.path.realpath(profile) if is_file else profile


def _option_layer(option: str) -> Layer:
    key, equals, text = option.partition("=")
    section, dot, name = key.strip().partition(".")
    layer = Layer("--set", option, {})
    if not (equals and dot and name):
        message = f"--set {option} is not section.key=value"
        raise layer.fail(UNKNOWN_KEY, key, message, "for example --set vibration.margin=1.3")
    try:
        value = tomllib.loads(f"v = {text}")["v"]
    except RecursionError:
        raise _too_deep(f"--set {key}") from None
    except ValueError:  # no TOML, or a number of thousands of digits: then it is text
        value = text.strip()
    if "." in name:
        name, _, inner = name.partition(".")
        value = {inner: value}
    return Layer("--set", option, _flat({section: {name: value}}))


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """``[axes.X]`` is a section of its own."""
    flat = dict(values)
    axes = flat.pop("axes", {})
    tables = axes.items() if isinstance(axes, dict) else [("", axes)]
    return flat | {f"axes.{axis}": table for axis, table in tables}


def _check_sections(layer: Layer) -> None:
    for section, table in layer.values.items():
        if section not in SECTIONS and section not in OPEN_SECTIONS:
            known = [*SECTIONS, *OPEN_SECTIONS]
            message = f"there is no section [{section}]"
            raise layer.fail(UNKNOWN_KEY, section, message, hint_at(section, known))
        if not isinstance(table, dict):
            message = f"{section} is a section, not a value"
            raise layer.fail(WRONG_TYPE, section, message, f"write [{section}]")


def _too_deep(name: str) -> SettingsError:
    message = f"{name} is nested too deeply"
    return SettingsError(Diagnostic(UNREADABLE, Severity.ERROR, message, "no value needs that"))
