"""What a reader of tool files is: one object for each kind of file."""

from __future__ import annotations

from collections.abc import Callable

from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.record import ValueRecord
from chipbreak.tools.data import ToolData


class Unit(NamedTuple):
    """The unit of lengths in a file that does not name its own: how many mm it has, and what says so."""

    mm: float
    origin: str


def _by_suffix_alone(_data: bytes, _name: str) -> bool:
    return False


class ToolReader(ValueRecord):
    """Reads one kind of tool file.

    ``suffixes``    ends of its files' names, in lower case and with their point; messages list them
    ``read``        bytes, name of the file and unit -> its tools; lengths in mm, angles in degrees, every
                    field with its origin.  Raises ToolFileError, which says what is wrong on which line
    ``recognises``  bytes and name -> whether they are of this kind, where no suffix tells
    """

    suffixes: tuple[str, ...]
    read: Callable[[bytes, str, Unit], list[ToolData]]
    recognises: Callable[[bytes, str], bool] = _by_suffix_alone

    def takes(self, data: bytes, name: str) -> bool:
        """True when this reader reads such a file."""
        return name.lower().endswith(self.suffixes) or self.recognises(data, name)
