"""chipbreak: a G-code filter that breaks chips and watches tools.

>>> import chipbreak
>>> settings = chipbreak.load("generic-lathe")
>>> chipbreak.rewrite(b"G0 X20. Z2.\\nM30\\n", settings).changed
False

A program that is refused raises :class:`ProgramRejectedError`, whose ``diagnostics`` say why; a profile that
cannot be used :class:`SettingsError`, a file of tools :class:`ToolFileError`, and a fault of ours
:class:`SelfCheckError`.

>>> chipbreak.rewrite(b"G97 S3000 M3\\nG0 X20. Z2.\\nG1 Z-30. F0.05 N2\\nM30\\n", settings)
Traceback (most recent call last):
chipbreak.ProgramRejectedError: N 2 (N word, line 3) is a whole number, ...
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chipbreak.pipeline import Result, rewrite
    from chipbreak.settings import Settings, SettingsError, load
    from chipbreak.text.diagnostics import ChipbreakError, ProgramRejectedError, SelfCheckError
    from chipbreak.tools.data import ToolFileError

__all__ = [
    "ChipbreakError",
    "ProgramRejectedError",
    "Result",
    "SelfCheckError",
    "Settings",
    "SettingsError",
    "ToolFileError",
    "load",
    "rewrite",
]
_HOMES = {
    "ChipbreakError": "chipbreak.text.diagnostics",
    "ProgramRejectedError": "chipbreak.text.diagnostics",
    "Result": "chipbreak.pipeline",
    "SelfCheckError": "chipbreak.text.diagnostics",
    "Settings": "chipbreak.settings",
    "SettingsError": "chipbreak.settings",
    "ToolFileError": "chipbreak.tools.data",
    "load": "chipbreak.settings",
    "rewrite": "chipbreak.pipeline",
}


def __getattr__(name: str) -> Any:
    """Import on first use: the command line must not wait for numpy to print its help."""
    if name not in _HOMES:
        raise AttributeError(f"module 'chipbreak' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
