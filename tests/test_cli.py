"""The command line as it is really called.

A case is a folder in tests/cli: ``args`` (one line), ``exit``, and what else it needs: ``stdin``,
``stdout``, ``stderr`` (empty when missing), ``env``, ``files/`` that stand in the current folder, and
``after/``, all that stands there afterwards (unchanged when missing).
"""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import click.testing
import pytest
from click.shell_completion import get_completion_class
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.cli import cli
from chipbreak.settings import SettingsError, load, profile_names
from chipbreak.settings.sections import SECTIONS
from warm import cold, warm

FOLDER = Path(__file__).parent / "cli"
CASES = sorted(path.parent for path in FOLDER.glob("*/args"))
# One of each command in a Python of its own.
COLD = frozenset({shlex.split((case / "args").read_text())[0]: case for case in CASES}.values())
WORKED = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"


def content(folder: Path) -> dict[str, bytes]:
    """Names and bytes of the files in a folder, and none without one."""
    files = folder.iterdir() if folder.is_dir() else ()
    return {path.name: path.read_bytes() for path in files if path.is_file()}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_case(case: Path, tmp_path: Path) -> None:
    wanted = content(case)
    known = {"args", "exit", "stdin", "stdout", "stderr", "env"}
    assert set(wanted) <= known
    if (case / "files").is_dir():
        shutil.copytree(case / "files", tmp_path, dirs_exist_ok=True)
    env = dict(line.split("=", 1) for line in wanted.get("env", b"").decode().splitlines())
    run = cold if case in COLD else warm
    done = run(shlex.split(wanted["args"].decode()), wanted.get("stdin", b""), tmp_path, env)
    assert done.stderr.decode() == wanted.get("stderr", b"").decode()
    assert done.stdout == wanted.get("stdout", b"")
    assert done.returncode == int(wanted["exit"])
    after = "after" if (case / "after").is_dir() else "files"
    assert content(tmp_path) == content(case / after)


# A control of which something is known, so that there is nothing to warn of.
KNOWN = ["-p", "generic-lathe", "--set", "planner.model=trapezoid"]
KNOWN += ["--set", "axes.Z.max_acceleration_mm_s2=20000"]

# --- streams ----------------------------------------------------------------------------------------------


def test_no_byte_of_stdin_or_stdout_is_translated() -> None:
    data = bytes(range(256)) + b"\r\n\x1a\n\r"
    done = cold(["filter", "-p", "generic-lathe"], data)
    assert done.stdout == data


@pytest.mark.parametrize("unbuffered", ["", "1"], ids=["buffered", "unbuffered"])
def test_a_reader_that_leaves_is_no_fault(unbuffered: str) -> None:
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-300. F0.05 N1.5\nM30\n"
    command = [sys.executable, "-m", "chipbreak", "filter", *KNOWN]
    env = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    with subprocess.Popen(command, stdin=-1, stdout=-1, stderr=-1, env=env) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdin.write(program)
        process.stdin.close()
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr.read() == b""
        process.wait()
    assert process.returncode == 1


_ODD_NAMES = {"no UTF-8": "\udcff.nc", "Japanese": "\u8ef8.nc", "a space": "a b.nc"}
_NAMED = [
    pytest.param(
        name,
        command,
        id=f"{command}-{what}",
        marks=() if command == "filter" or what == "no UTF-8" else pytest.mark.long,
    )
    for command in ("filter", "explain", "check", "restore", "diff", "verify")
    for what, name in _ODD_NAMES.items()
]


@pytest.mark.parametrize(("name", "command"), _NAMED)
def test_any_file_name_and_a_terminal_that_knows_ascii_only(name: str, command: str, tmp_path: Path) -> None:
    file = tmp_path / name
    data = warm(["filter", *KNOWN], WORKED).stdout if command == "verify" else WORKED
    file.write_bytes(data)
    profile = [] if command in ("diff", "restore") else KNOWN
    second = [str(file)] if command == "diff" else []
    run = cold if command == "filter" and not name.isprintable() else warm
    done = run([command, *profile, str(file), *second], env={"PYTHONIOENCODING": "ascii", "LC_ALL": "C"})
    assert done.returncode == 0
    assert done.stderr == b""


def test_the_mode_of_the_file_and_a_link_to_it_stay(tmp_path: Path) -> None:
    file, link = tmp_path / "a.nc", tmp_path / "link.nc"
    file.write_bytes(WORKED)
    file.chmod(0o640)
    link.symlink_to(file)
    done = warm(["filter", "-p", "generic-lathe", "-i", str(link)])
    assert done.returncode == 0
    assert link.is_symlink()
    assert file.stat().st_mode & 0o777 == 0o640
    assert b"CHIPBREAK" in file.read_bytes()


