"""A control of which nothing is known: it follows the blocks exactly, time = length / feed."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junctions import Blocks, exact_blocks
from chipbreak.trajectory.law import ControlLaw
from chipbreak.trajectory.motion import Motion


class Ideal(ControlLaw):
    """No acceleration, no rests: only speed and the reading of blocks limit it."""

    name: ClassVar[str] = "ideal"
    is_assumed: ClassVar[bool] = True
    needs_acceleration: ClassVar[bool] = False
    keeps_time: ClassVar[bool] = True

    def blocks(self, moved_mm: Floats, ahead_mm: Floats) -> Blocks:
        """See :meth:`ControlLaw.blocks`; nothing is worked out that would not be asked for."""
        return exact_blocks(moved_mm, ahead_mm)

    def block_times(
        self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, *, before_mm_s: float = 0.0
    ) -> Floats:
        """See :meth:`ControlLaw.block_times`."""
        lengths, feeds = self.checked(lengths_mm, feeds_mm_s)
        return self._times_s(lengths, feeds)

    def shortest_time(self, length_mm: float) -> float:
        """See :meth:`ControlLaw.shortest_time`."""
        return max(abs(length_mm) / self.velocity_mm_s, self.read_s)

    def feeds_for_spans(self, blocks: Blocks, spans_s: Floats, plain_from: int) -> Floats:
        """See :meth:`ControlLaw.feeds_for_spans`."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        feeds_mm_s: Floats = np.abs(blocks.lengths_mm) / spans_s
        self.refuse_overload(feeds_mm_s, spans_s)
        return feeds_mm_s

    def motion_between_dwells(self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats) -> Motion:
        """See :meth:`ControlLaw.commanded_motion`; the knots are the ends of the blocks."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        spans_s = self._times_s(blocks.lengths_mm, feeds_mm_s)
        return Motion(spans_s, np.append(0.0, np.cumsum(spans_s)), distance_mm)

    def _times_s(self, lengths_mm: Floats, feeds_mm_s: Floats) -> Floats:
        times_s: Floats = np.abs(lengths_mm) / np.minimum(feeds_mm_s, self.velocity_mm_s)
        return np.maximum(times_s, self.read_s)

    def _feed_for(self, length_mm: float, time_s: float) -> float:
        return length_mm / time_s

    def _acceleration_for(self, length_mm: float, time_s: float) -> float:
        return 0.0
