"""Which reader reads which file: a new kind of file is a module with its reader, and a line here."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from chipbreak.tools import freecad, fusion, linuxcnc, lists
from chipbreak.tools.data import NO_FORMAT, Errors, ToolData, ToolFileError
from chipbreak.tools.plug_ins import PlugIn, plug_ins
from chipbreak.tools.reader import ToolReader, Unit

# In the order in which messages name their suffixes; the first that takes a file reads it.
READERS: Final[tuple[ToolReader, ...]] = (
    ToolReader((".csv",), lists.read_csv),
    ToolReader((".toml",), lists.read_toml),
    ToolReader((".json",), fusion.read_fusion),
    ToolReader((".tools",), fusion.read_tools_zip),
    ToolReader((".fctl",), freecad.read_library),
    ToolReader((".tbl",), linuxcnc.read_table),
    # No suffix that a message should offer: a bit without its library has no tool number.
    ToolReader((), freecad.read_bit, lambda _data, name: name.lower().endswith(".fctb")),
)


def read_with(name: str, data: bytes, unit: Unit) -> list[ToolData]:
    """The tools of a file by the first reader that takes it; other packages are asked when none of ours does.

    Raises ToolFileError for what the reader finds wrong, for a file that no reader takes, and for a reader
    of another package that does not work.
    """
    for reader in READERS:
        if reader.takes(data, name):
            return reader.read(data, name, unit)
    others, broken = plug_ins(name)
    for other in others:
        if other.takes(data, name):
            return other.read(data, name, unit)
    if broken:  # it may be one of these that reads this file
        raise ToolFileError(broken)
    return _nobody_reads(name, others)


def _nobody_reads(name: str, others: list[PlugIn]) -> list[ToolData]:
    suffix = Path(name).suffix.lower()
    message = f'files that end with "{suffix}" are not read' if suffix else "this file has no ending"
    known = [s for reader in (*READERS, *(other.reader for other in others)) for s in reader.suffixes]
    return Errors(name).stop(NO_FORMAT, message, f"known: {', '.join(known)}")
