"""What must hold of an edit in the bytes that were written, whichever pass made it.

A pass gives every edit a promise; when the output is read again, each promise is looked after.  Part of every
promise is that the edit leaves no trace: before and behind it the control is in the state of the original and
the tool in its place, or on a way on which the program itself takes it to the next cut.  A class here, or in
the room that makes the edit, says what must hold beyond that::

    class Turns(Promise, kw_only=True):
        speed_rpm: float

        def check(self, written: Written) -> None: ...
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from chipbreak.editing.restore import Region
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.paths import begins_program
from chipbreak.model.state_difference import spindle_speed
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.record import Record

if TYPE_CHECKING:
    from chipbreak.editing.edits import Edit


class Written(Record):
    """An edit, and what stands for it in the output.

    ``original`` and ``result`` are the program before and after all edits, loops written out.  ``region`` is
    the place of the edit in ``result``; ``stop`` the line of ``original`` at which the next edit begins, or
    the program ends.
    """

    edit: Edit
    region: Region
    original: InterpretedProgram
    result: InterpretedProgram
    stop: int

    @property
    def was_behind(self) -> State:
        """The state of the original behind the edit."""
        return self.original.behind(self.edit.last)

    @property
    def now_behind(self) -> State:
        """The state of the output behind the edit."""
        return self.result.behind(self.region.last)

    def first_cut_behind(self) -> BlockEffect | None:
        """The first block of the original behind the edit that feeds; None where another edit comes first."""
        for effect in self.blocks_behind():
            if effect.move is not None and effect.move.kind != "rapid":
                return effect
        return None

    def blocks_behind(self) -> Iterator[BlockEffect]:
        """What the original does in the same path from the edit to the next one, or to the program's end.

        Without the shapes of cycles, over which the control passes.
        """
        path = self.was_behind.path
        dialect = self.original.settings.dialect
        for effect in self.original.effects_of(self.edit.last, self.stop):
            if effect.after.ended or begins_program(effect.block, dialect):
                return
            if effect.after.path == path and not effect.in_contour:
                yield effect

    def line_in_result(self, line: int) -> int:
        """Where a line of the original before the next edit stands in the output."""
        return self.region.last + line - self.edit.last


class Promise(Record, kw_only=True):
    """Nothing but what every edit keeps: the state of the control, the place of the tool, the spindle speed.

    ``leaves_motion``: behind the edit another of G0 to G3 may be in force, for the next move says its own.
    ``leaves_speed``: the edit may leave another spindle speed behind.
    ``leaves_spindle``, ``leaves_coolant``: the spindle may stand, or coolant not flow, for the program says
    that itself before anything counts on it; ``leaves_feed``: another F may be in force, for the same reason.
    """

    leaves_motion: bool = False
    leaves_speed: bool = False
    leaves_spindle: bool = False
    leaves_coolant: bool = False
    leaves_feed: bool = False

    def check(self, written: Written) -> object | None:
        """Look at what was promised beyond that; what is worth a report is returned, several as a tuple.

        Raises SelfCheckError where the output does not do it.
        """
        return None


class SpeedCommanded(Promise, kw_only=True):
    """Behind the edit the spindle is commanded to turn at ``speed_rpm``."""

    speed_rpm: float
    leaves_speed: bool = True

    def check(self, written: Written) -> None:
        """Compare what the output commands; a call in the same block may leave it unknown."""
        now = spindle_speed(written.now_behind)
        if now.value is not None and (now.mode != "rpm" or now.value != self.speed_rpm):
            needed = f"the spindle needs {self.speed_rpm:g} rpm behind line {written.edit.first + 1}"
            raise SelfCheckError(f"{needed}, S{now.value:g} is commanded")


class SpeedGivenBack(Promise, kw_only=True):
    """Behind the edit the spindle speed is the programmed one, in its mode."""

    leaves_speed: bool = True

    def check(self, written: Written) -> None:
        """Compare with the original."""
        if spindle_speed(written.was_behind) != spindle_speed(written.now_behind):
            line = written.edit.last + 1
            raise SelfCheckError(f"before line {line} the spindle speed is not the programmed one")


class SpindleRestarted(Promise, kw_only=True):
    """The spindle is stopped and started again; the next cut behind has the programmed speed.

    Where the program commands spindle or coolant itself before it moves anywhere but home, they may stand.
    """

    leaves_speed: bool = True

    def check(self, written: Written) -> None:
        """Speed, spindle and coolant are back behind the edit, or the program commands them itself."""
        self._check_speed(written)
        if self.leaves_feed and not _feed_is_said(written):
            at = written.edit.first + 1
            raise SelfCheckError(f"behind the insertion at line {at} a cut begins with another F")
        for group, is_left in (("spindle", self.leaves_spindle), ("coolant", self.leaves_coolant)):
            if is_left and not _is_commanded(written, group):
                at = written.edit.first + 1
                raise SelfCheckError(f"behind the insertion at line {at} the {group} is not given back")

    def _check_speed(self, written: Written) -> None:
        if spindle_speed(written.was_behind) == spindle_speed(written.now_behind):
            return
        for effect in written.blocks_behind():
            if effect.after.speed != effect.before.speed:
                return
            if effect.move is not None and effect.move.kind != "rapid":
                at = written.edit.first + 1
                raise SelfCheckError(f"behind the insertion at line {at} a cut begins at another speed")


def _feed_is_said(written: Written) -> bool:
    """True where the first block behind that feeds says F itself."""
    for effect in written.blocks_behind():
        if effect.says("F"):
            return not effect.block.is_optional
        if effect.move is not None and effect.move.kind != "rapid":
            return False
    return True


def _is_commanded(written: Written, group: str) -> bool:
    """True where the program commands it, or ends, before it moves, calls or waits for anybody."""
    for effect in written.blocks_behind():
        if effect.does(group):
            return True
        moves = effect.move is not None and not effect.non_modal & {"home", "machine"}
        if moves or effect.block.controls or effect.does("stop") or effect.does("subprogram"):
            return False
    return True


KEPT = Promise()
