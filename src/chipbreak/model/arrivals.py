"""By which ways a program comes to a block that is reached from elsewhere than the block above it.

::

    N10 G0 X0            GOTO 10 further down comes here
    WHILE[#1LT3]DO1      the first pass comes from above, each further one from END1
    G1 X5.
    END1                 behind it the program goes on from the WHILE

A way says only where the program comes from.  Which F and S it brings is known once the program is
interpreted: where all ways bring the same, they are known behind the meeting too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field

from chipbreak.dialects.modes import Modes, Units
from chipbreak.model.giving_back import is_same, is_same_path_mode
from chipbreak.model.left_open import differing, merged
from chipbreak.model.modal import LeftOpen, Setting, State
from chipbreak.syntax.nodes import Block, Control, Number
from chipbreak.text.named_tuple import NamedTuple

_BRANCH = "O-IF"
_CLOSERS: Mapping[str, str] = {
    "O-IF": "O-ENDIF",
    "O-REPEAT": "O-ENDREPEAT",
    "O-DO": "O-WHILE",
    "O-WHILE": "O-ENDWHILE",
    "WHILE": "END",
    "DO": "END",
}
_ARMS = frozenset({"O-ELSE", "O-ELSEIF"})
_LEAVES = frozenset({"O-BREAK", "O-CONTINUE"})
_GOES_ELSEWHERE = _LEAVES | {"O-RETURN"}
_MOST_NUMBERS = 5_000  # of a program with a jump that the machine works out
# By these F and S are read.
_READ_BY = frozenset({"units", "feed_mode", "speed_mode"})


class Place(NamedTuple):
    """Before a line, or behind what its block does."""

    line: int
    is_behind: bool


class Arrival(NamedTuple):
    """The ways that meet at a place; ``from_above``: the block above is one of them, beside ``ways``.

    ``beside`` are more of them, which come to other places as well.
    """

    ways: tuple[Place, ...]
    from_above: bool = True
    beside: tuple[Place, ...] = ()


class Jump(NamedTuple):
    """A GOTO in a line, and the block number that it jumps to, None where the machine works that out."""

    line: int
    number: int | None


class Carried(NamedTuple):
    """F, S, the modes and the tool as a way brings them; ``left_open`` are groups in which it is not sure.

    ``path_words``, ``path_units`` and ``smooth_words`` are those of the state, ``spindle`` too where it
    ``is_spindle_sure``; ``kept`` is what M70 has kept.
    """

    feed: Setting | None
    speed: Setting | None
    modes: Modes
    left_open: frozenset[str] = frozenset()
    tool: int | None = None
    path_words: str = ""
    path_units: Units = "mm"
    smooth_words: str = ""
    spindle: str = "stop"
    is_spindle_sure: bool = True
    kept: Carried | None = None

    def without(self, *, feed: bool, speed: bool) -> Carried:
        """The same where what is called on the way may have said another F, or another S."""
        return self._replace(feed=None if feed else self.feed, speed=None if speed else self.speed)


Arrivals = Mapping[Place, Arrival]
CarriedTo = Mapping[Place, tuple[Carried, ...]]


# --- the ways ------------------------------------------------------------------------------------------
def at_targets(
    jumps: Sequence[Jump], numbers: Mapping[int, Sequence[int]], called: Set[int]
) -> Iterator[tuple[Place, Arrival]]:
    """The ways to the numbered lines that a GOTO reaches: to all where the machine works out a number.

    Of very many numbers that it may work out nothing is said: to go through these again takes too long.
    ``called`` are numbers that calls and returns name (``M99 P100``): nothing is said of these.
    """
    ways: dict[int, list[Place]] = {}
    to_any: list[Place] = []
    for jump in jumps:
        found = to_any if jump.number is None else ways.setdefault(jump.number, [])
        found.append(Place(jump.line, is_behind=True))
    if to_any and len(numbers) > _MOST_NUMBERS:
        return
    anywhere = Arrival((), beside=tuple(to_any))  # one for all, so that what it brings is put together once
    reached = numbers.keys() if to_any else ways.keys() & numbers.keys()
    for number in sorted(reached - called):
        arrival = anywhere._replace(ways=tuple(ways[number])) if number in ways else anywhere
        for line in numbers[number]:
            yield Place(line, is_behind=False), arrival


@dataclass(eq=False, repr=False)
class _Nest:
    """A loop or a branch while it is read.

    ``test``   the line that the program leaves for the next arm, where its condition is not met
    ``arms``   where arms of a branch end, without the last one
    ``leaves`` where the loop is left (``break``)
    ``again``  where the rest of a pass is left out (``continue``)
    """

    keyword: str
    label: str
    first: int
    runs_at_least_once: bool
    test: int | None
    arms: list[Place] = field(default_factory=list)
    leaves: list[Place] = field(default_factory=list)
    again: list[Place] = field(default_factory=list)


def at_nests(blocks: Iterable[Block]) -> dict[Place, Arrival]:
    """The ways to the ends of loops and branches; empty where these are not nested properly."""
    reader = _NestReader()
    is_proper = all(reader.read(control, block.line) for block in blocks for control in _controls(block))
    return reader.found if is_proper and not reader.opened else {}


def _controls(block: Block) -> Iterator[Control]:
    """The control words of a block; ``WHILE[...]DO1`` is one, with the label of its DO."""
    named = {control.keyword: control for control in block.controls}
    if "DO" in named:
        yield named["DO"]._replace(keyword="WHILE" if "WHILE" in named else "DO")
    yield from (control for control in block.controls if control.keyword not in ("DO", "WHILE"))


class _NestReader:
    """One walk over the control words: what is ``opened``, and the ways ``found`` so far."""

    def __init__(self) -> None:
        self.opened: list[_Nest] = []
        self.found: dict[Place, Arrival] = {}

    def read(self, control: Control, line: int) -> bool:
        """Take in a control word; False where nothing is open that it belongs to."""
        keyword = control.keyword
        if self._innermost(control, _CLOSERS.get) == keyword:
            self.found.update(_closed(self.opened.pop(), line))
            return True
        if keyword in _CLOSERS:
            label = control.label.lower()
            self.opened.append(_Nest(keyword, label, line, runs_at_least_once(control), line))
            return True
        if keyword in _ARMS:
            return self._innermost(control, str) == _BRANCH and self._next_arm(keyword, line)
        if keyword in _GOES_ELSEWHERE:
            return self._leave(control, line)
        return keyword not in _CLOSERS.values()

    def _innermost(self, control: Control, says: Callable[[str], str | None]) -> str | None:
        """What the keyword of the innermost opening says, None where that has another label."""
        nest = self.opened[-1] if self.opened else None
        return says(nest.keyword) if nest is not None and nest.label == control.label.lower() else None

    def _next_arm(self, keyword: str, line: int) -> bool:
        """``else``, ``elseif``: reached from the last condition that was not met."""
        branch = self.opened[-1]
        if branch.test is None:
            return False
        branch.arms.append(Place(line, is_behind=False))
        ways = (Place(branch.test, is_behind=True),)
        self.found[Place(line, is_behind=True)] = Arrival(ways, from_above=False)
        branch.test = None if keyword == "O-ELSE" else line
        return True

    def _leave(self, control: Control, line: int) -> bool:
        """``break``, ``continue``, ``return``: nobody comes to what stands behind, which is just read on."""
        self.found[Place(line, is_behind=True)] = Arrival(())
        left = [nest for nest in self.opened if nest.label == control.label.lower()]
        for nest in left:
            ways = nest.again if control.keyword == "O-CONTINUE" else nest.leaves
            ways.append(Place(line, is_behind=False))
        return bool(left) or control.keyword not in _LEAVES


def _closed(nest: _Nest, last: int) -> Iterator[tuple[Place, Arrival]]:
    """The ways to the first and behind the last line of a loop or a branch."""
    begin = Place(nest.first, is_behind=True)
    end = Place(last, is_behind=True)
    if nest.keyword == _BRANCH:
        past = [] if nest.test is None else [Place(nest.test, is_behind=True)]
        yield begin, Arrival(())
        yield end, Arrival((*nest.arms, *past))
        return
    yield begin, Arrival((Place(last, is_behind=False), *nest.again))
    if nest.keyword in ("O-WHILE", "WHILE"):  # it is left where its condition stands
        yield end, Arrival((begin, *nest.leaves), from_above=False)
    else:
        past = [] if nest.runs_at_least_once else [begin]
        yield end, Arrival((*nest.leaves, *nest.again, *past))


def runs_at_least_once(opener: Control) -> bool:
    """False where the condition or the count of a loop or a branch may let nothing of it run."""
    if opener.keyword != "O-REPEAT":
        return opener.keyword in ("DO", "O-DO")
    times = opener.arguments
    return bool(times) and isinstance(times[0], Number) and times[0].value >= 1.0


# --- what they bring -----------------------------------------------------------------------------------
def carried_by(state: State) -> Carried:
    """F and S of a state; one that cannot be known is None."""
    return Carried(
        _known(state.feed),
        _known(state.speed),
        state.modes,
        frozenset(group for group, _ in state.left_open),
        state.tool,
        state.path_words,
        state.path_units,
        state.smooth_words,
        state.spindle,
        not state.spindle_why,
        None if state.kept is None else carried_by(state.kept),
    )


def _known(setting: Setting | None) -> Setting | None:
    return None if setting is None or math.isnan(setting.value) else setting


def together(ways: Sequence[Carried]) -> tuple[Carried, ...]:
    """As one, what all these bring to the place where they meet; empty where there are none.

    F and S are known where all bring the same and read them alike, the modes but for those left open.
    """
    if not ways:
        return ()
    first = ways[0]
    left_open = differing(first.modes, (way.modes for way in ways)).union(*(way.left_open for way in ways))
    left_open |= {name for name, is_other in _OTHERWISE.items() if any(is_other(first, way) for way in ways)}
    is_read_alike = left_open.isdisjoint(_READ_BY)
    brought = first._replace(
        feed=_common([way.feed for way in ways]) if is_read_alike else None,
        speed=_common([way.speed for way in ways]) if is_read_alike else None,
        left_open=left_open,
        is_spindle_sure=_is_spindle_sure(ways),
        kept=_kept_by(ways),
    )
    return (brought,)


def _is_spindle_sure(ways: Sequence[Carried]) -> bool:
    return all(way.is_spindle_sure and way.spindle == ways[0].spindle for way in ways)


def _kept_by(ways: Sequence[Carried]) -> Carried | None:
    """What M72 gives back; a way by which nothing was kept comes to none, which would end the program."""
    kept = together([way.kept for way in ways if way.kept is not None])
    return kept[0] if kept else None


# What belongs to no modal group, or to the words beside a code of it.
_OTHERWISE: Mapping[str, Callable[[Carried, Carried], bool]] = {
    "tool": lambda one, other: one.tool != other.tool,
    "path": lambda one, other: not is_same_path_mode(one, other),
    "look_ahead": lambda one, other: one.smooth_words != other.smooth_words,
}


def met(
    state: State, carried: Sequence[Carried] | None, why: str, *, from_above: bool, said: frozenset[str]
) -> State:
    """The state where ways meet; ``carried`` is what the other ones bring, None where they are not known.

    Empty where nothing has come by them yet.  ``said`` are the groups that a way which is not known may bring
    otherwise, and the tool.
    """
    if carried is None:
        return _unsure(state, said, why)
    (all_ways,) = together([carried_by(state), *carried] if from_above or not carried else carried)
    return _as_brought(state.forgotten(why), all_ways, state.left_open if from_above else (), why)


def _unsure(state: State, said: frozenset[str], why: str) -> State:
    """The state, and what M70 has kept, where any way may have come in."""
    kept = None if state.kept is None else _unsure(state.kept, said, why)
    return state.forgotten(why)._replace(left_open=merged(state.left_open, said, why), kept=kept)


def _as_brought(state: State, ways: Carried, left_open: LeftOpen, why: str) -> State:
    """The state with what some ways bring; ``left_open`` has its reasons already."""
    kept = state.kept or state  # one that only other ways have kept is like this but for what they bring
    return state._replace(
        modes=ways.modes,
        feed=ways.feed,
        speed=ways.speed,
        tool=ways.tool,
        path_words=ways.path_words,
        path_units=ways.path_units,
        smooth_words=ways.smooth_words,
        left_open=merged(left_open, ways.left_open, why),
        spindle=ways.spindle,
        spindle_why="" if ways.is_spindle_sure else state.spindle_why or why,
        kept=None if ways.kept is None else _as_brought(kept._replace(kept=None), ways.kept, (), why),
    )


def _common(settings: Sequence[Setting | None]) -> Setting | None:
    """The setting that all bring, None where they differ; it counts as made where the first of them was.

    One that was given back in other units is the same.
    """
    made = [setting for setting in settings if setting is not None]
    if len(made) < len(settings) or not all(is_same(made[0], one) for one in made):
        return None
    return min(made, key=lambda one: one.line)
