"""Fanuc-type controls: lathe code systems A, B and C, and the machining centre."""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.dialects.base import (
    CHANGER_M_CODES,
    COMMON,
    COMMON_M_CODES,
    EVERY_LETTER,
    LOGIC_AS_ARITHMETIC,
    NON_MODAL,
    OTHER_SPINDLES,
    PATH_MARKS,
    THROUGH_SPINDLE,
    Clock,
    Code,
    ContourCycle,
    Dialect,
    Loop,
    NoseRules,
    table,
)
from chipbreak.dialects.check_programs import MACRO_B, MACRO_B_SETS
from chipbreak.dialects.modes import Modes
from chipbreak.text.frozen_table import FrozenTable

_INCREMENTAL = FrozenTable({"U": "X", "V": "Y", "W": "Z", "H": "C"})

# The control works these statements out while it reads ahead.  That is harmless here: they count, and ask for
# nothing that depends on where the tool is.
_LOOP = Loop(
    begin=("#{variable}=0", "WHILE[#{variable}LT{passes}]DO{label}"),
    end=("#{variable}=#{variable}+1", "END{label}"),
    labels=range(1, 4),
    reuses=True,
    variables=(range(1, 34), range(100, 200), range(500, 1000)),
)

_CLOCK = Clock(
    wait="G53",
    begin="#3001=0",
    end="#{variable}=#3001",
    message="#3006=1({text})",
    first_variable=101,
    program=7999,
)

# The S of G50 and G92 is the limit of the spindle, which ``speed_limit`` says.
_OWN_WORDS = FrozenTable(
    {
        Code(NON_MODAL, "dwell"): "XUP",
        Code(NON_MODAL, "data-setting"): "LPRNQXYZUVWABCIJKDH",
        Code(NON_MODAL, "rough-cycle"): "PQUVWRDIK",
        Code(NON_MODAL, "finish-cycle"): "PQ",
        Code(NON_MODAL, "peck-cycle"): "XZUWPQRIKD",
        Code(NON_MODAL, "thread-cycle"): "XZUWPQRIKDA",
        Code(NON_MODAL, "macro-call"): EVERY_LETTER,
        Code("modal_macro", "on"): EVERY_LETTER,
    }
)

# G70 to G76: the description of each of them ends with a way back to its start point.
_RETURNING = frozenset({"finish-cycle", "rough-cycle", "peck-cycle", "thread-cycle"})

# Tip 3 is that of a tool that turns outside towards the chuck; 0 and 9 are programmed by the centre.
FANUC_NOSE = NoseRules(
    FrozenTable(
        {
            0: (0, 0),
            1: (1, 1),
            2: (-1, 1),
            3: (-1, -1),
            4: (1, -1),
            5: (1, 0),
            6: (0, 1),
            7: (-1, 0),
            8: (0, -1),
            9: (0, 0),
        }
    )
)

_LATHE = COMMON | table(
    motion={"G32 G33 G34": "thread", "G83 G84 G85 G87 G88 G89": "cycle"},
    cycle_end={"G80": "ends"},
    speed_mode={"G96": "surface", "G97": "rpm"},
    rotation={"G69 G69.1": "off", "G68 G68.1": "on"},
    polar={"G13.1 G113": "off", "G12.1 G112": "on"},
    cylinder={"G7.1 G107": "switched"},
    polygon={"G50.2 G250": "off", "G51.2 G251": "on"},
    modal_macro={"G67": "off", "G66 G66.1": "on"},
    look_ahead={"G5.1 G5": "switched"},
    non_modal={"G22 G23 G25 G26 G27 G36 G37 G37.1": "service"},
)

_LATHE_INITIAL = Modes(motion="rapid", plane="ZX", feed_mode="rev")

_CONTOURS_AB: Mapping[int, ContourCycle] = FrozenTable(
    {700: "finish", 710: "along-z", 720: "along-x", 730: "pattern"}
)
_CYCLES_AB = table(
    non_modal={
        "G70": "finish-cycle",
        "G71 G72 G73": "rough-cycle",
        "G74 G75": "peck-cycle",
        "G76": "thread-cycle",
    }
)

FANUC_LATHE_A = Dialect(
    name="fanuc-lathe",
    title="Fanuc lathe, code system A",
    lathe_system="A",
    is_lathe=True,
    g_codes=_LATHE
    | _CYCLES_AB
    | table(
        feed_mode={"G98": "minute", "G99": "rev"},
        motion={"G90 G94": "turning-cycle", "G92": "threading-cycle"},
        non_modal={"G50": "set-position"},
    ),
    initial=_LATHE_INITIAL,
    tool_change="T",
    grammar="fanuc",
    precedence=LOGIC_AS_ARITHMETIC,
    m_codes=COMMON_M_CODES | OTHER_SPINDLES,
    marks=PATH_MARKS,
    spindle_word="P",
    incremental=_INCREMENTAL,
    speed_limit=frozenset({500}),
    machine_retract=("G28 U0", "G28 W0"),
    loop=_LOOP,
    clock=_CLOCK,
    contour_cycles=_CONTOURS_AB,
    nose=FANUC_NOSE,
    deep_drilling=frozenset({830}),
    turning_cycles=FrozenTable({900: "along-z", 940: "along-x"}),
    own_words=_OWN_WORDS,
    returning_cycles=_RETURNING,
    bare_arc_is_line=True,
)

