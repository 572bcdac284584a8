"""A profile as TOML text, every value with its source."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from datetime import date, time
from typing import Any

from chipbreak.settings.sections import OPEN_SECTIONS, SECTIONS, Settings


def show_profile(settings: Settings) -> Iterator[str]:
    """Lines that can be used as a profile again; a key without a value stands in a comment."""
    yield f"# {settings.name}: {settings.dialect.title}"
    for section in SECTIONS:
        yield ""
        yield f"[{section}]"
        is_axis = section.startswith("axes.")
        values = settings.axes[section[-1]] if is_axis else getattr(settings, section)
        for field in dataclasses.fields(values):
            value = getattr(values, field.name)
            if value is None:
                yield f"# {field.name} is not set"
            else:
                yield f"{field.name} = {_toml(value)}  # {settings.origin(f'{section}.{field.name}')}"
    tables = (settings.operations, settings.call_sets, settings.plugins)
    for section, table in zip(OPEN_SECTIONS, tables, strict=True):
        if table:
            yield ""
            yield f"[{section}]"
            for key, value in table.items():
                yield f"{key} = {_toml(value)}"


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    if isinstance(value, date | time):  # only a plug-in has such options; a datetime is a date
        return value.isoformat()
    return repr(value) if isinstance(value, float) else json.dumps(value)
