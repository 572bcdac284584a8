"""Behind a refused cut some more are tried, so that one run says more than one thing, and not all."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.text.diagnostics import Diagnostic

# Too short for a vibration, which planning says.
REFUSED, FINE = "G1 Z1.98 F0.05 N1.5", "G1 Z-3. F0.05 N1.5"


def refused(*cuts: str) -> tuple[Diagnostic, ...]:
    """What a program with these cuts is told."""
    passes = "".join(f"G0 X20. Z2.\n{cut}\nG0 X30.\n" for cut in cuts)
    data = f"G97 S1200 M3\n{passes}M30\n".encode()
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(data, chipbreak.load("generic-lathe"))
    return caught.value.diagnostics


def said(*cuts: str) -> list[tuple[str, int]]:
    """The same, as code and line."""
    return [(one.code, one.place.line if one.place else 0) for one in refused(*cuts)]


def test_the_last_that_is_tried() -> None:
    """Two hundred behind the refused one are, and the next is the first that is not."""
    assert len(said(REFUSED, *[FINE] * 199, REFUSED)) == 2
    codes = dict(said(REFUSED, *[FINE] * 199, REFUSED, REFUSED))
    assert len(codes) == 2
    assert codes["VIB098"] == 3 + 3 * 201


def test_so_many_refused_ones_are_said() -> None:
    """Twenty are, then that the others were not tried."""
    assert [code for code, _ in said(*[REFUSED] * 20)] == ["VIB013"] * 20
    found = said(*[REFUSED] * 21)
    assert [code for code, _ in found] == ["VIB013"] * 20 + ["VIB098"]
    assert found[-1][1] == 3 + 3 * 20


LATHE = "linuxcnc-lathe"
HEAD = "G21 G18 G90 G95\nG97 S1200 M3\n"


def said_on_linuxcnc(*cuts: str) -> list[tuple[str, int]]:
    """The same on a control whose law is gone through again and again."""
    passes = "".join(f"G0 X20. Z2.\n{cut}\nG0 X30.\n" for cut in cuts)
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(f"{HEAD}{passes}M30\n".encode(), chipbreak.load(LATHE))
    return [(one.code, one.place.line if one.place else 0) for one in caught.value.diagnostics]


def test_fewer_are_tried_where_each_takes_long() -> None:
    """Twenty behind the refused one."""
    assert said_on_linuxcnc(REFUSED, *["(VIB OFF)"] * 19, REFUSED)[-1] == ("VIB013", 4 + 3 * 20)
    few = said_on_linuxcnc(REFUSED, *["G1 Z-3. F0.05 N1.5"] * 19, REFUSED, REFUSED)
    assert few == [("VIB013", 4), ("VIB013", 4 + 3 * 20), ("VIB098", 4 + 3 * 21)]


def test_a_long_one_behind_a_refused_one_is_not_tried() -> None:
    """Of which each block would be planned for nothing; alone it is."""
    long = "(VIB WAVE SINE N1.5)\nG1 X30. Z-60. F0.05"
    codes = said_on_linuxcnc(REFUSED, long)
    assert codes == [("VIB013", 4), ("VIB098", 8)]
    whole = f"{HEAD}G0 X20. Z2.\n{long}\nG0 X30.\nM30\n".encode()
    assert len(chipbreak.rewrite(whole, chipbreak.load(LATHE)).cuts) == 1


def test_what_is_before_the_refused_one_does_not_count() -> None:
    """However many cuts are fine, those behind the first error are tried."""
    found = said(*[FINE] * 30, REFUSED, *[FINE] * 30, REFUSED)
    assert [line for _, line in found] == [3 + 3 * 30, 3 + 3 * 61]


def test_all_is_tried_where_none_is_refused() -> None:
    """A long program is not an error."""
    passes = f"G0 X20. Z2.\n{FINE}\nG0 X30.\n" * 203
    result = chipbreak.rewrite(f"G97 S1200 M3\n{passes}M30\n".encode(), chipbreak.load("generic-lathe"))
    assert len(result.cuts) == 203


# Half the stroke that it would need, which is known once its blocks are made.
WHOLE_CHIPS = "G1 Z-3. F0.05 N1.5 Q0.5"


def test_so_many_with_whole_chips_are_said() -> None:
    """As of those that planning refuses, and what would work for the first three."""
    assert [code for code, _ in said(*[WHOLE_CHIPS] * 20)] == ["VIB060"] * 20
    found = said(*[WHOLE_CHIPS] * 21)
    assert [code for code, _ in found] == ["VIB060"] * 20 + ["VIB098"]
    assert found[-1][1] == 3 + 3 * 20


def test_whole_chips_behind_cuts_that_break_them() -> None:
    """Each kind of cut is looked at, however many of another kind have held."""
    found = said(*[FINE] * 5, *[WHOLE_CHIPS, FINE] * 21)
    assert [code for code, _ in found] == ["VIB060"] * 20 + ["VIB098"]
    assert found[0][1] == 3 + 3 * 5
    assert found[-1][1] == 3 + 3 * (5 + 39)


@pytest.mark.parametrize("count", [3, 21])
def test_what_works_is_said_with_few_and_with_many(count: int) -> None:
    """For the first three."""
    helped = [one.help.startswith("works: Q 1.") for one in refused(*[WHOLE_CHIPS] * count)]
    assert helped[:4] == [True, True, True, False][:count]


def test_whole_chips_that_are_let_pass_end_nothing() -> None:
    """However many there are."""
    passes = f"G0 X20. Z2.\n{WHOLE_CHIPS}\nG0 X30.\n" * 21
    data = f"G97 S1200 M3\n{passes}M30\n".encode()
    result = chipbreak.rewrite(data, chipbreak.load("generic-lathe"), allow_unbroken=True)
    assert len(result.cuts) == 21


UNREAD, UNREAD_SAYS = "(VIB N1.5)\nX2O.", ["VIB065", "VIB018"]


def test_only_the_first_are_tried_where_the_program_is_refused_anyway() -> None:
    """A line that cannot be read is said before any cut is planned."""
    assert [code for code, _ in said(*[FINE] * 199, REFUSED, UNREAD)] == ["VIB013", *UNREAD_SAYS]
    assert [code for code, _ in said(*[FINE] * 200, REFUSED, UNREAD)] == ["VIB098", *UNREAD_SAYS]
