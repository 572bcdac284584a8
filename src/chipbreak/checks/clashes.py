"""Variables that a program shares with the macros behind the built-in calls.

A macro that works in #105 leaves its limit there, and ``X#105`` behind the check goes to that place.  So a
program that names one of their variables anywhere gets no check that calls them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

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
    needed = [f"#{one[0]} to #{one[-1]}" for one in (working, store) if one]
    for line, key in _named(program):
        is_name = isinstance(key, str)
        if is_name and not str(key).startswith(_PREFIX):
            continue
        if isinstance(key, int) and key not in working and key not in store:
            continue
        what = (
            f"#<{key}>" if is_name else f"#{key}" if key is not None else "a variable by a number worked out"
        )
        needs = f"those that begin with {_PREFIX}" if is_name else " and ".join(needed)
        message = f"left out: all checks; this program uses {what}, and the macros they call use {needs}"
        help_text = "let the program use other variables"
        if isinstance(key, int) and key in store:
            help_text += ", or the macros: macros.store_first and macros.store_last say which"
        return Clash(line, message, help_text)
    return None


def _named(program: Program) -> Iterator[tuple[int, int | str | None]]:
    for block in program.event_blocks():
        for key in variables_of(block):
            yield block.line, key
