"""Variables that a program shares with the macros behind the built-in calls.

A macro that works in #105 leaves its limit there, and ``X#105`` after the check goes to that place.  So a
program that names one of their variables anywhere gets no check that calls them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from chipbreak.checks.ways_out import OR_MOVE_THE_STORE, USE_OTHER_VARIABLES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import Program
from chipbreak.syntax.variables import variables_of
from chipbreak.text.frozen_table import FrozenTable

# What the macros work in beside the store; on LinuxCNC they have names of their own.
WORKING: Final[Mapping[str, range]] = FrozenTable({"fanuc-mill": range(100, 151)})
_PREFIX: Final = "_cb_"


class Clash(NamedTuple):
    """The line that names such a variable, what is wrong with it, and the way out."""

    line: int
    message: str
    help: str


def clash_of(program: Program, settings: Settings) -> Clash | None:
    """The first variable of a program that the macros of its calls need, None where there is none."""
    if settings.checks.calls != "builtin" or "builtin" in settings.call_sets:
        return None
    working = WORKING.get(settings.dialect.name, range(0))
    store = range(settings.macros.store_first, settings.macros.store_last + 1)
    for line, key in _named(program):
        if _is_needed(key, working, store):
            return _clash(line, key, working, store)
    return None


def _is_needed(key: int | str | None, working: range, store: range) -> bool:
    """True for a variable of the macros; one by a number worked out may be any of them."""
    if isinstance(key, str):
        return key.startswith(_PREFIX)
    return key is None or key in working or key in store


def _clash(line: int, key: int | str | None, working: range, store: range) -> Clash:
    needs = " and ".join(f"#{one[0]} to #{one[-1]}" for one in (working, store) if one)
    way_out = USE_OTHER_VARIABLES
    if isinstance(key, str):
        what = f"#<{key}>"
        needs = f"those that begin with {_PREFIX}"
    elif key is None:
        what = "a variable by a number worked out"
    else:
        what = f"#{key}"
        way_out += OR_MOVE_THE_STORE if key in store else ""
    message = f"left out: all checks; this program uses {what}, and the macros they call use {needs}"
    return Clash(line, message, way_out)


def _named(program: Program) -> Iterator[tuple[int, int | str | None]]:
    for block in program.event_blocks():
        for key in variables_of(block):
            yield block.line, key
