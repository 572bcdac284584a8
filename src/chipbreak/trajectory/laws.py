"""The laws of control, one a kind of control; ``planner.model`` of a profile names one of them."""

from __future__ import annotations

from chipbreak.trajectory.after_interpolation import AfterInterpolation
from chipbreak.trajectory.ideal import Ideal
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.law import ControlLaw
from chipbreak.trajectory.linuxcnc import LinuxCnc
from chipbreak.trajectory.look_ahead import LookAhead
from chipbreak.trajectory.trapezoid import Trapezoid

LAWS: tuple[type[ControlLaw], ...] = (
    Ideal,  # nothing known: the blocks, exactly; what profiles have that say nothing
    Trapezoid,  # a rest at every reversal, and the acceleration that the profile declares
    AfterInterpolation,  # Fanuc and alike: the blocks exactly, then the filters of the axes
    LookAhead,  # the same with AI contour control
    Junction,  # junction deviation: Grbl, grblHAL, Klipper
    LinuxCnc,  # LinuxCNC's planner, period by period
)


def law_named(name: str) -> type[ControlLaw]:
    """The law of this name.  Errors: KeyError."""
    return {law.name: law for law in LAWS}[name]
