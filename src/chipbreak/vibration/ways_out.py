"""What would break the chips of a cut that does not break them, or is not run as planned: all of it tried.

A larger stroke does not always help: round a corner, or on a control that cannot keep up, the weakest
vibration stays weak.  So each proposal is planned, made into blocks and judged like any cut.
"""

from __future__ import annotations

from chipbreak.kinematics.sourced_value import shown
from chipbreak.settings.sections import Settings
from chipbreak.vibration.advice import chosen
from chipbreak.vibration.measure import CutReport
from chipbreak.vibration.plan import command_group
from chipbreak.vibration.trial import Trials, fed, first_by_halving, with_values

_STROKES = (1.05, 1.25, 1.5, 2.0, 2.5, 3.0)  # times the least stroke by the formula
_TURNS = (2.0, 3.0)  # of the spindle, per edge, in one vibration
_HIGHER = (1.25, 1.5, 2.0, 3.0, 5.0, 8.0, 12.0)  # times a feed that is too slow for the control
_SLOWER = (0.8, 0.6, 0.45, 0.3, 0.2, 0.12)


def ways_out(settings: Settings, report: CutReport) -> str:
    """A larger Q, a lower frequency, behind filters an E, that break chips; empty where none was found."""
    # Each gets its part of what may be tried.
    found = [_larger_stroke(settings, report)]
    found.append(_higher_feed(settings, report) if report.is_early else _lower_frequency(settings, report))
    if report.following is not None:
        found.append(_fewer_vibrations(settings, report))
    if not any(found):
        found.append(chosen(report.plan, settings))
    return ", or ".join(way for way in found if way)


def _larger_stroke(settings: Settings, report: CutReport) -> str:
    plan = report.plan
    if report.misses_plan:
        return ""  # a stroke of any size would be late
    trials = Trials(settings)
    margin = report.verdict.margin
    ratio = plan.wave.stroke_mm / plan.wave.feed_mm_rev
    least = ratio / margin if margin > 0.0 else ratio
    tried = dict.fromkeys(round(least * factor + 0.005, 2) for factor in _STROKES)
    for stroke in (s for s in tried if s > ratio):
        if trials.works(with_values(plan.chain, {"Q": stroke}, without="A")) is not None:
            return f"Q {stroke:g} with the same S, N and f"
    return ""


def _higher_feed(settings: Settings, report: CutReport) -> str:
    """A feed at which no move is too slow for the control: a lower frequency makes all slower."""
    plan = report.plan
    trials = Trials(settings)
    for factor in _HIGHER:
        feed_mm = float(f"{plan.wave.feed_mm_rev * factor:.3g}")
        share = feed_mm / plan.wave.feed_mm_rev
        if trials.works(fed(plan.chain, share)) is not None:
            per_minute = plan.chain.before.modes.feed_mode != "rev"
            spoken = f" ({shown(round(feed_mm * plan.solution.speed_rpm, 3))} mm/min)" if per_minute else ""
            return f"a feed of {shown(feed_mm)} mm/rev{spoken} with the same S, N and f"
    return ""


def _lower_frequency(settings: Settings, report: CutReport) -> str:
    plan = report.plan
    trials = Trials(settings)
    group = command_group(settings)
    per_rev = round(plan.solution.per_rev, 4)
    top_hz = plan.solution.frequency_hz
    every = dict.fromkeys(group.nearest(top_hz * factor).frequency_hz for factor in _SLOWER)
    lower = [frequency_hz for frequency_hz in every if frequency_hz < top_hz]
    found = dict[int, CutReport]()

    def works(place: int) -> bool:
        wish = {"N": per_rev, "F": float(shown(lower[place]))}
        report = trials.works(with_values(plan.chain, wish, without="SE"))
        if report is not None:
            found[place] = report
        return report is not None

    place = first_by_halving(works, -1, len(lower))
    if place not in found:
        return ""
    speed = f"S {found[place].plan.solution.speed_rpm:z.0f}"
    return f"N {shown(per_rev)} f {shown(lower[place])} Hz ({speed}) with the same feed and stroke"


def _fewer_vibrations(settings: Settings, report: CutReport) -> str:
    """Revolutions a vibration at about the programmed speed: slow axes follow that sooner than an N."""
    plan = report.plan
    trials = Trials(settings)
    for turns in _TURNS:
        if turns / plan.edges <= 1.0 / plan.solution.per_rev:
            continue
        works = trials.works(with_values(plan.chain, {"E": turns / plan.edges}, without="NF"))
        if works is not None:
            solution = works.plan.solution
            runs = f"S {solution.speed_rpm:z.0f}, f {shown(round(solution.frequency_hz, 3))} Hz"
            return f"E {shown(turns / plan.edges)} ({runs}) with the same feed"
    return ""
