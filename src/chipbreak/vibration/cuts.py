"""All vibrated cuts of a program: planned, made into blocks, and put into edits with their spindle speeds."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import SpeedGivenBack
from chipbreak.kinematics.sourced_value import shown
from chipbreak.kinematics.toolpath import BAD_ARC, path_of
from chipbreak.kinematics.waveform import TOO_SHORT
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import settles_motion
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.advice import tried, untried, with_advice
from chipbreak.vibration.beginning import failure_of
from chipbreak.vibration.blocks import Expansion, moves_of
from chipbreak.vibration.called import in_called_programs, not_followed
from chipbreak.vibration.chain import Chain, chains_of, legs_of
from chipbreak.vibration.choice import NOTHING_FITS, Chooser, is_open
from chipbreak.vibration.cut_edit import Step, cut_edit, feed_codes_of, overrides_of, settling
from chipbreak.vibration.diameter_steps import diameter_steps
from chipbreak.vibration.fails_alike import FailsAlike
from chipbreak.vibration.findings import first_error
from chipbreak.vibration.judged import Judged
from chipbreak.vibration.large_changes import refuse_beyond_any_machine
from chipbreak.vibration.left_cut import LeftCut
from chipbreak.vibration.look_ahead_feed import without_look_ahead
from chipbreak.vibration.loop_names import LoopNames, free_names
from chipbreak.vibration.machine import law_of
from chipbreak.vibration.plan import MOST_MOVES_IN_ALL, TOO_MANY, CutPlan, plan_cut
from chipbreak.vibration.request import Request
from chipbreak.vibration.shared_spindle import shared_spindle
from chipbreak.vibration.speeds import SpeedChange, UnknownSpeedError, speed_changes
from chipbreak.vibration.spindle_encoder import needs_encoder
from chipbreak.vibration.try_cost import cost_of

NOT_TRIED = "VIB098"
_MOST_BEHIND = 200  # cuts are tried behind a refused one
_MOST_DEAR_BEHIND = 20  # the same where strokes that are hardly alike are run through one by one
_MOST_COST_BEHIND = 600_000  # of the blocks of all these cuts, as one that is tried costs
_MOST_REFUSED = 20  # are said: to mend them is enough for one go
_MOST_ADVISED = 3  # what works is tried for the first refused cuts; the others fail alike
SMOOTHED = "VIB063"
_OFF = re.compile(r"[PQ]\s*0\b")
_WIDENINGS = (1.0, 1.5, 2.5)  # of the steps of a cut, where shorter ones cannot be planned
_NO_KNOTS = np.empty(0)
NONE_GIVEN_UP: Mapping[int, Diagnostic] = FrozenTable({})
_NO_REASONS: Mapping[int, RefusalError] = FrozenTable({})


class Cuts(NamedTuple):
    """The edits of every vibrated cut, what is to be said, and the cuts that stay as they are."""

    edits: list[Edit]
    diagnostics: list[Diagnostic]
    left: list[LeftCut]


def edits_of_cuts(
    interpreted: InterpretedProgram,
    requests: Sequence[Request],
    *,
    restarted_at: Collection[int] = (),
    air_lines: Collection[int] = (),
    given_up: Mapping[int, Diagnostic] = NONE_GIVEN_UP,
    allow_unbroken: bool = False,
    reasons: Mapping[int, RefusalError] = _NO_REASONS,
    is_refused: bool = False,
) -> Cuts:
    """The edits of every vibrated cut.  Errors are diagnostics; with one, there are no edits.

    ``restarted_at`` are the lines before which an edit starts the spindle as programmed; ``air_lines`` those
    of moves that do not depend on its speed.  ``given_up`` are cuts, by their first line, that were tried and
    stay as they are.
    ``allow_unbroken``: cuts too short to vibrate stay as they are, with a warning, where no word of theirs
    asks for vibration (it would reach the control).  ``reasons``: why cuts, by their line, stay under
    nose compensation, or why corners there are not drawn.  ``is_refused``: the program is, whatever its cuts
    are, so only the first of them are tried.
    """
    up = dict(given_up)
    around = _Around(restarted_at, air_lines, allow_unbroken, reasons, is_refused)
    while True:  # each round gives up one cut more
        found = _tried(interpreted, requests, around, up)
        if isinstance(found, Cuts):
            return found
        up |= found


class _Around(NamedTuple):
    """What :func:`edits_of_cuts` was told of the run."""

    restarted_at: Collection[int]
    air_lines: Collection[int]
    allow_unbroken: bool
    reasons: Mapping[int, RefusalError]
    is_refused: bool


def _tried(
    interpreted: InterpretedProgram,
    requests: Sequence[Request],
    around: _Around,
    given_up: Mapping[int, Diagnostic],
) -> Cuts | dict[int, Diagnostic]:
    """The edits; or, by its first line, a cut that must be given up for the spindle speed behind it."""
    chains, left, refused = chains_of(interpreted, requests, around.reasons)
    try:
        names = free_names(interpreted.program, interpreted.settings) if chains else None
    except RefusalError as error:
        return _without_loops(interpreted, chains, left, refused, error)
    advised = _MOST_ADVISED - len(refused)
    maker = _Maker(interpreted, Chooser(interpreted.settings), given_up, advised, around.allow_unbroken)
    made = _made(maker, chains, names, around, is_refused=around.is_refused or bool(refused))
    refused += made.refused
    left += made.left
    if refused:
        # A refused cut leaves the speeds around it open: nothing more can be said honestly.
        return Cuts([], sorted(refused, key=_by_line), left)
    plans = [plan for plan, _ in made.cuts]
    try:
        changes = speed_changes(
            interpreted, plans, interpreted.settings, around.restarted_at, around.air_lines
        )
    except UnknownSpeedError as error:
        chain = next(plan.chain for plan in plans if plan.chain.first == error.first)
        said = _at_chain(interpreted, chain, error)
        may_be_left = chain.may_be_left(interpreted.settings.vibration.refused)
        return {error.first: said} if may_be_left else Cuts([], [said], left)
    edits = _edits(interpreted, made.cuts, changes)
    warnings = [*made.warnings, *_smoothed(interpreted, [plan.chain for plan in plans])]
    warnings += [*shared_spindle(interpreted, plans), *needs_encoder(interpreted, plans)]
    warnings += without_look_ahead(interpreted, plans)
    chains = [plan.chain for plan in plans]
    warnings += [*not_followed(interpreted, chains), *in_called_programs(interpreted, chains)]
    return Cuts(edits, warnings, left)


def _edits(
    interpreted: InterpretedProgram,
    cuts: Sequence[tuple[CutPlan, Expansion]],
    changes: Sequence[SpeedChange],
) -> list[Edit]:
    """An edit for every cut, and for every place where the programmed speed comes back."""
    own = {id(change.for_cut): change.text for change in changes if change.for_cut is not None}
    steps: list[list[Step]] = []
    for plan, expansion in cuts:
        step = Step(plan, expansion, own.get(id(plan), ""))
        # The steps of one block are one edit.
        if steps and plan.chain.first < steps[-1][-1].plan.chain.last:
            steps[-1].append(step)
        else:
            steps.append([step])
    overrides = overrides_of(interpreted)
    feed_codes = feed_codes_of(interpreted)
    edits = [cut_edit(group, interpreted, overrides, feed_codes) for group in steps]
    return edits + [_speed_back(change, interpreted) for change in changes if change.for_cut is None]


def _without_loops(
    interpreted: InterpretedProgram,
    chains: Sequence[Chain],
    left: list[LeftCut],
    refused: list[Diagnostic],
    error: RefusalError,
) -> Cuts:
    """No cut can be a loop: those that may stay as they were do, and the first of the others is refused."""
    key = interpreted.settings.vibration.refused
    stay = [chain for chain in chains if chain.may_be_left(key)]
    left += [chain.left(_at_chain(interpreted, chain, error)) for chain in stay]
    others = [chain for chain in chains if chain not in stay]
    said = [_at_chain(interpreted, others[0], error)] if others else refused
    return Cuts([], said, left)


@dataclass(frozen=True)
class _Made:
    """What became of the chains: cuts with their blocks, errors, warnings, cuts that stay as they are."""

    cuts: list[tuple[CutPlan, Expansion]] = field(default_factory=list)
    refused: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    left: list[LeftCut] = field(default_factory=list)

    def give_up(self, chain: Chain, found: Diagnostic, refused: str, *, may_warn: bool) -> None:
        """A chain that cannot vibrate: a cut that stays as it was, a warning, or an error."""
        if chain.may_be_left(refused):
            self.left.append(chain.left(found))
        elif may_warn and found.code == TOO_SHORT and not chain.asked_by_word:
            self.warnings.append(found._replace(severity=Severity.WARNING))
        else:
            self.refused.append(found)


def _made(
    maker: _Maker, chains: Sequence[Chain], names: LoopNames | None, around: _Around, *, is_refused: bool
) -> _Made:
    """Plan every chain and make its blocks; where one ``is_refused``, only some of those behind it."""
    made = _Made()
    key = maker.interpreted.settings.vibration.refused
    waiting = list(reversed(chains))
    moves = 0
    behind = _Behind.of(maker.interpreted.settings)
    alike = FailsAlike(maker.interpreted, allow_unbroken=around.allow_unbroken)
    while waiting:
        chain = waiting.pop()
        behind = behind.with_one_more(is_behind=is_refused or bool(made.refused))
        if behind.is_enough or len(made.refused) + len(alike) >= _MOST_REFUSED:
            made.refused.extend([*alike.findings(), _not_tried(maker.interpreted, chain)])
            break
        if moves > MOST_MOVES_IN_ALL:
            said = _at_chain(maker.interpreted, chain, _too_many(moves))
            made.give_up(chain, said, key, may_warn=around.allow_unbroken)
            continue
        advise = len(made.refused) + len(made.left) < maker.advised
        try:
            cuts = maker.cuts(chain, names, advise=advise, most_cost=behind.most_cost)
        except _TooDearBehindError:
            made.refused.append(_not_tried(maker.interpreted, chain))
            break
        except RefusalError as error:
            waiting += reversed(_instead(maker, chain, error, made, around))
            continue
        alike.look_at(chain, cuts)
        made.cuts.extend(map(_without_knots, cuts))
        moves += sum(len(expansion.distance_mm) for _, expansion in cuts)
        behind = behind.with_cuts([plan for plan, _ in cuts], maker.interpreted.settings)
        names = _behind(names, cuts)
    return made


def _instead(
    maker: _Maker, chain: Chain, error: RefusalError, made: _Made, around: _Around
) -> Sequence[Chain]:
    """What may be tried instead of a chain that is refused; where nothing may, it is given up."""
    blocks = _by_block(chain)
    if not blocks:
        said = maker.given_up_in(chain) or _at_chain(maker.interpreted, chain, error)
        key = maker.interpreted.settings.vibration.refused
        made.give_up(chain, said, key, may_warn=around.allow_unbroken)
    return blocks


class _TooDearBehindError(Exception):
    """A cut would cost more than any behind a refused one may."""


class _Behind(NamedTuple):
    """How many cuts behind a refused one were tried, and what they cost; ``most`` may be."""

    most: int
    cuts: int = 0
    cost: int = 0

    @classmethod
    def of(cls, settings: Settings) -> _Behind:
        """Before the first."""
        is_dear = law_of(settings).unlike_stroke_costs > 1
        return cls(_MOST_DEAR_BEHIND if is_dear else _MOST_BEHIND)

    @property
    def is_enough(self) -> bool:
        """True where no more are tried."""
        return self.cuts > self.most

    @property
    def most_cost(self) -> float:
        """What the next one may cost."""
        return math.inf if self.cuts == 0 else _MOST_COST_BEHIND - self.cost

    def with_one_more(self, *, is_behind: bool) -> _Behind:
        """One more is tried, behind a refused one or not."""
        return self._replace(cuts=self.cuts + is_behind)

    def with_cuts(self, plans: Sequence[CutPlan], settings: Settings) -> _Behind:
        """That one was made."""
        if self.cuts == 0:
            return self
        return self._replace(cost=self.cost + sum(cost_of(plan, settings) for plan in plans))


def _not_tried(interpreted: InterpretedProgram, chain: Chain) -> Diagnostic:
    message = "the cuts from here on were not tried: those before that are refused are enough for one go"
    way_out = "mend what is refused before, and run it again"
    line = chain.first
    return interpreted.program.diagnose(line, NOT_TRIED, message, way_out, severity=Severity.WARNING)


def _too_many(moves: int) -> RefusalError:
    message = f"the cuts before this one have {moves} blocks; {MOST_MOVES_IN_ALL} in all are the most"
    return RefusalError(
        TOO_MANY, message, "make it several programs, or let fewer of its cuts vibrate; is each feed right?"
    )


def _by_block(chain: Chain) -> list[Chain]:
    """Where the machine chooses, what is too much round a corner may do from block to block."""
    if not is_open(chain) or len(chain.requests) == 1:
        return []
    return [Chain((request,)) for request in chain.requests]


def _without_knots(cut: tuple[CutPlan, Expansion]) -> tuple[CutPlan, Expansion]:
    """A cut whose blocks are made: its knots have served, and a long program has many."""
    plan, expansion = cut
    return replace(plan, time_s=_NO_KNOTS, distance_mm=_NO_KNOTS), replace(expansion, printed=None)


def _behind(names: LoopNames | None, cuts: Sequence[tuple[CutPlan, Expansion]]) -> LoopNames | None:
    """The names that are left for the loops behind some cuts."""
    loops = sum(len(expansion.loops or ()) for _, expansion in cuts)
    return names.behind(loops) if names is not None else None


class _Maker(NamedTuple):
    """Makes the cuts of one run; what works instead is tried for the first ``advised`` that cannot be."""

    interpreted: InterpretedProgram
    chooser: Chooser
    given_up: Mapping[int, Diagnostic]
    advised: int
    allow_unbroken: bool

    def given_up_in(self, chain: Chain) -> Diagnostic | None:
        """Why a chain was tried and stays, or one of the steps in which it was to vibrate."""
        found = (self.given_up[line] for line in self.given_up if chain.first <= line < chain.last)
        return next(found, None)

    def cuts(
        self, chain: Chain, names: LoopNames | None, *, advise: bool, most_cost: float
    ) -> list[tuple[CutPlan, Expansion]]:
        """The cut of a chain, or those of its steps, with their blocks.

        Errors: RefusalError; _TooDearBehindError for one that would cost more than ``most_cost``.
        """
        said = self.given_up_in(chain)
        if said is not None:
            raise RefusalError(said.code, said.message, said.help)
        settings = self.interpreted.settings
        for widening in _WIDENINGS:
            steps = diameter_steps(chain, settings, is_open=is_open(chain), widening=widening)
            if len(steps) == 1:
                break
            try:
                return self._steps(steps, names, most_cost)
            except RefusalError:
                continue
        return [self._cut(chain, names, most_cost, advise=advise)]

    def _steps(
        self, steps: Sequence[Chain], names: LoopNames | None, most_cost: float
    ) -> list[tuple[CutPlan, Expansion]]:
        made = []
        for step in steps:
            made.append(self._cut(step, names, most_cost, advise=False))
            names = _behind(names, made[-1:])
        return made

    def _cut(
        self, chain: Chain, names: LoopNames | None, most_cost: float, *, advise: bool
    ) -> tuple[CutPlan, Expansion]:
        def make(one: Chain) -> tuple[CutPlan, Expansion]:
            is_asked = advise and one is chain
            plan = _plan(one, self.interpreted.settings, advise=is_asked)
            _check_motion_mode(self.interpreted, one)
            if most_cost < math.inf and cost_of(plan, self.interpreted.settings) > most_cost:
                raise _TooDearBehindError
            if one.may_be_left(self.interpreted.settings.vibration.refused):
                refuse_beyond_any_machine(plan.wave)
            self._refuse_soon(plan, names, advise=is_asked)
            return plan, _expand(plan, self.interpreted.settings, names, advise=is_asked)

        is_chosen = is_open(chain)
        return self.chooser.cut(chain, make, advise=advise) if is_chosen else make(chain)

    def _refuse_soon(self, plan: CutPlan, names: LoopNames | None, *, advise: bool) -> None:
        """Refuse a long cut for what its beginning shows, before all of it is made.  Errors: RefusalError."""
        settings = self.interpreted.settings
        failure = failure_of(plan, settings, names)
        if isinstance(failure, RefusalError):
            raise with_advice(failure, plan, settings) if advise else untried(failure)
        if failure is None:
            return
        if is_open(plan.chain):
            raise RefusalError(NOTHING_FITS, "it fails from its beginning on", "give N, f and S")
        said = first_error(Judged(self.interpreted, (), failure, self.allow_unbroken, advise))
        if said is not None:
            seen = f"{said.message}; seen in its first {shown(round(failure.plan.path.length_mm, 1))} mm"
            raise RefusalError(said.code, seen, said.help)


def _plan(chain: Chain, settings: Settings, *, advise: bool) -> CutPlan:
    """Errors: RefusalError, whose help names no number that was not tried, but for what the machine chose."""
    try:
        return plan_cut(chain, settings)
    except RefusalError as error:
        raise (tried(error, chain, settings) if advise else untried(error)) from None


def _expand(plan: CutPlan, settings: Settings, names: LoopNames | None, *, advise: bool) -> Expansion:
    try:
        return moves_of(plan, settings, names)
    except RefusalError as error:
        raise (with_advice(error, plan, settings) if advise else untried(error)) from None


def _by_line(diagnostic: Diagnostic) -> int:
    return diagnostic.place.line if diagnostic.place else 0


def _at_chain(interpreted: InterpretedProgram, chain: Chain, error: RefusalError) -> Diagnostic:
    effect = chain.requests[_at_fault(chain, error)].effect
    words = effect.vibration
    at = (words[0].start, words[-1].end) if words else None
    said = (error.code, error.message, error.help)
    instead = tuple(_with_word(effect.block, words, one) for one in error.instead) if words else ()
    return interpreted.program.diagnose(effect.block.line, *said, at=at, instead=instead)


def _with_word(block: Block, words: Sequence[Word], word: str) -> str:
    """The text of some words with another one: in the place of its letter, or behind them."""
    first, last = words[0].start, words[-1].end
    old = next((one for one in words if one.letter == word[0]), None)
    if old is None:
        return f"{block.text[first:last]} {word}"
    return f"{block.text[first : old.start]}{word}{block.text[old.end : last]}"


def _at_fault(chain: Chain, error: RefusalError) -> int:
    """Which block of a chain: the arc that cannot be, of anything else the first."""
    if error.code != BAD_ARC:
        return 0
    for index, leg in enumerate(legs_of(chain)):
        try:
            path_of([leg])
        except RefusalError as alone:
            if alone.code == BAD_ARC:
                return index
    return 0


def _smoothed(interpreted: InterpretedProgram, chains: Sequence[Chain]) -> Iterator[Diagnostic]:
    """A warning where the program smooths and the profile does not say how that is switched off."""
    for chain in chains:
        words = chain.before.smooth_words
        if interpreted.settings.planner.smoothing_off or not words or _OFF.search(words):
            continue
        message = f"smoothing or look-ahead ({words}) is active and may round the oscillation away"
        help_text = "switch it off before the cut, or give planner.smoothing_off and smoothing_on"
        yield interpreted.program.diagnose(
            chain.first, SMOOTHED, message, help_text, severity=Severity.WARNING
        )


def _speed_back(change: SpeedChange, interpreted: InterpretedProgram) -> Edit:
    reason = "the programmed spindle speed comes back before the block that needs it"
    is_last = change.line >= interpreted.program.source.body.stop  # a program need not say its end
    effect = None if is_last else interpreted.effect(change.line)
    # A cut must find the speed reached, a thread above all; the end of the program need not.
    waits = effect is not None and effect.before.turns and not effect.after.ended
    content = (*change.blocks, *(settling(interpreted.settings) if waits else ()))
    return Edit(change.line, change.line, content, "SPEED AS PROGRAMMED", reason, SpeedGivenBack())


def _check_motion_mode(interpreted: InterpretedProgram, chain: Chain) -> None:
    """The expansion ends in G1; behind a chain that ends in an arc the next move must say its own code."""
    if chain.after.modes.motion == "line":
        return
    behind = interpreted.effects_of(chain.last, interpreted.program.source.body.stop)
    own = (one for one in behind if one.after.path == chain.after.path and not one.in_contour)
    dialect = interpreted.settings.dialect
    # A canned cycle has a code of its own, and behind its G80 the one from before it may be in force again.
    decides = (one for one in own if one.move is not None or settles_motion(one.block, dialect))
    effect = next((one for one in decides if one.after.modes.motion != "cycle"), None)
    if effect is not None and not settles_motion(effect.block, dialect):
        line = interpreted.program.source.place(effect.block.line).line
        message = f"line {line} goes on as an arc without saying G2 or G3, but this cut will end in G1"
        raise RefusalError("VIB056", message, f"write the motion code in line {line}")
