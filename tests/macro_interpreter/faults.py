"""What goes wrong when a macro runs.  Each code has one meaning."""

from __future__ import annotations

from chipbreak.text.diagnostics import RefusalError

NO_PROGRAM = "MAC001"  # a program, or a sequence number in it, that is not there
NO_LOOP = "MAC002"  # DO without END or the other way round
ENDLESS = "MAC003"  # more blocks than the limit
TOO_DEEP = "MAC004"  # calls or loops nested deeper than the control can
VARIABLE = "MAC005"  # a variable that does not exist or cannot be written
ARITHMETIC = "MAC006"  # division by zero, root of a negative number
UNREADABLE = "MAC007"  # a block that cannot be read
UNSUPPORTED = "MAC008"  # a code that this machine does not have
ARGUMENT = "MAC009"  # a call without a program number, a letter that takes no argument
MOTION = "MAC010"  # a move that cannot be made: no feed, an offset in force that the machine does not know
TEXT = "MAC011"  # an alarm or a stop that the control does not show


def fault(code: str, message: str, help: str = "") -> RefusalError:
    """The error to raise."""
    return RefusalError(code, message, help)


class Alarm(Exception):  # noqa: N818 (what controls call it)
    """``#3000=number(TEXT)``: the control stops."""

    def __init__(self, number: int, text: str) -> None:
        super().__init__(f"{number} {text}")
        self.number, self.text = number, text


class ProgramEnd(Exception):  # noqa: N818 (not an error)
    """M2 or M30."""
