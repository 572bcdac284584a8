"""What the G codes of a block say: the modal groups they set, and what they do once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import NON_MODAL
from chipbreak.dialects.modes import Modes
from chipbreak.model.words import cylinder_of, offset_of, plain_value
from chipbreak.syntax.nodes import Block
from chipbreak.text.frozen_table import FrozenTable

# Codes behind which it is not known where the tool stands, with the reason.
LOSES: Mapping[str, str] = FrozenTable(
    {
        "home": "a reference return (G28, G30) leaves the program's coordinates",
        "machine": "G53 moves in machine coordinates",
        "skip": "a skip move (G31) ends where the probe trips",
        "set-position": "G92 or G50 sets a new origin",
        "shift": "G52 shifts the origin",
        "data-setting": "G10 may change an offset",
        "macro-call": "a macro call moves the tool",
        "service": "a service code moves the tool",
        "tilt": "G53.1 turns the tool axis",
        "rough-cycle": "a roughing cycle moves the tool",
        "finish-cycle": "a finishing cycle moves the tool",
        "peck-cycle": "a pecking cycle moves the tool",
        "thread-cycle": "a threading cycle moves the tool",
    }
)
# Codes whose block gives its other words a meaning of their own: no axis motion, no vibration words.
_READS_ALL = frozenset(LOSES) - {"machine", "skip"} | {"dwell", "tuning"}


class BlockCodes(NamedTuple):
    """What the G codes of a block say.

    ``changes``   modal group -> value, also where it is the one in force
    ``modes``     what is in force with them
    ``non_modal`` what they do in this block only (dwell, home, macro-call, ...)
    ``unknown``   True with a G code that the dialect does not know
    ``reads_all`` True where a code gives the block's other words a meaning of their own
    """

    changes: Mapping[str, str]
    modes: Modes
    non_modal: frozenset[str]
    unknown: bool
    reads_all: bool


def read_codes(block: Block, modes: Modes, dialect: Dialect) -> BlockCodes:
    """The codes of a block that is reached under ``modes``."""
    changes: dict[str, str] = {}
    non_modal: set[str] = set()
    unknown = False
    for word in block.words_of("G"):
        value = plain_value(word)
        code = None if math.isnan(value) else dialect.g_codes.get(round(value * 10))
        if code is None:
            unknown = True
        elif code.group == NON_MODAL:
            non_modal.add(code.value)
        else:
            changes[code.group] = code.value
    if "cylinder" in changes:
        changes["cylinder"] = cylinder_of(block)
    if "work_offset" in changes:
        changes["work_offset"] = offset_of(block, changes["work_offset"])
    reads_all = not non_modal.isdisjoint(_READS_ALL)
    return BlockCodes(changes, modes.replace(changes), frozenset(non_modal), unknown, reads_all)
