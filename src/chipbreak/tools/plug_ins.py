"""Readers of tool files that other installed packages bring.

A package names its reader, a :class:`ToolReader`, by an entry point in its ``pyproject.toml``::

    [project.entry-points."chipbreak.tool_readers"]
    presetter = "shop_presetter:READER"
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from typing import Final

from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.data import BROKEN_READER, ToolData, ToolFileError
from chipbreak.tools.reader import ToolReader, Unit

GROUP: Final = "chipbreak.tool_readers"


class PlugIn(NamedTuple):
    """A reader of another package; whatever it does wrong is said under its name."""

    entry: EntryPoint
    reader: ToolReader

    def takes(self, data: bytes, name: str) -> bool:
        """As of a reader.  Raises ToolFileError for a fault of the plug-in."""
        with _blamed(self.entry, name):
            return self.reader.takes(data, name)

    def read(self, data: bytes, name: str, unit: Unit) -> list[ToolData]:
        """As of a reader.  Raises ToolFileError for the file, and for a fault of the plug-in."""
        with _blamed(self.entry, name):
            tools = list(self.reader.read(data, name, unit))
            if not all(isinstance(tool, ToolData) for tool in tools):
                raise TypeError("it gave something else than ToolData")
            return tools


def plug_ins(name: str) -> tuple[list[PlugIn], list[Diagnostic]]:
    """The readers that are installed, and why others of them cannot be used; ``name`` is the file to read."""
    found = list[PlugIn]()
    broken = list[Diagnostic]()
    for entry in sorted(entry_points(group=GROUP)):
        try:
            with _blamed(entry, name):
                found.append(_loaded(entry))
        except ToolFileError as error:
            broken += error.diagnostics
    return found, broken


def _loaded(entry: EntryPoint) -> PlugIn:
    reader = entry.load()
    if not isinstance(reader, ToolReader):
        raise TypeError(f"{entry.value} is no ToolReader")
    return PlugIn(entry, reader)


@contextmanager
def _blamed(entry: EntryPoint, name: str) -> Iterator[None]:
    """Turn a fault of a plug-in into a ToolFileError; what it says of the file itself passes."""
    try:
        yield
    except ToolFileError:
        raise
    except Exception as error:
        package = f" of the package {entry.dist.name}" if entry.dist else ""
        message = f'{name}: the tool reader "{entry.name}"{package} fails: {type(error).__name__}: {error}'
        help_text = "update or remove that package, or give the tools as CSV"
        raise ToolFileError([Diagnostic(BROKEN_READER, Severity.ERROR, message, help_text)]) from error
