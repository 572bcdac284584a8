"""LinuxCNC 2.9: one interpreter, with the power-on modes a lathe and a mill are configured for."""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.dialects.base import (
    CHANGER_M_CODES,
    COMMON,
    LOGIC_LAST,
    NON_MODAL,
    SPINDLE,
    THROUGH_SPINDLE,
    Code,
    ContourCycle,
    Dialect,
    Loop,
    NoseRules,
    m_table,
    table,
)
from chipbreak.dialects.check_programs import O_WORD_SETS, O_WORDS
from chipbreak.dialects.modes import Modes
from chipbreak.text.frozen_table import FrozenTable

# LinuxCNC has neither G9, G11, G31 nor the calls of Fanuc macros.
_ABSENT = (90, 110, 310, 650, 541)
_SHARED = FrozenTable({number: code for number, code in COMMON.items() if number not in _ABSENT})
_CODES = _SHARED | table(
    motion={
        "G33 G33.1": "thread",
        "G76": "thread-cycle",
        "G80": "none",
        "G73 G74 G81 G82 G83 G84 G85 G86 G87 G88 G89": "cycle",
        "G5 G5.1 G5.2 G5.3": "spline",
        "G38.2 G38.3 G38.4 G38.5": "probe",
    },
    distance={"G90": "absolute", "G91": "incremental"},
    arc_distance={"G90.1": "absolute", "G91.1": "incremental"},
    feed_mode={"G93": "inverse", "G94": "minute", "G95": "rev"},
    speed_mode={"G96": "surface", "G97": "rpm"},
    length_offset={"G49": "off", "G43": "on", "G43.1 G43.2": "by-axes"},
    return_level={"G98": "initial", "G99": "r-plane"},
    path={"G61": "exact", "G61.1": "exact-stop", "G64": "blend"},
    diameter={"G7": "diameter", "G8": "radius"},
    non_modal={
        "G28.1 G30.1": "store-home",
        "G92 G92.1 G92.2 G92.3": "set-position",
        "G70": "finish-cycle",
        "G71 G71.1 G71.2 G72 G72.1 G72.2": "rough-cycle",
    },
)

_M_CODES = CHANGER_M_CODES | m_table(modes={"M70 M73": "keep", "M72": "give-back"})

_LOOP = Loop(
    begin=("o{label} repeat [{passes}]",),
    end=("o{label} endrepeat",),
    labels=range(1001, 100_000),
    reuses=False,
)

_INITIAL = Modes(motion="none", feed_mode="minute", path="blend")

# D and L of G41.1 and G42.1 are the diameter of the nose and its tip.
_OWN_WORDS = FrozenTable(
    {
        Code("compensation", "left"): "DL",
        Code("compensation", "right"): "DL",
        Code(NON_MODAL, "dwell"): "P",
        Code(NON_MODAL, "data-setting"): "LPRIJQXYZABCUVW",
        Code(NON_MODAL, "rough-cycle"): "QDIRXZUW",
        Code(NON_MODAL, "finish-cycle"): "QDEPXZUW",
    }
)

# G71.1 leaves the pockets, G71.2 cuts nothing else; both are told by their last digit.
_SUBROUTINE_CYCLES: Mapping[int, ContourCycle] = FrozenTable(
    {
        700: "finish",
        710: "along-z",
        711: "along-z",
        712: "along-z",
        720: "along-x",
        721: "along-x",
        722: "along-x",
    }
)

# Drawn with X down, so the numbers lie otherwise than on a Fanuc: 2 is a tool that turns outside.
_NOSE = NoseRules(
    FrozenTable(
        {
            0: (0, 0),
            1: (1, -1),
            2: (-1, -1),
            3: (-1, 1),
            4: (1, 1),
            5: (1, 0),
            6: (0, -1),
            7: (-1, 0),
            8: (0, 1),
            9: (0, 0),
        }
    ),
    rounds_corners=True,
    leads_in_by_itself=True,
)

_PLACES = frozenset({*range(5420, 5429), *(f"_{way}{axis}" for way in ("", "abs_") for axis in "xyzabcuvw")})
_SPEEDS = frozenset({"_rpm", "_spindle_rpm_mode", "_spindle_css_mode"})

LINUXCNC_LATHE = Dialect(
    name="linuxcnc-lathe",
    title="LinuxCNC, lathe",
    is_lathe=True,
    g_codes=_CODES,
    initial=_INITIAL._replace(plane="ZX"),
    tool_change="M6",
    m_codes=_M_CODES,
    grammar="linuxcnc",
    precedence=LOGIC_LAST,
    surface_limit="D",
    # Its interpreter before 2.9.0, that of Debian 12 among them.
    least_inverse_feed=0.1,
    surface_needs_speed=True,
    dwell_word="P",
    moves_beside_dwell=True,
    axis_letters="XYZUW",
    machine_retract=("G53 G0 X0", "G53 G0 Z0"),
    retract_is_absolute=True,
    reads_comments_in_lower_case=True,
    message_mark="MSG, ",
    loop=_LOOP,
    place_variables=_PLACES,
    speed_variables=_SPEEDS,
    place_settings=frozenset({10.0, 11.0, 20.0}),
    turns_offsets=True,
    takes_nested_comments=False,
    marks=FrozenTable({"PATH-MARK": SPINDLE}),
    line_needs_feed=True,
    converts_feed=True,
    feed_before_units=True,
    own_words=_OWN_WORDS,
    subroutine_cycles=_SUBROUTINE_CYCLES,
    arc_turns="P",
    subroutine_radius="A",
    subroutine_chamfer="C",
    nose=_NOSE,
)

LINUXCNC_MILL = LINUXCNC_LATHE._replace(
    name="linuxcnc-mill",
    title="LinuxCNC, mill",
    is_lathe=False,
    nose=None,
    initial=_INITIAL._replace(plane="XY"),
    machine_retract=("G53 G0 Z0",),
    m_codes=_M_CODES | THROUGH_SPINDLE,
    kept_variables=((31, 5000),),
    macros=O_WORDS,
    call_sets=O_WORD_SETS,
)
