"""The blocks that take a tool to the safe end of its travel, and what they do."""

from __future__ import annotations

from collections.abc import Iterable

from chipbreak.insertion.position_dependencies import named_axes
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter
from chipbreak.model.modal import State
from chipbreak.model.words import plain_value
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import read_block


class Retract:
    """What the retract of a profile does.

    ``axes``    the axes that it moves
    ``is_home`` it is a reference return (G28), which ends a length offset on some controls
    """

    def __init__(self, settings: Settings) -> None:
        effects = list(_effects(settings))
        self._letters = settings.axis_words.axes
        self.axes = frozenset(axis for effect in effects for axis in named_axes(effect, settings))
        self.is_home = any("home" in effect.non_modal for effect in effects)

    def repeats(self, effect: BlockEffect) -> frozenset[str]:
        """Axes that the retract takes to the same place as a block: G28, or G53 to zero."""
        if self.is_home and effect.block.has("G", 28):
            return self.axes
        return self.axes & {
            self._letters.get(w.address, "") for w in effect.block.words if plain_value(w) == 0.0
        }


def retract_blocks(settings: Settings) -> Iterable[str]:
    """The dialect's retract in the letters of the profile's axes."""
    dialect = settings.dialect
    # Where an axis has no such word, the profile does not get as far as a check.
    texts = (settings.axis_words.renamed(t, dialect.incremental) for t in dialect.machine_retract)
    return filter(None, texts)


def _effects(settings: Settings) -> Iterable[BlockEffect]:
    interpreter = Interpreter(settings, Flow(frozenset(), ()))
    state = State(modes=settings.dialect.initial)
    for text in retract_blocks(settings):
        effect = interpreter.advance(state, read_block(0, text, settings.dialect))
        state = effect.after
        yield effect
