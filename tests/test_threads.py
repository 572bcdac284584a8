"""Eight threads at once make what one makes, byte for byte."""

from __future__ import annotations

import random
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import pytest

import chipbreak
from chipbreak.trajectory import feed_search, linuxcnc_fit
from chipbreak.trajectory.linuxcnc_feeds import Found, Wanted
from chipbreak.trajectory.linuxcnc_planner import Clock
from chipbreak.trajectory.trapezoid import Trapezoid

HERE = Path(__file__).parent
FLAGS = "; flags:"
THREADS = 8


def programs(every: int) -> Iterator[tuple[bytes, chipbreak.Settings]]:
    """Programs of every so manieth case with the settings it asks for, a mill's and a bad one."""
    for file in sorted((HERE / "cases" / "vibrate").glob("*.nc"))[::every]:
        data = file.read_bytes().partition(b"; --- output\n")[0]
        head = data.decode("latin-1").splitlines()[0]
        words = shlex.split(head.removeprefix(FLAGS)) if head.startswith(FLAGS) else []
        options = list(zip(words[::2], words[1::2], strict=True))
        profile = next((value for option, value in options if option == "-p"), "generic-lathe")
        yield data, chipbreak.load(profile, [value for option, value in options if option == "--set"])
    for name in ("linuxcnc-lathe", "linuxcnc-mill", "haas-mill"):
        yield (HERE.parent / "samples" / "fusion-mill.nc").read_bytes(), chipbreak.load(name)
    yield b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N2 Q[1+1]\nM30\n", chipbreak.load("generic-lathe")
    strokes = b"G97 S1000 M3\nG0 X20. Z2.\nG95 G1 Z-1. F0.05 N1.5\nM30\n"
    for speed in (b"S1000", b"S900"):
        yield strokes.replace(b"S1000", speed), chipbreak.load("linuxcnc-lathe")


def outcome(data: bytes, settings: chipbreak.Settings) -> object:
    """All that a run gives: bytes, findings, reasons, verdicts; or why there is none."""
    try:
        result = chipbreak.rewrite(data, settings)
    except (chipbreak.ProgramRejectedError, chipbreak.ToolFileError) as error:
        return error.diagnostics
    verdicts = [(cut.control, cut.duration_s, cut.verdict) for cut in result.cuts]
    return result.data, result.diagnostics, [edit.reason for edit in result.edits], verdicts


def forget_everything() -> None:
    """Empty every cache of the package, so that the threads fill them together."""
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "chipbreak":
            for value in list(vars(module).values()):
                if hasattr(value, "cache_clear"):
                    value.cache_clear()


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads take turns as often as they can."""
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(usual)


@pytest.mark.usefixtures("hasty")
@pytest.mark.parametrize("every", [24, pytest.param(3, marks=pytest.mark.long)])
def test_eight_threads_make_what_one_makes(every: int, monkeypatch: pytest.MonkeyPatch) -> None:
    work = list(programs(every))
    wanted = [outcome(*one) for one in work]
    assert sum(isinstance(one, tuple) and len(one) == 4 for one in wanted) > len(wanted) // 2
    forget_everything()
    monkeypatch.setattr(feed_search, "_MOST_KNOWN", 0)  # what one has found another forgets at once
    together = Barrier(THREADS)

    def run(seed: int) -> list[int]:
        """The places whose outcome was another one."""
        order = random.Random(seed).sample(range(len(work)), len(work))
        together.wait()
        return [at for at in order if outcome(*work[at]) != wanted[at]]

    with ThreadPoolExecutor(THREADS) as pool:
        assert list(pool.map(run, range(THREADS))) == [[]] * THREADS


CUT = b"G97 S1000 M3\nG0 X20. Z2.\nG95 G1 Z-1. F0.05 N1.5\nG0 Z2.\nG1 Z-1.2 F0.05 N1.5\nM30\n"
LONGER = CUT.replace(b"M30", b"G0 Z2.\nG1 Z-1. F0.06 N1.5\nM30")


def test_what_another_thread_forgets_is_not_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search for feeds on LinuxCNC, with all that was found before forgotten while it searches."""
    settings = chipbreak.load("linuxcnc-lathe")
    wanted = chipbreak.rewrite(CUT, settings).data
    forgotten = list[int]()
    search = linuxcnc_fit.factors_for

    def forgetting(asked: Wanted, clocks: Sequence[Clock]) -> Found:
        known = linuxcnc_fit._known(tuple(clocks), asked.fitted)
        forgotten.append(len(known))
        known.clear()
        return search(asked, clocks)

    monkeypatch.setattr(linuxcnc_fit, "factors_for", forgetting)
    chipbreak.rewrite(LONGER, settings)
    assert any(forgotten)
    assert chipbreak.rewrite(CUT, settings).data == wanted


def test_nor_is_it_under_a_declared_acceleration(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same under the trapezoid."""
    settings = chipbreak.load("linuxcnc-lathe", ["planner.model=trapezoid"])
    wanted = chipbreak.rewrite(CUT, settings).data
    searches = (feed_search, "_new_factors"), (Trapezoid, "single_feeds")
    forgotten = set()

    def forgetting(name: str, search: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any) -> Any:
            law = next(one for one in arguments if isinstance(one, Trapezoid))
            known = feed_search._known(law)
            if known:
                forgotten.add(name)
            known.clear()
            return search(*arguments)

        return run

    for home, name in searches:
        monkeypatch.setattr(home, name, forgetting(name, getattr(home, name)))
    chipbreak.rewrite(LONGER, settings)
    assert "single_feeds" in forgotten
    assert chipbreak.rewrite(CUT, settings).data == wanted
