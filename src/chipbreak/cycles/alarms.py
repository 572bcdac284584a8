"""What a Fanuc stops with where a cycle or its contour has a fault: the numbers of its own list of alarms.

Only where the text of its alarm is the fault that is refused here; other makers have other numbers.
"""

from __future__ import annotations

NO_SUCH_BLOCK = "PS0063"
NO_DEPTH = "PS0062"
NO_TIMES = "PS0321"
TURNS_BACK = {"Z": "PS0064", "X": "PS0329"}
FIRST_IS_NO_LINE = "PS0065"
FOREIGN_COMMAND = "PS0325"
OPEN_CORNER = "PS0069"
NO_FEED_BEHIND_CORNER = "PS0052"


def with_alarm(help_text: str, alarm: str) -> str:
    """The way out, with the alarm by which an operator knows the fault."""
    return f"{help_text} (a Fanuc stops here with alarm {alarm})"
