"""A control without variables in front of a touch plate, after Grbl's documents: its own small model.

It knows nothing of the filter.  What it takes from the documents: G38.2 and G38.3 stop where the plate is
met; alarm 4 where one begins on the plate, alarm 5 where a G38.2 meets nothing; G53 goes by machine
coordinates; G10 L20 Pn makes the place of the tool the given one in the n-th work offset; F, units, distances
and the work offset stay in force.  What it assumes: the axis runs on by v * v / 2a behind the plate, as it
brakes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

_WORD = re.compile(r"([A-Z])([-+]?[0-9]*\.?[0-9]+)")
_OFFSETS = {f"G{number}": number - 53 for number in range(54, 60)}
MOTIONS = {"G0", "G1", "G38.2", "G38.3"}
NEAR_MM = 5.0


class AlarmError(Exception):
    """What the control says, and nothing moves any more."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@dataclass
class Control:
    """``tool_mm``: from the spindle nose to the tip, None without a tool; the plate lies at ``plate_mm``."""

    tool_mm: float | None
    plate_mm: tuple[float, float, float] = (-10.0, -20.0, -140.0)
    acceleration_mm_s2: float = 50.0
    is_shorted: bool = False
    at_mm: list[float] = field(default_factory=lambda: [-100.0, -100.0, -30.0])
    offsets_mm: dict[int, list[float]] = field(
        default_factory=lambda: {number: [-150.0 + number, -90.0, -130.0] for number in range(1, 7)}
    )
    offset: int = 1
    motion: str = "G0"
    is_incremental: bool = False
    unit_mm: float = 1.0
    feed: float = 0.0
    spindle: str = "M5"
    coolant: str = "M9"
    deepest_press_mm: float = 0.0

    @property
    def modes(self) -> tuple[object, ...]:
        return (self.offset, self.is_incremental, self.unit_mm, self.feed, self.spindle, self.coolant)

    @property
    def contact_mm(self) -> float:
        """Z of the spindle nose with the tip on the plate; far below where there is nothing to meet."""
        if self.tool_mm is None:
            return -1e9
        aside = max(abs(a - b) for a, b in zip(self.at_mm, self.plate_mm[:2], strict=False))
        return self.plate_mm[2] + self.tool_mm if aside < NEAR_MM else -1e9

    def run(self, text: str) -> None:
        """Run blocks; raises AlarmError."""
        for line in text.splitlines():
            self.block(re.sub(r"\(.*?\)|\s", "", line))

    def block(self, text: str) -> None:
        codes = {f"{a}{float(n):g}" for a, n in _WORD.findall(text) if a in "GM"}
        words = {a: float(n) for a, n in _WORD.findall(text) if a not in "GMN"}
        self._take_modes(codes)
        if "F" in words:
            self.feed = words["F"] * self.unit_mm
        if "G10" in codes:
            assert words["L"] == 20.0
            self._set_offset(int(words["P"]), words)
        elif any(axis in words for axis in "XYZ"):
            self._move(self._target(words, "G53" in codes))

    def _take_modes(self, codes: set[str]) -> None:
        self.motion = next(iter(codes & MOTIONS), self.motion)
        self.offset = next((_OFFSETS[code] for code in codes & _OFFSETS.keys()), self.offset)
        self.unit_mm = 25.4 if "G20" in codes else 1.0 if "G21" in codes else self.unit_mm
        self.is_incremental = "G91" in codes or (self.is_incremental and "G90" not in codes)
        self.spindle = next(iter(codes & {"M3", "M4", "M5"}), self.spindle)
        self.coolant = next(iter(codes & {"M7", "M8", "M9"}), self.coolant)

    def _set_offset(self, number: int, words: dict[str, float]) -> None:
        for axis, letter in enumerate("XYZ"):
            if letter in words:
                self.offsets_mm[number][axis] = self.at_mm[axis] - words[letter] * self.unit_mm

    def _target(self, words: dict[str, float], is_machine: bool) -> list[float]:
        target = list(self.at_mm)
        for axis, letter in enumerate("XYZ"):
            if letter in words:
                origin = 0.0 if is_machine else self.offsets_mm[self.offset][axis]
                if self.is_incremental and not is_machine:
                    origin = self.at_mm[axis]
                target[axis] = origin + words[letter] * self.unit_mm
        return target

    def _move(self, target: list[float]) -> None:
        if self.motion.startswith("G38"):
            self._probe(target)
            return
        self.at_mm = target
        self.deepest_press_mm = max(self.deepest_press_mm, self.contact_mm - target[2])

    def _probe(self, target: list[float]) -> None:
        assert target[:2] == self.at_mm[:2]
        assert self.feed > 0.0
        contact = self.contact_mm
        if self.is_shorted or self.at_mm[2] <= contact:
            raise AlarmError(4)
        if target[2] > contact:
            self.at_mm = target
            if self.motion == "G38.2":
                raise AlarmError(5)
            return
        speed = self.feed / 60.0
        self.at_mm[2] = contact - speed * speed / (2.0 * self.acceleration_mm_s2)
        self.deepest_press_mm = max(self.deepest_press_mm, contact - self.at_mm[2])
