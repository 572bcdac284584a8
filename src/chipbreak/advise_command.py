"""The command that says which conditions break the chips of a cut on a machine."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from chipbreak.options import PROFILE, REJECTED, REPORTING, SET, USAGE, Asked, asking, settings_of
from chipbreak.streams import replace_file, say, write_json

if TYPE_CHECKING:
    from chipbreak.advise.of_cut import Advice
    from chipbreak.settings import Settings

_LENGTH = click.FloatRange(min=0.0, min_open=True, max=1e5)


@click.command()
@click.option("--feed", type=click.FloatRange(0.0, 100.0, min_open=True), required=True, help="mm/rev.")
@click.option("--diameter", type=_LENGTH, required=True, help="At the start of the cut, mm.")
@click.option("--length", type=_LENGTH, required=True, help="Of the cut, mm.")
@click.option("--speed", type=click.FloatRange(0.0, 1e6, min_open=True), metavar="RPM", help="S in rpm.")
@click.option(
    "--surface", type=click.FloatRange(0.0, 1e5, min_open=True), metavar="M_MIN", help="V in m/min instead."
)
@click.option("--edges", type=click.IntRange(1, 20), default=1, show_default=True, help="Cutting edges.")
@click.option(
    "--axis",
    type=click.Choice(["Z", "X"]),
    default="Z",
    show_default=True,
    help="Z turns or drills along the spindle, X faces towards it.",
)
@click.option("--rows", type=click.IntRange(1, 40), default=8, show_default=True, help="At most so many.")
@click.option(
    "-o", "--output", metavar="FILE.svg|png|pdf", type=click.Path(), help="Draw S and N with these rows."
)
@asking(PROFILE, SET, *REPORTING)
def advise(
    asked: Asked,
    feed: float,
    diameter: float,
    length: float,
    speed: float | None,
    surface: float | None,
    edges: int,
    axis: str,
    rows: int,
    output: str | None,
) -> None:
    """Say which N, f, S and stroke break the chips of a cut on this machine, the best first.

    Every row is tried: it is what the verdict says of a program with this cut.  The first is what
    vibration.n = "auto" takes.  Exit 3: nothing breaks these chips within the limits of the machine.
    """
    from chipbreak.advise.as_text import advice_lines, advice_values
    from chipbreak.advise.of_cut import CutAsked, advice_for
    from chipbreak.text.diagnostics import ProgramRejectedError

    if (speed is None) == (surface is None):
        raise click.UsageError("give one of --speed and --surface")
    rpm = speed if speed is not None else round(1000.0 * (surface or 0.0) / (math.pi * diameter))
    if rpm <= 0.0:
        raise click.UsageError("--surface at this diameter is no speed that a spindle can turn")
    cut = CutAsked(feed, diameter, length, rpm, edges, axis)
    settings = settings_of(asked, "-")
    if output is not None:
        _check_kind(output)
    try:
        advice = advice_for(cut, settings, rows)
    except ProgramRejectedError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(REJECTED)
    if asked.as_json:
        write_json(dict(advice_values(advice)), indent=2)
    else:
        for line in advice_lines(advice):
            say(line)
    if output is not None:
        _draw(asked, output, advice, settings)


def _check_kind(output: str) -> None:
    from chipbreak.figures.style import KINDS, kind_of

    if kind_of(output) is None:
        raise click.UsageError(f"{output}: name it .{', .'.join(KINDS)}")


def _draw(asked: Asked, output: str, advice: Advice, settings: Settings) -> None:
    from chipbreak.figures.conditions import figure_of_advice
    from chipbreak.figures.style import kind_of
    from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity

    try:
        data = figure_of_advice(advice, settings, kind_of(output) or "svg")
    except RefusalError as error:
        asked.reporter.show([Diagnostic(error.code, Severity.ERROR, error.message, error.help)])
        sys.exit(USAGE)
    replace_file(Path(output), [data])
