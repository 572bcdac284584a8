"""The sections of a machine profile.  A field's metadata says what values are possible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from typing import Any

from chipbreak.dialects import Dialect, find
from chipbreak.dialects.numbers import NumberRule
from chipbreak.kinematics.wave_names import WAVE_NAMES
from chipbreak.settings.axis_words import AXES, AxisWords
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.record import ValueRecord
from chipbreak.trajectory.law_names import LAW_KEYS
from chipbreak.units import mm_per_step


def _one_of(default: str, *others: str) -> Any:
    return field(default=default, metadata={"choices": (default, *others)})


def _above(default: float | None, limit: float = 0.0) -> Any:
    return field(default=default, metadata={"above": limit})


def _at_least(default: float | None, limit: float = 0.0) -> Any:
    return field(default=default, metadata={"at_least": limit})


def _between(default: float, least: float, below: float) -> Any:
    return field(default=default, metadata={"at_least": least, "below": below})


def _digits(default: int) -> Any:
    return field(default=default, metadata={"at_least": 0, "below": 10})


_LONGEST_MS = 60_000.0  # of a filter: no control has a tenth of that


class Shown(NamedTuple):
    """What a program shows of its control where the profile leaves that to it; empty where it does not.

    ``rule`` is what a number without a decimal point is worth, ``system`` its code system (A, B, C).
    ``spindles`` are the words by which it chooses spindles that turn the work (P11).
    """

    rule: str = ""
    system: str = ""
    spindles: tuple[str, ...] = ()


# The value of a key that the program is to show.
SHOWN = "shown"


class Control(ValueRecord):
    """How the control reads and prints blocks."""

    dialect: str = ""
    lathe_system: str = _one_of("A", "B", "C", SHOWN)
    increment_mm: float = _above(0.001)
    decimal_point: str = _one_of("required", "calculator", "increment", SHOWN)
    x_diameter: bool = False
    max_line_chars: int = _at_least(80, 60)
    dwell_word: str = _one_of("", "X", "U", "P")


class Command(ValueRecord):
    """The periods in which the control can command a vibration."""

    base_period_ms: float = _above(4.0)
    min_multiple: int = _at_least(4, 2)
    max_multiple: int | None = _at_least(None, 2)
    multiples: tuple[int, ...] | None = _at_least(None, 2)
    periods_ms: tuple[float, ...] | None = _above(None)


# The kinds of operations, as `(OP ...)` and the rules of the profile name them.
OPERATION_KINDS = ("rough", "semi-finish", "finish", "drill", "thread", "probe", "unknown")


class Vibration(ValueRecord):
    """Defaults for what a program does not say about its vibrated cuts.

    ``n`` ``auto``: the machine chooses N, f and S for each cut, and leaves ``reserve`` of its acceleration;
    of cuts with N and f of their own that leave less it is said.
    ``only`` names the operations for whose cuts the profile asks, kinds or tools (``T3``).  ``refused`` says
    what becomes of a cut that cannot vibrate: ``auto`` leaves those that only the profile asks for.  ``air``
    is what becomes of a feed back through what was just cut.
    """

    n: float | str | None = field(default=None, metadata={"choices": ("auto",), "above": 0.0})
    e: float | None = _above(None)
    f_hz: float | None = _above(None)
    q: float | None = _above(None)
    a_mm: float | None = _above(None)
    margin: float = _at_least(1.2, 1.0)
    reserve: float = _between(0.1, 0.0, 1.0)
    waveform: str = _one_of(*WAVE_NAMES)
    alpha: float = field(default=0.5, metadata={"above": 0.0, "below": 1.0})
    phase: float | str = field(default="auto", metadata={"choices": ("auto",), "above": 0.0, "below": 1.0})
    pn: float | None = _at_least(None)
    mn: float | None = _at_least(None)
    rounding: str = _one_of("nearest-half", "claim-7")
    correct: str = _one_of("spindle", "count")
    ramp_vibrations: float = _at_least(3.0)
    ramp_s: float | None = _at_least(None)
    ramp_exponent: float = _above(1.0)
    end_revolutions: float = _at_least(1.0)
    end: str = _one_of("feed", "dwell")
    chord_mm: float = _above(0.001)
    edges: int = _at_least(1, 1)
    only: tuple[str, ...] = ()
    refused: str = _one_of("auto", "error", "leave")
    air: str = _one_of("leave", "vibrate")


class Output(ValueRecord):
    """How an expanded cut is written.

    ``brackets`` says where it is kept what was there before: in comments, or in a file beside the program.
    """

    feed_mode: str = _one_of("rev", "inverse", "minute")
    segments: str = _one_of("auto", "tick", "stroke")
    form: str = _one_of("expanded", "loop")
    loop_variable: int = field(default=33, metadata={"at_least": 1, "below": 1000})
    decimals: int = _digits(3)
    feed_decimals: int = _digits(5)
    stamp: bool = False
    brackets: str = _one_of("comments", "none")

    def decimals_of(self, *, is_inch: bool) -> int:
        """Decimals of a position: inch programs get one more."""
        return self.decimals + is_inch

    def step_mm(self, *, is_inch: bool) -> float:
        """What the last decimal of a position is worth."""
        return 10.0**-self.decimals * mm_per_step(is_inch=is_inch)

    def feed_decimals_of(self, *, is_inch: bool) -> int:
        """Decimals of F: fine for feed per revolution, three fewer for the larger numbers of other modes."""
        fine = self.feed_decimals + is_inch
        return fine if self.feed_mode == "rev" else max(1, fine - 3)


class Axis(ValueRecord):
    """How the control commands one axis, and what it can do.

    ``letter`` is the axis's own name where it is not set.  ``sign`` is 1 where the tool moves, -1 where the
    work does.  Without numbers an axis is taken to follow any command.  ``increment_mm`` is what it moves by
    at least (of travel, also where X words are diameters), or ``steps_per_mm`` says the same.
    ``acc_dec`` is the filter that the control puts behind its interpolation, of ``acc_dec_ms``, and of
    ``bell_ms`` besides where it is bell-shaped.  The position loop follows with its gain; ``feed_forward`` is
    the share of its lag that the control makes up for.
    """

    letter: str | None = field(default=None, metadata={"choices": tuple("XYZUVWABC")})
    sign: int = field(default=1, metadata={"values": (1, -1)})
    max_velocity_mm_min: float | None = _above(None)
    max_acceleration_mm_s2: float | None = _above(None)
    position_gain_1_s: float | None = _at_least(None, 0.1)
    feed_forward: float = field(default=0.0, metadata={"at_least": 0.0, "at_most": 1.0})
    acc_dec: str = _one_of("linear", "exponential", "bell")
    acc_dec_ms: float | None = field(default=None, metadata={"at_least": 0.0, "at_most": _LONGEST_MS})
    bell_ms: float | None = field(default=None, metadata={"above": 0.0, "at_most": _LONGEST_MS})
    # A coarser axis cuts nothing that anybody measures, and no stroke is left on it.
    increment_mm: float | None = field(default=None, metadata={"above": 0.0, "at_most": 0.1})
    steps_per_mm: float | None = _at_least(None, 10.0)

    @property
    def step_mm(self) -> float:
        """What the axis moves by at least [mm of travel]; 0 where nobody said it."""
        if self.increment_mm is not None:
            return self.increment_mm
        return 0.0 if self.steps_per_mm is None else 1.0 / self.steps_per_mm


class Planner(ValueRecord):
    """How the control times blocks, and the path mode and smoothing it needs around a vibrated cut.

    Corners are passed at the speed that ``junction_deviation_mm`` allows, or at that of
    ``corner_velocity_mm_s``, which is meant for a right angle.  ``min_cruise_ratio`` is the share of a short
    move that runs evenly.  The limits of the path count in every direction, beside those of the axes.
    A dwell takes whole ``dwell_step_ms``.  No move is slower than ``least_feed_mm_min``, nor its steps than
    ``least_steps_per_s``.  For ``segment_ms`` at once the control works out its steps.
    ``override_off`` and ``override_on`` are the blocks around a vibrated cut that hold the overrides at 100 %
    and give them back: they would take N with them.
    ``uncertainty`` is the share by which these numbers, and those of the axes, may be off.
    ``numbers_at`` says to people where these numbers, and those of the axes, are kept on the control.
    """

    model: str = _one_of(*LAW_KEYS)
    servo_period_ms: float = _above(1.0)
    max_blocks_per_s: float | None = _above(None)
    max_bytes_per_s: float | None = _above(None)
    dwell_step_ms: float | None = _above(None)
    reversal_stop_ms: float = _at_least(0.0)
    joint_speed_mm_min: float | None = _at_least(None)
    max_feed_override: float | None = _at_least(None, 1.0)
    junction_deviation_mm: float | None = _at_least(None)
    corner_velocity_mm_s: float | None = _at_least(None)
    min_cruise_ratio: float = field(default=0.0, metadata={"at_least": 0.0, "below": 1.0})
    path_velocity_mm_min: float | None = _above(None)
    path_acceleration_mm_s2: float | None = _above(None)
    look_ahead_blocks: int | None = _at_least(None, 3)
    least_steps_per_s: float | None = _at_least(None)
    least_feed_mm_min: float | None = _at_least(None)
    segment_ms: float | None = _above(None)
    uncertainty: float = field(default=0.0, metadata={"at_least": 0.0, "below": 0.5})
    path_mode: str = ""
    usual_path_mode: str = "G64"
    smoothing_off: str = ""
    smoothing_on: str = ""
    override_off: tuple[str, ...] = ()
    override_on: tuple[str, ...] = ()
    numbers_at: str = ""


class Spindle(ValueRecord):
    """What the spindle can do, and how far from the programmed speed the machine may choose.

    ``speed_tolerance`` and ``surface_tolerance`` are shares of the programmed S, in rpm and under G96.
    ``cw_codes``, ``ccw_codes`` and ``stop_codes`` are M codes of this spindle beside M3, M4 and M5;
    ``cw_flood_codes`` and ``ccw_flood_codes`` switch coolant on as well.
    """

    min_rpm: float = _at_least(0.0)
    max_rpm: float | None = _at_least(None, 1.0)
    speed_tolerance: float = _between(0.2, 0.0, 1.0)
    surface_tolerance: float = field(default=0.2, metadata={"above": 0.0, "below": 1.0})
    resolution_rpm: float = field(default=1.0, metadata={"at_least": 0.001, "below": 1000.0})
    settle_s: float = field(default=0.0, metadata={"at_least": 0.0, "below": 600.0})
    cw_codes: tuple[int, ...] = field(default=(), metadata={"at_least": 1, "below": 10_000})
    ccw_codes: tuple[int, ...] = field(default=(), metadata={"at_least": 1, "below": 10_000})
    stop_codes: tuple[int, ...] = field(default=(), metadata={"at_least": 1, "below": 10_000})
    cw_flood_codes: tuple[int, ...] = field(default=(), metadata={"at_least": 1, "below": 10_000})
    ccw_flood_codes: tuple[int, ...] = field(default=(), metadata={"at_least": 1, "below": 10_000})


class Checks(ValueRecord):
    """Tool checks: whether, which calls, which limits.

    ``strict`` makes an error of a check that is left out.  ``sister`` is the tool that may take another one's
    place.  ``every`` is how many workpieces one check is for.  Runout, length, diameter, the step of a trace,
    retries and alarm numbers go into the macros.
    """

    enabled: bool = False
    strict: bool = False
    calls: str = "builtin"
    w_rough_mm: float = _above(0.05)
    w_finish_mm: float = _above(0.02)
    w_mm: Mapping[str, float] = field(default_factory=FrozenTable, metadata={"above": 0.0, "table": True})
    runout_mm: float = _above(0.005)
    length_over_mm: float = _above(3.0)
    diameter_mm: float = _above(0.5)
    trace_height_mm: float = _above(20.0)
    trace_step_mm: float = _above(1.0)
    trace_chip_mm: float = _above(0.2)
    depth: str = _one_of("limit-line", "breakage", "full")
    last_use: float | str = field(
        default="next-part", metadata={"choices": ("next-part", "none"), "above": 0.0}
    )
    missing: str = _one_of("control", "error", "skip")
    only: tuple[int, ...] = ()
    ignore: tuple[int, ...] = ()
    sister: Mapping[str, int] = field(
        default_factory=FrozenTable, metadata={"at_least": 1, "below": 100_000_000, "table": True}
    )
    every: int = _between(1, 1, 10_000)
    retries: int = _between(1, 0, 100)
    alarm_base: int = _between(100, 1, 9_900)


class Macros(ValueRecord):
    """What the macros must know about the machine and its laser barrier; lengths in mm, feeds in mm/min.

    Positions are in machine coordinates.  ``beam_input`` is the number of the signal variable (#1000 and up)
    or of LinuxCNC's digital input, ``gate_output`` of the digital output there that lets probe moves see it.
    ``setter_x_mm`` to ``setter_z_mm``: where a touch plate is, the last the lowest place of the spindle nose.
    ``master_tool`` 0: somebody puts the master bar into the spindle.  ``orient`` stops the spindle at
    ``{angle}``.  ``turn_sign`` is -1 where the angle counts against M3.  ``first_program`` and
    ``first_variable`` are the numbers from which on the programs and their working variables count on Fanuc.
    ``settle_s`` is how long the signal stays after an edge.  ``gap_ms``: after how long without an edge the
    barrier gives its signal once ``gap_on`` has run; 0: it cannot.  ``clear_mm`` is how far beside and above
    the beam the tool waits, ``search_mm`` how much shorter than said a tool may be and still be found,
    ``above_mm`` how far above the lower end, a corner or a point the radius is measured, ``inset_mm`` how far
    inside the outer edge the length is.  ``pulled_mm`` is how much lower than stored a tool may hang that the
    cut has pulled out: so far above the beam the rapid of a CHIP CHECK ends.  ``store_first`` and
    ``store_last`` bound the variables of what is stored.
    """

    beam_x_mm: float | None = None
    beam_y_mm: float | None = None
    beam_z_mm: float | None = None
    safe_z_mm: float | None = None
    setter_x_mm: float | None = None
    setter_y_mm: float | None = None
    setter_z_mm: float | None = None
    master_length_mm: float | None = _above(None)
    master_diameter_mm: float | None = _above(None)
    master_tool: int = _at_least(0)
    beam_input: int = _at_least(0)
    gate_output: int = _at_least(0)
    approach_feed: float = _above(10000.0)
    entry_feed: float = _above(3000.0)
    fast_feed: float = _above(600.0)
    slow_feed: float = _above(12.0)
    clear_mm: float = _above(2.0)
    back_mm: float = _above(0.02)
    settle_s: float = _at_least(0.03)
    gap_ms: float = _at_least(0.0)
    beam_within_mm: float = _above(2.0)
    bar_within_mm: float = _above(0.1)
    search_mm: float = _above(10.0)
    pulled_mm: float = _at_least(20.0)
    above_mm: float = _above(0.1)
    inset_mm: float = _above(0.3)
    resolution_mm: float = _above(0.001)
    turn_sign: int = field(default=1, metadata={"values": (1, -1)})
    store_first: int = _at_least(500, 1)
    store_last: int = _at_least(999, 1)
    first_program: int = _between(8900, 1, 9969)
    first_variable: int = _between(100, 100, 900)
    orient: str = "M19 R{angle}"
    laser_on: str = ""
    laser_off: str = ""
    air_on: str = ""
    air_off: str = ""
    lock_on: str = ""
    lock_off: str = ""
    spin_off: str = ""
    gap_on: str = ""
    gap_off: str = ""


class Tools(ValueRecord):
    """Files with tool data, the first that says something first; ``table_unit`` is that of ``tool.tbl``.

    ``nose_radius_mm`` and ``nose_tip`` are R and T of the offset screen, by the number of the offset.
    ``other_nose_radius_mm`` and ``other_nose_tip`` are taken for offsets of which nothing says them: assumed.
    """

    files: tuple[str, ...] = ()
    table_unit: str = _one_of("program", "mm", "inch")
    nose_radius_mm: Mapping[str, float] = field(
        default_factory=FrozenTable, metadata={"above": 0.0, "table": True}
    )
    nose_tip: Mapping[str, int] = field(
        default_factory=FrozenTable, metadata={"at_least": 0, "below": 10, "table": True}
    )
    other_nose_radius_mm: float | None = _above(None)
    other_nose_tip: int | None = field(default=None, metadata={"at_least": 1, "below": 9})


class Cycles(ValueRecord):
    """Roughing and finishing cycles that are written out as plain blocks.

    ``unroll``: those whose cuts are asked to vibrate, all, or none.  ``depth_unit`` is what D without a
    decimal point counts in a block that says the whole cycle.  ``retract_mm`` is how far the tool goes back
    where the cycle does not say it.  ``plain_corners``: C, R, I, K and A without a comma in a straight move
    of a contour are a chamfer, a radius and an angle.  ``nose_in_roughing`` is what G41 and G42 are to G71,
    G72 and G73: nothing, or what they are to G70.  ``finish_pass`` says which types of G71 and G72 end with
    a pass along the contour with its allowances.
    """

    unroll: str = _one_of("asked", "always", "never")
    depth_unit: str = _one_of("increment", "program")
    retract_mm: float = _at_least(0.5)
    plain_corners: bool = True
    nose_in_roughing: str = _one_of("ignored", "compensated")
    finish_pass: str = _one_of("always", "type-1", "type-2", "never")


class Times(ValueRecord):
    """What the time of a whole program is worked out with, where the axes do not say it.

    ``rapid_mm_min`` is the speed of rapids, and goes before the fastest that the axes are said to move.
    ``tool_change_s`` is from chip to chip.
    """

    rapid_mm_min: float | None = _above(None)
    tool_change_s: float | None = _at_least(None)


class Passes(ValueRecord):
    """Passes of other installed packages that run behind the shipped ones, in the order of their names."""

    extra: tuple[str, ...] = ()


class Settings(ValueRecord):
    """Everything a run needs to know about the machine.  ``origins`` maps ``section.key`` to its source.

    ``plugins`` holds the options of each pass of another package as the profile says them, unchecked.
    ``shown`` is what the program at hand shows of its control.
    """

    name: str
    control: Control
    command: Command
    vibration: Vibration
    output: Output
    spindle: Spindle
    checks: Checks
    macros: Macros
    tools: Tools
    planner: Planner
    passes: Passes
    cycles: Cycles
    times: Times
    axes: Mapping[str, Axis]
    axis_words: AxisWords
    call_sets: Mapping[str, Mapping[str, tuple[str, ...]]]
    operations: Mapping[str, tuple[str, ...]]
    plugins: Mapping[str, Mapping[str, Any]]
    dialect: Dialect
    origins: Mapping[str, str]
    shown: Shown = Shown()

    def __repr__(self) -> str:
        return f"<Settings {self.name!r}: {self.dialect.title}>"

    @property
    def number_rule(self) -> NumberRule:
        """What a number without a decimal point is worth on this machine."""
        return self.dialect.number_rules[self.shown.rule or self.control.decimal_point]

    def as_shown(self, shown: Shown) -> Settings:
        """The same for a program that shows this of its control."""
        if shown == self.shown:
            return self
        dialect = find(self.dialect.name, shown.system) if shown.system else self.dialect
        # The profile has given these to the one dialect, and gives them to the other.
        dialect = dialect._replace(m_codes=self.dialect.m_codes, dwell_word=self.dialect.dwell_word)
        return replace(self, shown=shown, dialect=dialect)

    def origin(self, key: str) -> str:
        """Where the value of ``section.key`` came from, for messages."""
        return self.origins.get(key, "default")

    def acceleration_mm_s2(self, axis: str) -> float | None:
        """What an axis has, for itself or along the path; None where nobody said it."""
        said = (self.axes[axis].max_acceleration_mm_s2, self.planner.path_acceleration_mm_s2)
        return min((one for one in said if one is not None), default=None)

    def axis_step_mm(self, axis: str, *, is_diameter: bool) -> float:
        """What an axis moves by at least [mm of travel]; 0 where the profile does not say it."""
        one = self.axes[axis]
        if one.step_mm > 0.0:
            return one.step_mm
        if "control.increment_mm" not in self.origins:
            return 0.0
        return self.control.increment_mm / (2.0 if is_diameter else 1.0)


# Variables of the macros: 4 of the beam, 11 of locked tools and the count, and one small edge.
LEAST_STORE = 40

SECTIONS: Mapping[str, type[Any]] = {
    "control": Control,
    "command": Command,
    "vibration": Vibration,
    "output": Output,
    "planner": Planner,
    "spindle": Spindle,
    "checks": Checks,
    "macros": Macros,
    "tools": Tools,
    "passes": Passes,
    "cycles": Cycles,
    "times": Times,
    **{f"axes.{axis}": Axis for axis in AXES},
}
# Tables whose keys the user chooses: operation kinds with regular expressions, named sets of calls, options
# of passes that other packages offer.
OPEN_SECTIONS = ("operations", "calls", "plugins")
