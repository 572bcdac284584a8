"""The forms in which the blocks of a cut are written: all of them, or their steady parts as loops."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chipbreak.settings.sections import Settings
from chipbreak.vibration.loop import Loop, looped_points
from chipbreak.vibration.loop_names import LoopNames
from chipbreak.vibration.plan import CutPlan

Floats = NDArray[np.float64]


class OutputForm(ABC):
    """What is written of the blocks of a cut."""

    @abstractmethod
    def round_steps(
        self, cut: CutPlan, time_s: Floats, steps: Floats, axes: Sequence[int], settings: Settings
    ) -> Sequence[Loop]:
        """Round ``steps`` (n, 3) to whole ones in place, and say which blocks along ``axes`` are loops."""

    @abstractmethod
    def lines(self, loop: int, passes: int) -> tuple[list[str], list[str]]:
        """The lines before and behind the blocks of a loop, the ``loop``-th of a cut."""

    @abstractmethod
    def told(self, loops: Sequence[Loop]) -> Sequence[Loop] | None:
        """The loops to be told of; None where none were asked for."""


class WrittenOut(OutputForm):
    """Every block is written."""

    def round_steps(
        self, cut: CutPlan, time_s: Floats, steps: Floats, axes: Sequence[int], settings: Settings
    ) -> Sequence[Loop]:
        """See :meth:`OutputForm.round_steps`."""
        np.rint(steps, out=steps)
        return ()

    def lines(self, loop: int, passes: int) -> tuple[list[str], list[str]]:
        """None."""
        return [], []

    def told(self, loops: Sequence[Loop]) -> Sequence[Loop] | None:
        """None were asked for."""
        return None


class Looped(OutputForm):
    """Vibrations of full stroke on a straight line are passes of a loop, under free names."""

    def __init__(self, names: LoopNames) -> None:
        self.names = names

    def round_steps(
        self, cut: CutPlan, time_s: Floats, steps: Floats, axes: Sequence[int], settings: Settings
    ) -> Sequence[Loop]:
        """See :meth:`OutputForm.round_steps`.  Errors: VIB081."""
        steps[:, axes], loops = looped_points(cut, time_s, steps[:, axes], settings)
        np.rint(steps, out=steps)
        return loops

    def lines(self, loop: int, passes: int) -> tuple[list[str], list[str]]:
        """See :meth:`OutputForm.lines`."""
        return self.names.lines(loop, passes)

    def told(self, loops: Sequence[Loop]) -> Sequence[Loop] | None:
        """See :meth:`OutputForm.told`."""
        return loops


WRITTEN_OUT = WrittenOut()


def form_with(names: LoopNames | None) -> OutputForm:
    """Loops under these names; without names every block is written."""
    return WRITTEN_OUT if names is None else Looped(names)
