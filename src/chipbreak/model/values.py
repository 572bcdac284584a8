"""What a block sets: feed, speed and its limit, the modal groups, and which positions they make unknown.

Each rule looks at one thing; they run in the order of ``_RULES``, which is the order in which a control acts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from chipbreak.dialects import Dialect
from chipbreak.dialects.modes import Group
from chipbreak.dialects.numbers import NumberRule
from chipbreak.dialects.path_mode import has_lengths
from chipbreak.model.codes import BlockCodes
from chipbreak.model.modal import UNKNOWN, Setting, State
from chipbreak.model.words import codes_of, feed_of, makes_a_limit, plain_value, speed_of, surface_limit
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple

# The words beside G64 and beside G5.1 that are theirs.
MODE_LETTERS: Mapping[str, str] = FrozenTable({"path": "PQ", "look_ahead": "PQR"})
_COORDINATE_GROUPS: frozenset[Group] = frozenset(
    {"work_offset", "rotation", "polar", "scaling", "mirror", "interpolation"}
)


class Said(NamedTuple):
    """A block with what its codes say; ``was`` is the state before it, ``vibration`` its words for that."""

    block: Block
    codes: BlockCodes
    was: State
    vibration: tuple[Word, ...]
    dialect: Dialect
    number_rule: NumberRule


def values_after(said: Said) -> State:
    """The state with all that the words and the modal codes of a block set, before anything moves."""
    modes = said.codes.modes
    after = said.was if modes is said.was.modes else said.was._replace(modes=modes)
    if said.codes.changes:
        after = after.said(*said.codes.changes) if after.left_open else after
        for rule in _RULES:
            after = rule(after, said)
    return _feed_and_speed(after, said)


def _feed_ends(after: State, said: Said) -> State:
    """An F of another feed mode is no feed any more; one of other units on controls that convert none."""
    was = said.was.modes
    other_units = after.modes.units != was.units and not said.dialect.converts_feed
    ends = after.modes.feed_mode != was.feed_mode or other_units
    return after._replace(feed=None) if ends else after


def _speed_ends(after: State, said: Said) -> State:
    """An S in rpm is no surface speed, and the other way round; see F for one of other units."""
    was = said.was.modes
    is_surface = was.speed_mode == "surface"
    other_units = is_surface and after.modes.units != was.units and not said.dialect.converts_feed
    return after._replace(speed=None) if after.modes.speed_mode != was.speed_mode or other_units else after


def _cycle_begins(after: State, said: Said) -> State:
    """The motion code under which a cycle begins is kept for the G80 that leaves it in force."""
    was = said.was.modes.motion
    begins = after.modes.motion == "cycle" != was
    return after._replace(motion_before_cycle=was) if begins else after


def _surface_limit(after: State, said: Said) -> State:
    """``G96 D2000``."""
    if "speed_mode" not in said.codes.changes or not said.dialect.surface_limit:
        return after
    return after._replace(speed_limit=surface_limit(said.block, after.modes.speed_mode, said.dialect))


def _path_words(after: State, said: Said) -> State:
    """``G64 P0.01 Q0.005``."""
    if "path" not in said.codes.changes:
        return after
    # G61 has none: P beside it is another code's.
    letters = MODE_LETTERS["path"] if after.modes.path == "blend" else ""
    words = _own_words(said, "path", letters)
    return after._replace(path_words=words, path_units=after.modes.units if has_lengths(words) else "mm")


def _smooth_words(after: State, said: Said) -> State:
    """``G5.1 Q1 R3``."""
    if "look_ahead" not in said.codes.changes:
        return after
    return after._replace(smooth_words=_own_words(said, "look_ahead", MODE_LETTERS["look_ahead"]))


def _own_words(said: Said, group: Group, letters: str) -> str:
    """A mode in the program's own words, the code and those of these letters."""
    codes = {number / 10.0 for number in codes_of(said.block, group, said.dialect)}
    words = [w for w in said.block.words_of(f"G{letters}") if w.address != "G" or w.number in codes]
    return " ".join(map(said.block.text_of, words))


def _coordinates(after: State, said: Said) -> State:
    """Another origin or another direction of the axes: the numbers of a position mean another place."""
    if _COORDINATE_GROUPS.isdisjoint(said.codes.changes):
        return after
    worked_out = "work_offset" in said.codes.changes and said.block.has_macro
    if worked_out or _COORDINATE_GROUPS.intersection(said.was.modes.changed(after.modes)):
        return after.lost("the coordinate system changed")
    return after


def _length_offset(after: State, said: Said) -> State:
    """G43 gives Z another zero, also where it was on; G49 does where something was on."""
    new = said.codes.changes.get("length_offset")
    if new is None or new == said.was.modes.length_offset == "off":
        return after
    position = after.position._replace(z=UNKNOWN)
    return after._replace(position=position, unknown_why="tool length compensation changed Z")


_Rule = Callable[[State, Said], State]
_RULES: tuple[_Rule, ...] = (
    _feed_ends,
    _speed_ends,
    _cycle_begins,
    _surface_limit,
    _path_words,
    _smooth_words,
    _coordinates,
    _length_offset,
)


def _feed_and_speed(after: State, said: Said) -> State:
    """F, and S or the limit of S, where no code of the block takes them for itself."""
    words = said.block.words_of("FS")
    if not words:  # as in most blocks
        return after
    line = said.block.line
    is_limit = makes_a_limit(said.block, said.dialect)
    vibration_at = {word.start for word in said.vibration}
    for word in words:
        if word.start in vibration_at or word.address in said.codes.taken:
            continue
        if word.address == "F":
            after = after._replace(feed=feed_of(word, _read_in(after, said), said.number_rule, line))
        elif is_limit:
            after = after._replace(speed_limit=Setting(plain_value(word), word.value_text, line))
        else:
            after = after._replace(speed=speed_of(word, _read_in(after, said), line))
    return after


def _read_in(after: State, said: Said) -> State:
    """The state whose units F and S are read in: on some controls those before the block's G20 or G21."""
    units = said.was.modes.units
    if not said.dialect.feed_before_units or units == after.modes.units:
        return after
    return after._replace(modes=after.modes._replace(units=units))
