"""What the subprograms that a program calls may leave switched.

One that stands in the same file is followed: all that its blocks set counts as perhaps set, whatever its
branches do.  Of one that does not, or that calls tools itself, nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from chipbreak.checks.effects import set_by
from chipbreak.model.main_program import calls_subprogram
from chipbreak.model.steps import Step
from chipbreak.model.trace import Trace

THE_TOOL = "the tool"
_ONE_PROGRAM = 10_000  # P51234 calls O1234 five times
_Key = str | int


class Subprograms:
    """The bodies that stand in a file, by label or number."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.bodies: Mapping[_Key, list[Step]] = _bodies(trace)
        self._known: dict[_Key, frozenset[str] | None] = {}

    def changes(self, step: Step) -> frozenset[str] | None:
        """What the call in a block may set; None where nobody knows, empty where there is no call."""
        found: set[str] = set()
        for key in _called(step):
            one = self._of(key, ())
            if one is None:
                return None
            found |= one
        return frozenset(found)

    def call_tools(self, step: Step) -> bool:
        """True when a subprogram in this file, called by a block, calls tools."""
        bodies = (self._body(key) or () for key in _called(step))
        return any(THE_TOOL in set_by(inner, self.trace) for body in bodies for inner in body)

    def _body(self, key: _Key) -> list[Step] | None:
        if isinstance(key, int) and key not in self.bodies:
            key %= _ONE_PROGRAM
        return self.bodies.get(key)

    def _of(self, key: _Key, callers: tuple[_Key, ...]) -> frozenset[str] | None:
        if key not in self._known and key not in callers:
            self._known[key] = self._read(key, (*callers, key))
        return self._known.get(key)

    def _read(self, key: _Key, callers: tuple[_Key, ...]) -> frozenset[str] | None:
        body = self._body(key)
        if body is None:
            return None
        found: set[str] = set()
        for step in body:
            inner = [self._of(other, callers) for other in _called(step)]
            if step.block.opaque or None in inner:
                return None
            found |= set_by(step, self.trace).union(*(one for one in inner if one is not None))
        return None if THE_TOOL in found else frozenset(found)


def _called(step: Step) -> Iterator[_Key]:
    """The labels or numbers of what a block calls; an empty text where it has no name that can be read."""
    for control in step.block.controls:
        if control.keyword == "O-CALL":
            yield control.label.lower()
    is_macro = "macro-call" in step.once or step.after.modes.get("modal_macro") == "on"
    if is_macro or (calls_subprogram(step) and not step.block.controls):
        word = step.block.word("P")
        is_local = any(w.address == "M" and w.number == 97.0 for w in step.block.words)
        known = word is not None and word.number is not None and not is_local
        yield int(word.number) if known and word is not None and word.number is not None else ""


def _bodies(trace: Trace) -> dict[_Key, list[Step]]:
    """``o<name> sub`` to ``endsub``, and ``O1000`` to M99."""
    found: dict[_Key, list[Step]] = {}
    opened: list[Step] | None = None
    for step in trace.events:
        labels = {control.keyword: control.label.lower() for control in step.block.controls}
        number = step.block.word("O")
        if "O-SUB" in labels:
            opened = found.setdefault(labels["O-SUB"], [])
        elif number is not None and number.number is not None and not step.block.controls:
            opened = found.setdefault(int(number.number), [])
        elif "O-ENDSUB" in labels:
            opened = None
        elif opened is not None:
            opened.append(step)
        if any(w.address == "M" and w.number == 99.0 for w in step.block.words):
            opened = None
    return found
