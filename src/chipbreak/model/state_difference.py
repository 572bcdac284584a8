"""What differs between two states of a control, said in a few words for a message."""

from __future__ import annotations

import math
from collections.abc import Callable

from chipbreak.dialects.modes import UNSAID
from chipbreak.model.giving_back import is_same, is_same_path_mode
from chipbreak.model.modal import Setting, State
from chipbreak.text.named_tuple import NamedTuple

# Half a last digit of six in inches.
_SAME_MM = 2e-5
# More than anybody types, fewer than conversion leaves right.
_DIGITS = 9

_Rule = Callable[[State, State], str]


def difference(was: State, now: State) -> str:
    """The first thing other than position and spindle speed that differs; empty where nothing does.

    Where ``was`` says nothing (a path mode that was given back as usual) there is nothing to differ from.
    """
    return next((said for rule in _RULES if (said := rule(was, now))), "")


def _modal_groups(was: State, now: State) -> str:
    said = {group for group in was.modes.changed(now.modes) if was.modes.value(group) != UNSAID}
    groups = said - {"speed_mode"}
    return f"the modal state ({', '.join(sorted(groups))})" if groups else ""


def _path_mode(was: State, now: State) -> str:
    return "the path mode" if was.path_words and not is_same_path_mode(was, now) else ""


def _smoothing(was: State, now: State) -> str:
    return "the smoothing" if was.smooth_words and was.smooth_words != now.smooth_words else ""


def _feed(was: State, now: State) -> str:
    return "" if is_same(was.feed, now.feed) else "the feed"


def _speed_limit(was: State, now: State) -> str:
    # A speed mode that was changed on purpose takes its limit with it, until both come back.
    if was.modes.speed_mode != now.modes.speed_mode:
        return ""
    return "the limit of the spindle" if _value(was.speed_limit) != _value(now.speed_limit) else ""


def _tool(was: State, now: State) -> str:
    return "the tool" if was.tool != now.tool else ""


def _spindle(was: State, now: State) -> str:
    return "the spindle" if was.spindle != now.spindle else ""


def _choice(was: State, now: State) -> str:
    return "the choice of spindle" if was.choice != now.choice else ""


def _path(was: State, now: State) -> str:
    return "the path" if was.path != now.path else ""


def _coolant(was: State, now: State) -> str:
    return "the coolant" if was.coolant != now.coolant else ""


_RULES: tuple[_Rule, ...] = (
    _modal_groups,
    _path_mode,
    _smoothing,
    _feed,
    _speed_limit,
    _tool,
    _spindle,
    _choice,
    _coolant,
    _path,
)


class SpindleSpeed(NamedTuple):
    """The commanded spindle speed: its mode, S and the limit, None where one is not known."""

    mode: str
    value: float | None
    limit_rpm: float | None


def spindle_speed(state: State) -> SpindleSpeed:
    """The spindle speed of a state; one that was converted comes back but for its last digits."""
    speed = _value(state.speed)
    rounded = None if speed is None else float(f"{speed:.{_DIGITS}g}")
    return SpindleSpeed(state.modes.speed_mode, rounded, _value(state.speed_limit))


def is_same_place(was: State, now: State) -> bool:
    """True where the tool stands exactly where it stood, or nowhere that is known in both."""
    pairs = zip(was.position, now.position, strict=True)
    return all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in pairs)


def moved(was: State, now: State, near_mm: float = _SAME_MM) -> str:
    """Which axis does not stand where it stood; what is given back has as many digits as the program."""
    for axis, a, b in zip("XYZ", was.position, now.position, strict=True):
        if not (math.isnan(a) and math.isnan(b)) and not abs(a - b) <= max(near_mm, _SAME_MM):
            return f"the position of {axis} ({a:g} and {b:g})"
    return ""


def _value(setting: Setting | None) -> float | None:
    return None if setting is None or math.isnan(setting.value) else setting.value
