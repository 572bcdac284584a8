"""The edit of one vibrated cut: comments, words that act first, speed, modes, moves, modes given back."""

from __future__ import annotations

import re

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import Promise, Written
from chipbreak.model.giving_back import feed_text
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.vibration.blocks import Expansion
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.dwell import dwell_block
from chipbreak.vibration.measure import CutMotion, CutReport, measure_cut, measured_motion
from chipbreak.vibration.plan import CutPlan


class VibratedCut(Promise, kw_only=True):
    """The blocks of the edit run this plan: along its path, in its time, at its spindle speed."""

    plan: CutPlan
    expansion: Expansion
    leaves_speed: bool = True

    def check(self, written: Written) -> CutReport:
        """Measure the cut as the output commands it, and judge its chips."""
        return measure_cut(written.result, written.region, self.plan, self.expansion)

    def motion(self, written: Written) -> CutMotion:
        """The cut in time, as the output commands it."""
        return measured_motion(written.result, written.region, self.plan, self.expansion)


def cut_edit(plan: CutPlan, expansion: Expansion, speed: str, interpreted: InterpretedProgram) -> Edit:
    """The edit of one cut; ``speed`` are the words that command its spindle speed, empty where it has it."""
    settings = interpreted.settings
    chain = plan.chain
    switched, given_back = _modes_around(chain, settings)
    feed_mode, feed_back = _feed_modes(plan, interpreted)
    settle = settling(settings) if speed else []
    head = [*_comments(chain, interpreted), chain.preamble(), speed, *settle, feed_mode, *switched]
    tail = [*feed_back, *given_back]
    content = (*(text for text in head if text), *expansion.content, *(text for text in tail if text))
    reason = "; ".join(plan.reasons) or "nothing to correct"
    ends_in_line = chain.after.modes.motion == "line"
    promise = VibratedCut(plan=plan, expansion=expansion, leaves_motion=not ends_in_line)
    return Edit(chain.first, chain.last, content, _title(plan), reason, promise)


def _comments(chain: Chain, interpreted: InterpretedProgram) -> list[str]:
    """The comments between the blocks of a chain stay."""
    blocks = map(interpreted.program.block, range(chain.first, chain.last))
    return [block.text for block in blocks if block.is_empty and block.comments]


def _feed_modes(plan: CutPlan, interpreted: InterpretedProgram) -> tuple[str, list[str]]:
    """The feed mode of the moves where it is another, and the blocks that give the programmed feed back."""
    chain = plan.chain
    dialect = interpreted.settings.dialect
    was = chain.before.modes.feed_mode
    mode = plan.expander.feed_mode(was, interpreted.settings.output.feed_mode)
    feed = f"F{feed_text(chain.after)}" if chain.after.feed else ""
    if mode != was:
        like = {n for e in interpreted.effects for n in codes_of(e.block, "feed_mode", dialect)}
        return dialect.code("feed_mode", mode, like), [f"{dialect.code('feed_mode', was, like)} {feed}"]
    code = "G1 " if dialect.repeats_codes else ""
    return "", [] if plan.expander.ends_at_programmed_feed(plan.wave) else [code + feed]


def _title(plan: CutPlan) -> str:
    """``VIB N1.5 F62.5 S2500 STROKE 0.04``."""
    solution = plan.solution
    words = (("N", solution.per_rev, 4), ("F", solution.frequency_hz, 3), ("S", solution.speed_rpm, 3))
    said = [f"{letter}{print_number(value, decimals, point=False)}" for letter, value, decimals in words]
    return " ".join(["VIB", *said, plan.expander.title(plan.wave)])


def settling(settings: Settings) -> list[str]:
    """The dwell in which the spindle reaches a new speed."""
    if settings.spindle.settle_s <= 0.0:
        return []
    return [dwell_block(settings.spindle.settle_s, settings.dialect)]


def _modes_around(chain: Chain, settings: Settings) -> tuple[list[str], list[str]]:
    """Path mode and smoothing for the cut, and what the program had, to be given back.

    A straight oscillation is collinear: a path mode that blends, or a smoothing, may round it away.  It would
    also round the corner from a cut before this one, unless the tool rests there.
    """
    planner = settings.planner
    before = chain.before
    head = list[str]()
    tail = list[str]()
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
