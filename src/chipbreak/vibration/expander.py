"""What an expander answers: how cuts of one wave are planned, written, read back and told."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.kinematics.waves import Wave
from chipbreak.trajectory.law import ControlLaw

Form = Literal["tick", "stroke"]


@dataclass(frozen=True)
class StrokeAsked:
    """What a stroke follows from: the words of the cut, N, the feed, the forward share, edges, the margin."""

    values: Mapping[str, SourcedValue]
    per_rev: float
    feed_mm_rev: float
    alpha_share: float
    edges: int
    margin: float
    ticks: int


class Expander(ABC):
    """How cuts with one wave are planned, written, read back and told; it keeps nothing."""

    keeps_feed: ClassVar[bool]
    """Every block has the program's own feed, in its own mode."""
    larger: ClassVar[str]
    """How a stroke is made larger, for messages."""

    def __init__(self, wave: Wave) -> None:
        self.wave = wave

    # The plan.

    def refuse_share(self, alpha: SourcedValue) -> None:
        """Errors: VIB055 for a forward share that the wave cannot have."""
        return

    def way_out_of_whole(self, edges: int, alpha: float) -> str:
        """What breaks chips where N is whole; empty where it is what the solver says."""
        return ""

    @abstractmethod
    def form(self, segments: str) -> Form:
        """One block per base period, or one per stroke, from ``output.segments``."""

    @abstractmethod
    def stroke_mm(self, asked: StrokeAsked) -> float:
        """The stroke, peak to peak.  Errors: VIB012 and VIB085."""

    @abstractmethod
    def ramp_s(self, ramp_s: float) -> float:
        """How long the stroke grows where ``ramp_s`` was asked for."""

    # The blocks.

    def feed_mode(self, programmed: str, output: str) -> str:
        """The feed mode of the blocks, from that of the program and ``output.feed_mode``."""
        return programmed if self.keeps_feed else output

    def ends_at_programmed_feed(self, wave: WaveformParameters) -> bool:
        """True when the last block runs at the program's own feed."""
        return self.keeps_feed or wave.end_revolutions > 0.0

    def knots(self, time_s: Floats, distance_mm: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """The knots that blocks lead to, and behind which of them the tool dwells; (n,) each.

        The time of a knot is then the end of the dwell.
        """
        return time_s, distance_mm, np.zeros(len(time_s), np.bool_)

    def dwell_s(self, wave: WaveformParameters, law: ControlLaw, edges: int, per_rev: float) -> float:
        """How long the tool dwells in each vibration on this control.

        Errors: VIB086 when that is less than a revolution (per edge).
        """
        return 0.0

    def in_whole_dwells(self, wave: WaveformParameters, law: ControlLaw, edges: int) -> WaveformParameters:
        """The wave with dwells that the control can make.  Errors: VIB086 where no time is left to feed."""
        return wave

    def way_out_of_too_many_blocks(self, form: Form) -> str:
        """What leaves fewer blocks per second than a cut of this form."""
        return 'take output.segments = "stroke"' if form == "tick" else "ask for a lower frequency"

    # What is told.

    @abstractmethod
    def title(self, wave: WaveformParameters) -> str:
        """The stroke in the title of an edit."""

    @abstractmethod
    def told(self, wave: WaveformParameters, dwell_s: float) -> tuple[str, str]:
        """What the report calls the motion, and how large it is."""

    @abstractmethod
    def told_need(self, acceleration_mm_s2: float) -> str:
        """What the motion asks of the machine."""

    @abstractmethod
    def told_without_count(self) -> str:
        """What the report says where no N was reached; empty where that is no news."""
