"""Changes the code at random places and sees whether a test notices.

    make mutants                                        40 changes of every room
    python tests/mutants.py kinematics                  40 changes of one room
    python tests/mutants.py cycles 100 7                100 of them, drawn with the seed 7
    python tests/mutants.py diff --see 12               what the change number 12 of a draw is

Each mutant is one change: an operator, a comparison, a number, a ``not``, a loop without turns.  First a
place is drawn, then one of the changes that are possible there.  Left out is what no test can see
(annotations, which nothing evaluates) and what every test sees (``a | b`` for ``a + b`` of two floats).

Coverage says which tests come by the place; those run, quickest first, until one fails.  A mutant is killed
when one fails, when the tests take much longer than before, or when the code cannot even be imported.  One
that passes all of them, or ``PATIENCE_S`` of them, has survived.  All happens in a copy of the tree, as it
was when the tests were last measured (``--again``).
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

# Imported before a child is forked, so that no child waits for it; chipbreak is not among them.
import click  # noqa: F401
import coverage
import hypothesis.strategies  # noqa: F401
import lark  # noqa: F401
import numpy as np  # noqa: F401
import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "build" / "mutants"
TREE = KEPT / "tree"
SUBJECTS = {
    "kinematics": "kinematics/*.py",
    "trajectory": "trajectory/*.py",
    "editing": "editing/*.py",
    "cycles": "cycles/*.py",
    "checks": "checks/*.py",
    "syntax": "syntax/*.py",
    "diff": "editing/diff*.py",
}
# The tests of these rooms and of those that are made of them; LinuxCNC is not asked.
TESTS = (
    *("kinematics", "trajectory", "vibration", "editing", "cycles", "checks", "syntax", "model", "insertion"),
    *("passes", "operations", "dialects", "machine_test", "machine_files", "cycle_time"),
    *("restart", "second_reader", "tools", "test_cases.py", "test_right_values.py", "test_bad.py"),
    *(
        "test_advise.py",
        "test_api.py",
        "test_outcome.py",
        "test_long_files.py",
        "test_messages.py",
        "test_cli.py",
        "hooks/test_notes.py",
    ),
)
PATIENCE_S = 60.0
FEW_FILES = 3
HASTE_S = 5.0
WORKERS = 2
MOST_BYTES = 6 << 30
# No number takes these: an error wherever they are reached.
_SEEN_BY_ALL = ("_RShift", "_LShift", "_BitOr", "_BitAnd", "_BitXor", "_Is", "_IsNot", "_Invert")
_NEED_ARGUMENTS = ("core/VariableReplacer", "core/VariableInserter")
_COPIED = ("src", "tests", "grammar", "samples", "docs", "benchmarks", "pyproject.toml", "README.md")
Place = tuple[int, int]


class Mutant(NamedTuple):
    """One change: the operator of cosmic-ray, and which of its occurrences in the file."""

    file: str
    start: Place
    operator: str
    occurrence: int

    def code(self) -> str:
        """The file with the change in it."""
        text = (TREE / self.file).read_text("utf-8")
        return str(mutate_code(text, get_operator(self.operator)(), self.occurrence))

    def is_code(self) -> bool:
        """False where nobody could run it: the ``*`` of a signature is no product."""
        try:
            ast.parse(self.code())
        except SyntaxError:
            return False
        return True

    def shown(self) -> str:
        """The changed lines, for a reader."""
        was, now = ((TREE / self.file).read_text("utf-8").split("\n"), self.code().split("\n"))
        at = next((i for i, (one, other) in enumerate(zip(was, now, strict=False)) if one != other), 0)
        return f"{self.file}:{at + 1} {self.operator[5:]}\n    - {was[at].strip()}\n    + {now[at].strip()}"


# --- which changes there are ------------------------------------------------------------------------------


def _operators() -> dict[str, Operator]:
    names = [one for one in operator_names() if one not in _NEED_ARGUMENTS]
    return {one: get_operator(one)() for one in names if not one.endswith(_SEEN_BY_ALL)}


def _unseen(text: str) -> list[tuple[Place, Place]]:
    """Where nothing is ever evaluated: annotations, and what is for the type checker alone."""
    found: list[ast.AST | None] = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            found += [
                node.returns,
                *(one.annotation for one in [*every, node.args.vararg, node.args.kwarg] if one),
            ]
        elif isinstance(node, ast.AnnAssign):
            found.append(node.annotation)
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            found.append(node)
    return [
        ((one.lineno, one.col_offset), (one.end_lineno or 0, one.end_col_offset or 0))
        for one in found
        if isinstance(one, ast.expr | ast.stmt)
    ]


def mutants_of(file: Path) -> Iterator[Mutant]:
    """Every change of a file that somebody could see."""
    text = file.read_text("utf-8")
    unseen = _unseen(text)
    nodes = list(ast_nodes(get_ast(text)))
    for name, operator in _operators().items():
        places = [start for node in nodes for start, _ in operator.mutation_positions(node)]
        for occurrence, start in enumerate(places):
            if not any(begin <= start < end for begin, end in unseen):
                yield Mutant(str(file.relative_to(TREE)), start, name, occurrence)


def draw(subject: str, count: int, seed: int) -> list[Mutant]:
    """So many of them: a place each, and one of the changes there."""
    files = sorted((TREE / "src" / "chipbreak").glob(SUBJECTS[subject]))
    places: dict[tuple[str, Place], list[Mutant]] = {}
    for mutant in (one for file in files for one in mutants_of(file)):
        places.setdefault((mutant.file, mutant.start), []).append(mutant)
    choose = random.Random(seed)
    order = choose.sample(sorted(places), len(places))
    chosen = (choose.choice(places[place]) for place in order)
    return list(islice((mutant for mutant in chosen if mutant.is_code()), count))


# --- which tests come by ----------------------------------------------------------------------------------


def copy_of_tree(folder: Path) -> Path:
    """The tree in another folder, with what Python has compiled of it."""
    folder.mkdir(parents=True)
    for name in _COPIED:
        one = ROOT / name
        (shutil.copytree if one.is_dir() else shutil.copy2)(one, folder / name)
    return folder


@dataclass
class Times:
    """How long each test took, by its name."""

    seconds: dict[str, float] = field(default_factory=dict)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" and report.passed:
            self.seconds[report.nodeid] = report.duration


def measure_reach() -> None:
    """Run all the tests once, in a copy; which lines each one comes by, and how long it takes, is kept."""
    shutil.rmtree(KEPT, ignore_errors=True)
    copy_of_tree(TREE)
    times = Times()
    arguments = [
        "-n",
        str(WORKERS),
        "--dist",
        "worksteal",
        "--cov",
        "--cov-context=test",
        "--cov-report=",
        "--cov-fail-under=0",
    ]

    def work() -> int:
        pytest.main([*arguments, *_ARGUMENTS, *(f"tests/{one}" for one in TESTS)], plugins=[times])
        (KEPT / "times.json").write_text(json.dumps(times.seconds))
        return 0

    os.waitpid(_forked(work, TREE, KEPT / "reach.log"), 0)


# Hypothesis is imported already, so its asserts stay as they are.
_ARGUMENTS = (
    "-q",
    "-p",
    "no:cacheprovider",
    "-m",
    "not long",
    "-W",
    "ignore::pytest.PytestAssertRewriteWarning",
)


def _forked(work: Callable[[], int], folder: Path, log: Path) -> int:
    """A process that imports the code of a folder and writes all that it says into a file."""
    child = os.fork()
    if child:
        return child
    code = 99
    try:
        os.setsid()
        os.chdir(folder)
        sys.path[:0] = [str(folder / "src")]
        os.environ |= {"PYTHONPATH": str(folder / "src"), "OMP_NUM_THREADS": "1"}
        file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for stream in (1, 2):
            os.dup2(file, stream)
        code = work()
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


class Round(NamedTuple):
    """Tests that run together, and after how long they are given up."""

    tests: list[str]
    limit_s: float


class Reach:
    """Which tests come by a line, quickest first."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = json.loads((KEPT / "times.json").read_text())
        self.data = coverage.CoverageData(str(TREE / ".coverage"))
        self.data.read()

    @cache  # noqa: B019
    def _by_line(self, file: str) -> dict[int, list[str]]:
        return self.data.contexts_by_lineno(str(TREE / file))

    def tests(self, mutant: Mutant) -> list[str]:
        """Those that come by the statement; for one that runs on import, by the function or the file.

        Those of the room itself come first, each part quickest first.  By what is worked out once only the
        test came that was there first, so all of the room are among them.
        """
        by_line = self._by_line(mutant.file)
        room = _room_of(mutant)
        is_once = _is_once(TREE / mutant.file, mutant.start[0])
        every = {test for test in self.seconds if is_once and test.startswith(room)}
        for lines in _lines_around(TREE / mutant.file, mutant.start[0]):
            contexts = {context.split("|")[0] for line in lines for context in by_line.get(line, ())}
            if found := (contexts & self.seconds.keys()) | every:
                return sorted(found, key=lambda test: (not test.startswith(room), self.seconds[test], test))
        return []

    def rounds(self, mutant: Mutant) -> list[Round]:
        """First some tests of a few files, then all that there is time for."""
        every = self.tests(mutant)
        files = Counter(map(_file_of, every))
        room = _room_of(mutant)
        likely = sorted(files, key=lambda file: (not file.startswith(room), -files[file]))[:FEW_FILES]
        few = [test for test in every if _file_of(test) in likely]
        return [self._round(few, HASTE_S), self._round(every, PATIENCE_S)] if every else []

    def _round(self, tests: list[str], most_s: float) -> Round:
        tests = self._patient(tests, most_s)
        return Round(tests, 60.0 + 8.0 * sum(self.seconds[test] for test in tests))

    def _patient(self, tests: list[str], most_s: float) -> list[str]:
        """The first of them, as many as there is time for."""
        total_s = 0.0
        for at, test in enumerate(tests):
            total_s += self.seconds[test]
            if total_s > most_s and at:
                return tests[:at]
        return tests


