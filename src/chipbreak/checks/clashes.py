"""Variables that a program shares with the macros behind the built-in calls.

A macro that works in #105 leaves its limit there, and ``X#105`` after the check goes to that place.  So a
program that names one of their variables anywhere gets no check that calls them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from chipbreak.checks.ways_out import OR_MOVE_THE_STORE, USE_OTHER_VARIABLES
from chipbreak.dialects import BUILT_IN
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import Program
from chipbreak.syntax.variables import variables_of


class Clash(NamedTuple):
    """The line that names such a variable, what is wrong with it, and the way out."""

    line: int
    message: str
    help: str


class _Needs(NamedTuple):
    """Variables of the macros: those they work in, those of their store, and how their names begin."""

    working: range
    store: range
    prefix: str

    def has(self, key: int | str | None) -> bool:
        """True for a variable that is theirs, or may be: one by a number worked out."""
        if isinstance(key, str):
            return bool(self.prefix) and key.startswith(self.prefix)
        return key is None or key in self.working or key in self.store

    def shown(self, key: int | str | None) -> str:
        """The variables that such a one is among."""
        if isinstance(key, str):
            return f"those that begin with {self.prefix}"
        return " and ".join(f"#{one[0]} to #{one[-1]}" for one in (self.working, self.store) if one)


def clash_of(program: Program, settings: Settings) -> Clash | None:
    """The first variable of a program that the macros of its calls need, None where there is none."""
    macros = settings.dialect.macros
    if macros is None or settings.checks.calls != BUILT_IN or BUILT_IN in settings.call_sets:
        return None
    store = range(settings.macros.store_first, settings.macros.store_last + 1)
    needs = _Needs(macros.working, store, macros.prefix)
    for line, key in _named(program):
        if needs.has(key):
            uses = f"this program uses {_variable(key)}, and the macros they call use {needs.shown(key)}"
            way_out = USE_OTHER_VARIABLES + (OR_MOVE_THE_STORE if key in store else "")
            return Clash(line, f"left out: all checks; {uses}", way_out)
    return None


def _variable(key: int | str | None) -> str:
    if key is None:
        return "a variable by a number worked out"
    return f"#<{key}>" if isinstance(key, str) else f"#{key}"


def _named(program: Program) -> Iterator[tuple[int, int | str | None]]:
    for block in program.event_blocks():
        for key in variables_of(block):
            yield block.line, key
