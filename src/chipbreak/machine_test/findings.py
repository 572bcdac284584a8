"""What times and traces say of a machine: the values of a profile, and what they cannot tell."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

from chipbreak.machine_files.found import Found, Machine
from chipbreak.machine_test.fit import AxisData, Fit, fits_of
from chipbreak.machine_test.form import Form
from chipbreak.machine_test.groups import Group
from chipbreak.machine_test.model import EXACT, FilterKind, Limits, law_of, time_s
from chipbreak.machine_test.trace import Piece
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.law_names import LAW_KEYS
from chipbreak.units import MS_PER_S, S_PER_MIN

_FEWEST_TIMES = 6
_SIGMAS = 2.0  # what is said holds in 19 of 20 tests
_MOST_MISFIT_MM = 0.004
_MOST_MISFIT_NOISES = 4.0
_MOST_MISFIT_ERRORS = 6.0
_MOST_SHARE = 0.2
_NO_LAG_1_S = 10000.0  # Kp where no lag is seen
_AT_REST_MM_MIN = 0.001
_SLOWER = 1.03
# Two standard deviations are not less: the model rounds the shape of ramps, which moves the numbers so far.
_LEAST_SHARES = {"average_s": 0.02, "bell_s": 0.06, "lag_s": 0.015, "second_lag_s": 0.04}
_LEAST_SHARE = 0.006
_HIDDEN_BELL = 0.055  # what a second time of a third of the first adds to it


class Measured(NamedTuple):
    """A value of a profile, and by which share of it it may be off (two standard deviations)."""

    key: str
    value: str | float
    share: float
    unit: str = ""

    @property
    def told(self) -> str:
        """Where it came from, for a comment of the profile."""
        return f"machine test, +- {100.0 * self.share:.2g} %" if self.share else "machine test"


@dataclass(frozen=True, eq=False)
class Findings:
    """The law of control by name, its values, what the data cannot tell, and how well they are explained."""

    model: str
    measured: tuple[Measured, ...]
    open: tuple[str, ...]
    fits: tuple[tuple[str, Fit], ...]

    def machine(self, base: str) -> Machine:
        """As a profile is made of."""
        found = [Found("planner.model", self.model, "machine test")]
        found += [Found(one.key, one.value, one.told) for one in self.measured]
        return Machine(base, tuple(found), self.open)

    def lines(self) -> Iterator[str]:
        """For people."""
        yield f"law of control: {self.model}"
        for one in self.measured:
            value = one.value if isinstance(one.value, str) else f"{one.value:.5g}"
            about = f" +- {100.0 * one.share:.2g} %" if one.share else ""
            yield f"{one.key} = {value}{about}"
        for axis, fit in self.fits:
            yield f"{axis}: what is left is {fit.misfit_mm * 1000.0:.2g} um, {fit.misfit_s * 1000.0:.2g} ms"
        yield from (f"cannot tell: {one}" for one in self.open)

    def values(self) -> dict[str, Any]:
        """For programs."""
        return {
            "model": self.model,
            "measured": [one._asdict() for one in self.measured],
            "cannot_tell": list(self.open),
            "misfits": [
                {"axis": axis, "misfit_mm": fit.misfit_mm, "misfit_s": fit.misfit_s}
                for axis, fit in self.fits
            ],
        }


def findings_of(form: Form, pieces: Sequence[Piece], settings: Settings) -> Findings:
    """What explains times and traces.

    Errors: MTS005 where there is too little of them, MTS006 where no law of control explains them.
    """
    known = _known(settings)
    data = [one for axis in AXES if (one := _data_of(axis, form, pieces)) is not None]
    if not data:
        message = f"too little was measured: {len(form.timed)} times and no trace"
        help_text = f"write the times of at least {_FEWEST_TIMES} groups of an axis into the form, or --trace"
        raise RefusalError("MTS005", message, help_text)
    main = max(data, key=lambda one: one.count)
    best = fits_of(main, known, settings.planner.model)[0]
    fits = [(main.axis, best)]
    for one in data:
        if one is not main:
            fits.append((one.axis, fits_of(one, known, settings.planner.model, only=best.kind)[0]))
    for axis, fit in fits:
        noise_mm = max((one.noise_mm for one in pieces if one.axis == axis), default=0.0)
        _refuse_misfit(axis, fit, form, noise_mm)
    has_trace = {one.axis for one in data if one.pieces}
    model = _model_of(best, settings)
    measured = [*_of_law(model, fits), *_of_axes(model, fits, has_trace, settings)]
    rate, least = _rates(form, best, main, known)
    if rate is not None:
        measured.append(rate)
    measured.append(Measured("planner.uncertainty", _worst_share(measured), 0.0))
    told = _Known(model, fits, has_trace, least, form)
    still_open = tuple(text for rule in _OPEN for text in rule(told))
    return Findings(model, tuple(measured), still_open, tuple(fits))


def _worst_share(measured: Sequence[Measured]) -> float:
    """The most that a number may be off; not of a bell, for which its acc/dec makes up."""
    own = [one.share for one in measured if not one.key.endswith((".bell_ms", ".min_cruise_ratio", "_per_s"))]
    return round(min(max(own, default=0.0), _MOST_SHARE), 4)


def _known(settings: Settings) -> Limits:
    speeds = {
        axis: one.max_velocity_mm_min / S_PER_MIN
        for axis, one in settings.axes.items()
        if one.max_velocity_mm_min is not None
    }
    planner = settings.planner
    return Limits(speeds, planner.servo_period_ms / MS_PER_S, planner.max_feed_override or 1.0)


def _is_of_strokes(group: Group, axis: str) -> bool:
    return group.axis == axis and group.blocks == 1


def _data_of(axis: str, form: Form, pieces: Sequence[Piece]) -> AxisData | None:
    own = [one for one in pieces if _is_of_strokes(one.group, axis)]
    times = [
        (group, time)
        for group, time in zip(form.groups, form.times_s, strict=True)
        if time is not None and _is_of_strokes(group, axis)
    ]
    if len(times) < _FEWEST_TIMES:
        times = []
    if not own and not times:
        return None
    # A trace says more than times, and its clock is the same as that of the control.
    return AxisData(axis, own, [] if own else times, form.error_s)


def _refuse_misfit(axis: str, fit: Fit, form: Form, noise_mm: float) -> None:
    worst_s = _MOST_MISFIT_ERRORS * form.error_s
    if fit.misfit_mm <= max(_MOST_MISFIT_MM, _MOST_MISFIT_NOISES * noise_mm) and fit.misfit_s <= worst_s:
        return
    left = f"{fit.misfit_mm * 1000.0:.3g} um" if fit.misfit_mm else f"{fit.misfit_s * 1000.0:.3g} ms"
    message = f"no law of control that is known here explains {axis}: {left} are left by the nearest"
    help_text = (
        "look whether the feed override was 100 %, whether the times stand in their rows, whether error_ms is"
        " as it was, and whether the axis slipped"
    )
    raise RefusalError("MTS006", message, help_text)


def _model_of(fit: Fit, settings: Settings) -> str:
    """The law: that of the profile where it says the same."""
    if settings.planner.model in fit.kind.models:
        return settings.planner.model
    if fit.kind.name == "rests" and fit.behind.names:
        return "look-ahead"  # whose verdict sees filters within strokes
    return fit.kind.models[0]


def _share(fit: Fit, name: str) -> float:
    return max(_SIGMAS * fit.shares[name], _LEAST_SHARES.get(name, _LEAST_SHARE)) if name else 0.0


def _of_law(model: str, fits: Sequence[tuple[str, Fit]]) -> Iterator[Measured]:
    """What is one number for all axes: that of the axis that knows it best."""
    name = {"ramps": "joint_speed", "stops": "stop", "cruises": "smooth_share"}.get(fits[0][1].kind.name)
    if name is None:
        if "min_cruise_ratio" in LAW_KEYS[model]:
            yield Measured("planner.min_cruise_ratio", 0.0, 0.0)
        if "joint_speed_mm_min" in LAW_KEYS[model]:
            yield Measured("planner.joint_speed_mm_min", _AT_REST_MM_MIN, 0.0)
        return
    fit = min((one for _, one in fits), key=lambda one: one.shares[name])
    value = fit.numbers[name]
    if name == "joint_speed":
        yield Measured("planner.joint_speed_mm_min", value * S_PER_MIN, _share(fit, name), "mm/min")
    elif name == "stop":
        yield Measured("planner.reversal_stop_ms", value * MS_PER_S, _share(fit, name), "ms")
    else:
        top = max(one.numbers["acceleration"] for _, one in fits)
        yield Measured("planner.path_acceleration_mm_s2", top, _share(fit, "acceleration"), "mm/s2")
        ratio = min(max(1.0 - value, 0.0), 0.999)
        # What was measured is the rest of it.
        share = _share(fit, name) * value / ratio if ratio > 0.0 else 0.0
        yield Measured("planner.min_cruise_ratio", ratio, share)


def _of_axes(
    model: str, fits: Sequence[tuple[str, Fit]], has_trace: set[str], settings: Settings
) -> Iterator[Measured]:
    for axis, fit in fits:
        if "acceleration" in fit.numbers and _share(fit, "acceleration") <= _MOST_SHARE:
            key = f"axes.{axis}.max_acceleration_mm_s2"
            yield Measured(key, fit.numbers["acceleration"], _share(fit, "acceleration"), "mm/s2")
        has_filters = fit.behind.names or fit.kind is EXACT or "joint_speed_mm_min" in LAW_KEYS[model]
        if axis in has_trace and has_filters:
            yield from _of_filter(axis, fit, settings.axes[axis].feed_forward)


def _of_filter(axis: str, fit: Fit, feed_forward: float) -> Iterator[Measured]:
    """Averages are linear or bell-shaped acc/dec; of two lags the longer is exponential acc/dec."""
    names = sorted(fit.behind.names, key=lambda name: -fit.numbers[name])
    averages = [name for name in names if name in ("average_s", "bell_s")]
    lags = [name for name in names if name not in averages]
    # Of two lags in a row each is known only as well as the other.
    least = _LEAST_SHARES["second_lag_s"] if len(lags) == 2 else 0.0
    if len(lags) == 2:
        yield from _of_acc_dec(axis, fit, "exponential", [lags.pop(0)], least)
    else:
        yield from _of_acc_dec(axis, fit, "bell" if len(averages) > 1 else "linear", averages, least)
    yield _of_gain(axis, fit, lags, feed_forward, least)
    if feed_forward:
        yield Measured(f"axes.{axis}.feed_forward", feed_forward, 0.0)


def _of_acc_dec(axis: str, fit: Fit, kind: str, names: Sequence[str], least: float) -> Iterator[Measured]:
    """The acc/dec filter: its kind, its time, and that of a bell."""
    yield Measured(f"axes.{axis}.acc_dec", kind, 0.0)
    first, *others = names or [""]
    first_ms = fit.numbers[first] * MS_PER_S if first else 0.0
    least = _HIDDEN_BELL if _may_hide_bell(fit) else least
    yield Measured(f"axes.{axis}.acc_dec_ms", first_ms, max(_share(fit, first), least), "ms")
    for other in others:
        # The two together are known best: a little more of the longer is much less of the shorter.
        together = _LEAST_SHARES["average_s"] * (fit.numbers[first] / fit.numbers[other]) ** 2
        share = max(_share(fit, other), together)
        yield Measured(f"axes.{axis}.bell_ms", fit.numbers[other] * MS_PER_S, share, "ms")


def _of_gain(axis: str, fit: Fit, lags: Sequence[str], feed_forward: float, least: float) -> Measured:
    """The gain of the position loop, from its lag."""
    name = f"axes.{axis}.position_gain_1_s"
    if not lags:
        return Measured(name, _NO_LAG_1_S, 0.0, "1/s")
    gain = (1.0 - feed_forward) / fit.numbers[lags[0]] if feed_forward < 1.0 else _NO_LAG_1_S
    return Measured(name, min(gain, _NO_LAG_1_S), max(_share(fit, lags[0]), least), "1/s")


def _may_hide_bell(fit: Fit) -> bool:
    """A short second time is seen where the command is sharp, not behind the ramps of a look-ahead."""
    return fit.behind.averages == 1 and fit.kind is not EXACT


def _acc_dec_of(behind: FilterKind) -> str:
    """What a filter is called where it is acc/dec with a position loop."""
    if behind.averages:
        return ("linear", "bell")[behind.averages - 1]
    return "exponential" if behind.lags == 2 else "none"


def _rates(form: Form, fit: Fit, main: AxisData, known: Limits) -> tuple[Measured | None, float]:
    """How many blocks a second are read where that holds the machine up, and the most that was seen to be."""
    law = law_of(fit.kind, fit.numbers, main.axis, known)
    timed = list(zip(form.groups, form.times_s, strict=True))
    strokes = [(g, t) for g, t in timed if t is not None and _is_of_strokes(g, main.axis)]
    blocks = [(g, t) for g, t in timed if t is not None and g.axis == main.axis and g.blocks > 1]
    if not strokes or not blocks:
        return None, 0.0
    added_s = sum(t - time_s(fit.kind, law, fit.numbers, g) for g, t in strokes) / len(strokes)
    held = list[float]()
    free = [0.0]
    for group, time in blocks:
        own_s = time - added_s
        rate = group.strokes * group.blocks / own_s
        planned_s = time_s(fit.kind, law, fit.numbers, group)
        is_held = own_s > _SLOWER * planned_s + 4.0 * form.error_s
        (held if is_held else free).append(rate)
    if not held:
        return None, max(free)
    worst = min(held)
    return Measured(
        "planner.max_blocks_per_s", float(ceil(worst) - 1), _SIGMAS * form.error_s * worst / 200.0
    ), 0.0


@dataclass(frozen=True, eq=False)
class _Known:
    """What was found, for those who say what was not."""

    model: str
    fits: Sequence[tuple[str, Fit]]
    has_trace: set[str]
    rate: float
    form: Form

    @property
    def has_blocks(self) -> bool:
        """True where a group of many blocks has a time."""
        return any(self.form.groups[number].blocks > 1 for number in self.form.timed)


def _open_axes(known: _Known) -> Iterator[str]:
    tested = {axis for axis, _ in known.fits}
    for axis in "XZ":
        if axis not in tested:
            yield f"axes.{axis}: nothing was measured of it"
    for axis, fit in known.fits:
        yield from _open_behind(axis, fit) if axis in known.has_trace else _open_without_trace(axis)
        if "acceleration" in fit.numbers and _share(fit, "acceleration") > _MOST_SHARE:
            yield f"axes.{axis}.max_acceleration_mm_s2: it is so high that these strokes do not show it"


def _open_without_trace(axis: str) -> Iterator[str]:
    yield (
        f"axes.{axis}.acc_dec_ms and position_gain_1_s: times do not show what the axis makes of its"
        " command, only a trace of its real place does, or the parameter screen"
    )


def _open_behind(axis: str, fit: Fit) -> Iterator[str]:
    """What a trace leaves open of the filters behind the command."""
    if _may_hide_bell(fit):
        yield f"axes.{axis}.bell_ms: a second acc/dec time below a third of acc_dec_ms is not seen"
    for rival in fit.rivals:
        yield (
            f"axes.{axis}.acc_dec: {_acc_dec_of(rival)} explains the trace as well as"
            f" {_acc_dec_of(fit.behind)}, with other times; the parameter screen knows"
        )


def _open_of_trace(known: _Known) -> Iterator[str]:
    if known.has_trace:
        yield "whether the trace is the command: what the axis makes of it is seen in its real place alone"
        yield "feed forward apart from position gain: (1 - feed_forward) / position_gain_1_s was measured"


def _open_speeds(known: _Known) -> Iterator[str]:
    top = max(group.feed_mm_min for group in known.form.groups)
    yield f"max_velocity_mm_min: the test asked for no more than F{top:g}"
    if known.rate:
        yield f"planner.max_blocks_per_s: {known.rate:z.0f} are read, and more was not asked"
    elif not known.has_blocks:
        yield "planner.max_blocks_per_s: the form has no times of the groups B1 to B4"


def _open_laws(known: _Known) -> Iterator[str]:
    if "junction_deviation_mm" in LAW_KEYS[known.model]:
        yield "the speed at corners (junction_deviation_mm, corner_velocity_mm_s): take it from the control"
    if "max_feed_override" in LAW_KEYS[known.model]:
        yield "planner.max_feed_override and servo_period_ms: take them from the INI file"
    yield "what cutting forces, heat and wear change: it was measured in air"


_OPEN: tuple[Callable[[_Known], Iterator[str]], ...] = (_open_axes, _open_of_trace, _open_speeds, _open_laws)
