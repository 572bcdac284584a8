"""git compares programs by what their blocks say, and never fails of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.diff import items_of
from warm import warm_command, warm_text

PROGRAM = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
COLD = f'"{sys.executable}" -m chipbreak'


def git(folder: Path, *args: str) -> subprocess.CompletedProcess[str]:
    env = {k: v for k, v in os.environ.items() if not k.startswith(("CHIPBREAK", "GIT_"))}
    env |= {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull, "HOME": str(folder)}
    identity = ["-c", "user.name=Shop", "-c", "user.email=shop@example.com"]
    return subprocess.run(
        ["git", *identity, *args],
        cwd=folder,
        env=env,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    git(tmp_path, "init", "-q")
    (tmp_path / ".gitattributes").write_text("*.nc diff=nc\n")
    filtered = chipbreak.rewrite(PROGRAM, chipbreak.load("generic-lathe"), "part.nc").data
    (tmp_path / "part.nc").write_bytes(filtered)
    (tmp_path / "plain.nc").write_bytes(PROGRAM)
    git(tmp_path, "add", ".")
    assert git(tmp_path, "commit", "-qm", "first").returncode == 0
    return tmp_path


@pytest.fixture
def driver(repository: Path) -> Path:
    git(repository, "config", "diff.nc.command", f"{warm_command()} git-diff")
    return repository


@pytest.fixture
def converter(repository: Path) -> Path:
    git(repository, "config", "diff.nc.textconv", f"{warm_command()} textconv")
    return repository


def test_other_spaces_are_no_change(driver: Path) -> None:
    git(driver, "config", "diff.nc.command", f"{COLD} git-diff")
    (driver / "plain.nc").write_bytes(PROGRAM.replace(b"G1 Z-30. F0.05", b"N30 G01 Z-30.000 F.05"))
    done = git(driver, "diff")
    assert done.returncode == 0
    assert done.stdout == "diff --chipbreak a/plain.nc b/plain.nc\nthe same blocks\n"


def test_a_cut_that_changed_is_one_line(driver: Path) -> None:
    other = chipbreak.rewrite(PROGRAM.replace(b"-30.", b"-40."), chipbreak.load("generic-lathe")).data
    (driver / "part.nc").write_bytes(other)
    done = git(driver, "diff")
    assert done.returncode == 0
    changed = [line for line in done.stdout.splitlines() if line[:1] in "+-" and line[1:2] not in "+-"]
    assert len(changed) == 2
    assert changed[0].startswith("-[VIB N1.5 F62.5 S2500 STROKE 0.06: ")
    assert changed[1].startswith("+[VIB N1.5 F62.5 S2500 STROKE 0.06: ")


@pytest.mark.parametrize("damage", [(b"Z-30.", b"Z-31."), (b"(CHIPBREAK END", b"(CHIPBREAK ENT")])
def test_a_part_edited_by_hand_is_shown(driver: Path, damage: tuple[bytes, bytes]) -> None:
    edited = (driver / "part.nc").read_bytes().replace(*damage)
    (driver / "part.nc").write_bytes(edited)
    for command in (("diff",), ("log", "-p", "--ext-diff"), ("diff", "--stat")):
        done = git(driver, *command)
        assert done.returncode == 0, done.stderr
        assert "Traceback" not in done.stderr
    assert "compared by its text" in git(driver, "diff").stdout


def test_files_that_come_and_go(driver: Path) -> None:
    (driver / "plain.nc").rename(driver / "moved.nc")
    (driver / "new.nc").write_bytes(PROGRAM)
    git(driver, "add", "-A")
    done = git(driver, "diff", "--cached", "-M")
    assert done.returncode == 0, done.stderr
    assert "/dev/null" in done.stdout


def test_a_file_in_conflict(driver: Path) -> None:
    git(driver, "checkout", "-qb", "other")
    (driver / "plain.nc").write_bytes(PROGRAM.replace(b"S3000", b"S2000"))
    git(driver, "commit", "-qam", "slower")
    git(driver, "checkout", "-q", "-")
    (driver / "plain.nc").write_bytes(PROGRAM.replace(b"S3000", b"S4000"))
    git(driver, "commit", "-qam", "faster")
    assert git(driver, "merge", "other").returncode == 1
    done = git(driver, "diff")
    assert done.returncode == 0, done.stderr


def test_numbers_are_read_by_the_profile_beside_the_program(driver: Path) -> None:
    (driver / "plain.nc").write_bytes(PROGRAM.replace(b"X20.", b"X20"))
    assert "+G0 X20 Z2." in git(driver, "diff").stdout
    (driver / "chipbreak.toml").write_text('base = "linuxcnc-lathe"\n')
    assert "the same blocks" in git(driver, "diff").stdout


def test_the_converter_shows_a_filtered_cut_in_one_line(converter: Path) -> None:
    shorter = chipbreak.rewrite(PROGRAM.replace(b"-30.", b"-40."), chipbreak.load("generic-lathe")).data
    (converter / "part.nc").write_bytes(shorter)
    done = git(converter, "diff")
    assert done.returncode == 0
    changed = [line for line in done.stdout.splitlines() if line[:1] in "+-" and line[1:2] not in "+-"]
    assert len(changed) == 2


def test_the_converter_never_fails(converter: Path) -> None:
    edited = (converter / "part.nc").read_bytes().replace(b"Z-30.", b"Z-31.")
    (converter / "part.nc").write_bytes(edited)
    (converter / "plain.nc").write_bytes(b"%\x00\xff(((\n\r\r" * 50)
    done = git(converter, "diff", "--text")
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert "Z-31." in done.stdout


def test_a_rejected_unicode_program_is_shown_as_it_is(driver: Path) -> None:
    (driver / "plain.nc").write_bytes(PROGRAM.decode().encode("utf-16"))
    done = git(driver, "diff", "--text")
    assert done.returncode == 0, done.stderr


# --- programs without our comments -----------------------------------------------------------------------
def write_bare(folder: Path, z: str) -> str:
    """A filtered program whose brackets are in the file beside it; its cut as it is shown in one line."""
    settings = chipbreak.load("generic-lathe", ["output.brackets=none"])
    result = chipbreak.rewrite(PROGRAM.replace(b"-30.", z.encode()), settings, "bare.nc")
    assert result.beside is not None
    assert b"CHIPBREAK" not in result.data
    folder.mkdir(exist_ok=True)
    (folder / "bare.nc").write_bytes(result.data)
    (folder / "bare.nc.chipbreak").write_bytes(result.beside)
    (cut,) = [one.text for one in items_of(result.data, "", beside=result.beside) if "[VIB" in one.text]
    return cut


def changes(text: str) -> list[str]:
    return [line for line in text.splitlines() if line[:1] in "+-" and line[1:2] not in "+-"]


@pytest.fixture(params=["driver", "converter"])
def bare(request: pytest.FixtureRequest) -> Path:
    """A repository with a bare program in three versions, compared by each of the two commands."""
    folder: Path = request.getfixturevalue(request.param)
    with (folder / ".gitattributes").open("a") as file:
        file.write("*.chipbreak -diff\n")
    for z in ("-30.", "-40.", "-50."):
        write_bare(folder / "parts", z)
        git(folder, "add", ".")
        assert git(folder, "commit", "-qm", f"to {z}").returncode == 0
    return folder


VERSIONS = (
    (("diff",), "-50.", "-60."),
    (("diff", "HEAD~2", "HEAD~1"), "-30.", "-40."),
    (("log", "-p", "--ext-diff", "-n1", "HEAD~1"), "-30.", "-40."),
    (("diff", "HEAD~2"), "-30.", "-60."),
)
# Each pair of versions by one of the commands, which take turns; by the other one in the long form.
BY_EITHER = [
    pytest.param(by, *versions, marks=pytest.mark.long if (at + turn) % 2 else ())
    for at, versions in enumerate(VERSIONS)
    for turn, by in enumerate(["driver", "converter"])
]


@pytest.mark.parametrize(("bare", "command", "old", "new"), BY_EITHER, indirect=["bare"])
def test_each_version_is_read_with_its_file_beside(
    bare: Path, tmp_path: Path, command: tuple[str, ...], old: str, new: str
) -> None:
    write_bare(bare / "parts", "-60.")
    done = git(bare, *command)
    assert done.returncode == 0, done.stderr
    cuts = [write_bare(tmp_path / "elsewhere", z) for z in (old, new)]
    assert cuts[0] != cuts[1]
    assert changes(done.stdout) == [f"-{cuts[0]}", f"+{cuts[1]}"]


def test_an_edited_program_is_shown_as_it_stands(bare: Path) -> None:
    program = bare / "parts" / "bare.nc"
    program.write_bytes(program.read_bytes().replace(b"X20. Z2.", b"X21. Z2."))
    done = git(bare, "diff")
    assert done.returncode == 0, done.stderr
    assert "+G0 X21. Z2." in changes(done.stdout)
    if "--chipbreak" in done.stdout:
        says = "b/parts/bare.nc as it stands: no version of parts/bare.nc.chipbreak is about it"
        assert says in done.stdout.splitlines()


def test_a_file_beside_that_is_damaged_fails_nothing(bare: Path) -> None:
    (bare / "parts" / "bare.nc.chipbreak").write_bytes(b"{")
    program = bare / "parts" / "bare.nc"
    program.write_bytes(program.read_bytes() + b"\n")
    done = git(bare, "diff")
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "args", [["textconv", "gone.nc"], ["git-diff", "a", "gone.nc", "0", "0", "b", "0", "0"]]
)
def test_a_file_that_is_not_there(args: list[str], tmp_path: Path) -> None:
    done = warm_text(*args, cwd=tmp_path)
    assert done.returncode == 2
    assert "cannot read gone.nc" in done.stderr
