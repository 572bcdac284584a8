"""``chipbreak`` in a process of its own, without the time that a new Python takes to load it.

A server has all modules loaded and forks for each run: the child takes over the arguments, the folder, the
environment and the open files of who asks, and ends as every Python ends.  What a Python does before the
first line of ``main`` is not tried so; tests of streams that are closed, of limits and of signals start a new
one (``cold``), and so does one case of each command.
"""

from __future__ import annotations

import atexit
import importlib
import json
import os
import runpy
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from typing import Any

FIGURES = ("matplotlib.figure", *(f"matplotlib.backends.backend_{kind}" for kind in ("agg", "svg", "pdf")))
_REQUEST_BYTES = 1 << 20


def clean_environment(**more: str) -> dict[str, str]:
    """The environment without what a user may have said to chipbreak."""
    return {key: value for key, value in os.environ.items() if not key.startswith("CHIPBREAK")} | more


@contextmanager
def interruptible() -> Iterator[None]:
    """Processes that start here take Ctrl-C, even where a shell runs the tests with that ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def cold(
    args: list[str], stdin: bytes = b"", cwd: Path | None = None, env: dict[str, str] | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run chipbreak in a new Python."""
    command = [sys.executable, "-m", "chipbreak", *args]
    environment = clean_environment(**(env or {}))
    return subprocess.run(command, input=stdin, capture_output=True, cwd=cwd, env=environment, check=False)


def warm(
    args: list[str],
    stdin: bytes = b"",
    cwd: Path | None = None,
    env: dict[str, str] | None = None,
    loads: tuple[str, ...] = (),
) -> subprocess.CompletedProcess[bytes]:
    """Run chipbreak in a fork of a Python that has it loaded, and ``loads`` too."""
    if not hasattr(os, "fork"):
        return cold(args, stdin, cwd, env)
    request = {
        "args": args,
        "folder": str(cwd or Path.cwd()),
        "environment": clean_environment(**(env or {})),
        "loads": loads,
    }
    with ExitStack() as stack:
        files = [stack.enter_context(tempfile.TemporaryFile()) for _ in range(3)]
        files[0].write(stdin)
        files[0].seek(0)
        code = asked(_server(), request, [file.fileno() for file in files])
        _, stdout, stderr = (_content(file) for file in files)
    return subprocess.CompletedProcess(args, code, stdout, stderr)


def warm_text(*args: str, cwd: Path, loads: tuple[str, ...] = ()) -> subprocess.CompletedProcess[str]:
    """``warm`` with text for bytes."""
    done = warm(list(args), cwd=cwd, loads=loads)
    return subprocess.CompletedProcess(args, done.returncode, done.stdout.decode(), done.stderr.decode())


def _content(file: Any) -> bytes:
    file.seek(0)
    data: bytes = file.read()
    return data


@cache
def warm_command(*loads: str) -> Path:
    """An executable file named ``chipbreak``, alone in its folder, which asks the server for a run of it."""
    file = Path(_folder(), "-".join(("bin", *loads)), "chipbreak")
    file.parent.mkdir()
    client = shlex.join([sys.executable, "-I", "-S", __file__, _server(), ",".join(loads)])
    file.write_text(f'#!/bin/sh\nexec {client} "$@"\n')
    file.chmod(0o755)
    return file


def asked(server: str, request: dict[str, Any], files: list[int]) -> int:
    """The exit code of a run, negative for a signal."""
    with socket.socket(socket.AF_UNIX) as line:
        line.connect(server)
        socket.send_fds(line, [json.dumps(request).encode()], files)
        line.shutdown(socket.SHUT_WR)
        return int(line.recv(20))


@cache
def _folder() -> str:
    """A folder with a short name, for sockets have to."""
    folder = tempfile.TemporaryDirectory(prefix="warm-")
    atexit.register(folder.cleanup)
    return folder.name


@cache
def _server() -> str:
    """The address of the server of this process; it ends with it."""
    address = str(Path(_folder(), "socket"))
    environment = clean_environment(OPENBLAS_NUM_THREADS="1")  # one thread only may be forked
    reads, writes = os.pipe()
    server = subprocess.Popen([sys.executable, __file__, address], stdin=reads, env=environment)
    os.close(reads)
    atexit.register(server.wait)
    atexit.register(os.close, writes)  # which is done first
    while not Path(address).exists():
        assert server.poll() is None, "it has said why"
        time.sleep(0.01)
    return address


# --- the server -------------------------------------------------------------------------------------------


def load_all() -> None:
    """Every module of chipbreak but the one that runs it."""
    import pkgutil

    import chipbreak

    for module in pkgutil.walk_packages(chipbreak.__path__, "chipbreak."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)


def serve(address: str) -> None:
    """Fork for each request; return in the child that is to run it."""
    import select

    load_all()
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(f"{address}-")
        listening.listen(64)
        Path(f"{address}-").rename(address)
        while True:
            ready, _, _ = select.select([listening, 0], [], [])
            if 0 in ready:  # who has started this is gone
                os._exit(0)
            line, _ = listening.accept()
            if _is_run(line):
                return
            line.close()


def _is_run(line: socket.socket) -> bool:
    """True in the child that is to run what a line asks for; another waits for it and says how it ended."""
    data, files, _, _ = socket.recv_fds(line, _REQUEST_BYTES, 3)
    while more := line.recv(_REQUEST_BYTES):
        data += more
    request = json.loads(data)
    for module in request["loads"]:
        importlib.import_module(module)
    if os.fork():
        for file in files:
            os.close(file)
        while _reap():
            pass
        return False
    child = os.fork()
    if child:
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        line.sendall(str(code).encode())
        os._exit(0)
    line.close()
    become(request, files)
    return True


def _reap() -> bool:
    """Let one child go that has ended; False where there is none."""
    try:
        return os.waitpid(-1, os.WNOHANG)[0] != 0
    except ChildProcessError:
        return False


def become(request: dict[str, Any], files: list[int]) -> None:
    """Take over the folder, the environment, the arguments and the open files of who asks."""
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    encoding, _, errors = os.environ.get("PYTHONIOENCODING", "utf-8").partition(":")
    sys.stdin = open(0, encoding=encoding, errors=errors or "strict")  # noqa: SIM115
    sys.stdout = open(1, "w", encoding=encoding, errors=errors or "strict")  # noqa: SIM115
    sys.stderr = open(2, "w", encoding=encoding, errors="backslashreplace")  # noqa: SIM115
    sys.argv = ["chipbreak", *request["args"]]
    sys.path[:] = [folder for folder in sys.path if folder != str(Path(__file__).parent)]


def run_to_its_end() -> int:
    """The exit code of ``python -m chipbreak``, when all that waits for the end of a Python is done.

    Python itself would take everything apart that is loaded, which takes longer than most runs.
    """
    code: object = 0
    try:
        runpy.run_module("chipbreak", run_name="__main__", alter_sys=True)
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException:
        traceback.print_exc()
        code = 1
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except OSError:
        code = 120  # as Python does
    if isinstance(code, int):
        return code
    print(code, file=sys.stderr)
    return 1


def ask_for_a_run(address: str, loads: str, args: list[str]) -> int:
    """What ``warm_command`` does: its own folder, environment and open files are those of the run."""
    request = {
        "args": args,
        "folder": os.getcwd(),  # noqa: PTH109
        "environment": dict(os.environ),
        "loads": loads.split(",") if loads else [],
    }
    return asked(address, request, [0, 1, 2])


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit(ask_for_a_run(sys.argv[1], sys.argv[2], sys.argv[3:]))
    serve(sys.argv[1])
    os._exit(run_to_its_end())
