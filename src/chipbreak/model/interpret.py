"""One block at a time: the state before it, what it does, the state after it.

``Interpreter.advance`` is the law.  Inside a block things happen in the numbered order of ISO 6983 and of
the controls' manuals: (1) feed mode, (2) feed, (3) speed, (4) tool, (5) spindle, (6) coolant, (7) plane,
units, compensation, offsets and the other modal groups, (8) non-modal codes, (9) motion, (10) stop.
(1), (2), (3) and (7) are the rules of ``values``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from chipbreak.dialects.base import MCode
from chipbreak.dialects.modes import UNSAID, Group, Motion
from chipbreak.model.arrivals import CarriedTo, Place, met
from chipbreak.model.block_effect import CUTTING, BlockEffect, Move
from chipbreak.model.codes import LOSES, BlockCodes, read_codes
from chipbreak.model.cutting_speed import cutting_speed_of
from chipbreak.model.flow import Flow
from chipbreak.model.left_open import behind_unread, behind_worked_out, either, merged
from chipbreak.model.m_codes import m_code
from chipbreak.model.modal import CALLED, LOOPED, UNKNOWN, Setting, State
from chipbreak.model.motion import ANGLE, move_of
from chipbreak.model.paths import (
    CALLERS_STATE,
    begins_program,
    behind_choice,
    behind_unknown_start,
    behind_wait,
    behind_work_spindle,
    entered,
    spindle_choice,
)
from chipbreak.model.values import MODE_LETTERS, Said, values_after
from chipbreak.model.vibration_words import vibration_words
from chipbreak.model.words import JUMPED, plain_value, reread_speed
from chipbreak.settings.axis_words import AXES, CENTRES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.source import Source

Words = tuple[Word, ...]
# The axis words of their codes are a centre, no move; those of LinuxCNC's G43.1 are an offset.
_CENTRE_GROUPS: tuple[Group, ...] = ("rotation", "scaling", "mirror")
_LOSES_NAMED_AXES = ("home", "machine", "skip")
_LOST_BY_CYCLES: Mapping[Motion, str] = {"cycle": "a drilling cycle", "thread-cycle": "a threading cycle"}
_AXES_WITHOUT_V = frozenset("XYZUWABCH")
Steps = dict[int, tuple[State, BlockEffect]]
_MOST_STEPS = 100_000
_TAKES_WORDS = frozenset({"compensation", "modal_macro"})
_PLAIN_LETTERS = frozenset("GMTSFODHABC")
_STARTS = frozenset({("spindle", "cw"), ("spindle", "ccw")})
_ARCS: tuple[Motion, ...] = ("cw", "ccw")
_PLAIN_MOTIONS: tuple[Motion, ...] = ("rapid", "line", "cw", "ccw")
_CENTRE_LETTERS = frozenset(CENTRES)
_ARC_LETTERS = _CENTRE_LETTERS | {"R"}
_NO_ENTRIES: Mapping[int, State] = FrozenTable({})
_NOTHING: CarriedTo = FrozenTable({})


def initial_state(settings: Settings) -> State:
    """The state at the first block: the control's power-on modes, and the path mode that is usual on it."""
    modes = settings.dialect.initial
    usual = settings.dialect.code_of(settings.planner.usual_path_mode)
    if modes.path != UNSAID and usual is not None and usual.group == "path":
        modes = modes.replace({"path": usual.value})
    return State(modes=modes)


