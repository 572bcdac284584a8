"""Cycles that make one pass with each block (G90, G94 of code system A): rapid in, cut, feed out, rapid back.

::

    G90 X48. Z-20. F0.2           G0 X48.
    X46.                          G1 Z-20. F0.2
                           ->     G1 X52.
                                  G0 Z2.
                                  G0 X46. ...
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

from chipbreak.cycles.call import UNREAD_FORM, refuse_modes
from chipbreak.cycles.promise import SinglePasses
from chipbreak.cycles.starts import END_COMPENSATION, UNDER_COMPENSATION, refuse_unknown_start
from chipbreak.cycles.writing import BlockWriter
from chipbreak.editing.edits import Edit
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.points import WRITE_THE_POINT, first_without_point
from chipbreak.model.words import is_diameter, length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_WORDS = frozenset("GXZUWRF")
_BETWEEN = frozenset("SM")
_CUT = 1  # of the moves of a pass, the one along it
_Motion: TypeAlias = tuple[bool, float, float]


class _Target(NamedTuple):
    """The corner that a pass cuts to, and how much its start is off it [mm, X as a radius]; modal."""

    x_mm: float = math.nan
    z_mm: float = math.nan
    taper_mm: float = 0.0


def first_lines(interpreted: InterpretedProgram) -> list[int]:
    """The lines at which such cycles begin."""
    return [effect.block.line for effect in interpreted.effects if _passes(effect) and _begins(effect)]


def _passes(effect: BlockEffect) -> bool:
    return effect.after.modes.motion == "turning-cycle" and effect.move is not None


def _begins(effect: BlockEffect) -> bool:
    return effect.before.modes.motion != "turning-cycle"


def single_passes(interpreted: InterpretedProgram, first: int) -> Edit:
    """The edit that writes out the passes from line ``first`` on, as long as their code is in force.

    Errors: CYC007 for a block that cannot be written out.
    """
    effects = _run(interpreted, first)
    if not effects:
        message = "the program ends in the block of this cycle"
        raise RefusalError(UNREAD_FORM, message, "write its end (M30, M2, M99) on a line of its own")
    start = effects[0].before
    _refuse_state(interpreted, first, start)
    settings = interpreted.settings
    writer = BlockWriter(start, settings)
    target = _Target()
    content: list[str] = []
    moves: list[_Motion] = []
    number = 0
    along_z = True
    for effect in effects:
        if not _passes(effect):
            content += [effect.block.text.strip()] if effect.block.words or effect.block.comments else []
            continue
        number += 1
        target = _target(effect, target, settings)
        along_z = _goes_along_z(effect.block, settings, along_z=along_z)
        blocks, made = _blocks(writer, _moves(target, start, along_z=along_z), effect.block)
        content += [writer.comment(f"pass {number}"), *blocks]
        moves += made
    reason = "one pass with each block: rapid in, cut, feed out, rapid back"
    name = effects[0].block.text.strip()
    return Edit(
        first, effects[-1].block.line + 1, tuple(content), name, reason, SinglePasses(moves=tuple(moves))
    )


def _run(interpreted: InterpretedProgram, first: int) -> list[BlockEffect]:
    """The blocks from the first pass to the last one under its code."""
    effects: list[BlockEffect] = []
    count = 0
    for effect in interpreted.effects_of(first, interpreted.program.source.body.stop):
        if effect.after.modes.motion != "turning-cycle" or effect.after.ended:
            break
        effects.append(effect)
        count = len(effects) if effect.move is not None else count
    for effect in effects[:count]:
        _refuse_block(effect, interpreted)
    return effects[:count]


def _refuse_block(effect: BlockEffect, interpreted: InterpretedProgram) -> None:
    block = effect.block
    known = _WORDS if effect.move is not None else _BETWEEN
    is_plain = not (block.opaque or block.skip or block.has_macro or effect.non_modal or effect.vibration)
    is_plain &= not block.marks and block.line not in interpreted.flow.targets
    # A mode that a pass changes would be that of the passes before it too, or of none.
    is_plain &= not set(effect.before.modes.changed(effect.after.modes)) - {"motion"}
    if not is_plain or any(word.address not in known for word in block.words):
        message = f"{block.text.strip()[:40]} is no plain pass of this cycle"
        raise RefusalError(UNREAD_FORM, message, "write its passes with X, Z, U, W, R and F as plain numbers")


def _refuse_state(interpreted: InterpretedProgram, line: int, state: State) -> None:
    refuse_modes(state)
    refuse_unknown_start(interpreted, line, state)
    if state.modes.compensation != "off":
        raise RefusalError(UNREAD_FORM, UNDER_COMPENSATION, END_COMPENSATION)


def _goes_along_z(block: Block, settings: Settings, *, along_z: bool) -> bool:
    """Which way the pass goes; without a code as the pass before it."""
    cycles = settings.dialect.turning_cycles
    said = [cycles[code] for n in block.numbers("G") if (code := round(n * 10)) in cycles]
    return said[-1] == "along-z" if said else along_z


def _target(effect: BlockEffect, target: _Target, settings: Settings) -> _Target:
    """The corner of the pass: what a block does not say stays; U and W count from the start."""
    state = effect.after
    halved = 2.0 if is_diameter(state, settings.control) else 1.0
    words = settings.axis_words
    said = {"X": target.x_mm, "Z": target.z_mm}
    taper_mm = target.taper_mm
    for word in effect.block.words:
        axis = words.axes.get(word.address, "")
        value_mm = length_mm(word, state, settings)
        if axis in said:
            value_mm *= words.signs[axis] / (halved if axis == "X" else 1.0)
            begin_mm = (
                getattr(effect.before.position, axis.lower()) if word.address in words.distances else 0.0
            )
            said[axis] = begin_mm + value_mm
        elif word.address == "R":
            taper_mm = value_mm
    if math.isnan(said["X"] + said["Z"] + taper_mm):
        shown = first_without_point(effect.block.words_of({*words.axes, "R"}), state, settings)
        if shown:
            raise RefusalError(UNREAD_FORM, f"{shown} of this cycle has no decimal point", WRITE_THE_POINT)
        message = "X, Z or R of this cycle is missing, or worked out on the control"
        raise RefusalError(UNREAD_FORM, message, "give X and Z of the pass as plain numbers")
    return _Target(said["X"], said["Z"], taper_mm)


def _moves(target: _Target, start: State, *, along_z: bool) -> list[_Motion]:
    """The moves of one pass: whether it cuts, Z and radius of its end."""
    from_z = start.position.z
    from_x = start.position.x
    if along_z:
        return [
            (False, from_z, target.x_mm + target.taper_mm),
            (True, target.z_mm, target.x_mm),
            (True, target.z_mm, from_x),
            (False, from_z, from_x),
        ]
    return [
        (False, target.z_mm + target.taper_mm, from_x),
        (True, target.z_mm, target.x_mm),
        (True, from_z, target.x_mm),
        (False, from_z, from_x),
    ]


def _blocks(writer: BlockWriter, moves: Sequence[_Motion], block: Block) -> tuple[list[str], list[_Motion]]:
    """Each move as a block, and the moves that these make: one without length is none, as on the control.

    F of the cycle's block stands where the cut begins.  Errors: CYC007 for a pass that cuts nothing.
    """
    word = block.word("F")
    feed = "" if word is None else f"F{word.value_text}"
    blocks = []
    made = []
    for at, (cuts, z_mm, radius_mm) in enumerate(moves):
        text = writer.block("G1" if cuts else "G0", z_mm, radius_mm, feed if cuts else "")
        if text:
            feed = "" if cuts else feed
            blocks.append(text)
            made.append((cuts, z_mm, radius_mm))
        elif at == _CUT:
            message = "a pass of this cycle has a cut without length"
            raise RefusalError(UNREAD_FORM, message, "start the cycle away from where the pass ends")
    return blocks, made
