"""What is right for each program that once came out wrong: cuts, what is given back, what is said.

``tests/test_right_values.py`` holds the programs of the folder that ``CHIPBREAK_CASES`` names to this.
"""

from __future__ import annotations

from typing import NamedTuple

from beam import BEAM


class Right(NamedTuple):
    """One program on one control.

    ``cuts``     N, f, S and stroke of each vibrated cut, as its bracket says them
    ``modes``    blocks in the brackets that set S, F, units or modes: what is given back is among them
    ``checks``   title and line of each tool check, and the blocks that start the spindle again
    ``said``     code and line of what must be said; nothing else of these codes is
    ``refused``  the errors, code and line; no output then
    """

    file: str
    profile: str
    sets: tuple[str, ...] = ()
    cuts: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()
    said: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """For a report of tests."""
        return " ".join([self.file, self.profile, *self.sets])


LATHE, MILL = "fanuc-lathe", "fanuc-mill"
LC_LATHE, LC_MILL = "linuxcnc-lathe", "linuxcnc-mill"
WISH = ("vibration.n=1.5",)
IDEAL = ('planner.model="ideal"',)
# Cuts of random programs are short: ramps of half a vibration leave room for vibration between them.
SHORT = (*IDEAL, "vibration.ramp_vibrations=0.5", "vibration.end_revolutions=0", "checks.enabled=false")
PLAIN_25 = "N1.5 F25 S1000 STROKE 0.12"
OUR_9810 = (*BEAM, "macros.first_program=9810")  # where the program has those of another maker
OWN_CHECK = (
    "checks.enabled=true",
    'calls.own={chip_check="G65 P1 T{tool} H{limit}"}',
    "checks.calls=own",
)

