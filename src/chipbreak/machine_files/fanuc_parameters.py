"""What a print-out of Fanuc parameters says of a machine.

The control puts its parameters out as ``N01622Q1A1P40A2P40``: a number, then for each axis A (spindle S, path
L) the value P; values of bits have eight digits.  Blanks, line ends and leading zeros differ between models.
Numbers as in the parameter manuals of the series 16i/18i/21i, 0i and 30i/31i/32i.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from chipbreak.machine_files.found import Found, Machine, Value, first_of, plain
from chipbreak.text.bounds import MOST_MACHINE_FILE_BYTES, read_bounded
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_PARAMETER = re.compile(
    rb"N\s*0*(\d{1,5})(?!\d)((?:\s*[QALST]\s*\d{1,9}(?!\d)|\s*P\s*-?[\d.]+|\s*M(?=\s|[PA]))*)"
)
_BESIDE_VALUES = re.compile(rb"[\sM]+")
_VALUE = re.compile(rb"(?:([ALS])(\d+))?P(-?[\d.]+)")
_FEWEST = 3  # parameters that make a file a print-out
_AXES_BY_CODE = {ord(letter): letter for letter in "XYZ"}


class _Parameters(NamedTuple):
    """Texts by number and axis; axis 0 is that of a parameter without one."""

    values: Mapping[tuple[int, int], str]

    def text(self, number: int, axis: int = 0) -> str | None:
        """The value of a parameter as it stands there."""
        return self.values.get((number, axis), self.values.get((number, 1)) if axis == 0 else None)

    def number(self, number: int, axis: int = 0) -> float | None:
        """The value of a parameter."""
        try:
            value = float(self.text(number, axis) or "")
        except ValueError:
            return None
        return value if math.isfinite(value) else None

    def bit(self, number: int, bit: int, axis: int = 0) -> bool | None:
        """One of the eight digits of a parameter, bit 0 being the last."""
        text = self.text(number, axis)
        if text is None or re.fullmatch("[01]{8}", text) is None:
            return None
        return text[7 - bit] == "1"

    @property
    def axes(self) -> dict[int, str]:
        """Number of the axis -> letter, from parameter 1020; X, Z or X, Y, Z without it."""
        named = {
            axis: _AXES_BY_CODE[int(float(text))]
            for (number, axis), text in self.values.items()
            if number == 1020 and axis and text.isdigit() and int(text) in _AXES_BY_CODE
        }
        if named:
            return named
        count = max((axis for number, axis in self.values if number in (1420, 1825)), default=0)
        return dict(enumerate("XZ" if count <= 2 else "XYZ", 1))


def machine_of_parameters(path: str | Path) -> Machine:
    """The machine of a parameter print-out.  Errors: PAR001 for no such file, or one that is none."""
    path = Path(path)
    try:
        data = read_bounded(path, MOST_MACHINE_FILE_BYTES)
    except OSError as error:
        message = plain(f"cannot read {path}: {error.strerror}")
        raise RefusalError(
            "PAR001", message, "put the parameters out by PUNCH on the PARAMETER screen"
        ) from None
    parameters = _read(data)
    if len({number for number, _ in parameters.values}) < _FEWEST:
        message = plain(f"{path} is no print-out of Fanuc parameters")
        raise RefusalError("PAR001", message, "it has lines such as N01825 A1 P3000 A2 P3000")
    found = first_of(one for rule in _RULES for one in rule(parameters))
    base = "fanuc-mill" if "Y" in parameters.axes.values() else "fanuc-lathe"
    there = {one.key for one in found}
    missing = [
        text.format(axis=axis)
        for key, text in _WANTED
        for axis in (sorted(parameters.axes.values()) if "{axis}" in key else [""])
        if key.format(axis=axis) not in there
    ]
    return Machine(base, found, tuple(missing))


def _read(data: bytes) -> _Parameters:
    values: dict[tuple[int, int], str] = {}
    for match in _PARAMETER.finditer(data):
        number = int(match[1])
        # Blanks go first: to look for a value from each of a million of them would take hours.
        for which, index, value in _VALUE.findall(_BESIDE_VALUES.sub(b"", match[2])):
            axis = int(index) if which in (b"A", b"S") else 0
            values.setdefault((number, axis), value.decode("ascii"))
    return _Parameters(values)


def _by_axis(
    parameters: _Parameters, number: int, key: str, unit: str, change: Callable[[float], Value]
) -> Iterator[Found]:
    """A parameter of each axis that is set: 0 means that the control does without."""
    for index, letter in parameters.axes.items():
        value = parameters.number(number, index)
        if value:
            yield Found(
                f"axes.{letter}.{key}", change(value), f"parameter {number}, {value:g} {unit}".rstrip()
            )


def _numbers_read(parameters: _Parameters) -> Iterator[Found]:
    """What a number without a decimal point is worth (3401 bit 0, DPI), and the increment (1013, 1004)."""
    calculator = parameters.bit(3401, 0)
    if calculator is not None:
        rule = "calculator" if calculator else "increment"
        yield Found("control.decimal_point", rule, f"parameter 3401 bit 0 (DPI), {int(calculator)}")
    for number in (1013, 1004):
        coarse = parameters.bit(number, 0)
        fine = parameters.bit(number, 1)
        if coarse is not None and fine is not None:
            size = 0.01 if coarse else 0.0001 if fine else 0.001
            yield Found("control.increment_mm", size, f"parameter {number} bits 0 and 1 (ISA, ISC)")


def _lathe(parameters: _Parameters) -> Iterator[Found]:
    """G-code system (3401 bits 6 and 7) and diameter programming (1006 bit 3)."""
    b = parameters.bit(3401, 6)
    c = parameters.bit(3401, 7)
    if b is not None and c is not None and "Y" not in parameters.axes.values():
        system = "C" if c else "B" if b else "A"
        yield Found("control.lathe_system", system, "parameter 3401 bits 6 and 7 (GSB, GSC)")
    for index, letter in parameters.axes.items():
        diameter = parameters.bit(1006, 3, index)
        if letter == "X" and diameter is not None:
            yield Found("control.x_diameter", diameter, "parameter 1006 bit 3 (DIA) of X")


def _speeds(parameters: _Parameters) -> Iterator[Found]:
    """The highest cutting feed of each axis (1430), of all (1422), or else rapid traverse (1420)."""
    yield from _by_axis(parameters, 1430, "max_velocity_mm_min", "mm/min", float)
    for_all = parameters.number(1422)
    if for_all:
        for letter in parameters.axes.values():
            yield Found(f"axes.{letter}.max_velocity_mm_min", for_all, f"parameter 1422, {for_all:g} mm/min")
    yield from _by_axis(parameters, 1420, "max_velocity_mm_min", "mm/min, rapid traverse", float)


def _kind_of_acc_dec(parameters: _Parameters) -> Iterator[Found]:
    """Exponential, linear or bell-shaped behind interpolation (1610 bits 0 and 1)."""
    for index, letter in parameters.axes.items():
        linear = parameters.bit(1610, 0, index)
        bell = parameters.bit(1610, 1, index)
        if linear is None or bell is None:
            continue
        kind = "bell" if bell else "linear" if linear else "exponential"
        yield Found(f"axes.{letter}.acc_dec", kind, "parameter 1610 bits 0 and 1 (CTL, CTB)")


def _servo(parameters: _Parameters) -> Iterator[Found]:
    """Acc/dec time (1622), position gain (1825, in 0.01/s) and feed forward (2092, in 0.01 %; 2005 bit 1)."""
    yield from _by_axis(parameters, 1622, "acc_dec_ms", "ms", float)
    yield from _by_axis(parameters, 1825, "position_gain_1_s", "x 0.01/s", lambda value: value / 100.0)
    for index, letter in parameters.axes.items():
        value = parameters.number(2092, index)
        if value and parameters.bit(2005, 1, index) is not False and 0.0 < value <= 10_000.0:
            source = f"parameter 2092, {value:g} x 0.01 %"
            yield Found(f"axes.{letter}.feed_forward", value / 10_000.0, source)


def _spindle(parameters: _Parameters) -> Iterator[Found]:
    """The highest speed of the spindle (3772)."""
    value = parameters.number(3772)
    if value and value >= 1.0:
        yield Found("spindle.max_rpm", value, f"parameter 3772, {value:g} rpm")


def _law(parameters: _Parameters) -> Iterator[Found]:
    """Without AI contour control the time of blocks is kept, and the filters take from the stroke."""
    if any(True for _ in _servo(parameters)):
        yield Found("planner.model", "after-interpolation", "parameters 1622 and 1825; look-ahead under AICC")


_RULES: tuple[Callable[[_Parameters], Iterator[Found]], ...] = (
    _numbers_read,
    _law,
    _lathe,
    _speeds,
    _kind_of_acc_dec,
    _servo,
    _spindle,
)
# What a promise needs to know, and where it stands on the control.
_WANTED = (
    ("control.decimal_point", "control.decimal_point: parameter 3401 bit 0 (DPI)"),
    ("axes.{axis}.acc_dec", "axes.{axis}.acc_dec: parameter 1610"),
    ("axes.{axis}.acc_dec_ms", "axes.{axis}.acc_dec_ms: parameter 1622, or 1769 under look-ahead"),
    ("axes.{axis}.position_gain_1_s", "axes.{axis}.position_gain_1_s: parameter 1825, in 0.01/s"),
    ("spindle.max_rpm", "spindle.max_rpm: parameter 3772"),
)
