"""The files that make a simulated machine out of LinuxCNC: INI, HAL and tool table, as text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from .rs274 import ANY_TOOL, START_UP


class Limit(NamedTuple):
    """What one axis can do."""

    axis: str
    acceleration_mm_s2: float
    velocity_mm_s: float


def limits(
    axes: str, acceleration: float | Sequence[float], velocity: float | Sequence[float]
) -> list[Limit]:
    """One entry per axis; a single number holds for all of them."""
    return [Limit(*row) for row in zip(axes, _each(acceleration, axes), _each(velocity, axes), strict=True)]


def _each(value: float | Sequence[float], axes: str) -> list[float]:
    return [float(value)] * len(axes) if isinstance(value, int | float) else [float(one) for one in value]


def ini(
    folder: Path,
    axes: Sequence[Limit],
    servo_period_s: float,
    *,
    lathe: bool,
    max_feed_override: float = 1.0,
) -> str:
    """The INI file.  The trajectory section carries limits so high that only the axes' own ones count.

    The task, which hands over one block in each of its cycles, runs five times as often as usual: so the
    sped-up motion need not wait for it.
    """
    names = [limit.axis for limit in axes]
    joints = "".join(_joint(number, limit) for number, limit in enumerate(axes))
    return f"""[EMC]
VERSION = 1.1
MACHINE = test
DEBUG = 0
[DISPLAY]
DISPLAY = {folder}/driver.py
LATHE = {int(lathe)}
MAX_FEED_OVERRIDE = {max_feed_override!r}
[RS274NGC]
PARAMETER_FILE = parameters.var
SUBROUTINE_PATH = {folder}/subs
RS274NGC_STARTUP_CODE = {START_UP[lathe].decode()}
[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 30.0
SERVO_PERIOD = {round(servo_period_s * 1e9)}
[TASK]
TASK = milltask
CYCLE_TIME = 0.0002
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.1
TOOL_TABLE = tool.tbl
[HAL]
HALFILE = machine.hal
[TRAJ]
NO_FORCE_HOMING = 1
COORDINATES = {" ".join(names)}
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
DEFAULT_LINEAR_VELOCITY = 50
MAX_LINEAR_VELOCITY = 100000
DEFAULT_LINEAR_ACCELERATION = 1000000
MAX_LINEAR_ACCELERATION = 1000000
[KINS]
KINEMATICS = trivkins coordinates={"".join(names)}
JOINTS = {len(names)}
[SPINDLE_0]
MAX_FORWARD_VELOCITY = 6000
{joints}"""


def _joint(number: int, limit: Limit) -> str:
    """One axis and its joint; it is at home wherever it stands, so homing moves nothing."""
    both = f"""MIN_LIMIT = -10000
MAX_LIMIT = 10000
MAX_VELOCITY = {limit.velocity_mm_s!r}
MAX_ACCELERATION = {limit.acceleration_mm_s2!r}
"""
    return f"""[AXIS_{limit.axis}]
{both}[JOINT_{number}]
TYPE = LINEAR
HOME = 0
HOME_OFFSET = 0
HOME_SEARCH_VEL = 0
HOME_LATCH_VEL = 0
HOME_SEQUENCE = 0
FERROR = 100
MIN_FERROR = 100
{both}"""


def hal(axes: str) -> str:
    """The wiring: every axis follows its command at once, the spindle turns as told, all of it is sampled."""
    loops = "".join(
        f"net at-{axis} joint.{number}.motor-pos-cmd => joint.{number}.motor-pos-fb sampler.0.pin.{number}\n"
        for number, axis in enumerate(axes)
    )
    return f"""loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
loadrt sim_spindle names=turning
loadrt sampler depth=20000 cfg={"f" * len(axes)}s
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf turning servo-thread
addf sampler.0 servo-thread
setp sampler.0.enable 0
{loops}net line motion.program-line => sampler.0.pin.{len(axes)}
net spindle-speed spindle.0.speed-out-rps => spindle.0.speed-in turning.velocity-cmd
net spindle-turns turning.position-fb => spindle.0.revs
net spindle-index turning.index-enable <=> spindle.0.index-enable
setp spindle.0.at-speed 1
net enable iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net tool-ready iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net tool-changed iocontrol.0.tool-change => iocontrol.0.tool-changed
"""


def tool_table() -> str:
    """Tools 1 to 50 without offsets."""
    return "".join(tool.line() + "\n" for tool in ANY_TOOL[:50])
