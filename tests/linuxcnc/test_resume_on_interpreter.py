"""Programs that are started in their middle, on LinuxCNC's interpreter: from there on they do the same."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from random import Random

import pytest

import chipbreak
from chipbreak.restart.resume import resume
from longer import short_where

from . import rs274
from .mixed_programs import _Machine, program

pytestmark = [
    pytest.mark.linuxcnc,
    pytest.mark.skipif(not rs274.available(), reason="LinuxCNC is not installed"),
]
_MARK = b"(HERE BEGINS THE REST)\n"
# N with a decimal point behind other words is ours: the control does not know it.
_OUR_WORDS = re.compile(rb"(?<=[^\n]) N\d*\.\d*")
_SAMPLES = Path(__file__).parents[2] / "samples"
# What a program that has said nothing of it leaves as it is, and a start block too.
_UNSAID = {
    "place": {None, (0.0, 0.0, 0.0)},
    "FLOOD": {None, "FLOOD_OFF"},
    "MIST": {None, "MIST_OFF"},
    "spindle": {None, "STOP_SPINDLE_TURNING"},
}


def behind_the_mark(data: bytes, *, lathe: bool) -> tuple[dict[str, object], list[rs274.Call]]:
    """The state at the mark, and all that is done behind it."""
    judged = rs274.judge(_OUR_WORDS.sub(b"", data), lathe=lathe)
    assert judged.accepted, judged.message
    calls = rs274.calls(judged.canon)
    at = next(n for n, call in enumerate(calls) if call.name == "COMMENT" and "HERE" in call.arguments[0])
    machine = _Machine()
    for name, said in calls[:at]:
        machine.take(name, said)
    return machine.state, calls[at + 1 :]


def is_same(was: object, now: object, key: str) -> bool:
    """Equal but for the digits that the interpreter prints in inches, and for what nobody has said."""
    if was == now or {was, now} <= _UNSAID.get(key, set()):
        return True
    if key == "feed":  # it was not known before, and the next cut says another
        return now == 0.0
    pairs = zip(was, now, strict=True) if isinstance(was, tuple) and isinstance(now, tuple) else ()
    return key == "place" and bool(pairs) and all(abs(one - other) < 2e-3 for one, other in pairs)


def assert_goes_on(data: bytes, line: int, settings: chipbreak.Settings) -> bool:
    """Start at a line; False where that is refused."""
    try:
        result = resume(data, settings, line)
    except chipbreak.ProgramRejectedError as error:
        assert {one.code for one in error.diagnostics} <= {"RSM001", "RSM002"}
        return False
    lines = data.splitlines(keepends=True)
    rest = b"".join(lines[result.line - 1 :])
    head = result.data[: len(result.data) - len(rest)]
    whole = b"".join(lines[: result.line - 1])
    lathe = settings.dialect.is_lathe
    was, calls = behind_the_mark(whole + _MARK + rest, lathe=lathe)
    now, again = behind_the_mark(head + _MARK + rest, lathe=lathe)
    assert calls == again
    for key in {*was, *now}:
        assert is_same(was.get(key), now.get(key), key), (key, was.get(key), now.get(key), head.decode())
    return True


@pytest.mark.parametrize("seed", short_where(range(8), lambda seed: seed % 2 == 0))
def test_random_programs_go_on(seed: int) -> None:
    data, lathe, _ = program(seed)
    settings = chipbreak.load("linuxcnc-lathe" if lathe else "linuxcnc-mill", ["planner.model=ideal"])
    if seed % 2:
        with contextlib.suppress(chipbreak.ProgramRejectedError):  # then it is started again as it is
            data = chipbreak.rewrite(data, settings, allow_unbroken=True).data
    count = data.count(b"\n")
    for line in Random(seed).sample(range(4, count), k=3):
        assert_goes_on(data, line, settings)


@pytest.mark.parametrize("share", [0.1, 0.95])
def test_the_sample_goes_on(share: float) -> None:
    settings = chipbreak.load("linuxcnc-lathe")
    data = chipbreak.rewrite((_SAMPLES / "linuxcnc-lathe.ngc").read_bytes(), settings).data
    assert assert_goes_on(data, int(data.count(b"\n") * share), settings)
