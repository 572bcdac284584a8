"""A feed or a surface speed that was set in other units than those in force: right, but seldom meant."""

from __future__ import annotations

from collections.abc import Iterator

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import Setting
from chipbreak.text.diagnostics import Diagnostic, Severity

OTHER_UNITS = "MOD002"
_NAMES = {
    "F": {"inch": "inches", "mm": "millimetres"},
    "S": {"inch": "feet per minute", "mm": "metres per minute"},
}


def feeds_in_other_units(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """A warning for every such word: where it stands, or at the first cut that runs with it."""
    if not interpreted.settings.dialect.converts_feed:
        return []
    switches = [e for e in interpreted.effects if e.before.modes.units != e.after.modes.units]
    return [found for switch in switches for found in _found(interpreted, switch)]


def _found(interpreted: InterpretedProgram, switch: BlockEffect) -> Iterator[Diagnostic]:
    after = switch.after
    line = switch.block.line
    settings = [("F", after.feed)] if after.modes.feed_mode != "inverse" else []
    settings += [("S", after.speed)] if after.modes.speed_mode == "surface" else []
    for letter, setting in settings:
        if setting is not None and setting.line == line and setting.units != after.modes.units:
            what = f"{letter}{setting.text} stands beside a change of units and is read before it"
            yield _warning(interpreted, line, what, letter, setting)
    feed = after.feed
    if feed is None or feed.line == line or feed.units == after.modes.units:
        return
    cut = _first_cut(interpreted, line + 1, feed)
    if cut is not None:
        where = interpreted.program.source.place(feed.line).line
        yield _warning(
            interpreted, cut.block.line, f"this cut runs with F{feed.text} of line {where}", "F", feed
        )


def _first_cut(interpreted: InterpretedProgram, first: int, feed: Setting) -> BlockEffect | None:
    """The first cut that runs with a feed."""
    for effect in interpreted.effects_of(first, interpreted.program.source.body.stop):
        if effect.after.feed != feed or effect.after.modes.units == feed.units:
            return None
        if effect.move is not None and effect.move.is_cut:
            return effect
    return None


def _warning(
    interpreted: InterpretedProgram, line: int, what: str, letter: str, setting: Setting
) -> Diagnostic:
    message = f"{what}: {setting.text} is in {_NAMES[letter][setting.units]} here, as this control takes it"
    help_text = f"if that is not meant, write {letter} again in a block behind the G20 or G21"
    return interpreted.program.diagnose(line, OTHER_UNITS, message, help_text, severity=Severity.WARNING)
