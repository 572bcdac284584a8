"""Which spindle speed is commanded where: once for a run of cuts that share it, and back when it is needed.

The speed a vibrated cut needs is commanded before its first move.  The programmed speed comes back before
the next block that depends on it: a cut that does not vibrate, a thread, a cycle, a call, a spindle start,
the end of the program.  Between two vibrated cuts of one speed nothing is commanded.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from chipbreak.dialects import Dialect
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.numbers import print_number
from chipbreak.syntax.variables import variables_of
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.chain import SPEED_MODES
from chipbreak.vibration.plan import CutPlan

_Blocks = tuple[str, ...]
_FREE_NON_MODAL = frozenset(
    {"dwell", "home", "machine", "exact-stop", "set-position", "data-setting", "shift"}
)


@dataclass(frozen=True)
class SpeedChange:
    """``blocks`` are to command it before line ``line``; ``for_cut`` where it belongs to a vibrated cut."""

    line: int
    blocks: tuple[str, ...]
    for_cut: CutPlan | None

    @property
    def text(self) -> str:
        """The words of a change of one block."""
        return " ".join(self.blocks)


def speed_changes(
    interpreted: InterpretedProgram,
    cuts: Sequence[CutPlan],
    settings: Settings,
    restarted_at: Collection[int] = (),
    air_lines: Collection[int] = (),
) -> list[SpeedChange]:
    """All speed commands that the vibrated cuts need, in order.

    ``restarted_at`` are the lines before which the spindle will be stopped and started as programmed, as for
    a tool check; ``air_lines`` those of feed moves that cut nothing.  Raises UnknownSpeedError, VIB057, when
    the programmed speed must come back and is not known.
    """
    changes: list[SpeedChange] = []
    commanded: tuple[str, float] | None = None  # mode and speed, None while the program's own is active
    stops = [*(cut.chain.first for cut in cuts[1:]), interpreted.program.source.body.stop]
    for cut, stop in zip(cuts, stops, strict=False):
        # An S in the block itself goes with the block; what the spindle turns is what stood before it.
        now = commanded or _programmed(cut.chain.requests[0].effect.before)
        wanted = ("rpm", cut.solution.speed_rpm)
        if now != wanted:
            words = speed_words(now, wanted, cut.chain.before, settings)
            changes.append(SpeedChange(cut.chain.first, (words,), cut))
        if wanted == _programmed(cut.chain.after):
            commanded = None
            continue
        around = _Around(interpreted, frozenset(restarted_at), frozenset(air_lines))
        try:
            back = _needs_programmed(around, cut.chain.last, stop)
        except RefusalError as error:
            raise UnknownSpeedError(error.code, error.message, error.help, cut.chain.first) from None
        commanded = wanted if back is None else None
        if back is not None and back.blocks:
            changes.append(back)
    return changes


def _programmed(state: State) -> tuple[str, float] | None:
    if state.speed is None:
        return None
    return state.modes.speed_mode, state.speed.value


def speed_words(
    now: tuple[str, float] | None, wanted: tuple[str, float], state: State, settings: Settings
) -> str:
    """S, and the speed mode where it is another than ``now``: mode and speed."""
    # A speed is on the resolution of the spindle, or the program's own.
    speed = _for_choice(f"S{print_number(wanted[1], 3, point=False)}", state)
    is_same = now is not None and now[0] == wanted[0]
    if is_same or not settings.dialect.can("speed_mode", wanted[0]):
        return settings.dialect.with_code(state.spindle, speed)
    return f"{settings.dialect.code('speed_mode', wanted[0])} {speed}"


class UnknownSpeedError(RefusalError):
    """Behind the cut at line ``first`` the programmed speed must come back, and nobody knows it."""

    def __init__(self, code: str, message: str, help: str, first: int) -> None:
        super().__init__(code, message, help)
        self.first = first
        self.args = (code, message, help, first)


class _Around(NamedTuple):
    """The program around the cuts: see :func:`speed_changes`."""

    interpreted: InterpretedProgram
    restarted_at: frozenset[int]
    air_lines: frozenset[int]


def _needs_programmed(around: _Around, first: int, stop: int) -> SpeedChange | None:
    """Where the programmed speed must be back; without blocks where the program commands a speed itself."""
    interpreted = around.interpreted
    restart = min((line for line in around.restarted_at if first <= line <= stop), default=None)
    state = interpreted.before(first)
    for effect in interpreted.effects_of(first, stop):
        line = effect.block.line
        at = _Place(effect, state, line == restart, line in around.air_lines, interpreted)
        found = next((blocks for rule in _NEEDS if (blocks := rule(at)) is not None), None)
        if found is not None:
            return SpeedChange(effect.block.line, found, None)
        state = effect.after
    if restart == stop and state.speed is not None:
        return SpeedChange(restart, _own_blocks(state, interpreted.settings), None)
    return None


class _Place(NamedTuple):
    """A block behind a vibrated cut, and the state that the program has before it."""

    effect: BlockEffect
    state: State
    is_restarted: bool
    is_air: bool
    interpreted: InterpretedProgram

    @property
    def own_blocks(self) -> _Blocks:
        """The programmed speed before this block.  Errors: VIB057 where it is not known."""
        return _known_blocks(self, self.state)


def _known_blocks(at: _Place, state: State) -> _Blocks:
    """The programmed speed of a state.  Errors: VIB057 where it takes an S that is not known."""
    settings = at.interpreted.settings
    has_bare_surface = state.modes.speed_mode == "surface" and not settings.dialect.surface_needs_speed
    if not _is_unknown(state) or has_bare_surface:
        return _own_blocks(state, settings)
    if _ends(at.effect):
        return ()
    raise _not_said(at)


def _ends(effect: BlockEffect) -> bool:
    """True for the end of the program, which ends constant surface speed with it."""
    return effect.does("program", "end") or effect.does("subprogram", "return")


def _is_unknown(state: State) -> bool:
    """True without an S, or where block delete may skip it, or the limit that belongs to it."""
    limit = state.speed_limit
    limit_is_open = limit is not None and math.isnan(limit.value) and state.modes.speed_mode == "surface"
    return state.speed is None or math.isnan(state.speed.value) or limit_is_open


def _not_said(at: _Place) -> RefusalError:
    said = at.interpreted.program.source.place(at.effect.block.line).line
    message = f"line {said} needs the spindle speed from before this cut, which the program does not say"
    way_out = "give S before the cut, even when N and f make another of it, or behind it"
    return RefusalError("VIB057", message, way_out)


def _before_restart(at: _Place) -> _Blocks | None:
    """The spindle starts again as programmed, behind a tool check for example."""
    return at.own_blocks if at.is_restarted and at.state.speed is not None else None


def _before_target(at: _Place) -> _Blocks | None:
    """A jump to here comes with the programmed speed; in a shape of a later cycle nothing is commanded."""
    flow, line = at.interpreted.flow, at.effect.block.line
    return at.own_blocks if line in flow.targets or flow.is_run_again(line) else None


def _before_other_path(at: _Place) -> _Blocks | None:
    """Another path begins, waits, or turns the spindle: it finds the programmed speed.  Errors: VIB057."""
    leaves = at.effect.after.path != at.state.path or _loses_spindle(at.effect)
    leaves = leaves or at.effect.after.choice != at.state.choice
    return at.own_blocks if leaves else None


def _loses_spindle(effect: BlockEffect) -> bool:
    return bool(effect.after.spindle_why) and effect.after.spindle_why != effect.before.spindle_why


def _before_own_speed(at: _Place) -> _Blocks | None:
    """The program commands a speed itself."""
    before = at.effect.before
    after = at.effect.after
    if at.effect.block.is_optional:  # where it is skipped, the speed is the one from before
        return _known_blocks(at, before) if _says_speed(at.effect) else None
    # Where a loop or a jump ends, several ways meet: nothing is commanded there.
    if after.speed == before.speed or after.speed is None or at.effect.block.statements:
        return None
    # An S under G96 is metres per minute: it must not meet the G97 of the cut before it.
    own_mode = after.modes.speed_mode == "rpm" or _says_speed_mode(at.effect)
    return () if own_mode else _known_blocks(at, before)


def _before_bare_mode(at: _Place) -> _Blocks | None:
    """G96 again, without S, takes the S in force.  Errors: VIB057."""
    takes = _says_speed_mode(at.effect) and not at.effect.says("S")
    return _known_blocks(at, at.effect.before) if takes else None


def _before_dependent(at: _Place) -> _Blocks | None:
    """What the block does depends on the speed.  Errors: VIB057."""
    if not _depends_on_speed(at.effect, at.interpreted.settings.dialect, is_air=at.is_air):
        return None
    return _known_blocks(at, at.effect.before)


def _before_stop(at: _Place) -> _Blocks | None:
    """At a stop and a tool change the operator finds the program's own speed, where it is known."""
    stops = at.effect.does("stop") or at.effect.does("tool")
    if _is_unknown(at.effect.before) or not stops:
        return None
    return _own_blocks(at.effect.before, at.interpreted.settings)


