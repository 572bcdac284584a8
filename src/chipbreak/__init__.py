"""chipbreak: a G-code filter that breaks chips and watches tools.

>>> import chipbreak
>>> settings = chipbreak.load("generic-lathe")
>>> chipbreak.rewrite(b"G0 X20. Z2.\\nM30\\n", settings).changed
False
"""

from __future__ import annotations

from typing import Any

__all__ = ["ProgramRejectedError", "Result", "Settings", "load", "rewrite"]
_HOMES = {
    "ProgramRejectedError": "chipbreak.diagnostics",
    "Result": "chipbreak.pipeline",
    "Settings": "chipbreak.settings",
    "load": "chipbreak.settings",
    "rewrite": "chipbreak.pipeline",
}


def __getattr__(name: str) -> Any:
    """Import on first use: the command line must not wait for numpy to print its help."""
    if name not in _HOMES:
        raise AttributeError(f"module 'chipbreak' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
