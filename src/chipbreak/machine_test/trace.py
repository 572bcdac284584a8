"""A recorded trace of time and axis positions, cut into the motions of the groups.

Servo guides, halscope and halsampler write text: columns between commas, semicolons, tabs or blanks, perhaps
with a line of names above.  A name says what a column is and in which unit: ``time_ms``, ``Z [um]``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from chipbreak.kinematics.floats import Floats
from chipbreak.machine_files.found import plain
from chipbreak.machine_test.groups import Group, longest_mm
from chipbreak.settings.axis_words import AXES
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import MM_PER_INCH

_CODE = "MTS003"
_MOST_BYTES = 200_000_000
_FEWEST_ROWS = 100
_TIME_UNITS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0}
_PLACE_UNITS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "m": 1e3, "inch": MM_PER_INCH, "in": MM_PER_INCH}
_DIAMETERS = ("dia", "diameter")
_TIME_NAMES = ("t", "time")
_LEFT_OUT = "-"
_WORD = re.compile(r"[A-Za-zµ]+")
_NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?")
_COARSEST_S = 0.008  # the shortest strokes take 20 ms
_LARGEST_NOISE_MM = 0.01
_GAP = 3.5  # steps of a sampler that are none any more
_WINDOW_S = 0.06
_REST_S = 0.35  # shorter rests are inside a group
_SIGMAS = 9.0
_LEAST_MM = 0.001
_AWAY = 2.0  # times what counts as a move
_SMALLEST_MM = 0.02  # of a group: strokes are 0.1 mm, and their mean is seen behind any filter
_CLOSED_MM = 0.03
_SAME_SHARE = 0.04
# What it usually is when an axis goes so many times as far as asked.
_SCALES = {
    1000.0: "micrometres: name the column {axis}_um",
    0.001: "metres: name the column {axis}_m",
    1.0 / MM_PER_INCH: "inches: name the column {axis}_inch",
    2.0: "diameters: name the column {axis}_diameter",
}
_WHAT = "record time and the positions of the axes from before the first group to behind the last one"


class Column(NamedTuple):
    """What a column holds: ``time`` or an axis, and what its unit is in s or mm."""

    what: str
    unit: float


class Trace(NamedTuple):
    """Times [s], (n,), and the places [mm] of each axis that was recorded, (n,) each."""

    time_s: Floats
    places_mm: Mapping[str, Floats]


class Piece(NamedTuple):
    """The motion of an axis in one group: from a little before it moves to a little behind that.

    ``place_mm`` (n,) counts from where the axis was, in the direction of the group.  ``noise_mm`` is the
    standard deviation of the places.
    """

    group: Group
    axis: str
    time_s: Floats
    place_mm: Floats
    noise_mm: float


def read_trace(path: str | Path, columns: str | None = None) -> Trace:
    """Read a trace.  ``columns`` names them, as in ``time_ms,z,-``, where the file does not.

    Errors: MTS003.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            data = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise RefusalError(_CODE, plain(f"cannot read {path}: {error.strerror}"), _WHAT) from None
    if len(data) > _MOST_BYTES:
        message = f"{path.name} is larger than {_MOST_BYTES // 1_000_000} MB"
        raise RefusalError(_CODE, plain(message), "leave out columns, or record less often")
    lines = [line.strip() for line in data.decode("latin-1").splitlines()]
    rows, names = _rows(lines)
    if len(rows) < _FEWEST_ROWS:
        message = f"{path.name} is no trace: it has {len(rows)} lines of numbers in a row"
        raise RefusalError(_CODE, plain(message), _WHAT)
    known = _columns(columns.split(",") if columns else names, rows.shape[1], path.name)
    time_s = (
        rows[:, [one.what for one in known].index("time")]
        * known[[one.what for one in known].index("time")].unit
    )
    places = {one.what: rows[:, number] * one.unit for number, one in enumerate(known) if one.what in AXES}
    _check_times(time_s)
    return Trace(time_s - time_s[0], places)


