"""The form beside the program: what was asked of the machine, and room for the times that it took."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from chipbreak.machine_files.found import plain
from chipbreak.machine_test.groups import Group, is_a_group
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import MS_PER_S

_CODE = "MTS002"
_MOST_BYTES = 1_000_000
_HELP = 'it is the file that "chipbreak machine-test write" puts beside the program'


class Form(NamedTuple):
    """A form that was read: the profile, the groups, and the time of each [s], None where it is not known.

    ``error_s`` is how well the times are known.
    """

    profile: str
    groups: tuple[Group, ...]
    times_s: tuple[float | None, ...]
    error_s: float

    @property
    def timed(self) -> list[int]:
        """Which groups have a time."""
        return [number for number, time_s in enumerate(self.times_s) if time_s is not None]


def form_text(
    profile: str, program: str, groups: Sequence[Group], variables: Sequence[int], error_ms: float
) -> str:
    """The form as TOML, its times still 0."""
    return "".join(f"{line}\n" for line in _lines(profile, program, groups, variables, error_ms))


def _lines(
    profile: str, program: str, groups: Sequence[Group], variables: Sequence[int], error_ms: float
) -> Iterator[str]:
    yield plain(f"# Times of the machine test {program}.")
    where = f"variables {variables[0]} to {variables[-1]}" if variables else "a clock"
    yield f"# Write the milliseconds of each group behind ms, from {where}; 0 is not known."
    yield "# A trace of time and position may stand in their place: chipbreak machine-test read --trace"
    yield f"profile = {_text(profile)}"
    yield f"error_ms = {error_ms:g}  # how well the times are known"
    for number, group in enumerate(groups):
        yield ""
        yield f"[[group]]  # {group.told}"
        yield f'name = "{group.name}"'
        yield f'axis = "{group.axis}"'
        yield f"stroke_mm = {group.stroke_mm:.10g}"
        yield f"feed_mm_min = {group.feed_mm_min:.10g}"
        yield f"strokes = {group.strokes}"
        yield f"blocks = {group.blocks}"
        yield f"ms = 0{f'  # variable {variables[number]}' if variables else ''}"


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{plain(escaped)}"'


def read_form(path: str | Path) -> Form:
    """Read a form.  Errors: MTS002 for a file that is none, or whose numbers are none."""
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RefusalError(_CODE, plain(f"cannot read {path}: {error.strerror}"), _HELP) from None
    try:
        values = tomllib.loads(data[:_MOST_BYTES].decode("utf-8-sig"))
        groups = tuple(_group(one) for one in values["group"])
        times = tuple(_time_s(one["ms"]) for one in values["group"])
        form = Form(str(values["profile"]), groups, times, _number(values["error_ms"]) / MS_PER_S)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        why = "a value is of another kind than was written" if isinstance(error, TypeError) else str(error)
        why = f"it lacks {error}" if isinstance(error, KeyError) else why
        raise RefusalError(_CODE, plain(f"{path} is no form of a machine test: {why}"), _HELP) from None
    names = [group.name for group in groups]
    if not groups or len(set(names)) < len(names) or not form.error_s > 0.0:
        message = plain(f"{path}: every group needs a name of its own, and error_ms is above 0")
        raise RefusalError(_CODE, message, _HELP)
    return form


def _group(values: Mapping[str, Any]) -> Group:
    counts = (values["strokes"], values["blocks"])
    if not all(type(count) is int for count in counts):
        raise ValueError("strokes and blocks are whole numbers")
    group = Group(
        str(values["name"]),
        str(values["axis"]),
        _number(values["stroke_mm"]),
        _number(values["feed_mm_min"]),
        *counts,
    )
    if not is_a_group(group):
        raise ValueError(f"group {group.name} is not as it was written")
    return group


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{value!r} is no number")
    number = float(value)
    if not abs(number) < 1e9:
        raise ValueError(f"{value!r} is no number of a machine")
    return number


def _time_s(value: Any) -> float | None:
    number = _number(value)
    if number < 0.0:
        raise ValueError(f"a time of {number:g} ms")
    return number / MS_PER_S if number else None
