"""How long one block takes.  What it can be is a tuple of small rules: the first that knows it times it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from chipbreak.cycle_time.clock import CUTTING, DWELLS, RAPIDS, Clock
from chipbreak.cycle_time.drilling import Drilling
from chipbreak.cycle_time.feed import feed_time_s, path_length_mm, way_mm
from chipbreak.cycle_time.threading import Threading
from chipbreak.kinematics.move_times import rapid_times_s
from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.unread_words import says_turns
from chipbreak.model.words import plain_value
from chipbreak.settings.sections import Settings

_UNKNOWN_FEED = "its feed or spindle speed is not known"
_UNREAD_ARC = "what a word of this arc says is not known"
_UNKNOWN_PLACE = "where it begins or ends is not known"
_LOOPS = frozenset({"WHILE", "DO", "GOTO", "O-WHILE", "O-DO", "O-REPEAT"})
_CYCLES = {
    "rough-cycle": "a roughing cycle",
    "finish-cycle": "a finishing cycle",
    "peck-cycle": "a pecking cycle",
    "service": "a service code",
}


class BlockTimer:
    """Times blocks one by one; remembers what drilling and threading cycles keep."""

    def __init__(self, settings: Settings, clock: Clock) -> None:
        self.settings = settings
        self.clock = clock
        self.drilling = Drilling(settings, clock)
        self.threading = Threading(settings, clock)

    def time(self, effect: BlockEffect) -> None:
        """Add the time of a block, or say why it has none that is known."""
        if effect.in_contour or effect.block.opaque:
            return
        if any(control.keyword in _LOOPS for control in effect.block.controls):
            self.clock.counted_once = True
        self._change(effect)
        for rule in _RULES:
            if rule(self, effect):
                return

    def _change(self, effect: BlockEffect) -> None:
        dialect = self.settings.dialect
        if dialect.tool_by_word:
            other = effect.block.has("T") and effect.after.tool not in (None, effect.before.tool)
        else:
            other = effect.does("tool", "change")
        if other:
            self.clock.change_tool()

    def _dwell(self, effect: BlockEffect) -> bool:
        if "dwell" not in effect.non_modal:
            return False
        self.clock.add(DWELLS, dwell_s(effect, self.settings))
        return effect.move is None

    def _home(self, effect: BlockEffect) -> bool:
        if not {"home", "machine"} & effect.non_modal:
            return False
        self.clock.rapid_without_place()
        return True

    def _thread_cycle(self, effect: BlockEffect) -> bool:
        return self.threading.time(effect)

    def _drilling_cycle(self, effect: BlockEffect) -> bool:
        return self.drilling.time(effect)

    def _cycle(self, effect: BlockEffect) -> bool:
        for value, title in _CYCLES.items():
            if value in effect.non_modal:
                self.clock.cannot(effect.block.line, f"{title} moves the tool")
                return True
        return False

    def _move(self, effect: BlockEffect) -> bool:
        move = effect.move
        if move is None or move.kind == "other":
            return move is not None and self._unknown_move(effect)
        if move.kind == "rapid":
            return self._rapid(move)
        length_of = path_length_mm(move)
        if self._has_unread_arc(effect):
            self.clock.cannot(effect.block.line, _UNREAD_ARC)
            return True
        if not math.isfinite(length_of):
            self.clock.cannot(effect.block.line, _UNKNOWN_PLACE)
            return True
        time_s = feed_time_s(effect.after, move, length_of, self.settings)
        if math.isfinite(time_s):
            self.clock.add(CUTTING, time_s)
        else:
            self.clock.cannot(effect.block.line, _UNKNOWN_FEED)
        return True

    def _has_unread_arc(self, effect: BlockEffect) -> bool:
        """True for an arc with a word that nothing reads: P may be turns, or a widening."""
        is_arc = effect.move is not None and effect.move.kind in ("cw", "ccw")
        return is_arc and any(not says_turns(effect, w, self.settings.dialect) for w in effect.unread)

    def _unknown_move(self, effect: BlockEffect) -> bool:
        self.clock.cannot(effect.block.line, "what moves there is not followed")
        return True

    def _rapid(self, move: Move) -> bool:
        way = np.array([way_mm(move.end, move.start, axis, move.axes) for axis in "XYZ"])[np.newaxis]
        if np.isnan(way).any():
            self.clock.rapid_without_place()
            return True
        self.clock.moved(way)
        machine = self.clock.machine
        times = rapid_times_s(way, machine.speed_mm_s, machine.acceleration_mm_s2)
        self.clock.add(RAPIDS, float(times[0]))
        return True


_RULES: tuple[Callable[[BlockTimer, BlockEffect], bool], ...] = (
    BlockTimer._dwell,
    BlockTimer._home,
    BlockTimer._thread_cycle,
    BlockTimer._drilling_cycle,
    BlockTimer._cycle,
    BlockTimer._move,
)


def dwell_s(effect: BlockEffect, settings: Settings) -> float:
    """The time of a G4 block [s]; 0 where it cannot be read."""
    dialect = settings.dialect
    seconds = {"X", "U"} if dialect.dwell_word in "XU" else set()
    for word in effect.block.words_of("XUPF"):
        value = plain_value(word)
        if word.address in seconds:
            is_whole = word.has_point or settings.number_rule.reads_whole
            return value if is_whole else value * settings.control.increment_mm
        if word.address == dialect.dwell_word:
            return value / dialect.dwells_per_s
        if word.address == "P":
            # Where X has the seconds, P counts milliseconds, with a point (Haas) seconds.
            return value if word.has_point else value / 1000.0
    return 0.0
