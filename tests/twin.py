"""The twin of a program: the same motion for a control with other axis letters and other signs.

It knows nothing of the package: words are renamed and negated one by one, arcs are mirrored.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

_COMMENT = re.compile(r"(\([^)]*\)|;.*)")
_WORD = re.compile(r"([A-Za-z])([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))")
_DISTANCE_OF = {"X": "U", "Y": "V", "Z": "W", "C": "H"}
_PLANES = {"XY": "17", "ZX": "18", "YZ": "19"}
_CALL = re.compile(r"G65|O<.*>")


@dataclass(frozen=True)
class Mapping:
    """``letters`` and ``signs`` of the axes X, Y and Z."""

    letters: str
    signs: tuple[int, int, int]

    @property
    def sets(self) -> tuple[str, ...]:
        """The same as settings of a profile."""
        letters = [f'axes.{axis}.letter="{letter}"' for axis, letter in zip("XYZ", self.letters, strict=True)]
        return (*letters, *(f"axes.{a}.sign={s}" for a, s in zip("XYZ", self.signs, strict=True)))

    def places(self) -> str:
        """For each of the control's X, Y and Z the axis that stands there."""
        named = {letter: axis for axis, letter in zip("XYZ", self.letters, strict=True)}
        return "".join(named.get(place, place) for place in "XYZ")

    def plane(self, plane: str) -> tuple[str, bool]:
        """The control's plane for one of the geometry, and whether arcs turn the other way in it."""
        where = "".join("XYZ"[self.places().index(axis)] for axis in plane)
        flips = self.signs["XYZ".index(plane[0])] != self.signs["XYZ".index(plane[1])]
        return (where, flips) if where in _PLANES else (where[::-1], not flips)


def twin(program: str, mapping: Mapping, plane: str) -> str:
    """The twin of a program; ``plane`` is the one it begins in."""
    state = [plane]
    return "".join(_line(line, mapping, state) for line in program.splitlines(keepends=True))


def _line(line: str, mapping: Mapping, state: list[str]) -> str:
    if _CALL.match(line):
        return line  # the words of a macro call are its own
    parts = _COMMENT.split(line)
    code = "".join(parts[::2])
    for geometry, number in _PLANES.items():
        if re.search(rf"G{number}(?![0-9])", code):
            state[0] = geometry
    rename = _renamer(mapping, state[0])
    return "".join(part if i % 2 else _WORD.sub(rename, part) for i, part in enumerate(parts))


def _renamer(mapping: Mapping, plane: str) -> Callable[[re.Match[str]], str]:
    new_plane, flips = mapping.plane(plane)
    by_axis = dict(zip("XYZ", zip(mapping.letters, mapping.signs, strict=True), strict=True))

    def rename(match: re.Match[str]) -> str:
        letter, value = match.groups()
        if letter in "XYZ":
            name, sign = by_axis[letter]
        elif letter in "UVW":
            name, sign = by_axis["XYZ"["UVW".index(letter)]]
            name = _DISTANCE_OF[name]
        elif letter in "IJK":
            axis = "XYZ"["IJK".index(letter)]
            name, sign = "IJK"[mapping.places().index(axis)], by_axis[axis][1]
        elif letter == "G" and value in ("2", "3") and flips:
            return {"2": "G3", "3": "G2"}[value]
        elif letter == "G" and value in _PLANES.values():
            return f"G{_PLANES[new_plane]}"
        else:
            return match[0]
        return name + (value if sign > 0 else negated(value))

    return rename


def negated(value: str) -> str:
    """The same number with the other sign; zero has none."""
    if float(value) == 0.0:
        return value
    return value[1:] if value.startswith("-") else f"-{value.lstrip('+')}"
