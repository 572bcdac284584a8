"""Files of tools: where they are, and their bytes.  Readers are loaded when there is a file to read."""

from __future__ import annotations

import errno
from collections.abc import Sequence
from pathlib import Path

from chipbreak.settings.checking import BACKSLASH
from chipbreak.settings.sections import Settings
from chipbreak.text.bounds import read_bounded
from chipbreak.tools.data import CANNOT_OPEN, MOST_BYTES, Errors, ToolData
from chipbreak.tools.reader import Unit
from chipbreak.tools.ways_out import IS_IT_THE_RIGHT_FILE
from chipbreak.units import mm_per_unit


def files_of(settings: Settings) -> tuple[str, ...]:
    """The files of ``[tools]``; a profile's relative path starts at the profile's own folder."""
    names = settings.tools.files
    is_option = settings.origin("tools.files").startswith("--")
    if is_option or not settings.name.endswith(".toml"):
        return names
    folder = Path(settings.name).parent
    return tuple(str(folder / name) for name in names)


def table_unit(settings: Settings, of_program: tuple[float, str]) -> Unit:
    """mm per unit of a LinuxCNC tool table, and what says so."""
    unit = settings.tools.table_unit
    if unit == "program":
        return Unit(*of_program)
    return Unit(mm_per_unit(is_inch=unit == "inch"), f"{unit}, {settings.origin('tools.table_unit')}")


def read_files(names: Sequence[str], unit: tuple[float, str]) -> list[list[ToolData]]:
    """The tools of every file; ``unit`` is that of LinuxCNC tool tables.

    Raises ToolFileError.
    """
    return [read_tools(name, read_bytes(name), unit) for name in names]


def read_bytes(name: str) -> bytes:
    """All bytes of a file.  Raises ToolFileError when it cannot be read or is too large for a list."""
    errors = Errors(name)
    try:
        return read_bounded(Path(name), MOST_BYTES)
    except (OSError, ValueError) as error:  # a NUL in a name is a ValueError
        if isinstance(error, OSError) and error.errno == errno.EFBIG:
            errors.stop(CANNOT_OPEN, "this file is larger than any list of tools", IS_IT_THE_RIGHT_FILE)
        why = error.strerror if isinstance(error, OSError) else str(error)
        # "C:\tools" in TOML is C:, a tab and ools.
        way_out = "check the path" if name.isprintable() else BACKSLASH
        errors.stop(CANNOT_OPEN, f"this file cannot be read: {why}", way_out)


def read_tools(name: str, data: bytes, unit: tuple[float, str] = (1.0, "mm")) -> list[ToolData]:
    """The tools of one file, by the end of its name.  Raises ToolFileError."""
    from chipbreak.tools.readers import read_with

    return read_with(name, data, Unit(*unit))