def _rows(lines: Sequence[str]) -> tuple[Floats, list[str]]:
    """The longest block of lines with as many numbers each, and the names above it."""
    found: list[list[float]] = []
    names: list[str] = []
    for line in lines:
        cells = _cells(line)
        numbers = [float(cell.replace(",", ".")) for cell in cells if _NUMBER.fullmatch(cell)]
        if cells and len(numbers) == len(cells) and len(cells) > 1:
            if found and len(found[0]) != len(cells):
                break
            found.append(numbers)
        elif not found and cells:
            names = cells
    return np.array(found).reshape(len(found), len(found[0]) if found else 0), names


def _cells(line: str) -> list[str]:
    """The cells of a line; a comma is a decimal point where semicolons or tabs divide."""
    for mark in ";\t":
        if mark in line:
            return [cell.strip().strip('"') for cell in line.split(mark) if cell.strip()]
    if "," in line:
        return [cell.strip().strip('"') for cell in line.split(",") if cell.strip()]
    return line.split()


def _columns(names: Sequence[str], count: int, file: str) -> list[Column]:
    known = [_column(name) for name in names]
    whats = [one.what for one in known if one.what != _LEFT_OUT]
    if len(known) == count and "time" in whats and len(set(whats)) == len(whats) > 1:
        return known
    message = f"{file} has {count} columns, and it is not plain which are the time and an axis"
    help_text = "name them: --columns time_ms,x,z, with - for one that does not count"
    raise RefusalError(_CODE, plain(message), help_text)


def _column(name: str) -> Column:
    words = [word.lower() for word in _WORD.findall(name)]
    letters = [word.upper() for word in words if word.upper() in tuple(AXES)]
    if set(words) & set(_TIME_NAMES):
        return Column("time", _unit(words, _TIME_UNITS))
    if len(letters) != 1:
        return Column(_LEFT_OUT, 1.0)
    half = 0.5 if set(words) & set(_DIAMETERS) else 1.0
    return Column(letters[0], half * _unit(words, _PLACE_UNITS))


def _unit(words: Sequence[str], units: Mapping[str, float]) -> float:
    """What the unit among some words is worth, 1 where there is none."""
    return next((units[word] for word in words if word in units), 1.0)


def _check_times(time_s: Floats) -> None:
    steps_s = np.diff(time_s)
    step_s = float(np.median(steps_s))
    if not (np.isfinite(time_s).all() and step_s > 0.0 and steps_s.min() > 0.0):
        raise RefusalError(_CODE, "the times of the trace do not rise", "give it as it was recorded")
    if step_s > _COARSEST_S:
        message = f"the trace has a place every {step_s * 1000.0:.4g} ms, strokes of 20 ms need more"
        help_text = (
            f"record every {_COARSEST_S * 1000.0:g} ms or more often; if the times are ms, say time_ms"
        )
        raise RefusalError(_CODE, message, help_text)
    worst = int(steps_s.argmax())
    if steps_s[worst] > _GAP * step_s:
        message = f"the trace has a gap of {steps_s[worst] * 1000.0:.4g} ms at {time_s[worst]:.4g} s"
        raise RefusalError(_CODE, message, "record it again: with a hole nobody knows what happened there")


def pieces_of(trace: Trace, groups: Sequence[Group]) -> list[Piece]:
    """The motion of each group and axis that was recorded, in order.  Errors: MTS003, MTS004."""
    found: list[Piece] = []
    for axis, place_mm in trace.places_mm.items():
        own = [group for group in groups if axis == group.axis]
        if own:
            found += _pieces_of_axis(trace.time_s, place_mm, axis, own)
    if not found:
        raise RefusalError(_CODE, "no axis of the trace is one of the test", _WHAT)
    return found


