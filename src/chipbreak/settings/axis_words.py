"""Which word of the control moves which axis of the geometry, and in which direction.

The geometry is the position of the tool relative to the work.  A control may name an axis by another letter,
and where the work moves instead of the tool (a spindle carrier), a positive word takes the tool in the
negative direction.  Whatever reads or writes an axis word asks here.
"""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple

AXES = "XYZ"
CENTRES = "IJK"
PLANES = ("XY", "ZX", "YZ")


class AxisWords(NamedTuple):
    """The axis words of a control.

    ``letters``    axis of the geometry -> the letter that moves it
    ``signs``      axis of the geometry -> 1 where the tool moves, -1 where the work does
    ``axes``       letter -> axis of the geometry; letters that always give distances (U) included
    ``distances``  those letters
    ``places``     the axes of the geometry where the control has its X, Y and Z: I, J, K and the planes of
                   G17, G18 and G19 belong to these
    """

    letters: Mapping[str, str]
    signs: Mapping[str, int]
    axes: Mapping[str, str]
    distances: frozenset[str]
    places: str

    def distance_letter(self, axis: str) -> str | None:
        """The letter that always moves an axis incrementally, None where there is none."""
        return next((letter for letter in self.distances if self.axes[letter] == axis), None)

    def centre_axis(self, letter: str) -> str:
        """The axis that I, J or K counts along."""
        return self.places[CENTRES.index(letter)]

    def plane(self, plane: str) -> tuple[str, bool]:
        """The plane of the geometry, and whether a clockwise arc of the control turns the other way in it."""
        first, second = (self.places[AXES.index(place)] for place in plane)
        is_mirrored = self.signs[first] != self.signs[second]
        if first + second in PLANES:
            return first + second, is_mirrored
        return second + first, not is_mirrored

    def renamed(self, text: str, distances: Mapping[str, str]) -> str | None:
        """A block of the dialect, written for X, Y, Z and their ``distances``, in the letters of these axes.

        None where it needs a letter that an axis does not have.
        """
        own = dict(self.letters) | {d: self.distance_letter(axis) for d, axis in distances.items()}
        letters = [own.get(character, character) for character in text]
        return None if None in letters else "".join(filter(None, letters))


def axis_words(
    letters: Mapping[str, str], signs: Mapping[str, int], distances: Mapping[str, str]
) -> AxisWords:
    """The words of a control from the letters of its axes; ``distances`` is the dialect's (U -> X).

    U belongs to the letter X, whatever axis of the geometry that moves.
    """
    axis_of = {letter: axis for axis, letter in letters.items()}
    # What a distance of another axis (H of C) moves keeps its name; it is no axis of the geometry.
    used = {d: axis_of.get(letter, letter) for d, letter in distances.items() if letter not in AXES}
    used |= {d: axis_of[letter] for d, letter in distances.items() if letter in AXES and letter in axis_of}
    return AxisWords(
        FrozenTable(letters),
        FrozenTable(signs),
        FrozenTable(axis_of | used),
        frozenset(used),
        _places(axis_of),
    )


def _places(axis_of: Mapping[str, str]) -> str:
    """X, Y and Z stand at their own places, another letter at that of its axis or at what is left."""
    places = {letter: axis for letter, axis in axis_of.items() if letter in AXES}
    others = [axis for letter, axis in axis_of.items() if letter not in AXES]
    for axis in sorted(others, key=lambda axis: axis in places):
        free = [place for place in AXES if place not in places]
        places[axis if axis in free else free[0]] = axis
    return "".join(places[place] for place in AXES)
