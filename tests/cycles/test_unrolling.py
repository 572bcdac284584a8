"""Cycles on the whole way: what is asked is written out and vibrates, what is not stays byte for byte."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import chipbreak
from chipbreak.editing.bracket import CHANGES, UNROLLED_CYCLES
from chipbreak.editing.restore import regions
from chipbreak.model.interpreted_program import interpret
from chipbreak.settings import load
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import ProgramRejectedError
from chipbreak.text.source import read
from longer import short_where

SAMPLE = (Path(__file__).parents[2] / "samples" / "roughing.nc").read_bytes()
CONTOUR = b"N10 G0 X16. F0.1\nG1 Z-15.\nX30. Z-30.\nN20 X52.\n"
CYCLE = b"""G21 G40 G99
T0101
G97 S1200 M3
G0 X52. Z2.
G71 U2. R0.5
G71 P10 Q20 U0.4 W0.1 F0.3
N10 G0 X16. F0.1
G1 Z-15.
X30. Z-30.
N20 X52.
G70 P10 Q20
G0 X100. Z100.
M30
"""
ALWAYS = ['cycles.unroll="always"']


def filtered(program: bytes, *options: str, profile: str = "fanuc-lathe") -> bytes:
    return chipbreak.rewrite(program, load(profile, options)).data


def without_vibration(output: bytes) -> bytes:
    """The program with its cycles written out, as the passes saw it."""
    source = read(output)
    pieces = []
    line = 0
    for region in regions(source, CHANGES):
        pieces += [source.data[source.starts[line] : source.starts[region.first]], region.original]
        line = region.last
    return b"".join([*pieces, source.data[source.starts[line] :]])


def cut_lines(program: bytes) -> Iterator[str]:
    for line in program.decode().splitlines():
        if re.match(r"G[123] ", line):
            yield line


@pytest.mark.parametrize(
    "options", [(), ("vibration.n=1.5", 'vibration.only=["drill"]'), ('cycles.unroll="never"',)]
)
def test_what_nobody_asks_stays_byte_for_byte(options: tuple[str, ...]) -> None:
    assert filtered(CYCLE, *options) == CYCLE


# The sample with all that may be asked, other line ends with one of these.
_WAYS = [ALWAYS, ["vibration.n=1.5"], ["vibration.n=1.5", 'vibration.only=["rough", "finish"]']]
_PUT_BACK = short_where(
    [
        (program, options)
        for program in (SAMPLE, CYCLE, CYCLE.replace(b"\n", b"\r\n"), CYCLE[:-1])
        for options in _WAYS
    ],
    lambda case: case[0] == SAMPLE or case[1] == ALWAYS,
)


@pytest.mark.parametrize(("program", "options"), _PUT_BACK)
def test_it_is_put_back_and_a_second_run_changes_nothing(program: bytes, options: list[str]) -> None:
    output = filtered(program, *options)
    assert b"(CHIPBREAK UNROLLED G71 P10 Q20)" in output
    assert chipbreak.restore(output) == program
    assert filtered(output, *options) == output
    assert chipbreak.verify(output, load("fanuc-lathe", options)).data == output


def test_an_edited_part_is_refused() -> None:
    output = filtered(CYCLE, *ALWAYS)
    for edited in (output.replace(b"G0 X48.", b"G0 X47."), output.replace(b"ROLLED ", b"ROLED ", 9)):
        with pytest.raises(ProgramRejectedError):
            chipbreak.restore(edited.replace(b"UNROLED", b"UNROLLED"))


def test_every_roughing_pass_of_the_sample_vibrates_and_nothing_else() -> None:
    output = filtered(SAMPLE)
    source = read(output)
    inner = [region for region in regions(source) if region.title.startswith("VIB ")]
    asked = [line for region in inner for line in region.original.decode().splitlines()]
    opened = without_vibration(output)
    (rough, contour, finish) = regions(read(opened), UNROLLED_CYCLES)
    body = read(opened)
    of_rough = [body.text(line) for line in range(rough.body, rough.last)]
    assert asked == [line for line in of_rough if re.match(r"G[123] ", line)]
    assert len(asked) >= 15
    assert contour.body == contour.last - 1, "nothing stands for the contour"
    shape = SAMPLE[SAMPLE.index(b"N10 ") : SAMPLE.index(b"G0 X100.")].decode().splitlines()
    assert [body.text(line) for line in range(finish.body, finish.last - 1)] == [
        *(re.sub(r"^N[0-9]+ ", "", line) for line in shape),
        "G0 Z2.",
    ]
    behind = SAMPLE[SAMPLE.index(b"T0303") :]
    assert output.endswith(behind)


def test_a_message_names_the_line_of_the_users_file() -> None:
    result = chipbreak.rewrite(SAMPLE, load("fanuc-lathe"))
    lines = {cut.plan.chain.first for cut in result.cuts}
    assert {result.source.place(line).line for line in lines} == {8}
    again = chipbreak.rewrite(result.data, load("fanuc-lathe"))
    kept = result.data[: result.data.index(b"(CHIPBREAK WAS G71")].count(b"\n") + 1
    assert {again.source.place(line).line for line in lines} == {kept}


def test_kinds_of_operations_stay_what_they_were() -> None:
    plain = chipbreak.rewrite(CYCLE, load("fanuc-lathe")).operations
    written = chipbreak.rewrite(CYCLE, load("fanuc-lathe", ALWAYS)).operations
    assert [(o.kind, o.tool, o.label) for o in written] == [(o.kind, o.tool, o.label) for o in plain]


def test_feed_and_place_behind_the_cycle_are_those_of_the_control() -> None:
    """The tool is back at the start, F of the cycle is in force; G70 leaves that of the contour."""
    settings = load("fanuc-lathe", ALWAYS)
    program = CYCLE.replace(b"G70 P10 Q20\n", b"")
    for text, feed in ((program, 0.3), (CYCLE, 0.1)):
        opened = interpret(parse(read(filtered(text, *ALWAYS)), settings.dialect), settings)
        line = next(
            n
            for n in range(opened.program.source.line_count)
            if opened.program.source.text(n) == "G0 X100. Z100."
        )
        state = opened.before(line)
        assert (state.position.x, state.position.z) == pytest.approx((26.0, 2.0))
        assert state.feed is not None
        assert state.feed.value == feed


@pytest.mark.parametrize(
    ("system", "codes"), [("B", (70, 71)), ("C", (72, 73))], ids=["system B", "system C"]
)
def test_other_code_systems_have_their_own_numbers(system: str, codes: tuple[int, int]) -> None:
    finish, rough = codes
    program = re.sub(rb"G71", f"G{rough}".encode(), CYCLE.replace(b"G70", f"G{finish}".encode()))
    program = program.replace(b"G21 G40 G99", b"G90 G40 G95")
    output = filtered(program, *ALWAYS, f"control.lathe_system={system}")
    mine = list(cut_lines(output))
    assert mine == list(cut_lines(filtered(CYCLE, *ALWAYS)))
    assert len(mine) == 12


def test_one_block_says_the_same_as_two() -> None:
    one = CYCLE.replace(b"G71 U2. R0.5\n", b"").replace(b"W0.1", b"W0.1 D2000")
    two = CYCLE
    assert list(cut_lines(filtered(one, *ALWAYS))) == list(cut_lines(filtered(two, *ALWAYS)))
    in_mm = one.replace(b"D2000", b"D2")
    rule = 'cycles.depth_unit="program"'
    assert list(cut_lines(filtered(in_mm, *ALWAYS, rule))) == list(cut_lines(filtered(two, *ALWAYS)))


def test_facing_goes_along_x() -> None:
    program = CYCLE.replace(b"G71 U2.", b"G72 W2.").replace(b"G71 P", b"G72 P")
    program = program.replace(
        b"N10 G0 X16. F0.1\nG1 Z-15.\nX30. Z-30.\nN20 X52.", b"N10 G0 Z-11.\nG1 X20.\nN20 Z2."
    )
    cuts = list(cut_lines(filtered(program, *ALWAYS)))
    assert cuts[:2] == ["G1 X20.4 F0.3", "G1 X20.4"]


def test_boring_goes_from_the_inside_out() -> None:
    program = CYCLE.replace(b"G0 X52. Z2.", b"G0 X18. Z2.").replace(b"U0.4", b"U-0.4")
    program = program.replace(
        b"X16. F0.1\nG1 Z-15.\nX30. Z-30.\nN20 X52.", b"X40. F0.1\nG1 Z-15.\nX30. Z-30.\nN20 X18."
    )
    output = filtered(program, *ALWAYS)
    assert b"\nG0 X22.\nG1 Z-35.9" not in output
    assert b"\nG0 X22.\nG1 Z-29.9 F0.3\n" in output


def test_inches_and_the_words_of_the_axes() -> None:
    program = CYCLE.replace(b"G21", b"G20")
    output = filtered(program, *ALWAYS)
    assert b"\nG0 X48.\nG1 Z-29.9 F0.3\n" in output


def test_a_contour_behind_the_end_of_the_program() -> None:
    program = CYCLE.replace(CONTOUR, b"") + CONTOUR
    assert list(cut_lines(filtered(program, *ALWAYS))) == list(cut_lines(filtered(CYCLE, *ALWAYS)))
    assert chipbreak.restore(filtered(program, *ALWAYS)) == program


STAYS = [
    (b"X30. Z-30.", b"X30. ,C100. Z-30.", "CYC002"),
    (b"X30. Z-30.", b"X30. Z-30. ,R1. C2.", "CYC002"),
    (b"N20 X52.", b"N20 X52. ,C1.", "CYC002"),
    (b"X30. Z-30.", b"X30. Z-30. ,A45.", "CYC002"),
    (b"X30. Z-30.", b"X30. Z-30. M98 P9", "CYC002"),
    (b"X30. Z-30.", b"X#1 Z-30.", "CYC002"),
    (b"G0 X52. Z2.", b"G0 X52.", "CYC007"),
    (b"F0.3", b"F0.3 M8", "CYC007"),
    (b"G71 U2. R0.5\n", b"G71 U0.002 R0.5\n", "CYC004"),
    (b"T0101", b"T0101\nG66 P9000", "CYC007"),
    (b"G71 U2. R0.5", b"G71 U2. R0.5 Q3", "CYC007"),
    (b"G1 Z-15.", b"(VIB OFF)\nG1 Z-15.", "CYC007"),
    (b"G0 X100.", b"G70 P10 Q#1\nG0 X100.", "CYC007"),
    (b"G0 X100.", b"M97 P10\nG0 X100.", "CYC007"),
    (b"G0 X100.", b"IF[#1EQ1]GOTO10\nG0 X100.", "CYC007"),
]


@pytest.mark.parametrize(("old", "new", "code"), STAYS)
def test_what_cannot_be_written_out_stays_with_all_that_share_its_contour(
    old: bytes, new: bytes, code: str
) -> None:
    program = CYCLE.replace(old, new, 1)
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert b"UNROLLED" not in result.data
    assert code in {d.code for d in result.diagnostics}
    assert code in {cut.said.code for cut in result.left}


@pytest.mark.parametrize(
    ("old", "new"),
    [(b"X30. Z-30.", b"X30. Z-30. M8"), (b"N20 X52.", b"N20 G42 X52."), (b"G0 X100.", b"G1 X50.\nG0 X100.")],
)
def test_a_finishing_cycle_that_stays_keeps_no_passes(old: bytes, new: bytes) -> None:
    """Coolant, G42 or F that its contour leaves: its control knows what it does with them."""
    program = CYCLE.replace(old, new, 1)
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert result.cuts
    assert b"\nG70 P10 Q20\n" in result.data
    assert chipbreak.restore(result.data) == program


@pytest.mark.parametrize(("old", "new", "code"), STAYS)
def test_what_a_comment_asks_and_cannot_be_is_an_error(old: bytes, new: bytes, code: str) -> None:
    program = CYCLE.replace(old, new, 1).replace(b"T0101", b"T0101\n(VIB N1.5)", 1)
    with pytest.raises(ProgramRejectedError) as caught:
        chipbreak.rewrite(program, load("fanuc-lathe"))
    assert code in {d.code for d in caught.value.diagnostics}


def test_cycles_whose_passes_cannot_vibrate_stay() -> None:
    """The spindle does not turn: written out, nothing would vibrate."""
    program = CYCLE.replace(b"M3", b"M5")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert result.data == program
    (said,) = [d for d in result.diagnostics if d.code == "VIB065"]
    assert "reached no cut" in said.message
    assert "while the spindle stands" in said.message
    assert chipbreak.rewrite(CYCLE, load("fanuc-lathe", ["vibration.n=1.5"])).data != CYCLE  # M3: the way out


def test_the_profile_asks_for_roughing_and_not_for_finishing() -> None:
    """One tool does both, so the operation is called a finishing one."""
    result = chipbreak.rewrite(CYCLE, load("fanuc-lathe", ["vibration.n=1.5"]))
    (finish,) = [
        i for i, text in enumerate(result.data.split(b"\n")) if text.startswith(b"(CHIPBREAK UNROLLED G70")
    ]
    assert b"BEGIN VIB" not in b"\n".join(result.data.split(b"\n")[finish:])
    assert len(result.cuts) == 9
    both = chipbreak.rewrite(
        CYCLE, load("fanuc-lathe", ["vibration.n=1.5", 'vibration.only=["rough", "finish"]'])
    )
    assert len(both.cuts) == 10


def test_the_retract_of_the_profile_counts_where_the_cycle_says_none() -> None:
    program = CYCLE.replace(b" R0.5", b"")
    assert filtered(program, *ALWAYS).count(b"G0 X49. Z-29.4\n") == 1
    assert filtered(program, *ALWAYS, "cycles.retract_mm=1").count(b"G0 X50. Z-28.9\n") == 1


def test_numbers_may_repeat_where_each_contour_is_right_behind_its_cycle() -> None:
    again = CYCLE[CYCLE.index(b"G0 X52.") : CYCLE.index(b"G70")].replace(b"Z-15.", b"Z-12.")
    one = CYCLE.replace(b"G70 P10 Q20\n", b"")
    output = filtered(one.replace(b"M30", again + b"M30"), *ALWAYS)
    assert output.count(b"UNROLLED G71") == 2


def test_a_word_of_the_cycle_asks_for_all_its_cuts() -> None:
    program = CYCLE.replace(b"F0.3", b"F0.3 N1.5")
    result = chipbreak.rewrite(program, load("fanuc-lathe"))
    assert len(result.cuts) == 9
    assert b"G1 Z-29.9 F0.3 N1.5)" in result.data
    assert chipbreak.restore(result.data) == program
    finish = CYCLE.replace(b"G70 P10 Q20", b"G70 P10 Q20 N1.5")
    result = chipbreak.rewrite(finish, load("fanuc-lathe"))
    assert [cut.plan.chain.first for cut in result.cuts], "the contour of the finishing cycle"
    assert b"UNROLLED G71" in result.data, "it shares the contour"
    assert b"(CHIPBREAK WAS X30. Z-30. N1.5)" in result.data


@pytest.mark.parametrize("unroll", ["always", "asked"])
def test_a_word_of_a_cycle_that_stays_is_an_error(unroll: str) -> None:
    program = CYCLE.replace(b"F0.3", b"F0.3 N1.5").replace(b"X30. Z-30.", b"X#1 Z-30.")
    with pytest.raises(ProgramRejectedError) as caught:
        chipbreak.rewrite(program, load("fanuc-lathe", [f'cycles.unroll="{unroll}"']))
    assert [d.code for d in caught.value.diagnostics if d.severity.value == "error"] == ["CYC002"]


def test_of_repeated_numbers_the_control_takes_the_next_and_it_is_said() -> None:
    again = CYCLE[CYCLE.index(b"G0 X52.") : CYCLE.index(b"G70")].replace(b"Z-15.", b"Z-12.")
    between = chipbreak.rewrite(CYCLE.replace(b"M30", again + b"M30"), load("fanuc-lathe", ALWAYS))
    finish = between.data[between.data.index(b"UNROLLED G70") :]
    assert b"\nG1 Z-12.\n" in finish[: finish.index(b"G0 X100.")], "the G70 stands before the second contour"
    said = [(d.place.line, d.message) for d in between.diagnostics if d.code == "CYC008" and d.place]
    assert said == [
        (6, "N10 stands on 2 blocks: the next one, in line 7, is taken"),
        (11, "N10 stands on 2 blocks: the next one, in line 16, is taken"),
        (15, "N10 stands on 2 blocks: the next one, in line 16, is taken"),
    ]
    assert chipbreak.restore(between.data) == CYCLE.replace(b"M30", again + b"M30")


def test_where_none_stands_behind_the_cycle_the_control_begins_from_the_top() -> None:
    again = CYCLE[CYCLE.index(b"G0 X52.") : CYCLE.index(b"G0 X100.")].replace(b"Z-15.", b"Z-12.")
    program = CYCLE.replace(b"G70 P10 Q20\n", b"").replace(b"M30", again + b"M30")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    finish = result.data[result.data.index(b"UNROLLED G70") :]
    assert b"\nG1 Z-15.\n" in finish
    assert "none stands behind the cycle, so the first one, in line 7" in str(
        [d.message for d in result.diagnostics if d.code == "CYC008"]
    )


def test_the_way_back_at_the_end_of_a_contour_is_no_part_of_its_shape() -> None:
    """``G0 G40 Z2.`` above the stock: roughed as without it, and run by the finishing cut."""
    closed = CYCLE.replace(b"N10 G0 X16.", b"N10 G42 G0 X16.").replace(
        b"N20 X52.\n", b"X52.\nN20 G40 G0 Z2.\n"
    )
    written = filtered(closed, *ALWAYS)
    rough = written.split(b"ROLLED")[1]
    assert rough.split(b"PASS 1")[1] == filtered(CYCLE, *ALWAYS).split(b"ROLLED")[1].split(b"PASS 1")[1]
    assert b"G40 G0 Z2.\n" in written.split(b"UNROLLED G70")[1]
    assert chipbreak.restore(written) == closed


def test_explain_says_passes_depth_and_time_of_each_cycle() -> None:
    """16 mm in passes of 2 (17.8 less the allowance), and one along the contour."""
    machine = ['planner.model="trapezoid"', "axes.X.max_acceleration_mm_s2=5000", 'vibration.n="auto"']
    settings = load("fanuc-lathe", [*machine, "axes.Z.max_acceleration_mm_s2=5000"])
    report = chipbreak.explain(chipbreak.rewrite(CYCLE, settings), settings)
    rough, finish = report.cycles
    assert (rough.line, rough.block, rough.kind, rough.passes, rough.depth_mm) == (
        5, "G71 P10 Q20", "rough", 9, 2.0,
    )  # fmt: skip
    assert rough.vibrated == sum(5 <= cut.first_line <= 6 for cut in report.cuts) > 0
    assert (finish.kind, finish.passes, finish.depth_mm, finish.vibrated) == ("finish", 1, None, 0)
    assert rough.after_s == pytest.approx(
        rough.before_s + sum(cut.duration_s - (cut.programmed_s or 0.0) for cut in report.cuts)
    )
    assert finish.after_s == finish.before_s > 0.0
    assert rough.before_s + finish.before_s < (report.time.before_s if report.time else 0.0)
    text = str(report)
    assert "Cycles written out: 2" in text
    assert re.search(r"line 5: G71 P10 Q20: 9 passes of 2 mm, \d+ vibrated cuts, 0:\S+ as programmed, ", text)
    assert report.as_dict()["cycles"][0]["passes"] == 9


def test_compensation_in_force_at_a_roughing_cycle_comes_back_behind_it() -> None:
    under = CYCLE.replace(b"G0 X52. Z2.\n", b"G42 G0 X52. Z2.\n").replace(b"G0 X100.", b"G40 G0 X100.")
    result = chipbreak.rewrite(under, load("fanuc-lathe", ALWAYS))
    rough = result.data.split(b"UNROLLED G71")[1].split(b"ROLLED")[0]
    assert b"\nG40 G0 X52. Z2.\n(PASS 1 " in rough
    assert rough.rstrip(b" (CHIPBREAK").endswith(b"\nG42\n") or b"\nG42\n(CHIPBREAK" in rough
    assert [d.place.line for d in result.diagnostics if d.code == "CYC009" and d.place] == [6]
    assert chipbreak.restore(result.data) == under
    stays = load("fanuc-lathe", [*ALWAYS, 'cycles.nose_in_roughing="compensated"'])
    left = chipbreak.rewrite(under, stays)
    assert not left.changed
    assert any("compensates the nose" in d.message for d in left.diagnostics)


def test_a_pattern_under_compensation() -> None:
    pattern = CYCLE.replace(b"G71 U2. R0.5\nG71", b"G73 U4. W1. R3\nG73").replace(
        b"G0 X52. Z2.\n", b"G42 G0 X52. Z2.\n"
    )
    written = filtered(pattern.replace(b"G0 X100.", b"G40 G0 X100."), *ALWAYS)
    assert written.count(b"(PASS ") == 3
    assert b"\nG40 G0 X52. Z2.\n(PASS 1 " in written


@pytest.mark.parametrize(
    ("behind", "why"),
    [
        ("G0 X60. Z5.\nG1 Z-5.\n", "says no F"),
        ("G0 X60. Z5.\nG1 Z-5. F0.2\n", ""),
        ("G0 X60. Z5.\nF0.2\nG1 Z-5.\n", ""),
        ("", ""),
    ],
)
def test_a_cut_behind_a_finishing_cycle_says_its_own_feed(behind: str, why: str) -> None:
    """Whether the F of the contour is in force behind G70 no page of a maker says."""
    program = CYCLE.replace(b"G0 X100. Z100.", behind.encode() + b"G0 X100. Z100.")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    assert (b"UNROLLED G70" in result.data) is not bool(why)
    assert not why or any(why in d.message for d in result.diagnostics)


AGAIN = "G0 X52. Z2.\nG70 P10 Q20\n"


@pytest.mark.parametrize(
    ("behind", "written"),
    [
        (AGAIN * 3, 4),  # nothing cuts behind the last
        (AGAIN * 3 + "G1 X60. F0.2\n", 4),
        (AGAIN * 3 + "G1 X60.\n", 0),  # none of them has its F said
        (AGAIN + "G1 X60. F0.2\n" + AGAIN + "G1 X60.\n", 2),
        (AGAIN + "G1 X60.\n" + AGAIN + "G1 X60. F0.2\n", 1),
        ("G1 X60. F0.2\n" + AGAIN + "F0.2\n" + AGAIN + "F0.2\nG1 X60.\n", 3),
    ],
)
def test_what_cuts_behind_several_finishing_cycles(behind: str, written: int) -> None:
    """Each is asked for what comes behind it, whatever another one was asked for."""
    program = CYCLE.replace(b"G0 X100. Z100.", behind.encode() + b"G0 X100. Z100.")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    assert result.data.count(b"UNROLLED G70") == written
    stays = [d.message for d in result.diagnostics if "says no F" in d.message]
    assert len(stays) == 1 + behind.count("G70") - written


@pytest.mark.parametrize("options", [ALWAYS, ["vibration.n=1.5"]], ids=str)
def test_a_long_comment_of_a_contour_is_no_reason_to_refuse_the_program(options: list[str]) -> None:
    """The block is written without it, for the control takes no longer one; the bracket keeps it."""
    long = b"X30. Z-30. (THE TAPER OF THE SHOULDER, WHICH THE DRAWING GIVES AS 26.565 DEGREES TO THE AXIS)"
    program = CYCLE.replace(b"X30. Z-30.", long).replace(b"N20 X52.", b"N20 X52. (" + b"A" * 90 + b")")
    output = filtered(program, *options)
    assert output.count(b"\nX30. Z-30.\n") == 1, "the finishing cycle copies the contour"
    assert chipbreak.restore(output) == program


def test_a_long_comment_under_compensation_is_no_reason_to_refuse_the_program() -> None:
    move = b"Z-30. (" + b"B" * 90 + b")"
    program = b"T0101\nG97 S800 M3\nG0 X40. Z2.\nG1 G42 X30. Z0. F0.2\n" + move + b"\nG0 G40 X60.\nM30\n"
    options = ["vibration.n=1.5", "tools.nose_radius_mm.1=0.8", "tools.nose_tip.1=3"]
    output = filtered(program, *options)
    assert b"(CHIPBREAK COMPENSATED" in output
    assert chipbreak.restore(output) == program


BEFORE = CYCLE.replace(CONTOUR, b"").replace(b"G0 X52. Z2.\n", b"G0 X52. Z2.\n" + CONTOUR)


def test_a_contour_before_its_cycle_is_cut_where_it_stands() -> None:
    """The control comes to it first: taking it out would take cuts out, so the cycle stays and says why."""
    result = chipbreak.rewrite(BEFORE, load("fanuc-lathe", ALWAYS))
    assert result.data == BEFORE
    (said,) = [one for one in result.diagnostics if one.code == "CYC002"]
    assert "the contour in line 5 stands before its cycle" in said.message
    behind = interpret(parse(read(BEFORE), load("fanuc-lathe").dialect), load("fanuc-lathe"))
    assert behind.before(8).position[::2] == (26.0, -30.0), "the blocks of the contour move"


def test_the_way_out_of_a_contour_before_its_cycle() -> None:
    """``CYCLE`` is the same with the contour behind."""
    assert b"(CHIPBREAK UNROLLED G71 P10 Q20)" in filtered(CYCLE, *ALWAYS)


FACED = CYCLE.replace(b"G71 U2.", b"G94 X-1. Z0. F0.2\nG71 U2.", 1)


@pytest.mark.parametrize("options", [ALWAYS, ["vibration.n=1.5"]], ids=str)
def test_a_cycle_behind_a_modal_one_is_written_out(options: list[str]) -> None:
    """Hand-written programs face with G94 and rough with G71 straight behind it."""
    output = filtered(FACED, *options)
    assert b"(CHIPBREAK UNROLLED G71 P10 Q20)" in output
    assert b"(CHIPBREAK UNROLLED G70 P10 Q20)" in output
    assert chipbreak.restore(output) == FACED
    assert filtered(output, *options) == output


def test_where_the_next_move_counts_on_the_modal_code_the_cycle_stays_and_the_way_out_works() -> None:
    program = FACED.replace(b"G0 X100. Z100.", b"X20. Z-1.\nG0 X100. Z100.")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    assert b"(CHIPBREAK UNROLLED G71" not in result.data
    assert any("says no motion code of its own" in one.message for one in result.diagnostics)
    output = filtered(program.replace(b"X20. Z-1.", b"G0 X20. Z-1."), *ALWAYS)
    assert b"(CHIPBREAK UNROLLED G71 P10 Q20)" in output


PART = "N1000 G71 U1.5 R.5\nG71 P1 Q2 U.3 W.1 F.2\nN1 G0 X20. Z1.\nG1 Z-15. F.1\nN2 X48.\nM99\n"


@pytest.mark.parametrize("times", ["", " L2"])
def test_a_cycle_with_which_a_part_begins_does_not_start_where_the_program_before_it_ended(
    times: str,
) -> None:
    """It starts where its call stands, X50 and not X100; called twice, nobody knows where the second time."""
    main = f"T0101\nG97 S800 M3\nG0 X50. Z2.\nM97 P1000{times}\nG0 X100. Z100.\nM30\n"
    program = f"{main}{PART}".encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    if times:
        assert result.data == program
        assert any("where this cycle starts is not known" in one.message for one in result.diagnostics)
    else:
        assert b"(PASS 1 LEVEL 1.5 MM BELOW THE START)\nG0 Z2.1\nG0 X47.\n" in result.data
        assert chipbreak.restore(result.data) == program


COMPENSATED = CYCLE.replace(b"N10 G0 X16.", b"N10 G0 G42 X16.").replace(b"G0 X100.", b"G40 G0 X100.")


@pytest.mark.parametrize("options", [ALWAYS, ["vibration.n=1.5"]], ids=str)
@pytest.mark.parametrize(
    "end",
    [b"G40 G0 X100. Z100.", b"G40\nG0 X100. Z100.", b"M9\nG40\nG0 X100. Z100.", b"G0 G40 X100. Z100."],
)
def test_compensation_of_the_contour_may_end_behind_its_finishing_cycle(
    end: bytes, options: list[str]
) -> None:
    """Most programs begin it in the first block of the contour and end it in the move away."""
    program = COMPENSATED.replace(b"G40 G0 X100. Z100.", end)
    output = filtered(program, *options)
    assert b"(CHIPBREAK UNROLLED G71 P10 Q20)" in output
    finish = output.partition(b"(CHIPBREAK UNROLLED G70 P10 Q20)")[2].partition(b"(CHIPBREAK ROLLED")[0]
    assert b"\nG0 G42 X16. F0.1\n" in finish
    assert b"G40" not in finish, "it holds to the move away, as on the control"
    assert chipbreak.restore(output) == program
    assert filtered(output, *options) == output


@pytest.mark.parametrize(
    "behind", [b"G0 X100. Z100.", b"G28 U0 W0\nG40", b"G1 X60. F0.2\nG40", b"/G40\nG0 X100."]
)
def test_one_that_goes_on_behind_the_cycle_keeps_it_as_it_is(behind: bytes) -> None:
    """The passes before it are written; it finds its contour behind the end."""
    program = COMPENSATED.replace(b"G40 G0 X100. Z100.", behind)
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    assert b"UNROLLED G71" in result.data
    assert b"UNROLLED G70" not in result.data
    assert b"\nG70 P10 Q20\n" in result.data
    assert chipbreak.restore(result.data) == program
    assert any("leaves another compensation in force" in one.message for one in result.diagnostics)


def test_a_cycle_that_runs_while_the_spindle_stands_is_no_cut() -> None:
    """As its moves are none; a wish by a word is not passed over."""
    program = CYCLE.replace(b" M3", b"")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert result.data == program
    assert [one.code for one in result.diagnostics] == ["VIB065"]
    with pytest.raises(ProgramRejectedError):
        filtered(program.replace(b"F0.3\n", b"F0.3 N1.5\n", 1), "vibration.n=1.5")


BEHIND_THE_END = b"""G21 G40 G99
T0101
G97 S1200 M3
G0 X52. Z2.
G71 U2. R0.5
G71 P10 Q20 U0.4 W0.1 F0.3
G70 P10 Q20
G1 X50.
G0 X100. Z100.
M30
N10 G0 X16. F0.1
G1 Z-15.
X30. Z-30.
N20 X52.
"""


@pytest.mark.parametrize("options", [ALWAYS, ["vibration.n=1.5"]], ids=str)
def test_a_finishing_cycle_that_stays_does_not_keep_the_passes_where_nothing_comes_to_its_contour(
    options: list[str],
) -> None:
    """The cut behind it says no F, so it stays, with its contour behind M30; the passes do not need it."""
    result = chipbreak.rewrite(BEHIND_THE_END, load("fanuc-lathe", options))
    assert b"UNROLLED G71" in result.data
    assert b"\nG70 P10 Q20\n" in result.data
    assert result.data.endswith(BEHIND_THE_END[BEHIND_THE_END.index(b"N10") :])
    assert chipbreak.restore(result.data) == BEHIND_THE_END
    assert chipbreak.rewrite(result.data, load("fanuc-lathe", options)).data == result.data
    assert bool(result.cuts) is (options != ALWAYS)
    said = [one for one in result.diagnostics if one.code == "CYC007"]
    assert len(said) == (options == ALWAYS), "of the finishing cycle, where it was asked"


def test_a_contour_on_the_way_of_the_program_that_cannot_go_behind_its_end_keeps_the_passes() -> None:
    """It is said because of which cycle."""
    program = CYCLE.replace(b"G0 X100.", b"G1 X50.\nG0 X100.").replace(b"M30", b"/M30")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert result.data == program
    (said,) = [one for one in result.diagnostics if one.code == "CYC007"]
    assert said.place is not None and said.place.line == 6
    assert said.message.startswith(
        "the cycle in line 11 needs the same contour and cannot be written out: G1 X50."
    )


@pytest.mark.parametrize("control", ["fanuc-lathe", "haas-lathe"])
def test_the_finishing_cycle_that_stays_finds_what_it_would_have_found(control: str) -> None:
    """Place, F, S and modes before it are those of the original."""
    settings = load(control, ALWAYS)
    written = chipbreak.rewrite(BEHIND_THE_END, settings).data
    states = []
    for program in (BEHIND_THE_END, written):
        interpreted = interpret(parse(read(program), settings.dialect), settings)
        line = program.decode().splitlines().index("G70 P10 Q20")
        states.append(interpreted.before(line))
    assert states[1].position[::2] == (26.0, 2.0)
    assert states[0].modes == states[1].modes
    for name in ("feed", "speed"):
        before, after = (getattr(state, name) for state in states)
        assert before.text.rstrip(".") == after.text.rstrip(".")


def without_comments(data: bytes) -> list[str]:
    return [line for line in data.decode().splitlines() if not line.startswith("(")]


LONGER = CYCLE.replace(b"G70 P10 Q20", b"N21 Z2.\nG70 P10 Q21")


def test_a_finishing_cycle_may_call_more_than_the_roughing_one() -> None:
    """The block behind the shape of the roughing cycle runs there, and again as the last one of G70."""
    output = filtered(LONGER, *ALWAYS)
    assert chipbreak.restore(output) == LONGER
    assert filtered(output, *ALWAYS) == output
    written = without_comments(output)
    shorter = without_comments(filtered(CYCLE, *ALWAYS))
    # The last block cuts to where a rapid led back, and leaves the motion code in force as that did.
    assert shorter[-3] == "G0 Z2."
    assert [line for line in written if line not in ("N21 Z2.", "G0")] == [
        *shorter[:-3],
        "Z2.",
        *shorter[-2:],
    ]
    assert written[-3] == "G0"
    assert written.index("N21 Z2.") < written.index("G0 X16. F0.1", written.index("N21 Z2."))


def test_one_that_stays_finds_all_of_what_it_calls() -> None:
    program = LONGER.replace(b"X30. Z-30.", b"X30. Z-30. M8")
    assert filtered(program, *ALWAYS) == program
    assert filtered(program.replace(b"N21 Z2.\n", b"").replace(b"Q21", b"Q20"), *ALWAYS) != program


def test_roughing_cycles_that_call_other_parts_of_a_contour_stay() -> None:
    other = b"G71 P10 Q15 U1. W0.5 F0.3\nG71 U2. R0.5\nG71 P10 Q20"
    program = CYCLE.replace(b"G71 P10 Q20", other, 1).replace(b"X30.", b"N15 X30.")
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    assert result.data == program
    assert "another part of the same contour" in " ".join(one.message for one in result.diagnostics)


HOME = CYCLE.replace(b"N20 X52.", b"X52.\nN20 Z2.")


@pytest.mark.parametrize(
    ("program", "behind"),
    [
        (HOME, [b"Z2.", b"G0"]),
        (
            HOME.replace(b"G71 U2. R0.5", b"G73 U4. W1. R3").replace(
                b"G71 P10 Q20 U0.4 W0.1", b"G73 P10 Q20"
            ),
            [],
        ),
        (HOME.replace(b"G71 U2. R0.5", b"G1 Z3. F0.2\nZ2.\nG71 U2. R0.5"), [b"X52.", b"Z2."]),
    ],
    ids=["finish", "pattern", "behind G1"],
)
def test_a_contour_that_ends_at_the_start_leaves_the_motion_code_that_was_in_force(
    program: bytes, behind: list[bytes]
) -> None:
    """No rapid leads back from there."""
    output = filtered(program, *ALWAYS)
    assert chipbreak.restore(output) == program
    last = [line for line in output.split(b"G0 X100.")[0].split(b"\n") if line and not line.startswith(b"(")]
    assert last[len(last) - len(behind) :] == behind


def test_an_arc_that_goes_down_by_less_than_the_last_digit_makes_no_pocket() -> None:
    """Its ends are rounded; the passes are those of a contour that may have pockets."""
    rounded = CYCLE.replace(b"N10 G0 X16.", b"N10 G0 X19.").replace(
        b"Z-15.", b"Z0.\nG3 X20. Z-0.51 R0.5\nG1 Z-15."
    )
    output = filtered(rounded, *ALWAYS)
    assert chipbreak.restore(output) == rounded
    pockets = rounded.replace(b"N10 G0 X19.", b"N10 G0 X19. Z2.")
    assert list(cut_lines(output)) == list(cut_lines(filtered(pockets, *ALWAYS)))
    deeper = rounded.replace(b"Z-0.51", b"Z-0.6")
    result = chipbreak.rewrite(deeper, load("fanuc-lathe", ALWAYS))
    assert result.data == deeper
    assert "CYC003" in {one.code for one in result.diagnostics}


def test_a_depth_that_is_more_than_there_is_to_take_is_said() -> None:
    """18 mm from the start to the contour, less an allowance of 0.2 mm."""
    for depth, is_said in ((b"20.", True), (b"17.9", True), (b"17.8", False), (b"2.", False)):
        result = chipbreak.rewrite(CYCLE.replace(b"U2.", b"U" + depth), load("fanuc-lathe", ALWAYS))
        said = [one for one in result.diagnostics if one.code == "CYC011"]
        assert bool(said) is is_said
        assert not said or (said[0].place is not None and said[0].place.line == 6)
        assert not said or "17.8 mm that there is" in said[0].message


@pytest.mark.parametrize(("spindle", "left"), [(b"M4", "spindle"), (b"M5", "spindle"), (b"M8", "coolant")])
def test_what_a_contour_leaves_in_force_stays_with_its_cycle(spindle: bytes, left: str) -> None:
    """Whether it holds behind the cycle is not known of a control."""
    program = CYCLE.replace(b"N20 X52.", b"N20 X52. " + spindle)
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    assert b"\nG70 P10 Q20\n" in result.data
    assert any(f"leaves another {left} in force" in one.message for one in result.diagnostics)
    assert chipbreak.restore(result.data) == program


@pytest.mark.parametrize(("begins", "is_refused"), [(b"Z2.", False), (b"Z1.", False), (b"Z2.5", True)])
def test_a_contour_begins_behind_the_start_of_its_cycle(begins: bytes, is_refused: bool) -> None:
    program = CYCLE.replace(b"N10 G0 X16.", b"N10 G0 X16. " + begins)
    result = chipbreak.rewrite(program, load("fanuc-lathe", ALWAYS))
    said = [one.code for one in result.diagnostics if "begins before the start point" in one.message]
    assert said == (["CYC006"] if is_refused else [])
    assert (b"UNROLLED G71" in result.data) != is_refused


@pytest.mark.parametrize("dwell", ["G4 X1.", "G4 P500", "G4 U0.5"])
def test_a_dwell_in_a_contour_belongs_to_its_finish(dwell: str) -> None:
    """The finishing cycle dwells where the contour says it; roughing is what it is without."""
    head = "O1\nG21 G40 G99\nT0101\nG97 S900 M3\nG0 X52. Z2.\nG71 U2. R1.\nG71 P10 Q20 U0.4 W0.1 F0.25\n"
    settings = load("fanuc-lathe", ['cycles.unroll="always"'])
    roughings, finishes = [], []
    for between in ("", f"{dwell}\n"):
        contour = f"N10 G0 X30.\nG1 Z-30. F0.1\n{between}X40.\nN20 X52.\n"
        program = f"{head}{contour}G70 P10 Q20\nG28 U0 W0\nM30\n"
        _, roughing, _, finish = (
            chipbreak.rewrite(program.encode(), settings).data.decode().split("UNROLLED ")
        )
        roughings.append(roughing)
        finishes.append([line for line in finish.splitlines() if not line.startswith("(")])
    assert roughings[0] == roughings[1]
    at = finishes[1].index(dwell)
    assert finishes[1][:at] + finishes[1][at + 1 :] == finishes[0]
    assert finishes[1][at - 1] == "G1 Z-30. F0.1"
