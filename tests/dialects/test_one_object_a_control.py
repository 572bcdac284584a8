"""A control is one object: no module but the dialects decides by its name or keeps a table of names."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from chipbreak.dialects import DIALECTS, FANUC_MILL, LINUXCNC_MILL
from chipbreak.dialects.base import MCode
from source_trees import tree_of

PACKAGE = Path(__file__).parents[2] / "src" / "chipbreak"
NAMES = {dialect.name for dialect in DIALECTS}
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent.name != "dialects")


def _texts(node: ast.AST | None) -> set[str]:
    """The strings that stand in an expression."""
    return (
        {n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)}
        if node
        else set()
    )


def _asks_for_a_name(node: ast.AST) -> bool:
    """True for ``....dialect.name`` and ``dialect.name``."""
    of = node.value if isinstance(node, ast.Attribute) and node.attr in ("name", "title") else None
    return (isinstance(of, ast.Name) and of.id == "dialect") or (
        isinstance(of, ast.Attribute) and of.attr == "dialect"
    )


# Where neither stands, nothing decides by a name, and the tree need not be looked through.
_MAY_DECIDE = re.compile("|".join([r"dialect\s*\.\s*(?:name|title)\b", *map(re.escape, sorted(NAMES))]))
LOOKING_UP = ("get", "startswith", "endswith", "partition")


def decided_by(node: ast.AST) -> Sequence[ast.AST | None]:
    """What a statement compares, keeps as a key, or looks something up by."""
    match node:
        case ast.Compare():
            return [node.left, *node.comparators]
        case ast.Dict():
            return node.keys
        case ast.Subscript():
            return [node.slice]
        case ast.MatchValue():
            return [node]
        case ast.Call(func=ast.Attribute() as method) if method.attr in LOOKING_UP:
            return [*node.args, method.value]
    return []


def decisions(tree: ast.AST) -> Iterator[int]:
    """The lines that compare with a control's name, keep one as a key, or look something up by it."""
    for node in ast.walk(tree):
        if any(_texts(part) & NAMES or _asks_for_a_name(part) for part in decided_by(node)):
            yield node.lineno


def test_no_module_decides_by_the_name_of_a_control() -> None:
    """What differs between controls is a field of the dialect."""
    asking = [path for path in MODULES if _MAY_DECIDE.search(path.read_text("utf-8"))]
    lines = {path.relative_to(PACKAGE): list(decisions(tree_of(path))) for path in asking}
    assert {path: found for path, found in lines.items() if found} == {}


@pytest.mark.parametrize(
    "text",
    [
        'if name == "fanuc-mill": pass',
        'if "linuxcnc-lathe" != settings.dialect.name: pass',
        'is_mill = name in ("fanuc-mill", "linuxcnc-mill")',
        'TABLE = {"generic-lathe": 1}',
        "value = TABLE[settings.dialect.name]",
        "value = TABLE.get(dialect.name)",
        'if dialect.name.startswith("fanuc"): pass',
        'match name:\n    case "fanuc-mill": pass',
    ],
)
def test_such_a_decision_is_found(text: str) -> None:
    assert _MAY_DECIDE.search(text)
    assert list(decisions(ast.parse(text)))


@pytest.mark.parametrize(
    "text", ['message = f"not for {dialect.name}"', 'if tool.name == "drill": pass', 'load("generic-lathe")']
)
def test_a_name_in_a_message_is_no_decision(text: str) -> None:
    assert not list(decisions(ast.parse(text)))


def test_m_codes_are_vocabulary() -> None:
    assert FANUC_MILL.m_codes[3] == MCode("spindle", "cw", before_move=True)
    assert FANUC_MILL.m_code("spindle", "stop") == "M5"
    assert [dialect.name for dialect in DIALECTS if dialect.keeps_modes] == [
        "linuxcnc-lathe",
        "linuxcnc-mill",
    ]
    assert all((6 in dialect.m_codes) != dialect.tool_by_word for dialect in DIALECTS)
    with pytest.raises(KeyError, match="tool change"):
        DIALECTS[0].m_code("tool", "change")


def test_a_turret_names_tool_and_offset_in_one_word() -> None:
    lathe = next(dialect for dialect in DIALECTS if dialect.tool_by_word)
    assert [lathe.tool_of(number) for number in (2, 99, 212, 1201)] == [2, 99, 2, 12]
    assert lathe._replace(offset_digits=3).tool_of(12003) == 12
    assert LINUXCNC_MILL.tool_of(1201) == 1201
