"""Grbl 1.1, and grblHAL as it is built without options: lathe mode, no expressions, no tool table.

Both stop at a code that they do not know, so what is not in these tables is refused here as well.
"""

from __future__ import annotations

from chipbreak.dialects.base import LOGIC_LAST, NON_MODAL, Code, Dialect, Stops, m_table, table
from chipbreak.dialects.check_programs import PLAIN_SETS
from chipbreak.dialects.modes import Modes
from chipbreak.text.frozen_table import FrozenTable

_CODES = table(
    motion={
        "G0": "rapid",
        "G1": "line",
        "G2": "cw",
        "G3": "ccw",
        "G38.2 G38.3 G38.4 G38.5": "probe",
        "G80": "none",
    },
    plane={"G17": "XY", "G18": "ZX", "G19": "YZ"},
    units={"G20": "inch", "G21": "mm"},
    distance={"G90": "absolute", "G91": "incremental"},
    arc_distance={"G91.1": "incremental"},
    feed_mode={"G93": "inverse", "G94": "minute"},
    compensation={"G40": "off"},
    length_offset={"G49": "off", "G43.1": "by-axes"},
    work_offset={f"G{number}": f"G{number}" for number in range(54, 60)},
    path={"G61": "exact"},
    non_modal={
        "G4": "dwell",
        "G10": "data-setting",
        "G28 G30": "home",
        "G28.1 G30.1": "store-home",
        "G53": "machine",
        "G92 G92.1": "set-position",
    },
)
_M_CODES = m_table(
    spindle={"M3!": "cw", "M4!": "ccw", "M5": "stop"},
    coolant={"M7!": "mist", "M8!": "flood", "M9": "off"},
    program={"M2 M30": "end"},
    stop={"M0": "always", "M1": "optional"},
)
# $ settings: the number without that of the axis (0 is X), and what the profile calls it.
_SETTINGS = FrozenTable(
    {
        11: "planner.junction_deviation_mm",
        **{100 + number: f"axes.{axis}.steps_per_mm" for number, axis in enumerate("XYZ")},
        **{110 + number: f"axes.{axis}.max_velocity_mm_min" for number, axis in enumerate("XYZ")},
        **{120 + number: f"axes.{axis}.max_acceleration_mm_s2" for number, axis in enumerate("XYZ")},
    }
)
_OWN_WORDS = FrozenTable(
    {Code(NON_MODAL, "dwell"): "P", Code(NON_MODAL, "data-setting"): "LPRXYZ"},
)

GRBL = Dialect(
    name="grbl",
    title="Grbl 1.1",
    is_lathe=False,
    g_codes=_CODES,
    m_codes=_M_CODES,
    initial=Modes(motion="rapid", plane="XY", feed_mode="minute"),
    # M6 is refused, and T is a number that nothing reads: who changes the tool does it there.
    tool_change="T",
    offset_digits=0,
    grammar="grbl",
    precedence=LOGIC_LAST,
    dwell_word="P",
    moves_beside_dwell=True,
    axis_letters="XYZ",
    machine_retract=("G53 G0 Z0",),
    retract_is_absolute=True,
    own_words=_OWN_WORDS,
    call_sets=PLAIN_SETS,
    no_macros="it has no variables, so runout, diameter and edges cannot be measured",
    place_variables=frozenset(),
    speed_variables=frozenset(),
    place_settings=frozenset({20.0}),
    settings=_SETTINGS,
    stops_at=Stops(
        letters="FGIJKLMNPRSTXYZ",
        tape_mark=True,
        # The buffer of a line holds 80 characters with its end; comments and blanks do not get into it.
        code_chars=79,
        real_time="!~\x18",
        real_time_from=0x80,
    ),
)

GRBLHAL_LATHE = GRBL._replace(
    name="grblhal-lathe",
    title="grblHAL, lathe",
    is_lathe=True,
    settings=FrozenTable({**_SETTINGS, 398: "planner.look_ahead_blocks"}),
    g_codes=_CODES
    | table(
        motion={
            "G5 G5.1": "spline",
            "G33": "thread",
            "G76": "thread-cycle",
            "G73 G81 G82 G83 G84 G85 G86 G89": "cycle",
        },
        feed_mode={"G95": "rev"},
        speed_mode={"G96": "surface", "G97": "rpm"},
        diameter={"G7": "diameter", "G8": "radius"},
        return_level={"G98": "initial", "G99": "r-plane"},
        scaling={"G50": "off", "G51": "on"},
        work_offset={"G59.1": "G59.1", "G59.2": "G59.2", "G59.3": "G59.3"},
        non_modal={"G65": "macro-call", "G92.2 G92.3": "set-position"},
    ),
    m_codes=_M_CODES
    | m_table(
        tool={"M6": "change"},
        stop={"M60": "pallet"},
        subprogram={"M98": "call", "M99": "return"},
        override={"M48 M49 M50 M51 M53 M56": "switched"},
        tool_number={"M61": "set"},
        output={"M62 M63 M64 M65 M67 M68": "set"},
        input={"M66": "wait"},
    ),
    call_sets=FrozenTable({}),
    no_macros="the macros measure tools that turn",
    tool_change="M6",
    offset_digits=2,
    machine_retract=("G53 G0 X0", "G53 G0 Z0"),
    surface_limit="D",
    surface_needs_speed=True,
    stops_at=Stops(
        letters="DEFGHIJKLMNPQRSTXYZ",
        line_chars=256,
        real_time="!~\x18\x19",
        real_time_from=0x80,
    ),
)
