"""The edit of one vibrated cut: comments, words that act first, speed, modes, moves, modes given back."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from chipbreak.dialects.path_mode import path_mode_in
from chipbreak.editing.edits import Edit, MoveTable
from chipbreak.editing.promise import Promise, Written
from chipbreak.editing.restore import Region
from chipbreak.model.giving_back import feed_blocks, path_mode_blocks
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.settings.sections import Settings
from chipbreak.syntax.comments import acting_comments
from chipbreak.syntax.numbers import print_number
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.blocks import Expansion
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.dwell import dwell_block
from chipbreak.vibration.measure import CutMotion, CutReport, measure_cut, measured_motion
from chipbreak.vibration.plan import CutPlan

_OVERRIDES = (48.0, 49.0, 50.0, 51.0, 52.0, 53.0)  # M codes that switch overrides


class Step(NamedTuple):
    """One vibrated cut with its blocks, and the words that command its speed, empty where it has it."""

    plan: CutPlan
    expansion: Expansion
    speed: str


class Overrides(NamedTuple):
    """The blocks that hold the overrides in a cut, and those that give them back."""

    held: Sequence[str] = ()
    given_back: Sequence[str] = ()


def overrides_of(interpreted: InterpretedProgram) -> Overrides:
    """Those of the profile; none in a program that switches overrides itself."""
    planner = interpreted.settings.planner
    if not any(planner.override_off):
        return Overrides()
    words = (word for effect in interpreted.effects for word in effect.block.words_of("M"))
    is_own = any(word.number in _OVERRIDES for word in words)
    return Overrides() if is_own else Overrides(planner.override_off, planner.override_on)


def feed_codes_of(interpreted: InterpretedProgram) -> frozenset[int]:
    """The codes with which a program switches its feed mode."""
    dialect = interpreted.settings.dialect
    return frozenset(n for e in interpreted.effects for n in codes_of(e.block, "feed_mode", dialect))


class VibratedCut(Promise, kw_only=True):
    """The blocks of the edit run these plans: along their paths, in their times, at their spindle speeds.

    ``lines`` are the blocks of each in the edit, from ``first`` to ``last`` (exclusive), from the first line
    behind the brackets on; a single cut has them all.  ``holds_override``: the operator's overrides do not
    count in them.
    """

    cuts: tuple[tuple[CutPlan, Expansion], ...]
    lines: tuple[tuple[int, int], ...] = ()
    leaves_speed: bool = True
    holds_override: bool = False

    def check(self, written: Written) -> tuple[CutReport, ...]:
        """Measure the cuts as the output commands them, and judge their chips."""
        reports = (measure_cut(written.result, where, *cut) for cut, where in self._each(written))
        return tuple(replace(report, holds_override=self.holds_override) for report in reports)

    def motions(self, written: Written) -> Iterator[CutMotion]:
        """The cuts in time, as the output commands them."""
        for cut, where in self._each(written):
            yield measured_motion(written.result, where, *cut)

    def _each(self, written: Written) -> Iterator[tuple[tuple[CutPlan, Expansion], Region]]:
        whole = written.region
        if not self.lines:
            yield self.cuts[0], whole
            return
        for cut, (first, last) in zip(self.cuts, self.lines, strict=True):
            yield cut, whole._replace(body=whole.body + first, last=whole.body + last)


def cut_edit(
    steps: Sequence[Step],
    interpreted: InterpretedProgram,
    overrides: Overrides,
    feed_codes: Collection[int],
) -> Edit:
    """The edit of one cut, or of the steps in which it vibrates; ``overrides`` stand around it.

    ``feed_codes`` are those of the program, whose like is written.
    """
    settings = interpreted.settings
    first = steps[0].plan.chain
    last = steps[-1].plan.chain
    switched, given_back = _modes_around(steps[0], settings)
    feed_mode, feed_back = _feed_modes(steps[-1].plan, settings, feed_codes)
    comments = [text for step in steps for text in _comments(step.plan.chain, interpreted)]
    head = [
        *dict.fromkeys(comments),
        first.preamble(),
        *overrides.held,  # before the speed, which then has its time to settle
        *_speed(steps[0], settings),
        feed_mode,
        *switched,
    ]
    content: list[str | MoveTable] = [text for text in head if text]
    lines = []
    for step in steps:
        content += _speed(step, settings) if step is not steps[0] else []
        begin = _line_count(content)
        content += step.expansion.content
        lines.append((begin, _line_count(content)))
    content += [text for text in (*feed_back, *given_back, *overrides.given_back) if text]
    reason = "; ".join(part for step in steps for part in step.plan.reasons) or "nothing to correct"
    promise = VibratedCut(
        cuts=tuple((step.plan, step.expansion) for step in steps),
        lines=tuple(lines) if len(steps) > 1 else (),
        leaves_motion=last.after.modes.motion != "line",
        holds_override=any(overrides.held),
    )
    return Edit(first.first, last.last, tuple(content), _title(steps), reason, promise)


def _speed(step: Step, settings: Settings) -> list[str]:
    """The speed of a step, and the time to reach it."""
    return [step.speed, *settling(settings)] if step.speed else []


def _line_count(content: Sequence[str | MoveTable]) -> int:
    """How many lines of a program that is."""
    return sum(1 if isinstance(one, str) else len(one) * (2 if one.behind else 1) for one in content)


def _comments(chain: Chain, interpreted: InterpretedProgram) -> list[str]:
    """The comments between the blocks of a chain stay, and those of its first block that do something."""
    blocks = map(interpreted.program.block, range(chain.first, chain.last))
    between = [block.text for block in blocks if block.is_empty and block.comments]
    return [acting_comments(chain.requests[0].effect.block), *between]


def _feed_modes(plan: CutPlan, settings: Settings, like: Collection[int]) -> tuple[str, list[str]]:
    """The feed mode of the moves where it is another, and the blocks that give the programmed feed back."""
    chain = plan.chain
    dialect = settings.dialect
    was = chain.before.modes.feed_mode
    mode = plan.expander.feed_mode(was, settings.output.feed_mode)
    feed = feed_blocks(chain.after, dialect)
    if mode != was:
        back = dialect.code("feed_mode", was, like)
        return dialect.code("feed_mode", mode, like), [" ".join([back, *feed[:1]]), *feed[1:]]
    if len(feed) < 2 and plan.expander.ends_at_programmed_feed(plan.wave):
        return "", []
    code = "G1 " if dialect.repeats_codes else ""
    return "", [code + text for text in feed]


def _title(steps: Sequence[Step]) -> str:
    """``VIB N1.5 F62.5 S2500 STROKE 0.04``; of the first step where there are several."""
    plan = steps[0].plan
    solution = plan.solution
    words = (("N", solution.per_rev, 4), ("F", solution.frequency_hz, 3), ("S", solution.speed_rpm, 3))
    said = [f"{letter}{print_number(value, decimals, point=False)}" for letter, value, decimals in words]
    title = " ".join(["VIB", *said, plan.expander.title(plan.wave)])
    return title if len(steps) == 1 else f"{title} FIRST OF {len(steps)}"


def settling(settings: Settings) -> list[str]:
    """The dwell in which the spindle reaches a new speed."""
    if settings.spindle.settle_s <= 0.0:
        return []
    return [dwell_block(settings.spindle.settle_s, settings.dialect)]


def _modes_around(step: Step, settings: Settings) -> tuple[list[str], list[str]]:
    """Path mode and smoothing for the cut, and what the program had, to be given back.

    A straight oscillation is collinear: a path mode that blends, or a smoothing, may round it away.  It would
    also round the corner from a cut before this one, unless the tool rests there.
    """
    planner = settings.planner
    before = step.plan.chain.before
    from_stand = step.expansion.from_stand
    head = list[str]()
    tail = list[str]()
    if planner.smoothing_off and not _is_same_mode(before.smooth_words, planner.smoothing_off):
        head.append(planner.smoothing_off)
        tail.append(before.smooth_words or planner.smoothing_on)
    path_mode, usual_path_mode = (
        path_mode_in(words, "mm", before.modes.units)
        for words in (planner.path_mode, planner.usual_path_mode)
    )
    own = path_mode_blocks(before, settings.dialect)
    if path_mode and not (len(own) == 1 and _is_same_mode(own[0], path_mode)):
        from_stand |= step.plan.chain.requests[0].effect.before.modes.motion != "rapid"
        tail += own or [usual_path_mode]
    else:
        path_mode = ""
    stand = f"G4 {settings.dialect.dwell_word}0" if from_stand else ""
    return [*head, *filter(None, (stand, path_mode))], tail


def _is_same_mode(one: str, other: str) -> bool:
    """``G05.1Q0`` is ``G5.1 Q0``."""
    plain = [re.sub(r"(?<=[A-Z])0+(?=[0-9])", "", text.upper()).replace(" ", "") for text in (one, other)]
    return plain[0] == plain[1]