RIGHT = (
    # --- F, and S under G96, beside G20 and G21: LinuxCNC reads both before the units
    Right("public/01a-units-after-feed.ngc", LC_LATHE, said=("MOD002 4",), refused=("VIB013 5",)),
    Right(
        "public/01a-units-after-feed.ngc",
        LC_LATHE,
        SHORT,
        cuts=("N0.5 F8.333 S1000 STROKE 3.048",),
        modes=("G95", "G61", "G94 G20", "G21 F100", "G64"),
        said=("MOD002 4",),
    ),
    Right(
        "public/01b-units-before-feed.ngc",
        LC_LATHE,
        IDEAL,
        cuts=("N0.5 F8.333 S1000 STROKE 0.12",),
        modes=("G95", "G61", "G94 F100", "G64"),
    ),
    Right(
        "public/01c-g95-same-block.ngc",
        LC_LATHE,
        IDEAL,
        cuts=(PLAIN_25,),
        modes=("G61", "G64"),
        said=("MOD002 4",),
    ),
    Right("public/01d-units-after-feed-next.ngc", LC_LATHE, said=("MOD002 4",), refused=("VIB013 5",)),
    Right(
        "public/01d-units-after-feed-next.ngc",
        LC_LATHE,
        SHORT,
        cuts=("N0.5 F8.333 S1000 STROKE 3.048",),
        modes=("G95", "G61", "G94 G20", "G21 F100", "G64"),
        said=("MOD002 4",),
    ),
    Right(
        "public/01e-f-old-units.ngc",
        LC_LATHE,
        IDEAL,
        cuts=("N0.5 F8.333 S1000 STROKE 0.0048",),
        modes=("G95", "G61", "G94 F4.", "G64"),
        said=("MOD002 1",),
    ),
    Right(
        "public/01f-mill-units-after-feed.ngc",
        LC_MILL,
        BEAM,
        checks=("5 TOOL CHECK T1, TRACE T1",),  # behind line 5 M72 would give F back in the other units
        modes=("M5", "S3000 M3"),
        said=("MOD002 5",),
    ),
    Right(
        "public/01g-initial-inch-machine.ngc",
        LC_LATHE,
        IDEAL,
        cuts=("N0.5 F8.333 S1000 STROKE 0.12",),
        modes=("G95", "G61", "G94 F100", "G64"),
    ),
    Right(
        "public/01h-css-units-same-block.ngc",
        LC_LATHE,
        IDEAL,
        cuts=("N0.4988 F1.613 S194 STROKE 0.1205",),  # 100 feet a minute at diameter 50
        modes=("G97 S194", "G61", "G64", "G20", "G21 G96 D3000 S100"),
        said=("MOD002 1", "MOD002 3"),
    ),
    Right(
        "public/01i-g21-to-g20.ngc",
        LC_LATHE,
        IDEAL,
        cuts=("N0.5 F8.333 S1000 STROKE 0.0048",),
        modes=("G95", "G61", "G94 G21", "G20 F4.", "G64"),
        said=("MOD002 4",),
    ),
    # --- comments: none of ours closes one that the program left open
    Right(
        "public/09a-nested-paren.ngc",
        LC_LATHE,
        IDEAL,
        cuts=(PLAIN_25,),
        modes=("G61", "G64"),
        said=("SYN001 2", "SYN004 5"),
    ),
    Right("public/09b-nested-inline.ngc", LC_LATHE, IDEAL, said=("SYN001 3",), refused=("VIB051 4",)),
    Right("public/09c-tail-looks-like-code.ngc", LC_LATHE, IDEAL, said=("SYN001 4",), refused=("VIB051 5",)),
    Right("public/09d-unclosed.ngc", LC_LATHE, IDEAL, refused=("SYN003 3",)),
    Right("public/09e-unclosed-then-comment.nc", LATHE, refused=("SYN003 2",)),
    Right("public/09f-comment-two-lines.nc", LATHE, said=("SYN003 3",), refused=("VIB018 4",)),
    # --- T0 on a way home is no tool; what is said of operations stands in OPERATIONS
    Right(
        "public/12a-haas-lathe.nc",
        LATHE,
        # The face runs in steps of G96 S420, up to the limit of the spindle near the axis.
        cuts=("N1.5 F12.5 S500 STROKE 0.2438 FIRST OF 10", "N1.5009 F13.158 S526 STROKE 0.3857"),
        modes=("G97 S500", *(f"S{rpm}" for rpm in (588, 714, 833, 1000, 1250, 1429, 1667, 2000, 2500, 526))),
    ),
    Right(
        "public/12b-css-clamp.nc",
        LATHE,
        cuts=("N1.4996 F35.714 S1429 STROKE 0.137 FIRST OF 2",),
        modes=("G97 S1429", "S1667", "G96 S180"),  # not beyond G50 S1800
    ),
    Right(
        "public/12c-css-end-linuxcnc.ngc",
        LC_LATHE,
        IDEAL,
        cuts=("N0.4999 F8.065 S968 STROKE 0.1238",),
        modes=("G97 S968", "G61", "G64", "G96 D1800 S120"),
    ),
    Right(
        "public/12d-haas-title.nc",
        LATHE,
        cuts=("N1.5 F12.5 S500 STROKE 0.0144", "N1.5005 F19.231 S769 STROKE 0.0052"),
        modes=("S769", "S800"),
        said=("VIB061 17",),
    ),
    Right(
        "public/12e-title-gap.nc",
        LATHE,
        cuts=("N1.5 F12.5 S500 STROKE 0.3658", "N1.5005 F19.231 S769 STROKE 0.1314"),
        modes=("S769", "S800"),
        said=("VIB061 18",),
    ),
    Right(
        "public/12f-title-gap-mill.nc",
        MILL,
        BEAM,
        checks=(
            "7 CALIBRATE",
            "8 TOOL CHECK T1, TRACE T1",
            "14 CHIP CHECK T1 W0.02",
            "21 CHIP CHECK T1 W0.05",
        ),
        modes=("M5", "S3000 M3", "M5"),
    ),
    Right("public/12g-lathe-checks-t0.nc", LATHE),
    Right(
        "public/12g-lathe-checks-t0.nc",
        LATHE,
        OWN_CHECK,
        checks=("15 CHIP CHECK T1 W0.02", "25 CHIP CHECK T1 W0.05"),
        modes=("M5", "S800 M3", "M5"),
    ),
    # --- programs that other people's numbers stand in
    Right("public/17a-renishaw-probe.nc", MILL, OUR_9810, said=("CHK010 9",)),
    Right("public/17b-renishaw-only-calls.nc", MILL, OUR_9810, said=("CHK010 10",)),
    Right("public/17c-haas-probe-break.nc", MILL, OUR_9810, said=("CHK010 7",)),
    Right(
        "public/17a-renishaw-probe.nc",
        MILL,
        BEAM,
        checks=("5 CALIBRATE", "17 TOOL CHECK T10, TRACE T10", "25 CHIP CHECK T10 W0.02"),
        modes=("M5",),
    ),
    Right(
        "public/17b-renishaw-only-calls.nc",
        MILL,
        BEAM,
        checks=("4 CALIBRATE", "5 TOOL CHECK T10, TRACE T10"),
        said=("CHK002 15",),
    ),
    Right(
        "public/17c-haas-probe-break.nc",
        MILL,
        BEAM,
        checks=("4 CALIBRATE", "14 TOOL CHECK T10, TRACE T10", "21 CHIP CHECK T10 W0.05"),
        modes=("M5",),
    ),
    # --- S and F beside codes of one block
    Right("public/24a-iosender-turn.ngc", LC_LATHE, IDEAL),
    Right(
        "public/24a-iosender-turn.ngc",
        LC_LATHE,
        (*IDEAL, "vibration.n=0.5"),
        cuts=("N0.5 F8.333 S1000 STROKE 0.24", "N0.5 F8.333 S1000 STROKE 0.12"),
        modes=("G95", "G61", "G94 F200.000", "G64", "G95", "G61", "G94 F100.000", "G64"),
    ),
    Right(
        "public/24c-bare-g97-fanuc.nc",
        LATHE,
        cuts=("N1.5 F31.25 S1250 STROKE 0.12",),
        modes=("S1250", "S1200"),
    ),
    Right("public/24d-g96-bare-g97-fanuc.nc", LATHE, refused=("VIB001 5",)),
    Right(
        "public/24e-s-before-g97.nc",
        LATHE,
        cuts=("N1.5 F31.25 S1250 STROKE 0.12",),
        modes=("S1250", "S1200"),
    ),
    Right(
        "public/24f-s-with-dwell-silent.ngc",
        LC_LATHE,
        cuts=("N0.5001 F9.259 S1111 STROKE 0.1245",),
        modes=("S1111", "G61", "G64", "S1100"),
    ),
    Right("public/24g-s-with-dwell-fanuc.nc", LATHE, cuts=("N1.5 F31.25 S1250 STROKE 0.12",)),
    Right(
        "public/24h-f-with-dwell.ngc",
        LC_LATHE,
        cuts=("N0.5 F8.333 S1000 STROKE 0.24",),
        modes=("G61", "G64"),
    ),
    Right(
        "public/24i-mill-speed-with-dwell.nc",
        MILL,
        BEAM,
        checks=(
            "5 CALIBRATE",
            "6 TOOL CHECK T1, TRACE T1",
            "13 CHIP CHECK T1 W0.02",
            "19 CHIP CHECK T1 W0.02",
            "24 CHIP CHECK T1 W0.05",
        ),
        modes=("M5", "M5", "S8000 M3", "M5"),  # behind the first comes S8000 M3 of the program
    ),
    Right(
        "public/24j-mill-first-speed-with-dwell.nc",
        MILL,
        BEAM,
        checks=("5 CALIBRATE", "6 TOOL CHECK T1, TRACE T1", "12 CHIP CHECK T1 W0.02"),
        modes=("M5",),
    ),
    Right("public/24k-s-dwell-then-plain.nc", LATHE, cuts=("N1.5 F31.25 S1250 STROKE 0.12",)),
    # --- several paths: nothing passes from one to another
    Right("public/32a-two-paths.nc", LATHE, refused=("VIB069 16",)),
    Right("public/32b-two-paths-no-end.nc", LATHE, refused=("VIB069 16",)),
    Right("public/32c-path-inline.nc", LATHE, refused=("VIB048 4",)),
    Right("public/32d-path-marks-profile.nc", LATHE),
    Right("public/32d-path-marks-profile.nc", LATHE, WISH, said=("VIB048 3",)),
    Right("public/32e-sections-leak.nc", LATHE, refused=("VIB069 10",)),
    Right("public/32f-sections-leak-position.nc", LATHE, refused=("VIB069 7",)),
    # --- what real programs met
    Right("held/arc-goes-on-as-line.nc", LATHE, WISH, cuts=(PLAIN_25,)),
    Right("held/bar-puller.nc", LATHE, WISH, cuts=(PLAIN_25,), said=("VIB046 9",)),
    Right(
        "held/clamp-rounding.nc",
        LATHE,
        WISH,
        cuts=("N1.4993 F16.667 S667 STROKE 0.2556",),
        modes=("G97 S667", "G96 S200"),
    ),
    Right(
        "held/cycles-silent.nc",
        LATHE,
        WISH,
        cuts=("N1.5 F25 S1000 STROKE 0.24",) * 8,
        said=("VIB068 10", "VIB067 11", "CYC007 15"),
    ),
    Right("held/feed-of-cycle-missing.nc", LATHE, WISH, cuts=("N1.5 F25 S1000 STROKE 0.36",) * 9),
    Right("held/feed-of-cycle.nc", LATHE, WISH, cuts=(PLAIN_25, *["N1.5 F25 S1000 STROKE 0.36"] * 9)),
    Right("held/g71-in-contour.nc", LATHE),
    Right(
        "held/g71-without-label.nc",
        LATHE,
        WISH,
        cuts=("N1.5 F25 S1000 STROKE 0.36",),
        said=("CYC001 4",),  # once: not as MOD003 and VIB067 too
    ),
    Right("held/g71-without-label.nc", LATHE, said=("MOD003 4",)),
    *(
        Right(
            f"held/{name}.nc",
            MILL,
            BEAM,
            checks=("5 CALIBRATE", "6 TOOL CHECK T1, TRACE T1", "13 CHIP CHECK T1 W0.02"),
            modes=("M5",),
        )
        for name in ("g80-safe-line", "g80-without")
    ),
    Right("held/m9-in-cut.nc", LATHE, WISH, said=("VIB048 3",)),
    Right("held/no-length.nc", LATHE, WISH, cuts=("N1.5 F25 S1000 STROKE 0.24",), said=("VIB023 3",)),
    Right("held/start-behind-cycle.nc", LATHE, WISH, cuts=(PLAIN_25,), said=("VIB067 4",)),
    Right("held/unreadable-head.nc", LATHE, WISH, cuts=(PLAIN_25,), said=("SYN001 1",)),
    # --- random programs
    Right(
        "random/lathe-1696-rejected.ngc",
        LC_LATHE,
        SHORT,
        cuts=("N0.5 F16.667 S2000 STROKE 0.1024", "N1.5 F62.5 S2500 STROKE 0.096"),
        modes=("G61", "F0.08", "G64", "G97 S2500", "G61", "F0.08", "G64", "G96 S150"),
    ),
    Right(
        "random/lathe-2572.ngc",
        LC_LATHE,
        SHORT,
        cuts=("N0.5 F25 S3000 STROKE 0.06",),
        modes=("G61", "F0.05", "G64"),
    ),
    Right(
        "random/lathe-3271.ngc",
        LC_LATHE,
        SHORT,
        cuts=("N1.5 F62.5 S2500 STROKE 0.24", *["N1.5 F62.5 S2500 STROKE 0.06"] * 2),
        modes=(
            *("G97 S2500", "G61", "F0.2", "G64", "G96 D2500 S100"),
            *("G97 S2500", "G61", "F0.05", "G64", "G96 D2500 S100") * 2,
        ),
        said=("VIB064 11", "VIB064 19", "VIB064 21"),
    ),
    Right(
        "random/lathe-528.ngc",
        LC_LATHE,
        SHORT,
        cuts=("N1.5 F62.5 S2500 STROKE 0.096", "N0.5 F25 S3000 STROKE 0.12"),
        modes=("S2500", "G61", "F0.00315", "G64", "S3000", "G61", "F0.1", "G64"),
    ),
    Right(
        "random/lathe-651.ngc",
        LC_LATHE,
        SHORT,
        cuts=(
            "N1.5 F62.5 S2500 STROKE 0.08",
            "N1.5 F62.5 S2500 STROKE 0.1201",
            "N1.5 F62.5 S2500 STROKE 0.096",
        ),
        modes=(
            *("S2500", "G61", "F0.05", "G64", "S3000"),
            *("S2500", "G61", "F0.00394", "G64", "S2500", "G61", "F0.00315", "G64", "S3000"),
        ),
        said=("MOD002 14",),
    ),
    Right(
        "random/mill-1308.ngc",
        LC_MILL,
        SHORT,
        cuts=(
            "N1.5 F62.5 S2500 STROKE 0.06",
            "N0.5 F20.833 S2500 STROKE 0.24",
            "N1.5 F62.5 S2500 STROKE 0.24",
        ),
        modes=(
            *("G97 S2500", "G61", "F0.05", "G64", "G96 D2500 S100"),
            *("G97 S2500", "G61", "F0.2", "G64", "G61", "F0.2", "G64", "G96 D2500 S100"),
        ),
        said=("VIB064 25",),
    ),
    Right(
        "random/mill-1557.ngc",
        LC_MILL,
        SHORT,
        cuts=("N1.5 F62.5 S2500 STROKE 0.12", "N1.5 F62.5 S2500 STROKE 0.096"),
        modes=("S2500", "G61", "F0.1", "G64", "G97 S2500", "G61", "F0.08", "G64", "G96 D2500 S100"),
    ),
    Right(
        "random/mill-1618.ngc",
        LC_MILL,
        SHORT,
        cuts=(
            "N2.5 F50 S1200 STROKE 0.144",
            "N1.5 F62.5 S2500 STROKE 0.12",
            *["N1.5 F62.5 S2500 STROKE 0.06"] * 2,
        ),
        modes=(
            *("S1200", "G61", "F0.1", "G64", "S1250"),
            *("G97 S2500", "G61", "F0.1", "G64", "G96 S150"),
            *("G97 S2500", "G61", "F0.00197", "G64", "G61", "F0.00197", "G64", "G21", "G20 G96 S150"),
        ),
        said=("VIB074 15", "VIB075 15"),
    ),
    Right(
        "random/mill-61.ngc",
        LC_MILL,
        (*SHORT, 'vibration.air="vibrate"'),  # else the way back through air runs at the speed of the cut
        cuts=("N2.5 F62.5 S1500 STROKE 0.096", "N2.4988 F27.778 S667 STROKE 0.0665"),
        modes=(
            *("S1500", "G61", "F0.08", "G64", "S2000"),
            *("G97 S667", "G61", "F0.05", "G64", "G96 D2500 S100"),
        ),
        said=("VIB074 9", "VIB075 9"),
    ),
    Right(
        "random/mill-744.ngc",
        LC_MILL,
        SHORT,
        cuts=("N1.5 F31.25 S1250 STROKE 0.08",),
        modes=("G61", "F0.05", "G64"),
    ),
    Right(
        "random/mill-813.ngc",
        LC_MILL,
        SHORT,
        cuts=("N1.5 F31.25 S1250 STROKE 0.12", *["N1.5 F62.5 S2500 STROKE 0.06"] * 2),
        modes=(
            *("G97 S1250", "G61", "F0.1", "G64"),
            *("S2500", "G61", "F0.05", "G64", "G61", "F0.00197", "G64", "G96 D2500 S100"),
        ),
        said=("VIB064 15", "VIB064 18", "MOD002 22"),
    ),
)

