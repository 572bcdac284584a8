"""What all tests share: the corpus of real programs, hypothesis profiles and loud reports of skips."""

from __future__ import annotations

import importlib
import os
import re
from pathlib import Path

import pytest
from hypothesis import settings

CHECKOUT = Path(__file__).parents[1]
NO_CORPUS = "the corpus of real programs is not here"
HOW = "Set CHIPBREAK_CORPUS to a folder of NC programs."
_NO_PROGRAMS = {".md", ".tsv", ".csv", ".json"}

settings.register_profile("quick", deadline=None, max_examples=150)
settings.register_profile("ci", deadline=None, max_examples=150, derandomize=True, print_blob=True)
settings.register_profile("long", deadline=None, max_examples=5000)
settings.load_profile("ci" if os.environ.get("CI") else "quick")


def corpus_dir() -> Path | None:
    """Where the corpus is, or None; a folder that was asked for must exist."""
    asked = os.environ.get("CHIPBREAK_CORPUS")
    if asked:
        if not Path(asked).is_dir():
            raise pytest.UsageError(f"CHIPBREAK_CORPUS is {asked}, which is not a folder")
        return Path(asked)
    beside = CHECKOUT.parent / "shared" / "corpus"
    return beside if beside.is_dir() else None


def corpus_programs() -> list[Path]:
    """Every program of the corpus, in a fixed order."""
    folder = corpus_dir()
    found = folder.rglob("*") if folder else ()
    return sorted(p for p in found if p.is_file() and p.suffix.lower() not in _NO_PROGRAMS)


def pytest_configure(config: pytest.Config) -> None:
    if (CHECKOUT / "tests" / "linuxcnc" / "plugin.py").is_file():
        config.pluginmanager.register(importlib.import_module("linuxcnc.plugin"))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test with an argument ``corpus_file`` runs once for every program of the corpus."""
    if "corpus_file" in metafunc.fixturenames:
        files = corpus_programs()
        missing = pytest.param(None, marks=pytest.mark.skip(reason=NO_CORPUS), id="no corpus")
        metafunc.parametrize("corpus_file", files or [missing], ids=lambda p: p.name if p else None)


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
