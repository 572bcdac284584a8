"""The import rule: a room imports only from rooms above it in the list of ``docs/architecture.md``.

Inside a room a module may import any other one, as long as no imports run in a circle.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from source_trees import tree_of

CHECKOUT = Path(__file__).parents[1]
PACKAGE = CHECKOUT / "src" / "chipbreak"
PAGE = CHECKOUT / "docs" / "architecture.md"


def rooms_of(page: str) -> list[str]:
    """The rooms in their order: the first column of the table on the page."""
    return re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)


ROOMS = rooms_of(PAGE.read_text("utf-8"))


def room(module: str) -> str:
    """The room of a module: its package, or the module itself at the top."""
    return module.split(".", maxsplit=1)[0]


# Libraries that only these modules may import.
ONLY_IN = {
    "lark": {"syntax.grammar", "syntax.parse"},
    "click": {
        "streams",
        "options",
        "cli",
        "tool_commands",
        "advise_command",
        "machine_test_command",
        "batch_command",
        "completion_command",
        "hook_commands",
        "language_server_command",
        "profile_commands",
        "program_files",
        "resume_command",
        "figure_commands",
        "git_commands",
        "program_commands",
    },
    "matplotlib": {"figures.style"},
    "pygls": {"editor.server"},
    "lsprotocol": {"editor.server"},
    "distributed": {"batch.dask_cluster"},
}


def modules() -> dict[str, Path]:
    """Every module of the package by its name without ``chipbreak.``."""
    found = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(PACKAGE).with_suffix("").parts
        parts = parts[:-1] if parts[-1] == "__init__" else parts
        found[".".join(parts) or "chipbreak"] = file
    return found


def imports(tree: ast.AST) -> Iterator[tuple[int, str, list[str]]]:
    """Line, module and names of every import but those for type checkers; relative ones are not used here."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.expr):
            continue  # nothing is imported in there
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            for other in node.orelse:
                yield from imports(ast.Module([other], []))
        elif isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, []) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.lineno, "." * node.level + (node.module or ""), [alias.name for alias in node.names]
        else:
            yield from imports(node)


def own_imports(tree: ast.AST, known: dict[str, Path]) -> Iterator[tuple[int, str]]:
    """Line and name of every module of the package that is imported."""
    for line, module, names in imports(tree):
        assert not module.startswith("."), f"line {line}: write the whole name instead of {module!r}"
        if module.split(".")[0] != "chipbreak":
            continue
        inside = module.removeprefix("chipbreak").removeprefix(".")
        for name in names or [""]:
            submodule = f"{inside}.{name}".strip(".")
            yield line, submodule if submodule in known else inside or "chipbreak"


def complaints(name: str, tree: ast.AST, known: dict[str, Path]) -> list[str]:
    """What is wrong with the imports of one module."""
    found = []
    own = room(name)
    above = ROOMS[: ROOMS.index(own)]
    for line, imported in own_imports(tree, known):
        if room(imported) not in ROOMS:
            found.append(f"line {line}: {imported} is in no room of docs/architecture.md")
        elif room(imported) not in above and (room(imported) != own or imported == name):
            found.append(f"line {line}: {name} imports {imported}, which is not above it")
    for line, module, _ in imports(tree):
        library = module.split(".")[0]
        if library in ONLY_IN and name not in ONLY_IN[library]:
            found.append(f"line {line}: {library} is for {', '.join(sorted(ONLY_IN[library]))} only")
    return found


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    """Modules that import each other in a circle, or nothing."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


MODULES = modules()


@cache
def trees() -> dict[str, ast.Module]:
    """Every module, read once."""
    return {name: tree_of(file) for name, file in MODULES.items()}


def test_a_module_imports_only_from_above() -> None:
    homeless = {name: room(name) for name in MODULES if room(name) not in ROOMS}
    assert not homeless, (
        "these modules are in no room: add a line for it to the table in docs/architecture.md, below all it "
        "imports and above all that import it"
    )
    found = {name: complaints(name, tree, MODULES) for name, tree in trees().items()}
    assert not {name: said for name, said in found.items() if said}


def test_no_imports_run_in_a_circle() -> None:
    graph = {name: {found for _, found in own_imports(tree, MODULES)} for name, tree in trees().items()}
    assert not circle(graph)


def test_a_circle_is_found() -> None:
    assert circle({"text.source": {"text.span"}, "text.span": {"text.source"}})


def test_every_room_is_named_once_and_there() -> None:
    assert len(set(ROOMS)) == len(ROOMS)
    assert set(ROOMS) == {room(name) for name in MODULES}


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("text.source", "from chipbreak.syntax.parse import parse", "imports syntax.parse"),
        ("text.source", "import chipbreak.syntax.parse", "imports syntax.parse"),
        ("text.source", "from chipbreak.syntax import parse", "imports syntax.parse"),
        ("text.source", "def f():\n    from chipbreak import cli", "imports cli"),
        ("text.source", "from chipbreak.text.source import read", "imports text.source"),
        ("text.source", "from chipbreak.nowhere import x", "nowhere is in no room"),
        ("text.source", "import lark.exceptions", "lark is for"),
        ("pipeline", "if True:\n    import click", "click is for"),
        ("text.source", "from chipbreak.text.span import Place", ""),
        ("text.source", "if TYPE_CHECKING:\n    from chipbreak.syntax.parse import Program", ""),
        ("syntax.grammar", "def f():\n    from lark import Lark", ""),
    ],
)
def test_the_rule_finds_what_it_must(name: str, text: str, complaint: str) -> None:
    found = complaints(name, ast.parse(text), {**MODULES, "nowhere": Path()})
    assert bool(found) == bool(complaint)
    assert complaint in "; ".join(found)
