"""The import rule: a module imports only from modules above it in the list below.

A new module gets its line here, below everything it imports and above everything that imports it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "chipbreak"
# Package "x" is x/__init__.py; the whole package's own __init__.py is "chipbreak".
ORDER = """
span
units
nearest
diagnostics
source
bracket
restore

dialects.base
dialects.generic
dialects.fanuc
dialects.linuxcnc
dialects

syntax
syntax.numbers
syntax.nodes
syntax.variables
syntax.grammar
syntax.build
syntax.shapes
syntax.parse
syntax.columns

settings.axis_words
settings.sections
settings.checking
settings.ranges
settings.tool_rules
settings.load
settings.show
settings

model
model.evaluate
model.modal
model.words
model.peripheral
model.steps
model.motion
model.flow
model.requests
model.machine_functions
model.interpret
model.trace
model.lazy_pattern
model.kind_words
model.kinds
model.main_program
model.cycle_kinds
model.operations

edits

tools
tools.data
tools.values
tools.facts
tools.tips
tools.cells
tools.lists
tools.json_text
tools.fusion
tools.freecad
tools.linuxcnc
tools.files
tools.comments
tools.merge
tools.needs
tools.program
tools.edge_figure

lasersim
lasersim.tool
lasersim.barrier

macro_b.faults
macro_b.machine
macro_b.modes
macro_b.expressions
macro_b.variables
macro_b.programs
macro_b.blocks
macro_b.interpreter
macro_b

macros.calls
macros.parameters
macros.write
macros

vibration
vibration.given
vibration.solve
vibration.waveform
vibration.laws
vibration.path
vibration.control
vibration.planner
vibration.stretches
vibration.factors
vibration.bends
vibration.timing
vibration.piecewise
vibration.verdict
vibration.load
vibration.directive
vibration.request
vibration.chain
vibration.plan
vibration.loop_names
vibration.loop
vibration.stands
vibration.content
vibration.speeds
vibration.advice
vibration.blocks
vibration.readback

checks
checks.edges
checks.effects
checks.subprograms
checks.doubts
checks.ground
checks.reliance
checks.clearance
checks.tool_values
checks.call_sets
checks.calls
checks.known
checks.borders
checks.limits
checks.clashes
checks.plan

passes
passes.speeds
passes.vibrate
passes.check_tools

emit
unroll
measure
unbroken
verify
diff
pipeline
report
chipbreak
streams
options
tool_commands
cli
__main__
"""
LAYERS = ORDER.split()

# Libraries that only these modules may import.
ONLY_IN = {
    "lark": {"syntax.grammar", "syntax.parse"},
    "click": {"streams", "options", "cli", "tool_commands"},
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
    above = LAYERS[: LAYERS.index(name)]
    for line, imported in own_imports(tree, known):
        if imported not in LAYERS:
            found.append(f"line {line}: {imported} is not in the list of tests/test_layers.py")
        elif imported not in above:
            found.append(f"line {line}: {name} imports {imported}, which is not above it")
    for line, module, _ in imports(tree):
        library = module.split(".")[0]
        if library in ONLY_IN and name not in ONLY_IN[library]:
            found.append(f"line {line}: {library} is for {', '.join(sorted(ONLY_IN[library]))} only")
    return found


MODULES = modules()


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_only_from_above(name: str) -> None:
    file = MODULES[name]
    assert name in LAYERS, (
        f"{file.relative_to(PACKAGE.parents[1])} has no place in the order of modules: add a line {name!r} "
        "to ORDER in tests/test_layers.py, below all it imports and above all that import it"
    )
    found = complaints(name, ast.parse(file.read_bytes()), MODULES)
    assert not found, f"{file.relative_to(PACKAGE.parents[1])}: " + "; ".join(found)


def test_every_layer_is_named_once() -> None:
    assert len(set(LAYERS)) == len(LAYERS)


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("source", "from chipbreak.syntax.parse import parse", "imports syntax.parse"),
        ("source", "import chipbreak.syntax.parse", "imports syntax.parse"),
        ("source", "from chipbreak.syntax import parse", "imports syntax.parse"),
        ("source", "def f():\n    from chipbreak import cli", "imports cli"),
        ("source", "from chipbreak.source import read", "imports source"),
        ("source", "from chipbreak.nowhere import x", "nowhere is not in the list"),
        ("source", "import lark.exceptions", "lark is for"),
        ("pipeline", "if True:\n    import click", "click is for"),
        ("source", "from chipbreak.span import Place", ""),
        ("source", "if TYPE_CHECKING:\n    from chipbreak.syntax.parse import Program", ""),
        ("syntax.grammar", "def f():\n    from lark import Lark", ""),
    ],
)
def test_the_rule_finds_what_it_must(name: str, text: str, complaint: str) -> None:
    found = complaints(name, ast.parse(text), {**MODULES, "nowhere": Path()})
    assert bool(found) == bool(complaint)
    assert complaint in "; ".join(found)
