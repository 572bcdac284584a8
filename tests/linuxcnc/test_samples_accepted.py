"""The shipped samples for LinuxCNC, through the filter and past LinuxCNC's own interpreter."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.restore import restore
from chipbreak.text.source import read

from . import rs274

SAMPLES = Path(__file__).parents[2] / "samples"
COOKBOOK = SAMPLES / "cookbook.ngc"
WITH_TESTS_OF_THEIR_OWN = {COOKBOOK, SAMPLES / "shaft.ngc"}
FOR_LINUXCNC = sorted(set(SAMPLES.glob("*.ngc")) - WITH_TESTS_OF_THEIR_OWN)
CANON_MM = 1e-4  # canonical calls have four decimals


def filtered(sample: Path, *sets: str) -> chipbreak.Result:
    settings = chipbreak.load(sample.stem, sets)
    return chipbreak.rewrite(sample.read_bytes(), settings, sample.name)


def without_wishes(program: bytes) -> bytes:
    """Without the words that ask for vibration: no control knows them behind a move."""
    plain = re.sub(rb"(?m)^(G1 .*?)( [ENQf][0-9.]+)+(?=\s*$)", rb"\1", program)
    assert plain != program
    return plain


def motion(program: bytes) -> list[rs274.Motion]:
    judgement = rs274.judge(program, lathe=True)
    assert judgement.accepted, judgement.message
    assert judgement.message == ""
    return judgement.motion


def ends_of_cuts(moves: list[rs274.Motion]) -> list[rs274.Motion]:
    """The last move of every run of feed moves."""
    cuts = [move.kind == "feed" for move in moves]
    return [
        move
        for move, is_cut, goes_on in zip(moves, cuts, [*cuts[1:], False], strict=True)
        if is_cut and not goes_on
    ]


def test_there_are_samples() -> None:
    assert [sample.stem for sample in FOR_LINUXCNC] == ["linuxcnc-lathe"]


@pytest.mark.linuxcnc
@pytest.mark.parametrize("feed_mode", ["rev", "inverse", "minute"])
@pytest.mark.parametrize("sample", FOR_LINUXCNC, ids=lambda path: path.stem)
def test_the_interpreter_takes_what_comes_out(sample: Path, feed_mode: str) -> None:
    result = filtered(sample, f"output.feed_mode={feed_mode}")
    strokes = [move for move in motion(result.data) if move.path_mode == "G61"]

    assert len(strokes) == sum(cut.move_count for cut in result.cuts) > 100
    assert {move.kind for move in strokes} == {"feed"}
    # F gives the time that an ideal control would take; this one needs longer, as the filter reckoned.
    promised_s = sum(cut.duration_s for cut in result.cuts)
    assert 0.8 * promised_s < sum(move.time_s for move in strokes) < promised_s


@pytest.mark.linuxcnc
@pytest.mark.parametrize("sample", FOR_LINUXCNC, ids=lambda path: path.stem)
def test_the_interpreter_takes_it_when_put_back(sample: Path) -> None:
    put_back = restore(read(filtered(sample).data, sample.name)).data

    assert put_back == sample.read_bytes()
    assert motion(without_wishes(put_back))


@pytest.mark.linuxcnc
@pytest.mark.parametrize("sample", FOR_LINUXCNC, ids=lambda path: path.stem)
def test_every_cut_ends_where_and_as_it_did(sample: Path) -> None:
    was = ends_of_cuts(motion(without_wishes(sample.read_bytes())))
    now = ends_of_cuts(motion(filtered(sample).data))

    assert len(now) == len(was) >= 3
    for one, other in zip(was, now, strict=True):
        assert (other.x_mm, other.z_mm) == pytest.approx((one.x_mm, one.z_mm), abs=CANON_MM)
        assert (other.feed, other.per_rev, other.speed) == (one.feed, one.per_rev, one.speed)


@pytest.mark.linuxcnc
@pytest.mark.parametrize("feed_mode", ["rev", "inverse", "minute"])
def test_the_cut_of_the_cookbook_ends_where_it_did(feed_mode: str) -> None:
    """The machine chooses S and N, so the speed may be another one."""
    settings = chipbreak.load(str(SAMPLES / "cookbook-lathe.toml"), [f"output.feed_mode={feed_mode}"])
    result = chipbreak.rewrite(COOKBOOK.read_bytes(), settings, COOKBOOK.name)
    (cut,) = result.cuts
    (was,) = ends_of_cuts(motion(COOKBOOK.read_bytes()))
    moves = motion(result.data)
    strokes = [move for move in moves if move.path_mode == "G61"]
    assert len(strokes) == cut.move_count > 100
    now = ends_of_cuts(moves)[-1]
    assert (now.x_mm, now.z_mm) == pytest.approx((was.x_mm, was.z_mm), abs=CANON_MM)
    assert restore(read(result.data, COOKBOOK.name)).data == COOKBOOK.read_bytes()
