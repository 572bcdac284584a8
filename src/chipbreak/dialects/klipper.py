"""Klipper: one command a line, feed per minute, no spindle (M3, M4 and M5 are macros of the shop)."""

from __future__ import annotations

from chipbreak.dialects.base import LOGIC_LAST, NON_MODAL, SEMICOLON, Code, Dialect, Stops, m_table, table
from chipbreak.dialects.modes import Modes
from chipbreak.text.frozen_table import FrozenTable

KLIPPER = Dialect(
    name="klipper",
    title="Klipper",
    is_lathe=False,
    g_codes=table(
        # G2, G3 and the planes need the section gcode_arcs.
        motion={"G0": "rapid", "G1": "line", "G2": "cw", "G3": "ccw"},
        plane={"G17": "XY", "G18": "ZX", "G19": "YZ"},
        units={"G20": "inch", "G21": "mm"},
        distance={"G90": "absolute", "G91": "incremental"},
        non_modal={"G4": "dwell", "G28": "home", "G92": "set-position"},
    ),
    m_codes=m_table(
        spindle={"M3!": "cw", "M4!": "ccw", "M5": "stop"},
        coolant={"M7!": "mist", "M8!": "flood", "M9": "off"},
        program={"M2 M30": "end"},
        stop={"M0": "always", "M1": "optional"},
        wait={"M400": "moves"},
    ),
    initial=Modes(motion="none", plane="XY", feed_mode="minute"),
    tool_change="T",
    offset_digits=0,
    grammar="klipper",
    precedence=LOGIC_LAST,
    dwell_word="P",
    dwells_per_s=1000.0,
    axis_letters="XYZ",
    comment_marks=SEMICOLON,
    reads_comments_in_lower_case=True,
    own_words=FrozenTable({Code(NON_MODAL, "dwell"): "P"}),
    place_variables=frozenset(),
    speed_variables=frozenset(),
    repeats_codes=True,
    # The host runs the file: M0 and M2 are nothing there, but for a macro of the shop.
    holds_programs=False,
    no_macros=(
        "it has no G38, probing (PROBE) is a macro of its configuration, and a program cannot compare"
    ),
    stops_at=Stops(letters="EFGIJKMNPRSTXYZ", one_command=True, has_own_commands=True),
)
