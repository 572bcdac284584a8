"""W after an operation against all the ways that a program can go with each block delete on or off."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product
from typing import NamedTuple

import pytest
from hypothesis import example, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from beam import BEAM
from chipbreak.checks.limits import Uses
from chipbreak.model.interpreted_program import interpret
from chipbreak.operations.kinds import KindRules
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import operations_of
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

SETTINGS = chipbreak.load("fanuc-mill", (*BEAM, "checks.last_use=none"))
W_MM = {"ROUGH": 0.05, "FINISH": 0.02}


class Cut(NamedTuple):
    """An operation; ``mark`` is "/" where its first cut may be left out."""

    kind: str
    mark: str = ""


class Visit(NamedTuple):
    """A tool and what it does; ``mark`` is "/" where its call may be left out."""

    tool: int
    cuts: tuple[Cut, ...]
    mark: str = ""

    def text(self) -> str:
        cuts = (
            f"({cut.kind})\nG0 X1. Y2.\nG43 Z15. H{self.tool}\n{cut.mark}G1 Z-1. X9. F100.\nG0 Z15.\n"
            for cut in self.cuts
        )
        return f"{self.mark}T{self.tool} M6\nS1000 M3\n{''.join(cuts)}M5\nG28 G91 Z0.\nG90\nG49\n"


def limits(visits: list[Visit]) -> list[float | None]:
    """W after each operation that wears an edge, as the checks have it."""
    text = f"G90 G94 G17 G49 G40 G80\nG21\n{''.join(map(Visit.text, visits))}M30\n"
    interpreted = interpret(parse(read(text.encode()), SETTINGS.dialect), SETTINGS)
    rules = KindRules.from_profile(SETTINGS.operations)
    operations = operations_of(interpreted, main_program(interpreted), rules)
    assert len(operations) == sum(len(visit.cuts) for visit in visits)
    uses = Uses(operations, interpreted)
    found = [uses.limit_after(operation, SETTINGS) for operation in uses.cutting]
    return [limit and limit.w_mm for limit in found]


def ways(visits: list[Visit]) -> Iterator[list[tuple[int, int, str]]]:
    """Number, tool and kind of what is cut, in order, for every choice of what is left out."""
    marked = [*visits, *(cut for visit in visits for cut in visit.cuts)]
    for runs in product(*((True, False) if one.mark else (True,) for one in marked)):
        called = iter(runs[: len(visits)])
        cut_at_all = iter(runs[len(visits) :])
        tool = 0
        number = -1
        way = []
        for visit in visits:
            tool = visit.tool if next(called) else tool
            for cut in visit.cuts:
                number += 1
                if next(cut_at_all) and cut.kind in W_MM:
                    way.append((number, tool, cut.kind))
        yield way


def asked_next(way: list[tuple[int, int, str]]) -> Iterator[tuple[int, int, float]]:
    """Number and tool of what is cut, and what the next cut of that tool asks of it."""
    for at, (number, tool, _) in enumerate(way):
        following = (W_MM[kind] for _, later, kind in way[at + 1 :] if later == tool)
        yield from ((number, tool, w_mm) for w_mm in islice(following, 1))


def tightest(visits: list[Visit]) -> list[float | None]:
    """What the next cut of the same tool asks, in the way that asks most."""
    cuts = [(visit.tool, cut.kind) for visit in visits for cut in visit.cuts]
    asked = {one for way in ways(visits) for one in asked_next(way)}
    return [
        min((w_mm for at, by, w_mm in asked if (at, by) == (number, tool)), default=None)
        for number, (tool, kind) in enumerate(cuts)
        if kind in W_MM
    ]


marks = st.sampled_from(["", "", "/"])
cuts = st.builds(Cut, st.sampled_from(["ROUGH", "FINISH", "PROBE"]), marks)
visits = st.builds(Visit, st.integers(1, 2), st.lists(cuts, min_size=1, max_size=3).map(tuple), marks)
ROUGH = Cut("ROUGH")
FINISH = Cut("FINISH")


@pytest.mark.few(20)
@hypothesis_settings(deadline=None)
@given(st.lists(visits, min_size=1, max_size=4).map(lambda drawn: [drawn[0]._replace(mark=""), *drawn[1:]]))
@example([Visit(1, (ROUGH,)), Visit(2, (ROUGH,)), Visit(1, (ROUGH, ROUGH), "/"), Visit(1, (FINISH,))])
def test_no_way_of_the_program_asks_more_than_the_check_looks_for(visits: list[Visit]) -> None:
    found, wanted = limits(visits), tightest(visits)
    assert [w_mm is None for w_mm in found] == [w_mm is None for w_mm in wanted]
    assert all(a <= b for a, b in zip(found, wanted, strict=True) if a is not None and b is not None)
    if not any(one.mark for visit in visits for one in (visit, *visit.cuts)):
        assert found == wanted


def test_with_the_call_all_its_operations_may_be_left_out() -> None:
    """Without the second call of T1 its roughing is done by T2, and T1 finishes next."""
    last = Visit(1, (FINISH,))
    certain = [Visit(1, (ROUGH,)), Visit(2, (ROUGH,)), Visit(1, (ROUGH, ROUGH)), last]
    assert limits(certain)[0] == 0.05
    assert limits([*certain[:2], certain[2]._replace(mark="/"), last])[0] == 0.02
