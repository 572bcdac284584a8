"""Variables: locals of each call level, commons, and system variables of the machine."""

from __future__ import annotations

from functools import cache

from chipbreak.units import MM_PER_INCH
from macro_interpreter.expressions import Value
from macro_interpreter.faults import VARIABLE, fault
from macro_interpreter.machine import Machine
from macro_interpreter.modes import Modes

LOCAL_COUNT = 33
ALARM, STOP = 3000, 3006
SINGLE_BLOCK, OVERRIDE = 3003, 3004
# Argument letters of G65, specification I.
_LETTERS, _NUMBERS = "ABCIJKDEFHMQRSTUVWXYZ", (*range(1, 10), 11, 13, *range(17, 27))
ARGUMENTS = dict(zip(_LETTERS, _NUMBERS, strict=True))


@cache
def _numbers(ranges: tuple[tuple[int, int], ...]) -> frozenset[int]:
    return frozenset(number for first, last in ranges for number in range(first, last + 1))


class Variables:
    """All that ``#`` can name.

    ``commons`` are those that the control has, vacant until written.  ``inputs``
    are signals #1000 to #1031 other than the beam, which is ``beam_input``.
    """

    def __init__(self, machine: Machine, modes: Modes, beam_input: int) -> None:
        self.machine, self.modes, self.beam_input = machine, modes, beam_input
        self._common_numbers = _numbers(machine.control.commons)
        self.levels: list[dict[int, Value]] = [{}]
        self.commons: dict[int, Value] = {}
        self.inputs: dict[int, float] = {}
        self.locks: dict[int, Value] = {}  # single block, overrides

    def read(self, number: int) -> Value:
        """The value of a variable; None is vacant."""
        if number == 0:
            return None
        if 1 <= number <= LOCAL_COUNT:
            return self.levels[-1].get(number)
        if number in self._common_numbers:
            return self.commons.get(number)
        return self._system(number)

    def write(self, number: int, value: Value) -> None:
        """Give a local or common variable a value."""
        if 1 <= number <= LOCAL_COUNT:
            self.levels[-1][number] = value
        elif number in (SINGLE_BLOCK, OVERRIDE):
            self.locks[number] = value
        elif number in self._common_numbers:
            self.commons[number] = value
        else:
            raise fault(VARIABLE, f"#{number} cannot be written here")

    def _system(self, number: int) -> Value:
        if 1000 <= number <= 1031:
            if number == self.beam_input:
                return float(self.machine.is_broken())
            return self.inputs.get(number, 0.0)
        if 3001 <= number <= 3002:  # a clock: milliseconds, hours
            scale = 1000.0 if number == 3001 else 1.0 / 3600.0
            return self.machine.clock_s * scale
        if 4001 <= number <= 4130:
            return self.modes.readout(number)
        kind, axis = divmod(number - 5001, 20)
        if number > 5000 and kind in range(4) and axis < 3:
            return self._position(kind, axis)
        raise fault(VARIABLE, f"there is no variable #{number} on this control")

    def _position(self, kind: int, axis: int) -> float:
        """#5001 end of the block, #5021 machine, #5041 work, #5061 skip; in program units."""
        machine = self.machine
        places = (machine.planned, machine.at, machine.at, machine.skipped_at)
        value = places[kind][axis] - (0.0 if kind == 1 else machine.work_mm[axis])
        if kind == 0 and axis == 2:
            value -= self.modes.length_mm
        grid = machine.control.machine_grid_mm()
        value = round(value / grid) * grid
        return value / (MM_PER_INCH if self.modes.is_inch else 1.0)
