"""Drilling, boring and tapping cycles: rapid over the hole, feed or pecks down to Z, back to R or higher.

::

    G98 G83 X20. Y10. Z-30. R2. Q5. F200     rapid to X Y, rapid to R, pecks of 5 mm, rapid back
"""

from __future__ import annotations

import math

from chipbreak.cycle_time.clock import CUTTING, DWELLS, RAPIDS, Clock
from chipbreak.cycle_time.feed import counted_mm, rapid_s, turn_s, word_mm
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.modal import State
from chipbreak.model.words import plain_value
from chipbreak.settings.sections import Settings
from chipbreak.units import S_PER_MIN

_FEEDS_BACK = frozenset({84, 74, 85, 88, 89})
_PECKS_OUT = 83
_PECKS_SHORT = 73
_CHIP_BREAK_MM = 0.5  # what G73 goes back after each peck
_MOST_PECKS = 10_000


class Drilling:
    """The cycle that is in force, with what its blocks have said so far."""

    def __init__(self, settings: Settings, clock: Clock) -> None:
        self.settings = settings
        self.clock = clock
        self.code = 0
        self.words: dict[str, float] = {}
        self.initial_mm = math.nan

    def time(self, effect: BlockEffect) -> bool:
        """Add the time of the holes of a block; False where no such cycle is in force."""
        if effect.after.modes.motion != "cycle":
            return False
        if effect.before.modes.motion != "cycle":
            self.words = {}
            self.initial_mm = effect.before.position.z
        self._keep(effect)
        if effect.move is None:
            return True
        count = max(1, int(effect.block.number("K") or effect.block.number("L") or 1))
        self._holes(effect, count)
        return True

    def _keep(self, effect: BlockEffect) -> None:
        codes = [int(number) for number in effect.block.numbers("G") if 73 <= number <= 89]
        self.code = codes[-1] if codes else self.code
        for letter in "ZR":
            value = word_mm(effect, letter, self.settings)
            self.words |= {} if math.isnan(value) else {letter: value}
        peck = counted_mm(effect, "Q", self.settings)
        if self.settings.number_rule.reads_whole:
            peck = word_mm(effect, "Q", self.settings)
        self.words |= {} if math.isnan(peck) else {"Q": peck}
        pause = effect.block.word("P")
        if pause is not None:
            in_seconds = pause.has_point or self.settings.dialect.dwell_word == "P"
            self.words["P"] = plain_value(pause) / (1.0 if in_seconds else 1000.0)

    def _holes(self, effect: BlockEffect, count: int) -> None:
        state = effect.after
        top_mm, bottom_mm = self._heights(state)
        speed = self._feed_mm_s(state)
        depth_mm = top_mm - bottom_mm
        move = effect.move
        if move is None or not (speed > 0.0 and math.isfinite(depth_mm)):
            self.clock.cannot(effect.block.line, "depth, R or feed of this hole is not known")
            return
        machine = self.clock.machine
        position = effect.before.position
        over = [end - start for end, start in zip(move.end[:2], position[:2], strict=True)]
        over = [way for way in over if math.isfinite(way)] + [0.0, 0.0]
        back_to = top_mm if state.modes.return_level == "r-plane" else max(self.initial_mm, top_mm)
        height = back_to - top_mm if math.isfinite(back_to) else 0.0
        rapids = rapid_s(machine, over[0], over[1]) + rapid_s(machine, z_mm=height)
        feeds = depth_mm / speed
        if self.code in _FEEDS_BACK:
            feeds += depth_mm / speed
            rapids += rapid_s(machine, z_mm=height)
        else:
            rapids += rapid_s(machine, z_mm=depth_mm + height)
        pecks_s, again_s = self._pecks(depth_mm, speed)
        self.clock.add(CUTTING, count * (feeds + again_s))
        self.clock.add(RAPIDS, count * (rapids + pecks_s))
        self.clock.add(DWELLS, count * self.words.get("P", 0.0))
        self.clock.assumed_axes |= {"Z"} if machine.assumes_rapids[2] else set()

    def _heights(self, state: State) -> tuple[float, float]:
        """Z of R and of the bottom."""
        top = self.words.get("R", self.initial_mm)
        bottom = self.words.get("Z", math.nan)
        if state.modes.distance == "incremental":
            top += self.initial_mm if "R" in self.words else 0.0
            bottom += top
        return top, bottom

    def _feed_mm_s(self, state: State) -> float:
        feed = state.feed
        if feed is None or not feed.value > 0.0:
            return math.nan
        if state.modes.feed_mode == "rev":
            return feed.value / turn_s(state, 0.0, 0.0, self.settings)
        return feed.value / S_PER_MIN

    def _pecks(self, depth_mm: float, speed_mm_s: float) -> tuple[float, float]:
        """Rapids between the pecks, and what is fed twice [s]."""
        peck_mm = self.words.get("Q", 0.0)
        if not peck_mm > 0.0 or self.code not in (_PECKS_OUT, _PECKS_SHORT):
            return 0.0, 0.0
        between = min(_MOST_PECKS, math.ceil(depth_mm / peck_mm - 1e-9) - 1)
        if self.code == _PECKS_SHORT:
            return between * rapid_s(self.clock.machine, z_mm=_CHIP_BREAK_MM), 0.0
        ways = [2.0 * rapid_s(self.clock.machine, z_mm=number * peck_mm) for number in range(1, between + 1)]
        return sum(ways), 0.0
