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

from chipbreak.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.edits import Edit, MoveTable
from chipbreak.model.trace import Trace
from chipbreak.model.words import codes_of
from chipbreak.passes import VIBRATE
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.vibration.advice import with_advice
from chipbreak.vibration.blocks import Expansion, moves_of
from chipbreak.vibration.chain import Chain, chains_of, legs_of
from chipbreak.vibration.loop_names import LoopNames, free_names
from chipbreak.vibration.path import BAD_ARC, path_of
from chipbreak.vibration.plan import VibratedCut, plan_cut
from chipbreak.vibration.request import Request
from chipbreak.vibration.speeds import SpeedChange, speed_changes, speed_words
from chipbreak.vibration.waveform import TOO_SHORT

_MOST_ADVISED = 3  # what works is tried for the first refused cuts; the others fail alike
SMOOTHED = "VIB063"
_OFF = re.compile(r"[PQ]\s*0\b")

_NO_KNOTS = np.empty(0)


@dataclass(frozen=True, eq=False)
class PlannedCut:
    """A vibrated cut, its blocks, and the edit that puts them into the program."""

    cut: VibratedCut
    expansion: Expansion
    edit: Edit


@dataclass(frozen=True, eq=False)
class VibrationPlan:
    """The vibrated cuts of a program, all edits of this pass, and what was found on the way."""

    cuts: tuple[PlannedCut, ...]
    edits: tuple[Edit, ...]
    diagnostics: tuple[Diagnostic, ...]


