"""The names of the waves, for profiles and directives, which are read without the waves themselves."""

from __future__ import annotations

from typing import Final

# In the order of ``waves.WAVES``; the first is what a profile has that says nothing.
WAVE_NAMES: Final = ("triangle", "sine", "dwell")
