"""The call sets that come with chipbreak: those of its own macros, and of makers' cycles.

Of the makers' cycles only what is confirmed stands here: the block that compares a tool's length with the
one stored on the control, to be called behind an operation.  Their limit takes W.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from chipbreak.text.frozen_table import FrozenTable


class ShippedCalls(NamedTuple):
    """Blocks by event, and what stands behind the last of them.

    ``tails``          behind the last block where a tool has a sister, or not every workpiece is checked
    ``ends_offset``    the calls may end the length offset, as one of these cycles is known to
    """

    blocks: Mapping[str, Sequence[str]]
    tails: Mapping[str, str] = FrozenTable({})
    ends_offset: bool = False


# Tool data is in mm, whatever the program counts in; it lasts for the TRACE straight behind the check.
_FANUC = ShippedCalls(
    {
        "calibrate": ("G65 P9810",),
        "tool_check": (
            "G65 P9814 T{tool} K{kind} D{diameter_mm} R{tip} H{length_mm} E{holder_mm} Q{teeth} B{helix}",
            "G65 P9811 T{tool} S{speed_rpm}",
        ),
        "trace": ("G65 P9812 T{tool} Z{height}",),
        "chip_check": ("G65 P9813 T{tool} W{limit} Z{height}",),
    },
    {
        "calibrate": " K{every}",
        "tool_check": " K{every} U{sister}",
        "trace": " K{every}",
        "chip_check": " K{every} U{sister}",
    },
)
_LINUXCNC = ShippedCalls(
    {
        "calibrate": ("o<cb_calibrate> call",),
        "tool_check": (
            "o<cb_tool> call [{tool}] [{kind}] [{diameter_mm}] [{tip}] [{teeth}] [{helix}]",
            "o<cb_length> call [{tool}] [{length_mm}] [{holder_mm}]",
            "o<cb_tool_check> call [{tool}] [{speed_rpm}]",
        ),
        "trace": ("o<cb_trace> call [{tool}] [{height}]",),
        "chip_check": ("o<cb_chip_check> call [{tool}] [{limit}] [{height}]",),
    },
    {
        "calibrate": " [{every}]",
        "tool_check": " [{every}] [{sister}]",
        "trace": " [0] [{every}]",
        "chip_check": " [{every}] [{sister}]",
    },
)
BUILT_IN: Final[Mapping[str, ShippedCalls]] = {"fanuc-mill": _FANUC, "linuxcnc-mill": _LINUXCNC}

NAMED: Final[Mapping[str, ShippedCalls]] = {
    "haas": ShippedCalls({"chip_check": ("G65 P9853 T{tool} B0. H{limit}",)}, ends_offset=True),
    "renishaw": ShippedCalls({"chip_check": ("G65 P9858 T{tool} H{limit}",)}, ends_offset=True),
    "speedio-renishaw": ShippedCalls({"chip_check": ("G65 P8858 B1 H{limit} T{tool}",)}, ends_offset=True),
    "speedio-blum": ShippedCalls({"chip_check": ("G65 P8915 B2 Q{limit}",)}, ends_offset=True),
}
# All of them are macro B calls of machining centres.
NAMED_DIALECT: Final = "fanuc-mill"
