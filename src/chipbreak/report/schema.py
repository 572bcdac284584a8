"""The version of what is printed as JSON."""

from __future__ import annotations

from typing import Final

# Grows when a key goes away or changes its meaning; a new key leaves it as it is.
SCHEMA: Final = 1
