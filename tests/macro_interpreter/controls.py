"""Controls as their makers describe them: how they read numbers, what they hold, and how quick they are."""

from __future__ import annotations

from typing import NamedTuple

from chipbreak.units import MM_PER_INCH

# Letters whose values count increments where they have no decimal point: in moves and data, and in G65.
_LENGTHS = frozenset("XYZUVWIJKQRABC")
_DWELL = frozenset("XU")


class FanucControl(NamedTuple):
    """One control.

    ``increment_mm``     least input increment: 0.001 for IS-B, 0.0001 for IS-C
    ``calculator``       decimal point input of the pocket calculator type (DPI, parameter 3401)
    ``is_inch_machine``  the ball screws count in inches: positions are multiples of that increment
    ``macro_levels``     G65 in each other
    ``sub_levels``       M98 in each other
    ``levels``           all of them together
    ``text_chars``       of an alarm or a stop
    ``last_alarm``       the highest n of ``#3000=n``
    ``commons``          ranges of common variables
    ``block_s``, ``m_code_s``, ``orient_s``, ``spindle_s``  how long these take
    """

    name: str
    increment_mm: float = 0.001
    calculator: bool = False
    is_inch_machine: bool = False
    macro_levels: int = 4
    sub_levels: int = 4
    levels: int = 8
    text_chars: int = 26
    last_alarm: int = 200
    commons: tuple[tuple[int, int], ...] = ((100, 199), (500, 999))
    block_s: float = 0.008
    m_code_s: float = 0.05
    orient_s: float = 0.4
    spindle_s: float = 0.6

    def step(self, *, is_inch: bool) -> float:
        """The least input increment in units of the program."""
        return self.increment_mm / 10.0 if is_inch else self.increment_mm

    def grid_mm(self, *, is_inch: bool) -> float:
        """Ends of moves are multiples of this [mm]."""
        return self.step(is_inch=True) * MM_PER_INCH if is_inch else self.increment_mm

    def machine_grid_mm(self) -> float:
        """Measured positions are multiples of this [mm]."""
        return self.grid_mm(is_inch=self.is_inch_machine)

    def scale(self, letter: str, *, is_inch: bool, is_dwell: bool) -> float:
        """What one without a decimal point is worth, of a letter."""
        if is_dwell:
            return 0.001 if letter in _DWELL else 1.0
        if letter not in _LENGTHS or self.calculator:
            return 1.0
        return self.increment_mm if letter in "ABC" else self.step(is_inch=is_inch)

    def argument_scale(self, letter: str, *, is_inch: bool) -> float:
        """The same for an argument of G65: D, E, F, H, M, S and T count ones."""
        return self.scale(letter, is_inch=is_inch, is_dwell=False)


FANUC_0I_F = FanucControl("Fanuc 0i-F, IS-B")
FANUC_0I_F_DPI = FANUC_0I_F._replace(name="Fanuc 0i-F, IS-B, calculator type", calculator=True)
FANUC_0I_F_INCH = FANUC_0I_F._replace(name="Fanuc 0i-F, IS-B, inch machine", is_inch_machine=True)
FANUC_31I_C = FanucControl(
    "Fanuc 31i-B, IS-C",
    increment_mm=0.0001,
    macro_levels=5,
    sub_levels=10,
    levels=15,
    text_chars=31,
    commons=((100, 199), (500, 999), (98000, 98499)),
    block_s=0.004,
)
CONTROLS = (FANUC_0I_F, FANUC_0I_F_DPI, FANUC_0I_F_INCH, FANUC_31I_C)