def _room_of(mutant: Mutant) -> str:
    """Where the tests of its room lie."""
    return f"tests/{mutant.file.split('/')[2]}/"


def _file_of(test: str) -> str:
    return test.split("::", maxsplit=1)[0]


def _lines_around(file: Path, line: int) -> Iterator[range]:
    """The lines of the statement, of what it stands in, and so on to the whole file."""
    tree = ast.parse(file.read_text("utf-8"))
    found = [
        node for node in ast.walk(tree) if isinstance(node, ast.stmt) and _first(node) <= line <= _last(node)
    ]
    for node in sorted(found, key=lambda node: _last(node) - _first(node)):
        body = getattr(node, "body", None)
        if body and line < body[0].lineno and not isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield range(_first(node), body[0].lineno)
        yield range(_first(node), _last(node) + 1)
    yield range(1, 1_000_000)


def _is_once(file: Path, line: int) -> bool:
    """True for what runs on import, and in a function that keeps its results."""
    around = [
        node
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.FunctionDef) and _first(node) <= line <= _last(node)
    ]
    is_on_import = not any(node.body[0].lineno <= line for node in around)
    decorators = (ast.unparse(one) for node in around for one in node.decorator_list)
    return is_on_import or any("cache" in one for one in decorators)


def _first(node: ast.stmt) -> int:
    return min([node.lineno, *(one.lineno for one in getattr(node, "decorator_list", ()))])


