"""Safe borders: lines before which a check can be inserted, and what has to be put back behind it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from chipbreak.insertion.clearance import Clearance
from chipbreak.insertion.obstacles import Ground
from chipbreak.insertion.position_dependencies import homed_axes, named_axes, reliance, relies_on_speed
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.words import codes_of, plain_value
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.operations.operations import calls_tool
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import read_block

# How far around the obvious line a safe one is looked for.
REACH = 500


class SafePoint(NamedTuple):
    """A line before which a check can stand.

    ``state``          the state there
    ``axes``           axes that have to stand again where they stood, in the order X, Y, Z
    ``length_offset``  words that bring the length offset back into force, such as ``G43 H2``, or ""
    ``needs_speed``    True when S must be in force again, because the spindle turns or starts without S
    """

    line: int
    state: State
    axes: str
    length_offset: str
    needs_speed: bool


class NoSafePoint(NamedTuple):
    """Why there is none: what is wrong at the obvious line, and what would help."""

    line: int
    why: str
    help: str = "make a place for it: G0 to a known position, G40, G80, the spindle with S"


class Range(NamedTuple):
    """Where to look: forward from ``obvious`` to ``last``, then back to ``first`` (all of them lines).

    The line before ``first`` is a cut, a tool call or nothing (``at_start``).
    """

    first: int
    obvious: int
    last: int
    at_start: bool = False


class _Spot(NamedTuple):
    """A line, the state before it, and what brought the tool there.

    ``mover``   "nothing" yet, "rapid", "home" (or the machine's own tool change), "call" of
                a subprogram or a macro, or "cut" for all else
    ``homed``   axes that the program sent to a fixed place where our own retract does not take them
    ``z_is_home``  the last move of Z was a reference return, which ends the length offset as ours does
    ``z_is_shifted``  the length offset changed after the last move of Z: its number says nothing now
    ``is_displaced``  X and Y stand beside their numbers: G40 has ended cutter compensation without a move
    ``spindle_is_open``  M3 was active at a tool change; some machines stop the spindle there, some do not
    """

    line: int
    state: State
    mover: str
    homed: frozenset[str] = frozenset()
    z_is_home: bool = False
    z_is_shifted: bool = False
    is_displaced: bool = False
    spindle_is_open: bool = False


class SafePointFinder:
    """Looks for safe borders in one program.

    ``calls_end_offset`` is True for calls that may end the length offset, as some makers' cycles do.
    """

    def __init__(
        self, interpreted: InterpretedProgram, ground: Ground, *, calls_end_offset: bool = False
    ) -> None:
        self.interpreted, self.ground = interpreted, ground
        self.dialect = interpreted.settings.dialect
        effects_of = list(retract_steps(interpreted.settings))
        self._retracted = {axis for effect in effects_of for axis in named_axes(effect, interpreted.settings)}
        self._retract_homes = any("home" in effect.non_modal for effect in effects_of)
        self._calls_end_offset = calls_end_offset
        self._clearance = Clearance(interpreted, ground.main) if self.dialect.is_lathe else None

    def find(self, where: Range) -> SafePoint | NoSafePoint:
        """The first safe line of a range."""
        spots = self._spots(where)
        forward = [spot for spot in spots if spot.line >= where.obvious]
        back = [spot for spot in spots if spot.line < where.obvious][::-1]
        first_refusal: NoSafePoint | None = None
        for spot in forward + back:
            found = self._judge(spot)
            if isinstance(found, SafePoint):
                return found
            first_refusal = first_refusal or found
        return first_refusal or NoSafePoint(where.obvious, "there is no block between")

    def _spots(self, where: Range) -> list[_Spot]:
        first = max(where.first, where.obvious - REACH)
        start = first if where.at_start and first == where.first else max(first - 1, self.ground.main.first)
        last = min(where.last, where.obvious + REACH, self._end())
        if last < start:
            return []
        before, mover = self.interpreted.before(start), "nothing" if where.at_start else "cut"
        spot = _Spot(start, before, mover, is_displaced=_compensates(before))
        spots = [spot]
        for effect in self.interpreted.effects_of(start, last):
            spot = self._behind(spot, effect)
            spots.append(spot)
        return [spot for spot in spots if spot.line >= first]

    def _end(self) -> int:
        """The last line before which something can be inserted."""
        source = self.interpreted.program.source
        is_open = source.data[-1:] not in (b"\n", b"\r")
        return min(self.ground.main.last, source.line_count - 1 if is_open else source.line_count)

    def _behind(self, spot: _Spot, effect: BlockEffect) -> _Spot:
        """The next line, with what the step did."""
        line, state, mover = spot.line + 1, effect.after, spot.mover
        homed, z_is_home, is_open = spot.homed, spot.z_is_home, spot.spindle_is_open
        moves_z = effect.move is not None and "Z" in effect.move.axes
        shifts = bool(codes_of(effect.block, "length_offset", self.dialect))
        z_is_shifted = not moves_z and (shifts or spot.z_is_shifted)
        codes = set(effect.block.numbers("M"))
        axes_of = homed_axes if "home" in effect.non_modal else named_axes
        named = axes_of(effect, self.interpreted.settings)
        if codes & {3.0, 4.0, 5.0, 19.0}:
            is_open = False
        if calls_tool(effect, self.dialect.tool_change):
            mover, homed = "home", frozenset()
            is_open = state.turns and not codes & {3.0, 4.0}
        elif "home" in effect.non_modal or ("machine" in effect.non_modal and state.modes.motion == "rapid"):
            mover, homed = "home", homed | (named - self._reproducible(effect))
        elif calls_subprogram(effect) or "macro-call" in effect.non_modal or "service" in effect.non_modal:
            mover = "call"
        elif effect.move is not None:
            # A canned cycle ends with its own way out.
            rapid = effect.move.kind == "rapid" or (state.modes.motion == "cycle" and not effect.non_modal)
            mover, homed = ("rapid" if rapid else "cut"), homed - named
            z_is_home = z_is_home and "Z" not in named
        z_is_home = z_is_home or ("home" in effect.non_modal and "Z" in named)
        in_plane = effect.move is not None and bool(set("XY") & set(effect.move.axes))
        is_displaced = _compensates(state) or (spot.is_displaced and not in_plane and mover != "home")
        return _Spot(line, state, mover, homed, z_is_home, z_is_shifted, is_displaced, is_open)

    def _reproducible(self, effect: BlockEffect) -> set[str]:
        """Axes that our own retract takes to the same place: G28, or G53 to zero."""
        g28 = effect.block.has("G", 28)
        axes = self.interpreted.settings.axis_words.axes
        zero = {axes.get(w.address, "") for w in effect.block.words if plain_value(w) == 0.0}
        return self._retracted if g28 and self._retract_homes else self._retracted & zero

    def _judge(self, spot: _Spot) -> SafePoint | NoSafePoint:
        state = spot.state
        why = self.ground.why_not(spot.line, state) or self._why_not(spot)
        if why and why == self.ground.unreadable(spot.line):
            return NoSafePoint(spot.line, why, "call the tool again behind it: from there on all is known")
        if why:
            return NoSafePoint(spot.line, why)
        is_on = state.modes.length_offset != "off"
        has_offset = is_on and (self._calls_end_offset or (self._retract_homes and not spot.z_is_home))
        needed = reliance(
            self.interpreted,
            spot.line,
            spot.homed,
            has_offset=has_offset,
            home_ends_offset=not self._calls_end_offset,
        )
        if needed.length_offset and spot.z_is_home:
            why = "the next blocks rely on a length offset, which a reference return or the calls may end"
            return NoSafePoint(spot.line, why)
        axes = set(needed.axes)
        if "Z" in axes or needed.length_offset:
            # The way down to Z starts where X and Y stood, and ends at a height that counts from the offset.
            axes |= set("XZ" if self.dialect.is_lathe else "XYZ")
        restates = has_offset and "Z" in axes
        known = dict(zip("XYZ", state.position, strict=True))
        lost = [axis for axis in "XYZ" if axis in axes and math.isnan(known[axis])]
        if lost:
            why = f"the next blocks rely on where {lost[0]} stands, which nobody knows: {state.unknown_why}"
            return NoSafePoint(spot.line, why)
        doubt = self.ground.place_in_doubt(spot.line, axes)
        if doubt:
            return NoSafePoint(spot.line, f"the next blocks rely on where the tool stands, and {doubt}")
        if spot.is_displaced and not self.dialect.is_lathe and axes & set("XY"):
            why = "the next blocks rely on where X and Y stand, and G40 has ended compensation without a move"
            return NoSafePoint(spot.line, why, "move X or Y in the block of G40 or behind it, in rapid")
        if "Z" in axes and spot.z_is_shifted:
            why = "the next blocks rely on where Z stands, and the length offset changed since it moved"
            return NoSafePoint(spot.line, why)
        words = self._offset_words(spot.line) if restates else ""
        if words is None:
            why = "the length offset must be put back, and which G43 H is in force cannot be known"
            return NoSafePoint(spot.line, why)
        needs_speed = state.turns or relies_on_speed(self.interpreted, spot.line)
        if needs_speed and (state.speed is None or not state.speed.value > 0.0):
            return NoSafePoint(spot.line, "the spindle speed must be put back, and S cannot be known")
        return SafePoint(spot.line, state, "".join(a for a in "XYZ" if a in axes), words, needs_speed)

    def _why_not(self, spot: _Spot) -> str:
        """What the last move and the spindle say against the place."""
        motion = spot.state.modes.motion
        if motion not in ("rapid", "none", "line", "cw", "ccw"):
            return "a cycle is still on"
        if spot.mover == "call":
            return "a subprogram or a macro was called last, and no rapid stands between"
        if spot.mover == "cut":
            return "the last move was a cut, not a rapid"
        if motion in ("cw", "ccw") or (motion == "line" and spot.mover != "home"):
            return "the motion mode is a cut, not a rapid"
        if motion == "line" and not self._takes_bare_line(spot):
            return "G1 would have to be given back, and no F is in force for it"
        is_rapid = spot.mover == "rapid"
        if self._clearance and is_rapid and not self._clearance.is_clear(spot.line, spot.state.position):
            return "the tool may stand in a bore, where the way home leads through the wall"
        if spot.spindle_is_open:
            return "the spindle was on at the tool change; whether it still turns cannot be known"
        return ""

    def _takes_bare_line(self, spot: _Spot) -> bool:
        """LinuxCNC refuses a G1 without F, even one that moves nothing; its G94 and G95 end the last F."""
        if not self.dialect.line_needs_feed:
            return True
        state = spot.state
        feed = state.feed
        if feed is None or not feed.value > 0.0 or state.modes.feed_mode == "inverse":
            return False
        if self.interpreted.program.block(feed.line).skip:
            return False
        modes = (s for s in self.interpreted.effects if codes_of(s.block, "feed_mode", self.dialect))
        return not any(feed.line < effect.block.line < spot.line for effect in modes)

    def _offset_words(self, line: int) -> str | None:
        """``G43 H2`` as last given before a line; None where it is not that simple."""
        number: str | None = None
        for effect in reversed(self.interpreted.effects):
            block = effect.block
            if block.line >= line:
                continue
            if "home" in effect.non_modal and "Z" in homed_axes(effect, self.interpreted.settings):
                return None  # some controls have dropped it there, some have not
            if effect.non_modal:  # H of a macro call is an argument
                continue
            h = block.word("H")
            number = number or (h.value_text if h and h.number is not None and not block.has_macro else None)
            if h and number is None:
                return None
            codes = codes_of(block, "length_offset", self.dialect)
            if codes and self.dialect.g_codes[codes[-1]].value != "off":
                is_plain = codes[-1] in (430, 440)
                return f"G{codes[-1] // 10} H{number}" if is_plain and number else None
        return None


def _compensates(state: State) -> bool:
    return state.modes.compensation != "off"


def retract_blocks(settings: Settings) -> Iterable[str]:
    """The dialect's retract in the letters of the profile's axes."""
    dialect = settings.dialect
    # Where an axis has no such word, the profile does not get as far as a check.
    texts = (settings.axis_words.renamed(t, dialect.incremental) for t in dialect.machine_retract)
    return filter(None, texts)


def retract_steps(settings: Settings) -> Iterable[BlockEffect]:
    """What the dialect's retract does, block by block."""
    interpreter = Interpreter(settings, Flow(frozenset(), ()))
    state = State(modes=settings.dialect.initial)
    for text in retract_blocks(settings):
        effect = interpreter.advance(state, read_block(0, text, settings.dialect))
        state = effect.after
        yield effect
