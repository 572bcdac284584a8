"""Commands that measure a machine: the program that it runs, and the profile that comes of it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import click

from chipbreak.options import PROFILE, REPORTING, SET, USAGE, Asked, asking, settings_of
from chipbreak.streams import replace_file, replace_files, write_json
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_there

if TYPE_CHECKING:
    from chipbreak.machine_test.findings import Findings
    from chipbreak.text.diagnostics import RefusalError

_LEAST_FEED_MM_MIN = 300.0
_CLOCK_ERROR_MS = 1.0
_HAND_ERROR_MS = 100.0


@click.group("machine-test")
def machine_test() -> None:
    """Measure a machine: a short air cut, and what its times or a trace of it say."""


@machine_test.command("write")
@click.option("-o", "--output", metavar="PROGRAM", required=True, help="The program; the form is beside it.")
@click.option("--axes", metavar="XZ", help="The axes to test: X and Z of a lathe, else X, Y and Z.")
@click.option(
    "--travel",
    type=click.FloatRange(5.0, 1000.0),
    default=10.0,
    show_default=True,
    help="How far each axis goes in plus direction, mm.",
)
@click.option(
    "--feed", type=click.FloatRange(_LEAST_FEED_MM_MIN, 60000.0), help="The highest F, mm/min; usually 3000."
)
@click.option(
    "--repeats",
    type=click.IntRange(1, 100),
    help="How often each group is done in a row: 1, or 10 where the times are taken by hand.",
)
@click.option("--force", is_flag=True, help="Replace files that are there.")
@asking(PROFILE, SET, *REPORTING)
def write(
    asked: Asked,
    output: str,
    axes: str | None,
    travel: float,
    feed: float | None,
    repeats: int | None,
    force: bool,
) -> None:
    """Write a program that moves in air, and beside it a form for the times.

    It starts where the tool is, goes in plus direction only, by at most --travel, and comes back.  No spindle
    turns.  On a control whose programs read a clock the times are left in variables.
    """
    from chipbreak.machine_test.form import form_text
    from chipbreak.machine_test.groups import groups_for, usual_axes, usual_feed_mm_min
    from chipbreak.machine_test.program import program_text, variables_for
    from chipbreak.text.diagnostics import RefusalError
    from chipbreak.trajectory.law_names import LAW_KEYS

    settings = settings_of(asked, "-")
    letters = (axes or usual_axes(settings)).upper()
    if not letters or set(letters) - set("XYZ") or len(set(letters)) < len(letters):
        raise click.UsageError("--axes takes letters of X, Y and Z, each once")
    target = Path(output)
    form = target.with_suffix(".toml")
    if form == target:
        raise click.UsageError("the program must not end in .toml: its form does")
    for file in (target, form):
        if is_there(file) and not force:
            raise click.UsageError(f"{file} is there already: give another name, or --force to replace it")
    # Where no clock times a group and no record of the motion is usual, a hand with a watch does.
    has_record = "max_feed_override" in LAW_KEYS[settings.planner.model]
    count = repeats or (1 if settings.dialect.clock or has_record else 10)
    highest = feed or usual_feed_mm_min(settings, letters)
    if highest < _LEAST_FEED_MM_MIN:
        message = (
            f"the slowest of {letters} makes {highest:g} mm/min (axes.*.max_velocity_mm_min), and a test"
        )
        raise click.UsageError(f"{message} needs {_LEAST_FEED_MM_MIN:g}: give others with --axes")
    groups = groups_for(letters, travel, highest, count)
    variables = variables_for(settings, groups)
    try:
        text = program_text(settings, groups, variables)
    except RefusalError as error:
        _refuse(asked, error)
    error_ms = _CLOCK_ERROR_MS if variables else _HAND_ERROR_MS
    profile = asked.profile or settings.name
    said = form_text(profile, target.name, groups, variables, error_ms).encode()
    replace_files({target: text.encode("ascii", "replace"), form: said})
    if not asked.quiet:
        told = f"{target}: {len(groups)} groups of {letters}; {form}: the form for their times"
        click.echo(escaped(told), err=True)


@machine_test.command("read")
@click.argument("form", metavar="FORM.toml", type=click.Path())
@click.option("--trace", metavar="CSV", type=click.Path(), help="A record of time and places of the axes.")
@click.option(
    "--columns",
    metavar="NAMES",
    help="What the columns of the trace are, such as time_ms,x_um,z_um; - for one that does not count.",
)
@click.option("-o", "--output", metavar="PROFILE.toml", help="Write the profile there; else to stdout.")
@click.option("--force", is_flag=True, help="Replace PROFILE.toml if it is there.")
@asking(PROFILE, SET, *REPORTING)
def read(
    asked: Asked, form: str, trace: str | None, columns: str | None, output: str | None, force: bool
) -> None:
    """Make a profile of the times in a form, or of a trace.

    It finds the law of control and its numbers, each with how uncertain it is, and says what the data cannot
    tell.  The profile builds on the one that wrote the form, or on -p.
    """
    from chipbreak.machine_files.found import profile_text
    from chipbreak.machine_test.findings import findings_of
    from chipbreak.machine_test.form import read_form
    from chipbreak.machine_test.trace import pieces_of, read_trace
    from chipbreak.text.diagnostics import RefusalError

    if output is not None and is_there(output) and not force:
        raise click.UsageError(f"{output} is there already: give another name, or --force to replace it")
    try:
        filled = read_form(form)
        settings = settings_of(asked._replace(profile=asked.profile or filled.profile), form)
        pieces = pieces_of(read_trace(trace, columns), filled.groups) if trace is not None else []
        findings = findings_of(filled, pieces, settings)
    except RefusalError as error:
        _refuse(asked, error)
    title = f"Machine profile, measured by chipbreak machine-test with {Path(form).name}."
    text = profile_text(findings.machine(asked.profile or filled.profile), title)
    _give(asked, findings, text, output)


def _give(asked: Asked, findings: Findings, text: str, output: str | None) -> None:
    if asked.as_json:
        write_json(findings.values(), indent=2)
    elif output is None:
        click.echo(text, nl=False)
    if output is not None:
        replace_file(Path(output), [text.encode("utf-8", "replace")])
    if not asked.quiet and not asked.as_json:
        for line in findings.lines():
            click.echo(escaped(line), err=True)


def _refuse(asked: Asked, error: RefusalError) -> NoReturn:
    from chipbreak.text.diagnostics import Diagnostic, Severity

    asked.reporter.show([Diagnostic(error.code, Severity.ERROR, error.message, error.help)])
    sys.exit(USAGE)
