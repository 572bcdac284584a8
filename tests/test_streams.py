"""Streams and files that do not take or give what they should: a message, exit code 2, no fault of ours."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import threading
from importlib.metadata import version
from pathlib import Path

import click
import pytest

import chipbreak
from chipbreak.streams import replace_file
from warm import clean_environment, warm_command

WORKED = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"
FILTER = "filter -p generic-lathe"


def shell(command: str, cwd: Path) -> subprocess.CompletedProcess[bytes]:
    """Run ``chipbreak COMMAND``, with redirections, in a folder where in.nc stands.

    A new Python is asked about the first of its streams that is closed, and about a full disk.
    """
    (cwd / "in.nc").write_bytes(WORKED)
    is_new = "&-" in command or command == f"{FILTER} in.nc >/dev/full"
    program = f"{shlex.quote(sys.executable)} -m chipbreak" if is_new else str(warm_command())
    line = ["sh", "-c", f"{program} {command}"]
    return subprocess.run(line, capture_output=True, cwd=cwd, env=clean_environment(), check=False)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize(
    "command",
    [
        f"{FILTER} in.nc",
        "explain -p generic-lathe in.nc",
        "diff in.nc in.nc",
        "restore in.nc",
        "profile list",
    ],
)
def test_a_full_disk_behind_stdout(command: str, tmp_path: Path) -> None:
    done = shell(f"{command} >/dev/full", tmp_path)
    if command.startswith("diff"):  # says nothing, so nothing is lost
        assert (done.returncode, done.stderr) == (0, b"")
        return
    assert done.returncode == 2
    assert b"No space left on device" in done.stderr
    assert b"SLF" not in done.stderr
    assert b"Exception" not in done.stderr


@pytest.mark.parametrize(
    ("redirection", "wanted"),
    [
        (f"{FILTER} <&-", b"standard input is closed: name a file"),
        (f"{FILTER} in.nc >&-", b"standard output is closed: name a file with -o"),
        ("restore in.nc >&-", b"standard output is closed: name a file with -o"),
    ],
)
def test_a_closed_stream(redirection: str, wanted: bytes, tmp_path: Path) -> None:
    done = shell(redirection, tmp_path)
    assert done.returncode == 2
    assert done.stdout == b""
    assert wanted in done.stderr


def test_a_link_that_leads_to_itself(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    done = shell(f"{FILTER} in.nc -o loop", tmp_path)
    assert done.returncode == 2
    assert b"cannot write loop: Too many levels of symbolic links" in done.stderr
    assert (tmp_path / "loop").is_symlink()


def test_a_pipe_is_written_into_and_stays_one(tmp_path: Path) -> None:
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
    reader.start()
    assert shell(f"{FILTER} in.nc -o pipe", tmp_path).returncode == 0
    assert pipe.is_fifo(), "not replaced by a file"
    reader.join(10)
    assert got == [chipbreak.rewrite(WORKED, chipbreak.load("generic-lathe")).data]


def test_a_file_that_may_not_be_written_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.nc"
    file.write_bytes(b"old")
    file.chmod(0o444)
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # as for anybody but root
    with pytest.raises(click.UsageError, match=r"cannot write .*a\.nc: Permission denied"):
        replace_file(file, [b"new"])
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    assert file.read_bytes() == b"old"


def test_a_bad_file_of_tools_is_said_in_json_when_asked(tmp_path: Path) -> None:
    (tmp_path / "milled.nc").write_bytes(b"T1 M6\nS1000 M3\nG0 X0. Y0. Z2.\nG1 Z-5. F100.\nG0 Z100.\nM30\n")
    done = shell("filter -p fanuc-mill --tools none.csv --json milled.nc", tmp_path)
    assert done.returncode == 2
    assert [found["code"] for found in json.loads(done.stderr)] == ["TOL001"]


def test_a_profile_by_its_path(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text('base = "generic-lathe"\n')
    assert chipbreak.load(file) == chipbreak.load(str(file))


@pytest.mark.parametrize("name", [name for name in chipbreak.__all__ if name != "__version__"])
def test_what_the_package_offers_is_there(name: str) -> None:
    assert getattr(chipbreak, name).__name__ == name


def test_the_package_says_its_version() -> None:
    assert "__version__" in chipbreak.__all__
    assert chipbreak.__version__ == version("chipbreak")


@pytest.mark.parametrize("command", ["filter", "explain", "verify", "tools", "restore"])
def test_a_damaged_part_is_no_fault_of_ours(command: str, tmp_path: Path) -> None:
    (tmp_path / "damaged.nc").write_bytes(b"(CHIPBREAK BEGIN X)\nG1 X1.\n")
    profile = "" if command == "restore" else "-p fanuc-mill"
    done = shell(f"{command} {profile} damaged.nc", tmp_path)
    assert (done.returncode, done.stdout) == (3, b"")
    assert done.stderr.startswith(b"damaged.nc:1:1: error RES002")


def test_no_verdict_of_an_edge_where_its_figure_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "edge.csv").write_text("tooth,height_mm,radius_mm\n1,0,5\n1,1,5\n")
    done = shell("inspect edge.csv edge.csv --next rough -o none/edge.svg", tmp_path)
    assert (done.returncode, done.stdout) == (2, b"")
    assert b"cannot write none/edge.svg" in done.stderr


@pytest.mark.parametrize("mask", [0o022, 0o027, 0o077])
def test_a_new_file_gets_the_mode_of_new_files_and_an_old_one_keeps_its_own(
    mask: int, tmp_path: Path
) -> None:
    old = tmp_path / "old.nc"
    old.write_bytes(b"")
    old.chmod(0o640)
    before = os.umask(mask)
    try:
        for name in ("old.nc", "new.nc"):
            replace_file(tmp_path / name, [b"M30\n"])
    finally:
        os.umask(before)
    modes = {name: (tmp_path / name).stat().st_mode & 0o777 for name in ("old.nc", "new.nc")}
    assert modes == {"old.nc": 0o640, "new.nc": 0o666 & ~mask}


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal of Unix")
@pytest.mark.parametrize("is_terminal", [True, False])
def test_a_terminal_is_told_what_is_waited_for(is_terminal: bool, tmp_path: Path) -> None:
    import pty

    program = b"G97 S3000 M3\nG0 X20. Z2.\nM30\n"
    ours, theirs = pty.openpty() if is_terminal else os.pipe()[::-1]
    try:
        os.write(ours, program + b"\x04" * is_terminal)
        if not is_terminal:
            os.close(ours)
        command = [sys.executable, "-m", "chipbreak", "filter", "-p", "generic-lathe"]
        done = subprocess.run(
            command, stdin=theirs, capture_output=True, check=False, cwd=tmp_path, timeout=60
        )
    finally:
        os.close(theirs)
        if is_terminal:
            os.close(ours)
    assert done.returncode == 0
    assert done.stdout == program
    assert (b"waiting for a program from the keyboard" in done.stderr) == is_terminal
