"""What became of one program, whatever happened: an exit code, what was said, and perhaps a result."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, SelfCheckError, Severity
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from chipbreak.pipeline import Result

DONE = 0
DIFFERENT = 1
USAGE = 2
REJECTED = 3
FAILED = 4

_INTERNAL = "SLF002"
_REPORT_IT = "nothing was written; please report this with the program"


class Outcome(NamedTuple):
    """``code`` is the exit code of a run of its own; ``result`` is there when that is :data:`DONE`."""

    code: int
    diagnostics: tuple[Diagnostic, ...]
    result: Result | None = None


def outcome_of(work: Callable[[], Result]) -> Outcome:
    """Run, and turn what the program, the profile or we have done wrong into an outcome."""
    from chipbreak.settings import SettingsError
    from chipbreak.tools.data import ToolFileError

    try:
        result = work()
    except ProgramRejectedError as error:
        return Outcome(REJECTED, error.diagnostics)
    except ToolFileError as error:
        return Outcome(USAGE, tuple(error.diagnostics))
    except SettingsError as error:
        return Outcome(USAGE, (error.diagnostic,))
    except SelfCheckError as error:
        return failed("SLF001", f"the output failed its self-check: {error}")
    except MemoryError:
        return failed(_INTERNAL, "not enough memory for this program")
    return Outcome(DONE, result.diagnostics, result)


def failed(code: str, message: str, help_text: str = _REPORT_IT) -> Outcome:
    """The outcome of a fault of ours."""
    return Outcome(FAILED, (Diagnostic(code, Severity.ERROR, message, help_text),))


def internal_fault(error: Exception) -> Outcome:
    """The outcome of what should never happen, for those who must go on all the same."""
    return failed(_INTERNAL, f"internal fault, {type(error).__name__}: {error}")
