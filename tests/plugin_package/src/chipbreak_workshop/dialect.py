"""The workshop control of a lathe: its vocabulary.  How its blocks look is in ``blocks.lark``."""

from __future__ import annotations

from pathlib import Path

from chipbreak.dialects.base import COMMON, LOGIC_LAST, SEMICOLON, Dialect, table
from chipbreak.dialects.modes import Modes
from chipbreak.text.frozen_table import FrozenTable

WORKSHOP_LATHE = Dialect(
    name="workshop-lathe",
    title="Workshop control of a lathe",
    is_lathe=True,
    g_codes=COMMON
    | table(
        feed_mode={"G94": "minute", "G95": "rev"},
        speed_mode={"G96": "surface", "G97": "rpm"},
        non_modal={"G92": "set-position", "G165": "macro-call"},
    ),
    initial=Modes(motion="rapid", plane="ZX", feed_mode="rev"),
    tool_change="T",
    grammar=Path(__file__).with_name("blocks.lark"),
    precedence=LOGIC_LAST,
    incremental=FrozenTable({"U": "X", "W": "Z"}),
    speed_limit=frozenset({920}),
    machine_retract=("G28 U=0", "G28 W=0"),
    axis_letters="XYZ",
    set_off="=",
    comment_marks=SEMICOLON,
)
