"""Modal state of a Fanuc machining centre, as the system variables from #4001 show it."""

from __future__ import annotations

from dataclasses import dataclass, field

from macro_interpreter.faults import VARIABLE, fault

# Modal groups by the number of their variable less 4000, and what each holds at power-on.
GROUPS: dict[int, tuple[float, ...]] = {
    1: (0, 1, 2, 3, 33),
    2: (17, 18, 19),
    3: (90, 91),
    5: (94, 93, 95),
    6: (21, 20),
    7: (40, 41, 42),
    8: (49, 43, 44),
    9: (80, 73, 74, 76, 81, 82, 83, 84, 85, 86, 87, 88, 89),
    10: (98, 99),
    11: (50, 51),
    12: (67, 66),
    13: (97, 96),
    14: (54, 55, 56, 57, 58, 59),
    15: (64, 61, 62, 63),
    16: (69, 68),
    17: (15, 16),
    22: (50.1, 51.1),
}
GROUP_OF = {code: group for group, codes in GROUPS.items() for code in codes}
_WORDS = {102: "B", 107: "D", 108: "E", 109: "F", 111: "H", 113: "M", 114: "N", 115: "O", 119: "S", 120: "T"}


@dataclass
class Modes:
    """The code in force in each group, and the last value of each word."""

    codes: dict[int, float] = field(default_factory=lambda: {g: codes[0] for g, codes in GROUPS.items()})
    words: dict[str, float] = field(default_factory=dict)
    length_mm: float = 0.0

    @property
    def is_inch(self) -> bool:
        """G20 is in force."""
        return self.codes[6] == 20

    @property
    def is_absolute(self) -> bool:
        """G90 is in force."""
        return self.codes[3] == 90

    def readout(self, number: int) -> float:
        """``#4001`` to ``#4130``."""
        index = number - 4000
        if index in self.codes:
            return float(self.codes[index])
        if index in _WORDS:
            return self.words.get(_WORDS[index], 0.0)
        raise fault(VARIABLE, f"#{number} is not read out here")
