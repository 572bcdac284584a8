"""Threading cycles: so many passes over the length of the thread, each with its ways out and back.

::

    G76 P010060 Q50 R0.02                    Fanuc: P height, Q first depth, in increments
    G76 X18.16 Z-13. P920 Q250 F1.5
    G76 X18.16 Z-13. K0.92 D250 F1.5         the same in one block
    G76 P1.5 Z-13 I-1 J0.25 K0.92 R1.5 H1    LinuxCNC: P lead, J first depth, K height, H springs
    G92 X19.5 Z-13. F1.5                     one pass a block
"""

from __future__ import annotations

import math

from chipbreak.cycle_time.clock import CUTTING, RAPIDS, Clock
from chipbreak.cycle_time.feed import counted_mm, rapid_s, turn_s, word_mm
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.modal import NOWHERE
from chipbreak.settings.sections import Settings
from chipbreak.text.named_tuple import NamedTuple

_MOST_PASSES = 1000
_WAYS_MM = 4.0  # out and in again, radially, where the cycle does not say how far


class _Thread(NamedTuple):
    """A threading cycle: lengths in mm; ``degression`` is the power of the depths, 2 for even chips."""

    lead_mm: float
    height_mm: float
    first_mm: float
    least_mm: float = 0.0
    allowance_mm: float = 0.0
    finishing: int = 0
    degression: float = 2.0

    def passes(self) -> int:
        """How often the tool goes over the thread."""
        to_cut = self.height_mm - self.allowance_mm
        depth = 0.0
        count = 0
        while depth < to_cut - 1e-9 and count < _MOST_PASSES:
            count += 1
            depth = max(self.first_mm * count ** (1.0 / self.degression), depth + self.least_mm)
        return count + self.finishing


class Threading:
    """Remembers what the first block of a two-block G76, or the first G92, has said."""

    def __init__(self, settings: Settings, clock: Clock) -> None:
        self.settings = settings
        self.clock = clock
        self.finishing = 1
        self.least_mm = 0.0
        self.allowance_mm = 0.0
        self.way_mm = math.nan
        self.start = NOWHERE

    def time(self, effect: BlockEffect) -> bool:
        """Add the time of a thread; False for a block that cuts none by a cycle."""
        motion = effect.after.modes.motion
        if motion == "threading-cycle":
            return self._single(effect)
        if "thread-cycle" in effect.non_modal:
            self._fanuc(effect)
            return True
        if motion == "thread-cycle" and effect.move is not None:
            self._linuxcnc(effect)
            return True
        return motion == "thread-cycle"

    def _single(self, effect: BlockEffect) -> bool:
        """One pass a block (G92, G78): in, along, out, back."""
        if effect.before.modes.motion != "threading-cycle":
            self.way_mm = math.nan
            self.start = effect.before.position
        if effect.move is None:
            return False
        end = word_mm(effect, "Z", self.settings)
        way = word_mm(effect, "W", self.settings) if math.isnan(end) else end - self.start.z
        self.way_mm = self.way_mm if math.isnan(way) else way
        feed = effect.after.feed
        lead = feed.value if feed is not None else math.nan
        self._add(effect, self.way_mm, lead, 1, self.start.x)
        return True

    def _fanuc(self, effect: BlockEffect) -> None:
        block = effect.block
        settings = self.settings
        end = word_mm(effect, "Z", settings)
        if math.isnan(end) and not block.has("W"):
            said = int(block.number("P") or 0)
            self.finishing = said // 10_000 or 1
            self.least_mm = _or_zero(counted_mm(effect, "Q", settings))
            self.allowance_mm = _or_zero(word_mm(effect, "R", settings))
            return
        way = word_mm(effect, "W", settings) if math.isnan(end) else end - effect.before.position.z
        feed = effect.after.feed
        lead = feed.value if feed is not None else math.nan
        one_block = block.has("K") and block.has("D")
        height = word_mm(effect, "K", settings) if one_block else counted_mm(effect, "P", settings)
        first = counted_mm(effect, "D" if one_block else "Q", settings)
        kept = (0.0, 0.0, 0) if one_block else (self.least_mm, self.allowance_mm, self.finishing)
        self._passes(effect, way, _Thread(lead, height, first, *kept))

    def _linuxcnc(self, effect: BlockEffect) -> None:
        settings = self.settings
        lead, first, height = (word_mm(effect, letter, settings) for letter in "PJK")
        way = word_mm(effect, "Z", settings) - effect.before.position.z
        halved = 2.0 if effect.after.modes.diameter == "diameter" else 1.0
        springs = int(effect.block.number("H") or 0)
        degression = max(1.0, effect.block.number("R") or 1.0)
        thread = _Thread(lead, height / halved, first / halved, finishing=springs, degression=degression)
        self._passes(effect, way, thread)

    def _passes(self, effect: BlockEffect, way_mm: float, thread: _Thread) -> None:
        if not (thread.first_mm > 0.0 and thread.height_mm > 0.0):
            self.clock.cannot(effect.block.line, "the depths of this thread are not known")
            return
        self._add(effect, way_mm, thread.lead_mm, thread.passes(), effect.before.position.x)

    def _add(self, effect: BlockEffect, way_mm: float, lead_mm: float, passes: int, radius_mm: float) -> None:
        turn = turn_s(effect.after, radius_mm, radius_mm, self.settings)
        pass_s = abs(way_mm) / lead_mm * turn if lead_mm > 0.0 else math.nan
        if not math.isfinite(pass_s):
            self.clock.cannot(effect.block.line, "length, lead or spindle speed of this thread is not known")
            return
        machine = self.clock.machine
        back_s = rapid_s(machine, z_mm=way_mm) + 2.0 * rapid_s(machine, x_mm=_WAYS_MM)
        self.clock.assumed_axes |= {"Z"} if machine.assumes_rapids[2] else set()
        self.clock.add(CUTTING, passes * pass_s)
        self.clock.add(RAPIDS, passes * back_s)


def _or_zero(value: float) -> float:
    return 0.0 if math.isnan(value) else value
