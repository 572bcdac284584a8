"""Commands about tools: what is known of them, and whether an edge is chipped."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chipbreak.options import (
    DIFFERENT,
    DONE,
    PROFILE,
    REJECTED,
    REPORTING,
    SET,
    TOOLS,
    USAGE,
    Asked,
    asking,
    settings_of,
)
from chipbreak.program_files import read_program
from chipbreak.streams import replace_file, say, write_json
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from chipbreak.inspection.edge_figure import EdgeCurves
    from chipbreak.inspection.edges import EdgeVerdict
    from chipbreak.settings.sections import Checks


@click.command()
@click.argument("before")
@click.argument("after")
@click.option(
    "--next",
    "next_kind",
    type=click.Choice(["rough", "finish"]),
    required=True,
    help="What the tool does next; it decides the limit W.",
)
@click.option("--tool", type=click.IntRange(0), metavar="N", help="Its number, for a limit of its own.")
@click.option("-o", "--output", metavar="OUT.svg", help="Write a figure.")
@asking(PROFILE, SET, *REPORTING)
def inspect(
    asked: Asked, before: str, after: str, next_kind: str, tool: int | None, output: str | None
) -> None:
    """Compare traced edges BEFORE and AFTER cutting, tooth by tooth.

    Both are CSV with the columns tooth,height_mm,radius_mm.  Exit 0: fine, 1: chipped, 2: trouble.
    """
    if output is not None and Path(output).suffix.lower() != ".svg":
        raise click.UsageError(
            f"{output}: figures are SVG, which any browser shows and converts; name it .svg"
        )
    edges = inspected_edges(asked, before, after, next_kind, tool)
    if output is not None:
        replace_file(Path(output), [edges.svg().encode()])
    _say(edges.verdicts, edges.heading, as_json=asked.as_json)
    sys.exit(DIFFERENT if edges.chipped else DONE)


class InspectedEdges(NamedTuple):
    """The edges of a tool before and after cutting: a verdict and the curves of each tooth."""

    heading: str
    limit_mm: float
    verdicts: dict[int, EdgeVerdict]
    curves: Sequence[EdgeCurves]

    @property
    def chipped(self) -> list[int]:
        """The teeth that are chipped."""
        return [tooth for tooth, verdict in self.verdicts.items() if verdict.is_chipped]

    def svg(self) -> str:
        """The figure of the edges."""
        from chipbreak.inspection.edge_figure import edge_figure

        found = (
            f"tooth {', '.join(map(str, self.chipped))} chipped" if self.chipped else "no tooth is chipped"
        )
        return edge_figure(self.curves, self.limit_mm, f"{self.heading.replace('limit ', '')}: {found}")


def inspected_edges(
    asked: Asked, before: str, after: str, next_kind: str, tool: int | None = None
) -> InspectedEdges:
    """Compare two files of traced edges; exits with 2 where they cannot be compared."""
    from chipbreak.settings.sections import Checks

    # The limits have defaults, so no machine is needed to judge an edge.
    needs_profile = asked.profile is not None or bool(asked.sets)
    checks = settings_of(asked, before).checks if needs_profile else Checks()
    limit_mm = _limit_mm(checks, next_kind, tool)
    stored, traced = _traces(before, after, asked)
    edges = {tooth: _judged(tooth, stored[tooth], traced[tooth], limit_mm, after) for tooth in stored}
    title = f"T{tool}, " if tool is not None else ""
    return InspectedEdges(
        f"{title}next {next_kind}, limit W {limit_mm:g} mm",
        limit_mm,
        {tooth: verdict for tooth, (verdict, _) in edges.items()},
        [curves for _, curves in edges.values()],
    )


def _traces(before: str, after: str, asked: Asked) -> tuple[dict[int, Any], dict[int, Any]]:
    """The points of both files by tooth; exits with 2 where they are not of the same teeth."""
    from chipbreak.tools.data import ToolFileError
    from chipbreak.tools.files import read_bytes
    from chipbreak.tools.lists import read_traces

    try:
        stored, traced = (read_traces(name, read_bytes(name)) for name in (before, after))
    except ToolFileError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(USAGE)
    if set(stored) != set(traced):
        odd = ", ".join(str(tooth) for tooth in sorted(set(stored) ^ set(traced)))
        raise click.UsageError(f"tooth {odd} is in one of {before} and {after} only")
    return stored, traced


def _limit_mm(checks: Checks, next_kind: str, tool: int | None) -> float:
    own = checks.w_mm.get(str(tool))
    if own is not None:
        return own
    return checks.w_rough_mm if next_kind == "rough" else checks.w_finish_mm


def _judged(
    tooth: int, stored: Any, traced: Any, limit_mm: float, name: str
) -> tuple[EdgeVerdict, EdgeCurves]:
    from chipbreak.inspection.edge_figure import EdgeCurves
    from chipbreak.inspection.edges import inward_mm, judge_edge, limit_line

    try:
        verdict = judge_edge(stored, traced, limit_mm)
    except ValueError as error:
        raise click.UsageError(f"{name}: tooth {tooth}: {error}") from None
    inward = inward_mm(stored, traced)
    line = limit_line(stored, limit_mm)
    return verdict, EdgeCurves(tooth, stored, traced, line, inward, verdict.is_chipped)


def _say(verdicts: dict[int, EdgeVerdict], heading: str, *, as_json: bool) -> None:
    if as_json:
        teeth = [
            {
                "tooth": tooth,
                "inward_mm": verdict.inward_mm,
                "height_mm": verdict.height_mm,
                "limit_mm": verdict.limit_mm,
                "chipped": verdict.is_chipped,
            }
            for tooth, verdict in verdicts.items()
        ]
        write_json({"chipped": any(v.is_chipped for v in verdicts.values()), "teeth": teeth})
        return
    say(heading)
    for tooth, verdict in verdicts.items():
        word = "CHIPPED" if verdict.is_chipped else "fine"
        inward = f"{verdict.inward_mm:z.4f} mm inward at height {verdict.height_mm:z.3f} mm"
        say(f"  tooth {tooth}: {inward}, {word}")


@click.command()
@click.argument("source", metavar="[INPUT]", default="-")
@asking(TOOLS, PROFILE, SET, *REPORTING)
def tools(asked: Asked, source: str) -> None:
    """Show what is known about the tools of a program, who said it, and what a check lacks."""
    from chipbreak.api import tool_table
    from chipbreak.text.diagnostics import ProgramRejectedError
    from chipbreak.tools.data import ToolFileError
    from chipbreak.tools.program import table_json, table_text

    settings = settings_of(asked, source)
    name = "<stdin>" if source == "-" else source
    program = read_program(source)
    try:
        table = tool_table(program.data, settings, name, beside=program.beside)
    except ProgramRejectedError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(REJECTED)
    except ToolFileError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(USAGE)
    if asked.as_json:
        write_json(table_json(table), indent=2)
        return
    asked.reporter.show(table.diagnostics)
    for line in table_text(table):
        say(line)
