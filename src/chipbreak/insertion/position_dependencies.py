"""What the blocks after a candidate rely on: the place of the tool there, and its length offset.

An inserted check leaves the tool retracted, somewhere over the laser.  Blocks that first bring it into place
by themselves (rapid, absolute: first X and Y, then Z) rely on nothing.  Everything else does: a cut or a
distance from where the tool is, a way down before X and Y are in place, a slanting way down that would now
start elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field

from chipbreak.dialects import Dialect
from chipbreak.dialects.modes import Group
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of, plain_value
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.operations.operations import calls_tool
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.variables import variables_of
from chipbreak.text.named_tuple import NamedTuple

# Where this many blocks have not decided it, they are taken to rely on everything.
HORIZON = 400
_HARMLESS = frozenset({"dwell", "exact-stop", "tuning", "data-setting", "data-setting-end", "shift"})
# Where these are on, a word of one axis moves another.
_BENT: tuple[Group, ...] = (
    "rotation",
    "polar",
    "interpolation",
    "cylinder",
    "mirror",
    "scaling",
    "modal_macro",
)


class PositionDependencies(NamedTuple):
    """``axes`` that must be where they were; whether the length offset must be in force again."""

    axes: frozenset[str]
    length_offset: bool


# What a walk has found out so far, and from which to which line (exclusive) no block adds to that.
QuietRuns = dict[Hashable, tuple[int, int]]


def position_dependencies(
    interpreted: InterpretedProgram,
    line: int,
    homed: Collection[str],
    quiet_runs: QuietRuns,
    *,
    has_offset: bool,
    home_ends_offset: bool = True,
) -> PositionDependencies:
    """What the blocks from ``line`` on rely on.

    ``homed`` are axes the program itself has sent to a fixed place: a tool change and the end of the
    program may count on that.  ``has_offset`` is True where a length offset is in force that the retract
    would end.  ``home_ends_offset`` is False for calls that end it also on a control whose own way home does
    not: blocks after that way home may then still rely on it.  ``quiet_runs``, which grows here, is that of
    all the walks in this program.
    """
    walk = _Walk(
        interpreted, frozenset(homed), offset_is_decided=not has_offset, home_ends_offset=home_ends_offset
    )
    last = min(line + HORIZON, interpreted.program.source.body.stop)
    while line < last and not walk.is_decided:
        line = walk.through_quiet_run(line, last, quiet_runs)
    if not walk.is_decided and last < interpreted.program.source.body.stop:
        walk.rely_on_all()
    return PositionDependencies(frozenset(walk.axes), walk.length_offset)


def named_axes(effect: BlockEffect, settings: Settings) -> frozenset[str]:
    """The linear axes that a block names."""
    axes = settings.axis_words.axes
    return frozenset(axes.get(w.address, "") for w in effect.block.words) & frozenset(AXES)


def homed_axes(effect: BlockEffect, settings: Settings) -> frozenset[str]:
    """The axes a reference return takes home; one that names none, not even a rotary axis, means all."""
    linear = settings.axis_words.axes
    rotary = any(word.address not in linear for word in effect.block.words_of("ABC"))
    return named_axes(effect, settings) or frozenset("" if rotary else AXES)


def reads_position(effect: BlockEffect, dialect: Dialect) -> bool:
    """True for a block that works with the place where the tool is.

    ``X[#5420+5]``, ``#100=#5041``, and LinuxCNC's G28.1 and G30.1, which keep that place, or G10 L10,
    L11 and L20, which give it other numbers.
    """
    if "store-home" in effect.non_modal:
        return True
    if dialect.place_settings and "data-setting" in effect.non_modal:
        kind = effect.block.word("L")
        setting = math.nan if kind is None else plain_value(kind)
        return math.isnan(setting) or setting in dialect.place_settings
    if not effect.block.has_macro and not effect.block.assignments and not effect.block.controls:
        return False
    return any(key is None or key in dialect.place_variables for key in variables_of(effect.block))


def relies_on_speed(interpreted: InterpretedProgram, line: int) -> bool:
    """True when the spindle is started after ``line`` without a new S."""
    for effect in interpreted.effects_of(line, min(line + HORIZON, interpreted.program.source.body.stop)):
        if effect.in_contour:
            continue  # roughing passes over its S
        if effect.says("S") or effect.after.ended:
            return False
        if effect.does("spindle", "cw", "ccw"):
            return True
    return False


@dataclass
class _Walk:
    """The walk along the blocks.

    A rule about axes returns True when they are decided, False when the next block has to be looked at, and
    None when it has nothing to say of a block.
    """

    interpreted: InterpretedProgram
    homed: frozenset[str]
    offset_is_decided: bool
    home_ends_offset: bool
    axes_are_decided: bool = False
    axes: set[str] = field(default_factory=set)
    placed: set[str] = field(default_factory=set)
    length_offset: bool = False

    def __post_init__(self) -> None:
        self.dialect = self.interpreted.settings.dialect
        self.words = self.interpreted.settings.axis_words
        self.all_axes = frozenset("XZ" if self.dialect.is_lathe else "XYZ")

    @property
    def is_decided(self) -> bool:
        """True when the blocks so far say all there is to know."""
        return self.offset_is_decided and self.axes_are_decided

    def through_quiet_run(self, line: int, last: int, known: QuietRuns) -> int:
        """Look at blocks up to the first that says something, that one too; the line behind it.

        Candidates stand close together, and where nothing is decided for long each would walk the same way.
        """
        found = self._found()
        first = line
        begin, end = known.get(found, (last, last))
        if begin <= line <= end:
            first, line, begin = begin, end, last
        for effect in self.interpreted.effects_of(line, last):
            if line == begin:
                known[found] = (first, end)
                return min(end, last)
            self._look_at(effect)
            if self._found() != found:
                known[found] = (first, line)
                return line + 1
            line += 1
        known[found] = (first, line)
        return line

    def _found(self) -> Hashable:
        """All that the next blocks are judged by, and what they add to."""
        sets = (frozenset(self.axes), frozenset(self.placed), self.homed)
        return *sets, self.offset_is_decided, self.home_ends_offset, self.axes_are_decided, self.length_offset

    def _look_at(self, effect: BlockEffect) -> None:
        if effect.block.is_empty:
            return
        if not self.offset_is_decided:
            self._look_at_offset(effect)
        if not self.axes_are_decided:
            self.axes_are_decided = self._look_at_axes(effect)

    def rely_on_all(self) -> None:
        """Whatever is still open."""
        self.length_offset |= not self.offset_is_decided
        if not self.axes_are_decided:
            self._rely_on_rest()

    def _look_at_offset(self, effect: BlockEffect) -> None:
        """A new offset or the way home ends the old one; a move of Z in the program's coordinates uses it."""
        block = effect.block
        move = effect.move
        is_home = "home" in effect.non_modal and "Z" in homed_axes(effect, self.interpreted.settings)
        ends_it = bool(codes_of(block, "length_offset", self.dialect))
        if ends_it or (is_home and self.home_ends_offset):
            self.offset_is_decided = True
        elif move is not None and "machine" not in effect.non_modal:
            self.length_offset = "Z" in move.axes or move.kind != "rapid"
        else:
            acts = effect.non_modal - _HARMLESS - {"machine", "home"}
            acts |= {"data-setting"} & effect.non_modal if reads_position(effect, self.dialect) else set()
            self.length_offset = bool(block.opaque or block.controls or acts) or calls_subprogram(effect)
        self.offset_is_decided |= self.length_offset or effect.after.ended

    def _look_at_axes(self, effect: BlockEffect) -> bool:
        named = named_axes(effect, self.interpreted.settings)
        decisions = (rule(self, effect, named) for rule in self._AXIS_RULES)
        is_decided = next((decision for decision in decisions if decision is not None), False)
        return is_decided or effect.after.ended  # what moves in the last block moves before the end

    def _reads_or_calls(self, effect: BlockEffect, _: frozenset[str]) -> bool | None:
        block = effect.block
        acts = (
            block.opaque or block.controls or calls_subprogram(effect) or reads_position(effect, self.dialect)
        )
        return self._rely_on_rest() if acts else None

    def _may_set_modes(self, effect: BlockEffect, _: frozenset[str]) -> bool | None:
        """``/G91`` may be skipped, and what comes is a distance."""
        is_unsure = effect.block.is_optional and effect.before.modes != effect.after.modes
        return self._rely_on_rest() if is_unsure else None

    def _ends_or_calls_tool(self, effect: BlockEffect, named: frozenset[str]) -> bool | None:
        calls = calls_tool(effect, self.dialect)
        if not effect.after.ended and not calls:
            return None
        self.axes |= self.homed - self.placed - named
        # M6 takes Z home on most machines, on a LinuxCNC without a changer nothing at all: X and Y that are
        # not named after it are those from before.
        return not effect.block.is_optional if calls and self.dialect.tool_by_word else None

    def _goes_home(self, effect: BlockEffect, _: frozenset[str]) -> bool | None:
        if "home" not in effect.non_modal:
            return None
        # A home of the program's own (LinuxCNC's G28.1) may lie anywhere.
        is_own = any("store-home" in other.non_modal for other in self.interpreted.effects)
        return self._rely_on_rest() if is_own else self._home(effect)

    def _moves_in_machine(self, effect: BlockEffect, named: frozenset[str]) -> bool | None:
        return self._machine(effect, named) if "machine" in effect.non_modal else None

    def _acts_otherwise(self, effect: BlockEffect, named: frozenset[str]) -> bool | None:
        """A mode in which a word of one axis moves another, or a code that does more than move."""
        is_limit = "set-position" in effect.non_modal and not named  # G50 S2000
        is_bent = any(effect.after.modes.value(group) != "off" for group in _BENT)
        acts = is_bent or (effect.non_modal - _HARMLESS and not is_limit)
        return self._rely_on_rest() if acts else None

    def _does_not_move(self, effect: BlockEffect, named: frozenset[str]) -> bool | None:
        if effect.move is not None:
            return None
        # Axis words that were not read: a G code the profile does not know.
        return bool(named) and not effect.non_modal and self._rely_on_rest()

    def _moves(self, effect: BlockEffect, _: frozenset[str]) -> bool | None:
        move = effect.move
        if move is None or move.kind != "rapid" or move.incremental:
            return self._rely_on_rest()
        return self._rapid(frozenset(move.axes), effect.block.is_optional)

    # The first that has something to say of a block decides.
    _AXIS_RULES = (
        _reads_or_calls,
        _may_set_modes,
        _ends_or_calls_tool,
        _goes_home,
        _moves_in_machine,
        _acts_otherwise,
        _does_not_move,
        _moves,
    )

    def _rely_on_rest(self) -> bool:
        """All axes that are not in place yet."""
        self.axes |= self.all_axes - self.placed
        return True

    def _rapid(self, named: AbstractSet[str], may_be_skipped: bool) -> bool:
        if not self.dialect.is_lathe and "Z" in named:
            away = {"X", "Y"} - self.placed
            if away & named:
                return self._rely_on_rest()  # slanting down from elsewhere
            self.axes |= away
        if not may_be_skipped:
            self.placed |= named
        return self.placed >= self.all_axes

    def _home(self, effect: BlockEffect) -> bool:
        """``G91 G28 Z0.`` goes straight home; with other values it is a move to a point first."""
        named = homed_axes(effect, self.interpreted.settings)
        incremental = effect.after.modes.distance == "incremental"
        words = [w for w in effect.block.words if self.words.axes.get(w.address, "") in self.words.signs]
        distances = [w for w in words if incremental or w.address in self.words.distances]
        if len(distances) < len(words):
            return self._rapid(named, effect.block.is_optional)
        if any(plain_value(word) != 0.0 for word in distances):
            return self._rely_on_rest()
        self.placed |= set() if effect.block.is_optional else named
        return self.placed >= self.all_axes

    def _machine(self, effect: BlockEffect, named: frozenset[str]) -> bool:
        depth = effect.block.word(self.words.letters["Z"])
        if effect.after.modes.motion != "rapid":
            return self._rely_on_rest()
        if depth and plain_value(depth) != 0.0:
            return self._rapid(named, effect.block.is_optional)
        self.placed |= set() if effect.block.is_optional else named
        return self.placed >= self.all_axes
