"""The page of a run: what vibrates, what was left and why, the checks, the times, the figures of each cut."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from html import escape

from chipbreak.figures.of_run import CHIPS, RAMP, SPEEDS, THICKNESS, figure_of_times, figures_of_cuts
from chipbreak.figures.times import cut_names
from chipbreak.page.figure_text import inline
from chipbreak.page.style import STYLE
from chipbreak.pipeline import Result
from chipbreak.report.build import report_of
from chipbreak.report.model import ExplainedCut, Report
from chipbreak.settings import Settings
from chipbreak.text.encoding import escaped
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN

# So many cuts are drawn; of cuts that are alike the first.
_MOST_DRAWN = 12
_CAPTIONS = {
    CHIPS: "The work unrolled: each line is the way of the edge over one turn of the spindle. Where it comes"
    " back to the line before, it cuts air, and the chip is off.",
    THICKNESS: "The same over time. At 0 nothing is cut; from one 0 to the next is one chip.",
    SPEEDS: "Each curve is a frequency that the control can command. In a band, the stroke of this cut is"
    " large enough to break chips; on whole numbers none is.",
    RAMP: "The cut starts and ends exactly where it was programmed: the stroke grows from nothing, and the"
    " last turn is plain feed.",
}


class _Run(NamedTuple):
    """What the parts of the page are made of."""

    report: Report
    result: Result
    settings: Settings
    edges: Sequence[str]


def page_of_run(result: Result, settings: Settings, edges: Sequence[str] = ()) -> str:
    """One HTML page without scripts, that needs nothing but itself.

    ``edges`` are SVG figures of inspected tools.  Errors: FIG001 without matplotlib.
    """
    run = _Run(report_of(result, settings), result, settings, edges)
    body = "\n".join(part for rule in _PARTS for part in rule(run))
    title = _text(f"{run.report.file} - what vibrates, and why")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _text(text: str) -> str:
    return escape(escaped(text))


def _head(run: _Run) -> Iterator[str]:
    report = run.report
    yield f"<h1>{_text(report.file)}</h1>"
    yield f'<p class="lead">{_text(report.summary())}</p>'
    control = f"Control: {run.settings.dialect.title}, profile {report.profile}."
    yield f'<p class="about">{_text(control)}</p>'


def _findings(run: _Run) -> Iterator[str]:
    if not run.report.diagnostics:
        return
    yield "<h2>Said on the way</h2>\n<ul>"
    for one in run.report.diagnostics:
        where = f"line {one.place.line}: " if one.place else ""
        way_out = f'<br><span class="about">{_text(one.help)}</span>' if one.help else ""
        yield (
            f'<li class="{one.severity.value}"><b>{one.severity.value} {one.code}</b> '
            f"{_text(where + one.message)}{way_out}</li>"
        )
    yield "</ul>"


def _times(run: _Run) -> Iterator[str]:
    drawn = figure_of_times(run.report)
    if drawn is not None:
        yield f"<h2>Time before and after</h2>\n<figure>{inline(drawn, 'times')}</figure>"


def _cuts(run: _Run) -> Iterator[str]:
    names = cut_names(run.report.cuts)
    rows = [
        [name.removeprefix("line "), *(of(cut) for _, of in _COLUMNS)]
        for name, cut in zip(names, run.report.cuts, strict=True)
    ]
    yield from _table("Vibrated cuts", ["line", *(name for name, _ in _COLUMNS)], rows)


def _drawn_cuts(run: _Run) -> Iterator[str]:
    """The figures of each cut that is unlike those before it."""
    numbers = _unlike(run.report.cuts)
    drawn = numbers[:_MOST_DRAWN]
    figures_of = figures_of_cuts(run.result, run.settings, run.report, drawn)
    # Not strict: the motion of the cuts behind the last of these is not asked for.
    for number, pictures in zip(drawn, figures_of, strict=False):
        cut = run.report.cuts[number - 1]
        lines = (
            f"s {cut.first_line} to {cut.last_line}"
            if cut.last_line > cut.first_line
            else f" {cut.first_line}"
        )
        yield f'<section class="cut"><h2>Line{lines}</h2>'
        yield f"<pre>{_text(cut.block)}</pre>"
        if cut.reasons:
            yield "<ul>" + "".join(f"<li>{_text(reason)}</li>" for reason in cut.reasons) + "</ul>"
        figures = {one.name: one for one in pictures}
        for name, caption in _CAPTIONS.items():
            figure = inline(figures[name], f"cut{number}-{name}")
            yield f"<figure>{figure}<figcaption>{caption}</figcaption></figure>"
        yield "</section>"
    others = len(run.report.cuts) - min(len(numbers), _MOST_DRAWN)
    if others:
        why = "they are like these, or there are too many"
        more = "1 more cut is" if others == 1 else f"{others} more cuts are"
        yield f'<p class="about">{more} not drawn: {why}.</p>'


def _unlike(cuts: Sequence[ExplainedCut]) -> list[int]:
    """Numbers of the cuts, from 1, that differ from all before them in what a figure would show."""
    seen: dict[tuple[object, ...], int] = {}
    for number, cut in enumerate(cuts, 1):
        key = (
            round(cut.speed_rpm),
            round(cut.per_rev, 3),
            round(cut.feed_mm_rev, 4),
            round(cut.stroke_mm, 3),
            cut.waveform,
        )
        seen.setdefault(key, number)
    return list(seen.values())


def _left(run: _Run) -> Iterator[str]:
    rows = [(str(cut.first_line), cut.block, cut.reason, cut.way_out) for cut in run.report.left]
    yield from _table("Left as they were", ("line", "block", "because", "way out"), rows)


def _operations(run: _Run) -> Iterator[str]:
    rows = [
        (
            "" if one.tool is None else f"T{one.tool}",
            one.kind,
            f"{one.first_line} to {one.last_line}",
            one.reason,
        )
        for one in run.report.operations
    ]
    yield from _table("Operations", ("tool", "kind", "lines", "because"), rows)


def _checks(run: _Run) -> Iterator[str]:
    rows = [
        ("at the end" if one.is_at_end else f"before line {one.line}", one.title, one.reason)
        for one in run.report.checks
    ]
    yield from _table("Tool checks", ("where", "check", "because"), rows)


def _table(title: str, names: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """A table under its title; nothing where it has no rows."""
    if not rows:
        return
    yield f'<h2>{title}</h2>\n<div class="wide"><table>\n<thead><tr>'
    yield "".join(f"<th>{_text(name)}</th>" for name in names) + "</tr></thead>\n<tbody>"
    for row in rows:
        yield "<tr>" + "".join(f"<td>{_text(cell)}</td>" for cell in row) + "</tr>"
    yield "</tbody></table></div>"


def _edges(run: _Run) -> Iterator[str]:
    if run.edges:
        yield "<h2>Edges against their limit line</h2>"
        yield from (f"<figure>{svg}</figure>" for svg in run.edges)


def _assumed(run: _Run) -> Iterator[str]:
    """On what the verdicts rest."""
    laws = sorted({cut.control for cut in run.report.cuts})
    if laws:
        yield "<h2>What this rests on</h2>"
        yield f"<p>Motion and times are those of the planner model {_text(', '.join(laws))} with the numbers"
        yield " of the profile; the chips are judged from the moves as the filtered program has them.</p>"
    if any(cut.unproven for cut in run.report.cuts):
        yield "<p>That chips break is <b>unproven</b>: the profile does not say what the axes can do, and it"
        yield " holds only on a control that follows the blocks exactly.</p>"


def _chips(cut: ExplainedCut) -> str:
    if not cut.verdict.breaks:
        return "DO NOT BREAK"
    return "would break (unproven)" if cut.unproven else "break"


def _seconds(value: float | None) -> str:
    return "" if value is None else f"{value:z.1f}"


_COLUMNS: tuple[tuple[str, Callable[[ExplainedCut], str]], ...] = (
    ("S [rpm]", lambda cut: f"{cut.speed_rpm:g}"),
    ("N", lambda cut: f"{cut.verdict.per_rev or cut.per_rev:.4g}"),
    ("f [Hz]", lambda cut: f"{cut.frequency_hz:.4g}"),
    ("feed [mm/rev]", lambda cut: f"{cut.feed_mm_rev:.4g}"),
    ("stroke [mm]", lambda cut: f"{cut.stroke_mm:.4g}"),
    ("chips", _chips),
    ("margin", lambda cut: f"{cut.verdict.margin:z.2f}"),
    ("longest chip [rev]", lambda cut: f"{cut.verdict.longest_chip_rev:z.2f}"),
    ("axis [mm/min]", lambda cut: f"{cut.verdict.peak_speed_mm_s * S_PER_MIN:z.0f}"),
    ("needs [mm/s2]", lambda cut: f"{cut.acceleration_mm_s2:z.0f}"),
    ("time before [s]", lambda cut: _seconds(cut.programmed_s)),
    ("now [s]", lambda cut: _seconds(cut.duration_s)),
)
_PARTS: tuple[Callable[[_Run], Iterator[str]], ...] = (
    _head,
    _findings,
    _cuts,
    _times,
    _left,
    _drawn_cuts,
    _checks,
    _edges,
    _operations,
    _assumed,
)