def plan(
    trace: Trace,
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
    chains, diagnostics = chains_of(trace, requests)
    warnings = list[Diagnostic]()
    cuts: list[VibratedCut] = []
    expansions: list[Expansion] = []
    try:
        names = free_names(trace.program, settings) if chains else None
    except RefusalError as error:
        return VibrationPlan((), (), (_at_chain(trace, chains[0], error),))
    for chain in chains:
        try:
            cut = plan_cut(chain, settings)
            _check_motion_mode(trace, chain)
            expansion = _expand(cut, settings, names, advise=len(diagnostics) < _MOST_ADVISED)
        except RefusalError as error:
            if allow_unbroken and error.code == TOO_SHORT and not chain.asked_by_word:
                warnings.append(_at_chain(trace, chain, error)._replace(severity=Severity.WARNING))
            else:
                diagnostics.append(_at_chain(trace, chain, error))
            continue
        # Its blocks are made: the knots have served, and a long program has many.
        cuts.append(replace(cut, time_s=_NO_KNOTS, distance_mm=_NO_KNOTS))
        expansions.append(expansion)
        names = names.behind(len(expansion.loops or ())) if names is not None else None
    if diagnostics:
        # A refused cut leaves the speeds around it open: nothing more can be said honestly.
        return VibrationPlan((), (), tuple(sorted(diagnostics, key=_by_line)))
    try:
        changes = speed_changes(trace, cuts, settings, checks_at)
    except RefusalError as error:
        chain = next(chain for chain in chains if chain.before.speed is None)
        return VibrationPlan((), (), (_at_chain(trace, chain, error),))
    own = {change.line: change.text for change in changes if change.for_cut is not None}
    edits = [
        _expansion(cut, made.content, own.get(cut.chain.first, ""), trace, settings)
        for cut, made in zip(cuts, expansions, strict=True)
    ]
    back = [_speed_back(change, trace, settings) for change in changes if change.for_cut is None]
    planned = tuple(map(PlannedCut, cuts, expansions, edits))
    return VibrationPlan(planned, tuple(edits + back), (*warnings, *_smoothed(trace, chains, settings)))


def planned_cut(chain: Chain, trace: Trace, settings: Settings) -> PlannedCut:
    """One cut on its own, with its speed said; for trying what would work.  Errors: RefusalError."""
    cut = plan_cut(chain, settings)
    made = moves_of(cut, settings)
    speed = speed_words(None, ("rpm", cut.solution.speed_rpm), settings)
    return PlannedCut(cut, made, _expansion(cut, made.content, speed, trace, settings))


def _expand(cut: VibratedCut, settings: Settings, names: LoopNames | None, *, advise: bool) -> Expansion:
    try:
        return moves_of(cut, settings, names)
    except RefusalError as error:
        if not advise:
            raise
        raise with_advice(error, cut, settings, moves_of) from None


def _by_line(diagnostic: Diagnostic) -> int:
    return diagnostic.place.line if diagnostic.place else 0


def _at_chain(trace: Trace, chain: Chain, error: RefusalError) -> Diagnostic:
    step = chain.requests[_at_fault(chain, error)].step
    at = (step.vibration[0].start, step.vibration[-1].end) if step.vibration else None
    return trace.program.diagnose(step.block.line, error.code, error.message, error.help, at=at)


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


def _expansion(
    cut: VibratedCut,
    moves: tuple[str | MoveTable, ...],
    speed: str,
    trace: Trace,
    settings: Settings,
) -> Edit:
    """The edit of one cut: comments kept, words that act first, speed, feed mode, moves, modes given back."""
    chain = cut.chain
    comments = [
        trace.program.block(line).text
        for line in range(chain.first, chain.last)
        if trace.program.block(line).is_empty and trace.program.block(line).comments
    ]
    was = chain.before.modes["feed_mode"]
    mode = was if cut.keeps_feed else settings.output.feed_mode
    head = [*comments, chain.preamble(), speed]
    head += _settling(settings) if speed else []
    feed_back = f"F{chain.after.feed.text}" if chain.after.feed else ""
    if mode != was:
        like = {n for s in trace.events for n in codes_of(s.block, "feed_mode", settings.dialect)}
        head.append(settings.dialect.code("feed_mode", mode, like))
        feed_back = f"{settings.dialect.code('feed_mode', was, like)} {feed_back}"
    feed_stands = cut.keeps_feed or cut.cut.end_revolutions > 0.0
    tail = [] if mode == was and feed_stands else [feed_back]
    switched, given_back = _modes_around(chain, settings)
    head += switched
    tail += given_back
    solution = cut.solution
    title = (
        f"VIB N{print_number(solution.per_rev, 4, point=False)}"
        f" F{print_number(solution.frequency_hz, 3, point=False)}"
        f" S{print_number(solution.speed_rpm, 3, point=False)}"
        f" {'DWELL' if cut.keeps_feed else f'STROKE {print_number(cut.cut.stroke_mm, 4)}'}"
    )
    reason = "; ".join(cut.reasons) or "nothing to correct"
    content = (*(text for text in head if text), *moves, *tail)
    return Edit(chain.first, chain.last, content, title, reason, VIBRATE)


def _settling(settings: Settings) -> list[str]:
    """The dwell in which the spindle reaches a new speed."""
    if settings.spindle.settle_s <= 0.0:
        return []
    return [f"G4 {settings.dialect.dwell_word}{print_number(settings.spindle.settle_s, 3)}"]


def _modes_around(chain: Chain, settings: Settings) -> tuple[list[str], list[str]]:
    """Path mode and smoothing for the cut, and what the program had, to be given back.

    A straight oscillation is collinear: a path mode that blends, or a smoothing, may round it away.  It would
    also round the corner from a cut before this one, unless the tool rests there.
    """
    planner, before = settings.planner, chain.before
    head, tail = list[str](), list[str]()
    if planner.smoothing_off and not _is_same_mode(before.smooth_words, planner.smoothing_off):
        head.append(planner.smoothing_off)
        tail.append(before.smooth_words or planner.smoothing_on)
    if planner.path_mode and not _is_same_mode(before.path_words, planner.path_mode):
        if chain.requests[0].step.before.modes["motion"] != "rapid":
            head.append(f"G4 {settings.dialect.dwell_word}0")
        head.append(planner.path_mode)
        tail.append(before.path_words or planner.usual_path_mode)
    return head, tail


def _smoothed(trace: Trace, chains: Sequence[Chain], settings: Settings) -> Iterator[Diagnostic]:
    """A warning where the program smooths and the profile does not say how that is switched off."""
    for chain in chains:
        words = chain.before.smooth_words
        if settings.planner.smoothing_off or not words or _OFF.search(words):
            continue
        message = f"smoothing or look-ahead ({words}) is active and may round the oscillation away"
        help_text = "switch it off before the cut, or give planner.smoothing_off and smoothing_on"
        yield trace.program.diagnose(chain.first, SMOOTHED, message, help_text, severity=Severity.WARNING)


def _is_same_mode(one: str, other: str) -> bool:
    """``G05.1Q0`` is ``G5.1 Q0``."""
    plain = [re.sub(r"(?<=[A-Z])0+(?=[0-9])", "", text.upper()).replace(" ", "") for text in (one, other)]
    return plain[0] == plain[1]


def _speed_back(change: SpeedChange, trace: Trace, settings: Settings) -> Edit:
    reason = "the programmed spindle speed comes back before the block that needs it"
    step = trace.step(change.line)
    # A cut must find the speed reached, a thread above all; the end of the program need not.
    waits = step.before.turns and not step.after.ended
    content = (change.text, *(_settling(settings) if waits else ()))
    return Edit(change.line, change.line, content, "SPEED AS PROGRAMMED", reason, VIBRATE)


def _check_motion_mode(trace: Trace, chain: Chain) -> None:
    """The expansion ends in G1; behind a chain that ends in an arc the next move must say its own code."""
    last_kind = chain.requests[-1].step.after.modes["motion"]
    if last_kind == "line":
        return
    for step in trace.steps(chain.last, trace.program.source.body.stop):
        if step.move is None:
            continue
        if not codes_of(step.block, "motion", trace.settings.dialect):
            line = step.block.line + 1
            message = f"line {line} goes on as an arc without saying G2 or G3, but this cut will end in G1"
            raise RefusalError("VIB056", message, f"write the motion code in line {line}")
        return
