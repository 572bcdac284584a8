"""What the user can do with a file of tools that cannot be used: texts that several readers say."""

from __future__ import annotations

from typing import Final

EXPORT_AGAIN: Final = "export the library again"
IS_IT_THE_RIGHT_FILE: Final = "is it the right file?"
SHAPE_OF_A_TOML_TOOL: Final = "a tool is [[tool]] and key = value lines"
SHAPE_OF_A_FREECAD_ENTRY: Final = "an entry has nr and path"
