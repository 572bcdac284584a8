"""The benchmarks still run.  Nothing here looks at a clock: how fast it is, is for ``make bench``."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from warm import warm_command

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

import before  # noqa: E402
import edges  # noqa: E402
import programs  # noqa: E402
import run as benchmarks  # noqa: E402
import subject  # noqa: E402
from rows import Goal, Row  # noqa: E402
from stopwatch import Contestant, Sample, in_turn, ratio  # noqa: E402


class Run(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Run]:
    """``benchmarks/run.py`` in this process, with a chipbreak that has nothing to load."""
    for module in (subject, before, edges):
        monkeypatch.setattr(module, "command", lambda: (str(warm_command()),))

    def of(*arguments: str) -> Run:
        monkeypatch.setattr(sys, "argv", ["run.py", *arguments])
        try:
            code = benchmarks.main()
        except SystemExit as ended:
            code = int(str(ended.code))
        return Run(code, *capsys.readouterr())

    return of


def test_it_runs_as_it_is_called(tmp_path: Path) -> None:
    results = tmp_path / "results.json"
    command = [sys.executable, str(BENCHMARKS / "run.py"), "--quick", "--smaller", "1000", "--only", "modal"]
    done = subprocess.run([*command, "--json", str(results)], capture_output=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert results.exists()


@pytest.mark.parametrize("case", ["pass-through", "expansion", "planned", "emit", "start-up"])
def test_a_case_runs(case: str, tmp_path: Path, run: Callable[..., Run]) -> None:
    results = tmp_path / "results.json"
    done = run("--quick", "--smaller", "1000", "--only", case, "--json", str(results))
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads(results.read_text())["cases"][case]["rows"]
    assert len(rows) > 1
    assert all(sample["wall_s"] > 0.0 for row in rows for sample in row["samples"])
    assert all(row["name"] in done.stdout for row in rows)


def test_another_chipbreak_runs_in_turn(tmp_path: Path, run: Callable[..., Run]) -> None:
    results = tmp_path / "results.json"
    other = str(warm_command())
    done = run("--quick", "--smaller", "5000", "--before", other, "--json", str(results))
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads(results.read_text())["cases"]["before"]["rows"]
    ours = ["pass-through", "modal", "expansion", "small", "help"]
    assert [row["name"] for row in rows] == [name for one in ours for name in (one, "  before")]
    for mine, its in zip(rows[::2], rows[1::2], strict=True):
        assert len(mine["samples"]) == len(its["samples"]) > 0
        ratios = [a["cpu_s"] / b["cpu_s"] for a, b in zip(mine["samples"], its["samples"], strict=True)]
        assert mine["goal"]["value"] == pytest.approx(sorted(ratios)[len(ratios) // 2])
        assert ("the same bytes" in mine["note"]) == (mine["name"] != "help")


def test_bytes_that_another_chipbreak_writes_are_compared(tmp_path: Path, run: Callable[..., Run]) -> None:
    other = tmp_path / "chipbreak"
    other.write_text('#!/bin/sh\nfor last; do :; done\ncase " $* " in *" -o "*) echo else >"$last";; esac\n')
    other.chmod(0o755)
    done = run("--quick", "--smaller", "5000", "--before", str(other))
    assert done.stdout.count("OTHER BYTES") == 4


def test_another_chipbreak_that_is_not_there_is_said(tmp_path: Path, run: Callable[..., Run]) -> None:
    done = run("--quick", "--smaller", "1000", "--before", str(tmp_path / "chipbreak"))
    assert done.returncode == 2
    assert "COULD NOT BE MEASURED" in done.stderr


def test_a_case_that_does_not_exist_is_refused(run: Callable[..., Run]) -> None:
    done = run("--only", "dancing")
    assert done.returncode == 2
    assert "pass-through" in done.stderr


def test_a_program_has_the_blocks_that_were_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "mill.nc"
    programs.milling(path, 1000)
    lines = path.read_text("ascii").split("\n")[1:-2]
    assert len(lines) == 1000
    assert [line.split(" ")[0] for line in lines] == [f"N{number + 1}" for number in range(1000)]
    assert sum("FINISH" in line or "ROUGH" in line for line in lines) == programs.OPERATIONS
    assert lines[-1].endswith("M30")


def test_a_program_is_the_same_every_time(tmp_path: Path) -> None:
    for name in ("one", "two"):
        programs.milling(tmp_path / name, 1000, modal=True)
        programs.turning(tmp_path / f"{name}.turn", 20_000)
        programs.long_line(tmp_path / f"{name}.line", 100_001)
    for kind in ("", ".turn", ".line"):
        assert (tmp_path / f"one{kind}").read_bytes() == (tmp_path / f"two{kind}").read_bytes()
    assert (tmp_path / "one.line").stat().st_size == 100_001


def test_everybody_runs_once_a_round_and_not_always_first(tmp_path: Path) -> None:
    log = tmp_path / "log"
    code = "import sys; open(sys.argv[1], 'a').write(sys.argv[2])"
    everybody = [Contestant(name, (sys.executable, "-c", code, str(log), name)) for name in "abc"]
    samples = in_turn(everybody, 3)
    assert [len(found) for found in samples] == [3, 3, 3]
    assert log.read_text() == "abcbcacab"


def test_only_runs_of_one_round_are_compared() -> None:
    slow_machine = [Sample(wall_s, wall_s, 0) for wall_s in (2.0, 20.0, 2.0)]
    same_machine = [Sample(wall_s, wall_s, 0) for wall_s in (1.0, 10.0, 1.0)]
    assert ratio(slow_machine, same_machine) == 2.0
    assert ratio(slow_machine, same_machine, units=0.5) == 4.0


def test_a_missed_target_is_said() -> None:
    assert "MISSED" in Row("filter", Goal(0.9, 1.0, at_least=True, unit="M blocks/s")).text()
    assert "met" in Row("filter", Goal(0.9, 1.0, at_least=False, unit="x as long")).text()
