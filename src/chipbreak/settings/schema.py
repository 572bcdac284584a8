"""The JSON Schema of profiles, made of the settings: editors complete and check TOML by it."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from typing import Any

from chipbreak.settings.profile_files import profile_names
from chipbreak.settings.sections import OPEN_SECTIONS, SECTIONS

_DRAFT = "https://json-schema.org/draft/2020-12/schema"
_TYPES: Mapping[Any, str] = {str: "string", int: "integer", float: "number", bool: "boolean"}
_OPEN: Mapping[str, Any] = {
    "operations": {"type": ["string", "array"], "items": {"type": "string"}},
    "calls": {
        "type": "object",
        "additionalProperties": {"type": ["string", "array"], "items": {"type": "string"}},
    },
    "plugins": {"type": "object"},
}


def schema_of_profiles() -> dict[str, Any]:
    """The schema of a profile, with the default of every key."""
    properties: dict[str, Any] = {
        "base": {
            "type": "string",
            "description": "A shipped profile or a file whose values hold where this one says nothing.",
            "examples": list(profile_names()),
        }
    }
    for name, section in SECTIONS.items():
        parent, _, child = name.partition(".")
        if not child:
            properties[name] = _section(section)
            continue
        axes = properties.setdefault(
            parent, {"type": "object", "additionalProperties": False, "properties": {}}
        )
        axes["properties"][child] = _section(section)
    properties |= {name: {"type": "object", "additionalProperties": _OPEN[name]} for name in OPEN_SECTIONS}
    return {
        "$schema": _DRAFT,
        "title": "Machine profile of chipbreak",
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


def _section(section: type[Any]) -> dict[str, Any]:
    hints = typing.get_type_hints(section)
    keys = {field.name: _key(field, hints[field.name]) for field in dataclasses.fields(section)}
    told = (section.__doc__ or "").split("\n\n")[0]
    return {
        "type": "object",
        "description": " ".join(told.replace("``", "").split()),
        "additionalProperties": False,
        "properties": keys,
    }


def _key(field: dataclasses.Field[Any], hint: Any) -> dict[str, Any]:
    schema = _value(hint, field.metadata)
    if field.default is not dataclasses.MISSING and field.default is not None:
        schema["default"] = list(field.default) if isinstance(field.default, tuple) else field.default
    return schema


def _value(hint: Any, limits: Mapping[str, Any]) -> dict[str, Any]:
    """What a key may be: one of several kinds, each with its limits."""
    options = typing.get_args(hint) if typing.get_origin(hint) in (typing.Union, types.UnionType) else (hint,)
    kinds = [_kind(option, limits) for option in options if option is not type(None)]
    return kinds[0] if len(kinds) == 1 else {"anyOf": kinds}


def _kind(hint: Any, limits: Mapping[str, Any]) -> dict[str, Any]:
    if typing.get_origin(hint) is tuple:
        one = _kind(typing.get_args(hint)[0], limits)
        return {"anyOf": [one, {"type": "array", "items": one}]}
    if limits.get("table"):
        return {
            "type": "object",
            "additionalProperties": _kind(typing.get_args(hint)[1], {**limits, "table": 0}),
        }
    schema: dict[str, Any] = {"type": _TYPES[hint]}
    if hint is str:
        return {"enum": list(limits["choices"])} if "choices" in limits else schema
    if hint is bool:
        return schema
    if "values" in limits:
        return {"enum": list(limits["values"])}
    names = {
        "above": "exclusiveMinimum",
        "below": "exclusiveMaximum",
        "at_least": "minimum",
        "at_most": "maximum",
    }
    return schema | {word: limits[name] for name, word in names.items() if name in limits}
