"""What a canned cycle or another code says of its operation."""

from __future__ import annotations

from chipbreak.model.kinds import Kind
from chipbreak.model.steps import Step

_TAPPING = (74.0, 84.0, 84.2)
_FINE_BORING = 76.0


def kind_by_cycle(step: Step) -> Kind | None:
    """The kind of operation that the codes of a block stand for, or None."""
    once, motion = step.once, step.after.modes["motion"]
    codes = {word.number for word in step.block.words if word.address == "G"}
    if "finish-cycle" in once or (motion == "cycle" and _FINE_BORING in codes):
        return Kind.FINISH
    if "rough-cycle" in once:
        return Kind.ROUGH
    if "thread-cycle" in once or (step.move and motion in ("thread", "threading-cycle", "thread-cycle")):
        return Kind.THREAD
    if "skip" in once or (step.move and motion == "probe"):
        return Kind.PROBE
    if motion == "cycle" and step.before.modes["motion"] != "cycle":
        return Kind.THREAD if codes & set(_TAPPING) else Kind.DRILL
    return None
