"""Finds and loads ``grammar/``: the only module that imports lark.

lark is imported on first use, because most programs have only plain blocks and never need it.
"""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lark import Lark

_TERMINAL = re.compile(r"^([A-Z_]+)(?:\.\d+)?\s*:\s*/(.*)/(i?)\s*$", re.MULTILINE)


def grammar_dir() -> Path:
    """Where the grammar is: inside an installed package, or at the top of a checkout."""
    installed = Path(__file__).parents[1] / "grammar"
    return installed if installed.is_dir() else Path(__file__).parents[3] / "grammar"


@lru_cache(maxsize=1)
def block_parser() -> Lark:
    """The grammar of one block, as an LALR parser that keeps positions."""
    from lark import Lark  # noqa: PLC0415

    text = (grammar_dir() / "nc.lark").read_text("ascii")
    return Lark(
        text,
        start="block",
        parser="lalr",
        lexer="contextual",
        propagate_positions=True,
        import_paths=[str(grammar_dir())],
    )


@lru_cache(maxsize=1)
def terminals() -> dict[str, str]:
    """The terminals of ``nc.lark`` and ``expression.lark`` by name, as regular expressions."""
    found = {}
    for name in ("expression.lark", "nc.lark"):
        text = (grammar_dir() / name).read_text("ascii")
        found.update({m[1]: m[2].replace("\\/", "/") for m in _TERMINAL.finditer(text)})
    return found
