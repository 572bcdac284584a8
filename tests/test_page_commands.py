"""Every command that a page shows is run, page by page and in its order, where a reader would run it.

The folder has what the pages speak of: a program, a profile, a folder of programs, traces, a machine's INI
file.  What cannot be run here stands in ``LEFT_OUT``, with the reason.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from warm import FIGURES, clean_environment, warm_command, warm_text

CHECKOUT = Path(__file__).parents[1]
sys.path.insert(0, str(CHECKOUT / "benchmarks"))

import cookbook  # noqa: E402

PAGES = sorted(
    [*(CHECKOUT / "docs").glob("*.md"), *CHECKOUT.glob("*.md"), CHECKOUT / "samples" / "README.md"]
)
_COMMAND = re.compile(r"^ {4}(?:\$ )?(chipbreak (?:[^\n]*\\\n)*[^\n]*)$", re.MULTILINE)
LEFT_OUT = {
    "--dask tcp://": "a cluster of several machines; tests/batch runs one of real processes",
    "language-server": "talks with an editor; tests/editors does",
    "hooks watch": "goes on until Ctrl-C; tests/hooks runs it",
    "machine-test read": "needs times or a trace of a machine; tests/machine_test has some",
    "chipbreak advise -p samples/cookbook-lathe.toml --surface": "the table: run by its own test",
}
# Programs that differ, and an edge of the samples that is chipped, end with 1.
FOUND = ("chipbreak diff ", "chipbreak inspect samples/tools/ball-6-before.csv")
PROGRAM = b"G97 S1200 M3\nG0 X40. Z2.\nG1 Z-25. F0.15 N1.5\nG0 X45.\nM30\n"
TRACE = "tooth,height_mm,radius_mm\n" + "".join(f"1,{0.1 * i:.1f},5.0\n" for i in range(20))
INI = "[DISPLAY]\nLATHE = 1\n[TRAJ]\nCOORDINATES = X Z\nLINEAR_UNITS = mm\n[AXIS_X]\nMAX_ACCELERATION = 900\n"
LASER = (
    "[macros]\nbeam_x_mm = 400.0\nbeam_y_mm = 120.0\nbeam_z_mm = -350.0\nsafe_z_mm = 0.0\n"
    "master_length_mm = 120.0\nmaster_diameter_mm = 10.0\n"
)


def commands_of(page: Path) -> list[str]:
    return _COMMAND.findall(page.read_text("utf-8"))


WITH_COMMANDS = [page for page in PAGES if commands_of(page)]


def why_left_out(command: str) -> str:
    return next((why for part, why in LEFT_OUT.items() if part in command), "")


@pytest.fixture
def shop(tmp_path: Path) -> Path:
    files = {
        "part.nc": PROGRAM,
        "O0001": PROGRAM,
        "programs/O0002": PROGRAM,
        "more/O1234": PROGRAM,
        "my-lathe.toml": b'base = "fanuc-lathe"\n',
        "machine.toml": f'base = "fanuc-mill"\n{LASER}'.encode(),
        "before.csv": TRACE.encode(),
        "after.csv": TRACE.encode(),
        "home/linuxcnc/configs/lathe/lathe.ini": INI.encode(),
    }
    for name, data in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(data)
    (tmp_path / "samples").symlink_to(CHECKOUT / "samples")
    return tmp_path


def run(command: str, shop: Path) -> subprocess.CompletedProcess[str]:
    """In a shell of its own, with ``chipbreak`` on its path and a home in the folder."""
    folders = [warm_command(*FIGURES).parent, Path(sys.executable).parent, os.environ["PATH"]]
    path = os.pathsep.join(map(str, folders))
    env = clean_environment(PATH=path, HOME=str(shop / "home"), XDG_CONFIG_HOME=str(shop / "home"))
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", command], cwd=shop, env=env, capture_output=True, text=True,
        stdin=subprocess.DEVNULL, timeout=300, check=False,
    )  # fmt: skip


@pytest.mark.skipif(sys.platform == "win32", reason="commands of a Unix shell")
@pytest.mark.parametrize("page", WITH_COMMANDS, ids=lambda page: page.stem)
def test_every_command_of_a_page_runs(page: Path, shop: Path) -> None:
    _set_up(page, shop)
    for command in commands_of(page):
        if why_left_out(command):
            continue
        if "--dask" in command:
            pytest.importorskip("distributed", reason="pip install 'chipbreak[dask]'")
        done = run(command, shop)
        wanted = int(any(part in command for part in FOUND))
        assert done.returncode == wanted, f"{command}\n{done.stderr}"


def _set_up(page: Path, shop: Path) -> None:
    """What stands there before the first command of a page, and what must not."""
    if page.stem == "hooks":
        (shop / "my-lathe.toml").unlink()
    if page.stem == "at-the-machine":
        (shop / "chipbreak.toml").write_text('base = "generic-lathe"\n[output]\nstamp = true\n')
        (shop / "part.nc").write_bytes(PROGRAM.replace(b"Z-25.", b"Z-300."))
        assert run("chipbreak filter -i part.nc", shop).returncode == 0


def test_what_is_left_out_is_there() -> None:
    """An exception that no page needs any more goes away."""
    all_commands = [command for page in WITH_COMMANDS for command in commands_of(page)]
    assert [part for part in LEFT_OUT if not any(part in command for command in all_commands)] == []
    assert sum(not why_left_out(command) for command in all_commands) > 20


def test_the_table_of_the_cookbook_is_what_its_commands_say(monkeypatch: pytest.MonkeyPatch) -> None:
    def said(command: str, *more: str) -> str:
        done = warm_text(*shlex.split(command)[1:], *more, cwd=CHECKOUT)
        assert done.returncode == 0, done.stderr
        return done.stdout

    monkeypatch.setattr(cookbook, "chipbreak", said)
    monkeypatch.setattr(sys, "argv", ["cookbook.py", "--check"])
    assert cookbook.main() == 0, "make cookbook writes it anew"


@pytest.mark.skipif(sys.platform == "win32", reason="commands of a Unix shell")
@pytest.mark.parametrize(
    "figure", sorted((CHECKOUT / "docs" / "figures").glob("*.svg")), ids=lambda p: p.stem
)
def test_a_figure_of_the_cookbook_is_what_its_command_draws(figure: Path, shop: Path) -> None:
    pytest.importorskip("matplotlib", reason="pip install 'chipbreak[plot]'")
    source = (CHECKOUT / "benchmarks" / "cookbook.py").read_text("utf-8")
    assert f"docs/figures/{figure.name}" in source
    page = (CHECKOUT / "docs" / "cookbook.md").read_text("utf-8")
    before = page[: page.index(f"(figures/{figure.name})")]
    command = _COMMAND.findall(before)[-1]
    target = shlex.split(command)[-1]
    done = run(command, shop)
    assert done.returncode == 0, done.stderr
    assert texts(shop / target) == texts(figure)


def texts(figure: Path) -> list[str]:
    """What a figure says in words and numbers."""
    return ["".join(node.itertext()) for node in ET.parse(figure).iter() if node.tag.endswith("}text")]
