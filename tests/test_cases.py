"""Programs in tests/cases/vibrate: what goes in, and behind ``; --- output`` what must come out.

Without the divider the program must not change.  The first line may be a comment ``(CASE ...)`` with
``-p PROFILE`` and ``section.key=value``; the generic lathe is the default.  Bracket lines that keep the
original are left out of the expected output: going back is tested for every case.
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


def without_brackets(text: str) -> str:
    return re.sub(r"(?m)^.*\(CHIPBREAK (?:BEGIN|WAS|HEX|END)[^()]*\)\n", "", text)


@pytest.mark.parametrize("file", CASES, ids=lambda file: file.stem)
def test_case(file: Path) -> None:
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
    assert restore(read(result.data)).data.decode("latin-1") == program
    assert chipbreak.rewrite(result.data, settings).data == result.data
