"""The tool-check macros of each control, and the settings they need."""

from chipbreak.macros.calls import ToolValues
from chipbreak.macros.parameters import MacroSettings, UnsetError
from chipbreak.macros.write import check_axes, foreign_files, macro_files, makers_numbers

__all__ = [
    "MacroSettings",
    "ToolValues",
    "UnsetError",
    "check_axes",
    "foreign_files",
    "macro_files",
    "makers_numbers",
]
