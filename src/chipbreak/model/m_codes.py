"""M codes: the spindle, coolant, the end of the program, and how LinuxCNC keeps a state and gives it back."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from chipbreak.dialects.base import MCode
from chipbreak.dialects.modes import Group
from chipbreak.model.modal import State

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
    """M72 gives back all but the motion mode, the position and the tool."""
    modes = kept.modes._replace(motion=state.modes.motion)
    after = state._replace(
        modes=modes,
        feed=kept.feed,
        speed=kept.speed,
        spindle=kept.spindle,
        coolant=kept.coolant,
        path_words=kept.path_words,
        # It says G96 without the D of the program.
        speed_limit=None,
    )
    if _PLACING.intersection(state.modes.changed(modes)):
        after = after.lost("M72 gave another offset back")
    return after


_CHANGES: Mapping[str, Callable[[State, str], State]] = {
    "spindle": _spindle,
    "coolant": _coolant,
    "program": _end,
    "subprogram": _subprogram,
    "modes": _modes,
}
