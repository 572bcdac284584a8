"""Completion, in the shell in which people use it."""

from __future__ import annotations

import os
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

BIN = Path(sys.executable).parent
BASH = shutil.which("bash")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_script_for_each_shell(shell: str) -> None:
    if shell == "bash" and BASH is None:
        pytest.skip("click asks bash for its version")
    command = [sys.executable, "-m", "chipbreak", "completion", shell]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "_CHIPBREAK_COMPLETE" in done.stdout


@pytest.mark.skipif(BASH is None or sys.platform == "win32", reason="needs bash and a terminal")
@pytest.mark.parametrize(
    ("typed", "becomes"),
    [
        ("chipbreak expl\t", "chipbreak explain "),
        ("chipbreak filter -p linuxcnc-m\t", "chipbreak filter -p linuxcnc-mill "),
        ("chipbreak filter -p my-la\t", "chipbreak filter -p my-lathe.toml "),
        ("chipbreak filter lonely-p\t", "chipbreak filter lonely-part.nc "),
        ("chipbreak filter --reject\t", "chipbreak filter --reject-file "),
    ],
)
def test_a_key_completes(typed: str, becomes: str, tmp_path: Path) -> None:
    import pty

    (tmp_path / "lonely-part.nc").touch()
    (tmp_path / "my-lathe.toml").touch()
    (tmp_path / "rc").write_text(
        'PS1="READY> "\nbind "set bell-style none"\neval "$(chipbreak completion bash)"\n'
    )
    env = {"PATH": f"{BIN}:{os.environ['PATH']}", "TERM": "dumb", "HOME": str(tmp_path), "COLUMNS": "200"}
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(tmp_path)
        os.execve(str(BASH), ["bash", "--noprofile", "--rcfile", "rc", "-i"], env)
    try:
        assert wait_for(terminal, "READY> ")
        os.write(terminal, typed.encode())
        assert becomes in wait_for(terminal, becomes)
    finally:
        os.close(terminal)
        os.waitpid(child, 0)


def wait_for(terminal: int, text: str, patience_s: float = 60.0) -> str:
    """What the terminal shows until a text is there."""
    shown = ""
    end = time.monotonic() + patience_s
    while text not in shown and time.monotonic() < end:
        if select.select([terminal], [], [], 0.5)[0]:
            shown += os.read(terminal, 4096).decode("utf-8", "replace")
    return shown
