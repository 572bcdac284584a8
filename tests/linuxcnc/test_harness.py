"""The harness itself: does it tell good programs from bad ones, and motion from no motion?"""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from . import machine, rs274

GOOD_LATHE = b"""%
G7 G95 G97 S1000 M3
T0101 M6
G0 X20 Z2
G1 Z-5 F0.1
X30
G8 G94 F300
G1 X20 Z-10
G2 X25 Z-15 R5
G4 P0.5
M30
%
"""


@pytest.mark.linuxcnc
def test_a_lathe_program_is_accepted_and_read_as_motion() -> None:
    verdict = rs274.judge(GOOD_LATHE.replace(b"T0101", b"T1"), lathe=True)

    assert verdict.accepted, verdict.message
    assert verdict.message == ""
    assert [(m.kind, m.x_mm, m.z_mm) for m in verdict.motion] == [
        ("traverse", 10, 2),
        ("feed", 10, -5),
        ("feed", 15, -5),
        ("feed", 20, -10),
        ("arc", 25, -15),
        ("dwell", 25, -15),
    ]
    turning, facing, taper = verdict.motion[1:4]
    assert (turning.feed, turning.per_rev, turning.speed) == (0.1, True, 1000)
    assert turning.time_s == pytest.approx(7 / 100 * 60)
    assert facing.time_s == pytest.approx(5 / 100 * 60)
    assert (taper.feed, taper.per_rev) == (300, False)
    assert verdict.motion[-1].time_s == 0.5


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    ("program", "complaint"),
    [
        (b"G93 G1 X1\nM2\n", "F word missing with inverse time"),
        (b"G95 G1 X1 F0.1\nM2\n", "zero spindle speed"),
        (b"G1 X1 F100\n", "File ended with no percent sign"),
        (b"%\nG1 X1 F100\nG1 X1 ,C2\n%\n", "Bad character"),
        (b"o<nowhere> call\nM2\n", "nowhere"),
        (b"T100 M6\nM2\n", "100"),
        (b"", ""),
    ],
)
def test_a_bad_program_is_rejected_with_the_complaint(program: bytes, complaint: str) -> None:
    verdict = rs274.judge(program, lathe=True)

    assert not verdict.accepted
    assert verdict.message
    assert complaint in verdict.message


@pytest.mark.linuxcnc
def test_inverse_time_inches_threads_and_surface_speed_are_read() -> None:
    program = (
        b"G97 M3 S600\nG93 G1 X3 Z4 F120\n"
        b"G94 G20\nG1 Z1 F10\nG33 Z2 K0.1\n"
        b"G96 S100 D2000\nG21 G95 G1 Z0 F0.2\nM2\n"
    )
    inverse, inch, thread, surface = rs274.judge(program, lathe=True).motion

    assert inverse.time_s == pytest.approx(0.5)
    assert (inch.z_mm, inch.feed) == (25.4, 254)
    assert (thread.kind, thread.per_rev, thread.time_s) == ("thread", True, pytest.approx(1.0))
    assert thread.feed == pytest.approx(2.54)
    assert (surface.surface, surface.speed, surface.time_s) == (True, 100, 0)


@pytest.mark.linuxcnc
def test_subroutines_tools_and_block_delete(tmp_path: Path) -> None:
    (tmp_path / "step.ngc").write_bytes(b"o<step> sub\nG1 Z[#1] F100\no<step> endsub\nM2\n")
    program = b"T3 M6 G43\n/G1 Z9 F100\no<step> call [-4]\nM2\n"
    verdict = rs274.judge(
        program, lathe=True, subroutines=tmp_path, tools=[rs274.Tool(3, z_mm=12.5)], block_delete=True
    )

    assert verdict.accepted, verdict.message
    assert [m.z_mm for m in verdict.motion] == [-4]
    offsets = [call for call in rs274.calls(verdict.canon) if call.name == "USE_TOOL_LENGTH_OFFSET"]
    assert float(offsets[-1].arguments[2]) == pytest.approx(12.5)


@pytest.mark.linuxcnc("machine")
def test_the_machine_reaches_the_end_and_reports_errors() -> None:
    good = b"G21 G90 G94 G61.1\nG1 X10 Y5 Z-3 F600\nG1 Z-4\nG1 Z-3\n(msg, done)\nM2\n"
    bad = b"G93\nG1 X3\nM2\n"
    run, stopped, again = machine.run_steadily([good, bad, good], acceleration_mm_s2=2000)

    assert run.errors == ()
    assert [text.strip() for text in run.messages] == ["done"]
    assert run.samples[-1, 1:].tolist() == [10, 5, -3]
    assert run.samples[:, 3].min() == pytest.approx(-4, abs=0.001)
    # 1 mm at 10 mm/s with 5 ms to speed up and to slow down, each of them costing half of itself
    assert run.line_times()[4] == pytest.approx(0.105, abs=0.0015)
    assert "F word missing" in stopped.errors[0]
    assert len(stopped.moving()) == 0
    assert np.array_equal(run.moving()[:, 1:], again.moving()[:, 1:])


@pytest.mark.linuxcnc("machine")
def test_exact_stop_runs_do_not_depend_on_the_speed_of_the_clock() -> None:
    strokes = "".join(f"G1 Z{0.07 + 0.01 * k:.3f} F6000\nZ{0.01 * (k + 1):.3f}\n" for k in range(40))
    programs = [f"G21 G90 G94 {mode}\n{strokes}M2\n".encode() for mode in ("G61", "G61.1")]
    slow, wall, fast = (
        machine.run_steadily(programs, acceleration_mm_s2=10000, lathe=True, speed_up=speed_up)
        for speed_up in (0.5, 1, 10)
    )

    for slower, one, other in zip(slow, wall, fast, strict=True):
        assert slower.errors == one.errors == other.errors == ()
        assert len(one.moving()) > 80 * 5
        assert np.array_equal(one.moving()[:, 1:], other.moving()[:, 1:])
        assert np.array_equal(one.moving()[:, 1:], slower.moving()[:, 1:])


@pytest.mark.linuxcnc("machine")
def test_feed_per_revolution_follows_the_spindle() -> None:
    program = b"G21 G90 G61 G95 S1200 M3\nG1 Z-4 F0.25\nM2\n"
    (run,) = machine.run([program], acceleration_mm_s2=2000, lathe=True)

    assert run.errors == ()
    assert run.line_times()[2] == pytest.approx(4 / (0.25 * 20), abs=0.01)


def test_the_installer_never_fails() -> None:
    script = Path(__file__).with_name("install.sh")
    done = subprocess.run(["/bin/sh", script], capture_output=True, check=False, env={"PATH": "/nowhere"})

    assert done.returncode == 0
    assert b"LINUXCNC IS NOT INSTALLED" in done.stderr
