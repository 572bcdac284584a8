"""Every hook is tried the way its caller really calls it."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import IO

import pytest

import chipbreak
from chipbreak.cli import cli
from chipbreak.hook_commands import _NAMES
from chipbreak.hooks.write import HOOKS
from warm import interruptible, warm_text

PROGRAM = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
WRONG = PROGRAM.replace(b"N1.5", b"N2")


def run(*args: str, cwd: Path, **env: str) -> subprocess.CompletedProcess[str]:
    clean = {k: v for k, v in os.environ.items() if not k.startswith("CHIPBREAK")} | env
    return subprocess.run(args, capture_output=True, text=True, cwd=cwd, env=clean, check=False)


def written(name: str, folder: Path, profile: str = "generic-lathe") -> Path:
    out = folder / "hooks"
    done = warm_text("hooks", "write", name, "-p", profile, "-o", str(out), cwd=folder)
    assert done.returncode == 0, done.stderr
    return out


def test_the_names_are_those_of_the_hooks() -> None:
    assert tuple(hook.name for hook in HOOKS) == _NAMES


@pytest.mark.parametrize("name", _NAMES)
def test_no_mark_is_left_in_a_file(name: str, tmp_path: Path) -> None:
    for file in written(name, tmp_path).iterdir():
        text = file.read_text("utf-8")
        assert "@CHIPBREAK" not in text
        assert "@PROFILE" not in text
        assert "@FOLDER" not in text
        assert os.access(file, os.X_OK) == text.startswith("#!")


def test_a_file_of_somebody_is_kept(tmp_path: Path) -> None:
    out = written("linuxcnc", tmp_path)
    (out / "machine.ini.part").write_text("mine")
    done = warm_text("hooks", "write", "linuxcnc", "-p", "fanuc-mill", "-o", str(out), cwd=tmp_path)
    assert done.returncode == 2
    assert (out / "machine.ini.part").read_text() == "mine"


def test_a_profile_that_cannot_be_read_is_said_at_once(tmp_path: Path) -> None:
    done = warm_text("hooks", "write", "cam", "-p", "no-such", "-o", "out", cwd=tmp_path)
    assert done.returncode == 2
    assert not (tmp_path / "out").exists()


# --- LinuxCNC ---------------------------------------------------------------------------------------------


def test_linuxcnc_opens_what_comes_out(tmp_path: Path) -> None:
    """The program is the only argument, standard output is opened, and an error ends with another code."""
    script = written("linuxcnc", tmp_path) / "chipbreak-filter"
    (tmp_path / "a part.nc").write_bytes(PROGRAM)
    done = run(str(script), str(tmp_path / "a part.nc"), cwd=tmp_path, AXIS_PROGRESS_BAR="1")
    assert done.returncode == 0
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(PROGRAM, settings)
    # The operator is told that nobody knows this control; the rest is the program.
    assert "VIB079 UNPROVEN" in done.stdout
    assert chipbreak.restore(done.stdout.encode()) == PROGRAM
    assert done.stdout.encode().endswith(result.data[-200:])
    progress = [int(n) for n in re.findall(r"^FILTER_PROGRESS=(\d+)$", done.stderr, re.MULTILINE)]
    assert progress[0] == 0
    assert progress[-1] > 90
    assert len(progress) > 3
    assert progress == sorted(set(progress))
    (tmp_path / "a part.nc").write_bytes(WRONG)
    done = run(str(script), str(tmp_path / "a part.nc"), cwd=tmp_path)
    assert done.returncode == 3
    assert done.stdout == ""
    assert "VIB005" in done.stderr


def test_the_lines_for_the_ini_file_name_the_script(tmp_path: Path) -> None:
    folder = written("linuxcnc", tmp_path)
    lines = (folder / "machine.ini.part").read_text().splitlines()
    assert "[FILTER]" in lines
    assert f"ngc = {folder}/chipbreak-filter" in lines


# --- CAM systems ------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_a_cam_system_filters_in_place(tmp_path: Path) -> None:
    script = written("cam", tmp_path) / "chipbreak-in-place.sh"
    program = tmp_path / "my part.nc"
    program.write_bytes(PROGRAM)
    done = run(str(script), "--some-option", str(program), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert program.read_bytes() == chipbreak.rewrite(PROGRAM, chipbreak.load("generic-lathe")).data
    assert (tmp_path / "my part.nc.unfiltered").read_bytes() == PROGRAM
    assert "1 cut vibrates" in (tmp_path / "chipbreak.log").read_text()


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_a_rejected_program_is_taken_from_its_place(tmp_path: Path) -> None:
    script = written("cam", tmp_path) / "chipbreak-in-place.sh"
    program = tmp_path / "part.nc"
    program.write_bytes(WRONG)
    done = run(str(script), str(program), cwd=tmp_path)
    assert done.returncode == 3
    assert not program.exists()
    assert (tmp_path / "part.nc.unfiltered").read_bytes() == WRONG
    assert "VIB005" in (tmp_path / "part.nc.rejected").read_text()
    assert "VIB005" in (tmp_path / "chipbreak.log").read_text()


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_a_program_is_posted_again_over_one_without_comments(tmp_path: Path) -> None:
    (tmp_path / "bare.toml").write_text('base = "generic-lathe"\n[output]\nbrackets = "none"\n')
    script = written("cam", tmp_path) / "chipbreak-in-place.sh"
    program = tmp_path / "part.nc"
    settings = chipbreak.load(tmp_path / "bare.toml")
    for posted in (PROGRAM, PROGRAM.replace(b"G1 Z-30.", b"G1 Z-29.")):
        program.write_bytes(posted)
        done = run("env", f"CHIPBREAK_PROFILE={tmp_path}/bare.toml", str(script), str(program), cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert program.read_bytes() == chipbreak.rewrite(posted, settings).data
        beside = (tmp_path / "part.nc.chipbreak").read_bytes()
        assert chipbreak.restore(program.read_bytes(), beside=beside) == posted


def test_the_windows_script_has_the_line_ends_of_windows(tmp_path: Path) -> None:
    data = (written("cam", tmp_path) / "chipbreak-in-place.bat").read_bytes()
    assert data.startswith(b"@echo off\r\n")
    assert data.count(b"\n") == data.count(b"\r\n")


# --- git --------------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_git_is_set_up(tmp_path: Path) -> None:
    script = written("git", tmp_path) / "set-up.sh"
    repository = tmp_path / "programs"
    repository.mkdir()
    run("git", "init", "-q", cwd=repository)
    assert run(str(script), cwd=repository).returncode == 0
    attributes = (repository / ".gitattributes").read_bytes()
    assert run(str(script), cwd=repository).returncode == 0  # a second time changes nothing
    assert (repository / ".gitattributes").read_bytes() == attributes
    (repository / "O0001").write_bytes(PROGRAM)
    run("git", "add", "-A", cwd=repository)
    (repository / "O0001").write_bytes(PROGRAM.replace(b"G1 Z-30.", b"G01 Z-30.0"))
    done = run("git", "diff", cwd=repository)
    assert done.returncode == 0, done.stderr
    assert "the same blocks" in done.stdout


# --- editors ----------------------------------------------------------------------------------------------


def test_tasks_of_an_editor_read_our_messages(tmp_path: Path) -> None:
    tasks = json.loads((written("editors", tmp_path) / "vscode-tasks.json").read_text())["tasks"]
    (tmp_path / "part.nc").write_bytes(WRONG)
    check = tasks[0]
    args = [one.replace("${file}", str(tmp_path / "part.nc")) for one in check["args"]]
    done = run(check["command"], *args, cwd=tmp_path)
    pattern = check["problemMatcher"]["pattern"]["regexp"]
    match = re.search(pattern, done.stderr, re.MULTILINE)
    assert match is not None
    assert match.group(2, 4) == ("3", "error")


# --- FreeCAD ----------------------------------------------------------------------------------------------

FREECAD = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
JOB = """
import json, sys, traceback
import FreeCAD, PathScripts.PathUtil as PathUtil, PathScripts.PathToolController as PathToolController
import PathScripts.PathPreferences as Preferences
from PathScripts.PathPostProcessor import PostProcessor
from PathScripts.PathPost import CommandPathPost
try:
    FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Macro").SetString("MacroPath", FOLDER)
    document = FreeCAD.open(FreeCAD.getHomePath() + "Mod/Path/PathTests/boxtest.fcstd")
    job = document.getObject("Job")
    operations = [o for o in job.Operations.Group if hasattr(o, "ToolController")]
    second = PathToolController.Create("second", tool=operations[0].ToolController.Tool, toolNumber=2)
    job.Proxy.addToolController(second)
    import PathScripts.PathProfile as PathProfile
    other = PathProfile.Create("Other", None, job)
    other.Base = operations[0].Base
    other.ToolController = second
    for controller in (operations[0].ToolController, second):
        controller.SpindleSpeed = 3000.0
    document.recompute()
    postlist = CommandPathPost().buildPostList(job)
    objects = [o for section in postlist for o in (section[1] if isinstance(section, tuple) else section)]
    assert "chipbreak" in Preferences.allAvailablePostProcessors()
    post = PostProcessor.load("chipbreak")
    text = post.export(objects, TARGET, "--base=linuxcnc --no-show-editor ARGUMENTS")
    told = {"text": text}
