"""The programs that check tools on a control, and the blocks that call them: what each control has of them.

Plain data: :mod:`chipbreak.macros` writes the programs, :mod:`chipbreak.checks` the calls.  Lengths in calls
are in mm, whatever the program counts in.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Final

from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple

BUILT_IN: Final = "builtin"
# With a touch plate in the place of a laser.
SETTER: Final = "setter"


class CallTemplates(NamedTuple):
    """Blocks by the kind of check, and what stands behind the last of them.

    ``tails``          behind the last block where a tool has a sister, or not every workpiece is checked
    ``ends_offset``    the calls may end the length offset, as some makers' cycles are known to
    ``returning``      the checks whose program comes back to X and Y of its call, at the safe height
    ``in_line``        the blocks are the check itself, for a control without macros: they set F, and keep a
                       length in the work offset ``keeps``, which a program may not use beside them
    """

    blocks: Mapping[str, Sequence[str]]
    tails: Mapping[str, str] = FrozenTable({})
    ends_offset: bool = False
    returning: Collection[str] = ()
    in_line: bool = False
    keeps: str = ""


class MacroSet(NamedTuple):
    """The check programs of a control.

    ``folder``     where those lie that never change: in ``macros/``, or the path of another folder
    ``written``    file name -> lines of a program that the settings make; a line ``{settings}``, ``{orient}``
                   or one of LINES in braces stands for those of the profile
    ``setting``    the line of one setting: ``{number}`` or ``{name}`` of its variable, ``{value}``, and what
                   it is, as ``{title}`` or in lower case as ``{small_title}``
    ``angle``      the variable in which the angle stands to which the spindle is turned
    ``frame``      what stands around each program in its file
    ``first_signal`` the variable of the first input, to which the number of the beam's input is added
    ``working``    variables in which the programs work, beside those of the store
    ``prefix``     of the names of variables that are theirs; empty where variables have no names
    ``tool_data``  the blocks that hand the data of a tool over, before its check
    ``numbers``    the program numbers of all of them, before a profile moves them; empty where programs
                   have names
    ``arguments``  number -> the letters with which a program may call it; the others are called by these
    ``name_prefix`` of the names of the programs; empty where programs have numbers
    ``mark``       what each file of ours holds, and no other
    """

    folder: str | Path
    written: Mapping[str, Sequence[str]]
    setting: str
    angle: str
    tool_data: Sequence[str]
    frame: str = "{program}"
    first_signal: int = 0
    working: range = range(0)
    prefix: str = ""
    numbers: range = range(0)
    arguments: Mapping[int, str] = FrozenTable({})
    name_prefix: str = ""
    mark: str = "(CHIPBREAK "

    def moved(self, text: str, first_program: int, first_variable: int) -> str:
        """A text of these programs or of their calls, with other program numbers and working variables."""
        if not self.numbers:
            return text
        programs, variables = first_program - self.numbers[0], first_variable - self.working[0]

        def program(hit: re.Match[str]) -> str:
            number = int(hit[2])
            return f"{hit[1]}{number + programs:04d}" if number in self.numbers else hit[0]

        def variable(hit: re.Match[str]) -> str:
            number = int(hit[1])
            return f"#{number + variables}" if number in self.working else hit[0]

        return _VARIABLE.sub(variable, _PROGRAM.sub(program, text))


_PROGRAM = re.compile(r"\b([OP])(\d{4})\b")
_VARIABLE = re.compile(r"#(\d+)")
# Keys of a profile whose lines stand in the programs.
LINES: Final = (
    "laser_on", "laser_off", "air_on", "air_off", "lock_on", "lock_off", "spin_off", "gap_on", "gap_off",
)  # fmt: skip


# The program numbers of makers of probes and tool setters.  Some of ours are among them: a control that has
# their programs has not got ours under the same number.
PROBE_MAKERS: Final[Mapping[str, range]] = FrozenTable(
    {"Renishaw": range(9800, 9900), "Blum": range(9800, 9900), "Haas": range(9800, 9900)}
)


def _program(number: int, title: str, *lines: str) -> dict[str, Sequence[str]]:
    return {f"O{number}.nc": (f"O{number}(CHIPBREAK {title})", *lines, "M99")}


def _sub(name: str, *lines: str) -> dict[str, Sequence[str]]:
    return {f"cb_{name}.ngc": (f"o<cb_{name}> sub", *lines, f"o<cb_{name}> endsub", "M2")}


MACRO_B: Final = MacroSet(
    folder="fanuc",
    written=FrozenTable(
        {
            **_program(8905, "SETTINGS", "{settings}"),
            **_program(
                8912,
                "ORIENT",
                "(A ANGLE)",
                "#1=#1-FIX[#1/360.]*360.",
                "IF [#1 LT 0] THEN #1=#1+360.",
                "{orient}",
            ),
            **_program(8913, "LASER ON", "{lock_on}", "{laser_on}", "{air_on}"),
            **_program(8916, "LASER OFF", "{air_off}", "{laser_off}", "{lock_off}"),
            **_program(8927, "LOOK FOR A MISSING EDGE", "{gap_on}"),
            **_program(8928, "LOOK FOR A BROKEN BEAM", "{gap_off}"),
            **_program(8929, "SPIN OFF", "{spin_off}"),
        }
    ),
    setting="#{number}={value}({title})",
    angle="#1",
    tool_data=(
        "G65 P8904 T{tool}. K{kind}. D{diameter_mm} R{tip} H{length_mm} E{holder_mm} Q{teeth}. B{helix}",
    ),
    frame="%\n{program}%\n",  # a memory card wants each program between two marks
    first_signal=1000,
    working=range(100, 180),
    numbers=range(8900, 8933),
    arguments=FrozenTable(
        {8900: "K", 8901: "TSKU", 8902: "TZSKUWD", 8903: "TWDKU", 8904: "TKDRHEQB", 8919: "T"}
    ),
)
O_WORDS: Final = MacroSet(
    folder="linuxcnc",
    written=FrozenTable(
        {
            **_sub("settings", "{settings}"),
            **_sub("orient", "#<angle> = [#1 - FIX[#1 / 360] * 360]", "{orient}"),
            **_sub("laser_on", "{lock_on}", "{laser_on}", "{air_on}"),
            **_sub("laser_off", "{air_off}", "{laser_off}", "{lock_off}"),
            **_sub("gap_on", "{gap_on}"),
            **_sub("gap_off", "{gap_off}"),
            **_sub("spin_off", "{spin_off}"),
        }
    ),
    setting="#<_cb_{name}> = {value} ({small_title})",
    angle="#<angle>",
    tool_data=(
        "o<cb_tool> call [{tool}] [{kind}] [{diameter_mm}] [{tip}] [{teeth}] [{helix}]",
        "o<cb_length> call [{tool}] [{length_mm}] [{holder_mm}]",
    ),
    prefix="_cb_",
    name_prefix="cb_",
    mark="o<cb_",
)

# Tool data lasts for the TRACE straight behind the check.
_MACRO_B_CALLS = CallTemplates(
    FrozenTable(
        {
            "calibrate": ("G65 P8900",),
            "tool_check": (*MACRO_B.tool_data, "G65 P8901 T{tool}. S{speed_rpm}."),
            "trace": ("G65 P8902 T{tool}. Z{height}",),
            "chip_check": ("G65 P8903 T{tool}. W{limit} D{depth}.",),
        }
    ),
    FrozenTable(
        {
            "calibrate": " K{every}.",
            "tool_check": " K{every}. U{sister}.",
            "trace": " K{every}. U{sister}. W{limit} D{depth}.",
            "chip_check": " K{every}. U{sister}.",
        }
    ),
    returning=("calibrate",),
)
_O_WORD_CALLS = CallTemplates(
    FrozenTable(
        {
            "calibrate": ("o<cb_calibrate> call",),
            "tool_check": (*O_WORDS.tool_data, "o<cb_tool_check> call [{tool}] [{speed_rpm}]"),
            "trace": ("o<cb_trace> call [{tool}] [{height}]",),
            "chip_check": ("o<cb_chip_check> call [{tool}] [{limit}] [{depth_signed}]",),
        }
    ),
    FrozenTable(
        {
            "calibrate": " [{every}]",
            "tool_check": " [{every}] [{sister}]",
            "trace": " [0] [{every}] [{limit}] [{sister}] [{depth_signed}]",
            "chip_check": " [{every}] [{sister}]",
        }
    ),
    returning=("calibrate",),
)


def _makers(block: str) -> CallTemplates:
    """A maker's cycle that compares a tool's length with the one stored on the control."""
    return CallTemplates(FrozenTable({"chip_check": (block,)}), ends_offset=True)


# Of the makers' cycles only what is confirmed stands here: the block that compares a tool's length, to be
# called behind an operation.  Their limit takes W.  All of them are macro B calls of machining centres.
MACRO_B_SETS: Final[Mapping[str, CallTemplates]] = FrozenTable(
    {
        BUILT_IN: _MACRO_B_CALLS,
        "haas": _makers("G65 P9853 T{tool} B0. H{limit}"),
        "renishaw": _makers("G65 P9858 T{tool} H{limit}"),
        "speedio-renishaw": _makers("G65 P8858 B1 H{limit} T{tool}"),
        "speedio-blum": _makers("G65 P8915 B2 Q{limit}"),
    }
)
_O_WORD_SETTER = CallTemplates(
    FrozenTable(
        {
            "tool_check": ("o<cb_setter> call [{tool}]",),
            "chip_check": ("o<cb_setter> call [{tool}] [{limit}]",),
        }
    )
)
O_WORD_SETS: Final[Mapping[str, CallTemplates]] = FrozenTable(
    {BUILT_IN: _O_WORD_CALLS, SETTER: _O_WORD_SETTER}
)

# Grbl stops with alarm 5 where G38.2 meets nothing, and with alarm 4 where a probe move begins on the plate.
# So the tool is judged by the control itself.  It must not have met the plate at W above the stored height: a
# G38.3 that stops before leaves the next move to begin on the plate.  At W below it must have met it.  The
# stored height is Z0 of the work offset G59: G10 L20 P6 gives it to where the tool is.
PLAIN_SETS: Final[Mapping[str, CallTemplates]] = FrozenTable(
    {
        SETTER: CallTemplates(
            FrozenTable(
                {
                    "tool_check": (
                        "G53 G0 Z{safe_z}",
                        "G53 G0 X{setter_x} Y{setter_y}",
                        "G59",
                        "G10 L20 P6 Z0",
                        "G38.2 Z-{setter_depth} F{fast_feed}",
                        "G10 L20 P6 Z0",
                        "G0 Z{clear}",
                        "G38.2 Z-{clear} F{slow_feed}",
                        "G10 L20 P6 Z0",
                        "G53 G0 Z{safe_z}",
                        "{work_offset}",
                    ),
                    "chip_check": (
                        "G53 G0 Z{safe_z}",
                        "G53 G0 X{setter_x} Y{setter_y}",
                        "G59",
                        "G38.3 Z{limit} F{fast_feed}",
                        "G38.2 Z-{limit} F{slow_feed}",
                        "G53 G0 Z{safe_z}",
                        "{work_offset}",
                    ),
                }
            ),
            in_line=True,
            keeps="G59",
        )
    }
)
