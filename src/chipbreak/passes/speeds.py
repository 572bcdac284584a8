"""Cutting speed and diameter become S.

::

    G97 V120. D20. M3     ->     G97 S1910 M3
    (SPEED V120 D20)      ->     (SPEED V120 D20)
                                 S1910
"""

from __future__ import annotations

from collections.abc import Iterator

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import SpeedCommanded
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.cutting_speed import CuttingSpeed, cutting_speed_of
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.text.diagnostics import Diagnostic, RefusalError


class CuttingSpeeds(Pass):
    """S from V and D, so that the control knows a spindle speed."""

    name = "speeds"

    def plan(self, context: Context) -> Planned:
        """An edit for every V and D, and what is wrong with the others."""
        edits: list[Edit] = []
        diagnostics: list[Diagnostic] = []
        for effect in _asking(context.interpreted):
            found = _edit_or_error(context.interpreted, effect)
            if isinstance(found, Edit):
                edits.append(found)
            elif found is not None:
                diagnostics.append(found)
        return Planned(edits, diagnostics)


def _asking(interpreted: InterpretedProgram) -> Iterator[BlockEffect]:
    """The blocks that may speak of a cutting speed."""
    for line in interpreted.program.special_lines.tolist():
        if _may_ask(interpreted.program.block(line)):
            yield interpreted.effect(line)


def _may_ask(block: Block) -> bool:
    return block.has_any("VD") or any("SPEED" in comment.text.upper() for comment in block.comments)


def _edit_or_error(interpreted: InterpretedProgram, effect: BlockEffect) -> Edit | Diagnostic | None:
    """What becomes of a block; None where it speaks of no cutting speed after all."""
    line = effect.block.line
    try:
        starts = effect.does("spindle", "cw", "ccw")
        dialect = interpreted.settings.dialect
        asked = cutting_speed_of(effect.block, effect.after, dialect, starts_spindle=starts)
    except RefusalError as error:
        return interpreted.program.diagnose(line, error.code, error.message, error.help)
    if asked is None:
        return None
    speed = f"S{asked.speed_text(interpreted.settings.spindle.resolution_rpm)}"
    if float(speed[1:]) == 0.0:
        message = f"V{asked.v_m_min:g} at D{asked.d_mm:g} prints as S0: the spindle would not turn"
        return interpreted.program.diagnose(line, "VIB073", message, "raise V", at=asked.at)
    limit = _limit_rpm(effect.after, interpreted.settings)
    if limit is not None and float(speed[1:]) > limit:
        message = f"V{asked.v_m_min:g} at D{asked.d_mm:g} needs {speed}, above the limit of {limit:g} rpm"
        return interpreted.program.diagnose(line, "VIB072", message, "lower V", at=asked.at)
    return _edit(interpreted, effect, asked, speed)


def _limit_rpm(state: State, settings: Settings) -> float | None:
    """The lower of the limits of the machine and of the program."""
    programmed = state.speed_limit.value if state.speed_limit else None
    return min((x for x in (settings.spindle.max_rpm, programmed) if x is not None), default=None)


def _edit(interpreted: InterpretedProgram, effect: BlockEffect, asked: CuttingSpeed, speed: str) -> Edit:
    first, last, content = _blocks(interpreted, effect, asked, speed)
    reason = f"V {asked.v_m_min:g} m/min at D {asked.d_mm:g} mm: S = 1000 V / (pi D)"
    return Edit(first, last, content, f"SPEED {speed}", reason, SpeedCommanded(speed_rpm=float(speed[1:])))


def _blocks(
    interpreted: InterpretedProgram, effect: BlockEffect, asked: CuttingSpeed, speed: str
) -> tuple[int, int, tuple[str, ...]]:
    """First and last line (exclusive) that change, and what they become."""
    line = effect.block.line
    text = effect.block.text
    if asked.words:
        first, second = asked.words
        between = text[first.end : second.start].rstrip()
        return line, line + 1, (text[: first.start] + speed + between + text[second.end :],)
    # The comment stays.  Beside other words its speed must be there before they act.
    at = line if effect.block.words else line + 1
    source = interpreted.program.source
    if at == source.line_count and not source.raw(line).endswith((b"\n", b"\r")):
        return line, line + 1, (text, speed)
    return at, at, (speed,)
