"""What a canned cycle or another code says of its operation."""

from __future__ import annotations

from chipbreak.model.block_effect import BlockEffect
from chipbreak.operations.kinds import Kind

_TAPPING = (74.0, 84.0, 84.2)
_FINE_BORING = 76.0


def kind_by_cycle(effect: BlockEffect) -> Kind | None:
    """The kind of operation that the codes of a block stand for, or None."""
    non_modal, motion = effect.non_modal, effect.after.modes.motion
    codes = {word.number for word in effect.block.words if word.address == "G"}
    if "finish-cycle" in non_modal or (motion == "cycle" and _FINE_BORING in codes):
        return Kind.FINISH
    if "rough-cycle" in non_modal:
        return Kind.ROUGH
    if "thread-cycle" in non_modal or (
        effect.move and motion in ("thread", "threading-cycle", "thread-cycle")
    ):
        return Kind.THREAD
    if "skip" in non_modal or (effect.move and motion == "probe"):
        return Kind.PROBE
    if motion == "cycle" and effect.before.modes.motion != "cycle":
        return Kind.THREAD if codes & set(_TAPPING) else Kind.DRILL
    return None
