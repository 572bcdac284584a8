"""chipbreak: a G-code filter that breaks chips and watches tools.

>>> import chipbreak
>>> settings = chipbreak.load("generic-lathe")
>>> chipbreak.rewrite(b"G0 X20. Z2.\\nM30\\n", settings).changed
False

A program that is refused raises :class:`ProgramRejectedError`, whose ``diagnostics`` say why; a profile that
cannot be used :class:`SettingsError`, a file of tools :class:`ToolFileError`, and a fault of ours
:class:`SelfCheckError`.  All of them are a :class:`ChipbreakError`.

>>> chipbreak.rewrite(b"G97 S3000 M3\\nG0 X20. Z2.\\nG1 Z-30. F0.05 N2\\nM30\\n", settings)
Traceback (most recent call last):
chipbreak.ProgramRejectedError: N 2 (N word, line 3) is a whole number, ...

``docs/api.md`` shows each name at work.  Everything may be called from several threads at once; settings,
results and errors pickle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chipbreak.api import (
        check,
        diff,
        explain,
        macro_programs,
        motions,
        read_tools,
        restore,
        tool_table,
        verify,
    )
    from chipbreak.pipeline import Result, rewrite
    from chipbreak.report.model import Report
    from chipbreak.settings import Settings, SettingsError, load, profile_names
    from chipbreak.text.diagnostics import (
        ChipbreakError,
        Diagnostic,
        ProgramRejectedError,
        SelfCheckError,
        Severity,
    )
    from chipbreak.tools.data import ToolData, ToolFileError
    from chipbreak.tools.reader import ToolReader

    __version__: str

__all__ = [
    "ChipbreakError",
    "Diagnostic",
    "ProgramRejectedError",
    "Report",
    "Result",
    "SelfCheckError",
    "Settings",
    "SettingsError",
    "Severity",
    "ToolData",
    "ToolFileError",
    "ToolReader",
    "__version__",
    "check",
    "diff",
    "explain",
    "load",
    "macro_programs",
    "motions",
    "profile_names",
    "read_tools",
    "restore",
    "rewrite",
    "tool_table",
    "verify",
]
_HOMES = {
    "chipbreak.api": (
        "check",
        "diff",
        "explain",
        "macro_programs",
        "motions",
        "read_tools",
        "restore",
        "tool_table",
        "verify",
    ),
    "chipbreak.pipeline": ("Result", "rewrite"),
    "chipbreak.report.model": ("Report",),
    "chipbreak.settings": ("Settings", "SettingsError", "load", "profile_names"),
    "chipbreak.text.diagnostics": (
        "ChipbreakError",
        "Diagnostic",
        "ProgramRejectedError",
        "SelfCheckError",
        "Severity",
    ),
    "chipbreak.tools.data": ("ToolData", "ToolFileError"),
    "chipbreak.tools.reader": ("ToolReader",),
}


def __getattr__(name: str) -> Any:
    """Import on first use: the command line must not wait for numpy to print its help."""
    if name == "__version__":
        from importlib.metadata import version

        return version("chipbreak")
    from importlib import import_module

    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(home), name)
    raise AttributeError(f"module 'chipbreak' has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names, loaded or not."""
    return sorted({*globals(), *__all__})
