"""Rules of the house that no linter knows."""

from __future__ import annotations

import ast
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from source_trees import tree_of

CHECKOUT = Path(__file__).parents[1]
PYTHON_FILES = sorted(
    path
    for folder in ("src", "tests", "benchmarks")
    for path in (CHECKOUT / folder).rglob("*.py")
    if path != Path(__file__)
)
EXEMPT = re.compile(
    r"noqa[^\n]*C901|complexipy\s*:\s*ignore|ruff\s*:\s*noqa\s*(?:$|:[^\n]*C901)", re.MULTILINE
)
# Assignments of several values side by side (a, b = x, y) are read one by one anyway: at most so many of all.
MOST_PARALLEL = 0.02
SOURCES = sorted((CHECKOUT / "src").rglob("*.py"))

# A path that is somebody's own works on no other computer.
HOME_PATH = re.compile(r"/home/\w|/Users/\w|/root/\w|[A-Z]:\\+Users\b", re.IGNORECASE)
TEXT_FILES = {
    ".py",
    ".md",
    ".toml",
    ".lark",
    ".c",
    ".h",
    ".sh",
    ".cfg",
    ".ini",
    ".yml",
    ".yaml",
    ".html",
    ".tsv",
    "",
}
NOT_OURS = {"LICENSE"}

CODE = re.compile(r"[\"']([A-Z]{3}[0-9]{3})[\"']")
# The same, and within a message that is put together by hand.
SAID = re.compile(r"""["']([A-Z]{3}[0-9]{3})["']|\b(?:error|warning|note) ([A-Z]{3}[0-9]{3}):""")
# A code belongs to one module.  Those that two of them share, and the one thing each code says:
SHARED_CODES = {
    "VIB023": "the cut has no length, as it is written or as it is printed",
    "VIB030": "a stroke needs more acceleration than the axis has, of one block or of several",
    "VIB031": "the strokes need more speed than the axis has, one by one or all at once",
    "VIB032": "the strokes need more blocks per second than the control reads, likewise",
}


def _name(path: Path) -> str:
    return str(path.relative_to(CHECKOUT))


def our_text_files() -> list[Path]:
    """Everything people read, without hidden folders, environments and build products."""
    found = []
    for top in CHECKOUT.iterdir():
        if top.name in {"build", "dist"} or (top.name.startswith(".") and top.name != ".ci"):
            continue
        found += [top] if top.is_file() else top.rglob("*")
    return sorted(
        path
        for path in found
        if path.is_file()
        and path.suffix in TEXT_FILES
        and path.name not in NOT_OURS
        and path != Path(__file__)
        if "__pycache__" not in path.parts
    )


def test_there_is_something_to_look_at() -> None:
    assert len(SOURCES) > 10
    assert CHECKOUT / "pyproject.toml" in our_text_files()
    assert CHECKOUT / "grammar" / "iso.lark" in our_text_files()


def is_parallel(node: ast.Assign) -> bool:
    """True for ``a, b = x, y``, and not for the swap ``a, b = b, a`` or an unpacked call."""
    if not isinstance(node.value, ast.Tuple):
        return False
    values = {ast.unparse(value) for value in node.value.elts}
    tuples = [target.elts for target in node.targets if isinstance(target, ast.Tuple)]
    return any({ast.unparse(name) for name in names} != values for names in tuples)


@pytest.mark.parametrize(
    ("text", "parallel"),
    [
        ("a, b = x, y", True),
        ("a.c, b[0] = b, y", True),
        ("a, b = b, a", False),
        ("a, b = f(x, y)", False),
        ("a = x, y", False),
        ("a = b = x", False),
    ],
)
def test_a_parallel_assignment_is_found(text: str, parallel: bool) -> None:
    (node,) = ast.parse(text).body
    assert isinstance(node, ast.Assign)
    assert is_parallel(node) == parallel


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Every statement; expressions have none inside."""
    for node in ast.iter_child_nodes(tree):
        if not isinstance(node, ast.expr):
            yield node
            yield from statements(node)


def test_an_assignment_says_one_thing() -> None:
    nodes = [node for path in SOURCES for node in statements(tree_of(path))]
    assignments = [node for node in nodes if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign)]
    parallel = [node for node in assignments if isinstance(node, ast.Assign) and is_parallel(node)]
    assert len(parallel) < MOST_PARALLEL * len(assignments)


def test_nothing_is_exempt_from_being_easy_to_follow() -> None:
    assert [_name(path) for path in PYTHON_FILES if EXEMPT.search(path.read_text("utf-8"))] == []


def homes_in(path: Path) -> list[str]:
    """Where a file names somebody's home, with its words."""
    text = path.read_text("latin-1")
    places = HOME_PATH.finditer(text)
    return [f"{_name(path)}:{text.count(chr(10), 0, one.start()) + 1} {one[0]}" for one in places]


def test_no_file_names_somebodys_home() -> None:
    assert [found for path in our_text_files() for found in homes_in(path)] == []


def modules_of_codes() -> dict[str, set[str]]:
    """Every diagnostic code, with the modules that use it as a string."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in SOURCES:
        for code in CODE.findall(path.read_text("utf-8")):
            found[code].add(_name(path))
    return found


def test_a_diagnostic_code_belongs_to_one_module() -> None:
    codes = modules_of_codes()
    assert "SYN001" in codes
    several = {code: sorted(names) for code, names in codes.items() if len(names) > 1}
    assert set(several) <= set(SHARED_CODES), (
        f"one code, one meaning: {several}; take a free number, or import a constant from one module"
    )


def test_every_code_is_in_the_list_of_diagnostics_and_no_other() -> None:
    sections = tomllib.loads((CHECKOUT / "docs" / "diagnostics.toml").read_text("utf-8"))["section"]
    listed = {code for section in sections for code in section["codes"]}
    said = {a or b for path in SOURCES for a, b in SAID.findall(path.read_text("utf-8"))}
    assert len(said) > 150
    assert listed == said, "docs/diagnostics.toml, then make diagnostics"
