"""Which files of the command line are meant: files as they are named, and the programs in folders."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from chipbreak.text.existence import is_folder
from chipbreak.text.named_tuple import NamedTuple

# How controls, CAM systems and editors name programs.  A file named on the command line is taken as it is.
_SUFFIXES = re.compile(
    r"\.(a?nc|ngc|ncc|nca|cnc|dnc|fnc|mpf|spf|min|eia|iso|din|tap|txt|prg|pgm|pim|mim|sub|ptp|gcode|gc|g|h|i)",
    re.IGNORECASE,
)
# A program without a suffix, as a memory card has it: O0001, O1234A.
_BARE = re.compile(r"[OoN]?\d{1,8}[A-Za-z]?")


class Input(NamedTuple):
    """A program on disk, and its name below the folder it was found in."""

    path: Path
    name: Path


def inputs_of(sources: Iterable[str], results: Path | None = None) -> list[Input]:
    """Files as they are named and the programs in folders, in the order of names; each file once.

    ``results`` is the folder into which they are filtered: what is found there in a folder around it is the
    result of an earlier run.
    """
    found: dict[Path, Input] = {}
    for source in sources:
        path = Path(source)
        inputs = _programs_in(path, results) if is_folder(path) else [Input(path, Path(path.name))]
        for one in inputs:
            found.setdefault(Path(os.path.realpath(one.path)), one)
    return list(found.values())


def _programs_in(folder: Path, results: Path | None) -> Iterator[Input]:
    left_out = None if results is None else os.path.realpath(results)
    for place, folders, files in os.walk(folder):
        others = (name for name in folders if os.path.realpath(Path(place, name)) != left_out)
        folders[:] = sorted(name for name in others if not name.startswith("."))
        for name in sorted(files):
            if is_program(name):
                path = Path(place, name)
                yield Input(path, path.relative_to(folder))


def is_program(name: str) -> bool:
    """True for a file name that programs have; hidden files are none."""
    path = Path(name)
    if name.startswith("."):
        return False
    return _SUFFIXES.fullmatch(path.suffix) is not None or (
        not path.suffix and _BARE.fullmatch(name) is not None
    )
