"""The modal groups: one door in, every group known by name, foreign ones kept and compared like the rest."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import pytest

import chipbreak
from chipbreak.dialects import DIALECTS, Dialect
from chipbreak.dialects.base import CYCLE_END, NON_MODAL, Code, table
from chipbreak.dialects.modes import UNSAID, VALUES, Group, Modes, check_value
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter, initial_state
from chipbreak.syntax.parse import read_block


def test_the_names_of_the_groups_are_those_of_the_fields() -> None:
    assert (*get_args(Group), "others") == Modes._fields
    assert tuple(VALUES) == get_args(Group)


@pytest.mark.parametrize("dialect", DIALECTS, ids=lambda dialect: f"{dialect.name}{dialect.lathe_system}")
def test_our_own_tables_name_known_groups_and_values_only(dialect: Dialect) -> None:
    for code in dialect.g_codes.values():
        if code.group not in (NON_MODAL, CYCLE_END):
            assert code.group in VALUES, code
            check_value(*code)
    assert not dialect.initial.others
    for group, value in dialect.initial.items():
        check_value(group, value)


def test_every_default_is_a_value_of_its_group() -> None:
    for group, value in Modes().items():
        check_value(group, value)


def test_a_misspelt_value_is_refused_where_a_table_is_built() -> None:
    with pytest.raises(ValueError, match=r"feed_mode has no value 'revv'; it has inverse, minute, rev"):
        table(feed_mode={"G95": "revv"})


def test_what_changes_is_told_in_the_order_of_the_groups() -> None:
    one = Modes()
    other = one.replace({"polar": "on", "motion": "line", "stroke_mode": "short"})
    assert one.changed(other) == other.changed(one) == ("motion", "polar", "stroke_mode")
    assert (other.motion, other.polar, other.value("stroke_mode")) == ("line", "on", "short")
    assert one.value("stroke_mode") == UNSAID


def test_setting_what_is_in_force_makes_nothing_new() -> None:
    modes = Modes().replace({"stroke_mode": "short"})
    assert modes.replace({"distance": "absolute", "stroke_mode": "short"}) is modes
    assert modes.replace({}) is modes


def test_a_group_that_only_a_dialect_knows_is_kept_and_compared() -> None:
    settings = chipbreak.load("fanuc-mill")
    dialect = settings.dialect
    codes = {**dialect.g_codes, 8000: Code("stroke_mode", "long"), 8010: Code("stroke_mode", "short")}
    settings = replace(settings, dialect=dialect._replace(g_codes=codes))
    interpreter = Interpreter(settings, Flow(frozenset(), ()))
    state = start = initial_state(settings)
    for text in ("G801", "G91 G1 X1. F100.", "G800 G90"):
        before, state = state, interpreter.advance(state, read_block(0, text, interpreter.dialect)).after
    assert before.modes.others == (("stroke_mode", "short"),)
    assert before.modes.changed(state.modes) == ("distance", "stroke_mode")
    assert state.modes.value("stroke_mode") == "long"
    assert start.modes.changed(state.modes) == ("motion", "stroke_mode")
    assert settings.dialect.code("stroke_mode", "short") == "G801"