_NEEDS = (
    _before_restart,
    _before_target,
    _before_other_path,
    _before_own_speed,
    _before_bare_mode,
    _before_dependent,
    _before_stop,
)


def _says_speed(effect: BlockEffect) -> bool:
    return effect.says("S") or _says_speed_mode(effect) or effect.does("spindle")


def _says_speed_mode(effect: BlockEffect) -> bool:
    return effect.block.has("G", *SPEED_MODES)


def _for_choice(speed: str, state: State) -> str:
    """An S for the spindle that the program has chosen, which is said anew."""
    return f"{speed} {state.choice}" if speed and state.choice else speed


def _own_blocks(state: State, settings: Settings) -> _Blocks:
    """The program's own speed, in its own digits and units."""
    text = "" if state.speed is None or math.isnan(state.speed.value) else f"S{state.speed.text}"
    text = _for_choice(text, state)
    if state.modes.speed_mode == "rpm":
        return (settings.dialect.with_code(state.spindle, text),) if text else ()
    words = [settings.dialect.code("speed_mode", state.modes.speed_mode)]
    if settings.dialect.surface_limit and state.speed_limit is not None:
        words.append(f"{settings.dialect.surface_limit}{state.speed_limit.text}")
    said = " ".join([*words, text]).rstrip()
    speed = state.speed
    if speed is None or speed.units == state.modes.units or not settings.dialect.feed_before_units:
        return (said,)
    # The S is read in the units before those of its block; where the spindle starts it is read again.
    before, now = (settings.dialect.code("units", units) for units in (speed.units, state.modes.units))
    return (before, f"{now} {said}")


