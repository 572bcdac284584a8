"""Programs that must be refused: one file, one error, at its place, with a way out.

The first line of a file says what is expected: ``(EXPECT VIB050 4:1)``, with ``-p PROFILE`` and
``section.key=value`` behind it where the generic lathe does not do.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chipbreak

FOLDER = Path(__file__).parent / "bad"
FILES = sorted(FOLDER.glob("*.nc"))
_EXPECT = re.compile(r"\(EXPECT ([A-Z]{3}[0-9]{3}) ([0-9]+):([0-9]+) ?([^()]*)\)")
_CODE = re.compile(r"[\"']([A-Z]{3}[0-9]{3})[\"']")

# Codes that no input can reach through the whole way, with the reason.
UNREACHABLE = {
    "VIB010": "ramps, shares and feeds: VIB017, VIB050 and the profile's own limits come first",
    "VIB012": "a whole N is refused by the solver (VIB005) before its stroke is asked for",
    "VIB020": "the knots of a planned cut always rise in time",
    "SLF002": "an internal fault or too little memory",
}


def expectation(text: str) -> tuple[str, int, int, str, list[str]]:
    """Code, line, column, profile and settings of the first line."""
    match = _EXPECT.match(text)
    assert match is not None, "the first line says what is expected"
    flags = match[4].split()
    profile = "generic-lathe"
    if flags[:1] == ["-p"]:
        profile, flags = flags[1], flags[2:]
    return match[1], int(match[2]), int(match[3]), profile, flags


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_bad_program(file: Path) -> None:
    data = file.read_bytes()
    code, line, column, profile, sets = expectation(data.decode("latin-1"))
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(data, chipbreak.load(profile, sets), file.name)
    (error,) = [d for d in caught.value.diagnostics if d.severity.value == "error"]
    assert error.place is not None
    assert (error.code, error.place.line, error.place.column) == (code, line, column)
    assert error.place.file == file.name
    assert error.help
    assert f"help: {error.help}" in error.render()


def test_every_code_is_reached() -> None:
    """By a bad program, or by a test that names the code."""
    checkout = Path(__file__).parents[1]
    sources = {c for f in (checkout / "src").rglob("*.py") for c in _CODE.findall(f.read_text("utf-8"))}
    by_file = {expectation(f.read_bytes().decode("latin-1"))[0] for f in FILES}
    tests = [f for f in (checkout / "tests").rglob("*.py") if f != Path(__file__)]
    tests += (checkout / "tests" / "cli").glob("*/stderr")
    by_test = {c for f in tests for c in re.findall(r"\b[A-Z]{3}[0-9]{3}\b", f.read_text("utf-8"))}
    assert {"VIB001", "SYN001", "SET001"} <= sources
    assert not sources - by_file - by_test - set(UNREACHABLE), "a code that nothing reaches"
    assert not by_file - sources, "a file expects a code that is no longer there"
    assert not set(UNREACHABLE) & by_file, "it can be reached after all"
