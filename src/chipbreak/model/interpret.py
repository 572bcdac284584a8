"""One block at a time: the state before it, what it does, the state after it.

``Interpreter.advance`` is the law.  Inside a block things happen in the numbered order of ISO 6983 and of
the controls' manuals: (1) feed mode, (2) feed, (3) speed, (4) tool, (5) spindle, (6) coolant, (7) plane,
units, compensation, offsets and the other modal groups, (8) non-modal codes, (9) motion, (10) stop.
"""

from __future__ import annotations

import math

from chipbreak.dialects.base import NON_MODAL
from chipbreak.dialects.modes import Group, Modes, Motion
from chipbreak.model.block_effect import CUTTING, BlockEffect, Move
from chipbreak.model.cutting_speed import cutting_speed_of
from chipbreak.model.flow import Flow
from chipbreak.model.m_codes import m_code
from chipbreak.model.modal import LOOPED, UNREAD, Position, Setting, State
from chipbreak.model.motion import move_of
from chipbreak.model.vibration_words import vibration_words
from chipbreak.model.words import (
    JUMPED,
    codes_of,
    cylinder_of,
    feed_value,
    offset_of,
    plain_value,
    surface_limit,
)
from chipbreak.settings.axis_words import AXES, CENTRES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import RefusalError

_CALLS = (97, 98, 198)
Words = tuple[Word, ...]
_MODES_WITH_WORDS = frozenset({"path", "look_ahead"})  # P, Q and R beside G64 or G5.1 are theirs
_LOSES = {
    "home": "a reference return (G28, G30) leaves the program's coordinates",
    "machine": "G53 moves in machine coordinates",
    "skip": "a skip move (G31) ends where the probe trips",
    "set-position": "G92 or G50 sets a new origin",
    "shift": "G52 shifts the origin",
    "data-setting": "G10 may change an offset",
    "macro-call": "a macro call moves the tool",
    "service": "a service code moves the tool",
    "tilt": "G53.1 turns the tool axis",
    "rough-cycle": "a roughing cycle moves the tool",
    "finish-cycle": "a finishing cycle moves the tool",
    "peck-cycle": "a pecking cycle moves the tool",
    "thread-cycle": "a threading cycle moves the tool",
}
# Codes whose block gives its other words a meaning of their own: no axis motion, no vibration words.
_READS_ALL = frozenset(_LOSES) - {"machine", "skip"} | {"dwell", "tuning"}
_COORDINATE_GROUPS: frozenset[Group] = frozenset(
    {"work_offset", "rotation", "polar", "scaling", "mirror", "interpolation"}
)
# The axis words of their codes are a centre, no move; those of LinuxCNC's G43.1 are an offset.
_CENTRE_GROUPS: tuple[Group, ...] = ("rotation", "scaling", "mirror")
_LOSES_NAMED_AXES = ("home", "machine", "skip")
_AXES_WITHOUT_V = frozenset("XYZUWABCH")
_PLAIN_LETTERS = frozenset("GMTSFODHABC")
_ARCS: tuple[Motion, ...] = ("cw", "ccw")
_CENTRE_LETTERS = frozenset(CENTRES)


def initial_state(settings: Settings) -> State:
    """The state at the first block: the control's power-on modes."""
    return State(modes=settings.dialect.initial)


