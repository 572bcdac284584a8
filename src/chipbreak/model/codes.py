"""What the G codes of a block say: the modal groups they set, and what they do once."""

from __future__ import annotations

import math
from collections.abc import Mapping

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import CYCLE_END, NON_MODAL, Code
from chipbreak.dialects.modes import Modes
from chipbreak.model.modal import State
from chipbreak.model.words import cylinder_of, offset_of, plain_value
from chipbreak.syntax.nodes import Block
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple

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
_DWELL = Code(NON_MODAL, "dwell")
# Codes whose block gives its other words a meaning of their own: no axis motion, no vibration words.
_READS_ALL_BUT_DWELL = frozenset(LOSES) - {"machine", "skip"} | {"tuning"}
_READS_ALL = _READS_ALL_BUT_DWELL | {"dwell"}


class BlockCodes(NamedTuple):
    """What the G codes of a block say.

    ``changes``   modal group -> value, also where it is the one in force
    ``modes``     what is in force with them
    ``non_modal`` what they do in this block only (dwell, home, macro-call, ...)
    ``unknown``   True with a G code that the dialect does not know
    ``reads_all`` True where a code gives the block's axis words and custom words a meaning of their own
    ``taken``     the letters that the codes take for themselves
    """

    changes: Mapping[str, str]
    modes: Modes
    non_modal: frozenset[str]
    unknown: bool
    reads_all: bool
    taken: str = ""


def read_codes(block: Block, state: State, dialect: Dialect) -> BlockCodes:
    """The codes of a block that is reached in ``state``."""
    changes: dict[str, str] = {}
    non_modal: set[str] = set()
    unknown = False
    ends_cycle = False
    said: dict[Code, None] = {}  # in their order, each once
    for word in block.words_of("G"):
        value = plain_value(word)
        code = None if math.isnan(value) else dialect.g_codes.get(round(value * 10))
        if code is None:
            unknown = True
            continue
        said[code] = None
        if code.group == NON_MODAL:
            non_modal.add(code.value)
        elif code.group == CYCLE_END:
            ends_cycle = True
        else:
            changes[code.group] = code.value
    if ends_cycle and state.modes.motion == "cycle":
        changes.setdefault("motion", state.motion_before_cycle)
    _complete(changes, block)
    reads_all = not non_modal.isdisjoint(_READS_ALL_BUT_DWELL if dialect.moves_beside_dwell else _READS_ALL)
    modes = state.modes.replace(changes)
    taken = "".join([_taken_by(code, block, dialect) for code in said])
    return BlockCodes(changes, modes, frozenset(non_modal), unknown, reads_all, taken)


def _taken_by(code: Code, block: Block, dialect: Dialect) -> str:
    """The letters of its block that a code takes for itself."""
    own = dialect.own_words.get(code, "")
    is_bare_dwell = code == _DWELL and not block.has_any(own)
    return own + dialect.lone_dwell_words if is_bare_dwell else own


def _complete(changes: dict[str, str], block: Block) -> None:
    """What words of the block say of a group."""
    if "cylinder" in changes:
        changes["cylinder"] = cylinder_of(block)
    if "work_offset" in changes:
        changes["work_offset"] = offset_of(block, changes["work_offset"])
