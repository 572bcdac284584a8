"""Tools that have no edge to be looked at are not checked, and it is said where the first of them cuts."""

from __future__ import annotations

import chipbreak
from beam import BEAM

from .test_plan import END, HEAD, visit

PROBE = "(T1  D=6. CR=0. - ZMIN=-1. - PROBE)\n"


def test_a_tool_without_an_edge_is_said_where_it_cuts_first() -> None:
    program = HEAD + PROBE + visit(1, "ROUGH", "FINISH") + visit(2, "ROUGH") + END
    result = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-mill", BEAM))
    said = [
        (one.code, one.severity.value, one.place and one.place.line, one.message, one.help)
        for one in result.diagnostics
        if one.code == "CHK005"
    ]
    assert said == [
        (
            "CHK005",
            "note",
            11,
            'T1 has no edge to measure, so it is not checked: "probe" (comment in line 5)',
            "",
        )
    ]
    assert b"CHECK T1" not in result.data and b"CHECK T2" in result.data


def test_a_sister_that_cuts_itself_is_said_where_it_cuts_first() -> None:
    program = HEAD + visit(1, "ROUGH") + visit(12, "ROUGH", "FINISH") + visit(12, "FINISH") + END
    options = (*BEAM, "checks.sister.1=12")
    result = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-mill", options))
    assert [one.place and one.place.line for one in result.diagnostics if one.code == "CHK008"] == [22]