class Interpreter:
    """Reads blocks under one profile.  Holds no state of its own."""

    def __init__(self, settings: Settings, flow: Flow) -> None:
        self.settings, self.flow = settings, flow
        self.dialect = settings.dialect
        self.axis_letters = frozenset(settings.axis_words.axes)

    def advance(self, state: State, block: Block) -> BlockEffect:
        """What a block does."""
        if state.ended and not block.is_empty:
            state = initial_state(self.settings)._replace(unknown_why="another program starts here")
        if block.line in self.flow.targets:
            state = state.forgotten(JUMPED)
        if block.opaque:
            return BlockEffect(block, state, state.forgotten(f"line {block.line + 1} {UNREAD}"))
        if block.is_empty:
            effect = BlockEffect(block, state, state)
            return self._with_cutting_speed(effect) if block.comments else effect
        if self.flow.in_contour(block.line):
            asks = vibration_words(block, self.axis_letters, cuts=True, has_once=False)
            return BlockEffect(block, state, state, vibration=asks, in_contour=True)
        effect = self._with_cutting_speed(self._execute(state, block))
        if block.skip:
            effect = effect._replace(after=_maybe(state, effect.after, block.line))
        return effect

    def _with_cutting_speed(self, effect: BlockEffect) -> BlockEffect:
        """V and D set the speed; a fault in them is the speeds pass's to report."""
        try:
            asked = cutting_speed_of(effect.block, effect.after)
        except RefusalError:
            return effect
        if asked is None:
            return effect
        text = asked.speed_text(self.settings.spindle.resolution_rpm)
        after = effect.after._replace(speed=Setting(float(text), text, effect.block.line))
        unread = tuple(w for w in effect.unread if w not in asked.words)
        return effect._replace(after=after, unread=unread, cutting_speed=asked)

    def _execute(self, state: State, block: Block) -> BlockEffect:
        changes, non_modal, unknown = self._codes(block)
        modes = state.modes.replace(changes)
        motion = modes.motion
        reads_all = bool(non_modal & _READS_ALL)
        # A full circle may name its centre only.
        # So is an axis of another profile's: its wish must be refused, not passed over.
        moving = self.axis_letters | set(AXES) | (_CENTRE_LETTERS if motion in _ARCS else set())
        mode_words = "PQR" if changes.keys() & _MODES_WITH_WORDS else ""
        cuts = motion in CUTTING and not (unknown or mode_words)
        vibration = vibration_words(block, moving, cuts=cuts, has_once=reads_all)
        after = self._values(state, block, changes, modes, non_modal, vibration=vibration)
        if "macro-call" not in non_modal:  # T, M and S of a G65 block are arguments
            after = self._machine_functions(after, block)
        move = None
        has_centre = any(changes.get(group) == "on" for group in _CENTRE_GROUPS)
        has_centre |= changes.get("length_offset") == "by-axes"
        if not has_centre:
            after, move = self._motion(after, block, non_modal, unknown)
        after = self._flow_of_control(after, block)
        mode_words += "P" if " P" in changes.get("work_offset", "") else ""
        seen = (*vibration, *(w for w in block.words if w.address in mode_words))
        unread = () if reads_all or has_centre or block.has_macro else self._unread(block, seen, after, move)
        return BlockEffect(block, state, after, move, non_modal, vibration, unread)

    def _codes(self, block: Block) -> tuple[dict[str, str], frozenset[str], bool]:
        """Modal changes, non-modal codes, and whether a G code is not known."""
        changes: dict[str, str] = {}
        non_modal: set[str] = set()
        unknown = False
        for word in block.words:
            if word.address != "G":
                continue
            value = plain_value(word)
            code = None if math.isnan(value) else self.dialect.g_codes.get(round(value * 10))
            if code is None:
                unknown = True
            elif code.group == NON_MODAL:
                non_modal.add(code.value)
            else:
                changes[code.group] = code.value
        if "cylinder" in changes:
            changes["cylinder"] = cylinder_of(block)
        if "work_offset" in changes:
            changes["work_offset"] = offset_of(block, changes["work_offset"])
        return changes, frozenset(non_modal), unknown

    def _values(
        self,
        state: State,
        block: Block,
        changes: dict[str, str],
        modes: Modes,
        non_modal: frozenset[str],
        *,
        vibration: Words,
    ) -> State:
        """(1) feed mode, (2) feed, (3) speed, (7) the other modal groups."""
        was = state.modes
        after = state if modes is was else state._replace(modes=modes)
        if modes.feed_mode != was.feed_mode or modes.units != was.units:
            after = after._replace(feed=None)
        if modes.speed_mode != was.speed_mode:
            after = after._replace(speed=None)
        if "speed_mode" in changes and self.dialect.surface_limit:
            limit = surface_limit(block, modes.speed_mode, self.dialect)
            after = after._replace(speed_limit=limit)
        if "path" in changes:
            after = after._replace(path_words=self._group_words(block, "path"))
        if "look_ahead" in changes:
            after = after._replace(smooth_words=self._group_words(block, "look_ahead"))
        limits = self._is_speed_limit(block)
        reads_all = bool(non_modal & _READS_ALL) and not limits
        for word in block.words:
            if word in vibration or reads_all:
                continue
            if word.address == "F":
                value = feed_value(word, after, self.settings.control)
                after = after._replace(feed=Setting(value, word.value_text, block.line))
            elif word.address == "S":
                setting = Setting(plain_value(word), word.value_text, block.line)
                after = after._replace(speed_limit=setting) if limits else after._replace(speed=setting)
        worked_out = "work_offset" in changes and block.has_macro
        if worked_out or _COORDINATE_GROUPS.intersection(was.changed(modes)):
            after = after.lost("the coordinate system changed")
        if changes.get("length_offset", "off") != "off" or (
            "length_offset" in changes and was.length_offset != "off"
        ):
            after = after._replace(position=after.position._replace(z=math.nan))
            after = after._replace(unknown_why="tool length compensation changed Z")
        return after

    def _group_words(self, block: Block, group: Group) -> str:
        """``G64 P0.01 Q0.005``, ``G5.1 Q1 R3``: a mode in the program's own words."""
        addresses = {("G", n / 10.0) for n in codes_of(block, group, self.dialect)}
        words = [w for w in block.words if w.address in "PQR" or (w.address, w.number) in addresses]
        return " ".join(block.text[w.start : w.end] for w in words)

    def _is_speed_limit(self, block: Block) -> bool:
        """``G50 S2000``: a code that limits the spindle when it stands with S."""
        codes = {round(w.number * 10) for w in block.words if w.address == "G" and w.number is not None}
        return bool(codes & self.dialect.speed_limit) and block.word("S") is not None

    def _machine_functions(self, state: State, block: Block) -> State:
        """(4) tool, (5) spindle, (6) coolant, (10) stop."""
        for word in block.words:
            value = plain_value(word)
            if word.address == "T":
                state = self._tool_word(state, value)
            elif word.address == "M" and not math.isnan(value):
                state = m_code(state, int(value), self.dialect)
        if self.dialect.tool_change == "M6" and any(w.address == "M" and w.number == 6 for w in block.words):
            state = state._replace(tool=state.next_tool).lost("a tool change moves the machine")
        return state

    def _tool_word(self, state: State, value: float) -> State:
        number = None if math.isnan(value) else int(value)
        if self.dialect.tool_change == "M6":
            return state._replace(next_tool=number)
        if number is not None and number >= 100:
            number //= 100
        return state._replace(tool=number, next_tool=None).lost("a tool or its offset changed")

    def _motion(
        self, state: State, block: Block, non_modal: frozenset[str], unknown: bool
    ) -> tuple[State, Move | None]:
        """(8) non-modal codes, (9) motion."""
        axis_words = [w for w in block.words if w.letter.upper() in self.axis_letters]
        if not any(w.address in _AXES_WITHOUT_V for w in block.words) and block.word("D") is not None:
            axis_words = []  # V beside D is a peripheral speed
        limits_only = "set-position" in non_modal and not axis_words
        for name in sorted(non_modal):
            if name in _LOSES and not limits_only:
                axes = [self.settings.axis_words.axes[w.address] for w in axis_words]
                state = _lose_axes(state, axes, _LOSES[name], everything=name not in _LOSES_NAMED_AXES)
        has_centre = any(w.address in _CENTRE_LETTERS for w in block.words)
        is_circle = has_centre and state.modes.motion in _ARCS
        if not (axis_words or is_circle) or non_modal & _READS_ALL:
            return state, None
        if unknown:
            return state.lost("a G code this profile does not know stands with axis words"), None
        move = move_of(block, state, axis_words, self.settings, non_modal)
        return state._replace(position=move.end), move

    def _flow_of_control(self, state: State, block: Block) -> State:
        """Loops, subprograms and calls: the next block may be reached with other values."""
        for control in block.controls:
            if control.keyword in ("WHILE", "DO", "END") or control.keyword.startswith("O-"):
                called = control.keyword == "O-CALL"
                why = "a subprogram moves the tool" if called else LOOPED
                state = state.lost(why) if called else state.forgotten(why)
        for word in block.words:
            if word.address == "M" and word.number in _CALLS:
                state = state.lost("a subprogram moves the tool")
        return state

    def _unread(self, block: Block, seen: Words, after: State, move: Move | None) -> Words:
        read = _PLAIN_LETTERS | self.axis_letters
        motion = after.modes.motion
        if motion in _ARCS:
            read |= _CENTRE_LETTERS | {"R"}
        if motion not in ("rapid", "line", "cw", "ccw"):
            return ()
        if any(w.address == "M" and w.number is not None for w in block.words) and move is None:
            return ()
        return tuple(w for w in block.words if w.letter.upper() not in read and w not in seen)


def _lose_axes(state: State, axes: list[str], why: str, *, everything: bool) -> State:
    if everything or not axes:
        return state.lost(why)
    position = state.position._replace(**{a.lower(): math.nan for a in axes if a in AXES})
    return state._replace(position=position, unknown_why=why)


def _maybe(before: State, after: State, line: int) -> State:
    """After a block that an operator may switch off: what differs cannot be known."""
    pairs = zip(before.position, after.position, strict=True)
    position = Position(*(b if a == b else math.nan for a, b in pairs))
    if position != after.position:
        why = f"line {line + 1} is skipped while block delete is on"
        after = after._replace(position=position, unknown_why=why)
    return after._replace(ended=before.ended)
