"""The conditions under which a machine breaks the chips of a cut, the best first, each tried as a program.

A program with this one cut is filtered with every choice, and what stands here is what its verdict says.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from chipbreak.kinematics.conditions import Conditions
from chipbreak.model.from_source import interpret_source
from chipbreak.pipeline import Result, rewrite
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import ProgramRejectedError, SelfCheckError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import read
from chipbreak.trajectory.ideal import Ideal
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.choice import Chooser
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.measure import CutReport
from chipbreak.vibration.request import AUTO, requests_of

_CLEAR_MM = 2.0
_NEAR_COUNT = 0.15
_NEAR_SPEED = 0.04
_TRIES_A_ROW = 3


class CutAsked(NamedTuple):
    """A cut: feed [mm/rev], diameter at its start and length [mm], S [rpm], cutting edges, and its axis."""

    feed_mm_rev: float
    diameter_mm: float
    length_mm: float
    speed_rpm: float
    edges: int = 1
    axis: str = "Z"


class AdvisedRow(NamedTuple):
    """Conditions that were tried, and what they do on this machine.

    ``directive`` asks a program for them.  ``margin`` is the real one.  Chips are the longest uncut ones of
    one edge.  ``acceleration_share`` is the part of the axis's acceleration, None where nobody knows that.
    """

    directive: str
    speed_rpm: float
    per_rev: float
    frequency_hz: float
    alpha_share: float
    stroke_mm: float
    margin: float
    longest_chip_rev: float
    longest_chip_mm: float | None
    peak_thickness: float
    duration_s: float
    programmed_s: float
    acceleration_mm_s2: float
    acceleration_share: float | None


class Advice(NamedTuple):
    """The rows for a cut, the best first; by which law of the control, and whether that is proven."""

    cut: CutAsked
    profile: str
    control: str
    is_unproven: bool
    rows: tuple[AdvisedRow, ...]


def advice_for(cut: CutAsked, settings: Settings, most_rows: int = 8) -> Advice:
    """Conditions for a cut on a machine.

    The first row is what ``n = "auto"`` takes.  Raises ProgramRejectedError with the reasons where the cut
    cannot vibrate at all.
    """
    machine = _for_one_cut(settings, edges=cut.edges, n=AUTO)
    data = program_of(cut, machine)
    (best,) = rewrite(data, machine, "this cut").cuts
    rows = [_row(best, cut, settings)]
    tries = 0
    for choice in _choices(data, machine):
        if len(rows) >= most_rows or tries >= _TRIES_A_ROW * most_rows:
            break
        if any(_is_near(choice, row) for row in rows):
            continue
        tries += 1
        tried = _tried(data, cut, choice, settings)
        if tried is not None:
            rows.append(_row(tried, cut, settings))
    return Advice(cut, settings.name, best.control, best.control == Ideal.name, tuple(rows))


def program_of(cut: CutAsked, settings: Settings) -> bytes:
    """A program with this cut, in the words of the control."""
    dialect = settings.dialect
    modes = (("units", "mm"), ("distance", "absolute"), ("diameter", "diameter"), ("speed_mode", "rpm"))
    per_rev = dialect.can("feed_mode", "rev") and dialect.can("speed_mode", "rpm")
    feed_mode = "rev" if per_rev else "minute"
    codes = [dialect.code(*one) for one in (*modes, ("feed_mode", feed_mode)) if dialect.can(*one)]
    speed = dialect.m_code("spindle", "cw") + f" S{_printed(cut.speed_rpm)}"
    feed = cut.feed_mm_rev * (1.0 if per_rev else cut.speed_rpm)
    letters = settings.axis_words.letters
    x, z = letters["X"], letters["Z"]
    is_diameter = settings.control.x_diameter or dialect.can("diameter", "diameter")
    start = cut.diameter_mm if is_diameter else cut.diameter_mm / 2.0
    if cut.axis == "X":
        end = (cut.diameter_mm - 2.0 * cut.length_mm) / (1.0 if is_diameter else 2.0)
        way = [f"G0 {x}{_printed(start)} {z}0.", f"G1 {x}{_printed(end)} F{_printed(feed)}"]
    else:
        place = f"{x}{_printed(start)} " if dialect.is_lathe else ""
        way = [
            f"G0 {place}{z}{_printed(_CLEAR_MM)}",
            f"G1 {z}{_printed(_CLEAR_MM - cut.length_mm)} F{_printed(feed)}",
        ]
    return "\n".join([" ".join(codes), speed, *way, "M30", ""]).encode("ascii")


def _printed(value: float) -> str:
    return print_number(value, 6)


def _for_one_cut(settings: Settings, **changed: object) -> Settings:
    """The machine with a wish of its own, and no checks."""
    vibration = replace(settings.vibration, refused="error", only=(), e=None, f_hz=None)
    return replace(
        settings,
        vibration=replace(vibration, **changed),  # type: ignore[arg-type]
        checks=replace(settings.checks, enabled=False, strict=False),
        tools=replace(settings.tools, files=()),
    )


def _choices(data: bytes, settings: Settings) -> Iterator[Conditions]:
    """What closed forms and the law find for the cut, the best first."""
    interpreted = interpret_source(read(data), settings)
    chain = Chain(tuple(requests_of(interpreted).requests))
    return Chooser(settings).candidates(chain)


def _is_near(choice: Conditions, row: AdvisedRow) -> bool:
    near_count = abs(choice.per_rev / row.per_rev - 1.0) < _NEAR_COUNT
    return near_count and abs(choice.speed_rpm / row.speed_rpm - 1.0) < _NEAR_SPEED


def _tried(data: bytes, cut: CutAsked, choice: Conditions, settings: Settings) -> CutReport | None:
    """The cut with a choice; None where it does not break its chips."""
    given = {"n": choice.per_rev, "f_hz": choice.period.frequency_hz, "alpha": choice.alpha}
    try:
        result: Result = rewrite(data, _for_one_cut(settings, edges=cut.edges, **given), "this cut")
    except (ProgramRejectedError, SelfCheckError):
        return None
    (report,) = result.cuts
    return report


def _row(report: CutReport, cut: CutAsked, settings: Settings) -> AdvisedRow:
    plan = report.plan
    verdict = report.verdict
    limit = control_along(settings, plan.path, plan.chain.before).acceleration_mm_s2
    words = {
        "N": plan.solution.per_rev,
        "F": plan.solution.frequency_hz,
        "ALPHA": plan.wave.alpha_share,
        "EDGES": float(cut.edges),
    }
    said = [f"{key}{value:.6g}" for key, value in words.items() if (key, value) != ("EDGES", 1.0)]
    return AdvisedRow(
        directive=f"(VIB {' '.join(said)})",
        speed_rpm=plan.solution.speed_rpm,
        per_rev=plan.solution.per_rev,
        frequency_hz=plan.solution.frequency_hz,
        alpha_share=plan.wave.alpha_share,
        stroke_mm=plan.wave.stroke_mm,
        margin=verdict.margin,
        longest_chip_rev=verdict.longest_chip_rev,
        longest_chip_mm=verdict.longest_chip_mm,
        peak_thickness=verdict.peak_thickness,
        duration_s=report.duration_s,
        programmed_s=cut.length_mm / (cut.feed_mm_rev * cut.speed_rpm) * S_PER_MIN,
        acceleration_mm_s2=report.acceleration_mm_s2,
        acceleration_share=report.acceleration_mm_s2 / limit if math.isfinite(limit) else None,
    )