@pytest.mark.parametrize("target", ["folder", "no/such/folder.nc"])
def test_a_target_that_cannot_be_written(target: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    done = warm(["filter", "-p", "generic-lathe", "-o", target], WORKED, tmp_path)
    assert done.returncode == 2
    assert done.stdout == b""
    assert b"cannot write" in done.stderr
    assert [path.name for path in tmp_path.rglob("*")] == ["folder"]


# --- JSON -------------------------------------------------------------------------------------------------


def no_constants(name: str) -> None:
    raise AssertionError(f"{name} is no JSON")


def test_explain_json_is_json_and_complete() -> None:
    done = warm(["explain", "-p", "generic-lathe", "--json"], WORKED)
    facts = json.loads(done.stdout, parse_constant=no_constants)
    (cut,) = facts["cuts"]
    assert facts["changed"] is True
    assert (cut["first_line"], cut["last_line"]) == (3, 3)
    assert (cut["speed_rpm"], cut["frequency_hz"]) == (2500.0, 62.5)
    assert cut["per_rev"] == pytest.approx(1.5)
    assert cut["given"]["N"] == {"value": 1.5, "origin": "N word, line 3"}
    assert any("62.5 Hz" in reason for reason in cut["reasons"])
    assert cut["verdict"]["breaks"] is True
    assert cut["verdict"]["margin"] == pytest.approx(1.2, abs=0.01)


def test_explain_tells_of_a_check_behind_the_last_line() -> None:
    program = b"T1 M6\nG0 X0. Y0. Z2.\nG1 Z-5. F100.\nG0 Z100.\n"
    done = warm(["explain", "-p", "speedio-blum"], program)
    assert b"at the end: CHIP CHECK T1" in done.stdout
    done = warm(["explain", "-p", "speedio-blum", "--json"], program)
    facts = json.loads(done.stdout)
    assert [check["line"] for check in facts["checks"]] == [5]
    assert (facts["operations"][0]["first_line"], facts["operations"][0]["last_line"]) == (1, 4)


def test_explain_names_the_lines_of_a_filtered_file() -> None:
    program = b"G1 X5.\n" + WORKED.replace(b"M30", b"T2 M6\nM30")
    non_modal = warm(["filter", "-p", "generic-lathe"], program).stdout
    assert non_modal.count(b"\n") > program.count(b"\n")
    facts = json.loads(warm(["explain", "-p", "generic-lathe", "--json"], non_modal).stdout)
    assert facts["operations"][-1]["last_line"] == non_modal.split(b"\n").index(b"T2 M6") + 1 > 100


def test_an_unbroken_cut_is_json_too() -> None:
    program = WORKED.replace(b"N1.5", b"N1.5 Q0.2")
    done = warm(["explain", "-p", "generic-lathe", "--json", "--allow-unbroken"], program)
    facts = json.loads(done.stdout, parse_constant=no_constants)
    assert facts["cuts"][0]["verdict"]["breaks"] is False


def test_diagnostics_in_json() -> None:
    done = warm(["filter", "-p", "generic-lathe", "--json"], WORKED.replace(b"N1.5", b"N2"))
    (found,) = json.loads(done.stderr, parse_constant=no_constants)
    assert found["code"] == "VIB005"
    assert found["severity"] == "error"
    assert found["span"] == {"line": 3, "column": 15, "end_column": 17}
    assert found["message"]
    assert found["help"]


# --- whatever comes ---------------------------------------------------------------------------------------


def test_explain_says_where_no_count_can_be_told() -> None:
    program = b"G97 S1000 M3\nG0 X20. Z0.\nG1 Z-0.8 F0.05 N0.5\nM30\n"
    said = invoke(["explain", "-p", "generic-lathe", "-"], program).output
    assert "reaches  no N that could be told: at full stroke the tool turns back once or never" in said
    longer = invoke(["explain", "-p", "generic-lathe", "-"], program.replace(b"0.8", b"0.9")).output
    assert "reaches  N 0.5, 8.3333 Hz" in longer


def invoke(args: list[str], stdin: bytes = b"") -> click.testing.Result:
    """Run in this process; what ``main`` would turn into "internal fault" is raised."""
    result = click.testing.CliRunner().invoke(cli, args, input=stdin)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


_WORDS = st.sampled_from(
    [
        "filter",
        "explain",
        "check",
        "diff",
        "restore",
        "profile",
        "show",
        "list",
        "verify",
        "-",
        "--",
        "-p",
        "-o",
        "--set",
        "--json",
        "-q",
        "--color",
        "never",
        "-i",
        "--backup",
        "--check",
        "generic-lathe",
        "nowhere.nc",
        "vibration.n=1.5",
        "vibration.n=x",
        "=",
        "control.dialect=1",
        "--allow-unbroken",
        "-h",
        "--version",
        "",
        ".",
    ]
)


@given(st.lists(_WORDS, max_size=6))
def test_any_arguments(args: list[str]) -> None:
    asked = {word for option, word in pairwise(args) if option == "-o"}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        assert invoke(args, WORKED).exit_code in (0, 1, 2, 3)
        assert {path.name for path in Path().iterdir()} <= asked


_KEYS = [f"{section}.{key}" for section, cls in SECTIONS.items() for key in cls.__dataclass_fields__]
_VALUES = st.one_of(
    st.integers(),
    st.floats().map(lambda x: str(x).replace("nan", "nan")),
    st.booleans().map(lambda b: str(b).lower()),
    st.sampled_from(
        ['""', '"auto"', "[]", "[4]", "[4, 5.5]", "{}", "{a = 1}", "'x'", "1e308", "5e-324", "-1", "0"]
    ),
    st.text(max_size=8),
)


@pytest.mark.few(60)
@given(st.lists(st.tuples(st.sampled_from(_KEYS), _VALUES), max_size=3))
@hypothesis_settings(max_examples=250)
def test_any_setting(sets: list[tuple[str, object]]) -> None:
    args = [word for key, value in sets for word in ("--set", f"{key}={value}")]
    assert invoke(["filter", "-p", "generic-lathe", *args], WORKED).exit_code in (0, 2, 3)


@given(st.binary(max_size=200))
def test_any_profile_file(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.toml")
        file.write_bytes(data)
        assert invoke(["filter", "-p", str(file)], WORKED).exit_code == 2, "no dialect, no profile"


_LINES = st.sampled_from(
    [
        "[control]",
        "[vibration]",
        "[axes.Z]",
        'dialect = "generic-lathe"',
        "n = 1.5",
        "n = -1",
        "e = [1]",
        "x = 1",
        'base = "generic-lathe"',
        'base = "x.toml"',
        'base = "\\u0000.toml"',
        "base = 1",
        "[calls.a]",
        "[operations]",
        'rough = "("',
        'rough = ["a"]',
        "ramp_s = 0.1",
        "multiples = []",
        "control = 1",
        "[[axes]]",
        "[tools]",
    ]
)


@given(st.lists(_LINES, max_size=7))
def test_any_likely_profile(lines: list[str]) -> None:
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("x.toml").write_text("\n".join(lines))
        assert invoke(["filter", "-p", "x.toml"], WORKED).exit_code in (0, 2, 3)


@given(st.binary(max_size=300), st.sampled_from(["filter", "explain", "check", "restore"]))
def test_any_program(data: bytes, command: str) -> None:
    if command == "check":
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "x.nc")
            file.write_bytes(data)
            assert invoke(["check", "-p", "generic-lathe", str(file)]).exit_code in (0, 1)
        return
    profile = [] if command == "restore" else ["-p", "generic-lathe"]
    assert invoke([command, *profile], data).exit_code in (0, 3)


_PIECES = st.sampled_from(
    [
        "G0",
        "G1",
        "G2",
        "G3",
        "G91",
        "G96",
        "G97",
        "G71",
        "G50",
        "M3",
        "M98",
        "X",
        "Z",
        "W",
        "I",
        "R",
        "F",
        "f",
        "S",
        "N",
        "E",
        "Q",
        "V",
        "D",
        "T",
        "1",
        "2.5",
        "-.5",
        "0",
        "99999999",
        "#1",
        "[1/0]",
        "(VIB N1.5)",
        "(VIB OFF)",
        "(VIB ALPHA.7 K2)",
        "(SPEED V1 D2)",
        "/",
        "%",
        "\n",
        "\n",
        "\n",
        "(CHIPBREAK BEGIN X)",
        "(CHIPBREAK END 0)",
    ]
)


@pytest.mark.few(50)
@given(st.lists(_PIECES, max_size=40))
@hypothesis_settings(max_examples=300)
def test_any_words_in_a_row(pieces: list[str]) -> None:
    data = ("G97 S3000 M3 F0.1\nG0 X20. Z2.\n" + " ".join(pieces)).encode()
    assert invoke(["filter", "-p", "generic-lathe"], data).exit_code in (0, 3)


# --- profiles ---------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform != "linux", reason="the user's folder is elsewhere there")
def test_the_nearest_profile_counts(tmp_path: Path) -> None:
    """Beside the program, then in the folders above, then in the user's own; the last line says which."""
    part = tmp_path / "shop" / "part 7" / "in.nc"
    home = tmp_path / "home" / "chipbreak"
    for folder in (part.parent, home):
        folder.mkdir(parents=True)
    part.write_bytes(WORKED)
    env = {"XDG_CONFIG_HOME": str(home.parent), "HOME": str(home.parent)}
    places = [(home, "found as "), (tmp_path / "shop", "found as "), (part.parent, "found beside it")]
    for number, (folder, said) in enumerate(places):
        (folder / "chipbreak.toml").write_text(
            f'base = "generic-lathe"\n[vibration]\nmargin = 1.{number + 1}\n'
        )
        done = warm(["filter", "in.nc", "-o", "out.nc"], cwd=part.parent, env=env)
        assert done.returncode == 0, done.stderr
        wanted = chipbreak.rewrite(WORKED, load("generic-lathe", [f"vibration.margin=1.{number + 1}"])).data
        assert (part.parent / "out.nc").read_bytes() == wanted
        end = done.stderr.decode().rstrip()
        assert said in end
        assert said.endswith("it") or str(folder / "chipbreak.toml") in end


@pytest.mark.parametrize("name", profile_names())
def test_a_shown_profile_is_a_profile_again(name: str, tmp_path: Path) -> None:
    shown = warm(["profile", "show", name])
    assert shown.returncode == 0
    file = tmp_path / "again.toml"
    file.write_bytes(shown.stdout)
    one, other = load(name), load(str(file))
    assert replace(other, name=one.name, origins=one.origins) == one


def test_the_list_names_every_profile() -> None:
    listed = warm(["profile", "list"]).stdout.decode().splitlines()
    assert [line.split()[0] for line in listed] == profile_names()


def test_a_profile_that_is_not_there_is_a_settings_error() -> None:
    with pytest.raises(SettingsError) as caught:
        load("generic-lath")
    assert "did you mean generic-lathe?" in caught.value.diagnostic.help


# --- the list of commands ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(cli.commands))
def test_a_command_is_listed_as_it_speaks_of_itself(name: str) -> None:
    """The list is printed without importing the commands; each must be what the list says."""
    context = click.Context(cli)
    listed, command = cli.commands[name], cli.get_command(context, name)
    assert command is not None
    assert (command.name, command.hidden) == (name, listed.hidden)
    for width in range(20, 160):
        assert listed.get_short_help_str(width) == command.get_short_help_str(width)


@pytest.mark.parametrize("words", ["", "prof", "mach"])
def test_a_shell_offers_the_commands(words: str) -> None:
    shell = get_completion_class("fish")
    assert shell is not None
    context = click.Context(cli)
    offered = shell(cli, {}, "chipbreak", "_CHIPBREAK_COMPLETE").get_completions([], words)
    commands = [(name, cli.get_command(context, name)) for name in cli.list_commands(context)]
    wanted = [
        (name, command.get_short_help_str())
        for name, command in commands
        if command and name.startswith(words)
    ]
    assert wanted
    assert [(one.value, one.help) for one in offered] == wanted


@pytest.mark.parametrize("env", [{}, {"_CHIPBREAK_COMPLETE": "fish_complete", "COMP_CWORD": "fil"}])
def test_help_and_completion_load_no_command(env: dict[str, str]) -> None:
    script = (
        "import atexit, sys; sys.argv[1:] = ['--help'][:not sys.argv[1]]\n"
        "atexit.register(lambda: print(*(m for m in sys.modules if 'chipbreak' in m or m == 'numpy')))\n"
        "from chipbreak.cli import cli; cli(prog_name='chipbreak')"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, env.get("COMP_CWORD", "")],
        capture_output=True,
        text=True,
        env=dict(os.environ) | {"COMP_WORDS": "chipbreak fil", **env},
        check=True,
    )
    assert "filter" in done.stdout
    loaded = done.stdout.splitlines()[-1].split()
    assert sorted(loaded) == ["chipbreak", "chipbreak.cli", "chipbreak.text", "chipbreak.text.encoding"]


def test_a_misspelt_command_is_told_the_right_one() -> None:
    refused = warm(["filtr"])
    assert refused.returncode == 2
    assert "filter" in refused.stderr.decode()
