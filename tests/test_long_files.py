"""A long program is rewritten from an excerpt: what comes out is what the whole one gives, to the byte."""

from __future__ import annotations

import os
import subprocess
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from beam import BEAM
from chipbreak import long_programs, program_commands
from chipbreak.cli import cli
from chipbreak.long_programs import AROUND, pieces_of, rewrite_long
from chipbreak.pipeline import rewrite
from chipbreak.report.build import report_of
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import ChipbreakError, Severity
from chipbreak.text.long_file import LongFile
from longer import short_where

TESTS = Path(__file__).parent
SAMPLES = TESTS.parent / "samples"
FOLDERS = ("shop", "shop_mills", "cases", "bad")
FILES = sorted(
    file
    for folder in (SAMPLES, *(TESTS / name for name in FOLDERS))
    for file in folder.rglob("*")
    if file.suffix in (".nc", ".ngc", ".tap")
)
MILL = chipbreak.load(str(SAMPLES / "mill-with-laser.toml"))
PROFILES = {
    "mill": MILL,
    "linuxcnc": chipbreak.load("linuxcnc-mill", BEAM),
    "lathe": chipbreak.load("fanuc-lathe"),
    # What a program shows of its control stands anywhere in it, so one that may show it is read whole.
    "nothing is shown": chipbreak.load("fanuc-lathe", ["control.decimal_point=required"]),
}
# How many lines are kept around a cut, and how many bytes are read at once.
SIZES = [(0, 64), (1, 100), (4, 1 << 16)]
NAME = "long.nc"


def opened(data: bytes, folder: Path) -> LongFile:
    file = folder / NAME
    file.write_bytes(data)
    return LongFile.of(file.open("rb"), NAME)


def said_of(data: bytes, settings: Settings) -> object:
    """What the whole program gives: bytes, what is said, the report; or what stands in its way."""
    try:
        result = rewrite(data, settings, NAME)
    except ChipbreakError as error:
        return str(error)
    return result.data, result.diagnostics, str(report_of(result, settings)), result.changed


def said_of_excerpt(
    data: bytes, settings: Settings, folder: Path, around: int = AROUND, piece_bytes: int = 1 << 20
) -> object | None:
    """The same from an excerpt; None where the program is read whole."""
    program = opened(data, folder)
    with program.file:
        try:
            result = rewrite_long(program, settings, around=around, piece_bytes=piece_bytes)
        except ChipbreakError as error:
            return str(error)
        if result is None:
            return None
        written = b"".join(pieces_of(result))
        return written, result.diagnostics, str(report_of(result, settings)), result.changed


def compared(data: bytes, settings: Settings, folder: Path) -> int:
    """How many of the sizes gave an excerpt; each of these gives what the whole program gives."""
    found = [said_of_excerpt(data, settings, folder, *size) for size in SIZES]
    excerpts = [one for one in found if one is not None]
    if excerpts:
        wanted = said_of(data, settings)
        for one in excerpts:
            assert one == wanted
    return len(excerpts)


