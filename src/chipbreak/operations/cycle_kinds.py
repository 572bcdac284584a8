"""What a canned cycle or another code says of its operation."""

from __future__ import annotations

from collections.abc import Callable

from chipbreak.model.block_effect import BlockEffect
from chipbreak.operations.kinds import Kind
from chipbreak.text.named_tuple import NamedTuple

_TAPPING = frozenset({74.0, 84.0, 84.2})
_FINE_BORING = 76.0
_THREADING = ("thread", "threading-cycle", "thread-cycle")


class _Codes(NamedTuple):
    """The codes of a block: its G numbers, its non-modal codes, and the motion they lead to."""

    numbers: frozenset[float | None]
    non_modal: frozenset[str]
    motion: str
    motion_before: str
    moves: bool

    @property
    def begins_cycle(self) -> bool:
        return self.motion == "cycle" and self.motion_before != "cycle"


def kind_by_cycle(effect: BlockEffect) -> Kind | None:
    """The kind of operation that the codes of a block mean, or None."""
    codes = _Codes(
        frozenset(effect.block.numbers("G")),
        effect.non_modal,
        effect.after.modes.motion,
        effect.before.modes.motion,
        effect.move is not None,
    )
    return next((kind for kind, means_it in _RULES if means_it(codes)), None)


def _finishes(codes: _Codes) -> bool:
    return "finish-cycle" in codes.non_modal or (codes.motion == "cycle" and _FINE_BORING in codes.numbers)


def _roughs(codes: _Codes) -> bool:
    return "rough-cycle" in codes.non_modal


def _threads(codes: _Codes) -> bool:
    return "thread-cycle" in codes.non_modal or (codes.moves and codes.motion in _THREADING)


def _probes(codes: _Codes) -> bool:
    return "skip" in codes.non_modal or (codes.moves and codes.motion == "probe")


def _taps(codes: _Codes) -> bool:
    return codes.begins_cycle and bool(codes.numbers & _TAPPING)


def _drills(codes: _Codes) -> bool:
    return codes.begins_cycle


# The first that fits.
_RULES: tuple[tuple[Kind, Callable[[_Codes], bool]], ...] = (
    (Kind.FINISH, _finishes),
    (Kind.ROUGH, _roughs),
    (Kind.THREAD, _threads),
    (Kind.PROBE, _probes),
    (Kind.THREAD, _taps),
    (Kind.DRILL, _drills),
)
