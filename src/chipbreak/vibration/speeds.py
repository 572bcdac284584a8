"""Which spindle speed is commanded where: once for a run of cuts that share it, and back when it is needed.

The speed a vibrated cut needs is commanded before its first move.  The programmed speed comes back before
the next block that depends on it: a cut that does not vibrate, a thread, a cycle, a call, a spindle start,
the end of the program.  Between two vibrated cuts of one speed nothing is commanded.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import Setting, State
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError
from chipbreak.vibration.chain import SPEED_MODES
from chipbreak.vibration.plan import CutPlan

_FREE_NON_MODAL = frozenset(
    {"dwell", "home", "machine", "exact-stop", "set-position", "data-setting", "shift"}
)


@dataclass(frozen=True)
class SpeedChange:
    """``text`` is to be commanded before line ``line``; ``for_cut`` where it belongs to a vibrated cut."""

    line: int
    text: str
    for_cut: CutPlan | None


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
            changes.append(SpeedChange(cut.chain.first, speed_words(now, wanted, settings), cut))
        if wanted == _programmed(cut.chain.after):
            commanded = None
            continue
        around = _Around(interpreted, frozenset(restarted_at), frozenset(air_lines))
        try:
            back = _needs_programmed(around, cut.chain.last, stop)
        except RefusalError as error:
            raise UnknownSpeedError(error.code, error.message, error.help, cut.chain.first) from None
        commanded = wanted if back is None else None
        if back is not None and back.text:
            changes.append(back)
    return changes


def _programmed(state: State) -> tuple[str, float] | None:
    if state.speed is None:
        return None
    return state.modes.speed_mode, state.speed.value


def speed_words(now: tuple[str, float] | None, wanted: tuple[str, float], settings: Settings) -> str:
    """S, and the speed mode where it is another than ``now``: mode and speed."""
    # A speed is on the resolution of the spindle, or the program's own.
    speed = f"S{print_number(wanted[1], 3, point=False)}"
    if now is not None and now[0] == wanted[0]:
        return speed
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
    """Where the programmed speed must be back; an empty text where the program commands a speed itself."""
    interpreted = around.interpreted
    restart = min((line for line in around.restarted_at if first <= line <= stop), default=None)
    state = interpreted.before(first)
    for effect in interpreted.effects_of(first, stop):
        line = effect.block.line
        at = _Place(effect, state, line == restart, line in around.air_lines, interpreted)
        found = next((text for rule in _NEEDS if (text := rule(at)) is not None), None)
        if found is not None:
            return SpeedChange(effect.block.line, found, None)
        state = effect.after
    if restart == stop and state.speed is not None:
        return SpeedChange(restart, _own_words(state, interpreted.settings), None)
    return None


class _Place(NamedTuple):
    """A block behind a vibrated cut, and the state that the program has before it."""

    effect: BlockEffect
    state: State
    is_restarted: bool
    is_air: bool
    interpreted: InterpretedProgram

    @property
    def own_words(self) -> str:
        """The programmed speed before this block."""
        return _own_words(self.state, self.interpreted.settings)


def _before_restart(at: _Place) -> str | None:
    """The spindle starts again as programmed, behind a tool check for example."""
    return at.own_words if at.is_restarted and at.state.speed is not None else None


def _before_target(at: _Place) -> str | None:
    """A jump to here comes with the programmed speed."""
    return at.own_words if at.effect.block.line in at.interpreted.flow.targets else None


def _before_other_path(at: _Place) -> str | None:
    """Another path begins, waits, or turns the spindle: it finds the programmed speed.  Errors: VIB057."""
    leaves = at.effect.after.path != at.state.path or _loses_spindle(at.effect)
    if not leaves:
        return None
    if at.state.speed is None:
        raise _not_known(at)
    return at.own_words


def _loses_spindle(effect: BlockEffect) -> bool:
    return bool(effect.after.spindle_why) and effect.after.spindle_why != effect.before.spindle_why


def _not_known(at: _Place) -> RefusalError:
    said = at.interpreted.program.source.place(at.effect.block.line).line
    message = f"line {said} needs the spindle speed from before this cut,"
    way_out = "give S before the cut, even when N and f make another of it, or behind it"
    return RefusalError("VIB057", f"{message} which the program does not say", way_out)


def _before_own_speed(at: _Place) -> str | None:
    """The program commands a speed itself."""
    before = at.effect.before
    after = at.effect.after
    if after.speed == before.speed or after.speed is None:
        return None
    # An S under G96 is metres per minute: it must not meet the G97 of the cut before it.
    own_mode = after.modes.speed_mode == "rpm" or _says_speed_mode(at.effect)
    return "" if own_mode else _own_words(before, at.interpreted.settings)


def _before_dependent(at: _Place) -> str | None:
    """What the block does depends on the speed.  Errors: VIB057."""
    if at.is_air or not _depends_on_speed(at.effect):
        return None
    if at.effect.before.speed is None and at.effect.move is not None:
        raise _not_known(at)
    return _own_words(at.effect.before, at.interpreted.settings)


_NEEDS = (_before_restart, _before_target, _before_other_path, _before_own_speed, _before_dependent)


def _says_speed_mode(effect: BlockEffect) -> bool:
    return effect.block.has("G", *SPEED_MODES)


def _own_words(state: State, settings: Settings) -> str:
    """The program's own speed, in its own digits."""
    speed: Setting | None = state.speed
    text = "" if speed is None else f"S{speed.text}"
    if state.modes.speed_mode == "rpm":
        return text
    words = [settings.dialect.code("speed_mode", state.modes.speed_mode)]
    if settings.dialect.surface_limit and state.speed_limit is not None:
        words.append(f"{settings.dialect.surface_limit}{state.speed_limit.text}")
    return " ".join([*words, text]).rstrip()


def _depends_on_speed(effect: BlockEffect) -> bool:
    """True for a block whose effect depends on the spindle speed, or that hands the speed on."""
    if effect.block.is_empty or effect.in_contour:
        return False
    if effect.block.opaque or effect.block.controls or effect.non_modal - _FREE_NON_MODAL:
        return True
    if effect.move is not None and effect.move.kind != "rapid":
        return True
    leaves = effect.does("subprogram") or effect.does("program", "end")
    return leaves or effect.does("spindle", "cw", "ccw")
