"""A contour that a finishing cycle still needs, behind the end of the program.

The passes of the roughing cycle stand in its place, and the control would cut along it where it stood.  A
cycle finds its blocks by their numbers, wherever they are.
"""

from __future__ import annotations

from chipbreak.cycles.call import UNREAD_FORM
from chipbreak.cycles.writing import without_number
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import Promise, Written
from chipbreak.model.flow import contour_calls, sequence_lines
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.state_difference import difference
from chipbreak.text.diagnostics import RefusalError, SelfCheckError


class MovedContour(Promise, kw_only=True):
    """The end of the program and the blocks of a contour as they were; the cycles that name it find it there.

    ``numbers`` are those of its first and its last block.
    """

    numbers: tuple[float, float]
    texts: tuple[str, ...]

    def check(self, written: Written) -> None:
        """Compare the blocks, and look for them as a cycle does.  Raises SelfCheckError.

        Behind the end there is no state that counts.
        """
        program = written.result.program
        region = written.region
        was, now = (written.original.before(written.edit.first), written.result.before(region.first))
        wrong = difference(was._replace(feed=now.feed).with_motion(now.modes.motion), now)
        if wrong:
            raise SelfCheckError(f"{wrong} differs at the end in line {written.edit.first + 1}")
        texts = tuple(program.block(line).text for line in range(region.body, region.last - 1))
        calls = contour_calls(program, written.result.settings.dialect)
        named = [one for one in calls if program.block(one.line).number("P") == self.numbers[0]]
        inside = range(region.body, region.last)
        finds_it = all(one.first in inside and one.last in inside for one in named)
        if texts != self.texts or not (named and finds_it):
            raise SelfCheckError(f"the moved contour N{self.numbers[0]:g} is not found as it was")


def moved_contour(interpreted: InterpretedProgram, removed: Edit, call_line: int) -> Edit:
    """The edit that writes the contour that ``removed`` takes away behind the end that follows its last call.

    Errors: CYC007 where there is no sure end, or its numbers stand on other blocks too.
    """
    program = interpreted.program
    lines = range(removed.first, removed.last)
    blocks = [program.block(line) for line in lines]
    sequences = (blocks[0].sequence, blocks[-1].sequence)
    numbers = [word.number for word in sequences if word is not None and word.number is not None]
    known = sequence_lines(program)
    if len(numbers) != 2 or any(len(known.get(int(number), ())) != 1 for number in numbers):
        raise _refused("its numbers stand on several blocks")
    end = _end_behind(interpreted, max(call_line, removed.last - 1))
    texts = (without_number(program.block(end), interpreted.settings), *(block.text for block in blocks))
    promise = MovedContour(numbers=(numbers[0], numbers[1]), texts=texts, leaves_motion=True)
    reason = "the finishing cycle that stays looks for it by its numbers"
    return Edit(end, end + 1, texts, removed.title, reason, promise)


def _end_behind(interpreted: InterpretedProgram, line: int) -> int:
    """The line of the M30, M2 or M99 with which the program ends behind a line."""
    for effect in interpreted.effects_of(line, interpreted.program.source.body.stop):
        if effect.after.ended and not effect.before.ended:
            if effect.block.skip or effect.block.has_macro or effect.block.controls:
                break
            return effect.block.line
    raise _refused("no block ends the program behind it")


def _refused(why: str) -> RefusalError:
    message = f"the contour cannot stand behind the end of the program: {why}"
    return RefusalError(UNREAD_FORM, message, "write it behind M30 yourself")
