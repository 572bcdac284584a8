"""The edit of one vibrated cut: comments, words that act first, speed, modes, moves, modes given back."""

from __future__ import annotations

import re
from dataclasses import dataclass

from chipbreak.editing.edits import Edit, MoveTable
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.vibration.blocks import Expansion, moves_of
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.plan import CutPlan, plan_cut
from chipbreak.vibration.speeds import speed_words

VIBRATE = "vibrate"  # the pass that these edits belong to


@dataclass(frozen=True, eq=False)
class PlannedCut:
    """A vibrated cut, its blocks, and the edit that puts them into the program."""

    plan: CutPlan
    expansion: Expansion
    edit: Edit


def planned_cut(chain: Chain, interpreted: InterpretedProgram, settings: Settings) -> PlannedCut:
    """One cut on its own, with its speed said; for trying what would work.  Errors: RefusalError."""
    cut = plan_cut(chain, settings)
    made = moves_of(cut, settings)
    speed = speed_words(None, ("rpm", cut.solution.speed_rpm), settings)
    return PlannedCut(cut, made, expansion_edit(cut, made.content, speed, interpreted, settings))


def expansion_edit(
    cut: CutPlan,
    moves: tuple[str | MoveTable, ...],
    speed: str,
    interpreted: InterpretedProgram,
    settings: Settings,
) -> Edit:
    """The edit of one cut: comments kept, words that act first, speed, feed mode, moves, modes given back."""
    chain = cut.chain
    comments = [
        interpreted.program.block(line).text
        for line in range(chain.first, chain.last)
        if interpreted.program.block(line).is_empty and interpreted.program.block(line).comments
    ]
    was = chain.before.modes.feed_mode
    mode = was if cut.keeps_feed else settings.output.feed_mode
    head = [*comments, chain.preamble(), speed]
    head += settling(settings) if speed else []
    feed_back = f"F{chain.after.feed.text}" if chain.after.feed else ""
    if mode != was:
        like = {n for s in interpreted.effects for n in codes_of(s.block, "feed_mode", settings.dialect)}
        head.append(settings.dialect.code("feed_mode", mode, like))
        feed_back = f"{settings.dialect.code('feed_mode', was, like)} {feed_back}"
    feed_stands = cut.keeps_feed or cut.wave.end_revolutions > 0.0
    tail = [] if mode == was and feed_stands else [feed_back]
    switched, given_back = _modes_around(chain, settings)
    head += switched
    tail += given_back
    solution = cut.solution
    title = (
        f"VIB N{print_number(solution.per_rev, 4, point=False)}"
        f" F{print_number(solution.frequency_hz, 3, point=False)}"
        f" S{print_number(solution.speed_rpm, 3, point=False)}"
        f" {'DWELL' if cut.keeps_feed else f'STROKE {print_number(cut.wave.stroke_mm, 4)}'}"
    )
    reason = "; ".join(cut.reasons) or "nothing to correct"
    content = (*(text for text in head if text), *moves, *tail)
    return Edit(chain.first, chain.last, content, title, reason, VIBRATE)


def settling(settings: Settings) -> list[str]:
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
        if chain.requests[0].effect.before.modes.motion != "rapid":
            head.append(f"G4 {settings.dialect.dwell_word}0")
        head.append(planner.path_mode)
        tail.append(before.path_words or planner.usual_path_mode)
    return head, tail


def _is_same_mode(one: str, other: str) -> bool:
    """``G05.1Q0`` is ``G5.1 Q0``."""
    plain = [re.sub(r"(?<=[A-Z])0+(?=[0-9])", "", text.upper()).replace(" ", "") for text in (one, other)]
    return plain[0] == plain[1]
