"""M codes: the spindle, coolant, the end of the program, and how LinuxCNC keeps a state and gives it back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from chipbreak.dialects.base import MCode
from chipbreak.dialects.modes import Group, Units
from chipbreak.model.modal import Setting, State
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

    It says what is no longer so, in words: no number that is the same, and another one rounded, F to a tenth
    and S to a whole number, to be read in the units that are given back.
    """
    modes = kept.modes._replace(motion=state.modes.motion)
    after = state._replace(
        modes=modes,
        feed=_feed_given_back(state, kept),
        speed=_speed_given_back(state, kept),
        spindle=kept.spindle,
        coolant=kept.coolant,
        path_words=kept.path_words,
        # Its number comes back as a number.
        path_units=state.path_units if state.path_words == kept.path_words else kept.modes.units,
        # Where it says G96, then without the D of the program.
        speed_limit=state.speed_limit if state.modes.speed_mode == modes.speed_mode else None,
    )
    if _PLACING.intersection(state.modes.changed(modes)):
        after = after.lost("M72 gave another offset back")
    return after


def _feed_given_back(state: State, kept: State) -> Setting | None:
    if _feed_number(state) != _feed_number(kept):
        feed = kept.feed
        scale = 1.0 if kept.modes.feed_mode == "inverse" else kept.mm_per_unit
        return feed and _rounded(feed, _feed_number(kept), 1, scale, kept.modes.units)
    return state.feed if state.modes.feed_mode == kept.modes.feed_mode else None  # which G94 and G95 end


def _speed_given_back(state: State, kept: State) -> Setting | None:
    if _speed_number(state) == _speed_number(kept) and state.modes.speed_mode == kept.modes.speed_mode:
        return state.speed
    is_surface = kept.modes.speed_mode == "surface"
    scale = surface_speed_m_min(1.0, is_inch=kept.is_inch) if is_surface else 1.0
    return kept.speed and _rounded(kept.speed, _speed_number(kept), 0, scale, kept.modes.units)


def _rounded(kept: Setting, number: float, decimals: int, scale: float, units: Units) -> Setting:
    """A number as M72 says it: the kept one where rounding leaves it alone, else one that is not known."""
    value = kept.value if units == kept.units else number * scale
    return kept._replace(value=value if round(number, decimals) == number else math.nan, units=units)


def _feed_number(state: State) -> float:
    """F as it was typed; 0 without."""
    if state.feed is None:
        return 0.0
    is_inch = state.feed.units == "inch" and state.modes.feed_mode != "inverse"
    return typed_feed(state.feed.value, is_inch=is_inch)


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
