"""The command that starts a program again in its middle."""

from __future__ import annotations

import sys

import click

from chipbreak.options import (
    BESIDE,
    PROFILE,
    REJECTED,
    REPORTING,
    SET,
    Asked,
    asking,
    settings_of_filtered,
    shown,
)
from chipbreak.program_files import ProgramFile, read_program, write_program


@click.command("resume")
@click.argument("source", metavar="PROGRAM", type=click.Path(allow_dash=True))
@click.option(
    "-n", "--line", type=click.IntRange(min=1), required=True, help="Of the file, as an editor counts them."
)
@click.option("-o", "--output", metavar="OUT", help="Write to this file, replaced in one step.")
@asking(PROFILE, SET, BESIDE, *REPORTING)
def resume(asked: Asked, source: str, line: int, output: str | None) -> None:
    """Write the program that goes on from a line of PROGRAM, filtered or not.

    A start block says tool, offsets, modes, S, coolant and where the tool stood; the rest is as it is.
    It begins at the line, or at the last one before at which that is safe: outside cuts, cycles, loops and
    what chipbreak wrote.  Clear the tool by hand first: the start block goes home, then to that place.
    """
    from chipbreak.restart.resume import resume as resumed
    from chipbreak.text.diagnostics import ProgramRejectedError

    program = read_program(source, asked.beside if source == "-" else None)
    settings = settings_of_filtered(asked, source, program)
    try:
        result = resumed(program.data, settings, line, shown(source), beside=program.beside)
    except ProgramRejectedError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(REJECTED)
    except ValueError as error:
        raise click.UsageError(str(error)) from None
    asked.reporter.show(result.diagnostics)
    write_program(output, ProgramFile(result.data, result.beside), asked.beside)
