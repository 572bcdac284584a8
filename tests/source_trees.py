"""The syntax trees of our own modules: several tests of the house look through all of them."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path


@cache
def tree_of(file: Path) -> ast.Module:
    """What stands in a file, parsed once; nobody changes it."""
    return ast.parse(file.read_bytes())
