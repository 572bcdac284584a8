"""Run the pass as the filter does, and look at what comes out with two oracles.

``same_states`` interprets the result with the project's own interpreter.  ``same_cuts`` is a machine of
wood: it knows nothing of borders, drives both programs with real coordinates on a made-up machine, and
compares where the tool cuts and comes down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from chipbreak import settings
from chipbreak.editing import restore
from chipbreak.editing.edits import Edit
from chipbreak.editing.render import render
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.words import codes_of, is_diameter, plain_value
from chipbreak.operations.kinds import KindRules
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import Operation, operations_of
from chipbreak.passes.base import Context
from chipbreak.passes.check_tools import CheckTools
from chipbreak.settings import Settings
from chipbreak.syntax.nodes import Word
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import Diagnostic
from chipbreak.text.source import read
from chipbreak.tools.data import ToolData
from chipbreak.tools.merge import ToolTable

AXES = "XYZ"
# One short block a call: what the built-in calls say is not what these tests look at.
SHORT_CALLS = {
    "fanuc": 'calls.short={calibrate="G65 P9810", tool_check="G65 P9811 T{tool} S{speed_rpm}", '
    'trace="G65 P9812 T{tool} Z{height}", chip_check="G65 P9813 T{tool} W{limit}"}',
    "linuxcnc": 'calls.short={calibrate="o<cb_calibrate> call", trace="o<cb_trace> call [{tool}]", '
    'tool_check="o<cb_tool_check> call [{tool}] [{speed_rpm}]", '
    'chip_check="o<cb_chip_check> call [{tool}] [{limit}]"}',
}
TOP = 9000.0  # nothing is higher, unless a made-up program says so


@dataclass(frozen=True)
class Filtered:
    """A program before and after the pass."""

    settings: Settings
    data: bytes
    output: bytes
    interpreted: InterpretedProgram
    operations: list[Operation]
    edits: list[Edit]
    diagnostics: list[Diagnostic]

    @property
    def titles(self) -> list[str]:
        return [edit.title for edit in self.edits]

    @property
    def codes(self) -> list[str]:
        return [d.code for d in self.diagnostics]


class EveryTool(ToolTable):
    """Whatever tool is asked for, all that a check needs is known about it."""

    def get(self, number: int) -> ToolData:
        return ToolData(number, "flat end mill", 4, 10.0, 40.0, 0.0, 30.0, holder_mm=60.0)


def traced(data: bytes, rules: Settings) -> InterpretedProgram:
    return interpret(parse(read(data, "program.nc"), rules.dialect), rules)


def filtered(data: bytes, profile: str = "fanuc-mill", *options: str) -> Filtered:
    """The program with its checks; all is known of its tools."""
    calls = SHORT_CALLS[profile.partition("-")[0]]
    if profile.endswith("lathe"):  # where S turns the workpiece
        calls = calls.replace(" S{speed_rpm}", "").replace(" [{speed_rpm}]", "")
    short = (calls, "checks.calls=short")
    rules = settings.load(profile, (*short, *options))
    interpreted = traced(data, rules)
    main = main_program(interpreted)
    operations = operations_of(interpreted, main, KindRules.from_profile(rules.operations))
    planned = CheckTools().plan(Context(interpreted, main, operations, lambda: EveryTool({}, ())))
    edits = planned.edits
    diagnostics = planned.diagnostics
    output = b"".join(render(interpreted.program, edits, rules))
    return Filtered(rules, data, output, interpreted, operations, list(edits), list(diagnostics))


def pairs(result: Filtered) -> list[tuple[BlockEffect, BlockEffect | None]]:
    """Every step of the result: with the original step of its line, or None inside an insertion."""
    after = traced(result.output, result.settings)
    inserted = {n for r in restore.regions(after.program.source) for n in range(r.first, r.last)}
    before = result.interpreted
    body = before.program.source.body
    originals = iter(before.effects_of(body.start, body.stop))
    body = after.program.source.body
    effects_of = after.effects_of(body.start, body.stop)
    paired = [(s, None if s.block.line in inserted else next(originals)) for s in effects_of]
    assert next(originals, None) is None
    return paired


def check(result: Filtered) -> None:
    """All that must hold of any result."""
    assert restored(result.output) == result.data
    for edit in result.edits:
        for text in edit.content:
            assert isinstance(text, str)
            assert len(text) <= min(80, result.settings.control.max_line_chars)
    output = read(result.output)
    for region in restore.regions(output):  # with the comments around it
        assert all(len(output.text(line)) <= 80 for line in range(region.first, region.last))
    paired = pairs(result)
    same_states(paired)
    if not result.settings.dialect.is_lathe:  # a lathe comes down slanting from wherever it is
        shipped = result.settings.dialect.call_sets.get(
            result.settings.checks.calls
        )  # none of the shop's own
        ends = shipped is not None and shipped.ends_offset
        for home_ends in (True, False):
            same_cuts(paired, result.settings, home_ends=home_ends, calls_end=ends)


def restored(data: bytes) -> bytes:
    return restore.restore(read(data)).data


def same_states(paired: list[tuple[BlockEffect, BlockEffect | None]]) -> None:
    """At every block the control is in the state of the original, and cuts start where they did."""
    for new, old in paired:
        if old is not None:
            _same_state(new, old)
            _same_start(new, old)


def _same_state(new: BlockEffect, old: BlockEffect) -> None:
    where = old.block.text
    assert new.block.text == where
    one, other = old.before, new.before
    assert one.modes == other.modes, where
    # What the program says itself before the spindle or coolant is of use need not be given back.
    used = ("spindle", "coolant") if _uses_spindle(old) else ()
    for name in (*used, "tool", "ended"):
        assert getattr(one, name) == getattr(other, name), (name, where)
    for name in ("speed", "feed", "speed_limit"):
        a, b = (getattr(state, name) for state in (one, other))
        assert (a and a.text) == (b and b.text), (name, where)


def _uses_spindle(effect: BlockEffect) -> bool:
    """True for a block that moves the tool near the work, or hands the machine to somebody else."""
    waits_behind = effect.does("spindle") and effect.non_modal == {"dwell"}
    if (effect.move is not None or effect.non_modal) and not waits_behind:
        return not _goes_by_machine(effect)
    hands_over = any(effect.does(group) for group in ("stop", "tool", "subprogram"))
    return hands_over or bool(effect.block.controls or effect.block.opaque or effect.block.has("T"))


def _same_start(new: BlockEffect, old: BlockEffect) -> None:
    """A cut starts where it did."""
    where = old.block.text
    if old.move is None or old.move.kind == "rapid":
        return
    for now, was in zip(new.before.position, old.before.position, strict=True):
        assert math.isnan(was) or _equal(now, was), f"begins elsewhere: {where}"
    assert new.move is not None and new.move.kind == old.move.kind, where


# Where the axes are before and after a block.
Way = tuple[dict[str, float], dict[str, float]]
_HOME = {"X": -400.0, "Y": 300.0, "Z": TOP}


@dataclass
class Machine:
    """Where the axes really are, in program coordinates; far-off places stand for home and the changer.

    Controls differ in whether a reference return of Z ends the length offset.
    """

    settings: Settings
    home_ends_offset: bool
    at: dict[str, float] = field(default_factory=lambda: {"X": -311.0, "Y": 287.0, "Z": TOP})
    offset_is_in_force: bool = False

    def run(self, effect: BlockEffect, *, in_call: bool, ends_offset: bool = False) -> Way:
        """Start and end of what a block does."""
        start = dict(self.at)
        self._switch_offset(effect, ends_offset=ends_offset)
        words = [word for word in effect.block.words if word.address in AXES]
        if effect.block.has("M", 6):
            self.at = {"X": -311.0, "Y": 287.0, "Z": TOP}
        elif in_call:  # left over the laser, or over where it came from
            there = self.at if _comes_back(effect, self.settings) else {"X": 777.0, "Y": -222.0}
            self.at = {**there, "Z": TOP}
        elif _goes_by_machine(effect):
            self.at.update({word.address: _HOME[word.address] for word in words})
        elif effect.move is not None:
            is_hole = effect.move.kind == "other"  # the control itself comes back up
            self.at.update(
                {w.address: self._end(w, effect) for w in words if not (is_hole and w.address == "Z")}
            )
        return start, dict(self.at)

    def _switch_offset(self, effect: BlockEffect, *, ends_offset: bool) -> None:
        dialect = self.settings.dialect
        goes_home = "home" in effect.non_modal and any(w.address == "Z" for w in effect.block.words)
        if (goes_home and self.home_ends_offset) or ends_offset:
            self.offset_is_in_force = False
        codes = codes_of(effect.block, "length_offset", dialect)
        if codes:
            self.offset_is_in_force = dialect.g_codes[codes[-1]].value == "on"

    def _end(self, word: Word, effect: BlockEffect) -> float:
        """Where an axis word takes its axis."""
        value = plain_value(word) * (25.4 if effect.after.is_inch else 1.0)
        if word.address == "X" and is_diameter(effect.after, self.settings.control):
            value /= 2.0
        is_distance = effect.after.modes.distance == "incremental"
        return value + self.at[word.address] if is_distance else value


def _calls(effect: BlockEffect) -> bool:
    return "macro-call" in effect.non_modal or any(c.keyword == "O-CALL" for c in effect.block.controls)


def _comes_back(effect: BlockEffect, rules: Settings) -> bool:
    """True for the built-in CALIBRATE."""
    if rules.checks.calls != "builtin":
        return False
    return effect.block.has("P", 8900) or any("cb_calibrate" in c.label for c in effect.block.controls)


def _positions(effect: BlockEffect) -> bool:
    is_rapid = effect.move is not None and effect.move.kind == "rapid" and not effect.non_modal
    return is_rapid or _goes_by_machine(effect)


def _goes_by_machine(effect: BlockEffect) -> bool:
    return bool({"home", "machine"} & set(effect.non_modal))


def same_cuts(
    paired: list[tuple[BlockEffect, BlockEffect | None]], rules: Settings, *, home_ends: bool, calls_end: bool
) -> None:
    """The tool cuts where it did, and comes down nowhere else and with no other offset."""
    one, other = Machine(rules, home_ends), Machine(rules, home_ends)
    for new, old in paired:
        text = new.block.text
        is_call = _calls(new)
        if old is None:
            new_way = other.run(new, in_call=is_call, ends_offset=is_call and calls_end)
            _comes_down_nowhere_else(new_way, one, other, text)
            continue
        if old.after.ended:
            break  # what follows is another program
        old_way = one.run(old, in_call=is_call)
        new_way = other.run(new, in_call=is_call)
        if old.move is None and not old.non_modal - {"data-setting", "shift", "dwell", "exact-stop"}:
            continue
        if _positions(old):
            _positions_alike(old_way, new_way, old)
        else:
            _cuts_alike(old_way, new_way, text)
        if new_way[0]["Z"] != new_way[1]["Z"] and not _goes_by_machine(old):
            assert one.offset_is_in_force == other.offset_is_in_force, f"length offset differs: {text}"


def _comes_down_nowhere_else(way: Way, one: Machine, other: Machine, text: str) -> None:
    """What was inserted goes down only where the original is, and never below it."""
    start, end = way
    if end["Z"] < min(TOP, start["Z"]):
        for axis in "XY":
            assert start[axis] == end[axis] and _equal(end[axis], one.at[axis]), text
        assert other.offset_is_in_force == one.offset_is_in_force, text
    assert end["Z"] >= min(TOP, one.at["Z"]) or _equal(end["Z"], one.at["Z"]), text
    assert start["X"] == end["X"] or end["Z"] == TOP, text


def _positions_alike(old_way: Way, new_way: Way, old: BlockEffect) -> None:
    """A rapid comes down straight, and ends where it did."""
    text = old.block.text
    before, after = old_way
    start, end = new_way
    slanting = any(not _equal(start[a], before[a]) for a in "XY" if start["Z"] != end["Z"])
    assert not slanting, f"comes down elsewhere: {text}"
    assert start["Z"] >= min(TOP, before["Z"]) or _equal(start["Z"], before["Z"]), text
    assert all(_equal(end[a], after[a]) for a in (old.move.axes if old.move else "")), text


def _cuts_alike(old_way: Way, new_way: Way, text: str) -> None:
    for axis in AXES:
        assert _equal(new_way[0][axis], old_way[0][axis]), f"cuts from elsewhere ({axis}): {text}"
        assert _equal(new_way[1][axis], old_way[1][axis]), f"cuts to elsewhere ({axis}): {text}"


def _equal(a: float, b: float) -> bool:
    return (math.isnan(a) and math.isnan(b)) or abs(a - b) < 5e-5
