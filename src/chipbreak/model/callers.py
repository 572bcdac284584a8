"""Where the programs behind the first one of a file begin: what their callers leave, or the power-on state.

::

    O0010                         O0101
    G96 S180 M3                   G71 U2. R.5
    G0 X60. Z2.                   G71 P1 Q2 U.4 W.1 F.3
    M98 P0101                     ...
    M30                           M99

A program that ends itself (M30) is one that is started, as the first one.  One that returns (M99) begins as
its calls in this file leave the control, where these are once each, plain, and agree.  Nothing else is known
of it: another file may call it.  So does a part of a program from N1000 to M99 that ``M97 P1000`` calls.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

from chipbreak.dialects.modes import UNSAID, Group
from chipbreak.model.arrivals import Place
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import Flow, sequence_lines
from chipbreak.model.giving_back import is_same
from chipbreak.model.modal import NOWHERE, UNKNOWN, Position, State, one_unknown
from chipbreak.model.paths import begins_program
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program as Text
from chipbreak.text.named_tuple import NamedTuple

_ONE_PROGRAM = 10_000  # P51234 calls O1234 five times
_LONGEST = 5_000  # lines of a program that are looked through at each call
_PLAIN_CALL = frozenset("NMPL")
_WHOLE_FILE = -1  # where a program is called from anywhere
_Key = tuple[int, int]
_ANY: _Key = (_WHOLE_FILE, -1)  # what a call names that may be of any program
# What a subprogram leaves in these is seen by the block behind its call; it is not followed there.
_FOLLOWED_BEHIND: frozenset[Group] = frozenset({"motion"})


class Program(NamedTuple):
    """A program of a file: its number, the lines ``first`` to ``last`` (exclusive), how it ends.

    ``last_return`` is the line of the M99 behind all that belongs to one that returns: a branch may return
    before.  ``owner`` is the first line of the program whose part it is, -1 for one of its own.
    """

    number: int
    first: int
    last: int
    returns: bool
    ends: bool
    last_return: int
    owner: int = _WHOLE_FILE

    @property
    def key(self) -> tuple[int, int]:
        """What a call names: from where it can be called, and its number."""
        return self.owner, self.number

    @property
    def is_part(self) -> bool:
        """True for a part of a program, which nothing but that program calls."""
        return self.owner != _WHOLE_FILE


class Call(NamedTuple):
    """A call of a program in this file, and the state that it hands over; None where that is not known."""

    key: _Key
    state: State | None


def programs_of(effects: Sequence[BlockEffect], flow: Flow, settings: Settings, stop: int) -> list[Program]:
    """The programs that begin with an O word, in order, up to line ``stop``."""
    begins = [e for e in effects if _names(e.block) and begins_program(e.block, settings.dialect)]
    bounds = [*(effect.block.line for effect in begins[1:]), stop] if begins else []
    return [_program(effect, last, effects, flow) for effect, last in zip(begins, bounds, strict=True)]


def local_programs(
    text: Text, effects: Sequence[BlockEffect], flow: Flow, programs: Sequence[Program]
) -> list[Program]:
    """The parts of the ``programs`` that calls of their own name by a block number, in order.

    Each begins behind the end of another one, so that nothing but its calls leads into it.
    """
    calls = [effect for effect in effects if effect.does("subprogram", "local-call")]
    numbers = sequence_lines(text) if calls else {}
    ended = {effect.block.line for effect in effects if effect.after.ended}
    found: dict[int, Program] = {}
    for call in calls:
        number = int(call.block.number("P") or 0)
        lines = _lines_of_owner(programs, call.block.line, text.source.body.stop)
        first = next((line for line in numbers.get(number, ()) if line in lines), None)
        if first is not None and _last_block(text, first) in ended:
            found[first] = _part(number, range(first, lines.stop), effects, flow, lines.start)
    return [found[first] for first in sorted(found)]


def _lines_of_owner(programs: Sequence[Program], line: int, stop: int) -> range:
    """The lines of the program in which a line stands; ``stop`` is behind the last one of the file."""
    owner = _owner(programs, line)
    return range(owner, next((one.first for one in programs if one.first > owner), stop))


def _owner(programs: Sequence[Program], line: int) -> int:
    """The first line of the program in which a line stands; 0 where none has a number."""
    return max((one.first for one in programs if one.first <= line), default=0)


def _last_block(text: Text, last: int) -> int | None:
    """The last line before this one with something on it."""
    lines = range(last - 1, text.source.body.start - 1, -1)
    return next((line for line in lines if not text.block(line).is_empty), None)


def _part(number: int, lines: range, effects: Sequence[BlockEffect], flow: Flow, owner: int) -> Program:
    inside = _between(effects, lines.start, lines.stop)
    how = next((e for e in inside if e.does("program", "end") or e.does("subprogram", "return")), None)
    if how is None:
        return Program(
            number, lines.start, lines.stop, returns=False, ends=False, last_return=-1, owner=owner
        )
    returns = how.does("subprogram", "return")
    last = _last_return(inside, flow) if returns else how.block.line
    return Program(number, lines.start, last + 1, returns, ends=False, last_return=last, owner=owner)


def _between(effects: Sequence[BlockEffect], first: int, stop: int) -> Sequence[BlockEffect]:
    """Those of some lines; effects are in the order of their lines."""
    low, high = (bisect_left(effects, line, key=lambda effect: effect.block.line) for line in (first, stop))
    return effects[low:high]


def _last_return(inside: Sequence[BlockEffect], flow: Flow) -> int:
    """The line of the M99 behind all that jumps from the first lines of a program lead to; -1 without one."""
    first, last = inside[0].block.line, -1
    returns = [effect.block.line for effect in inside if effect.does("subprogram", "return")]
    for line in returns:
        if last < 0 or any(last < at <= line and _may_come(first, last, at, flow) for at in flow.targets):
            last = line
    return last


def _may_come(first: int, last: int, target: int, flow: Flow) -> bool:
    """True where a jump in lines ``first`` to ``last`` may lead to a numbered line."""
    arrival = flow.arrivals.get(Place(target, is_behind=False))
    return arrival is None or any(_has_one_in(first, last, ways) for ways in (arrival.ways, arrival.beside))


def _has_one_in(first: int, last: int, ways: Sequence[Place]) -> bool:
    """True where one of some ways, in the order of their lines, begins in lines ``first`` to ``last``."""
    at = bisect_left(ways, first, key=lambda way: way.line)
    return at < len(ways) and ways[at].line <= last


def _names(block: Block) -> bool:
    return bool(block.words) and block.words[0].address == "O" and block.words[0].number is not None


def _program(begin: BlockEffect, last: int, effects: Sequence[BlockEffect], flow: Flow) -> Program:
    inside = _between(effects, begin.block.line, last)
    how = next((e for e in inside if e.does("program", "end") or e.does("subprogram", "return")), None)
    returns = how is not None and how.does("subprogram", "return")
    number = int(begin.block.number("O") or 0)
    last_return = _last_return(inside, flow) if returns else -1
    return Program(number, begin.block.line, last, returns, how is not None and not returns, last_return)


def entry_states(
    effects: Sequence[BlockEffect],
    programs: Sequence[Program],
    initial: State,
    block_at: Callable[[int], Block],
) -> dict[int, State]:
    """The state in which programs behind the first one begin, by the line of their O, where it is known.

    ``effects`` are those of blocks that are more than plain motion; ``block_at`` gives any block by its line.
    """
    main = min((one.first for one in programs if not one.is_part), default=-1)
    found = {one.first: initial for one in programs if one.ends and one.first != main}
    by_key = {one.key: one for one in reversed(programs)}
    calls = list(_calls(effects, by_key, block_at))
    for key, one in by_key.items():
        states = [call.state for call in calls if call.key in (key, _ANY)]
        agreed = _agreed(states) if one.returns and one.first != main else None
        if agreed is not None:
            found[one.first] = agreed
    return found


def lines_of_calls(
    effects: Sequence[BlockEffect], programs: Sequence[Program], entries: Collection[int]
) -> frozenset[int]:
    """The lines of the calls of these programs, of those that return and begin in one of these lines."""
    by_key = {one.key: one for one in reversed(programs)}
    own = [one for one in programs if not one.is_part]
    found = set()
    for effect in filter(_calls_by_number, effects):
        number = effect.block.number("P")
        called = None if number is None else _called(effect, int(number), by_key, own)
        if called is not None and called.returns and called.first in entries:
            found.add(effect.block.line)
    return frozenset(found)


def _calls(
    effects: Sequence[BlockEffect], programs: Mapping[_Key, Program], block_at: Callable[[int], Block]
) -> Iterator[Call]:
    """The calls of these programs in the order of the file."""
    since = _Since()
    own = [one for one in programs.values() if not one.is_part]
    for effect in filter(_calls_by_number, effects):
        number = effect.block.number("P")
        if number is None:
            yield Call(_ANY, None)
            continue
        called = _called(effect, int(number), programs, own)
        if called is not None:
            yield Call(called.key, since.handed_over(_state_of_call(effect, int(number))))
            since.has_called(effect.block.line, called, effects, block_at)


def _called(
    effect: BlockEffect, number: int, programs: Mapping[_Key, Program], own: Sequence[Program]
) -> Program | None:
    """The program that a block calls by its number; None for one that is not in this file."""
    if effect.does("subprogram", "local-call"):
        return programs.get((_owner(own, effect.block.line), number))
    key = (_WHOLE_FILE, number)
    return programs.get(key) or programs.get((_WHOLE_FILE, number % _ONE_PROGRAM))


def called_by_number(effect: BlockEffect, programs: Sequence[Program]) -> Program | None:
    """The program that a block calls by its number; None for one that is not in this file."""
    number = effect.block.number("P")
    if number is None:
        return None
    own = [one for one in programs if not one.is_part]
    return _called(effect, int(number), {one.key: one for one in reversed(programs)}, own)


def may_call(effect: BlockEffect) -> bool:
    """True for a block that calls something, whatever it is."""
    by_label = any(control.keyword == "O-CALL" for control in effect.block.controls)
    return by_label or _calls_by_number(effect)


def _calls_by_number(effect: BlockEffect) -> bool:
    is_macro = "macro-call" in effect.non_modal or effect.after.modes.modal_macro == "on"
    return is_macro or effect.does("subprogram", "call", "local-call")


def _says(body: range, letter: str, block_at: Callable[[int], Block]) -> bool:
    return any(block_at(line).has(letter) for line in body)


def _state_of_call(effect: BlockEffect, number: int) -> State | None:
    """The state that a plain call of one pass hands over, None for any other."""
    block = effect.block
    is_plain = {word.address for word in block.words} <= _PLAIN_CALL and not (block.skip or block.has_macro)
    is_local = effect.does("subprogram", "local-call")
    is_once = (is_local or number < 2 * _ONE_PROGRAM) and block.number("L") in (None, 1.0)
    does_nothing_else = len(block.numbers("M")) == 1 and effect.does("subprogram", "call", "local-call")
    return effect.before if is_plain and is_once and does_nothing_else else None


class _Since:
    """What calls before a block may have left otherwise than the blocks around them say."""

    def __init__(self) -> None:
        self.is_known = True
        self.said = {"F": -1, "S": -1}

    def has_called(
        self,
        line: int,
        called: Program,
        effects: Sequence[BlockEffect],
        block_at: Callable[[int], Block],
    ) -> None:
        """A call in a line has run a program of this file.

        That one of another file leaves all as it was is taken for granted here as behind its call.
        """
        body = range(called.first, called.last)
        if _leaves_another_state([effect for effect in effects if effect.block.line in body]):
            self.is_known = False
        for letter in self.said:
            if len(body) > _LONGEST or _says(body, letter, block_at):
                self.said[letter] = line

    def handed_over(self, state: State | None) -> State | None:
        """The state of a later call, without what may be another one."""
        if state is None or not self.is_known:
            return None
        feed = None if state.feed is None or state.feed.line < self.said["F"] else state.feed
        speed = None if state.speed is None or state.speed.line < self.said["S"] else state.speed
        return state._replace(feed=feed, speed=speed)


def _leaves_another_state(inside: Sequence[BlockEffect]) -> bool:
    """True where a program leaves otherwise what the blocks behind its call take for granted."""
    before = inside[0].before
    after = inside[-1].after
    changed = set(before.modes.changed(after.modes)) - _FOLLOWED_BEHIND
    calls_tool = any(effect.block.has("T") for effect in inside)
    spindle = (before.spindle, before.choice) != (after.spindle, after.choice)
    return bool(changed) or calls_tool or spindle or before.coolant != after.coolant


def _agreed(states: Sequence[State | None]) -> State | None:
    """What all calls have in common; None where one is not known, or modes or spindle differ."""
    known = [state for state in states if state is not None]
    if not known or len(known) < len(states):
        return None
    offsets = {state.modes.work_offset for state in known}
    first, *others = map(_with_one_unknown, known if len(offsets) == 1 else map(_in_any_offset, known))
    for other in others:
        if _but_values(first) != _but_values(other) or not is_same(first.speed_limit, other.speed_limit):
            return None
        places = (a if a == b else UNKNOWN for a, b in zip(first.position, other.position, strict=True))
        first = first._replace(
            position=Position(*places),
            unknown_why="its calls come from different places",
            feed=first.feed if is_same(first.feed, other.feed) else None,
            speed=first.speed if is_same(first.speed, other.speed) else None,
        )
    return first


def _in_any_offset(state: State) -> State:
    """The state without the origin that its places count from: one program, called at several of them."""
    return state._replace(modes=state.modes._replace(work_offset=UNSAID))


def _with_one_unknown(state: State) -> State:
    """The state with one object for all places that are not known, so that it equals itself."""
    return state._replace(position=Position(*map(one_unknown, state.position)))


def _but_values(state: State) -> State:
    return state._replace(
        position=NOWHERE, unknown_why="", feed=None, speed=None, speed_limit=None, tool=None, next_tool=None
    )