def test_every_program_of_the_tests_with_one_profile(tmp_path: Path) -> None:
    """Half of them, each with a profile that does not depend on which others there are."""
    names = {file: zlib.crc32(file.name.encode()) for file in FILES}
    profiles = [*PROFILES.values()]
    each = ((file, profiles[number // 2 % len(profiles)]) for file, number in names.items() if number % 2)
    assert sum(compared(file.read_bytes(), settings, tmp_path) for file, settings in each) > 25


@pytest.mark.long
@pytest.mark.parametrize("profile", PROFILES)
def test_every_program_of_the_tests(profile: str, tmp_path: Path) -> None:
    count = sum(compared(file.read_bytes(), PROFILES[profile], tmp_path) for file in FILES)
    assert count > {"mill": 80, "linuxcnc": 30, "lathe": 25, "nothing is shown": 30}[profile]


@pytest.mark.large_is_long
@pytest.mark.parametrize("profile", short_where(PROFILES, lambda profile: profile == "lathe"))
def test_every_program_of_the_corpus(profile: str, corpus_file: Path, tmp_path: Path) -> None:
    compared(corpus_file.read_bytes()[: 1 << 20], PROFILES[profile], tmp_path)


# --- drawn programs ----------------------------------------------------------------------------------------
number = st.integers(-9000, 9000).map(lambda n: f"{n / 100:.2f}" if n % 3 else f"{n // 100}.")
move = st.builds(
    lambda code, words, feed: " ".join([code, *words, feed]).strip() or "X1.",
    st.sampled_from(["", "", "", "G1", "G0", "G01", "G1"]),
    st.lists(
        st.tuples(st.sampled_from("XYZ"), number).map("".join),
        min_size=1,
        max_size=3,
        unique_by=lambda w: w[0],
    ),
    st.sampled_from(["", "", "", "F300.", "F99.5"]),
)
arc = st.builds("G{} X{} Y{} I{} J{}".format, st.sampled_from("23"), number, number, number, number)
special = st.sampled_from(
    [
        "(FINISH POCKET)",
        "(ROUGH SIDE)",
        "(A NOTE)",
        "M8",
        "M9",
        "S4000 M3",
        "M5",
        "G4 P500",
        "T2 M6",
        "T1 M6",
        "G91 G28 Z0.",
        "G90",
        "G91",
        "G21",
        "G17 G40",
        "M1",
        "/ G0 Z5.",
        "",
        "G0 G43 Z20. H1",
        "G81 X5. Y5. Z-3. R2. F100.",
        "G80",
        "G54",
        "G0 X0. Y0. M8",
    ]
)
run = st.lists(st.one_of(move, move, move, arc), min_size=1, max_size=12)
drawn = st.lists(st.one_of(run, run, special.map(lambda one: [one])), min_size=3, max_size=24)
HEAD = ["%", "O1 (PART)", "(ROUGH POCKET)", "T1 M6", "G90 G54 G17 G21 G94", "S3000 M3", "G0 X0. Y0."]
HEAD += ["G43 Z50. H1 M8", "G0 Z2."]
TAIL = ["G0 Z50. M9", "M5", "M30", "%"]


@pytest.mark.few(10)
@given(drawn, st.sampled_from(["mill", "linuxcnc"]), st.sampled_from(["\n", "\r\n"]), st.booleans())
def test_drawn_programs(
    tmp_path_factory: pytest.TempPathFactory, parts: list[list[str]], profile: str, end: str, numbered: bool
) -> None:
    lines = [*HEAD, *(line for part in parts for line in part), *TAIL]
    if numbered:
        lines = [f"N{n} {line}" if line[:1] not in ("%", "/", "O") else line for n, line in enumerate(lines)]
    data = end.join([*lines, ""]).encode()
    compared(data, PROFILES[profile], tmp_path_factory.mktemp("drawn"))


# --- as long as they are meant to be -----------------------------------------------------------------------
def long_program(cuts: int, operations: int = 6) -> bytes:
    """Roughing and finishing by two tools, with links in rapid feed and arcs."""
    lines = ["%", "O7 (LONG)"]
    for operation in range(operations):
        tool = operation // 2 % 2 + 1
        lines.append(f"({'FINISH' if operation % 2 else 'ROUGH'} FACE {operation})")
        if operation % 2 == 0:
            lines += [f"T{tool} M6", "G90 G54 G17 G21 G94", f"S{3000 + tool} M3", "G0 X0. Y0."]
            lines += [f"G43 Z50. H{tool} M8"]
        lines += ["G0 Z2.", f"G1 Z-.5 F{500 + operation}."]
        for cut in range(cuts):
            lines.append(f"X{cut % 97}.{cut % 10} Y{cut % 31}. Z-{cut % 7}.25")
            if cut % 50 == 0:
                lines += ["G0 Z5.", f"X{cut % 11}.", "G1 Z-1."]
            if cut % 70 == 0:
                lines += ["G2 X5. Y5. I2.5 J0.", "G1 X6."]
        lines += ["G0 Z50.", "X100. Y100.", "M9", "M1"]
    return "\n".join([*lines, "M30", "%", ""]).encode()


@pytest.fixture(scope="module")
def wanted() -> tuple[bytes, bytes]:
    """A program with runs that are longer than what is kept of them, and what it becomes."""
    data = long_program(3 * AROUND)
    return data, rewrite(data, MILL, NAME).data


def test_a_program_of_long_runs(wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
    data, _ = wanted
    assert said_of_excerpt(data, MILL, tmp_path) == said_of(data, MILL)
    program = opened(data, tmp_path)
    with program.file:
        result = rewrite_long(program, MILL)
    assert result is not None
    assert result.edits
    assert result.source.line_count < data.count(b"\n") * 0.8


@pytest.fixture
def every_file_is_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """And none is read whole."""
    monkeypatch.setattr(program_commands, "LONG_BYTES", 1)
    monkeypatch.delattr("chipbreak.pipeline.rewrite")


WORDS = ["filter", "-q", "-p", str(SAMPLES / "mill-with-laser.toml")]


@pytest.mark.usefixtures("every_file_is_long")
class TestCommand:
    """``chipbreak filter`` of a long file."""

    def test_to_a_file(self, wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
        data, output = wanted
        file = tmp_path / NAME
        file.write_bytes(data)
        found = CliRunner().invoke(cli, [*WORDS, str(file), "-o", str(tmp_path / "out.nc")])
        assert found.exit_code == 0, found.output
        assert (tmp_path / "out.nc").read_bytes() == output
        assert file.read_bytes() == data
        assert sorted(one.name for one in tmp_path.iterdir()) == [NAME, "out.nc"]

    def test_to_stdout(self, wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
        data, output = wanted
        (tmp_path / NAME).write_bytes(data)
        found = CliRunner().invoke(cli, [*WORDS, str(tmp_path / NAME)])
        assert (found.exit_code, found.stdout_bytes) == (0, output)

    def test_in_place(self, wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
        data, output = wanted
        (tmp_path / NAME).write_bytes(data)
        found = CliRunner().invoke(cli, [*WORDS, "-i", str(tmp_path / NAME)])
        assert found.exit_code == 0, found.output
        assert (tmp_path / NAME).read_bytes() == output

    def test_only_looked_at(self, wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
        data, _ = wanted
        (tmp_path / NAME).write_bytes(data)
        found = CliRunner().invoke(cli, [*WORDS, "--check", str(tmp_path / NAME)])
        assert found.exit_code == 1, found.output
        assert (tmp_path / NAME).read_bytes() == data

    def test_one_that_changes_meanwhile(
        self, wanted: tuple[bytes, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        data, _ = wanted
        file = tmp_path / NAME
        target = tmp_path / "out.nc"
        file.write_bytes(data)
        target.write_bytes(b"as it was")

        def pieces_and_a_change(result: chipbreak.Result) -> Iterator[bytes]:
            yield from pieces_of(result)
            file.write_bytes(data.replace(b"X5.", b"X6."))
            os.utime(file, (1, 1))

        monkeypatch.setattr(long_programs, "pieces_of", pieces_and_a_change)
        found = CliRunner().invoke(cli, [*WORDS, str(file), "-o", str(target)])
        assert found.exit_code == 2
        assert "changes while it is read" in found.output
        assert target.read_bytes() == b"as it was"
        assert sorted(one.name for one in tmp_path.iterdir()) == [NAME, "out.nc"]

    def test_one_that_ends_early(
        self, wanted: tuple[bytes, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        data, _ = wanted
        file = tmp_path / NAME
        file.write_bytes(data)

        def pieces_of_a_shorter_one(result: chipbreak.Result) -> Iterator[bytes]:
            os.truncate(file, len(data) // 2)
            yield from pieces_of(result)

        monkeypatch.setattr(long_programs, "pieces_of", pieces_of_a_shorter_one)
        found = CliRunner().invoke(cli, [*WORDS, str(file), "-o", str(tmp_path / "out.nc")])
        assert found.exit_code == 2
        assert [one.name for one in tmp_path.iterdir()] == [NAME]

    def test_one_that_is_rejected(self, wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
        data, _ = wanted
        file = tmp_path / NAME
        target = tmp_path / "out.nc"
        file.write_bytes(data.replace(b"M30\n", b"(OPEN\nV100. D0. M3\nM30\n"))
        found = CliRunner().invoke(cli, [*WORDS, str(file), "-o", str(target)])
        assert found.exit_code == 3, found.output
        assert not target.exists()
        with pytest.raises(chipbreak.ProgramRejectedError) as error:
            rewrite(file.read_bytes(), MILL, str(file))
        assert found.output == "".join(
            f"{one.render()}\n" for one in error.value.diagnostics if one.severity is Severity.ERROR
        )


def test_stdin_as_a_file(wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
    data, output = wanted
    code = "from chipbreak import program_commands as c, cli; c.LONG_BYTES = 1; cli.cli()"
    words = [sys.executable, "-c", code, *WORDS]
    found = subprocess.run(words, input=data, capture_output=True, cwd=tmp_path, check=True)
    assert found.stdout == output


# --- what is read whole ------------------------------------------------------------------------------------
def cuts(line: str = "X{n}. Y1.", count: int = 40) -> str:
    return "".join(line.format(n=n) + "\n" for n in range(count))


PLAIN = f"G90 G21 G94\nS1000 M3\nG0 X0. Y0.\nZ2.\nG1 Z-1. F100.\n{cuts()}G0 Z50.\n"
WHOLE = {
    "a jump": f"{PLAIN}GOTO 10\nN10 M30\n",
    "a jump to a number that is left out": f"{PLAIN}IF [#1 EQ 1] GOTO 7\n{cuts('N{n} X{n}.')}M30\n",
    "a part that goes back": f"{PLAIN}M99 P10\n",
    "a loop": f"#1=0\nWHILE [#1 LT 3] DO1\n{PLAIN}#1=#1+1\nEND1\nM30\n",
    "a subprogram of the file": f"M98 P2\n{PLAIN}M30\nO2\n{PLAIN}M99\n",
    "a wish": f"(VIB N1.5)\n{PLAIN}M30\n",
    "a wish in a block": f"{PLAIN}G1 X5. F100. N1.5\nM30\n",
    "a number with a fraction": f"{PLAIN}{cuts('N1.5 X{n}.')}M30\n",
    "distances": f"{PLAIN}G91\nG1 X1.\n{cuts()}G90\nM30\n",
    "a line that ends with CR": PLAIN.replace("\n", "\r") + "M30\r",
    "a cycle": f"{PLAIN}G81 X1. Y1. Z-1. R1. F50.\n{cuts()}G80\nM30\n",
    "no cut behind": f"{PLAIN}G0 X1.\n{cuts()}M30\n".replace("G1 Z-1. F100.", "Z-1."),
    "behind the end": f"{PLAIN}M30\nG1 X1.\n{cuts()}",
}


@pytest.mark.parametrize("name", WHOLE)
def test_what_is_read_whole(name: str, tmp_path: Path) -> None:
    assert said_of_excerpt(f"{PLAIN}M30\n".encode(), MILL, tmp_path, 1) is not None
    assert said_of_excerpt(WHOLE[name].encode(), MILL, tmp_path, 1) is None


def test_one_that_was_filtered_is_read_whole(wanted: tuple[bytes, bytes], tmp_path: Path) -> None:
    assert said_of_excerpt(wanted[1], MILL, tmp_path) is None


@pytest.mark.parametrize(
    ("profile", "sets"),
    [
        ("fanuc-mill", ("vibration.n=1.5",)),
        ("fanuc-mill", ('output.brackets="none"',)),
        ("fanuc-mill", ('cycles.unroll="always"',)),
        ("fanuc-lathe", ("checks.enabled=true", *BEAM)),
        ("grbl", ()),
    ],
)
def test_profiles_for_which_programs_are_read_whole(
    profile: str, sets: tuple[str, ...], tmp_path: Path
) -> None:
    program = f"{PLAIN}M30\n".encode()
    assert said_of_excerpt(program, chipbreak.load(profile, sets), tmp_path, 1) is None


# --- what it takes -----------------------------------------------------------------------------------------
MEASURED = """
import sys
from pathlib import Path
from chipbreak.cli import cli
try:
    cli()
finally:
    lines = Path("/proc/self/status").read_text().splitlines()
    print(next(line.split()[1] for line in lines if line.startswith("VmHWM")), file=sys.stderr)
"""


def peak_mb(program: Path) -> float:
    words = [sys.executable, "-c", MEASURED, *WORDS, str(program), "-o", str(program.with_suffix(".out"))]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    found = subprocess.run(words, capture_output=True, text=True, check=True, env=environment)
    return int(found.stderr.split()[-1]) / 1024


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux's /proc")
def test_memory_does_not_grow_with_the_program(tmp_path: Path) -> None:
    sizes = []
    for cuts_of_each in (30_000, 120_000):
        program = tmp_path / f"{cuts_of_each}.nc"
        program.write_bytes(long_program(cuts_of_each))
        sizes.append(peak_mb(program))
    assert max(sizes) < 90
    assert sizes[1] - sizes[0] < 5


def test_bytes_that_end_in_the_middle_of_a_line(tmp_path: Path) -> None:
    data = long_program(40).rstrip(b"\n%") + b"\nG0 Z9"
    assert said_of_excerpt(data, MILL, tmp_path, 1, 50) == said_of(data, MILL)
