"""Throws what nobody would write at the filter: ``python tests/fuzz_inputs.py [SECONDS [SEED [KIND]]]``.

Programs, profiles, ``--set``, templates of calls, rules of operations, files of tools, traces, machine files
and whole commands are taken from the tests and samples and spoilt.  Nothing may end in a traceback, in a
fault of ours (exit 4), in a search without end (2 s and 2 s for each MB read or written), in output after an
error, or in a control character on the screen.  What does is printed with all it takes to see it again; the
last line counts the cases.

``python tests/fuzz_inputs.py --coverage [ARGUMENTS OF LIBFUZZER]`` lets atheris choose the bytes by what they
reach, where it is installed (``pip install atheris``); what reached something new stays in ``build/corpus``.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from unittest.mock import patch

import click.testing
import matplotlib.backends.backend_svg  # noqa: F401 (before the search, so that no case pays for it)

import chipbreak
from chipbreak.batch.work import Finished, Task, filtered
from chipbreak.checks.calls import check_sets
from chipbreak.cli import cli
from chipbreak.inspection.edges import judge_edge
from chipbreak.machine_files.fanuc_parameters import machine_of_parameters
from chipbreak.machine_files.linuxcnc_ini import machine_of_ini
from chipbreak.operations.kinds import KindRules
from chipbreak.settings import Settings, SettingsError, profile_names
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, RefusalError, SelfCheckError
from chipbreak.tools.data import ToolFileError
from chipbreak.tools.files import read_tools
from chipbreak.tools.lists import read_traces
from round_numbers import drawn_profile, drawn_program, drawn_sets

TESTS = Path(__file__).parent
SAMPLES = TESTS.parent / "samples"
CORPUS = TESTS.parent / "build" / "corpus"
# Seconds of the processor for any input, and for each MB of it.
_LEAST_S, _PER_MB_S = 2.0, 2.0
_SLOW = re.compile(r" s for \d+ bytes$|^no end after")
_HANG_S = 30.0
# Tried again, alone: what ends by then is held against its size.
_LONG_S = 150.0
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_EXPECTED = (ProgramRejectedError, SettingsError, ToolFileError, RefusalError)
_LARGEST = 1 << 17


class FoundError(Exception):
    """Something that must not happen."""


class HangError(BaseException):
    """It takes longer than anybody waits."""


# --- what is spoilt, and how ------------------------------------------------------------------------------


@cache
def programs() -> list[bytes]:
    """Programs of the tests, of the samples, and some drawn ones."""
    folders = [TESTS / "cases", TESTS / "bad", TESTS / "cli", SAMPLES]
    files = sorted(file for folder in folders for file in folder.rglob("*") if file.suffix in (".nc", ".ngc"))
    return [file.read_bytes() for file in files if file.stat().st_size < 20_000]


@cache
def profiles() -> list[str]:
    shipped = [f'base = "{name}"\n' for name in profile_names()]
    files = [*(TESTS.parent / "src/chipbreak/profiles").glob("*.toml"), *SAMPLES.glob("*.toml")]
    return [*shipped, *(file.read_text("utf-8") for file in sorted(files))]


@cache
def tool_files() -> list[tuple[str, bytes]]:
    files = sorted(file for file in (SAMPLES / "tools").rglob("*") if file.is_file())
    return [(file.name, file.read_bytes()) for file in files]


@cache
def keys() -> list[str]:
    """``section.key`` of every value a profile may have."""
    from chipbreak.settings.sections import SECTIONS

    return [f"{section}.{key}" for section, cls in SECTIONS.items() for key in cls.__dataclass_fields__]


_NUMBERS = (
    "0",
    "-0.",
    "1",
    "1.",
    ".5",
    "-1.",
    "999999999",
    "1e-300",
    "1e300",
    "0.0000001",
    "-99999.",
    "2",
    "3.14",
)
_VALUES = (
    *(
        *_NUMBERS,
        "true",
        "false",
        '""',
        '"auto"',
        '"X"',
        "[]",
        "[1]",
        '["A"]',
        "{}",
        "nan",
        "inf",
        "-inf",
        "'",
    ),
    *(
        '"linear"',
        '"required"',
        '"increment"',
        '"calculator"',
        '"minute"',
        '"rev"',
        '"sine"',
        '"dwell"',
        '"loop"',
    ),
    *(
        '"ideal"',
        '"trapezoid"',
        '"linuxcnc"',
        '"junction"',
        '"after-interpolation"',
        '"look-ahead"',
        '"leave"',
    ),
    *('"error"', '"G61"', '"G64 P0.01"', '"\\u001b[2J"', "1979-05-27", '"arc"', '"stroke"', '"builtin"'),
)
_PIECES = (
    *(
        "G0",
        "G1",
        "G2",
        "G3",
        "G4 P1",
        "G20",
        "G21",
        "G90",
        "G91",
        "G92",
        "G50",
        "G94",
        "G95",
        "G96 S100",
        "G97",
    ),
    *(
        "G98",
        "G99",
        "G28 U0",
        "G10 L2 P1 X1.",
        "G71 P1 Q2",
        "G76",
        "G81",
        "G68",
        "G41",
        "G54",
        "M3",
        "M5",
        "M6",
    ),
    *(
        "M30",
        "M98 P1",
        "M99",
        "T1",
        "T0101",
        "S3000",
        "F0.1",
        "N1.5",
        "E2",
        "(VIB N1.5)",
        "(VIB OFF)",
        "(VIB AUTO)",
    ),
    *(
        "(CHIPBREAK BEGIN X)",
        "(CHIPBREAK END 0)",
        "(",
        ")",
        "%",
        "O1",
        "#1=1",
        "[1/0]",
        "GOTO 1",
        "WHILE[1]DO1",
    ),
    *(
        "END1",
        "o1 sub",
        "o1 endsub",
        "o1 call",
        "IF[#1EQ1]THEN",
        "/",
        ";",
        "$1",
        "!2L1",
        "\x1b[2J",
        "\x00",
        "\xff",
    ),
    *(
        "\r\n",
        "\n",
        " ",
        "X",
        "Z-1.",
        "R1.",
        "I1. K1.",
        "U-.5",
        "W1.",
        "\x8e\xb2",
        "ü".encode().decode("latin-1"),
    ),
)


def spoilt(draw: random.Random, data: bytes, pieces: tuple[str, ...], most: int = 6) -> bytes:
    """The same with some bytes, numbers, lines and pieces changed."""
    text = bytearray(data)
    for _ in range(draw.randint(0, most)):
        at = draw.randint(0, len(text))
        choice = draw.random()
        if choice < 0.3:
            text[at:at] = draw.choice(pieces).encode("latin-1", "replace")
        elif choice < 0.45:
            del text[at : at + draw.choice([1, 1, 2, 5, 30])]
        elif choice < 0.55 and at < len(text):
            text[at] = draw.randrange(256)
        elif choice < 0.8:
            _change_number(draw, text)
        elif choice < 0.97:
            _move_line(draw, text)
        else:
            text[at:at] = text[at : at + 40] * draw.choice([2, 50, 1000])
    return bytes(text[:_LARGEST])


def _change_number(draw: random.Random, text: bytearray) -> None:
    found = list(re.finditer(rb"[-+]?\d+\.?\d*", text))
    if found:
        one = draw.choice(found)
        text[one.start() : one.end()] = draw.choice(_NUMBERS).encode()


def _move_line(draw: random.Random, text: bytearray) -> None:
    lines = bytes(text).split(b"\n")
    line = draw.choice(lines)
    lines.insert(draw.randrange(len(lines) + 1), line)
    if draw.random() < 0.5:
        lines.remove(line)
    text[:] = b"\n".join(lines)


@cache
def loaded(profile: str, sets: tuple[str, ...]) -> Settings | None:
    try:
        settings = chipbreak.load(profile, sets)
        check_sets(settings)
        KindRules.from_profile(settings.operations)
    except (SettingsError, RefusalError):
        return None
    return settings


# --- the cases --------------------------------------------------------------------------------------------

Case = Callable[[random.Random], int]
"""Tries one thing; how many bytes it had to read.  What it drew is in ``seen``."""

seen: list[object] = []


def drawn_settings(draw: random.Random) -> Settings | None:
    sets = tuple(
        f"{draw.choice(keys())}={draw.choice(_VALUES)}" for _ in range(draw.choice([0, 0, 0, 1, 1, 2, 3]))
    )
    profile = draw.choice(profile_names())
    seen.extend([profile, *sets])
    return loaded(profile, sets) if not sets else loaded.__wrapped__(profile, sets)


def a_program(draw: random.Random) -> int:
    settings = drawn_settings(draw)
    data = spoilt(draw, draw.choice(programs()), _PIECES)
    seen.append(data)
    if settings is not None:
        try:
            result = chipbreak.rewrite(data, settings, allow_unbroken=draw.random() < 0.5)
        except (ProgramRejectedError, ToolFileError) as error:
            shown(error.diagnostics)
        except SettingsError as error:
            shown((error.diagnostic,))
        except RefusalError as error:
            raise FoundError(f"a refusal without a place: {error}") from error
        else:
            shown(result.diagnostics)
            return len(data) + len(result.data)
    return len(data)


def a_round_program(draw: random.Random) -> int:
    """One that a shop could run, on a machine that could be: what is written goes back, and stays."""
    profile = drawn_profile(draw)
    sets = drawn_sets(draw, profile)
    data, allow_unbroken = drawn_program(draw, profile), draw.random() < 0.5
    seen.extend([profile, sets, allow_unbroken, data])
    try:
        settings = chipbreak.load(profile, sets)
        check_sets(settings)
    except (SettingsError, RefusalError):
        return len(data)
    try:
        result = chipbreak.rewrite(data, settings, allow_unbroken=allow_unbroken)
    except ProgramRejectedError as error:
        shown(error.diagnostics)
        return len(data)
    shown(result.diagnostics)
    if settings.output.brackets == "none":  # nothing says what it was
        return len(data) + len(result.data)
    if chipbreak.restore(result.data) != data:
        raise FoundError("it does not go back")
    if chipbreak.rewrite(result.data, settings, allow_unbroken=allow_unbroken).data != result.data:
        raise FoundError("it becomes another one when it is filtered again")
    chipbreak.verify(result.data, settings)
    json.dumps(chipbreak.explain(result, settings).as_dict())
    # It was filtered twice and verified, and each may take as long as one alone.
    return len(data) + 3 * len(result.data) + int(2 * _LEAST_S / _PER_MB_S * 1e6)


def a_profile(draw: random.Random) -> int:
    text = spoilt(draw, draw.choice(profiles()).encode(), (*keys(), *_VALUES, "\n[", "]\n", " = ", "\n"))
    seen.append(text)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "a.toml")
        file.write_bytes(text)
        expected(lambda: check_sets(chipbreak.load(file)))
    return len(text)


def a_set(draw: random.Random) -> int:
    sets = [f"{draw.choice(keys())}={draw.choice(_VALUES)}" for _ in range(draw.randint(1, 4))]
    sets[0] = spoilt(draw, sets[0].encode(), (*keys(), *_VALUES, ".", "="), 2).decode("latin-1")
    seen.extend(sets)
    expected(lambda: chipbreak.load(draw.choice(profile_names()), sets))
    return 100


def a_template(draw: random.Random) -> int:
    fields = (
        "{tool}",
        "{limit}",
        "{height}",
        "{speed_rpm}",
        "{operation}",
        "{tool!r}",
        "{tool:>99}",
        "{}",
        "{x}",
        "{",
    )
    blocks = [
        " ".join(draw.choices([*fields, *_PIECES], k=draw.randint(1, 4))) for _ in range(draw.randint(1, 2))
    ]
    check = draw.choice(["calibrate", "tool_check", "trace", "chip_check", "x"])
    seen.append((check, blocks))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "a.toml")
        shown_blocks = ", ".join(f'"{_toml(block)}"' for block in blocks)
        base = draw.choice(["fanuc-mill", "linuxcnc-mill", "speedio-blum", "haas-mill"])
        head = f'base = "{base}"\nchecks.calls = "own"\nchecks.enabled = true\n'
        text = f"{head}[calls.own]\n{check} = [{shown_blocks}]\n"
        file.write_text(text, "utf-8")
        settings: list[Settings] = []
        expected(lambda: check_sets(chipbreak.load(file)) or settings.append(chipbreak.load(file)))
        data = draw.choice(programs())
        seen.append(data)
        if settings:
            expected(lambda: chipbreak.rewrite(data, settings[0], allow_unbroken=True))
    return len(data)


def _toml(text: str) -> str:
    return "".join(c if c.isprintable() and c not in '"\\' else f"\\u{ord(c):04x}" for c in text)


def a_rule(draw: random.Random) -> int:
    pieces = (
        "A",
        "(A+)+",
        "[A-Z]*",
        "(",
        ")",
        "|",
        "{2,9}",
        "?",
        "\\b",
        "ROUGH",
        ".*",
        "[",
        "]",
        "\\",
        "^",
        "$",
        "(?i)",
    )
    text = "".join(draw.choices(pieces, k=draw.randint(1, 8)))
    seen.append(text)

    def work() -> None:
        ((_, pattern),) = KindRules.from_profile({"rough": [text]}).patterns
        pattern.search("A" * 300 + "ROUGH B")

    expected(work)
    return len(text)


def a_tool_file(draw: random.Random) -> int:
    name, data = draw.choice(tool_files())
    data = spoilt(
        draw, data, (*_VALUES, ",", ";", "\t", '"', "[[tool]]", "number", "T1", "D", "{", "}", "[", "]")
    )
    seen.extend([name, data])
    expected(lambda: read_tools(name, data, draw.choice([(1.0, "mm"), (25.4, "inch")])))
    return len(data)


def a_trace(draw: random.Random) -> int:
    heights = [
        draw.choice(_NUMBERS) if draw.random() < 0.1 else str(i * 0.2) for i in range(draw.randint(0, 30))
    ]
    rows = [f"{draw.choice('1112x')},{height},{draw.choice(['5', '4.9', *_NUMBERS])}" for height in heights]
    data = spoilt(draw, "\n".join(["tooth,height_mm,radius_mm", *rows]).encode(), (",", "\n", *_NUMBERS), 3)
    seen.append(data)

    def work() -> None:
        edges = read_traces("a.csv", data)
        with contextlib.suppress(ValueError):  # what a trace cannot be judged by; the command says it
            for edge in edges.values():
                judge_edge(edge, edge, 0.02)

    expected(work)
    return len(data)


def a_machine_file(draw: random.Random) -> int:
    ini = (
        "[TRAJ]\nLINEAR_UNITS = mm\nCOORDINATES = X Z\n"
        "[AXIS_X]\nMAX_ACCELERATION = 500\n[DISPLAY]\nLATHE = 1\n"
    )
    parameters = "N01622Q1A1P40A2P40\nN01825 A1 P3000 A2 P3000\nN01420A1P8000A2P8000\nN01020A1P88A2P90\n"
    is_ini = draw.random() < 0.5
    pieces = ("\n", "=", "[", "#INCLUDE a", "inch", "P", "A1", "N", " " * 999, "M", "Q1", *_NUMBERS)
    data = spoilt(draw, (ini if is_ini else parameters).encode(), pieces)
    seen.append(data)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "a")
        file.write_bytes(data)
        expected(lambda: (machine_of_ini if is_ini else machine_of_parameters)(file))
    return len(data)


_COMMANDS = (
    "filter in.nc -p {p}",
    "filter in.nc -p {p} --json -o out.nc",
    "filter -i in.nc -p {p} --backup .bak --operator-messages",
    "check in.nc -p {p}",
    "explain in.nc -p {p}",
    "explain in.nc -p {p} --json",
    "verify in.nc -p {p}",
    "verify in.nc",
    "restore in.nc",
    "restore in.nc -o out.nc",
    "diff in.nc other.nc",
    "diff in.nc other.nc -p {p} --json",
    "diff in.nc other.nc --html",
    "diff in.nc other.nc -y --ignore-comments",
    "textconv in.nc",
    "tools in.nc -p {p}",
    "tools in.nc -p {p} --tools t.{suffix}",
    "filter in.nc -p {p} --tools t.{suffix}",
    "inspect t.csv u.csv --next rough",
    "profile init new.toml --from-ini t.{suffix}",
    "profile init new.toml --from-parameters t.{suffix}",
    "profile show {p}",
    "profile show t.toml",
    "filter in.nc -p t.toml",
    "advise -p {p} --diameter {n} --feed {n} --depth {n}",
    "advise -p {p} {n} {n}",
    "macros -p {p} -o macros",
    "hooks write cam -p {p} -o hooks",
    "resume in.nc -n {line} -p {p}",
    "resume in.nc -n {line} -p {p} -o out.nc",
    "machine-test write -p {p} -o mt",
    "machine-test read t.toml -p {p} -o new.toml",
    "batch programs in.nc -p {p} -o out --jobs 1",
    "batch programs -p t.toml -o out --jobs 1 --json",
)
_IN_FOLDER = ("O0001", "deep/O0002", "deep/part.nc")
_RARE = ("report in.nc -p {p} -o out.html", "plot in.nc -p {p} -o out.svg")


def a_command(draw: random.Random) -> int:
    commands = _RARE if draw.random() < 0.01 else _COMMANDS
    suffix = draw.choice(["csv", "toml", "json", "tbl", "tools", "fctl", "fctb", "ini"])
    line = draw.choice(commands).format(
        p=draw.choice(profile_names()), suffix=suffix, n=draw.choice(_NUMBERS), line=draw.randint(1, 40)
    )
    arguments = line.split()
    if draw.random() < 0.3:
        arguments += ["--set", f"{draw.choice(keys())}={draw.choice(_VALUES)}"]
    files = _spoilt_files(draw, suffix)
    seen.extend([arguments, files])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in files.items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_bytes(content)
        with contextlib.chdir(folder), patch("chipbreak.batch.processes.by_processes", in_this_process):
            done = click.testing.CliRunner().invoke(cli, arguments)
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        wrong = next((said for rule in _RULES_OF_A_RUN if (said := rule(done, arguments[0], folder))), "")
        made = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        if wrong:
            raise FoundError(wrong)
    # Each program of a batch may take as long as one alone.
    others = len(_IN_FOLDER) if arguments[0] == "batch" else 0
    return made + len(done.stdout_bytes) + int(others * _LEAST_S / _PER_MB_S * 1e6)


def in_this_process(tasks: Iterable[Task], _jobs: int) -> Iterator[Finished]:
    """The tasks of a batch where this search sees how long they take."""
    return map(filtered, tasks)


def _spoilt_files(draw: random.Random, suffix: str) -> dict[str, bytes]:
    """What the commands name, by file."""
    one = drawn_program(draw, drawn_profile(draw)) if draw.random() < 0.3 else draw.choice(programs())
    _, tools = draw.choice(tool_files())
    return {
        **{f"programs/{name}": spoilt(draw, draw.choice(programs()), _PIECES) for name in _IN_FOLDER},
        "in.nc": spoilt(draw, one, _PIECES, draw.choice([0, 6])),
        "other.nc": spoilt(draw, one, _PIECES),
        f"t.{suffix}": spoilt(draw, tools, _PIECES),
        "t.toml": spoilt(draw, draw.choice(profiles()).encode(), _VALUES, 2),
    }


def _no_fault(done: click.testing.Result, _command: str, _folder: Path) -> str:
    is_fault = done.exit_code == 4 and "SLF003" not in done.stderr
    return f"exit 4: {done.stderr[-500:]}" if is_fault else ""


def _nothing_after_an_error(done: click.testing.Result, command: str, folder: Path) -> str:
    if done.exit_code not in (2, 3):
        return ""
    if done.stdout and command in ("filter", "restore"):
        return f"output after exit {done.exit_code}"
    return f"a file after exit {done.exit_code}" if (folder / "out.nc").exists() else ""


def _clean_screen(done: click.testing.Result, command: str, _folder: Path) -> str:
    prints_programs = ("filter", "restore", "textconv", "resume")
    screen = done.stderr if command in prints_programs else done.stderr + done.stdout
    found = _CONTROL.search(screen)
    return f"control character {found[0]!r} on the screen: {screen[:300]!r}" if found else ""


def _all_or_a_reason(done: click.testing.Result, command: str, folder: Path) -> str:
    """Of a batch each program is there, or a file that says why not."""
    if command != "batch" or done.exit_code not in (0, 3):
        return ""
    for name in _IN_FOLDER:
        there = [(folder / "out" / f"{name}{suffix}").exists() for suffix in ("", ".rejected")]
        if there not in ([True, False], [False, done.exit_code == 3]):
            return f"exit {done.exit_code}, but of {name} there is program, reason: {there}"
    return ""


def _nothing_left(_done: click.testing.Result, _command: str, folder: Path) -> str:
    return "".join(f"{left.name} is left" for left in folder.rglob(".chipbreak-*.part"))


_RULES_OF_A_RUN: tuple[Callable[[click.testing.Result, str, Path], str], ...] = (
    _no_fault,
    _nothing_after_an_error,
    _clean_screen,
    _nothing_left,
    _all_or_a_reason,
)


def shown(diagnostics: tuple[Diagnostic, ...]) -> None:
    """What is said must be fit for a screen."""
    for one in diagnostics:
        text = one.render()
        if found := _CONTROL.search(text):
            raise FoundError(f"control character {found[0]!r} in {text!r}")


def expected(work: Callable[[], object]) -> None:
    """Errors that are said are no fault."""
    try:
        work()
    except (ProgramRejectedError, ToolFileError) as error:
        shown(error.diagnostics)
    except SettingsError as error:
        shown((error.diagnostic,))
    except RefusalError:
        pass


CASES: dict[str, tuple[Case, int]] = {
    "program": (a_program, 10),
    "round program": (a_round_program, 1),
    "profile": (a_profile, 3),
    "set": (a_set, 6),
    "template": (a_template, 2),
    "rule": (a_rule, 3),
    "tool file": (a_tool_file, 8),
    "trace": (a_trace, 3),
    "machine file": (a_machine_file, 3),
    "command": (a_command, 2),
}


# --- the search -------------------------------------------------------------------------------------------


@contextlib.contextmanager
def bounded(seconds: float = _HANG_S) -> Iterator[None]:
    """End what does not end."""

    def stop(_number: int, _frame: object) -> None:
        raise HangError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def tried(name: str, seed: int, most_s: float = _HANG_S) -> str:
    """What is wrong with a case, which may take so long; empty where nothing is."""
    seen.clear()
    begin_s = time.process_time()
    try:
        with bounded(most_s):
            size = CASES[name][0](random.Random(seed))
    except HangError:
        return f"no end after {most_s:g} s"
    except (FoundError, SelfCheckError) as error:
        return f"{type(error).__name__}: {error}"
    except Exception:
        return traceback.format_exc()
    took_s = time.process_time() - begin_s
    return f"{took_s:.1f} s for {size} bytes" if took_s > _LEAST_S + _PER_MB_S * size / 1e6 else ""


def again(name: str, seed: int) -> str:
    """What is wrong with a case in a process of its own, behind an easy one, at the better of two times.

    Others at work on the machine, and what a first case imports, make any one slow now and then.
    """
    command = [sys.executable, __file__, "--again", name, str(seed)]
    runs = [subprocess.run(command, capture_output=True, text=True, check=False) for _ in range(2)]
    return min((run.stdout if run.returncode == 0 else run.stderr or "it died" for run in runs), key=len)


def tried_again(name: str, seed: int) -> str:
    """A case behind an easy one."""
    tried("program", 1)
    return tried(name, seed, _LONG_S)


def search(seconds: float, first_seed: int | None, kind: str = "") -> int:
    """Try cases for so long, of one kind where it is named; 1 where something was found."""
    end = time.monotonic() + seconds
    seed = random.SystemRandom().randrange(2**32) if first_seed is None else first_seed
    draw = random.Random(seed)
    counts: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    while time.monotonic() < end:
        name = kind or draw.choices(list(CASES), [weight for _, weight in CASES.values()])[0]
        one = draw.randrange(2**63)
        wrong = tried(name, one)
        wrong = again(name, one) if _SLOW.search(wrong) else wrong
        counts[name] += 1
        if wrong:
            last = f"{name}: {wrong.strip().splitlines()[-1][:150]}"
            kinds[last] += 1
            if kinds[last] == 1:
                print(f"--- {name}, seed {one}\n{wrong}\n{seen!r}"[:6000], flush=True)
        if sum(counts.values()) % 20_000 == 0:
            print(f"{sum(counts.values())} cases", flush=True)
    said = ", ".join(f"{count} {name}" for name, count in counts.items())
    found = f"{sum(kinds.values())} found of {len(kinds)} kinds"
    print(f"{sum(counts.values())} cases from seed {seed}: {said}; {found}")
    return min(len(kinds), 1)


def by_coverage(arguments: list[str]) -> None:
    """Let atheris choose the bytes of programs by what they reach; it starts from those of the tests."""
    import atheris  # type: ignore[import-not-found]

    names = profile_names()

    def one(data: bytes) -> None:
        settings = loaded(names[data[0] % len(names)], ()) if data else None
        if settings is not None:
            with bounded(), contextlib.suppress(ProgramRejectedError):
                chipbreak.rewrite(data[1:], settings, allow_unbroken=True)

    CORPUS.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(programs()):
        (CORPUS / str(number)).write_bytes(bytes([number % len(names)]) + data)
    atheris.instrument_all()
    atheris.Setup([sys.argv[0], *arguments, str(CORPUS)], one)
    atheris.Fuzz()


if __name__ == "__main__":
    os.environ.pop("CHIPBREAK_PROFILE", None)
    if sys.argv[1:2] == ["--coverage"]:
        by_coverage(sys.argv[2:])
    elif sys.argv[1:2] == ["--again"]:  # KIND SEED
        print(tried_again(sys.argv[2], int(sys.argv[3])), end="")
    elif sys.argv[1:2] == ["--see"]:  # KIND SEED
        print(tried(sys.argv[2], int(sys.argv[3])), seen)
    else:
        sys.stdout = io.TextIOWrapper(sys.stdout.buffer, "utf-8", "backslashreplace", line_buffering=True)
        given = sys.argv[1:]
        first_seed = int(given[1]) if given[1:] else None
        sys.exit(search(float(given[0]) if given else 60.0, first_seed, " ".join(given[2:])))
