"""Expand the cuts that are asked to vibrate.

::

    G97 S3000 M3                 G97 S3000 M3
    G0 X20. Z2.           ->     G0 X20. Z2.
    G1 Z-30. F0.05 N1.5          S2500
    M30                          G1 Z1.92 F0.55
                                 Z1.967 F0.305 ...
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chipbreak.editing.edits import Edit
from chipbreak.kinematics.toolpath import BAD_ARC, path_of
from chipbreak.kinematics.waveform import TOO_SHORT
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.vibration.advice import with_advice
from chipbreak.vibration.blocks import Expansion, moves_of
from chipbreak.vibration.chain import Chain, chains_of, legs_of
from chipbreak.vibration.cut_edit import VIBRATE, PlannedCut, expansion_edit, settling
from chipbreak.vibration.loop_names import LoopNames, free_names
from chipbreak.vibration.plan import CutPlan, plan_cut
from chipbreak.vibration.request import Request
from chipbreak.vibration.speeds import SpeedChange, speed_changes

_MOST_ADVISED = 3  # what works is tried for the first refused cuts; the others fail alike
SMOOTHED = "VIB063"
_OFF = re.compile(r"[PQ]\s*0\b")

_NO_KNOTS = np.empty(0)


@dataclass(frozen=True, eq=False)
class VibrationPlan:
    """The vibrated cuts of a program, all edits of this pass, and what was found on the way."""

    cuts: tuple[PlannedCut, ...]
    edits: tuple[Edit, ...]
    diagnostics: tuple[Diagnostic, ...]


def plan(
    interpreted: InterpretedProgram,
    settings: Settings,
    requests: Sequence[Request],
    *,
    checks_at: Collection[int] = (),
    allow_unbroken: bool = False,
) -> VibrationPlan:
    """Plan every vibrated cut.  Errors are diagnostics; with one, the edits must not be used.

    ``checks_at`` are the lines before which tool checks will stand.
    ``allow_unbroken``: cuts too short to vibrate stay as they are, with a warning, where no word of theirs
    asks for vibration (it would reach the control).
    """
    chains, diagnostics = chains_of(interpreted, requests)
    warnings = list[Diagnostic]()
    cuts: list[CutPlan] = []
    expansions: list[Expansion] = []
    try:
        names = free_names(interpreted.program, settings) if chains else None
    except RefusalError as error:
        return VibrationPlan((), (), (_at_chain(interpreted, chains[0], error),))
    for chain in chains:
        try:
            cut = plan_cut(chain, settings)
            _check_motion_mode(interpreted, chain)
            expansion = _expand(cut, settings, names, advise=len(diagnostics) < _MOST_ADVISED)
        except RefusalError as error:
            if allow_unbroken and error.code == TOO_SHORT and not chain.asked_by_word:
                warnings.append(_at_chain(interpreted, chain, error)._replace(severity=Severity.WARNING))
            else:
                diagnostics.append(_at_chain(interpreted, chain, error))
            continue
        # Its blocks are made: the knots have served, and a long program has many.
        cuts.append(replace(cut, time_s=_NO_KNOTS, distance_mm=_NO_KNOTS))
        expansions.append(expansion)
        names = names.behind(len(expansion.loops or ())) if names is not None else None
    if diagnostics:
        # A refused cut leaves the speeds around it open: nothing more can be said honestly.
        return VibrationPlan((), (), tuple(sorted(diagnostics, key=_by_line)))
    try:
        changes = speed_changes(interpreted, cuts, settings, checks_at)
    except RefusalError as error:
        chain = next(chain for chain in chains if chain.before.speed is None)
        return VibrationPlan((), (), (_at_chain(interpreted, chain, error),))
    own = {change.line: change.text for change in changes if change.for_cut is not None}
    edits = [
        expansion_edit(cut, made.content, own.get(cut.chain.first, ""), interpreted, settings)
        for cut, made in zip(cuts, expansions, strict=True)
    ]
    back = [_speed_back(change, interpreted, settings) for change in changes if change.for_cut is None]
    planned = tuple(map(PlannedCut, cuts, expansions, edits))
    return VibrationPlan(planned, tuple(edits + back), (*warnings, *_smoothed(interpreted, chains, settings)))


def _expand(cut: CutPlan, settings: Settings, names: LoopNames | None, *, advise: bool) -> Expansion:
    try:
        return moves_of(cut, settings, names)
    except RefusalError as error:
        if not advise:
            raise
        raise with_advice(error, cut, settings, moves_of) from None


def _by_line(diagnostic: Diagnostic) -> int:
    return diagnostic.place.line if diagnostic.place else 0


def _at_chain(interpreted: InterpretedProgram, chain: Chain, error: RefusalError) -> Diagnostic:
    effect = chain.requests[_at_fault(chain, error)].effect
    at = (effect.vibration[0].start, effect.vibration[-1].end) if effect.vibration else None
    return interpreted.program.diagnose(effect.block.line, error.code, error.message, error.help, at=at)


def _at_fault(chain: Chain, error: RefusalError) -> int:
    """Which block of a chain: the arc that cannot be, of anything else the first."""
    if error.code == BAD_ARC:
        for index, leg in enumerate(legs_of(chain)):
            try:
                path_of([leg])
            except RefusalError as alone:
                if alone.code == BAD_ARC:
                    return index
    return 0


def _smoothed(
    interpreted: InterpretedProgram, chains: Sequence[Chain], settings: Settings
) -> Iterator[Diagnostic]:
    """A warning where the program smooths and the profile does not say how that is switched off."""
    for chain in chains:
        words = chain.before.smooth_words
        if settings.planner.smoothing_off or not words or _OFF.search(words):
            continue
        message = f"smoothing or look-ahead ({words}) is active and may round the oscillation away"
        help_text = "switch it off before the cut, or give planner.smoothing_off and smoothing_on"
        yield interpreted.program.diagnose(
            chain.first, SMOOTHED, message, help_text, severity=Severity.WARNING
        )


def _speed_back(change: SpeedChange, interpreted: InterpretedProgram, settings: Settings) -> Edit:
    reason = "the programmed spindle speed comes back before the block that needs it"
    effect = interpreted.effect(change.line)
    # A cut must find the speed reached, a thread above all; the end of the program need not.
    waits = effect.before.turns and not effect.after.ended
    content = (change.text, *(settling(settings) if waits else ()))
    return Edit(change.line, change.line, content, "SPEED AS PROGRAMMED", reason, VIBRATE)


def _check_motion_mode(interpreted: InterpretedProgram, chain: Chain) -> None:
    """The expansion ends in G1; behind a chain that ends in an arc the next move must say its own code."""
    last_kind = chain.requests[-1].effect.after.modes.motion
    if last_kind == "line":
        return
    for effect in interpreted.effects_of(chain.last, interpreted.program.source.body.stop):
        if effect.move is None:
            continue
        if not codes_of(effect.block, "motion", interpreted.settings.dialect):
            line = effect.block.line + 1
            message = f"line {line} goes on as an arc without saying G2 or G3, but this cut will end in G1"
            raise RefusalError("VIB056", message, f"write the motion code in line {line}")
        return
