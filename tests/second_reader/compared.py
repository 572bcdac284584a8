"""The original held against the filtered program on the second reader, but for what the changes do."""

from __future__ import annotations

from itertools import zip_longest

import chipbreak
from brackets import marked

from .reader import Control, Record, run

_SAME = 1e-6


def settings_of(control: Control) -> chipbreak.Settings:
    """The profile of a control."""
    sets = ['vibration.refused="leave"', 'output.segments="stroke"', "checks.enabled=false"]
    if control.is_lathe:
        return chipbreak.load("fanuc-lathe", [f'control.lathe_system="{control.system}"', *sets])
    return chipbreak.load("fanuc-mill", sets)


def difference(output: bytes, control: Control) -> str:
    """What a control does otherwise outside the brackets; empty where nothing."""
    return differing(marked(output).decode("latin-1"), output.decode("latin-1"), control)


def differing(text: str, other_text: str, control: Control) -> str:
    """What a control does otherwise in one of two programs; empty where nothing."""
    both = zip_longest(run(text, control), run(other_text, control))
    for number, (one, other) in enumerate(both):
        if one is None or other is None:
            return f"record {number}: {one} against {other}"
        if found := _differing(one, other):
            return f"record {number}, {one.name}: {found}"
    return ""


def _differing(one: Record, other: Record) -> str:
    if one.name != other.name or not _is_near(one.numbers, other.numbers):
        return f"{one.name} {one.numbers} against {other.name} {other.numbers}"
    wrong = [key for key in one.state if not _is_near(one.state[key], other.state.get(key))]
    return "; ".join(f"{key} {one.state[key]} against {other.state.get(key)}" for key in wrong)


def _is_near(one: object, other: object) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_is_near, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= _SAME * max(1.0, abs(one))
    return one == other


def checked(text: str, control: Control) -> tuple[str, str]:
    """What became of a program in a word, and what a control does otherwise."""
    try:
        result = chipbreak.rewrite(text.encode("latin-1"), settings_of(control), allow_unbroken=True)
    except chipbreak.ProgramRejectedError as error:
        codes = sorted({said.code for said in error.diagnostics if said.severity.value == "error"})
        return f"refused {' '.join(codes)}", ""
    except chipbreak.SelfCheckError as error:
        return "fault", f"exit 4: {error}"
    if not result.changed:
        return "unchanged", ""
    return "changed", difference(result.data, control)
