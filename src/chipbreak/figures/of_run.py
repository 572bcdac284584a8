"""All figures of a run: by name, each as a file or as a part of a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from chipbreak.api import motions
from chipbreak.figures.cut_data import DrawnCut
from chipbreak.figures.of_cut import chip_pattern, chip_thickness, ramp
from chipbreak.figures.speeds import SpeedChart, SpeedPoint, speed_chart
from chipbreak.figures.style import Draw, picture
from chipbreak.figures.times import cut_times, height_inch
from chipbreak.pipeline import Result
from chipbreak.report.build import report_of
from chipbreak.report.model import ExplainedCut, Report
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.measure import CutMotion
from chipbreak.vibration.plan import command_group

# What can be drawn of a cut, and of a program.
CHIPS, THICKNESS, SPEEDS, RAMP, TIMES = "chips", "thickness", "speeds", "ramp", "times"
OF_CUT = (CHIPS, THICKNESS, SPEEDS, RAMP)
_WIDE = (7.6, 3.2)
_NO_CUT = "FIG002"


class Drawn(NamedTuple):
    """A figure: its name, what it is of, and how it is drawn at which size [inch]."""

    name: str
    title: str
    draw: Draw
    size_inch: tuple[float, float] = _WIDE

    def file(self, kind: str) -> bytes:
        """The figure as a file.  Errors: FIG001 without matplotlib."""
        return picture(self.draw, kind, self.size_inch)


def figures_of_cut(result: Result, settings: Settings, number: int) -> list[Drawn]:
    """The figures of one vibrated cut; ``number`` counts from 1.  Errors: FIG002 for no such cut."""
    report = report_of(result, settings)
    count = len(report.cuts)
    if not 1 <= number <= count:
        way_out = f"the program has cuts 1 to {count}" if count else "only vibrated cuts can be drawn"
        raise RefusalError(_NO_CUT, f"there is no vibrated cut {number} in {report.file}", way_out)
    return next(figures_of_cuts(result, settings, report, [number]))


def figures_of_cuts(
    result: Result, settings: Settings, report: Report, numbers: Sequence[int]
) -> Iterator[list[Drawn]]:
    """The figures of each of some vibrated cuts; ``numbers`` count from 1 and rise.

    The program is read once for all.
    """
    asked = frozenset(numbers)
    for number, motion in enumerate(motions(result, settings), 1):
        if number in asked:
            yield _figures(result, settings, report.cuts[number - 1], number - 1, motion)


def _figures(
    result: Result, settings: Settings, told: ExplainedCut, index: int, motion: CutMotion
) -> list[Drawn]:
    cut = DrawnCut(told, motion, result.cuts[index].plan.edges)
    chart = _chart(result, settings, index, told)
    return [
        Drawn(CHIPS, "chip pattern", partial(chip_pattern, cut=cut)),
        Drawn(THICKNESS, "chip thickness", partial(chip_thickness, cut=cut), (7.6, 2.6)),
        Drawn(SPEEDS, "S and N", partial(speed_chart, chart=chart)),
        Drawn(RAMP, "ramp", partial(ramp, cut=cut), (7.6, 2.4)),
    ]


def _chart(result: Result, settings: Settings, index: int, told: ExplainedCut) -> SpeedChart:
    plan = result.cuts[index].plan
    given = {key: value.value for key, value in told.given.items()}
    speed_rpm = given.get("S")
    programmed = None
    if speed_rpm is not None:
        wished = given.get("N") or (60.0 * given["F"] / speed_rpm if "F" in given else told.per_rev)
        programmed = SpeedPoint(speed_rpm, wished)
    return SpeedChart(
        group=command_group(settings),
        waveform=told.waveform,
        alpha_share=told.alpha_share,
        edges=plan.edges,
        stroke_ratio=told.stroke_mm / told.feed_mm_rev,
        chosen=SpeedPoint(told.speed_rpm, told.per_rev),
        programmed=programmed,
    )


def figure_of_times(report: Report) -> Drawn | None:
    """Times before and after; None where no cut's time was known before."""
    cuts: Sequence[ExplainedCut] = [cut for cut in report.cuts if cut.programmed_s is not None]
    if not cuts:
        return None
    return Drawn(TIMES, "time", partial(cut_times, cuts=cuts), (7.6, height_inch(cuts)))
