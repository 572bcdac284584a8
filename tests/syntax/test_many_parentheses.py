"""Comments in comments by the thousand, in one line: each is looked at once."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.settings import load

MANY = "(" * 40_000


@pytest.mark.parametrize("profile", ["klipper", "grbl", "fanuc-lathe", "linuxcnc-lathe"])
@pytest.mark.parametrize("line", [MANY, f"{MANY}x)", f"{MANY}x) G1 X2", "(a" * 20_000])
def test_what_is_not_closed_is_said_with_its_place(profile: str, line: str) -> None:
    try:
        said = chipbreak.rewrite(f"G21\nG0 X1.\n{line}\n".encode(), load(profile)).diagnostics
    except chipbreak.ProgramRejectedError as rejected:
        said = rejected.diagnostics
    ends_alike = line.endswith("x)") and profile in (
        "grbl",
        "fanuc-lathe",
    )  # at its first ), and nothing behind
    assert bool([one for one in said if one.place is not None and one.place.line == 3]) is not ends_alike
