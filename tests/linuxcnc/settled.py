"""Stalled runs of the simulated machine told from wrong programs.

The machine goes before all else on this computer (machine.py), but not where that is not allowed.  There a
computer that is busy holds up the part of LinuxCNC that reads the program.  Where the next block comes late
the machine slows down before it, without standing still and without a word.  So a run that missed something
counts only when another one was the same: a wrong program is wrong in the same way each time, a stalled one
is not, and runs again, slower.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Protocol, TypeVar

SPEEDS = (1.0, 0.5, 0.25, 0.25, 0.1)
UNSETTLED = "no two runs were alike: the computer was too busy"


class Seen(Protocol):
    """What a run came to."""

    @property
    def misses(self) -> Sequence[str]:
        """What it did not keep."""
        ...

    def is_like(self, other: Seen) -> bool:
        """Both were the same motion, as far as it was judged."""
        ...


Key = TypeVar("Key", bound=Hashable)
One = TypeVar("One", bound=Seen)


def is_settled(tries: Sequence[Seen]) -> bool:
    """The last run kept everything, or an earlier one missed the same."""
    return bool(tries) and (not tries[-1].misses or any(tries[-1].is_like(one) for one in tries[:-1]))


def tries_of(
    keys: Sequence[Key], run: Callable[[Sequence[Key], float], Mapping[Key, One]], speeds: Sequence[float]
) -> dict[Key, list[One]]:
    """Run all, and again those that are not settled, at one speed of the clock after the other.

    ``run`` may leave some out, where the machine did not start.
    """
    tries: dict[Key, list[One]] = {key: [] for key in keys}
    waiting = list(keys)
    for speed in speeds:
        for key, one in run(waiting, speed).items() if waiting else ():
            tries[key].append(one)
        waiting = [key for key in waiting if not is_settled(tries[key])]
    return tries
