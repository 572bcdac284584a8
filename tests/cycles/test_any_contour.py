"""Any contour in all quadrants, as programs: what is written is looked after, and a wrong block is found."""

from __future__ import annotations

import re

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.cycles import plan as planning
from chipbreak.settings import load
from chipbreak.text.diagnostics import SelfCheckError

LATHE = load("fanuc-lathe", ['cycles.unroll="always"'])
STEPS = st.lists(
    st.tuples(st.integers(0, 8000), st.integers(0, 5000), st.sampled_from(["", "G2", "G3"])),
    min_size=2,
    max_size=6,
)


def program_of(
    steps: list[tuple[int, int, str]], *, along_z: bool, z_way: int, x_way: int, depth: int, up_to_mm: float
) -> bytes:
    """A G71 or G72 whose contour goes away from its first point by the steps, along and across."""
    along = across = 0
    blocks = []
    for t, h, arc in steps:
        if t == h == 0:
            continue
        along += t
        across += h
        is_quarter = bool(arc and t and h)
        radius = f" R{max(t, h) * 2 / 1000:.3f}" if is_quarter else ""
        blocks.append((arc if is_quarter else "G1", along, across, radius))
    begin_x, begin_z = 100.0, 0.0
    start_across = across / 1000.0 + up_to_mm
    start = (begin_x + 2.0 * x_way * start_across, begin_z - z_way * 1.0)
    if not along_z:
        start = (begin_x - 2.0 * x_way * 1.0, begin_z + z_way * start_across)
    first = f"X{begin_x:.3f} Z{begin_z:.3f}"
    lines = [f"N10 G0 {first}"]
    for code, t, h, radius in blocks:
        z, x = (t, h) if along_z else (h, t)
        lines.append(
            f"{code} X{begin_x + 2.0 * x_way * x / 1000:.3f} Z{begin_z + z_way * z / 1000:.3f}{radius}"
        )
    lines[-1] = f"N20 {lines[-1]}"
    u, w = 0.4 * x_way, -0.1 * z_way
    if not along_z:
        u, w = -0.4 * x_way, 0.1 * z_way
    code, letter = ("G71", "U") if along_z else ("G72", "W")
    head = [
        "G21 G99",
        "G97 S900 M3",
        f"G0 X{start[0]:.3f} Z{start[1]:.3f}",
        f"{code} {letter}{depth / 1000:.3f} R0.3",
    ]
    head.append(f"{code} P10 Q20 U{u:.3f} W{w:.3f} F0.2")
    return "\n".join([*head, *lines, "G70 P10 Q20", "G0 X300. Z300.", "M30", ""]).encode()


WAYS = {
    "along_z": st.booleans(),
    "z_way": st.sampled_from([1, -1]),
    "x_way": st.sampled_from([1, -1]),
    "depth": st.integers(500, 4000),
    "up_to_mm": st.floats(1.0, 6.0),
}


@pytest.mark.few(8)
@settings(max_examples=60)
@given(STEPS, st.fixed_dictionaries(WAYS))
def test_what_is_written_leaves_the_contour_with_its_allowances(
    steps: list[tuple[int, int, str]], ways: dict[str, object]
) -> None:
    assume(sum(t for t, _, _ in steps) > 500)
    program = program_of(steps, **ways)  # type: ignore[arg-type]
    result = chipbreak.rewrite(program, LATHE)
    refused = {d.code for d in result.diagnostics if d.code.startswith(("CYC", "VIB022"))} - {
        planning.DEEPER_THAN_ALL
    }
    assert (b"UNROLLED" in result.data) != bool(refused)
    assert refused <= {"CYC003"}, "an arc may turn back"
    assert chipbreak.restore(result.data) == program


PROGRAM = program_of(
    [(6000, 0, ""), (3000, 3000, "G2"), (9000, 4000, "")],
    along_z=True,
    z_way=-1,
    x_way=1,
    depth=2000,
    up_to_mm=3.0,
)
PASSES = planning.blocks_of_passes


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (r"G1 Z-[0-9.]+ F", "G1 Z-16. F"),
        (r"G1 Z-[0-9.]+ F", "G1 Z-5. F"),
        (r"G1 (X1[0-9.]+) Z", r"G1 X101. Z"),
        (r"\bG2\b", "G3"),
        (r"G1(.*) F", r"G0\1 F"),
        (r"G0 X116.\n", "G0 X108.\n"),
        (r"G0 Z1\.\n$", ""),
        (r"G1 X114.*\n", ""),
    ],
)
def test_a_wrong_block_is_found(old: str, new: str, monkeypatch: pytest.MonkeyPatch) -> None:
    chipbreak.rewrite(PROGRAM, LATHE)

    def broken(*arguments: object) -> list[str]:
        text = "\n".join(PASSES(*arguments)) + "\n"  # type: ignore[arg-type]
        changed, count = re.subn(old, new, text, count=1)
        assert count, text
        return changed.splitlines()

    monkeypatch.setattr(planning, "blocks_of_passes", broken)
    with pytest.raises(SelfCheckError):
        chipbreak.rewrite(PROGRAM, LATHE)
