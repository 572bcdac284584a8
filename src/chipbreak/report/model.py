"""The facts of a run as frozen values: text, JSON and other programs read the same ones.

Lengths are in mm, times in s, speeds in rpm and mm/s, feeds in mm per revolution; lines count from 1 in the
user's file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

from chipbreak.kinematics.chip_model import Verdict
from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.report.as_text import report_lines
from chipbreak.report.schema import SCHEMA
from chipbreak.report.summary import summary_line
from chipbreak.text.diagnostics import Diagnostic


@dataclass(frozen=True)
class FlankClearance:
    """Flank clearance that the forward stroke uses up [degrees] at a diameter [mm]."""

    diameter_mm: float
    deg: float


@dataclass(frozen=True)
class MovedAxis:
    """The letter whose words move an axis, and what they move: ``tool`` or ``work``."""

    letter: str
    by: str


@dataclass(frozen=True)
class ExplainedLoop:
    """``vibrations`` vibrations in ``blocks`` blocks, run through ``passes`` times.

    ``drift_steps`` is what all passes together lack to the exact advance, in steps of the output.
    """

    vibrations: int
    passes: int
    drift_steps: float
    blocks: int


@dataclass(frozen=True)
class ToldMotion:
    """What is said of the motion of a cut, in words of its kind.

    ``name`` is ``stroke`` or ``dwell``, ``size`` how large it is, ``need`` what it asks of the machine, and
    ``without_count`` what is said where no N was reached; empty where that is no news.
    """

    name: str
    size: str
    need: str
    without_count: str


@dataclass(frozen=True)
class ExplainedCut:
    """One vibrated cut: what was asked for, what it became and why, and what that does.

    ``block``      its first block as it stands in the program
    ``given``      N, F (Hz), Q and so on -> the value, and who gave it
    ``reasons``    why that was changed
    ``speed_rpm``, ``per_rev``, ``frequency_hz``, ``period_s``  spindle speed, vibrations per revolution, and
                   frequency, as commanded
    ``stroke_mm``  of one vibration;  ``advance_mm``  what the tool feeds in one;  ``motion``  that in words
    ``alpha_share``  share of a vibration in which the tool moves forward
    ``stand_s``    how long the tool stands in each vibration of a dwell, 0 for others;  ``end_stand_s``  at
                   the end of the cut
    ``moves``      blocks of motion that the control runs
    ``output_form``  ``expanded`` or ``loop``;  ``loops``  what repeats
    ``duration_s``  of the cut as it is now;  ``programmed_s``  as it was written, None where nobody knows
    ``control``    the law by which the control times the moves;  ``unproven``  no control is known to follow
                   it: the verdict says what a control would do that follows the blocks exactly
    ``acceleration_mm_s2``  the least that an axis must have;  ``acceleration_share``  of what it has, None
                   where nobody says that
    ``override_band``  from which to which feed override, 1 for 100 %, its chips break at this spindle speed;
                   ``holds_override``  the cut holds it at 100 %
    ``follows_spindle``  the blocks say feed per revolution: N stays when the spindle droops
    ``servo_share``  what the axes make of the commanded stroke, None where they are taken to follow;
                   ``delay_s``  by how much they are late;  ``path_error_mm``  how far they leave the path;
                   ``looks``  how often a vibration their motion was looked at
    ``margin_off``  how far the margin may be off, as the numbers of the machine may be; 0 where that is not
                   said, or far from 1;  ``on_edge``  the margin is nearer to 1 than that
    ``moved``      axis -> what moves it, where the profile says so
    """

    first_line: int
    last_line: int
    given: Mapping[str, SourcedValue]
    reasons: tuple[str, ...]
    speed_rpm: float
    per_rev: float
    frequency_hz: float
    feed_mm_rev: float
    stroke_mm: float
    waveform: str
    alpha_share: float
    stand_s: float
    end_stand_s: float
    moves: int
    loops: tuple[ExplainedLoop, ...]
    duration_s: float
    control: str
    acceleration_mm_s2: float
    servo_share: float | None
    flank_clearance: tuple[FlankClearance, ...]
    moved: Mapping[str, MovedAxis]
    verdict: Verdict
    block: str
    period_s: float
    advance_mm: float
    output_form: str
    motion: ToldMotion
    programmed_s: float | None = None
    delay_s: float | None = None
    path_error_mm: float | None = None
    looks: float | None = None
    unproven: bool = False
    acceleration_share: float | None = None
    override_band: tuple[float, float] | None = None
    follows_spindle: bool = False
    holds_override: bool = False
    margin_off: float = 0.0
    on_edge: bool = False

    @property
    def written_moves(self) -> int:
        """Blocks of motion that stand in the program: what repeats stands there once."""
        return self.moves - sum(loop.blocks * (loop.passes - 1) for loop in self.loops)


@dataclass(frozen=True)
class ExplainedLeft:
    """A cut that was asked to vibrate and stays as it was.

    ``code``      of what stood in its way, empty for a feed back through air
    ``reason``, ``way_out``  that in words
    ``asked_by``  ``directive`` or ``profile``
    ``is_cut``    False for a move that cuts nothing
    """

    first_line: int
    last_line: int
    block: str
    code: str
    reason: str
    way_out: str
    asked_by: str
    is_cut: bool


@dataclass(frozen=True)
class ExplainedUnasked:
    """The cuts of an operation that nothing asks to vibrate: so many ``blocks``, and the ``reason``."""

    operation: str
    first_line: int
    last_line: int
    blocks: int
    reason: str


@dataclass(frozen=True)
class ExplainedOperation:
    """What one tool does from ``first_line`` to ``last_line``: its ``kind``, and the ``reason`` for that."""

    tool: int | None
    kind: str
    label: str
    reason: str
    first_line: int
    last_line: int


@dataclass(frozen=True)
class ExplainedCheck:
    """A tool check that is inserted before ``line``, or behind the last one where ``is_at_end``.

    ``duration_s`` is about how long it takes, None where nobody knows; ``otherwise_s`` how long by other
    settings, each as it is written.
    """

    line: int
    title: str
    reason: str
    is_at_end: bool
    duration_s: float | None = None
    otherwise_s: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ExplainedCycle:
    """A cycle that was written out: so many ``passes``, in which so many cuts (``vibrated``) vibrate.

    ``depth_mm``  of each pass as a radius, None where they have no common one
    ``before_s``, ``after_s``  how long the cycle takes as it was, and with its vibrated cuts
    """

    line: int
    block: str
    kind: str
    passes: int
    depth_mm: float | None
    vibrated: int
    before_s: float
    after_s: float


@dataclass(frozen=True)
class TimePart:
    """What a program spends time on: as it was written, and filtered."""

    name: str
    before_s: float
    after_s: float


@dataclass(frozen=True)
class Assumption:
    """What was taken where nobody says it, in short words; ``key`` of the profile would say it, if any."""

    what: str
    key: str


@dataclass(frozen=True)
class UntimedLine:
    """A line whose time nobody knows, and why."""

    line: int
    why: str


@dataclass(frozen=True)
class CycleTime:
    """How long the whole program runs, as it was written and filtered.

    ``assumed`` is what was taken where neither profile nor program says it;  ``untimed`` are lines whose time
    is in neither sum.
    """

    before_s: float
    after_s: float
    parts: tuple[TimePart, ...]
    assumed: tuple[Assumption, ...]
    untimed: tuple[UntimedLine, ...]


@dataclass(frozen=True)
class Report:
    """All that is said of a run.  ``str()`` of it is what ``chipbreak explain`` prints.

    ``left`` are the cuts that were asked to vibrate and stay as they were.  ``without_axis_data``: an axis of
    a vibrated cut has no acceleration in the profile.  ``feed_s`` is how long the program feeds as it is
    written, where checks are inserted and it can be known.  ``time`` is that of the whole program, None where
    nothing of it can be timed.  ``unasked`` are the cuts that nothing asks to vibrate.  ``cycles`` are those
    that were written out.
    """

    file: str
    profile: str
    changed: bool
    cuts: tuple[ExplainedCut, ...]
    operations: tuple[ExplainedOperation, ...]
    checks: tuple[ExplainedCheck, ...]
    diagnostics: tuple[Diagnostic, ...]
    left: tuple[ExplainedLeft, ...] = ()
    without_axis_data: bool = False
    feed_s: float | None = None
    time: CycleTime | None = None
    unasked: tuple[ExplainedUnasked, ...] = ()
    cycles: tuple[ExplainedCycle, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The facts as plain values, in a stable order, ready for JSON; ``schema`` is their version."""
        return {"schema": SCHEMA, **_fields(self)}

    def lines(self) -> Iterator[str]:
        """The facts as lines of text."""
        return report_lines(self)

    def summary(self) -> str:
        """The run in one line: what vibrates, what stays as it was, checks, time before and after."""
        return summary_line(self)

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def __repr__(self) -> str:
        counts = f"{len(self.cuts)} cuts, {len(self.operations)} operations, {len(self.checks)} checks"
        return f"<Report of {self.file!r}: {counts}>"


def _fields(value: Any) -> dict[str, Any]:
    return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}


def _plain(value: Any) -> Any:
    """A value in the words of JSON."""
    if isinstance(value, Diagnostic):
        return value.as_json()
    if isinstance(value, SourcedValue):
        return value._asdict()
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, tuple):
        return [_plain(inner) for inner in value]
    return _fields(value) if is_dataclass(value) else value
