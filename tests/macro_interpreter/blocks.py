"""What the codes of one block do to the machine."""

from __future__ import annotations

from collections.abc import Sequence

from chipbreak.syntax.nodes import Block
from chipbreak.units import MM_PER_INCH
from macro_interpreter.faults import MOTION, UNSUPPORTED, ProgramEnd, fault
from macro_interpreter.machine import AXES, Machine, Position
from macro_interpreter.modes import GROUP_OF, Modes

# M codes after which nothing more is read before they are done.
STOPS_READING = {0, 1, 2, 6, 30}
# Of the machine builder: shutter open and closed, air on and off, looks for a missing edge and for a broken
# beam, single block and overrides locked and free.
SHUTTER, AIR, GAP_ON, GAP_OFF, LOCKS = {71, 72}, {73, 74}, 75, 76, {77, 78}
_KNOWN_M = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 19, 30, GAP_ON, GAP_OFF, *SHUTTER, *AIR, *LOCKS}
_ONCE = {4, 9, 10, 28, 31, 53}
# Any of these in force turns or bends what an axis word means.
_BENDING = {7: 40, 9: 80, 11: 50, 16: 69, 17: 15, 22: 50.1}
Words = Sequence[tuple[str, float]]


class BlockRunner:
    """Runs blocks without macro statements."""

    def __init__(self, machine: Machine, modes: Modes, length_offsets_mm: dict[int, float]) -> None:
        self.machine, self.modes, self.length_offsets_mm = machine, modes, length_offsets_mm
        self.m_codes: list[int] = []  # all that ran, for those who want to know

    def run(self, block: Block, words: Words) -> None:
        """Run the words of a block, in the order in which controls act on them."""
        self.machine.do(lambda: self.machine.wait(self.machine.control.block_s))
        codes = [value for address, value in words if address == "G"]
        non_modal = [code for code in codes if code in _ONCE]
        self._set_modes(block, codes)
        self.modes.words.update((address, value) for address, value in words if address not in "GMXYZ")
        self._length_offset(codes)
        m_codes = [round(value) for address, value in words if address == "M"]
        for code in m_codes:
            self._before(code, words, block)
        self._move(block, words, non_modal)
        self.machine.end_block()
        for code in m_codes:
            if code in (2, 30):
                raise ProgramEnd
            if code in STOPS_READING:
                self.machine.catch_up()

    def _set_modes(self, block: Block, codes: Sequence[float]) -> None:
        for code in codes:
            if code in GROUP_OF:
                self.modes.codes[GROUP_OF[code]] = code
            elif code not in _ONCE:
                raise fault(UNSUPPORTED, f"G{code:g} is not known here: {block.text}")

    def _before(self, code: int, words: Words, block: Block) -> None:
        """M codes that act before the move."""
        if code not in _KNOWN_M:
            raise fault(UNSUPPORTED, f"M{code} is not known here: {block.text}")
        self.modes.words["M"] = float(code)
        self.m_codes.append(code)
        self.machine.do(lambda: self.machine.wait(self.machine.control.m_code_s))
        moves_too = any(address in AXES for address, _ in words)
        if code in (3, 4):
            self.machine.turn(float(round(self.modes.words.get("S", 0.0))), moves_too=moves_too)
        elif code == 5:
            self.machine.turn(0.0, moves_too=moves_too)
        elif code in (GAP_ON, GAP_OFF):
            self.machine.look_for_gap(is_on=code == GAP_ON)
        elif code == 6:
            self.machine.load(round(self.modes.words.get("T", 0.0)))
        elif code == 19:
            angles = [value for address, value in words if address in "RPQ"]
            self.machine.turn(0.0, angle_deg=angles[-1] if angles else 0.0)

    def _length_offset(self, codes: Sequence[float]) -> None:
        if 49 in codes:
            self.modes.length_mm = 0.0
        elif 43 in codes or 44 in codes:
            number = round(self.modes.words.get("H", 0.0))
            offset = self.length_offsets_mm.get(number, 0.0)
            self.modes.length_mm = offset if 43 in codes else -offset

    def _move(self, block: Block, words: Words, non_modal: Sequence[float]) -> None:
        scale = MM_PER_INCH if self.modes.is_inch else 1.0
        axes = {address: value * scale for address, value in words if address in AXES}
        if 53 in non_modal:
            self._move_by_machine(block, axes)
            return
        if 4 in non_modal:
            self._dwell(words)
            return
        if 10 in non_modal or not axes:
            return
        self._check_straight(block)
        target = self._target(axes)
        if 28 in non_modal:
            self.machine.move(target)
            self.machine.move(self._with(dict.fromkeys(axes, 0.0), target))
        elif 31 in non_modal:
            self.machine.skip(target, self._feed(scale, block))
        elif self.modes.codes[1] in (0, 1):
            feed = self._feed(scale, block) if self.modes.codes[1] == 1 else 0.0
            self.machine.move(target, feed)
        else:
            raise fault(UNSUPPORTED, f"only straight moves are known here: {block.text}")

    def _dwell(self, words: Words) -> None:
        """G4: X or U in seconds, P in milliseconds; nothing is read ahead over it."""
        for address, value in words:
            if address in "XUP":
                seconds = value / 1000.0 if address == "P" else value
                self.machine.do(lambda seconds=seconds: self.machine.wait(seconds))  # type: ignore[misc]

    def _move_by_machine(self, block: Block, axes: dict[str, float]) -> None:
        """G53: machine coordinates, and nothing is read ahead."""
        if axes and not self.modes.is_absolute:
            raise fault(MOTION, f"G53 under G91 moves nothing: {block.text}")
        self.machine.move(self._with(self._rounded(axes), self.machine.planned))
        self.machine.end_block()
        self.machine.catch_up()

    def _check_straight(self, block: Block) -> None:
        """Refuse a move while a code is in force that turns or bends it."""
        modes = self.modes.codes
        in_the_way = [f"G{modes[group]:g}" for group, plain in _BENDING.items() if modes[group] != plain]
        if in_the_way:
            raise fault(MOTION, f"a move under {' '.join(in_the_way)}: {block.text}")

    def _feed(self, scale: float, block: Block) -> float:
        if self.modes.codes[5] != 94 or not self.modes.words.get("F", 0.0) > 0.0:
            raise fault(MOTION, f"no feed per minute: {block.text}")
        return self.modes.words["F"] * scale

    def _target(self, axes: dict[str, float]) -> Position:
        """Where a move ends, in machine coordinates."""
        planned = self.machine.planned
        axes = self._rounded(axes)
        if not self.modes.is_absolute:
            return self._with({axis: planned[AXES.index(axis)] + way for axis, way in axes.items()}, planned)
        offsets = dict(zip(AXES, self.machine.work_mm, strict=True))
        offsets["Z"] += self.modes.length_mm
        return self._with({axis: value + offsets[axis] for axis, value in axes.items()}, planned)

    def _rounded(self, axes: dict[str, float]) -> dict[str, float]:
        """What is commanded is a multiple of the least input increment."""
        grid = self.machine.control.grid_mm(is_inch=self.modes.is_inch)
        return {axis: round(value / grid) * grid for axis, value in axes.items()}

    @staticmethod
    def _with(axes: dict[str, float], position: Position) -> Position:
        x, y, z = (axes.get(axis, old) for axis, old in zip(AXES, position, strict=True))
        return x, y, z
