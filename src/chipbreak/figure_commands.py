"""Commands that draw: one figure of a cut, and the report of a whole program as a page."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

from chipbreak.options import READING, USAGE, Asked, asking, run_filter, settings_of
from chipbreak.program_files import read_program
from chipbreak.streams import replace_file

_T = TypeVar("_T")
_OF_CUT = ("chips", "thickness", "speeds", "ramp")


@click.command()
@click.argument("source", metavar="[INPUT]", default="-", type=click.Path(allow_dash=True))
@click.option(
    "-o",
    "--output",
    metavar="FILE.svg|png|pdf",
    required=True,
    type=click.Path(),
    help="Write the figure here; its suffix says which kind.",
)
@click.option(
    "-f",
    "--figure",
    type=click.Choice((*_OF_CUT, "times")),
    default="chips",
    show_default=True,
    help="Path of the edge, thickness of the chip, S and N, begin and end, or the times of all cuts.",
)
@click.option(
    "-c", "--cut", "number", type=click.IntRange(1), default=1, metavar="N", help="Of which vibrated cut."
)
@asking(*READING)
def plot(asked: Asked, source: str, output: str, figure: str, number: int) -> None:
    """Draw a vibrated cut as the filtered program runs it."""
    from chipbreak.figures.of_run import figure_of_times, figures_of_cut
    from chipbreak.figures.style import KINDS, kind_of
    from chipbreak.report.build import report_of
    from chipbreak.text.diagnostics import RefusalError

    kind = kind_of(output)
    if kind is None:
        raise click.UsageError(f"{output}: name it .{', .'.join(KINDS)}")
    settings = settings_of(asked, source)
    result = run_filter(read_program(source), settings, source, asked)
    asked.reporter.show(result.diagnostics)

    def draw() -> bytes:
        if figure != "times":
            drawn = {one.name: one for one in figures_of_cut(result, settings, number)}
            return drawn[figure].file(kind)
        times = figure_of_times(report_of(result, settings))
        if times is None:
            raise RefusalError("FIG003", "no cut's time is known", "only vibrated cuts are timed")
        return times.file(kind)

    replace_file(Path(output), [_or_usage(asked, draw)])


@click.command()
@click.argument("source", metavar="[INPUT]", default="-", type=click.Path(allow_dash=True))
@click.option(
    "-o", "--output", metavar="FILE.html", required=True, type=click.Path(), help="Write the page here."
)
@click.option(
    "--edges",
    type=(click.Path(), click.Path(), click.Choice(["rough", "finish"])),
    multiple=True,
    metavar="BEFORE AFTER rough|finish",
    help="Traced edges of a tool and what it does next, drawn against the limit line as 'inspect' does.",
)
@asking(*READING)
def report(asked: Asked, source: str, output: str, edges: tuple[tuple[str, str, str], ...]) -> None:
    """Write all that is said of a program as one HTML page with figures.

    The page needs nothing but itself, has no scripts, and prints.
    """
    from chipbreak.page.of_run import page_of_run
    from chipbreak.tool_commands import inspected_edges

    settings = settings_of(asked, source)
    result = run_filter(read_program(source), settings, source, asked)
    asked.reporter.show(result.diagnostics)
    figures = [inspected_edges(asked, *one).svg() for one in edges]
    page = _or_usage(asked, lambda: page_of_run(result, settings, figures))
    replace_file(Path(output), [page.encode("utf-8", "replace")])


def _or_usage(asked: Asked, draw: Callable[[], _T]) -> _T:
    """What is drawn; says why nothing can be and exits with 2."""
    from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity

    try:
        return draw()
    except RefusalError as error:
        asked.reporter.show([Diagnostic(error.code, Severity.ERROR, error.message, error.help)])
        sys.exit(USAGE)
