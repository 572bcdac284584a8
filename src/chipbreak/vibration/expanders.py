"""The expanders, one a wave; ``WAVE`` of a directive and ``vibration.waveform`` of a profile name a wave."""

from __future__ import annotations

from chipbreak.kinematics.waves import WAVES, Wave
from chipbreak.vibration.dwell import DwellExpander
from chipbreak.vibration.expander import Expander
from chipbreak.vibration.swing import EvenSwing, Swing


def _expander(wave: Wave) -> Expander:
    if not wave.turns_back:
        return DwellExpander(wave)
    return EvenSwing(wave) if wave.is_even else Swing(wave)


EXPANDERS: tuple[Expander, ...] = tuple(_expander(wave) for wave in WAVES)


def expander_named(waveform: str) -> Expander:
    """The expander of the wave of this name.  Errors: KeyError."""
    return _BY_NAME[waveform]


_BY_NAME = {expander.wave.name: expander for expander in EXPANDERS}
