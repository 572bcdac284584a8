"""What other programs call: bytes and settings in, values out.  :mod:`chipbreak` offers all of it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from chipbreak.editing.beside import with_brackets
from chipbreak.editing.diff import Hunk, compare, items_of
from chipbreak.editing.restore import restore as put_back
from chipbreak.macros import check_axes, macro_files
from chipbreak.macros.parameters import MacroSettings
from chipbreak.model.from_source import interpret_source
from chipbreak.pipeline import Result, interpreted_of, rewrite, verify_filtered
from chipbreak.report.build import report_of
from chipbreak.report.model import Report
from chipbreak.self_check import written_edits
from chipbreak.settings import Settings, SettingsError
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, RefusalError
from chipbreak.tools import files
from chipbreak.tools.data import ToolData
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.program import tool_table as table_of

if TYPE_CHECKING:
    from chipbreak.vibration.measure import CutMotion


def check(
    data: bytes,
    settings: Settings,
    name: str = "<stdin>",
    *,
    beside: bytes | None = None,
    allow_unbroken: bool = False,
) -> tuple[Diagnostic, ...]:
    """All that is to be said of a program, in the order of its lines; nothing is written.

    A program with an error in it does not raise: its errors are among what is given.  Raises SelfCheckError,
    SettingsError and ToolFileError as :func:`rewrite` does.
    """
    try:
        return rewrite(data, settings, name, beside=beside, allow_unbroken=allow_unbroken).diagnostics
    except ProgramRejectedError as error:
        return error.diagnostics


def verify(data: bytes, settings: Settings, name: str = "<stdin>", *, beside: bytes | None = None) -> Result:
    """Judge a filtered program as it stands, instead of writing a new one.

    Cuts that do not break their chips do not raise: see ``verdict.breaks`` of the result's ``cuts``.  Raises
    what :func:`rewrite` raises; SelfCheckError also for a program that another profile or version has
    written, whose changes are not those that would be made now.
    """
    return verify_filtered(data, settings, name, beside=beside)


def restore(data: bytes, name: str = "<stdin>", *, beside: bytes | None = None) -> bytes:
    """The original bytes from a filtered program; other programs come back as they are.

    ``beside`` is the file beside a program whose brackets were left out of it.  Raises ProgramRejectedError
    for a filtered part, or such a program, that somebody has edited.
    """
    return put_back(with_brackets(data, name, beside)).data


def explain(
    program: bytes | Result, settings: Settings, name: str = "<stdin>", *, beside: bytes | None = None
) -> Report:
    """What a run did and why: each vibrated cut, operation and check, lengths in mm, times in s.

    ``program`` is what :func:`rewrite` takes, or what it gave.  ``str()`` of the report is the text that
    ``chipbreak explain`` prints, ``as_dict()`` its JSON.  Raises what :func:`rewrite` raises.
    """
    result = program if isinstance(program, Result) else rewrite(program, settings, name, beside=beside)
    return report_of(result, settings)


def motions(result: Result, settings: Settings) -> Iterator[CutMotion]:
    """How each of the result's ``cuts`` runs on its control, one at a time: ``time_s`` and ``distance_mm``.

    They are read from the new program again, with the ``settings`` of the run, because the motion of a long
    program takes more memory than the program.
    """
    from chipbreak.vibration.cut_edit import VibratedCut

    if not result.cuts:
        return
    interpreted = interpreted_of(result, settings)
    for written in written_edits(interpreted, result.bracketed, result.edits):
        promise = written.edit.promise
        if isinstance(promise, VibratedCut):
            yield from promise.motions(written)


def diff(
    a: bytes,
    b: bytes,
    settings: Settings | None = None,
    *,
    ignore_comments: bool = False,
    tolerance: float = 0.0,
) -> list[Hunk]:
    """Two programs compared by what their blocks say, as alternating equal and changed stretches.

    With ``settings`` numbers are read as that control reads them; without, X50 and X50. are different.
    Lengths and angles that differ by at most ``tolerance``, in units of the programs, are the same.  Raises
    ProgramRejectedError for a filtered part that somebody has edited.
    """
    sides = [
        items_of(data, name, settings, ignore_comments=ignore_comments) for data, name in ((a, "a"), (b, "b"))
    ]
    return compare(*sides, tolerance=tolerance)


def read_tools(path: str | os.PathLike[str], *, mm_per_unit: float = 1.0) -> list[ToolData]:
    """The tools of a file of a CAM system or of your own, by the end of its name; lengths in mm.

    ``mm_per_unit`` is that of a LinuxCNC tool table, which does not say its unit.  Raises ToolFileError.
    """
    name = os.fspath(path)
    return files.read_tools(name, files.read_bytes(name), (mm_per_unit, f"{mm_per_unit:g} mm a unit"))


def tool_table(
    data: bytes, settings: Settings, name: str = "<stdin>", *, beside: bytes | None = None
) -> ToolTable:
    """All that is known about the tools of a program: from the files of ``[tools]``, then from its comments.

    Raises ProgramRejectedError for a filtered part that somebody has edited, ToolFileError for a file that
    cannot be used.
    """
    return table_of(interpret_source(put_back(with_brackets(data, name, beside)), settings))


def macro_programs(settings: Settings) -> dict[str, bytes]:
    """The programs that the tool checks call, by file name.

    Raises SettingsError for a control without macros, and for settings that lack what nobody may guess.
    """
    try:
        check_axes(settings.axis_words)
        return macro_files(settings.dialect, MacroSettings.of(settings))
    except RefusalError as error:
        raise SettingsError.of(error, settings.name) from None
