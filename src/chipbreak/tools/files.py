"""Files of tools: which reader reads which.  A reader is loaded when a file wants it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from chipbreak.settings.sections import Settings
from chipbreak.tools.data import CANNOT_OPEN, MOST_BYTES, NO_FORMAT, Errors, ToolData
from chipbreak.units import MM_PER_INCH

SUFFIXES: Final = (".csv", ".toml", ".json", ".tools", ".fctl", ".tbl")


def files_of(settings: Settings) -> tuple[str, ...]:
    """The files of ``[tools]``; a profile's relative path starts at the profile's own folder."""
    names = settings.tools.files
    is_option = settings.origin("tools.files").startswith("--")
    if is_option or not settings.name.endswith(".toml"):
        return names
    folder = Path(settings.name).parent
    return tuple(str(folder / name) for name in names)


def table_unit(settings: Settings, of_program: tuple[float, str]) -> tuple[float, str]:
    """mm per unit of a LinuxCNC tool table, and who says so."""
    unit = settings.tools.table_unit
    if unit == "program":
        return of_program
    return (MM_PER_INCH if unit == "inch" else 1.0), f"{unit}, {settings.origin('tools.table_unit')}"


def read_files(names: Sequence[str], unit: tuple[float, str]) -> list[list[ToolData]]:
    """The tools of every file; ``unit`` is that of LinuxCNC tool tables.

    Raises ToolFileError.
    """
    return [read_tools(name, read_bytes(name), unit) for name in names]


def read_bytes(name: str) -> bytes:
    """All bytes of a file.  Raises ToolFileError when it cannot be read or is too large for a list."""
    errors = Errors(name)
    try:
        with Path(name).open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:  # a NUL in a name is a ValueError
        why = error.strerror if isinstance(error, OSError) else str(error)
        errors.stop(CANNOT_OPEN, f"this file cannot be read: {why}", "check the path")
    if len(data) > MOST_BYTES:
        errors.stop(CANNOT_OPEN, "this file is larger than any list of tools", "is it the right file?")
    return data


def read_tools(name: str, data: bytes, unit: tuple[float, str] = (1.0, "mm")) -> list[ToolData]:
    """The tools of one file, by the end of its name.  Raises ToolFileError."""
    from chipbreak.tools.freecad import read_bit, read_library
    from chipbreak.tools.fusion import read_fusion, read_tools_zip
    from chipbreak.tools.linuxcnc import read_table
    from chipbreak.tools.lists import read_csv, read_toml

    suffix = Path(name).suffix.lower()
    if suffix == ".csv":
        return read_csv(name, data)
    if suffix == ".toml":
        return read_toml(name, data)
    if suffix == ".tbl":
        return read_table(name, data, *unit)
    if suffix == ".fctl":
        return read_library(name, data, lambda path: _bit_of(Path(name), path))
    if suffix == ".fctb":
        return read_bit(name, data)
    if suffix == ".json":
        return read_fusion(name, data)
    if suffix == ".tools":
        return read_tools_zip(name, data)
    message = f'files that end with "{suffix}" are not read' if suffix else "this file has no ending"
    return Errors(name).stop(NO_FORMAT, message, f"known: {', '.join(SUFFIXES)}")


def _bit_of(library: Path, path: str) -> bytes:
    """A bit of a FreeCAD library: beside it, or in the folder ``Bit`` beside its own."""
    places = [library.parent / path, library.parent.parent / "Bit" / path]
    for place in places:
        try:
            with place.open("rb") as file:
                return file.read(MOST_BYTES)
        except ValueError:
            break
        except OSError as error:
            if place == places[-1]:
                raise OSError(error.errno, error.strerror or "") from None
    raise FileNotFoundError(2, "no such file")
