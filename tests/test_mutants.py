"""What ``make mutants`` draws: places that run, and what it shows is what it changes."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("cosmic_ray", reason="make mutants installs what changes the code")

import mutants

CODE = """from __future__ import annotations
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    LIMIT = 1
def half(x: int | None = 4, *, by: float = 2.0) -> int | None:
    y: int | None = x
    return y / by
"""
ONCE = """SHARE = 3.0
@functools.cache
def third(x: float) -> float:
    return x / 3.0
@property
def fourth(x: float) -> float:
    return x / 4.0
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(mutants, "TREE", tmp_path)
    file = tmp_path / "half.py"
    file.write_text(CODE)
    return file


def test_what_is_never_evaluated_is_not_changed(file: Path) -> None:
    found = list(mutants.mutants_of(file))
    assert {one.start[0] for one in found} == {5, 7}
    changed = {one.code() for one in found if one.is_code()}
    assert len(changed) > 10 and CODE not in changed
    assert CODE.replace("y / by", "y * by") in changed
    assert all(code.count("int | None") == 3 for code in changed), "an annotation"


def test_the_tests_of_a_statement_and_of_what_runs_on_import(file: Path) -> None:
    around = list(mutants._lines_around(file, 7))
    assert around[0] == range(7, 8)
    assert around[1] == range(5, 8), "the function"
    assert next(mutants._lines_around(file, 5)) == range(5, 8), (
        "its head runs on import, its body with a test"
    )


def test_what_is_worked_out_once_is_known(file: Path) -> None:
    """The head of a function runs on import, its body with every test, or with the first one."""
    file.write_text(ONCE)
    assert [mutants._is_once(file, line) for line in range(1, 8)] == [*(True,) * 6, False]