def _depends_on_speed(effect: BlockEffect, dialect: Dialect, *, is_air: bool) -> bool:
    """True for a block whose effect depends on the spindle speed, or that hands the speed on."""
    if effect.block.is_empty or effect.in_contour:
        return False
    if effect.block.opaque or effect.block.controls or effect.non_modal - _FREE_NON_MODAL:
        return True
    if _reads_speed(effect.block, dialect) or _may_cut(effect, dialect):
        return True
    if effect.move is not None and effect.move.kind != "rapid" and not is_air:
        return True
    leaves = effect.does("subprogram") or effect.does("program", "end") or effect.does("modes", "keep")
    return leaves or effect.does("spindle", "cw", "ccw")


def _may_cut(effect: BlockEffect, dialect: Dialect) -> bool:
    """True for a code that the profile does not know, a rotary feed, and words that are perhaps no new zero.

    Beside LinuxCNC's G92.1 axis words are a move.
    """
    codes = [dialect.g_codes.get(round(number * 10)) for number in effect.block.numbers("G")]
    moves = "set-position" in effect.non_modal and effect.after.modes.motion != "rapid"
    is_move = moves and effect.block.has_any(dialect.axis_letters)
    return None in codes or is_move or effect.feeds_others


def _reads_speed(block: Block, dialect: Dialect) -> bool:
    """True for a block that works with the speed in force (``#100=#4119``), or may (``#1=#[#2]``)."""
    if not block.has_macro and not block.assignments:
        return False
    return any(key is None or key in dialect.speed_variables for key in variables_of(block))