class Interpreter:
    """Reads blocks under one profile.  Holds no state of its own.

    ``entries`` are the states in which programs behind the first one of a file begin, by line.
    ``carried`` is what the ways bring that meet at a place; where it says nothing, they may bring anything.
    ``steps`` are effects by their line, and the state each began in, of who has gone through the same program
    with other entries and other ways: but for the lines where these come in, a block does the same again.
    """

    def __init__(
        self,
        settings: Settings,
        flow: Flow,
        source: Source | None = None,
        entries: Mapping[int, State] = _NO_ENTRIES,
        carried: CarriedTo = _NOTHING,
        *,
        steps: Steps | None = None,
    ) -> None:
        self.settings = settings
        self.flow = flow
        self.source = source
        self.entries = entries
        self.carried = carried
        self.dialect = settings.dialect
        self.number_rule = settings.number_rule
        self.axis_letters = frozenset(settings.axis_words.axes)
        self.any_axis = self.axis_letters | frozenset(AXES)
        self.read_on_lines = _PLAIN_LETTERS | self.axis_letters
        self.read_on_arcs = self.read_on_lines | _ARC_LETTERS
        self.steps = steps
        self.others_come_in = {*entries, *flow.targets, *(place.line for place in flow.arrivals)}

    def advance(self, state: State, block: Block) -> BlockEffect:
        """What a block does."""
        if self.steps is None or block.line in self.others_come_in:
            return self._advanced(state, block)
        was, effect = self.steps.get(block.line, (None, None))
        if effect is not None and (was is state or was == state):
            # A block that does nothing leaves the state as it is, and not one that is equal.
            return effect if effect.after is not was else effect._replace(before=state, after=state)
        effect = self._advanced(state, block)
        if len(self.steps) < _MOST_STEPS:
            self.steps[block.line] = (state, effect)
        return effect

    def _advanced(self, state: State, block: Block) -> BlockEffect:
        state = self._begun(state, block)
        if block.line in self.flow.targets:
            state = self._arrived(state, Place(block.line, is_behind=False), JUMPED)
        if block.opaque:
            after = behind_unread(state, block, self.dialect, self._user_line(block))
            return BlockEffect(block, state, after)
        if block.is_empty:
            effect = BlockEffect(block, state, state)
            return self._with_cutting_speed(effect) if block.comments else effect
        if self.flow.in_contour(block.line):
            codes = read_codes(block, state, self.dialect)
            asks = vibration_words(block, self.axis_letters, cuts=True, has_once=codes.reads_all)
            functions = self._functions(block, codes)
            return BlockEffect(block, state, state, vibration=asks, in_contour=True, functions=functions)
        effect = self._with_cutting_speed(self._execute(state, block))
        if block.is_optional:
            effect = effect._replace(after=either(state, effect.after, block, self._user_line(block)))
        return effect

    def _begun(self, state: State, block: Block) -> State:
        """The state at a block with which another program or another path may begin."""
        if block.line in self.entries:
            state = self.entries[block.line]
        elif block.is_empty:
            return state
        elif state.ended or begins_program(block, self.dialect):
            initial = initial_state(self.settings)
            if state != initial:
                why = CALLERS_STATE.format(line=self._user_line(block))
                state = initial._replace(unknown_why="another program starts here", spindle_why=why)
        return entered(state, block, self.dialect, self._user_line(block)) if block.controls else state

    def _user_line(self, block: Block) -> int:
        """The number of a block's line in the user's file."""
        return block.line + 1 if self.source is None else self.source.place(block.line).line

    def _with_cutting_speed(self, effect: BlockEffect) -> BlockEffect:
        """V and D set the speed; a fault in them is the speeds pass's to report."""
        if not (effect.block.comments or effect.block.has_any("VD")):
            return effect
        try:
            starts = effect.does("spindle", "cw", "ccw")
            asked = cutting_speed_of(effect.block, effect.after, self.dialect, starts_spindle=starts)
        except RefusalError:
            return effect
        if asked is None:
            return effect
        text = asked.speed_text(self.settings.spindle.resolution_rpm)
        after = effect.after._replace(speed=Setting(float(text), text, effect.block.line))
        unread = tuple(w for w in effect.unread if w not in asked.words)
        return effect._replace(after=after, unread=unread, cutting_speed=asked)

    def _execute(self, state: State, block: Block) -> BlockEffect:
        codes = read_codes(block, state, self.dialect)
        mode_words = self._mode_words(codes)
        vibration = self._vibration_words(block, codes, has_mode_words=bool(mode_words))
        after = values_after(Said(block, codes, state, vibration, self.dialect, self.number_rule))
        after = self._behind_finishing(after, block)
        functions = self._functions(block, codes)
        if self.dialect.converts_feed and any(code[:2] in _STARTS for code in functions):
            after = reread_speed(after, state.modes.units)  # worked out again where the spindle starts
        after = self._machine_functions(after, block, codes, functions)
        move = None
        has_centre = _names_a_centre(codes)
        if not has_centre:
            after, move = self._motion(after, block, codes)
        after = self._flow_of_control(after, block, functions)
        after = self._other_spindles(after, state, block, codes)
        has_macro = block.has_macro
        if has_macro:
            after = behind_worked_out(after, block, codes.taken, self.dialect, self._user_line(block))
        mode_words += "P" if " P" in codes.changes.get("work_offset", "") else ""
        mode_words += codes.taken if codes.non_modal or _TAKES_WORDS & codes.changes.keys() else ""
        seen = (*vibration, *block.words_of(mode_words)) if mode_words else vibration
        all_read = codes.reads_all or has_centre or has_macro
        unread = _stray(block.words, vibration) if all_read else self._unread(block, seen, after, move)
        effect = BlockEffect(
            block, state, after, move, codes.non_modal, vibration, unread, functions=functions
        )
        return effect._replace(taken=codes.taken) if codes.taken else effect

    def _behind_finishing(self, state: State, block: Block) -> State:
        """F and S of a shape act in its finishing cycle; whether they hold behind it, no manual says."""
        said = self.flow.finishes.get(block.line)
        if not said:
            return state
        unknown = {
            letter: Setting(UNKNOWN, text, block.line, state.modes.units) for letter, text in said.items()
        }
        return state._replace(feed=unknown.get("F", state.feed), speed=unknown.get("S", state.speed))

    def _mode_words(self, codes: BlockCodes) -> str:
        return "".join(letters for group, letters in MODE_LETTERS.items() if group in codes.changes)

    def _vibration_words(self, block: Block, codes: BlockCodes, *, has_mode_words: bool) -> Words:
        motion = codes.modes.motion
        # A full circle may name its centre only.
        # So is an axis of another profile's: its wish must be refused, not passed over.
        moving = self.any_axis | _CENTRE_LETTERS if motion in _ARCS else self.any_axis
        cuts = motion in CUTTING and not (codes.unknown or has_mode_words)
        return vibration_words(block, moving, cuts=cuts, has_once=codes.reads_all)

    def _machine_functions(
        self, state: State, block: Block, codes: BlockCodes, functions: tuple[MCode, ...]
    ) -> State:
        """(4) tool, (5) spindle, (6) coolant, (10) stop."""
        takes = codes.taken
        for word in block.words_of("TM"):
            value = plain_value(word)
            if word.address in takes:
                continue
            if word.address == "T":
                state = self._tool_word(state, value)
            elif not math.isnan(value) and int(value) in self.dialect.m_codes:
                state = m_code(state, self.dialect.m_codes[int(value)])
        if any(code.group == "tool" for code in functions):
            state = _changed_tool(state).lost("a tool change moves the machine")
        return state

    def _functions(self, block: Block, codes: BlockCodes) -> tuple[MCode, ...]:
        """What the M codes of a block do, as far as the control's table says; an M beside G66 is a number."""
        if "M" in codes.taken:
            return ()
        known = self.dialect.m_codes
        return tuple([known[int(n)] for n in block.numbers("M") if n in known])

    def _tool_word(self, state: State, value: float) -> State:
        number = None if math.isnan(value) else self.dialect.tool_of(int(value))
        if not self.dialect.tool_by_word:
            return state._replace(next_tool=number).said("next_tool")
        number = state.tool if number == 0 else number  # T0 ends the offset of the tool that is in the turret
        return state._replace(tool=number, next_tool=None).said("tool").lost("a tool or its offset changed")

    def _motion(self, state: State, block: Block, codes: BlockCodes) -> tuple[State, Move | None]:
        """(8) non-modal codes, (9) motion."""
        axis_words = self._axis_words(block)
        state = self._lost_by_codes(state, axis_words, codes)
        is_circle = state.modes.motion in _ARCS and block.has_any(_CENTRE_LETTERS)
        if not (axis_words or is_circle) or codes.reads_all:
            return state, None
        if codes.unknown:
            return state.lost("a G code this profile does not know stands with axis words"), None
        move = move_of(block, state, axis_words, self.settings, codes.non_modal)
        after = state._replace(position=move.end)
        if block.has(ANGLE):
            line = self._user_line(block)
            after = after._replace(unknown_why=f"the angle in line {line} gives an axis its place")
        elif any(math.isnan(getattr(move.end, axis.lower())) for axis in move.axes):
            why = self._why_lost(state, block, axis_words, codes)
            after = after._replace(unknown_why=why or after.unknown_why)
        return after, move

    def _why_lost(self, state: State, block: Block, axis_words: Words, codes: BlockCodes) -> str:
        """Why nobody knows where a move ends; empty where the reason is one from before."""
        if codes.non_modal:
            return ""
        if state.modes.motion in _LOST_BY_CYCLES:
            return f"{_LOST_BY_CYCLES[state.modes.motion]} in line {self._user_line(block)} moves the tool"
        if any(word.number is None for word in axis_words):
            return f"the control works out where line {self._user_line(block)} goes"
        return ""

    def _axis_words(self, block: Block) -> Words:
        if block.has("D") and not block.has_any(_AXES_WITHOUT_V):
            return ()  # V beside D is a cutting speed
        return block.words_of(self.axis_letters)

    def _lost_by_codes(self, state: State, axis_words: Words, codes: BlockCodes) -> State:
        if "set-position" in codes.non_modal and not axis_words:  # G50 S2000
            return state
        if not codes.non_modal:
            return state
        axes = [self.settings.axis_words.axes[word.address] for word in axis_words]
        for name in sorted(codes.non_modal & LOSES.keys() - self.dialect.returning_cycles):
            state = _lose_axes(state, axes, LOSES[name], everything=name not in _LOSES_NAMED_AXES)
        return state

    def _flow_of_control(self, state: State, block: Block, functions: tuple[MCode, ...]) -> State:
        """Loops, subprograms and calls: the next block may be reached with other values."""
        for control in block.controls:
            if control.keyword in ("WHILE", "DO", "END") or control.keyword.startswith("O-"):
                called = control.keyword == "O-CALL"
                here = Place(block.line, is_behind=True)
                state = state.lost(CALLED) if called else self._arrived(state, here, LOOPED)
            if control.keyword == "O-SUB":
                why = CALLERS_STATE.format(line=self._user_line(block))
                state = state.forgotten(why)._replace(spindle_why=why)
        calls = any(code.group == "subprogram" and code.value != "return" for code in functions)
        return state.lost(CALLED) if calls else state

    def _arrived(self, state: State, place: Place, why: str) -> State:
        """The state at a place to which other ways lead than the one from above, which brings ``state``."""
        arrival = self.flow.arrivals.get(place)
        from_above = arrival is None or arrival.from_above
        carried = self.carried.get(place)
        return met(state, carried, why, from_above=from_above, said=self.flow.said_otherwise)

    def _other_spindles(self, after: State, before: State, block: Block, codes: BlockCodes) -> State:
        """What is left of the spindle where another path, or a choice of spindle, comes between."""
        if block.controls or block.has("M"):
            after = behind_wait(after, block, self.dialect, self._user_line(block))
            after = behind_unknown_start(after, block, self.dialect, self._user_line(block))
        choice = spindle_choice(block, codes, self.dialect)
        if choice in self.settings.shown.spindles:
            return behind_work_spindle(after, before, choice, block, self._user_line(block))
        return behind_choice(after, before, choice, self._user_line(block)) if choice else after

    def _unread(self, block: Block, seen: Words, after: State, move: Move | None) -> Words:
        motion = after.modes.motion
        read = self.read_on_arcs if motion in _ARCS else self.read_on_lines
        words = [word for word in block.words if word.letter.upper() not in read]
        if not words:  # as in nearly every block
            return ()
        if motion not in _PLAIN_MOTIONS or (block.numbers("M") and move is None):
            return _stray(words, seen)
        seen_at = {word.start for word in seen}
        return tuple([word for word in words if word.start not in seen_at])


def _changed_tool(state: State) -> State:
    """The next tool is in the spindle, as sure as it was known."""
    why = dict(state.left_open).get("next_tool")
    after = state._replace(tool=state.next_tool).said("tool")
    return after if why is None else after._replace(left_open=merged(after.left_open, ("tool",), why))


def _stray(words: Sequence[Word], seen: Words) -> Words:
    """N with a point is no sequence number, and no code takes it: a wish that stands where nothing is cut."""
    seen_at = {word.start for word in seen}
    return tuple([w for w in words if w.letter.upper() == "N" and w.has_point and w.start not in seen_at])


def _names_a_centre(codes: BlockCodes) -> bool:
    """True where the axis words are a centre, or an offset: nothing moves."""
    changes = codes.changes
    has_centre = any(changes.get(group) == "on" for group in _CENTRE_GROUPS)
    return has_centre or changes.get("length_offset") == "by-axes"


def _lose_axes(state: State, axes: list[str], why: str, *, everything: bool) -> State:
    if everything or not axes:
        return state.lost(why)
    position = state.position._replace(**{a.lower(): math.nan for a in axes if a in AXES})
    return state._replace(position=position, unknown_why=why)