def _pieces_of_axis(time_s: Floats, place_mm: Floats, axis: str, groups: Sequence[Group]) -> Iterator[Piece]:
    if not np.isfinite(place_mm).all():
        raise RefusalError(_CODE, f"the trace has places of {axis} that are no numbers", _WHAT)
    noise_mm = noise_of(place_mm)
    if noise_mm > _LARGEST_NOISE_MM:
        message = f"the places of {axis} are uncertain by {noise_mm * 1000.0:.3g} um, strokes are 0.1 mm"
        help_text = "record the encoder of the axis, not a worked-out value; check the unit of the column"
        raise RefusalError("MTS004", message, help_text)
    step_s = float(np.median(np.diff(time_s)))
    limit_mm = max(_SIGMAS * noise_mm, _LEAST_MM)
    bounds = [
        (first, last)
        for first, last in _motions(place_mm, round(_WINDOW_S / step_s), round(_REST_S / step_s), limit_mm)
        if abs(place_mm[last] - place_mm[first]) <= max(2.0 * limit_mm, _CLOSED_MM)
        and np.ptp(place_mm[first : last + 1]) >= _SMALLEST_MM
    ]
    _check_scale(place_mm, bounds, axis, groups)
    if len(bounds) != len(groups):
        message = f"{len(bounds)} motions of {axis} come back to their start, the test has {len(groups)}"
        raise RefusalError(_CODE, message, _WHAT)
    for (first, last), group in zip(bounds, groups, strict=True):
        run = slice(first, last + 1)
        own_mm = place_mm[run] - float(np.median(place_mm[max(first - 5, 0) : first + 1]))
        yield Piece(group, axis, time_s[run], _directed(own_mm), noise_mm)


def _directed(place_mm: Floats) -> Floats:
    """Counted in the direction in which the group goes first: some machines record with another sign."""
    return place_mm if place_mm.max() > -place_mm.min() else -place_mm


def noise_of(place_mm: Floats) -> float:
    """The standard deviation of places that were recorded, from how three in a row leave a line."""
    bends = np.diff(place_mm, n=2)
    return float(np.median(np.abs(bends - np.median(bends))) * 1.4826 / np.sqrt(6.0))


def _motions(place_mm: Floats, window: int, rest: int, limit_mm: float) -> Iterator[tuple[int, int]]:
    """First and last sample of every motion, with what lies a window beside it."""
    window = max(window, 3)
    views = sliding_window_view(place_mm, window)
    moves = np.ptp(views, axis=1) > limit_mm
    if not moves.all():
        # Of short strokes some axes make next to nothing, but they are away from where they rest.
        home_mm = float(np.median(views[~moves, 0]))
        moves |= np.abs(views[:, 0] - home_mm) > _AWAY * limit_mm
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moves, [False]]).astype(np.int8)))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return
    splits = np.flatnonzero(begins[1:] - ends[:-1] > rest - window)
    firsts = np.concatenate([begins[:1], begins[1:][splits]])
    lasts = np.concatenate([ends[:-1][splits], ends[-1:]])
    for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True):
        yield first, min(last + window - 1, len(place_mm) - 1)


def _check_scale(
    place_mm: Floats, bounds: Sequence[tuple[int, int]], axis: str, groups: Sequence[Group]
) -> None:
    """The longest way must be that of the test.  Errors: MTS004."""
    asked_mm = longest_mm(groups, axis)
    went_mm = max((float(np.ptp(place_mm[first : last + 1])) for first, last in bounds), default=0.0)
    times = went_mm / asked_mm
    if abs(times - 1.0) <= _SAME_SHARE:
        return
    likely = [text for scale, text in _SCALES.items() if abs(times / scale - 1.0) <= _SAME_SHARE]
    message = f"{axis} goes {went_mm:.4g} mm at most in the trace, the test asks for {asked_mm:.4g} mm"
    help_text = (
        f"these are {likely[0].format(axis=axis.lower())}" if likely else "check the unit of the column"
    )
    raise RefusalError("MTS004", message, help_text)
