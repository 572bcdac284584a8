"""Programs in tests/cases/vibrate: what goes in, and behind ``; --- output`` what must come out.

Without the divider the program must not change.  The first line may be a comment ``(CASE ...)`` with
``-p PROFILE`` and ``section.key=value``; the generic lathe is the default.  Bracket lines that keep the
original are left out of the expected output: going back is tested for every case.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chipbreak
from chipbreak.restore import restore
from chipbreak.source import read

CASES = sorted((Path(__file__).parent / "cases" / "vibrate").glob("*.nc"))
DIVIDER = "; --- output\n"
_FLAGS = re.compile(r"\(CASE ([^()]*)\)\n")


def without_brackets(text: str) -> str:
    return re.sub(r"(?m)^.*\(CHIPBREAK (?:BEGIN|WAS|HEX|END)[^()]*\)\n", "", text)


@pytest.mark.parametrize("file", CASES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_case(file: Path) -> None:
    program, divider, wanted = file.read_bytes().decode("latin-1").partition(DIVIDER)
    flags = _FLAGS.match(program)
    words = flags[1].split() if flags else []
    profile = "generic-lathe"
    if words[:1] == ["-p"]:
        profile, words = words[1], words[2:]
    settings = chipbreak.load(profile, words)
    result = chipbreak.rewrite(program.encode("latin-1"), settings, file.name)
    out = result.data.decode("latin-1")
    if not divider:
        assert out == program
        assert not result.changed
        return
    assert without_brackets(out) == wanted
    assert restore(read(result.data)).data.decode("latin-1") == program
    assert chipbreak.rewrite(result.data, settings).data == result.data
