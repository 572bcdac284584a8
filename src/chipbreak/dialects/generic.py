"""A lathe whose control is not named: the codes that nearly all of them read the same way."""

from __future__ import annotations

from chipbreak.dialects.base import (
    COMMON,
    COMMON_M_CODES,
    EVERY_LETTER,
    LOGIC_LAST,
    NON_MODAL,
    OTHER_SPINDLES,
    PATH_MARKS,
    Code,
    Dialect,
    table,
)
from chipbreak.dialects.modes import Modes
from chipbreak.text.frozen_table import FrozenTable

GENERIC_LATHE = Dialect(
    name="generic-lathe",
    title="Lathe with ISO 6983 codes",
    is_lathe=True,
    g_codes=COMMON
    | table(
        motion={
            "G32 G33 G34": "thread",
            "G80": "none",
            "G81 G82 G83 G84 G85 G86 G87 G88 G89": "cycle",
        },
        distance={"G90": "absolute", "G91": "incremental"},
        feed_mode={"G94": "minute", "G95": "rev", "G93": "inverse", "G98": "minute", "G99": "rev"},
        speed_mode={"G96": "surface", "G97": "rpm"},
        path={"G61": "exact-stop", "G64": "blend"},
        rotation={"G69": "off", "G68": "on"},
        polar={"G113 G13.1": "off", "G112 G12.1": "on"},
        cylinder={"G107 G7.1": "switched"},
        modal_macro={"G67": "off", "G66": "on"},
        non_modal={
            "G50 G92": "set-position",
            "G70": "finish-cycle",
            "G71 G72 G73": "rough-cycle",
            "G74 G75": "peck-cycle",
            "G76": "thread-cycle",
            "G27 G36 G37": "service",
        },
    ),
    initial=Modes(motion="rapid", plane="ZX", feed_mode="rev"),
    tool_change="T",
    grammar="fanuc",
    precedence=LOGIC_LAST,
    m_codes=COMMON_M_CODES | OTHER_SPINDLES,
    marks=PATH_MARKS,
    spindle_word="P",
    incremental=FrozenTable({"U": "X", "V": "Y", "W": "Z", "H": "C"}),
    speed_limit=frozenset({500, 920}),
    surface_needs_speed=True,
    lone_dwell_words="F",  # as ISO 6983 has it
    own_words=FrozenTable(
        {
            Code(NON_MODAL, "dwell"): "XUP",
            Code(NON_MODAL, "macro-call"): EVERY_LETTER,
            Code("modal_macro", "on"): EVERY_LETTER,
        }
    ),
    machine_retract=("G28 U0", "G28 W0"),
    contour_cycles=FrozenTable({700: "finish", 710: "along-z", 720: "along-x", 730: "pattern"}),
)
