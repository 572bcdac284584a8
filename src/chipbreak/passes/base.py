"""What a pass is: it looks at the interpreted program, and plans edits.

A pass sees the work of others only in its context, and there only where edits stand and what they promise.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import Promise
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.operations.operations import Operation
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import Diagnostic, RefusalError, has_errors
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.record import Record
from chipbreak.tools.merge import ToolTable
from chipbreak.vibration.left_cut import LeftCut


def _nobody_waits(_percent: int) -> None:
    """For runs that nobody looks at."""


class RunOptions(NamedTuple):
    """What the user wants of this run, whatever the machine.

    ``allow_unbroken``: cuts that do not break their chips are let pass, with a warning.  ``messages``: the
    warnings are written into the program, for the operator.  ``progress`` is told about how much is done [%];
    a run that goes back to an earlier stage says so.
    """

    allow_unbroken: bool = False
    messages: bool = False
    progress: Callable[[int], None] = _nobody_waits


_NO_OPTIONS = RunOptions()


class Context(Record):
    """All that a pass may look at.

    ``read_tools`` gives the tool table, read when it is first asked for.  ``planned`` are the edits of the
    passes before.  ``given_up`` are edits, by their first line, that were tried and are not planned again.
    ``split_operations`` are the operations with each cycle that was written out as one of its own.
    ``named_cycles`` are lines of cycles of which it is said already why they stay as they are.
    ``reasons``: why cuts, by their line, stay under nose compensation, or why corners there are not drawn.
    ``said`` is what was said of the program as it came in, and by the passes before.
    """

    interpreted: InterpretedProgram
    main: MainProgram
    operations: Sequence[Operation]
    read_tools: Callable[[], ToolTable]
    options: RunOptions = _NO_OPTIONS
    planned: tuple[Edit, ...] = ()
    given_up: Mapping[int, Diagnostic] = field(default_factory=FrozenTable)
    split_operations: Sequence[Operation] = ()
    named_cycles: frozenset[int] = frozenset()
    reasons: Mapping[int, RefusalError] = field(default_factory=FrozenTable)
    said: Sequence[Diagnostic] = ()

    @property
    def is_refused(self) -> bool:
        """True where an error was said already: no edit will be used."""
        return has_errors(self.said)

    @property
    def cut_operations(self) -> Sequence[Operation]:
        """The operations as wishes by kind see them."""
        return self.split_operations or self.operations

    @property
    def settings(self) -> Settings:
        """The machine."""
        return self.interpreted.settings

    @property
    def tools(self) -> ToolTable:
        """What is known of the tools.  Raises ToolFileError for a file of tools that cannot be used."""
        return self.read_tools()

    def lines_of(self, promise: type[Promise]) -> list[int]:
        """The lines (from 0) at which edits with such a promise stand."""
        return [edit.first for edit in self.planned if isinstance(edit.promise, promise)]


class Planned(NamedTuple):
    """What a pass wants to change, and what it found.  With an error among it, no edit is used.

    ``left`` are cuts that were asked to vibrate and stay as they are.
    """

    edits: Sequence[Edit] = ()
    diagnostics: Sequence[Diagnostic] = ()
    left: Sequence[LeftCut] = ()


class Pass(ABC):
    """One thing that is done to programs.

    ``name`` is what its edits carry, and what messages call it.
    """

    name: str

    @abstractmethod
    def plan(self, context: Context) -> Planned:
        """The edits of this pass.  Raises SettingsError for a profile that it cannot use."""

    def findings(self, context: Context, reports: Sequence[object]) -> Sequence[Diagnostic]:
        """What the reports of this pass's promises say about the output; nothing, if it does not look."""
        return ()

    def gives_up(self, context: Context, reports: Sequence[object]) -> Mapping[int, Diagnostic]:
        """Edits, by their first line, that what they do in the output speaks against, with the reason.

        All is then planned again without them.  Nothing, if the pass keeps what it planned.
        """
        return {}
