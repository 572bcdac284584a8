"""AXIS, LinuxCNC's own screen, opens a program through the filter, on a display that nobody sees.

From the INI file of the machine come the profile and, with the lines that ``hooks write`` gives, the filter.
What AXIS opened is asked of LinuxCNC; that a program was refused is seen by AXIS's window.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import chipbreak

from . import config, machine

CHECKOUT = Path(__file__).parents[2]
PROGRAM = b"G21 G18 G8 G90 G95\nT1 M6 G43\nG97 S800 M3\nG0 X22 Z2\n(VIB N1.5)\nG0 X18\nG1 Z-20 F0.1\nM5\nM2\n"
REFUSED = PROGRAM.replace(b"N1.5", b"N2")
NEEDED = ("Xvfb", "xdotool", "axis", "axis-remote")
MISSING = [name for name in NEEDED if shutil.which(name) is None]

# A /tmp of its own, in which a checkout can lie.  AXIS answers before it can open; the refused program is
# opened in the background, because its window waits.
SESSION = """
ip link set lo up
mkdir seen && mount -o bind,ro "$CHECKOUT" seen
mount -t tmpfs tmpfs /tmp
mkdir -p "$CHECKOUT" && mount --bind seen "$CHECKOUT"
chmod 1777 /tmp
Xvfb :7 -screen 0 1280x900x24 >xvfb.txt 2>&1 &
linuxcnc machine.ini >said.txt 2>&1 &
try() { for _ in $(seq 200); do "$@" && return; sleep 0.5; done; return 1; }
ask() { /usr/bin/python3 -c 'import linuxcnc; s = linuxcnc.stat(); s.poll(); print(s.file)'; }
window() { xdotool search --name "$1" >/dev/null 2>&1; }
copy() { cp "$(ask)" opened.ngc 2>/dev/null && grep -q X22 opened.ngc; }
opened() { timeout 10 axis-remote part.ngc; sleep 1; copy; }
try axis-remote --ping
try opened || exit 1
try window part.ngc || exit 2
axis-remote refused.ngc >/dev/null 2>&1 &
try window "Filter failed" || exit 3
cp "$(ask)" still.ngc
if command -v import >/dev/null; then import -window root screen.png; fi
"""


@pytest.fixture(scope="module")
def session() -> Iterator[Path]:
    """The folder of a session in which a program was opened, and then one that is refused."""
    if MISSING or not machine.available():
        pytest.skip(f"needs LinuxCNC's simulated machine and {', '.join(MISSING or NEEDED)}")
    with tempfile.TemporaryDirectory(prefix="axis-", dir="/var/tmp") as name:
        folder = Path(name)
        folder.chmod(0o777)
        _machine(folder)
        (folder / "part.ngc").write_bytes(PROGRAM)
        (folder / "refused.ngc").write_bytes(REFUSED)
        environment = {key: value for key, value in os.environ.items() if not key.startswith("CHIPBREAK")}
        environment |= {"HOME": name, "DISPLAY": ":7", "LC_ALL": "C", "CHECKOUT": str(CHECKOUT)}
        environment |= {"RTAPI_UID": "65534", "RTAPI_FIFO_PATH": f"{name}/rtapi_fifo"}
        with (folder / "session.txt").open("wb") as out:
            done = subprocess.run(
                [*machine.NAMESPACES, "bash", "-c", SESSION],
                cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out,
                timeout=300, check=False,
            )  # fmt: skip
        said = "".join((folder / one).read_text("latin-1") for one in ("session.txt", "said.txt"))
        assert done.returncode == 0, f"step {done.returncode}: {said[-2000:]}"
        yield folder


def _machine(folder: Path) -> None:
    """A lathe with AXIS as its screen, its profile from its INI file, and the filter in its INI file."""
    axes = config.limits("XZ", 2000.0, 200.0)
    ini = config.ini(folder, axes, 0.001, lathe=True)
    ini = ini.replace(f"DISPLAY = {folder}/driver.py\n", "DISPLAY = axis\nINTRO_TIME = 0\nCYCLE_TIME = 0.1\n")
    (folder / "machine.ini").write_text(ini)
    (folder / "machine.hal").write_text(config.hal("XZ"))
    (folder / "tool.tbl").write_text(config.tool_table())
    (folder / "parameters.var").write_text("")
    (folder / "subs").mkdir()
    _chipbreak(folder, "profile", "init", "machine.toml", "--from-ini", "machine.ini")
    _chipbreak(folder, "hooks", "write", "linuxcnc", "-p", "machine.toml", "-o", "hooks")
    (folder / "machine.ini").write_text(ini + (folder / "hooks" / "machine.ini.part").read_text())


def _chipbreak(folder: Path, *args: str) -> None:
    command = [sys.executable, "-m", "chipbreak", *args]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_axis_opens_what_the_filter_wrote(session: Path) -> None:
    settings = chipbreak.load(session / "machine.toml")
    wanted = chipbreak.rewrite(PROGRAM, settings, "part.ngc").data
    assert wanted != PROGRAM
    opened = (session / "opened.ngc").read_bytes()
    assert chipbreak.restore(opened) == PROGRAM
    assert opened.endswith(wanted[-200:])


def test_a_refused_program_does_not_take_the_place_of_the_one_that_is_open(session: Path) -> None:
    assert (session / "still.ngc").read_bytes() == (session / "opened.ngc").read_bytes()
