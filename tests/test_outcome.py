"""Whatever happens to a program becomes a value with the exit code of its kind."""

from __future__ import annotations

from typing import NoReturn

import pytest

import chipbreak
from chipbreak.outcome import DONE, FAILED, REJECTED, USAGE, internal_fault, outcome_of
from chipbreak.settings import load
from chipbreak.text.diagnostics import Diagnostic, Severity

NOT_AS_PROMISED = "error SLF001: the output failed its self-check: no end"
SAID = Diagnostic("VIB005", Severity.ERROR, "N is a whole number")


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (chipbreak.ProgramRejectedError([SAID]), REJECTED, SAID.render()),
        (chipbreak.SettingsError(SAID), USAGE, SAID.render()),
        (chipbreak.ToolFileError([SAID]), USAGE, SAID.render()),
        (
            chipbreak.SelfCheckError("no end"),
            FAILED,
            "error SLF001: the output failed its self-check: no end",
        ),
        (MemoryError(), FAILED, "error SLF002: not enough memory for this program"),
    ],
)
def test_what_goes_wrong(error: Exception, code: int, said: str) -> None:
    def work() -> NoReturn:
        raise error

    outcome = outcome_of(work)
    assert (outcome.code, outcome.result) == (code, None)
    assert [one.render().splitlines()[0] for one in outcome.diagnostics] == [said]


def test_what_goes_right() -> None:
    outcome = outcome_of(lambda: chipbreak.rewrite(b"G0 X1.\n", load("generic-lathe")))
    assert outcome.code == DONE
    assert outcome.result is not None
    assert outcome.result.data == b"G0 X1.\n"


def test_what_should_never_happen() -> None:
    assert internal_fault(ZeroDivisionError("by 0")).diagnostics[0].code == "SLF002"
