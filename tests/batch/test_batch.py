"""Many programs at once give what each alone gives, whatever happens to the workers."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from chipbreak.batch import dask_cluster
from chipbreak.batch.inputs import inputs_of, is_program
from chipbreak.batch.processes import by_processes
from chipbreak.batch.work import Finished, Task, filtered
from chipbreak.cli import cli
from chipbreak.settings import load
from chipbreak.text.diagnostics import RefusalError
from warm import cold, warm_text

from .killed_worker import run as run_with_a_killed_worker

HEAD = b"G97 S3000 M3\nG0 X20. Z2.\n"
VIBRATED = HEAD + b"G1 Z-3. F0.05 N1.5\nM30\n"
PLAIN = HEAD + b"G1 Z-3. F0.05\nM30\n"
WRONG = HEAD + b"G1 Z-3. F0.05 N2\nM30\n"
LATHE = load("generic-lathe")

Runner = Callable[[Iterable[Task]], Iterator[Finished]]


def with_dask(tasks: Iterable[Task]) -> Iterator[Finished]:
    pytest.importorskip("distributed", reason="pip install 'chipbreak[dask]'")
    return dask_cluster.by_dask(tasks, "local", 2)


def with_processes(tasks: Iterable[Task]) -> Iterator[Finished]:
    return by_processes(tasks, 2)


RUNNERS = pytest.mark.parametrize("run", [with_processes, with_dask], ids=["processes", "dask"])


class Deadly(bytes):
    """A program that ends the process that reads it; with a file to remember, only the first time."""

    def __new__(cls, data: bytes, remember: Path | None = None) -> Deadly:
        self = super().__new__(cls, data)
        self.remember = remember
        return self

    def __reduce__(self) -> tuple[object, tuple[str]]:
        die = "__import__('os')._exit(9)"
        if self.remember is None:
            return eval, (die,)
        first = f"(open({str(self.remember)!r}, 'x').close(), {die})"
        seen = f"__import__('os').path.exists({str(self.remember)!r})"
        return eval, (f"{bytes(self)!r} if {seen} else {first}",)


def tasks_of(*programs: bytes) -> list[Task]:
    return [Task(number, f"{number}.nc", data, LATHE) for number, data in enumerate(programs)]


def alone(data: bytes) -> bytes:
    return chipbreak.rewrite(data, LATHE).data


@RUNNERS
def test_each_program_becomes_what_it_becomes_alone(run: Runner) -> None:
    programs = [VIBRATED, PLAIN, WRONG, VIBRATED.replace(b"Z-3.", b"Z-5."), b""]
    results = sorted(run(tasks_of(*programs)), key=lambda one: one.number)
    assert [one.code for one in results] == [0, 0, 3, 0, 0]
    for data, one in zip(programs, results, strict=True):
        if one.code == 0:
            assert one.data == alone(data)
            assert one.report is not None
        else:
            assert one.data is None
            assert [said.code for said in one.diagnostics if said.severity.value == "error"] == ["VIB005"]


def test_a_process_that_dies_once_costs_nothing(tmp_path: Path) -> None:
    programs = [VIBRATED] * 6
    programs[2] = Deadly(VIBRATED, tmp_path / "seen")
    results = list(with_processes(tasks_of(*programs)))
    assert (tmp_path / "seen").exists()
    assert sorted(one.number for one in results) == list(range(6))
    assert {one.data for one in results} == {alone(VIBRATED)}


def test_a_program_that_kills_every_process_is_lost_alone() -> None:
    programs = [VIBRATED] * 6
    programs[2] = Deadly(VIBRATED)
    results = {one.number: one for one in with_processes(tasks_of(*programs))}
    assert results[2].code == 4
    assert results[2].diagnostics[0].code == "BAT001"
    assert all(results[number].data == alone(VIBRATED) for number in results if number != 2)
    assert len(results) == 6


@pytest.mark.parametrize(
    "comes_back",
    [pytest.param(True, id="once"), pytest.param(False, id="every-time", marks=pytest.mark.long)],
)
def test_a_worker_of_a_cluster_that_dies(
    comes_back: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cloudpickle = pytest.importorskip("cloudpickle", reason="pip install 'chipbreak[dask]'")
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    seen = tmp_path / "seen"

    def deadly(task: Task) -> Finished:
        if task.number == 2 and not (comes_back and seen.exists()):
            seen.touch()
            os._exit(9)
        return filtered(task)

    monkeypatch.setattr(dask_cluster, "filtered", deadly)
    results = {one.number: one for one in with_dask(tasks_of(*[VIBRATED] * 6))}
    assert seen.exists()
    assert sorted(results) == list(range(6))
    assert {one.data for number, one in results.items() if number != 2 or comes_back} == {alone(VIBRATED)}
    if not comes_back:
        assert results[2].diagnostics[0].code == "BAT001"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds workers in /proc")
def test_a_worker_that_is_killed_from_outside_changes_no_result(tmp_path: Path) -> None:
    """As many as a shop has, from a folder of its own: ``python tests/batch/killed_worker.py FOLDER``."""
    shop = sorted((Path(__file__).parents[1] / "shop").glob("*.nc"), key=lambda path: path.stat().st_size)
    longer = VIBRATED.replace(b"Z-3.", b"Z-90.")
    programs = [*(path.read_bytes() for path in shop[:10]), WRONG, *[longer] * 9]
    outcome = run_with_a_killed_worker(programs, tmp_path)
    assert outcome.wrong == ()
    assert outcome.killed == 1
    assert outcome.changed >= 10
    assert outcome.rejected >= 1


def test_no_more_programs_are_read_than_workers_need() -> None:
    taken = count()

    def lazily() -> Iterator[Task]:
        for task in tasks_of(*[PLAIN] * 20):
            next(taken)
            yield task

    results = by_processes(lazily(), 2)
    next(results)
    results.close()  # type: ignore[attr-defined]
    assert next(taken) < 8


# --- the command ------------------------------------------------------------------------------------------


def chipbreak_run(command: str, *args: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """``batch`` in one process, unless it is said in how many."""
    several = "-j" in args or "--dask" in args
    return warm_text(command, *([] if several or command != "batch" else ["-j", "1"]), *args, cwd=cwd)


@pytest.fixture
def shop(tmp_path: Path) -> Path:
    files = {
        "in/O0001": VIBRATED,
        "in/deep/plain.NC": PLAIN,
        "in/deep/wrong.nc": WRONG,
        "in/notes.pdf": b"%PDF",
        "in/.hidden.nc": WRONG,
        "other.dat": VIBRATED,
    }
    for name, data in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return tmp_path


@pytest.mark.parametrize("output", ["in/out", "in/deep/../out", "out-by-link"])
def test_results_inside_the_folder_are_no_input_of_the_next_run(output: str, shop: Path) -> None:
    (shop / "in" / "out").mkdir()
    (shop / "out-by-link").symlink_to("in/out")
    for _ in range(2):
        chipbreak_run("batch", "-p", "generic-lathe", "-j", "1", "in", "-o", output, cwd=shop)
        there = {str(path.relative_to(shop / "in/out")) for path in (shop / "in/out").rglob("*.*")}
        assert there == {"deep/plain.NC", "deep/wrong.nc.rejected"}
    done = chipbreak_run("batch", "-p", "generic-lathe", "in/out", "-o", output, cwd=shop)
    assert done.returncode == 2
    assert "would replace itself" in done.stderr


def test_a_folder_becomes_a_folder(shop: Path) -> None:
    args = ["batch", "-p", "generic-lathe", "-j", "2", "in", "other.dat", "-o", "out"]
    done = cold(args, cwd=shop)
    assert done.returncode == 3
    there = {str(path.relative_to(shop / "out")) for path in (shop / "out").rglob("*") if path.is_file()}
    assert there == {"O0001", "deep/plain.NC", "deep/wrong.nc.rejected", "other.dat"}
    assert (shop / "out/O0001").read_bytes() == alone(VIBRATED) == (shop / "out/other.dat").read_bytes()
    assert (shop / "out/deep/plain.NC").read_bytes() == PLAIN
    assert "VIB005" in (shop / "out/deep/wrong.nc.rejected").read_text()
    lines = done.stdout.decode().splitlines()
    assert lines[0].split("  ", 1) == [
        "in/O0001",
        "        1 cut vibrates, it breaks; cycle 0:02.2 -> 0:02.7",
    ] or (lines[0].startswith("in/O0001 "))
    assert lines[-1] == "4 programs: 3 written, 2 of them with cuts that vibrate; 1 rejected"


def test_a_note_goes_away_when_the_program_is_right(shop: Path) -> None:
    chipbreak_run("batch", "-p", "generic-lathe", "in/deep/wrong.nc", "-o", "out", cwd=shop)
    assert (shop / "out/wrong.nc.rejected").exists()
    (shop / "in/deep/wrong.nc").write_bytes(PLAIN)
    done = chipbreak_run("batch", "-p", "generic-lathe", "in/deep/wrong.nc", "-o", "out", cwd=shop)
    assert done.returncode == 0
    assert [path.name for path in (shop / "out").iterdir()] == ["wrong.nc"]


def test_results_for_programs(shop: Path) -> None:
    done = chipbreak_run("batch", "-p", "generic-lathe", "--json", "in", "-o", "out", cwd=shop)
    told = json.loads(done.stdout)
    assert [one["file"] for one in told["programs"]] == ["in/O0001", "in/deep/plain.NC", "in/deep/wrong.nc"]
    assert told["programs"][0]["report"]["cuts"][0]["per_rev"] == 1.5
    assert told["programs"][2]["diagnostics"][0]["code"] == "VIB005"


def test_a_profile_beside_each_program(shop: Path) -> None:
    (shop / "in/chipbreak.toml").write_text('base = "generic-lathe"\n')
    (shop / "in/deep/chipbreak.toml").write_text('base = "no-such"\n')
    done = chipbreak_run("batch", "in", "-o", "out", cwd=shop)
    assert done.returncode == 2
    assert (shop / "out/O0001").read_bytes() == alone(VIBRATED)
    assert "2 not read" in done.stdout


def test_no_cluster_there(shop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="pip install 'chipbreak[dask]'")
    monkeypatch.setattr(dask_cluster, "_WAIT_S", 0.5)
    monkeypatch.chdir(shop)
    args = ["batch", "-p", "generic-lathe", "in", "-o", "out", "--dask", "tcp://127.0.0.1:9", "--quiet"]
    done = CliRunner().invoke(cli, args)
    assert done.exit_code == 2
    assert done.stderr.splitlines()[-2].startswith("error BAT002: no Dask cluster at tcp://127.0.0.1:9")


def test_dask_is_an_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(RefusalError, match="Dask is not installed") as caught:
        list(dask_cluster.by_dask(tasks_of(PLAIN), "local", 1))
    assert caught.value.code == "BAT002"


def test_a_program_that_is_not_there(shop: Path) -> None:
    done = chipbreak_run("batch", "-p", "generic-lathe", "missing.nc", "other.dat", "-o", "out", cwd=shop)
    assert done.returncode == 2
    assert (shop / "out/other.dat").exists()
    assert "BAT003" in (shop / "out/missing.nc.rejected").read_text()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["in", "-o", "in"], "would replace itself"),
        (["in/deep", "other.dat", "in/deep/../../other.dat", "missing.nc", "-o", "out"], "missing.nc"),
        (["empty", "-o", "out"], "no programs in there"),
    ],
)
def test_what_cannot_be_meant(shop: Path, args: list[str], said: str) -> None:
    (shop / "empty").mkdir()
    done = chipbreak_run("batch", "-p", "generic-lathe", *args, cwd=shop)
    assert done.returncode in {2, 3}
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_two_programs_for_one_place_are_refused(shop: Path) -> None:
    (shop / "more").mkdir()
    (shop / "more/O0001").write_bytes(PLAIN)
    done = chipbreak_run("batch", "-p", "generic-lathe", "in", "more", "-o", "out", cwd=shop)
    assert done.returncode == 2
    assert "would both become" in done.stderr
    assert not (shop / "out").exists()


# --- many inputs of the other commands ---------------------------------------------------------------------


def test_a_folder_in_place(shop: Path) -> None:
    done = chipbreak_run("filter", "-p", "generic-lathe", "-i", "--reject-file", "in", cwd=shop)
    assert done.returncode == 3
    assert (shop / "in/O0001").read_bytes() == alone(VIBRATED)
    assert (shop / "in/deep/wrong.nc").read_bytes() == WRONG
    assert "VIB005" in (shop / "in/deep/wrong.nc.rejected").read_text()
    assert (shop / "in/.hidden.nc").read_bytes() == WRONG


def test_a_folder_without_a_target_is_refused(shop: Path) -> None:
    done = chipbreak_run("filter", "-p", "generic-lathe", "in", cwd=shop)
    assert done.returncode == 2
    assert "one INPUT only" in done.stderr


def test_a_folder_is_checked(shop: Path) -> None:
    done = chipbreak_run("check", "-p", "generic-lathe", "in", cwd=shop)
    assert done.returncode == 1
    assert "in/deep/wrong.nc:3:" in done.stderr


def test_everything_that_is_said_goes_to_the_log_too(shop: Path) -> None:
    for args in (["in/O0001", "-o", "x.nc"], ["in/deep/wrong.nc", "-q"], ["missing.nc"]):
        chipbreak_run("filter", "-p", "generic-lathe", "--log", "log.txt", *args, cwd=shop)
    log = (shop / "log.txt").read_text()
    assert log.count(" chipbreak filter ") == 3
    assert "in/O0001: 1 cut vibrates" in log
    assert "error VIB005" in log
    assert "cannot read missing.nc" in log


@pytest.mark.parametrize("name", ["O0001", "o12A", "1234", "N100", "a.NC", "b.ngc", "c.tap", "d.MIN", "e.H"])
def test_names_of_programs(name: str) -> None:
    assert is_program(name)


@pytest.mark.parametrize(
    "name", [".a.nc", "README", "a.toml", "a.nc.bak", "a.nc.rejected", "Makefile", "a.json"]
)
def test_names_of_other_files(name: str) -> None:
    assert not is_program(name)


def test_a_file_named_twice_is_one(shop: Path) -> None:
    found = inputs_of([str(shop / "in"), str(shop / "in/O0001"), str(shop / "in/../in/deep")])
    assert [str(one.name) for one in found] == ["O0001", "deep/plain.NC", "deep/wrong.nc"]