# Two programs, and the lines of each that differ; none where they say the same.
DIFFERENCES = (
    ("public/05a-before.nc", "public/05b-renumbered-right.nc", []),
    # Numbers moved on but not the jumps: the end of the loop, its start, and the start of the program.
    ("public/05a-before.nc", "public/05c-renumbered-wrong.nc", [(5, 5), (7, 7), (9, 9)]),
    ("public/05a-before.nc", "public/05d-numbers-gone.nc", [(5, 5), (7, 7), (9, 9)]),
    ("public/05e-g71-before.nc", "public/05f-g71-wrong.nc", [(3, 3), (8, 8)]),
    ("public/05g-jump-before.nc", "public/05h-jump-moved.nc", [(1, 1)]),
    ("public/37a-parameter-before.nc", "public/37b-parameter-other.nc", [(2, 2)]),
    ("public/37c-macro-before.nc", "public/37d-macro-renumbered.nc", []),
)

# Tools of a file or of a program's comments: type, diameter, corner radius, point, teeth.
TOOLS = {
    "public/16-tool-comments.nc": {
        1: ("drill", 0.8, None, None, None),
        2: ("end mill", 0.2, None, None, None),
        3: ("flat end mill", 16.0, 0.0, None, None),
        4: ("drill", 5.0, None, 118.0, None),
        5: ("end mill", 6.0, None, None, None),
        6: ("end mill", 3.175, None, None, None),
    },
    "public/16b-freecad-tc.ngc": {
        1: ("end mill", 6.0, None, None, None),
        2: ("drill", 5.0, None, None, None),
    },
    "public/16c-coppercam.nc": {
        1: ("chamfer mill", 0.2, None, None, None),
        6: ("drill", 0.8, None, None, None),
    },
    "public/16d-cutviewer.nc": {
        3: ("flat end mill", 16.0, 0.0, None, None),
        4: ("drill", 5.0, None, 118.0, None),
    },
    "public/fcad/Library/lib.fctl": {
        1: ("flat end mill", 6.35, None, None, 2),
        2: ("bull nose end mill", 6.0, 1.5, None, 4),
        3: ("drill", 5.0, None, 119.0, None),
    },
}
# Tool bits, and their numbers in the library.
BITS = {"public/fcad/Bit/a.fctb": 1, "public/fcad/Bit/b.fctb": 2, "public/fcad/Bit/c.fctb": 3}

