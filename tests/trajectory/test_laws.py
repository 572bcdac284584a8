"""What every law of control must answer, whatever it makes of blocks; a new one is met by the same test."""

from __future__ import annotations

import ast
import inspect
import pickle
import re
from itertools import chain
from math import inf
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.kinematics.waves import WAVES
from chipbreak.settings import SettingsError
from chipbreak.settings.sections import Planner
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory import laws as module_of_laws
from chipbreak.trajectory.law import AxisLimits, ControlLaw
from chipbreak.trajectory.law_names import LAW_KEYS, foreign_keys
from chipbreak.trajectory.laws import LAWS, law_named
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.trapezoid import Trapezoid
from source_trees import tree_of
from strokes import on_z

PACKAGE = Path(chipbreak.__file__).parent
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)

strokes = st.lists(
    st.tuples(st.floats(0.005, 0.5), st.floats(2.0, 60.0)), min_size=2, max_size=12
)  # length [mm] and feed [mm/s]


def made(law: type[ControlLaw], **more: Any) -> ControlLaw:
    return on_z(law(velocity_mm_s=150.0, acceleration_mm_s2=4000.0, **more))


def columns(drawn: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Strokes forward and back in turn."""
    lengths, feeds = np.array(drawn).T
    return lengths * np.tile([1.0, -1.0], len(lengths))[: len(lengths)], feeds


def motion_of(
    law: ControlLaw, lengths_mm: np.ndarray, feeds_mm_s: np.ndarray, dwell_s: np.ndarray | None = None
) -> Motion:
    moved = np.zeros((len(lengths_mm), 3))
    moved[:, 2] = lengths_mm
    places = np.append(0.0, np.cumsum(lengths_mm))
    return law.motion(places, law.blocks(moved, lengths_mm), feeds_mm_s, dwell_s)


def test_every_law_is_in_the_tuple_and_in_the_profile() -> None:
    def concrete(law: type[ControlLaw]) -> set[type[ControlLaw]]:
        below = {found for sub in law.__subclasses__() for found in concrete(sub)}
        return below if inspect.isabstract(law) else below | {law}

    assert set(LAWS) == concrete(ControlLaw)  # type: ignore[type-abstract]
    names = [law.name for law in LAWS]
    assert len(set(names)) == len(names)
    field = Planner.__dataclass_fields__["model"]
    assert tuple(names) == tuple(LAW_KEYS) == field.metadata["choices"]
    assert field.default == names[0]
    assert [law_named(name) for name in names] == list(LAWS)
    for law in LAWS:
        chipbreak.load(
            "generic-lathe",
            [f"planner.model={law.name}", *(f"axes.{a}.max_acceleration_mm_s2=9" for a in "XZ")],
        )


@EVERY_LAW
def test_a_key_that_means_nothing_to_a_law_is_refused(law: type[ControlLaw]) -> None:
    keys = {key for own_keys in LAW_KEYS.values() for key in own_keys}
    assert keys <= set(Planner.__dataclass_fields__)
    assert set(foreign_keys(law.name)) == keys - set(LAW_KEYS[law.name])
    for key, others in foreign_keys(law.name).items():
        number = 0.5 if "below" in Planner.__dataclass_fields__[key].metadata else 3
        with pytest.raises(SettingsError, match=key) as refused:
            chipbreak.load("generic-lathe", [f"planner.model={law.name}", f"planner.{key}={number}"])
        assert all(other in refused.value.diagnostic.help for other in others)


@pytest.mark.few(40)
@EVERY_LAW
@settings(deadline=None)
@given(drawn=strokes, rate=st.sampled_from([None, 200.0]))
def test_blocks_take_at_least_length_by_feed(
    law: type[ControlLaw], drawn: list[tuple[float, float]], rate: float | None
) -> None:
    control = made(law, blocks_per_s=rate)
    lengths, feeds = columns(drawn)
    times = control.block_times(lengths, feeds)
    assert (times >= np.abs(lengths) / feeds * (1.0 - 1e-9)).all()
    assert (times >= np.abs(lengths) / 150.0 * (1.0 - 1e-9)).all()
    assert rate is None or (times >= 1.0 / rate).all()
    faster = control.block_times(np.abs(lengths[:1]), feeds[:1] * 1.5)
    assert faster[0] <= control.block_times(np.abs(lengths[:1]), feeds[:1])[0] + 1e-12


@pytest.mark.few(40)
@EVERY_LAW
@settings(deadline=None)
@given(drawn=strokes)
def test_the_motion_goes_from_start_to_end_in_rising_time(
    law: type[ControlLaw], drawn: list[tuple[float, float]]
) -> None:
    control = made(law)
    lengths, feeds = columns(drawn)
    motion = motion_of(control, lengths, feeds)
    assert motion.time_s[0] == motion.distance_mm[0] == 0.0
    assert (np.diff(motion.time_s) > 0.0).all()
    assert motion.distance_mm[-1] == pytest.approx(lengths.sum(), abs=1e-9)
    assert motion.spans_s == pytest.approx(control.block_times(lengths, feeds))
    lag = control.late_s + 1e-9
    assert motion.spans_s.sum() - 1e-9 <= motion.time_s[-1] <= motion.spans_s.sum() + lag
    # Never outside what is commanded, and never faster than the axis.
    ends = np.append(0.0, np.cumsum(lengths))
    assert ends.min() - 1e-9 <= motion.distance_mm.min()
    assert motion.distance_mm.max() <= ends.max() + 1e-9
    assert np.abs(np.diff(motion.distance_mm) / np.diff(motion.time_s)).max() <= feeds.max() * (1.0 + 1e-6)


@pytest.mark.few(40)
@EVERY_LAW
@settings(deadline=None)
@given(drawn=strokes, seed=st.integers(0, 7))
def test_a_dwell_is_added_and_the_tool_rests_in_it(
    law: type[ControlLaw], drawn: list[tuple[float, float]], seed: int
) -> None:
    control = made(law)
    lengths, feeds = columns(drawn)
    dwell_s = np.where(np.arange(len(lengths)) % 3 == seed % 3, 0.05, 0.0)
    motion = motion_of(control, np.abs(lengths), feeds, dwell_s)
    assert (np.diff(motion.time_s) > 0.0).all()
    assert motion.distance_mm[-1] == pytest.approx(np.abs(lengths).sum(), abs=1e-9)
    assert motion.time_s[-1] >= motion.spans_s.sum() + dwell_s[:-1].sum() - 1e-9
    ends_mm = np.cumsum(np.abs(lengths))
    for at in np.flatnonzero(dwell_s[:-1]).tolist():
        there = np.abs(motion.distance_mm - ends_mm[at]) < 1e-7
        assert np.ptp(motion.time_s[there]) >= 0.05 - control.late_s - 1e-9


@pytest.mark.few(40)
@EVERY_LAW
@settings(deadline=None)
@given(length=st.floats(0.01, 0.5), more=st.floats(1.15, 8.0))
def test_the_feed_found_takes_its_time(law: type[ControlLaw], length: float, more: float) -> None:
    control = made(law)
    least = control.shortest_time(length)
    wanted = control.rounded(least * more + 2.0 * control.servo_period_s)
    feed = control.feed_for_time(length, wanted)
    assert feed <= control.velocity_mm_s
    assert control.block_times([length], [feed])[0] == pytest.approx(wanted, rel=1e-6)
    assert control.block_times([length], [control.velocity_mm_s])[0] <= wanted + 1e-9


@given(st.lists(st.floats(0.01, 5.0), min_size=1, max_size=6), st.floats(1.0, 200.0), st.floats(50.0, 5000.0))
def test_a_straight_move_takes_as_long_in_many_blocks_as_in_one(
    lengths: list[float], feed: float, acceleration: float
) -> None:
    """Also where a block is too short to reach at its end what the next ones would let it have there."""
    control = Trapezoid(1e9, acceleration)
    one = control.block_times([sum(lengths)], [feed])
    assert control.block_times(lengths, [feed] * len(lengths)).sum() == pytest.approx(one[0], rel=1e-9)


@EVERY_LAW
def test_what_no_feed_does_is_refused(law: type[ControlLaw]) -> None:
    control = made(law)
    with pytest.raises(RefusalError, match="needs") as refused:
        control.feed_for_time(0.5, control.shortest_time(0.5) * 0.6)
    assert refused.value.code in ("VIB030", "VIB031")
    with pytest.raises(RefusalError) as unread:
        made(law, blocks_per_s=20.0).feed_for_time(0.5, 0.04)
    assert unread.value.code == "VIB032"
    with pytest.raises(RefusalError) as lost:
        made(law, merge_mm=0.1).block_times([0.3, -0.1, 0.3], 10.0)
    assert lost.value.code == "VIB033"
    for bad in ("velocity_mm_s", "acceleration_mm_s2", "servo_period_s"):
        with pytest.raises(ValueError, match="above zero"):
            law(**{bad: 0.0})


@EVERY_LAW
@pytest.mark.parametrize("blocks", [1, 3])
def test_strokes_get_their_time(law: type[ControlLaw], blocks: int) -> None:
    """A swinging cut of one or several blocks a stroke keeps its whole time, and each stroke its own."""
    control = made(law)
    stroke = np.repeat([0.06, -0.05], blocks) / blocks
    lengths = np.tile(stroke, 10)
    spans = np.full(len(lengths), 0.016 / blocks)
    moved = np.column_stack([np.zeros(len(lengths)), np.zeros(len(lengths)), lengths])
    feeds = control.feeds_for_spans(control.blocks(moved, lengths), spans, len(lengths))
    motion = motion_of(control, lengths, feeds)
    assert motion.spans_s.sum() == pytest.approx(spans.sum(), rel=0.01)
    each = motion.spans_s.reshape(-1, blocks).sum(axis=1)
    assert each == pytest.approx(np.full(20, 0.016), abs=control.servo_period_s + 1e-9)


@EVERY_LAW
def test_a_law_is_a_value(law: type[ControlLaw]) -> None:
    control = made(law)
    assert pickle.loads(pickle.dumps(control)) == control
    assert hash(made(law)) == hash(control)
    assert control.with_acceleration(5.0).acceleration_mm_s2 == 5.0
    axes = (AxisLimits("X", 10.0, 300.0), AxisLimits("Y", inf, inf), AxisLimits("Z", 20.0, 500.0))
    both = law().along((3.0, 0.0, -4.0), axes)
    assert (both.axis, both.acceleration_mm_s2) == ("X", pytest.approx(500.0))


# No module but that of a law, or of a wave, asks for it by name.

OTHER_DWELLS = {
    "effect.non_modal": "what a block does once",
    "settings.vibration.end": "how a cut ends",
}


def own_module(named: type[Any]) -> str:
    """The module of a law or a wave, as a path under the package."""
    return Path(inspect.getfile(named)).relative_to(PACKAGE).as_posix()


NAMED = {law.name: own_module(law) for law in LAWS} | {wave.name: own_module(type(wave)) for wave in WAVES}
# Where no text is such a name, the tree need not be looked through.
_MAY_BRANCH = re.compile("|".join(f"""["']{re.escape(name)}["']""" for name in NAMED))


def branches(tree: ast.AST) -> set[tuple[str, int]]:
    """Texts that are compared with or looked for in a tuple, a set or a list, each with its line."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            found |= {(part.value, node.lineno) for part in _compared(node) if _is_text(part)}
        elif isinstance(node, ast.MatchValue) and _is_text(node.value):
            found.add((node.value.value, node.value.lineno))
    return found


def _compared(node: ast.Compare) -> list[ast.expr]:
    """What a comparison compares, and what is in it; nothing where a dwell of another kind takes part."""
    parts = [node.left, *node.comparators]
    lists = [part.elts for part in parts if isinstance(part, ast.Tuple | ast.List | ast.Set)]
    found = [*parts, *chain.from_iterable(lists)]
    if not any(map(_is_text, found)) or any(ast.unparse(part) in OTHER_DWELLS for part in parts):
        return []
    return found


def _is_text(node: ast.expr) -> TypeGuard[ast.Constant]:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def test_no_branch_on_the_name_of_a_law_or_a_wave() -> None:
    found = []
    for file in PACKAGE.rglob("*.py"):
        inside = file.relative_to(PACKAGE).as_posix()
        told = branches(tree_of(file)) if _MAY_BRANCH.search(file.read_text("utf-8")) else ()
        found += [(inside, *one) for one in told if NAMED.get(one[0], inside) != inside]
    assert not found


def test_a_branch_is_found() -> None:
    for text in (
        'law == "ideal"',
        'if "ideal" != law: pass',
        'law in ("x", "ideal")',
        'not law in {"ideal"}',
    ):
        assert _MAY_BRANCH.search(text)
        assert ("ideal", 1) in branches(ast.parse(text))
    assert branches(ast.parse('match law:\n    case "ideal":\n        pass')) == {("ideal", 2)}
    assert not branches(ast.parse('name = "ideal"'))
    assert module_of_laws.LAWS is LAWS


@settings(deadline=None)
@given(st.lists(st.floats(0.01, 2.0), min_size=2, max_size=6), st.floats(1.0, 5.0))
def test_parts_with_rests_between_share_the_time_of_a_stroke_by_their_length(
    ways_mm: list[float], share: float
) -> None:
    law = Trapezoid(velocity_mm_s=150.0, acceleration_mm_s2=4000.0)
    # From rest to rest: there and back over half the way each at full acceleration.
    least_s = [2.0 * (way / 4000.0) ** 0.5 for way in ways_mm]
    wanted_s = share * sum(least_s)
    given_s = law._shared_out(wanted_s, ways_mm, [law] * len(ways_mm))
    step_s = law.time_step_s(wanted_s)
    parts = len(ways_mm)
    assert sum(given_s) == pytest.approx(wanted_s, abs=parts * (step_s + law.servo_period_s))
    spare_s = sum(given_s) - sum(least_s)
    for way, least, time in zip(ways_mm, least_s, given_s, strict=True):
        assert time >= least - 1e-9
        by_length = least + spare_s * way / sum(ways_mm)
        assert time == pytest.approx(by_length, abs=parts * (step_s + law.servo_period_s))
