"""What is known about a tool, field by field, and where each field came from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final, NoReturn

from chipbreak.text.diagnostics import ChipbreakError, Diagnostic, Severity
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.span import Place

CANNOT_OPEN = "TOL001"
NO_FORMAT = "TOL002"
UNKNOWN_KEY = "TOL003"
BAD_VALUE = "TOL004"
NO_NUMBER = "TOL005"
NO_UNIT = "TOL006"
TOO_MANY = "TOL007"
BROKEN_READER = "TOL011"
# After twenty errors a reader starts over with another file.
MOST_ERRORS = 20
MOST_BYTES = 64 * 1024 * 1024  # of one file of tools, packed or not

FIELDS: Final = (
    "type",
    "teeth",
    "diameter_mm",
    "length_mm",
    "corner_radius_mm",
    "helix_deg",
    "point_deg",
    "holder_mm",
    "nose_tip",
    "name",
)


class ToolData(NamedTuple):
    """One tool; ``None`` is what nobody said.

    ``type``       in the words of Fusion's library: "flat end mill", "ball end mill", "drill", …
    ``length_mm``  from the lower end of the holder to the tip
    ``corner_radius_mm``  of the corner between end and side; half the diameter of a ball end mill; of a
                   turning tool that of its nose
    ``helix_deg``  angle between an edge and the axis; positive for a right-hand helix
    ``point_deg``  full angle of a drill's or chamfer mill's point
    ``holder_mm``  from the nose of the spindle to the lower end of the holder
    ``nose_tip``   of a turning tool: the tip number (T on the offset screen) as its control counts
    ``origins``    field -> what said it, for messages
    """

    number: int
    type: str | None = None
    teeth: int | None = None
    diameter_mm: float | None = None
    length_mm: float | None = None
    corner_radius_mm: float | None = None
    helix_deg: float | None = None
    point_deg: float | None = None
    holder_mm: float | None = None
    nose_tip: int | None = None
    name: str | None = None
    origins: Mapping[str, str] = FrozenTable({})

    @classmethod
    def said(cls, number: int, origin: str, values: Mapping[str, Any]) -> ToolData:
        """What one place says about a tool; values that are None are not said."""
        known = {name: value for name, value in values.items() if value is not None}
        return cls(number, **known, origins=dict.fromkeys(known, origin))

    def known(self) -> dict[str, Any]:
        """The fields that somebody gave, in the order of ``FIELDS``."""
        values = ((name, getattr(self, name)) for name in FIELDS)
        return {name: value for name, value in values if value is not None}


class ToolFileError(ChipbreakError):
    """A file of tools, or of traces, that cannot be used; ``diagnostics`` says why and where."""

    __module__ = "chipbreak"

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return "; ".join(d.message for d in self.diagnostics)


class Errors:
    """Collects what is wrong with one file, so that all of it is said at once."""

    def __init__(self, name: str, text: str = "") -> None:
        self.name = name
        self.lines = text.split("\n")
        self.found: list[Diagnostic] = []

    def add(
        self, code: str, message: str, help_text: str, line: int = 0, span: tuple[int, int] = (0, 1)
    ) -> None:
        """One error; ``line`` counts from 1 (0: the whole file), ``span`` its characters from 0."""
        place = None
        shown = ""
        if line:
            place = Place(self.name, line, span[0] + 1, max(span[1], span[0] + 1) + 1)
            shown = self.lines[line - 1].rstrip("\r") if line <= len(self.lines) else ""
        else:
            message = f"{self.name}: {message}"
        self.found.append(Diagnostic(code, Severity.ERROR, message, help_text, place, shown))
        if len(self.found) == MOST_ERRORS:
            more = f"{self.name}: these are {MOST_ERRORS} errors; the rest was not read"
            self.found.append(Diagnostic(TOO_MANY, Severity.ERROR, more, "is it the file you meant?"))
            raise ToolFileError(self.found)

    def stop(
        self, code: str, message: str, help_text: str, line: int = 0, span: tuple[int, int] = (0, 1)
    ) -> NoReturn:
        """An error after which nothing can be read."""
        self.add(code, message, help_text, line, span)
        raise ToolFileError(self.found)

    def raise_if_any(self) -> None:
        """Raises ToolFileError when anything was wrong."""
        if self.found:
            raise ToolFileError(self.found)
