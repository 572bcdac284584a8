"""The passes: each reads the original program and plans edits; of others it sees what its context says."""

from chipbreak.passes.base import Pass
from chipbreak.passes.check_tools import CHECK_TOOLS, CheckTools
from chipbreak.passes.plug_ins import plug_ins_of
from chipbreak.passes.speeds import CuttingSpeeds
from chipbreak.passes.vibrate import VIBRATE, Vibrate
from chipbreak.settings.sections import Settings

__all__ = ["CHECK_TOOLS", "PASSES", "VIBRATE", "Pass", "passes_of"]

# In the order in which they plan.  Of two insertions before one line, what was planned later stands first.
PASSES: tuple[Pass, ...] = (
    CheckTools(),  # tool checks between operations
    CuttingSpeeds(),  # V and D become S
    Vibrate(),  # cuts that break their chips; it must know where the spindle is started again
)


def passes_of(settings: Settings) -> tuple[Pass, ...]:
    """The passes of a run: ours, and behind them those of other packages that the profile names."""
    return (*PASSES, *plug_ins_of(settings))