FANUC_LATHE_B = Dialect(
    name="fanuc-lathe",
    title="Fanuc lathe, code system B",
    lathe_system="B",
    is_lathe=True,
    g_codes=_LATHE
    | _CYCLES_AB
    | table(
        feed_mode={"G94": "minute", "G95": "rev"},
        distance={"G90": "absolute", "G91": "incremental"},
        return_level={"G98": "initial", "G99": "r-plane"},
        motion={"G77 G79": "turning-cycle", "G78": "threading-cycle"},
        non_modal={"G50 G92": "set-position"},
    ),
    initial=_LATHE_INITIAL,
    tool_change="T",
    grammar="fanuc",
    precedence=LOGIC_AS_ARITHMETIC,
    m_codes=COMMON_M_CODES | OTHER_SPINDLES,
    marks=PATH_MARKS,
    spindle_word="P",
    incremental=_INCREMENTAL,
    speed_limit=frozenset({500, 920}),
    machine_retract=("G28 U0", "G28 W0"),
    loop=_LOOP,
    clock=_CLOCK,
    contour_cycles=_CONTOURS_AB,
    nose=FANUC_NOSE,
    deep_drilling=frozenset({830}),
    turning_cycles=FrozenTable({770: "along-z", 790: "along-x"}),
    own_words=_OWN_WORDS,
    returning_cycles=_RETURNING,
    bare_arc_is_line=True,
)

FANUC_LATHE_C = Dialect(
    name="fanuc-lathe",
    title="Fanuc lathe, code system C",
    lathe_system="C",
    is_lathe=True,
    g_codes=_LATHE
    | table(
        units={"G70": "inch", "G71": "mm"},
        feed_mode={"G94": "minute", "G95": "rev"},
        distance={"G90": "absolute", "G91": "incremental"},
        return_level={"G98": "initial", "G99": "r-plane"},
        motion={"G20 G24": "turning-cycle", "G21": "threading-cycle"},
        non_modal={
            "G50 G92": "set-position",
            "G72": "finish-cycle",
            "G73 G74 G75": "rough-cycle",
            "G76 G77": "peck-cycle",
            "G78": "thread-cycle",
        },
    ),
    initial=_LATHE_INITIAL,
    tool_change="T",
    grammar="fanuc",
    precedence=LOGIC_AS_ARITHMETIC,
    m_codes=COMMON_M_CODES | OTHER_SPINDLES,
    marks=PATH_MARKS,
    spindle_word="P",
    incremental=_INCREMENTAL,
    speed_limit=frozenset({500, 920}),
    machine_retract=("G28 U0", "G28 W0"),
    loop=_LOOP,
    clock=_CLOCK,
    contour_cycles=FrozenTable({720: "finish", 730: "along-z", 740: "along-x", 750: "pattern"}),
    nose=FANUC_NOSE,
    deep_drilling=frozenset({830}),
    turning_cycles=FrozenTable({200: "along-z", 240: "along-x"}),
    own_words=_OWN_WORDS,
    returning_cycles=_RETURNING,
    bare_arc_is_line=True,
)

FANUC_MILL = Dialect(
    name="fanuc-mill",
    title="Fanuc machining centre",
    is_lathe=False,
    g_codes=COMMON
    | table(
        motion={
            "G33": "thread",
            "G73 G74 G76 G81 G82 G83 G84 G84.2 G85 G86 G87 G88 G89": "cycle",
        },
        cycle_end={"G80": "ends"},
        distance={"G90": "absolute", "G91": "incremental"},
        feed_mode={"G93": "inverse", "G94": "minute", "G95": "rev"},
        return_level={"G98": "initial", "G99": "r-plane"},
        arc_distance={"G90.1": "absolute", "G91.1": "incremental"},
        speed_mode={"G96": "surface", "G97": "rpm"},
        length_offset={"G49 G49.1": "off", "G43 G43.1 G43.4 G43.5 G44": "on"},
        rotation={"G69": "off", "G68 G68.2 G68.3": "on"},
        scaling={"G50": "off", "G51": "on"},
        mirror={"G50.1": "off", "G51.1": "on"},
        polar={"G15": "off", "G16": "on"},
        interpolation={"G13.1": "off", "G12.1": "on"},
        path={"G61": "exact-stop", "G62": "corner", "G63": "tapping", "G64": "blend"},
        modal_macro={"G67": "off", "G66 G66.1": "on"},
        # The further offsets of Haas: G154 P1 to P99, of which G110 to G129 are older names.
        work_offset={"G154": "G154"} | {f"G{n}": f"G{n}" for n in range(110, 130) if n not in (112, 113)},
        look_ahead={"G5 G5.1 G5.3": "switched", "G8": "switched"},
        non_modal={
            "G92 G92.1": "set-position",
            "G22 G23 G25 G26 G27 G29 G37 G45 G46 G47 G48": "service",
            "G53.1": "tilt",
            "G7 G12 G13": "service",
            "G103 G187": "tuning",  # Haas: how far it looks ahead, how smoothly it runs
        },
    ),
    initial=Modes(motion="rapid", plane="XY", feed_mode="minute", path="blend"),
    tool_change="M6",
    m_codes=CHANGER_M_CODES | THROUGH_SPINDLE,
    marks=PATH_MARKS,
    speed_limit=frozenset({920}),
    grammar="fanuc",
    precedence=LOGIC_AS_ARITHMETIC,
    axis_letters="XYZUWABC",
    machine_retract=("G91 G28 Z0.", "G90"),
    kept_variables=((500, 999), (98000, 98499)),
    macros=MACRO_B,
    call_sets=MACRO_B_SETS,
    loop=_LOOP,
    clock=_CLOCK,
    own_words=_OWN_WORDS,
    bare_arc_is_line=True,
)
