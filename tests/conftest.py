"""What all tests share: the corpus of real programs, hypothesis profiles and loud reports of skips."""

from __future__ import annotations

import gc
import importlib
import os
import re
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from chipbreak.kinematics.remembered import forget
from longer import short_where

# What is collected stays to the end: to look through it for garbage takes a third of the collection, and time
# of each test.
gc.disable()

NO_CORPUS = "the corpus of real programs is not here"
HOW = "Set CHIPBREAK_CORPUS to a folder of NC programs."
_LARGE_BYTES = 1_000_000
_EXAMPLES = "examples_of_a_search"
_asked: dict[object, settings] = {}
_NO_PROGRAMS = {".md", ".tsv", ".csv", ".json", ".toml", ".tbl", ".fctb", ".fctl"}

# The tests draw the same examples every time; new ones are searched for with ``make fuzz`` (tests/fuzz.py).
settings.register_profile("same", deadline=None, max_examples=60, derandomize=True, print_blob=True)
# The same ones and more, for ``make test-long``.
settings.register_profile("many", deadline=None, max_examples=600, derandomize=True, print_blob=True)
# Tests that say how many examples they want keep their number: the search repeats them with other seeds.
settings.register_profile("fuzz", deadline=None, max_examples=150, derandomize=False, print_blob=True)
settings.load_profile("same")  # another one is chosen with ``--hypothesis-profile``


def folder_of(variable: str) -> Path | None:
    """The folder that an environment variable names, or None; a folder that was asked for must exist."""
    asked = os.environ.get(variable)
    if asked and not Path(asked).is_dir():
        raise pytest.UsageError(f"{variable} is {asked}, which is not a folder")
    return Path(asked) if asked else None


def programs_of(variable: str) -> list[Path]:
    """Every NC program in the folder that an environment variable names, in a fixed order."""
    folder = folder_of(variable)
    found = folder.rglob("*") if folder else ()
    return sorted(p for p in found if p.is_file() and p.suffix.lower() not in _NO_PROGRAMS)


def corpus_programs() -> list[Path]:
    """Every program of the corpus, in a fixed order."""
    return programs_of("CHIPBREAK_CORPUS")


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Forget what another test has worked out; say to a drawn search how many examples it tries.

    Its place in hypothesis must say it, too.
    """
    forget()
    parameters = getattr(getattr(item, "callspec", None), "params", {})
    if _EXAMPLES in parameters:
        asked = _asked.setdefault(item.obj, item.obj._hypothesis_internal_use_settings)
        number = parameters[_EXAMPLES] or asked.max_examples
        item.obj._hypothesis_internal_use_settings = settings(asked, max_examples=number)


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(importlib.import_module("linuxcnc.plugin"))


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.enable()
    if settings.get_current_profile_name() != "fuzz":
        _draw_the_same()


def _draw_the_same() -> None:
    """No number of our own source is drawn more often than others.

    Hypothesis takes them from the modules that are loaded: which these are depends on what other tests have
    run in this process, and so would the examples.
    """
    none = providers.Constants()
    providers._get_local_constants = lambda: none


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """``corpus_file``: once for each program of the corpus; ``own_case``: for each in CHIPBREAK_CASES.

    A program of more than a megabyte is long where a test is marked ``large_is_long``.

    A drawn search that is marked ``few(N)`` is there twice: with N examples, and ``long`` with all of them.
    """
    few = metafunc.definition.get_closest_marker("few")
    if few is not None and settings.get_current_profile_name() != "fuzz":
        metafunc.fixturenames.append(_EXAMPLES)
        short = pytest.param(few.args[0], id=pytest.HIDDEN_PARAM)
        metafunc.parametrize(_EXAMPLES, [short, pytest.param(None, id="all", marks=pytest.mark.long)])
    if "corpus_file" in metafunc.fixturenames:
        files = corpus_programs()
        missing = pytest.param(None, marks=pytest.mark.skip(reason=NO_CORPUS), id="no corpus")
        whole = metafunc.definition.get_closest_marker("large_is_long") is None
        cases = short_where(files, lambda p: whole or p.stat().st_size < _LARGE_BYTES)
        metafunc.parametrize("corpus_file", cases or [missing], ids=lambda p: p.name if p else None)
    if "own_case" in metafunc.fixturenames:
        files = programs_of("CHIPBREAK_CASES")
        missing = pytest.param(None, marks=pytest.mark.skip(reason="CHIPBREAK_CASES names no folder"), id="-")
        metafunc.parametrize("own_case", files or [missing], ids=lambda p: p.name if p else None)


@pytest.fixture(scope="session")
def corpus() -> list[Path]:
    """All programs of the corpus at once."""
    files = corpus_programs()
    if not files:
        pytest.skip(NO_CORPUS)
    return files


@pytest.fixture(scope="session")
def corpus_lines(corpus: list[Path]) -> list[str]:
    """Lines of the corpus, one of those that differ in digits only (one digit, two, or more)."""
    lines: dict[str, str] = {}
    for file in corpus:
        for line in re.split("\r\n|\r|\n", file.read_bytes().decode("latin-1")):
            key = re.sub(r"[0-9]{3,}", "000", line)
            lines.setdefault(re.sub("[0-9]", "0", key), line)
    return list(lines.values())


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    skipped = [r for r in terminalreporter.stats.get("skipped", []) if NO_CORPUS in str(r.longrepr)]
    if skipped:
        terminalreporter.write_sep("!", f"{len(skipped)} CORPUS TESTS SKIPPED", red=True, bold=True)
        terminalreporter.write_line(HOW, red=True)
