"""The modal state of a control between two blocks."""

from __future__ import annotations

import math

from chipbreak.dialects.modes import Modes, Motion, Units
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import mm_per_unit

UNKNOWN = math.nan


class Position(NamedTuple):
    """Tool position in the program's coordinates [mm]; X is a radius.  NaN where it cannot be known."""

    x: float
    y: float
    z: float


NOWHERE = Position(UNKNOWN, UNKNOWN, UNKNOWN)


def one_unknown(value: float) -> float:
    """The value; NaN always as the same object, so that a state that holds it equals itself."""
    return UNKNOWN if math.isnan(value) else value


# Why nothing is known at the ends of a loop or a branch, and behind a line (the number stands before it).
LOOPED = "a loop or a branch arrives here"
UNREAD = "cannot be read"
# Why the position is not known behind a call.
CALLED = "a subprogram moves the tool"


# The tool and the next one are left open like a modal group.
TOOLS = ("tool", "next_tool")
# Modal groups that are not known for sure, and why, sorted by group.
LeftOpen = tuple[tuple[str, str], ...]


class Setting(NamedTuple):
    """A value that a word has set.

    ``value``  in the units of the state, whatever those of the program
    ``text``   the word's own text, for giving it back
    ``line``   where it stands, from 0
    ``units``  the units that were in force for its number
    """

    value: float
    text: str
    line: int
    units: Units = "mm"


class State(NamedTuple):
    """Everything that one block leaves to the next.

    ``modes``          the value of each modal group
    ``feed``           F in mm/rev, mm/min or, for inverse time, 1/min, as ``modes.feed_mode`` says
    ``speed``          S in rpm, or in m/min under constant surface speed
    ``speed_limit``    G50/G92 S, LinuxCNC's G96 D [rpm]
    ``unknown_why``    why the position, the feed or the speed cannot be known
    ``path_words``     the path mode as the program wrote it, with its P and Q; empty while it said none
    ``path_units``     the units of these P and Q
    ``smooth_words``   the same for look-ahead and smoothing (``G5.1 Q1 R3``)
    ``spindle_why``    why it is not followed what turns the spindle; empty where it is
    ``choice``         the word by which the program has chosen its spindle (P11); empty where it chooses none
    ``path``           the mark of the path that the lines are of; empty in a program without marks
    ``parked``         the states of the other paths, by mark
    ``kept``           what LinuxCNC's M70 has kept for M72
    ``motion_before_cycle`` the motion code that a G80 leaves in force where it is none itself
    ``left_open``      the groups that may have another value than ``modes`` says, each with why
    """

    modes: Modes
    position: Position = NOWHERE
    unknown_why: str = "no block has moved there yet"
    feed: Setting | None = None
    speed: Setting | None = None
    speed_limit: Setting | None = None
    spindle: str = "stop"
    coolant: frozenset[str] = frozenset()
    tool: int | None = None
    next_tool: int | None = None
    ended: bool = False
    path_words: str = ""
    path_units: Units = "mm"
    smooth_words: str = ""
    kept: State | None = None
    spindle_why: str = ""
    choice: str = ""
    path: str = ""
    parked: tuple[tuple[str, State], ...] = ()
    motion_before_cycle: Motion = "rapid"
    left_open: LeftOpen = ()

    def with_motion(self, motion: Motion) -> State:
        """The same under a motion code that the program says."""
        state = self.said("motion") if self.left_open else self
        if motion == state.modes.motion:
            return state
        return state._replace(modes=state.modes._replace(motion=motion))

    def said(self, *groups: str) -> State:
        """The same where the program says codes of groups: these are not left open any more."""
        return self._replace(left_open=tuple([one for one in self.left_open if one[0] not in groups]))

    def lost(self, why: str) -> State:
        """The same with the position unknown."""
        return self._replace(position=NOWHERE, unknown_why=why)

    def forgotten(self, why: str) -> State:
        """The same with position, feed and speed unknown: the block can be reached from elsewhere."""
        return self._replace(position=NOWHERE, unknown_why=why, feed=None, speed=None)

    @property
    def is_inch(self) -> bool:
        """True while the program is in inches."""
        return self.modes.units == "inch"

    @property
    def mm_per_unit(self) -> float:
        """Millimetres in the program's unit of length."""
        return mm_per_unit(is_inch=self.modes.units == "inch")

    @property
    def turns(self) -> bool:
        """True while the spindle turns."""
        return self.spindle != "stop"
