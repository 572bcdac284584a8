"""The hook files with the paths of this machine in them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from chipbreak.text.named_tuple import NamedTuple

_HOME = "files"


class Hook(NamedTuple):
    """Files for one kind of caller: its name, and what it is for."""

    name: str
    title: str


HOOKS = (
    Hook("linuxcnc", "LinuxCNC runs the filter when a program is opened"),
    Hook("freecad", "a FreeCAD post-processor that filters what another one writes"),
    Hook("cam", "Fusion, Mastercam and other CAM systems call a script behind posting"),
    Hook("git", "git compares programs by what their blocks say"),
    Hook("editors", "Visual Studio Code, Notepad++, CIMCO Edit and others"),
)


def hook_files(name: str, *, program: str, profile: str, folder: str) -> dict[str, tuple[bytes, bool]]:
    """The files of a hook by name: their bytes, and whether they are to be run.

    ``program`` is the path of this program, ``profile`` the one to filter with, ``folder`` where the files
    will be.
    """
    places: Mapping[str, str] = {
        "@CHIPBREAK@": program,
        "@CHIPBREAK_JSON@": json.dumps(program)[1:-1],
        "@PROFILE@": profile,
        "@FOLDER@": folder,
        "@FOLDER_BACK@": folder.replace("\\", "\\\\"),
    }
    found = {}
    for file in _files_of(name):
        text = file.read_text("utf-8")
        for mark, value in places.items():
            text = text.replace(mark, value)
        if Path(file.name).suffix == ".bat":
            text = text.replace("\n", "\r\n")
        # Python that FreeCAD runs is no module of this package.
        found[file.name.removesuffix(".in")] = (text.encode("utf-8"), text.startswith("#!"))
    return found


def _files_of(name: str) -> list[Traversable]:
    folder = files(__package__) / _HOME / name
    return sorted((one for one in folder.iterdir() if one.is_file()), key=lambda one: one.name)
