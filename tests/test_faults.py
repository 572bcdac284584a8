"""A file is old or new, whatever goes wrong while it is written, and the message says which."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pytest

import chipbreak
from beam import OPTIONS
from chipbreak import streams, whole_files
from chipbreak.streams import keep_file, read_input, replace_file
from warm import clean_environment, interruptible, warm

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

import faults

PROGRAM = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"
FILTERED = chipbreak.rewrite(PROGRAM, chipbreak.load("generic-lathe"), "a.nc").data
AS_IT_WAS = "the file is as it was"


@pytest.fixture(autouse=True)
def a_new_run() -> None:
    """Each test is a run of its own."""
    whole_files.SWEPT.clear()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "a.nc"
    file.write_bytes(PROGRAM)
    return file


def command(*arguments: str, cwd: Path, **extra: object) -> subprocess.CompletedProcess[bytes]:
    """A run in a Python of its own where something special is asked of it."""
    if not extra:
        return warm(list(arguments), cwd=cwd)
    line = [sys.executable, "-m", "chipbreak", *arguments]
    return subprocess.run(line, capture_output=True, cwd=cwd, env=clean_environment(), check=False, **extra)  # type: ignore[call-overload,no-any-return]


def in_place(cwd: Path, *more: str, **extra: object) -> subprocess.CompletedProcess[bytes]:
    return command("filter", "-q", "-p", "generic-lathe", "-i", "a.nc", *more, cwd=cwd, **extra)


@pytest.mark.parametrize(
    "line",
    [
        "filter {0} -p generic-lathe",
        "filter a.nc -p {0}",
        "filter a.nc -p generic-lathe -o {0}",
        "filter -i {0} -p generic-lathe",
        "filter a.nc -p generic-lathe --tools {0}",
        "verify {0}",
        "batch {0} -p generic-lathe -o out",
        "batch a.nc -p generic-lathe -o {0}",
        "hooks write cam -p generic-lathe -o {0}",
        "hooks write cam -p {0} -o out",
        "profile init {0}",
        "profile show {0}",
        "machine-test write -p linuxcnc-lathe -o {0}",
        "explain a.nc -p {0}/{0}.toml",
    ],
)
def test_a_name_that_no_file_can_have_is_not_there(file: Path, line: str) -> None:
    done = command(*line.format("n" * 300).split(), cwd=file.parent)
    assert done.returncode == 2, done.stderr
    assert not done.stdout or b"0 written" in done.stdout
    assert {*names(file.parent), "out"} == {"a.nc", "out"}  # a batch has made its folder by then
    assert file.read_bytes() == PROGRAM


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# --- killed -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("writings", [4, pytest.param(20, marks=pytest.mark.long)])
def test_killed_at_some_moments(writings: int, tmp_path: Path) -> None:
    import random

    for kill, runs in ((faults.kill_whole_runs, 2), (faults.kill_writing, writings)):
        found = kill(tmp_path, runs, random.Random(1))
        assert found["old"] + found["new"] == runs
        assert not [key for key in found if key.isupper() and found[key]], found


def test_what_a_killed_run_has_left_goes_with_the_next_one(file: Path) -> None:
    left = file.with_name(".chipbreak-4711-0123abcd.part")
    left.write_bytes(b"half of it")
    others = [file.with_name(name) for name in (".chipbreak-1-0123abcd.part.nc", "chipbreak-1-0123abcd.part")]
    for other in others:
        other.write_bytes(b"somebody's")
    replace_file(file, [b"new"])
    assert names(file.parent) == sorted([file.name, *(other.name for other in others)])


def test_what_another_run_is_writing_stays(file: Path) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def waits(_: Path) -> None:
        begun.set()
        assert go_on.wait(10)

    writer = threading.Thread(target=lambda: whole_files.replace(file, [b"first"], before=waits))
    writer.start()
    assert begun.wait(10)
    whole_files.SWEPT.clear()
    replace_file(file.with_name("other.nc"), [b"second"])
    go_on.set()
    writer.join()
    assert file.read_bytes() == b"first"
    assert names(file.parent) == ["a.nc", "other.nc"]


def test_an_interrupted_run_says_what_is_written(tmp_path: Path) -> None:
    for name, count in (("a.nc", 1), ("b.nc", 4000)):
        (tmp_path / name).write_bytes(PROGRAM[:-4] + b"G0 Z2.\nG1 Z-3. F0.05 N1.5\n" * count + b"M30\n")
    old = (tmp_path / "b.nc").read_bytes()
    line = [sys.executable, "-m", "chipbreak", "filter", "-q", "-p", "generic-lathe", "-i", "a.nc", "b.nc"]
    with interruptible():
        process = subprocess.Popen(line, cwd=tmp_path, stderr=subprocess.PIPE)
    with process:
        end = time.monotonic() + 30
        while b"CHIPBREAK" not in (tmp_path / "a.nc").read_bytes():
            assert time.monotonic() < end
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[1]
    assert (process.returncode, said) == (130, b"Interrupted; written: a.nc; nothing else was\n")
    assert (tmp_path / "b.nc").read_bytes() == old
    assert names(tmp_path) == ["a.nc", "b.nc"]


@pytest.mark.parametrize("is_in_place", [False, True])
def test_an_interruption_around_the_renaming_says_what_is_there(
    is_in_place: bool, file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    replace = whole_files.replace

    def interrupted(*args: Any, **named: Any) -> None:
        if is_in_place:
            replace(*args, **named)
        raise KeyboardInterrupt

    monkeypatch.setattr(whole_files, "replace", interrupted)
    monkeypatch.setattr(streams, "_written", [])
    with pytest.raises(KeyboardInterrupt):
        streams.replace_file(file, [b"new"])
    streams.say_interrupted()
    assert file.read_bytes() == (b"new" if is_in_place else PROGRAM)
    said = f"written: {file}; nothing else was" if is_in_place else "nothing was written"
    assert capsys.readouterr().err == f"Interrupted; {said}\n"


# --- no room, no right ------------------------------------------------------------------------------------


def no_room(most_bytes: int = 1000) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))


@pytest.mark.parametrize("backup", [[], ["--backup", ".bak"]])
def test_no_room_on_the_disk(backup: list[str], file: Path) -> None:
    done = in_place(file.parent, *backup, preexec_fn=no_room)
    assert done.returncode == 2
    assert f"cannot write a.nc: File too large; {AS_IT_WAS}" in done.stderr.decode()
    assert file.read_bytes() == PROGRAM
    assert names(file.parent) == (["a.nc", "a.nc.bak"] if backup else ["a.nc"])


def test_no_room_for_a_new_file(file: Path) -> None:
    done = command(
        "filter", "-q", "-p", "generic-lathe", "a.nc", "-o", "b.nc", cwd=file.parent, preexec_fn=no_room
    )
    assert done.returncode == 2
    assert b"cannot write b.nc: File too large; no part of it is there" in done.stderr
    assert names(file.parent) == ["a.nc"]


def test_of_several_files_it_is_said_which_are_new(tmp_path: Path) -> None:
    line = ("macros", "-p", "linuxcnc-mill", *OPTIONS, "-o", "m")
    done = command(*line, cwd=tmp_path, preexec_fn=lambda: no_room(1500))
    assert done.returncode == 2
    assert names(tmp_path / "m") == ["cb_above.ngc"]
    assert (tmp_path / "m" / "cb_above.ngc").read_bytes().endswith(b"M2\n")
    said = "cannot write m/cb_calibrate.ngc: File too large; no part of it is there"
    assert f"{said}; written before: m/cb_above.ngc" in done.stderr.decode()


def test_one_program_of_many_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "out" / "b.nc").mkdir(parents=True)  # a folder is in the way
    for name in ("a.nc", "b.nc", "c.nc"):
        (tmp_path / "in" / name).write_bytes(PROGRAM)
    done = command("batch", "-j", "1", "-p", "generic-lathe", "in", "-o", "out", cwd=tmp_path)
    assert done.returncode == 2
    assert b"NOT WRITTEN BAT004, cannot write out/b.nc: Is a directory" in done.stdout
    assert b"2 written, 2 of them with cuts that vibrate; 1 not written" in done.stdout
    assert [(tmp_path / "out" / name).read_bytes() for name in ("a.nc", "c.nc")] == [FILTERED] * 2


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can become somebody else"
)
@pytest.mark.parametrize(
    ("folder_mode", "file_mode", "owner", "said"),
    [
        (0o755, 0o666, 0, "no file can be made beside it: Permission denied"),
        (0o777, 0o444, 0, "Permission denied"),
        (0o777, 0o666, 1, "it belongs to user 1 and group 1, and a new file in its place to 65534 and 65534"),
    ],
    ids=["folder", "file", "owner"],
)
def test_what_somebody_else_may_not_replace(folder_mode: int, file_mode: int, owner: int, said: str) -> None:
    with tempfile.TemporaryDirectory() as name:  # where others may go, too
        file = Path(name, "a.nc")
        file.write_bytes(PROGRAM)
        file.chmod(file_mode)
        os.chown(file, owner, owner)
        file.parent.chmod(folder_mode)
        with pytest.raises(ChildError, match=said):
            as_nobody(lambda: replace_file(file, [b"new"]))
        assert file.read_bytes() == PROGRAM
        assert names(file.parent) == ["a.nc"]


class ChildError(Exception):
    """What a process of its own has said."""


def as_nobody(work: Callable[[], object]) -> None:
    reads, writes = os.pipe()
    child = os.fork()
    if not child:
        os.setgid(65534)
        os.setuid(65534)
        try:
            work()
        except click.UsageError as error:
            os.write(writes, error.message.encode())
        finally:
            os._exit(0)
    os.close(writes)
    os.waitpid(child, 0)
    with os.fdopen(reads) as pipe:
        raise ChildError(pipe.read())


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
def test_owner_group_and_mode_stay(file: Path) -> None:
    os.chown(file, 1, 2)
    file.chmod(0o640)
    keep_file(file, PROGRAM, ".bak")
    replace_file(file, [b"new"])
    for path in (file, file.with_name("a.nc.bak")):
        found = path.stat()
        assert (found.st_uid, found.st_gid, found.st_mode & 0o7777) == (1, 2, 0o640)


# --- links, devices, pipes --------------------------------------------------------------------------------


def test_a_file_with_a_second_name_is_not_torn_from_it(file: Path) -> None:
    other = file.with_name("other.nc")
    os.link(file, other)
    done = in_place(file.parent)
    assert done.returncode == 2
    assert b"cannot write a.nc: it has 2 names (hard links)" in done.stderr
    assert file.samefile(other)
    assert file.read_bytes() == PROGRAM
    # The way out of the message.
    shutil.copyfile(file, file.with_name("copy"))
    file.with_name("copy").replace(file)
    assert in_place(file.parent).returncode == 0
    assert (file.read_bytes(), other.read_bytes()) == (FILTERED, PROGRAM)


def test_a_link_into_another_folder_stays_a_link(file: Path) -> None:
    (file.parent / "deep").mkdir()
    target = file.rename(file.parent / "deep" / "b.nc")
    file.symlink_to(target)
    assert in_place(file.parent, "--backup", ".bak").returncode == 0
    assert file.is_symlink()
    assert (target.read_bytes(), file.with_name("a.nc.bak").read_bytes()) == (FILTERED, PROGRAM)


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout here")
def test_standard_output_by_its_name_is_written_into(file: Path) -> None:
    """Where it goes to a file, that file is not replaced under those who write into it too."""
    line = f"echo A; {sys.executable} -m chipbreak filter -q -p generic-lathe a.nc -o /dev/stdout; echo B"
    with file.with_name("out").open("wb") as out:
        subprocess.run(["sh", "-c", line], cwd=file.parent, stdout=out, check=True)
    assert file.with_name("out").read_bytes() == b"A\n" + FILTERED + b"B\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_device(file: Path) -> None:
    done = command("filter", "-q", "-p", "generic-lathe", "a.nc", "-o", "/dev/full", cwd=file.parent)
    assert done.returncode == 2
    assert b"cannot write /dev/full: No space left on device" in done.stderr


def test_no_pipe_is_filtered_in_place(file: Path) -> None:
    file.unlink()
    os.mkfifo(file)
    done = in_place(file.parent, timeout=20)
    assert done.returncode == 2
    assert b"-i replaces INPUT itself, and a.nc is no file" in done.stderr


@pytest.mark.parametrize(
    ("redirection", "code"),
    [("2>&-", 0), ("2>/dev/full", 0), ("--set x 2>&-", 2), ("--set x 2>/dev/full", 2)],
)
def test_a_standard_error_that_takes_nothing_changes_nothing(redirection: str, code: int, file: Path) -> None:
    line = f"{sys.executable} -m chipbreak filter -p generic-lathe a.nc -o b.nc {redirection}"
    done = subprocess.run(["sh", "-c", line], cwd=file.parent, capture_output=True, check=False)
    assert done.returncode == code
    assert names(file.parent) == (["a.nc"] if code else ["a.nc", "b.nc"])


@pytest.mark.parametrize("what", ["explain", "profile show generic-lathe", "explain --json"])
def test_a_closed_standard_output_is_said(what: str, file: Path) -> None:
    profile = "-p generic-lathe a.nc" if what.startswith("explain") else ""
    line = f"{sys.executable} -m chipbreak {what} {profile} >&-"
    done = subprocess.run(["sh", "-c", line], cwd=file.parent, capture_output=True, check=False)
    assert done.returncode == 2
    assert b"standard output is closed" in done.stderr


# --- two at once ------------------------------------------------------------------------------------------


def test_a_file_that_somebody_changed_meanwhile_is_left_alone(file: Path) -> None:
    file.write_bytes(b"edited")
    with pytest.raises(
        click.UsageError, match=f"somebody else has changed it since it was read; {AS_IT_WAS}"
    ):
        replace_file(file, [FILTERED], instead_of=PROGRAM)
    assert file.read_bytes() == b"edited"
    assert names(file.parent) == ["a.nc"]


def test_two_filters_on_one_file(file: Path) -> None:
    """With one profile both make the same, so both are right; nobody sees a half."""
    line = [sys.executable, "-m", "chipbreak", "filter", "-q", "-p", "generic-lathe", "-i", "a.nc"]
    both = [subprocess.Popen(line, cwd=file.parent) for _ in range(2)]
    seen = set()
    while any(process.poll() is None for process in both):
        seen.add(file.read_bytes())
    assert [process.returncode for process in both] == [0, 0]
    assert seen <= {PROGRAM, FILTERED}
    assert file.read_bytes() == FILTERED
    assert names(file.parent) == ["a.nc"]


def test_an_input_that_changes_while_it_is_read(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fstat, calls = os.fstat, []

    def changing(descriptor: int) -> os.stat_result:
        if calls:
            file.write_bytes(PROGRAM + b"more")
        calls.append(descriptor)
        return fstat(descriptor)

    monkeypatch.setattr(os, "fstat", changing)
    with pytest.raises(click.UsageError, match="it changes while it is read"):
        read_input(str(file))


# --- backups ----------------------------------------------------------------------------------------------


def test_an_older_backup_is_never_overwritten(file: Path) -> None:
    backups = [file.with_name(name) for name in ("a.nc.bak", "a.nc.bak.2")]
    assert in_place(file.parent, "--backup", ".bak").returncode == 0
    done = command(
        *("filter", "-p", "generic-lathe", "-i", "a.nc", "--backup", ".bak", "--set", "output.decimals=4"),
        cwd=file.parent,
    )
    assert b"a.nc: an older backup is there; the original is kept as a.nc.bak.2" in done.stderr
    assert [backup.read_bytes() for backup in backups] == [PROGRAM, FILTERED]
    # What says the same already is not kept twice.
    assert keep_file(file, FILTERED, ".bak") == backups[1]
    assert names(file.parent) == ["a.nc", "a.nc.bak", "a.nc.bak.2"]


def test_a_backup_on_a_memory_card(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(_old: object, _new: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", no_links)
    file.with_name("a.nc.bak").write_bytes(b"older")
    assert keep_file(file, PROGRAM, ".bak").name == "a.nc.bak.2"
    assert (file.with_name("a.nc.bak").read_bytes(), file.with_name("a.nc.bak.2").read_bytes()) == (
        b"older",
        PROGRAM,
    )


def test_without_its_backup_a_file_is_not_replaced(file: Path) -> None:
    long = ".b" * 130  # a.nc with it is longer than a file system takes
    done = in_place(file.parent, "--backup", long)
    assert done.returncode == 2
    assert b"cannot write the backup a.nc.b" in done.stderr
    assert b"File name too long; a.nc is as it was" in done.stderr
    assert file.read_bytes() == PROGRAM
    assert names(file.parent) == ["a.nc"]
