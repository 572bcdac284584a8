"""A short number that tells machine profiles apart by what they say, whatever they are called."""

from __future__ import annotations

import zlib
from typing import Any

from chipbreak.settings.sections import OPEN_SECTIONS, Settings

_HOMES = {"calls": "call_sets"}


def fingerprint(settings: Settings) -> str:
    """CRC-32 of all that a profile, its bases and ``--set`` say, in hexadecimal: ``1F0A33C2``.

    What nobody said does not count, so that it stays when keys are added.
    """
    said = [f"{key}={_value(settings, key)!r}" for key in sorted(settings.origins)]
    return f"{zlib.crc32(chr(10).join(said).encode()):08X}"


def _value(settings: Settings, full: str) -> Any:
    section, _, key = full.rpartition(".")
    if section in OPEN_SECTIONS:
        return getattr(settings, _HOMES.get(section, section))[key]
    home = settings.axes[section.removeprefix("axes.")] if section.startswith("axes.") else None
    return getattr(home or getattr(settings, section), key)
