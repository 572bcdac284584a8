"""Whether something can be inserted before one line: rules, each about one thing in the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from functools import cached_property

from chipbreak.dialects.modes import Group
from chipbreak.insertion.candidates import Candidate
from chipbreak.insertion.clearance import Clearance
from chipbreak.insertion.length_offset import offset_words
from chipbreak.insertion.looking_back import effects_before
from chipbreak.insertion.obstacles import Obstacles
from chipbreak.insertion.overwritten import coolant_is_overwritten, feed_is_said, spindle_is_overwritten
from chipbreak.insertion.position_dependencies import (
    PositionDependencies,
    QuietRuns,
    position_dependencies,
    relies_on_speed,
)
from chipbreak.insertion.retract import Retract
from chipbreak.insertion.ways_out import (
    MOVE_WITH_G40,
    RAISE_IT,
    SAY_THE_FEED,
    SAY_THE_MODES,
    START_THE_SPINDLE,
    Obstacle,
)
from chipbreak.model.giving_back import feed_text
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.text.record import Record


class Surroundings(Record):
    """What is the same for all candidates of a program.

    ``clearance``  None for mills: their way home is up
    ``calls_end_offset``  the calls may end the length offset, as some makers' cycles do
    ``calls_in_line``  the blocks are the check itself, and set F, modes and the work offset
    ``quiet_runs``  the runs of blocks that other candidates have looked at in vain
    """

    interpreted: InterpretedProgram
    obstacles: Obstacles
    retract: Retract
    clearance: Clearance | None
    calls_end_offset: bool
    calls_in_line: bool = False
    quiet_runs: QuietRuns = field(default_factory=dict)


class Case:
    """A candidate, and what the blocks after it need; each is found out when a rule asks for it.

    ``comes_back``: what is called goes back to X and Y by itself, also where the program does not know them.
    """

    def __init__(self, surroundings: Surroundings, candidate: Candidate, *, comes_back: bool = False) -> None:
        self.comes_back = comes_back
        self.surroundings = surroundings
        self.candidate = candidate
        self.interpreted = surroundings.interpreted
        self.dialect = surroundings.interpreted.settings.dialect
        self.line = candidate.line
        self.state = candidate.state

    @cached_property
    def has_offset(self) -> bool:
        """A length offset is in force that the check would end."""
        if self.state.modes.length_offset == "off":
            return False
        retract_ends_it = self.surroundings.retract.is_home and not self.candidate.z_is_home
        return self.surroundings.calls_end_offset or retract_ends_it

    @property
    def spindle_is_unsure(self) -> bool:
        """M3 was active at a tool change; some machines stop the spindle there, some do not."""
        return self.surroundings.obstacles.spindle_is_unsure(self.line)

    @cached_property
    def dependencies(self) -> PositionDependencies:
        """What the next blocks rely on."""
        return position_dependencies(
            self.interpreted,
            self.line,
            self.candidate.homed,
            self.surroundings.quiet_runs,
            has_offset=self.has_offset,
            home_ends_offset=not self.surroundings.calls_end_offset,
        )

    @cached_property
    def axes(self) -> frozenset[str]:
        """The axes that have to be put back."""
        axes = self.dependencies.axes
        if "Z" in axes or self.dependencies.length_offset:
            # The way down to Z starts where X and Y were, and ends at a height that counts from the offset.
            axes = axes | frozenset("XZ" if self.dialect.is_lathe else "XYZ")
        return axes - self.unknown("XY") if self.comes_back else axes

    def unknown(self, axes: str) -> frozenset[str]:
        """Those of some axes whose place the program does not know."""
        position = self.state.position._asdict()
        return frozenset(axis for axis in axes if math.isnan(position[axis.lower()]))

    @cached_property
    def offset_words(self) -> str | None:
        """What brings the length offset back, "" where it stays in force, None where it is not known."""
        return offset_words(self.interpreted, self.line) if self.has_offset and "Z" in self.axes else ""

    @cached_property
    def restarts(self) -> bool:
        """The spindle turns, and what comes next counts on it."""
        return self.state.turns and not spindle_is_overwritten(self.interpreted, self.line)

    @cached_property
    def needs_speed(self) -> bool:
        """The spindle must turn again, or is started with the S that is in force here."""
        return self.restarts or relies_on_speed(self.interpreted, self.line)

    @cached_property
    def coolant(self) -> frozenset[str]:
        """The coolant that must flow again."""
        is_overwritten = bool(self.state.coolant) and coolant_is_overwritten(self.interpreted, self.line)
        return frozenset() if is_overwritten else self.state.coolant


# --- what is wrong with a candidate itself -----------------------------------------------------------
def _obstacle(case: Case) -> Obstacle | None:
    return case.surroundings.obstacles.at(case.line, case.state)


def _cycle_is_on(case: Case) -> Obstacle | None:
    is_known = case.state.modes.motion in ("rapid", "none", "line", "cw", "ccw")
    return None if is_known else Obstacle("a cycle is still on")


def _call_moved_last(case: Case) -> Obstacle | None:
    if case.candidate.mover == "call":
        return Obstacle("a subprogram or a macro was called last, and there is no rapid after it")
    return None


def _cut_was_last(case: Case) -> Obstacle | None:
    if case.candidate.mover == "cut":
        return Obstacle("the last move was a cut, not a rapid")
    return None


def _motion_is_a_cut(case: Case) -> Obstacle | None:
    motion = case.state.modes.motion
    if motion in ("cw", "ccw") or (motion == "line" and case.candidate.mover != "home"):
        return Obstacle("the motion mode is a cut, not a rapid")
    return None


def _tool_is_low(case: Case) -> Obstacle | None:
    """Whether the way up is free is known where the program itself goes up: not under an undercut."""
    if case.candidate.is_low and not case.dialect.is_lathe:
        return Obstacle("the tool has not been raised since its last cut", RAISE_IT)
    return None


def _orientation_is_lost(case: Case) -> Obstacle | None:
    """A check turns the spindle, and what comes next may count on where M19 has turned it."""
    is_lost = case.surroundings.obstacles.is_oriented(case.line)
    if is_lost and not spindle_is_overwritten(case.interpreted, case.line):
        return Obstacle("the spindle is oriented (M19), and the check would turn it", START_THE_SPINDLE)
    return None


def _line_has_no_feed(case: Case) -> Obstacle | None:
    if case.state.modes.motion == "line" and not _takes_bare_line(case):
        return Obstacle("G1 would have to be given back, and no F is in force for it")
    return None


def _takes_bare_line(case: Case) -> bool:
    """LinuxCNC refuses a G1 without F, even one that moves nothing; its G94 and G95 end the last F."""
    if not case.dialect.line_needs_feed:
        return True
    feed = case.state.feed
    if feed is None or not feed.value > 0.0 or case.state.modes.feed_mode == "inverse":
        return False
    if case.interpreted.program.block(feed.line).is_optional:
        return False
    for effect in effects_before(case.interpreted, case.line):
        if effect.block.line <= feed.line:
            break
        if codes_of(effect.block, "feed_mode", case.dialect):
            return False
    return True


def _may_be_in_a_bore(case: Case) -> Obstacle | None:
    clearance = case.surroundings.clearance
    if clearance is None or case.candidate.mover != "rapid":
        return None
    if clearance.is_clear(case.line, case.state.position):
        return None
    return Obstacle("the tool may be in a bore, where the way home leads through the wall")


def _spindle_is_unsure(case: Case) -> Obstacle | None:
    if case.spindle_is_unsure:
        return Obstacle("the spindle was on at the tool change; whether it still turns cannot be known")
    return None


# --- what the next blocks need, and cannot be put back -----------------------------------------------
def _home_has_ended_the_offset(case: Case) -> Obstacle | None:
    if case.dependencies.length_offset and case.candidate.z_is_home:
        why = "the next blocks rely on a length offset, which a reference return or the calls may end"
        return Obstacle(why)
    return None


def _place_is_not_known(case: Case) -> Obstacle | None:
    lost = case.axes & case.unknown("XYZ")
    if not lost:
        return None
    why = f"the next blocks rely on where {min(lost)} is, which is not known: {case.state.unknown_why}"
    return Obstacle(why)


def _place_is_conditional(case: Case) -> Obstacle | None:
    why = case.surroundings.obstacles.why_place_is_conditional(case.line, case.axes)
    return Obstacle(f"the next blocks rely on where the tool is, and {why}") if why else None


def _place_is_displaced(case: Case) -> Obstacle | None:
    if not case.candidate.is_displaced or case.dialect.is_lathe or not case.axes & set("XY"):
        return None
    why = "the next blocks rely on where X and Y are, and G40 has ended compensation without a move"
    return Obstacle(why, MOVE_WITH_G40)


def _height_is_shifted(case: Case) -> Obstacle | None:
    if "Z" in case.axes and case.candidate.z_is_shifted:
        return Obstacle("the next blocks rely on where Z is, and the length offset changed since it moved")
    return None


def _offset_is_not_known(case: Case) -> Obstacle | None:
    if case.offset_words is None:
        return Obstacle("the length offset must be put back, and which G43 H is in force cannot be known")
    return None


def _speed_is_not_known(case: Case) -> Obstacle | None:
    speed = case.state.speed
    if case.needs_speed and (speed is None or not speed.value > 0.0):
        return Obstacle("the spindle speed must be put back, and S cannot be known")
    return None


def _mode_cannot_be_given_back(case: Case) -> Obstacle | None:
    """What a check does that is written out in the program, and what no code of the program undoes."""
    if not case.surroundings.calls_in_line:
        return None
    said = {
        group
        for effect in effects_before(case.interpreted, case.line)
        for group in _NEEDED.values()
        if codes_of(effect.block, group, case.dialect) and not effect.block.is_optional
    }
    unsaid = [name for name, group in _NEEDED.items() if group not in said]
    if unsaid:
        why = f"the check counts on the {unsaid[0]}, and the program has not said it yet"
        return Obstacle(why, SAY_THE_MODES)
    if case.state.modes.feed_mode != "minute":
        return Obstacle("F is not per minute here, as that of the check is")
    return None


def _feed_cannot_be_given_back(case: Case) -> Obstacle | None:
    if not case.surroundings.calls_in_line or feed_text(case.state):
        return None
    if feed_is_said(case.interpreted, case.line):
        return None
    return Obstacle("the F of the check would stay in force, for the next cut says none", SAY_THE_FEED)


# How a program says each of these: G54, G90, G21.
_NEEDED: Mapping[str, Group] = {"work offset": "work_offset", "distance mode": "distance", "units": "units"}

# In the order in which a user would look; the first that says something is the reason.  These hold wherever
# the tool is taken to the safe end of its travel and back.
RULES: tuple[Callable[[Case], Obstacle | None], ...] = (
    _obstacle,
    _cycle_is_on,
    _call_moved_last,
    _cut_was_last,
    _motion_is_a_cut,
    _line_has_no_feed,
    _may_be_in_a_bore,
    _spindle_is_unsure,
    _home_has_ended_the_offset,
    _place_is_not_known,
    _place_is_conditional,
    _place_is_displaced,
    _height_is_shifted,
    _offset_is_not_known,
    _speed_is_not_known,
    _mode_cannot_be_given_back,
    _feed_cannot_be_given_back,
)
# These hold where it goes there in the middle of the program, with a check on its way.
INSERTION_RULES = (*RULES, _tool_is_low, _orientation_is_lost)
