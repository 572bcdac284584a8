"""A package that brings a control, a pass and a tool reader, installed where nothing of it was before.

The steps in the README are what this package does: every file that they name is in it.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
PACKAGE = CHECKOUT / "tests" / "plugin_package"
PROGRAM = PACKAGE / "programs" / "part.nc"
TOOLS = PACKAGE / "programs" / "tools.magazine"
README = (CHECKOUT / "README.md").read_text("utf-8")
GROUPS = {"chipbreak.dialects", "chipbreak.passes", "chipbreak.profiles", "chipbreak.tool_readers"}


class Environment:
    """A virtual environment in which the package is installed; chipbreak itself is the one under test."""

    def __init__(self, folder: Path) -> None:
        venv.create(folder / "env", with_pip=False, symlinks=True)
        self.python = folder / "env" / "bin" / "python"
        (site,) = (folder / "env" / "lib").glob("python*/site-packages")
        ours = sysconfig.get_path("purelib")
        (site / "ours.pth").write_text(f"import site; site.addsitedir({ours!r})\n")
        self.folder = folder

    def install(self, package: Path) -> None:
        """As a user does, without a network: what builds it is in our own environment."""
        options = [
            "--quiet",
            "--no-index",
            "--no-deps",
            "--no-build-isolation",
            "--disable-pip-version-check",
        ]
        command = [
            sys.executable,
            "-m",
            "pip",
            "--python",
            str(self.python),
            "install",
            *options,
            str(package),
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr

    def chipbreak(self, *arguments: str | Path, code: int = 0) -> subprocess.CompletedProcess[bytes]:
        """Run the command line somewhere else than in the checkout."""
        command = [self.python, "-m", "chipbreak", *map(str, arguments)]
        clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "CHIPBREAK"))}
        done = subprocess.run(command, capture_output=True, check=False, cwd=self.folder, env=clean)
        assert done.returncode == code, done.stdout + done.stderr
        return done


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    folder = tmp_path_factory.mktemp("workshop")
    made = Environment(folder)
    refused = made.chipbreak("filter", "-p", "workshop-lathe", PROGRAM, code=2)
    assert b"workshop-lathe" in refused.stderr  # nobody knows it yet
    made.install(Path(shutil.copytree(PACKAGE, folder / "package")))
    return made


@pytest.fixture(scope="module")
def filtered(environment: Environment) -> bytes:
    out = environment.folder / "out.nc"
    done = environment.chipbreak("filter", "-p", "workshop-lathe", "--tools", TOOLS, PROGRAM, "-o", out)
    assert done.stderr.count(b": warning ") == done.stderr.count(b": warning VIB079: ") == 1
    return out.read_bytes()


def test_the_program_comes_out_as_its_control_reads_it(filtered: bytes) -> None:
    wanted = (PACKAGE / "programs" / "part.out.nc").read_bytes()
    head, gap, tail = wanted.partition(b"...\n")
    assert gap
    assert filtered.startswith(head)
    assert filtered.endswith(tail)
    assert b"(" not in filtered  # a comment of this control begins with a semicolon


def test_its_chips_break_and_the_self_check_says_so_again(environment: Environment, filtered: bytes) -> None:
    (environment.folder / "again.nc").write_bytes(filtered)
    said = environment.chipbreak("verify", "-p", "workshop-lathe", "--tools", TOOLS, "again.nc").stdout
    assert said.count(b"chips would break") == 1
    explained = environment.chipbreak("explain", "-p", "workshop-lathe", "--tools", TOOLS, PROGRAM).stdout
    assert b"chips would break" in explained


def test_the_way_back_gives_every_byte(environment: Environment, filtered: bytes) -> None:
    (environment.folder / "back.nc").write_bytes(filtered)
    assert environment.chipbreak("restore", "back.nc").stdout == PROGRAM.read_bytes()
    again = environment.chipbreak("filter", "-p", "workshop-lathe", "--tools", TOOLS, "back.nc").stdout
    assert again == filtered


def test_each_part_does_its_own(filtered: bytes) -> None:
    assert b"\nG165 P=2 A=1 L=52.3\n" in filtered  # its calls, with a length that its reader read
    assert filtered.count(b"; CHIPBREAK BEGIN STOP BEFORE FINISHING\nM1\n") == 2  # its pass
    assert filtered.count(b"\nG165 P=3 ") == 3
    assert b"\nG0 Z=5.\nG0 X=30.\n" in filtered  # given back in words as this control writes them


def test_what_its_control_does_not_have_is_not_read(environment: Environment) -> None:
    odd = environment.folder / "odd.nc"
    odd.write_bytes(PROGRAM.read_bytes().replace(b"; SHAFT 12", b"(SHAFT 12)"))
    assert b"SYN001" in environment.chipbreak("check", "-p", "workshop-lathe", "--tools", TOOLS, odd).stderr


def test_a_line_of_its_tool_file_that_is_none_is_said(environment: Environment) -> None:
    wrong = environment.folder / "wrong.magazine"
    wrong.write_bytes(b"1 LENGTH 52.3\n2 LENGTH\n")
    refused = environment.chipbreak("tools", "-p", "workshop-lathe", "--tools", wrong, PROGRAM, code=2)
    assert b"wrong.magazine:2:1: error TOL004" in refused.stderr


def test_its_pass_refuses_what_does_not_stop(environment: Environment) -> None:
    option = "plugins.stop-before-finishing.block=M8"
    refused = environment.chipbreak(
        "filter", "-p", "workshop-lathe", "--tools", TOOLS, "--set", option, PROGRAM, code=3
    )
    assert b"SHP001" in refused.stderr
    assert refused.stdout == b""


def steps(title: str) -> list[str]:
    """The numbered steps under a heading of the README."""
    section = README.partition(f"### {title}\n")[2].partition("\n#")[0]
    return re.findall(r"^\d+\. (.*?)(?=^\d+\. |\Z)", section, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("title", ["To add a control", "To add a pass", "To add a tool reader"])
def test_every_file_that_a_step_names_is_in_the_package(title: str) -> None:
    found = steps(title)
    assert len(found) >= 3
    metadata = tomllib.loads((PACKAGE / "pyproject.toml").read_text("utf-8"))
    offered = metadata["project"]["entry-points"]
    for step in found:
        files = re.findall(r"`([\w/.-]+\.(?:lark|py|toml|nc|magazine))`", step)
        groups = re.findall(r"`(chipbreak\.\w+)`", step)
        assert files or groups, f"this step names nothing that could be looked for: {step}"
        for file in files:
            assert list(PACKAGE.rglob(file)), f"{file} is not in the package"
        assert set(groups) <= set(offered)


def test_the_package_uses_every_entry_point_there_is() -> None:
    metadata = tomllib.loads((PACKAGE / "pyproject.toml").read_text("utf-8"))
    assert set(metadata["project"]["entry-points"]) == GROUPS
    sources = "".join(p.read_text("utf-8") for p in (CHECKOUT / "src").rglob("*.py"))
    assert set(re.findall(r'^GROUP(?:: Final)? = "(chipbreak\.\w+)"', sources, re.MULTILINE)) == GROUPS
