"""What the user can do where a check is left out: the one home of these texts."""

from __future__ import annotations

from typing import Final

GIVE_THE_SPEED: Final = "give S and M3 or M4 before the cut, after any block that a jump or a loop reaches"
GIVE_THE_TOOL_DATA: Final = (
    "give them in a tool file (--tools FILE); with checks.missing=error this is an error"
)
LEAVE_THE_CHECK_OUT: Final = "; checks.missing=skip leaves the check out"
CALL_WITH_ITS_NUMBER: Final = "call the tool with its number before it cuts"
KEEP_THE_SISTER: Final = "keep a sister for the tool whose place it takes"
USE_OTHER_VARIABLES: Final = "let the program use other variables"
OR_MOVE_THE_STORE: Final = ", or the macros: macros.store_first and macros.store_last say which"
OTHER_CALLS: Final = (
    "choose the cycles of that maker with checks.calls (haas, renishaw, ...), or describe calls of programs"
    " that have other numbers in [calls.NAME]"
)
RENAME_THE_PROGRAM: Final = (
    "give that program another number or name, or choose other calls with checks.calls or [calls.NAME]"
)
USE_OTHER_OFFSETS: Final = (
    "use G54 to G58 and G94, without G92, G43.1 and G10, or no checks (checks.enabled=false)"
)
SEE_ITS_TRACE: Final = "see why its TRACE was left out"
NAME_THE_BEAM: Final = (
    "give them under [macros] in the profile; or choose the cycles of a maker with checks.calls (haas,"
    " renishaw, ...); or, with no tool setter on the machine, checks.enabled=false"
)


def call_a_tool(where: str) -> str:
    """``where`` says where the program calls its tools, "" where it calls none."""
    return f"a check needs the tool's number from its call{where}"
