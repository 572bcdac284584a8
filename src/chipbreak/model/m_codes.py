"""M codes: the spindle, coolant, the end of the program, and how LinuxCNC keeps a state and gives it back."""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.dialects.modes import Group
from chipbreak.model.modal import State

_SPINDLE = {3: "cw", 4: "ccw", 5: "stop", 19: "stop"}
_ENDS = (2, 30, 99)
_KEEPS = (70, 73)
_GIVES_BACK = 72
# Where these change, the numbers of a position mean another place.
_PLACING: frozenset[Group] = frozenset({"work_offset", "length_offset", "diameter"})


def m_code(state: State, code: int, dialect: Dialect) -> State:
    """The state behind an M code."""
    if code in _SPINDLE:
        return state._replace(spindle=_SPINDLE[code])
    if code in (7, 8):
        return state._replace(coolant=state.coolant | {"mist" if code == 7 else "flood"})
    if code == 9:
        return state._replace(coolant=frozenset())
    if code in _ENDS:
        return state._replace(ended=True)
    if dialect.keeps_modes:
        if code in _KEEPS:
            return state._replace(kept=state._replace(kept=None))
        if code == _GIVES_BACK and state.kept is not None:
            return _given_back(state, state.kept)
    return state


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
