"""Programs in tests/cases/vibrate: what goes in, and behind ``; --- output`` what must come out.

Without the divider the program must not change.  The first line may be a comment ``(CASE ...)`` with
``-p PROFILE`` and ``section.key=value``; the generic lathe is the default.  Bracket lines that keep the
original are left out of the expected output: going back is tested for every case.

``CHIPBREAK_CASES`` may name a folder of programs that are not in the checkout.  Those with a divider are
cases like these.  For the others nobody has said what comes out, so they are held against what must be so for
any program, on several controls: refused with a place, or filtered so that it goes back and a second run
changes nothing.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.restore import restore
from chipbreak.text.source import read

CASES = sorted((Path(__file__).parent / "cases" / "vibrate").glob("*.nc"))
DIVIDER = "; --- output\n"
FLAGS = "; flags:"
FOR_ANY_PROGRAM = [
    ("generic-lathe", ["vibration.n=1.5"]),
    ("fanuc-lathe", ["vibration.n=1.5"]),
    ("linuxcnc-lathe", ["planner.model=ideal", "planner.path_mode="]),
    ("fanuc-mill", []),
]


def without_brackets(text: str) -> str:
    return re.sub(r"(?m)^.*\(CHIPBREAK (?:BEGIN|WAS|HEX|END)[^()]*\)\n", "", text)


def check_case(file: Path) -> None:
    program, divider, wanted = file.read_bytes().decode("latin-1").partition(DIVIDER)
    profile, sets = "generic-lathe", []
    if program.startswith(FLAGS):
        words = shlex.split(program.splitlines()[0].removeprefix(FLAGS))
        for option, value in zip(words[::2], words[1::2], strict=True):
            assert option in ("-p", "--set")
            profile = value if option == "-p" else profile
            sets += [value] if option == "--set" else []
    settings = chipbreak.load(profile, sets)
    result = chipbreak.rewrite(program.encode("latin-1"), settings, file.name)
    out = result.data.decode("latin-1")
    if not divider:
        assert out == program
        assert not result.changed
        return
    assert without_brackets(out) == wanted
    check_laws(program.encode("latin-1"), result, settings)


def check_laws(program: bytes, result: chipbreak.Result, settings: chipbreak.Settings) -> None:
    """The way back is open, and a filtered program stays as it is."""
    assert restore(read(result.data)).data == program
    assert chipbreak.rewrite(result.data, settings).data == result.data


@pytest.mark.parametrize("file", CASES, ids=lambda file: file.stem)
def test_case(file: Path) -> None:
    check_case(file)


@pytest.mark.parametrize(("profile", "sets"), FOR_ANY_PROGRAM)
def test_own_case(own_case: Path, profile: str, sets: list[str]) -> None:
    data = own_case.read_bytes()
    if DIVIDER.encode() in data:
        check_case(own_case)
        return
    settings = chipbreak.load(profile, sets)
    try:
        result = chipbreak.rewrite(data, settings, own_case.name)
    except chipbreak.ProgramRejectedError as error:
        errors = [found for found in error.diagnostics if found.severity.value == "error"]
        assert errors
        assert all(found.place is not None and found.help for found in errors)
        assert not any(found.code.startswith("SLF") for found in errors), "a fault of the filter itself"
        return
    if result.changed:
        check_laws(data, result, settings)
    else:
        assert result.data == data
