"""Comments of our own: the stamp by which a program is verified, and messages for the operator."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.notes import does_something, stamp_of
from chipbreak.settings import load
from chipbreak.settings.fingerprint import fingerprint
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from warm import warm_text

PROGRAM = b"%\nO0001 (SHAFT)\nG97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n%\n"
STAMPED = ("output.stamp=true",)


def lines(data: bytes) -> list[str]:
    return data.decode("latin-1").splitlines()


@pytest.mark.parametrize("profile", ["generic-lathe", "fanuc-lathe", "linuxcnc-lathe"])
def test_the_stamp_stands_before_the_first_block(profile: str) -> None:
    program = (
        PROGRAM
        if profile != "linuxcnc-lathe"
        else PROGRAM.replace(b"O0001 ", b"").replace(b"G97", b"G95 G97")
    )
    settings = load(
        profile, [*STAMPED, "axes.Z.max_acceleration_mm_s2=20000", "axes.X.max_acceleration_mm_s2=20000"]
    )
    data = chipbreak.rewrite(program, settings).data
    stamp = stamp_of(data)
    assert stamp is not None
    assert stamp.profile == profile.upper()
    assert stamp.fingerprint == fingerprint(settings)
    assert chipbreak.__version__.upper().startswith(stamp.version)
    assert "SHAFT" in lines(data)[1]
    assert lines(data)[2].startswith("(CHIPBREAK BEGIN STAMP ")
    assert chipbreak.restore(data) == program
    assert not chipbreak.rewrite(data, settings).changed


def test_a_program_that_does_not_change_gets_no_stamp() -> None:
    plain = PROGRAM.replace(b" N1.5", b"")
    assert chipbreak.rewrite(plain, load("generic-lathe", STAMPED)).data == plain


def test_the_fingerprint_is_that_of_what_is_said(tmp_path: Path) -> None:
    one, other = tmp_path / "one.toml", tmp_path / "other.toml"
    one.write_text('base = "generic-lathe"\n[spindle]\nmax_rpm = 4000\n[operations]\nrough = ["A"]\n')
    other.write_text(
        '# a copy\nbase = "generic-lathe"\n[operations]\nrough = ["A"]\n\n[spindle]\nmax_rpm = 4000.0\n'
    )
    assert fingerprint(load(one)) == fingerprint(load(other))
    assert fingerprint(load(one)) != fingerprint(load(one, ["spindle.max_rpm=4001"]))
    assert fingerprint(load("generic-lathe")) != fingerprint(load("linuxcnc-lathe"))
    assert fingerprint(load("generic-lathe")) != fingerprint(load("generic-lathe", ["axes.X.sign=-1"]))
    calls = 'base = "fanuc-mill"\n[calls.mine]\ncalibrate = "G65 P{}"\n'
    one.write_text(calls.format(1))
    other.write_text(calls.format(2))
    assert fingerprint(load(one)) != fingerprint(load(other))


def test_verify_finds_the_profile_by_the_stamp(tmp_path: Path) -> None:
    (tmp_path / "shop.toml").write_text(
        'base = "generic-lathe"\n[output]\nstamp = true\n[vibration]\nmargin = 1.3\n'
    )
    (tmp_path / "part.nc").write_bytes(PROGRAM)
    assert warm_text("filter", "-p", "shop.toml", "part.nc", "-o", "out.nc", cwd=tmp_path).returncode == 0
    done = warm_text("verify", "out.nc", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "profile shop.toml" in done.stdout
    (tmp_path / "shop.toml").write_text(
        'base = "generic-lathe"\n[output]\nstamp = true\n[vibration]\nmargin = 1.4\n'
    )
    done = warm_text("verify", "out.nc", cwd=tmp_path)
    assert done.returncode == 2
    assert "was filtered with profile SHOP" in done.stderr


def test_verify_finds_a_shipped_profile(tmp_path: Path) -> None:
    data = chipbreak.rewrite(PROGRAM, load("generic-lathe", STAMPED)).data
    (tmp_path / "out.nc").write_bytes(data)
    done = warm_text("verify", "out.nc", cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_verify_with_another_profile_says_which_the_stamp_names(tmp_path: Path) -> None:
    data = chipbreak.rewrite(PROGRAM, load("generic-lathe", STAMPED)).data
    (tmp_path / "out.nc").write_bytes(data)
    done = warm_text("verify", "-p", "fanuc-lathe", "out.nc", cwd=tmp_path)
    assert done.returncode == 4
    assert "its stamp says profile GENERIC-LATHE (" in done.stderr


def test_a_message_keeps_its_percent() -> None:
    program = b"G7 G95 G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG0 Z5.\nM2\n"
    settings = load("linuxcnc-lathe", ['planner.model="ideal"'])
    lines = chipbreak.rewrite(program, settings, messages=True).data.decode().splitlines()
    (said,) = [line for line in lines if "VIB090" in line]
    assert " percent of the acceleration" in said
    assert not [line for line in lines if line.startswith("(MSG") and "  " in line]


# --- messages ---------------------------------------------------------------------------------------------

WARNED = b"O0001\nG97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-30. F0.05\nG0 X40.\n(VIBRATION N1.5)\nM30\n"


@pytest.mark.parametrize(
    ("profile", "mark"), [("generic-lathe", "(CHIPBREAK "), ("linuxcnc-lathe", "(MSG, chipbreak ")]
)
def test_warnings_become_comments(profile: str, mark: str) -> None:
    program = WARNED.replace(b"O0001\n", b"").replace(b"G97", b"G95 G97")
    settings = load(profile, ["axes.Z.max_acceleration_mm_s2=20000", "axes.X.max_acceleration_mm_s2=20000"])
    result = chipbreak.rewrite(program, settings, "part.nc", messages=True)
    warnings = [one.code for one in result.diagnostics if one.severity.value == "warning"]
    written = [line for line in lines(result.data) if line.startswith(mark) and "CHIPBREAK BEGIN" not in line]
    assert warnings
    shown = [line for line in written if any(code in line for code in warnings)]
    assert len(shown) == len(warnings)
    assert all(len(line) <= settings.control.max_line_chars for line in shown)
    assert all(line.count("(") == line.count(")") == 1 for line in shown)
    assert chipbreak.restore(result.data) == program
    assert len(list(chipbreak.motions(result, settings))) == len(result.cuts)


def test_without_warnings_nothing_is_written() -> None:
    plain = PROGRAM.replace(b" N1.5", b"")
    assert chipbreak.rewrite(plain, load("generic-lathe"), messages=True).data == plain


def test_a_program_with_warnings_only_gets_them_too(tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_bytes(b"G97 S3000 M3\nG0 X20. Z2.\n(VIBRATION N1.5)\nG1 Z-3. F0.05\nM30\n")
    done = warm_text("filter", "-p", "generic-lathe", "--operator-messages", "part.nc", cwd=tmp_path)
    assert done.returncode == 0
    assert "(CHIPBREAK LINE 3, VIB06" in done.stdout


@pytest.mark.parametrize(
    ("line", "does"),
    [
        ("<PART>", False),  # the name of a program
        ("$1", False),  # the path that the lines are of
        ("O0001", False),
        ("(SO)", False),
        ("N5", False),
        ("$1 G0 X1.", True),
        ("G28 U0.", True),
    ],
)
def test_a_name_and_the_mark_of_a_path_do_nothing(line: str, does: bool) -> None:
    settings = load("fanuc-lathe")
    assert does_something(parse(read(f"{line}\n".encode()), settings.dialect), 0) is does
    # So the stamp stands behind it.
    output = chipbreak.rewrite(
        f"{line}\nG97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n".encode(),
        load("fanuc-lathe", STAMPED),
    )
    assert lines(output.data)[0].startswith("(CHIPBREAK") is does


@pytest.mark.parametrize("program", [b"(FOO", b"(FOO)", b"O1", b"%", b"(CHIPBREAK", b"%\n(FOO)\n"])
def test_a_program_that_runs_nothing_has_no_messages_in_it(program: bytes, tmp_path: Path) -> None:
    """There is no block for them to stand before, and perhaps no end of a line behind which they could."""
    (tmp_path / "part.nc").write_bytes(program)
    done = warm_text("filter", "-p", "fanuc-mill", "--operator-messages", "part.nc", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, program.decode())
    assert "CHK001" in done.stderr