def _last(node: ast.stmt) -> int:
    return node.end_lineno or node.lineno


# --- whether one of them notices --------------------------------------------------------------------------


@dataclass(frozen=True)
class Chosen:
    """Runs some tests only, in this order."""

    tests: Sequence[str]

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        wanted = {test: at for at, test in enumerate(self.tests)}
        items[:] = sorted(
            (item for item in items if item.nodeid in wanted), key=lambda item: wanted[item.nodeid]
        )


def run_tests(folder: Path, tests: Sequence[str], limit_s: float) -> tuple[str, str]:
    """Run tests on the code of a folder: what became of them, and the first one that failed."""

    def work() -> int:
        sys.dont_write_bytecode = True
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
        files = sorted({_file_of(test) for test in tests})
        return int(pytest.main(["-x", "--tb=no", *_ARGUMENTS, *files], plugins=[Chosen(tests)]))

    code = _wait(_forked(work, folder, folder / "tests.log"), limit_s)
    said = (folder / "tests.log").read_text("utf-8", "replace")
    failed = next((line for line in said.split("\n") if line.startswith(("FAILED", "ERROR"))), "")
    return {0: "survived", None: "too slow", 5: "no test"}.get(code, "killed"), failed


def _wait(child: int, limit_s: float) -> int | None:
    """The exit code of a child; None where it had to be ended."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        found, status = os.waitpid(child, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


_own: list[Path] = []


def try_mutant(mutant: Mutant, rounds: Sequence[Round], folder: Path) -> tuple[str, str]:
    """Try one in the copy that this process has to itself; the first round that notices ends it."""
    if not _own:
        _own.append(folder / str(os.getpid()))
        shutil.copytree(TREE, _own[0])
    file = _own[0] / mutant.file
    file.write_text(mutant.code(), "utf-8")
    os.utime(file, (0, 0))  # older than what was compiled of it, so that is compiled anew
    try:
        outcome = ("no test", "")
        for tests, limit_s in rounds:
            outcome = run_tests(_own[0], tests, limit_s)
            if outcome[0] != "survived":
                break
        return outcome
    finally:
        shutil.copy2(TREE / mutant.file, file)


def try_all(drawn: list[Mutant], reach: Reach) -> Counter[str]:
    """Try all; every one that is not killed is shown."""
    found: Counter[str] = Counter()
    with (
        tempfile.TemporaryDirectory() as folder,
        ProcessPoolExecutor(WORKERS, get_context("fork")) as workers,
    ):
        tries = [workers.submit(try_mutant, one, reach.rounds(one), Path(folder)) for one in drawn]
        for number, (mutant, one) in enumerate(zip(drawn, tries, strict=True)):
            outcome, failed = one.result()
            found[outcome] += 1
            if outcome in ("survived", "no test"):
                print(f"--- {number}: {outcome}, {mutant.shown()}", flush=True)
            else:
                print(f"{number}: {outcome}, {mutant.file}:{mutant.start[0]} {failed[:110]}", flush=True)
    return found


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("subject", choices=[*SUBJECTS, "all"])
    parser.add_argument("count", type=int, nargs="?", default=40)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("--see", type=int, help="show one change of the draw, and the tests that come by")
    parser.add_argument("--again", action="store_true", help="measure anew which test comes by which line")
    return parser.parse_args()


def main() -> int:
    given = _arguments()
    if given.again or not (KEPT / "times.json").exists():
        measure_reach()
    reach = Reach()
    for subject in SUBJECTS if given.subject == "all" else (given.subject,):
        drawn = draw(subject, given.count, given.seed)
        if given.see is not None:
            print(drawn[given.see].shown(), *reach.tests(drawn[given.see]), sep="\n")
            continue
        found = try_all(drawn, reach)
        killed = found["killed"] + found["too slow"]
        print(f"{subject}, seed {given.seed}: {killed} of {len(drawn)} killed; {dict(found)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
