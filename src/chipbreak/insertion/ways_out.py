"""What the user can do where nothing may be inserted: the one home of these texts."""

from __future__ import annotations

from typing import Final

from chipbreak.text.named_tuple import NamedTuple

MAKE_A_PLACE: Final = "make a place for it: G0 to a known position, G40, G80, the spindle with S"
CALL_THE_TOOL_AGAIN: Final = "call the tool again after it: from there on all is known"
SAY_THE_MODES: Final = "say G54, G90 and G21 (or what you use of them) at the start of the program"
SAY_THE_FEED: Final = "say F in the first cut after it"
RAISE_IT: Final = "raise Z behind the cut, in rapid: G0 Z15."
START_THE_SPINDLE: Final = (
    "start the spindle again with S and M3 or M4, or say M19 behind the place for the check"
)
MOVE_WITH_G40: Final = "move X or Y in the block of G40 or after it, in rapid"

ONE_PATH_A_FILE: Final = "write each path into a file of its own, without marks, and filter these"


class Obstacle(NamedTuple):
    """Why nothing may be inserted before a line, and what would help."""

    why: str
    way_out: str = MAKE_A_PLACE