# Tool, kind and title of each operation.
OPERATIONS = {
    "public/12a-haas-lathe.nc": [(1, "rough", "OD ROUGH"), (2, "unknown", "T2")],
    "public/12d-haas-title.nc": [(1, "rough", "O.D. ROUGHING"), (2, "finish", "O.D. FINISHING")],
    "public/12e-title-gap.nc": [(1, "rough", "OD ROUGH"), (2, "finish", "OD FINISH")],
    "public/12f-title-gap-mill.nc": [(1, "rough", "ADAPTIVE ROUGH"), (1, "finish", "FINISH CONTOUR")],
    "public/12g-lathe-checks-t0.nc": [(1, "rough", "ROUGHING OD"), (1, "finish", "FINISHING OD")],
    "public/16b-freecad-tc.ngc": [(1, "rough", "Adaptive"), (2, "drill", "Drilling")],
    "public/24i-mill-speed-with-dwell.nc": [
        (1, "rough", "ROUGH"),
        (1, "semi-finish", "SEMI FINISH"),
        (1, "finish", "FINISH"),
    ],
}

# Place X (radius), Y, Z [mm], F [mm/rev or mm/min] and S [rpm or m/min] after a line; None where unknown.
STATES = (
    ("public/01a-units-after-feed.ngc", LC_LATHE, 5, (12.7, None, -20.0), 2540.0, 1000.0),
    ("public/01d-units-after-feed-next.ngc", LC_LATHE, 6, (20.0, None, -20.0), 2540.0, 1000.0),
    ("public/01e-f-old-units.ngc", LC_LATHE, 5, (12.7, None, -20.0), 4.0, 1000.0),
    ("public/01f-mill-units-after-feed.ngc", LC_MILL, 6, (0.0, 0.0, -1.0), 2540.0, 3000.0),
    ("public/01h-css-units-same-block.ngc", LC_LATHE, 3, (25.4, None, 2.54), 0.004, 30.48),
    ("public/01i-g21-to-g20.ngc", LC_LATHE, 5, (12.5, None, -20.32), 4.0, 1000.0),
    ("public/24a-iosender-turn.ngc", LC_LATHE, 8, (5.673, None, -10.0), 200.0, 1000.0),
    ("public/24d-g96-bare-g97-fanuc.nc", LATHE, 4, (15.0, None, 2.0), None, None),
    ("public/24g-s-with-dwell-fanuc.nc", LATHE, 4, (15.0, None, -5.0), 0.1, 1250.0),
    ("public/24h-f-with-dwell.ngc", LC_LATHE, 5, (15.0, None, -5.0), 0.2, 1000.0),
    ("public/24i-mill-speed-with-dwell.nc", MILL, 14, (30.0, 0.0, 25.0), 200.0, 8000.0),
    ("held/feed-of-cycle.nc", LATHE, 6, (26.0, None, 2.0), 0.3, 1000.0),
    ("held/start-behind-cycle.nc", LATHE, 4, (15.0, None, 2.0), 0.1, 1000.0),
    ("held/arc-goes-on-as-line.nc", LATHE, 5, (10.0, None, -20.0), 0.1, 1000.0),
    ("random/lathe-2572.ngc", LC_LATHE, 7, (10.0, None, -1.0), 0.1, 3000.0),
)