except BaseException as error:
    told = {"error": "%s: %s" % (type(error).__name__, error), "where": traceback.format_exc()}
json.dump(told, open(RESULT, "w"))
"""


def posted(folder: Path, profile: str, arguments: str = "") -> dict[str, str]:
    """What FreeCAD gives back when a job with two tools is posted through the hook."""
    assert FREECAD is not None
    hooks = written("freecad", folder, profile)
    result = folder / "result.json"
    places = {"FOLDER": hooks, "TARGET": folder / "job.ngc", "RESULT": result}
    script = folder / "job.py"
    text = JOB.replace("ARGUMENTS", arguments)
    script.write_text("".join(f"{name} = {str(path)!r}\n" for name, path in places.items()) + text)
    run(FREECAD, str(script), cwd=folder, HOME=str(folder), QT_QPA_PLATFORM="offscreen")
    told: dict[str, str] = json.loads(result.read_text())
    return told


@pytest.mark.skipif(FREECAD is None, reason="needs FreeCAD")
def test_freecad_posts_a_job_with_two_tools(tmp_path: Path) -> None:
    told = posted(tmp_path, "linuxcnc-mill")
    assert "error" not in told, told
    assert told["text"] == (tmp_path / "job.ngc").read_text()
    changes = [line.strip() for line in told["text"].splitlines() if line.startswith("M6")]
    assert len(changes) == 2
    assert changes[-1] == "M6 T2"


PREAMBLE = "--preamble='G17 G54 G40 G49 G80 G90 G53 G0 X0 Y0 Z0'"


@pytest.mark.skipif(FREECAD is None, reason="needs FreeCAD")
@pytest.mark.parametrize(
    "arguments",
    [
        pytest.param("", id="as it is", marks=pytest.mark.long),
        pytest.param(PREAMBLE, id="with a place for CALIBRATE"),
    ],
)
def test_the_tools_of_a_freecad_job_are_checked(arguments: str, tmp_path: Path) -> None:
    """The preamble is the one of the page; without it there is no place before the first tool."""
    assert PREAMBLE in (Path(__file__).parents[2] / "docs" / "hooks.md").read_text("utf-8")
    beam = "[macros]\nbeam_x_mm = 400.0\nbeam_y_mm = 120.0\nbeam_z_mm = -350.0\nsafe_z_mm = 0.0\n"
    master = "master_length_mm = 120.0\nmaster_diameter_mm = 10.0\n"
    (tmp_path / "mill.toml").write_text(f'base = "linuxcnc-mill"\n{beam}{master}')
    told = posted(tmp_path, str(tmp_path / "mill.toml"), arguments)
    assert "error" not in told, told
    titles = re.findall(r"CHIPBREAK BEGIN (.*)\)", told["text"])
    checks = [f"{what} {tool}" for tool in ("T1", "T2") for what in ("TOOL CHECK", "CHIP CHECK")]
    wanted = ["CALIBRATE", *checks] if arguments else checks
    assert [title.split(",")[0].split(" W")[0] for title in titles] == wanted


# --- a folder that is watched -----------------------------------------------------------------------------


def until(stream: IO[str], begin: str) -> list[str]:
    """The lines of a stream up to the first one that begins so, or to its end."""
    lines = []
    for line in iter(stream.readline, ""):
        lines.append(line)
        if line.startswith(begin):
            break
    return lines


def test_a_program_that_is_written_is_filtered(tmp_path: Path) -> None:
    pytest.importorskip("watchfiles", reason="pip install 'chipbreak[watch]'")
    for name in ("in", "out"):
        (tmp_path / name).mkdir()
    command = [sys.executable, "-m", "chipbreak", "hooks", "watch", "-p", "generic-lathe", "in", "-o", "out"]
    with interruptible():
        process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    impatience = threading.Timer(60.0, process.kill)  # nobody waits for a line that never comes
    impatience.start()
    with process as watcher:
        assert watcher.stderr is not None
        assert watcher.stderr.readline().startswith("watching in")
        time.sleep(0.5)
        (tmp_path / "in/notes.pdf").write_bytes(b"%PDF")
        (tmp_path / "in/part.nc").write_bytes(PROGRAM)
        assert any("1 cut vibrates" in line for line in until(watcher.stderr, "in/part.nc: "))
        (tmp_path / "in/part.nc").write_bytes(WRONG)
        lines = until(watcher.stderr, "in/part.nc: ")
        watcher.send_signal(signal.SIGINT)
        watcher.wait(timeout=30)
    impatience.cancel()
    assert "REJECTED" in lines[-1]
    filtered = chipbreak.rewrite(PROGRAM, chipbreak.load("generic-lathe")).data
    there = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert set(there) == {"part.nc", "part.nc.rejected"}
    assert there["part.nc"] == filtered


# --- manual pages -----------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the page writer with a newer click
def test_every_command_has_a_manual_page(tmp_path: Path) -> None:
    write_man_pages = pytest.importorskip("click_man.core").write_man_pages
    write_man_pages("chipbreak", cli, version="1.2.3", target_dir=str(tmp_path))
    pages = {path.name: path.read_text("utf-8") for path in tmp_path.iterdir()}
    for name in cli.commands:
        assert f"chipbreak-{name}.1" in pages
    assert all(page.startswith(".TH") for page in pages.values())
