"""Comments that are not closed, and comments inside comments, are said; none of ours closes another's."""

from __future__ import annotations

import pytest

import chipbreak
from machine_reader import beside_unproven

_CUT = "G97 S1000 M3\nG99 G0 X30. Z2.\nG1 Z-20. F0.1 N1.5\n"


def _said(program: str, profile: str = "fanuc-lathe") -> list[tuple[str, str, int]]:
    found = chipbreak.check(program.encode("latin-1"), chipbreak.load(profile))
    return [(d.code, d.severity.value, d.place.line if d.place else 0) for d in found]


def test_an_open_comment_is_said() -> None:
    assert _said("G0 X1.\n(APPROACH\nG0 X2.\nM30\n") == [("SYN003", "warning", 2)]


def test_an_open_comment_in_a_line_that_cannot_be_read() -> None:
    assert ("SYN003", "warning", 1) in _said("G0 X&1. (APPROACH\nM30\n")


def test_nothing_is_changed_behind_an_open_comment() -> None:
    assert _said(f"(APPROACH\n{_CUT}M30\n") == [("SYN003", "error", 1)]
    assert _said(_CUT.replace("N1.5", "N1.5 (CUT") + "M30\n") == [("SYN003", "error", 3)]


_ROUGH = "T0101\nG97 S1000 M3\nG99 G0 X30. Z2.\nG1 Z-20. F0.1\nG0 X40.\n"
_PROFILE = "vibration.n=1.5"


@pytest.mark.parametrize("comment", ["(ROUGH\n(CNMG 12)\n", "(ROUGH\n\n ( A\n(B)\n"])
def test_an_open_comment_that_other_comments_close_is_harmless(comment: str) -> None:
    """Wherever the control ends it, the same blocks run."""
    program = f"{comment}{_ROUGH}M30\n".encode()
    result = chipbreak.rewrite(program, chipbreak.load("fanuc-lathe", [_PROFILE]))
    assert len(result.cuts) == 1
    assert chipbreak.restore(result.data) == program
    assert result.data.startswith(comment.encode())
    assert {d.severity.value for d in result.diagnostics if d.code == "SYN003"} == {"warning"}


@pytest.mark.parametrize(
    "comment",
    [f"(ROUGH\n{one}(CNMG 12)\n" for one in ("S1000\n", "#1=5\n", "N7\n", "N7 ", "%\n")] + ["(ROUGH\n"],
)
def test_cuts_behind_an_open_comment_stay_where_the_profile_asks(comment: str) -> None:
    program = f"{_ROUGH}{comment}{_ROUGH}M30\n".encode()
    result = chipbreak.rewrite(program, chipbreak.load("fanuc-lathe", [_PROFILE]))
    assert len(result.cuts) == 1
    assert chipbreak.restore(result.data) == program
    assert result.data.endswith(f"{comment}{_ROUGH}M30\n".encode())
    (left,) = [one for one in result.left if one.is_cut]
    assert left.said.code == "SYN003"


@pytest.mark.parametrize("comment", ["(ROUGH\n", "(ROUGH\n(CNMG 12)\n"])
def test_cycles_behind_an_open_comment(comment: str) -> None:
    cycle = "G0 X40. Z2.\nG71 U2. R1.\nG71 P1 Q2 U1. W0.1 F0.2\nN1 G0 X20.\nG1 Z-15.\nN2 X40.\n"
    program = f"T0101\nG99 G97 S1000 M3\n{comment}{cycle}M30\n".encode()
    for asked in (_PROFILE, 'cycles.unroll="always"'):
        settings = chipbreak.load("fanuc-lathe", [asked])
        if "CNMG" in comment:
            assert chipbreak.rewrite(program, settings).changed
        elif asked == _PROFILE:
            assert chipbreak.rewrite(program, settings).data == program
        else:
            with pytest.raises(chipbreak.ProgramRejectedError) as refused:
                chipbreak.rewrite(program, settings)
            assert {d.code for d in refused.value.diagnostics} == {"SYN003"}


def test_what_is_changed_before_it_stays_changed() -> None:
    program = f"{_CUT}G0 X50.\n(END\nM30\n".encode()
    result = chipbreak.rewrite(program, chipbreak.load("fanuc-lathe"))
    assert result.changed
    assert [d.code for d in beside_unproven(result.diagnostics)] == ["SYN003"]


@pytest.mark.parametrize("line", ["; (APPROACH", "(A) ; (B", "(A", "(A))", "((A)"])
def test_only_what_is_open_counts(line: str) -> None:
    is_said = ("SYN003", "warning", 1) in _said(f"{line}\nM30\n")
    assert is_said == (line == "(A")


def test_a_comment_in_a_comment_where_the_control_stops_on_it() -> None:
    said = _said("(ROUGH TURN (2))\n(A (B))\nM2\n", "linuxcnc-lathe")
    assert said == [("SYN004", "warning", 1)]
    assert _said("(ROUGH TURN (2))\nM30\n") == []


def test_words_behind_a_comment_in_a_comment() -> None:
    assert ("SYN004", "warning", 1) in _said("(TOOL (OLD) X50. F0.3\nM30\n")


def test_an_unreadable_rest_behind_a_comment_in_a_comment() -> None:
    program = b"(STOCK DIAMETER (X): 30.0 MM)\nM30\n"
    (found,) = chipbreak.check(program, chipbreak.load("fanuc-lathe"))
    assert "the comment has ended at its first" in found.message
    assert found.code == "SYN001"
    assert found.help.startswith("take the inner parentheses out")
    fixed = program.replace(b"(X)", b"X")
    assert chipbreak.check(fixed, chipbreak.load("fanuc-lathe")) == ()
