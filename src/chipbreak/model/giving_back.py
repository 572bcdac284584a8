"""A feed, a speed and a path mode as words that set them again, in the units that are in force by then."""

from __future__ import annotations

import math
from typing import Protocol

from chipbreak.dialects import Dialect
from chipbreak.dialects.path_mode import has_lengths
from chipbreak.model.modal import Setting, State
from chipbreak.syntax.numbers import print_number
from chipbreak.units import typed_feed, typed_surface_speed

# A feed that is converted has so many digits, so it is off by less than this share.
_DIGITS = 8
CONVERTED_SHARE = 1e-7
_DECIMALS = 12


def feed_text(state: State) -> str:
    """The number of the F in force: as the program wrote it, unless that was in other units; "" unknown."""
    feed = state.feed
    if feed is None or math.isnan(feed.value):
        return ""
    if feed.units == state.modes.units or state.modes.feed_mode == "inverse":
        return feed.text
    typed = typed_feed(feed.value, is_inch=state.is_inch)
    return print_number(float(f"{typed:.{_DIGITS}g}"), _DECIMALS)


def feed_blocks(state: State, dialect: Dialect) -> list[str]:
    """The F in force, with the number that the program wrote: ``#<_feed>`` and M70 read that."""
    feed = state.feed
    if feed is None or math.isnan(feed.value):
        return []
    text = feed_text(state)
    if text == feed.text or not dialect.feed_before_units:
        return [f"F{text}"]
    # The F is read in the units before those of its block.
    was, now = (dialect.code("units", units) for units in (feed.units, state.modes.units))
    return [was, f"{now} F{feed.text}"]


def speed_text(state: State) -> str:
    """The number of the S in force: as the program wrote it, unless that was in other units; "" unknown."""
    speed = state.speed
    if speed is None or math.isnan(speed.value):
        return ""
    if speed.units == state.modes.units or state.modes.speed_mode == "rpm":
        return speed.text
    return print_number(typed_surface_speed(speed.value, is_inch=state.is_inch), _DECIMALS, point=False)


def path_mode_blocks(state: State, dialect: Dialect) -> list[str]:
    """The path mode in force, in the program's own words and its own units; nothing where it said none."""
    if not state.path_words:
        return []
    if not has_lengths(state.path_words) or state.path_units == state.modes.units:
        return [state.path_words]
    was, now = (dialect.code("units", units) for units in (state.path_units, state.modes.units))
    return [f"{was} {state.path_words}", now]


class PathMode(Protocol):
    """The path mode as a program said it, and the units of its words."""

    @property
    def path_words(self) -> str: ...  # noqa: D102

    @property
    def path_units(self) -> str: ...  # noqa: D102


def is_same_path_mode(was: PathMode, now: PathMode) -> bool:
    """True for the same words in the same units."""
    same_units = was.path_units == now.path_units or not has_lengths(was.path_words)
    return same_units and was.path_words == now.path_words


def is_same(one: Setting | None, other: Setting | None) -> bool:
    """True where both set the same value; one that was converted may differ in its last digits."""
    if one is None or other is None or math.isnan(one.value) or math.isnan(other.value):
        return _is_unknown(one) and _is_unknown(other)
    share = CONVERTED_SHARE if one.units != other.units else 0.0
    return abs(one.value - other.value) <= share * abs(one.value)


def _is_unknown(setting: Setting | None) -> bool:
    return setting is None or math.isnan(setting.value)
