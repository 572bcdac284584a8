"""The package holds what the product uses: every module is imported, every function is called by the product.

What only tests call belongs to the tests, and a wheel does not carry it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import chipbreak
from chipbreak import cli
from test_layers import MODULES, own_imports, trees

# Where a run of the product begins: the command line with its commands, which it imports by name when one is
# called, ``python -m chipbreak``, and the public functions.
_COMMANDS = {home.partition(".")[0] for home, _ in cli._HOMES.values()}
_FUNCTIONS = {home.removeprefix("chipbreak.") for home in chipbreak._HOMES}
DOORS = {"chipbreak", "cli", "__main__"} | _COMMANDS | _FUNCTIONS
# Called by others than our own modules: the entry point of the script, a hook of Python's.
CALLED_FROM_OUTSIDE = {"main", "__getattr__", "__dir__"}
# The law that what is read is printed byte for byte is said where programs are read.
SAID_FOR_THE_READER = {"emit"}


def reached(graph: Mapping[str, set[str]], doors: set[str]) -> set[str]:
    """Every module that an import leads to, with the packages that it lies in."""
    found: set[str] = set()
    waiting = set(doors)
    while waiting:
        name = waiting.pop()
        found.add(name)
        parents = {name[: at.start()] for at in re.finditer(r"\.", name)}
        waiting |= (graph.get(name, set()) | (parents & graph.keys())) - found
    return found


def defined(tree: ast.Module) -> Iterator[str]:
    """The functions and classes of a module, without methods."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.name


def used(tree: ast.Module) -> Iterator[str]:
    """Every name that a module says, but for the place of its definition and imports of it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            yield node.id
        elif isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
            yield node.value  # the table of public functions, and annotations in quotes


@cache
def said() -> set[str]:
    """Every name that some module says."""
    return {word for tree in trees().values() for word in used(tree)}


def is_command(node: ast.stmt) -> bool:
    """A function that a decorator hands to somebody else, as click's commands."""
    return bool(getattr(node, "decorator_list", ()))


def test_every_module_is_reached() -> None:
    graph = {name: {found for _, found in own_imports(tree, MODULES)} for name, tree in trees().items()}
    left = set(MODULES) - reached(graph, DOORS)
    assert not left, f"no import leads to {sorted(left)}: what only tests use belongs into tests/"


def test_every_function_is_used() -> None:
    left = {}
    for name, tree in trees().items():
        handed_over = {node.name for node in tree.body if is_command(node)}
        left[name] = set(defined(tree)) - said() - CALLED_FROM_OUTSIDE - SAID_FOR_THE_READER - handed_over
    unused = {name: names for name, names in left.items() if names}
    assert not unused, "modules that define what nothing in the package uses"


def test_what_is_not_reached_is_found() -> None:
    graph = {"cli": {"a.b"}, "a": set(), "a.b": {"c"}, "c": set(), "d": {"c"}}
    assert set(graph) - reached(graph, {"cli"}) == {"d"}
    tree = ast.parse("def one(): ...\ndef two(): one()\n@command\ndef three(): ...")
    assert set(defined(tree)) - set(used(tree)) == {"two", "three"}
    assert [is_command(node) for node in tree.body] == [False, False, True]


def test_a_wheel_holds_the_package_only() -> None:
    """What hatch puts into it is said in pyproject.toml: the package, and the grammar inside it."""
    text = (Path(__file__).parents[1] / "pyproject.toml").read_text("utf-8")
    wheel = text.partition("[tool.hatch.build.targets.wheel]")[2].partition("\n[")[0]
    assert re.search(r'^packages = \["src/chipbreak"\]$', wheel, re.MULTILINE)
