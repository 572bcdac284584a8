"""M codes: the spindle, coolant, the end of the program, and how LinuxCNC keeps a state and gives it back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from chipbreak.dialects.base import MCode
from chipbreak.dialects.modes import Group, Units
from chipbreak.model.giving_back import is_same
from chipbreak.model.modal import LeftOpen, Setting, State
from chipbreak.syntax.numbers import print_number
from chipbreak.units import surface_speed_m_min, typed_feed, typed_surface_speed

# Where these change, the numbers of a position mean another place.
_PLACING: frozenset[Group] = frozenset({"work_offset", "length_offset", "diameter"})


def m_code(state: State, code: MCode) -> State:
    """The state behind an M code."""
    change = _CHANGES.get(code.group)
    after = change(state, code.value) if change else state
    return _coolant(after, code.coolant) if code.coolant else after


def _spindle(state: State, value: str) -> State:
    return state._replace(spindle=value, spindle_why="")


def _coolant(state: State, value: str) -> State:
    return state._replace(coolant=frozenset() if value == "off" else state.coolant | {value})


def _end(state: State, _: str) -> State:
    return state._replace(ended=True)


def _subprogram(state: State, value: str) -> State:
    return state._replace(ended=True) if value == "return" else state


def _modes(state: State, value: str) -> State:
    if value == "keep":
        return state._replace(kept=state._replace(kept=None))
    return state if state.kept is None else _given_back(state, state.kept)


def _given_back(state: State, kept: State) -> State:
    """M72 gives back all but the motion mode, the position and the tool.

    It says that in words: F rounded to a tenth and S to a whole number, in the units that are given back.
    Before LinuxCNC 2.9 it says no number that is the same, and since then every one; where that matters,
    F and S are not known.
    """
    modes = kept.modes._replace(motion=state.modes.motion)
    after = state._replace(
        modes=modes,
        feed=_feed_given_back(state, kept),
        speed=_speed_given_back(state, kept),
        spindle=kept.spindle,
        spindle_why=kept.spindle_why,
        coolant=kept.coolant,
        path_words=kept.path_words,
        path_units=kept.path_units,
        left_open=_left_open_given_back(state, kept),
        # Where it says G96, then without the D of the program.
        speed_limit=state.speed_limit if state.modes.speed_mode == modes.speed_mode else None,
    )
    if _PLACING.intersection(state.modes.changed(modes)):
        after = after.lost("M72 gave another offset back")
    return after


def _left_open_given_back(state: State, kept: State) -> LeftOpen:
    """Each group is as sure as it was when it was kept; the motion mode as it is."""
    motion = [one for one in state.left_open if one[0] == "motion"]
    return tuple(sorted([*motion, *(one for one in kept.left_open if one[0] != "motion")]))


def _feed_given_back(state: State, kept: State) -> Setting | None:
    scale = 1.0 if kept.modes.feed_mode == "inverse" else kept.mm_per_unit
    said = kept.feed and _rounded(kept.feed, _feed_number(kept), 1, scale, kept.modes.units)
    if _feed_number(state) != _feed_number(kept):
        return said
    stays = state.feed if state.modes.feed_mode == kept.modes.feed_mode else None  # which G94 and G95 end
    return _in_all_releases(stays, said)


def _speed_given_back(state: State, kept: State) -> Setting | None:
    is_surface = kept.modes.speed_mode == "surface"
    scale = surface_speed_m_min(1.0, is_inch=kept.is_inch) if is_surface else 1.0
    said = kept.speed and _rounded(kept.speed, _speed_number(kept), 0, scale, kept.modes.units)
    if _speed_number(state) != _speed_number(kept) or state.modes.speed_mode != kept.modes.speed_mode:
        return said
    return _in_all_releases(state.speed, said)


def _in_all_releases(stays: Setting | None, said: Setting | None) -> Setting | None:
    """What stays where nothing is said, if that is what is said as well; else one that is not known."""
    one = stays or said
    return one if one is None or is_same(stays, said) else one._replace(value=math.nan)


def _rounded(kept: Setting, number: float, decimals: int, scale: float, units: Units) -> Setting:
    """A number as M72 says it: the kept one where rounding leaves it alone, else one that is not known."""
    if round(number, decimals) != number:
        return kept._replace(value=math.nan, units=units)
    if units == kept.units:
        return kept
    return kept._replace(value=number * scale, text=print_number(number, decimals), units=units)


def _feed_number(state: State) -> float:
    """The number that the control has for F, 0 without: G20 and G21 make another one of a feed per minute."""
    if state.feed is None:
        return 0.0
    units = state.modes.units if state.modes.feed_mode == "minute" else state.feed.units
    return typed_feed(state.feed.value, is_inch=units == "inch" and state.modes.feed_mode != "inverse")


def _speed_number(state: State) -> float:
    """S as it was typed; 0 without."""
    if state.speed is None:
        return 0.0
    is_inch = state.speed.units == "inch" and state.modes.speed_mode == "surface"
    return typed_surface_speed(state.speed.value, is_inch=is_inch)


_CHANGES: Mapping[str, Callable[[State, str], State]] = {
    "spindle": _spindle,
    "coolant": _coolant,
    "program": _end,
    "subprogram": _subprogram,
    "modes": _modes,
}
