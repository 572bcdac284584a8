"""Peripheral speed and diameter become S.

::

    G97 V120. D20. M3     ->     G97 S1910 M3
    (SPEED V120 D20)      ->     (SPEED V120 D20)
                                 S1910
"""

from __future__ import annotations

from chipbreak.editing.edits import Edit
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.cutting_speed import CuttingSpeed, cutting_speed_of
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.passes import SPEEDS
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import Diagnostic, RefusalError


def plan(interpreted: InterpretedProgram, settings: Settings) -> tuple[list[Edit], list[Diagnostic]]:
    """An edit for every V and D, and what is wrong with the others."""
    edits: list[Edit] = []
    diagnostics: list[Diagnostic] = []
    for line in interpreted.program.special_lines.tolist():
        block = interpreted.program.block(line)
        has_words = any(w.address in "VD" for w in block.words)
        if not (has_words or any("SPEED" in c.text.upper() for c in block.comments)):
            continue
        effect = interpreted.effect(line)
        try:
            asked = cutting_speed_of(block, effect.after)
        except RefusalError as error:
            diagnostics.append(interpreted.program.diagnose(line, error.code, error.message, error.help))
            continue
        if asked is None:
            continue
        speed = f"S{asked.speed_text(settings.spindle.resolution_rpm)}"
        if float(speed[1:]) == 0.0:
            message = f"V{asked.v_m_min:g} at D{asked.d_mm:g} prints as S0: the spindle would not turn"
            diagnostics.append(interpreted.program.diagnose(line, "VIB073", message, "raise V", at=asked.at))
            continue
        limits = (
            settings.spindle.max_rpm,
            effect.after.speed_limit.value if effect.after.speed_limit else None,
        )
        limit = min((x for x in limits if x is not None), default=None)
        if limit is not None and float(speed[1:]) > limit:
            message = f"V{asked.v_m_min:g} at D{asked.d_mm:g} needs {speed}, above the limit of {limit:g} rpm"
            diagnostics.append(interpreted.program.diagnose(line, "VIB072", message, "lower V", at=asked.at))
            continue
        edits.append(_edit(interpreted, effect, asked, speed))
    return edits, diagnostics


def _edit(interpreted: InterpretedProgram, effect: BlockEffect, asked: CuttingSpeed, speed: str) -> Edit:
    line, text = effect.block.line, effect.block.text
    title = f"SPEED {speed}"
    reason = f"V {asked.v_m_min:g} m/min at D {asked.d_mm:g} mm: S = 1000 V / (pi D)"
    if not asked.words:
        # The comment stays.  Beside other words its speed must be there before they act.
        at = line + 1 if effect.block.is_empty else line
        source = interpreted.program.source
        if at == source.line_count and not source.raw(line).endswith((b"\n", b"\r")):
            return Edit(line, line + 1, (text, speed), title, reason, SPEEDS)
        return Edit(at, at, (speed,), title, reason, SPEEDS)
    first, second = asked.words
    rest = text[second.end :]
    between = text[first.end : second.start].rstrip()
    return Edit(line, line + 1, (text[: first.start] + speed + between + rest,), title, reason, SPEEDS)
