"""Any pass can be planned, applied and looked after, and none of that knows which one it is."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence

import pytest

import chipbreak
from chipbreak import passes
from chipbreak.editing.edits import Edit, OverlapError
from chipbreak.editing.promise import (
    KEPT,
    Promise,
    SpeedCommanded,
    SpeedGivenBack,
    SpindleRestarted,
    Written,
)
from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.text.diagnostics import Diagnostic, RefusalError, SelfCheckError, Severity

#           0             1             2              3             4           5         6
PROGRAM = b"G97 S900 M3\nG0 X20. Z2.\nG1 Z-3. F0.1\nX24.\nG0 X30. Z5.\nG1 X10.\nM30\n"
OURS = passes.PASSES
Made = Callable[[Context], Sequence[Edit]]


class Stub(Pass):
    """A pass that nothing but its test knows."""

    def __init__(self, name: str, made: Made) -> None:
        self.name = name
        self.made = made
        self.seen: list[object] = []

    def plan(self, context: Context) -> Planned:
        return Planned(self.made(context))

    def findings(self, context: Context, reports: Sequence[object]) -> Sequence[Diagnostic]:
        self.seen += reports
        return [Diagnostic("TST001", Severity.NOTE, f"{self.name} found {report}") for report in reports]


def insertion(line: int, *blocks: str, promise: Promise = KEPT) -> Edit:
    return Edit(line, line, blocks, "STUB", "a reason", promise)


def run(monkeypatch: pytest.MonkeyPatch, *stubs: Pass, program: bytes = PROGRAM) -> chipbreak.Result:
    monkeypatch.setattr(passes, "PASSES", (*OURS, *stubs))
    return chipbreak.rewrite(program, chipbreak.load("generic-lathe"))


def inserted(monkeypatch: pytest.MonkeyPatch, line: int, *blocks: str, promise: Promise = KEPT) -> list[str]:
    """The program with blocks before a line, without our own comments."""
    edit = insertion(line, *blocks, promise=promise)
    output = run(monkeypatch, Stub("stub", lambda _: [edit])).data.decode()
    return [text for text in output.splitlines() if "CHIPBREAK" not in text]


# --- what every promise says ------------------------------------------------------------------------------


@pytest.mark.parametrize(("line", "block"), [(3, "G4 X0.5"), (1, "(LOOK HERE)"), (2, "M3")])
def test_an_insertion_that_leaves_no_trace_stays(
    line: int, block: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert inserted(monkeypatch, line, block)[line] == block


def test_the_tool_may_stand_elsewhere_where_the_program_itself_goes_to_the_next_cut(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert inserted(monkeypatch, 4, "G0 X50.", "G1")[4:6] == ["G0 X50.", "G1"]


@pytest.mark.parametrize(
    ("line", "block", "said"),
    [
        (1, "G91", "the modal state"),
        (3, "F0.3", "the feed"),
        (2, "M8", "the coolant"),
        (2, "M5", "the spindle"),
        (2, "T0505", "the tool"),
        (2, "S500", "the spindle speed"),
        (2, "G96 S120", "the spindle speed"),
        (2, "G0 X99.", "a cut begins elsewhere"),
        (2, "G1", "the modal state"),
    ],
)
def test_a_trace_that_was_not_promised_is_caught(
    line: int, block: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SelfCheckError, match=said):
        inserted(monkeypatch, line, block)


def test_a_changed_block_that_goes_elsewhere_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    edit = Edit(3, 4, ("X25.",), "STUB", "a reason", KEPT)
    with pytest.raises(SelfCheckError, match="the position of X"):
        run(monkeypatch, Stub("stub", lambda _: [edit]))


def test_a_block_that_is_too_long_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SelfCheckError, match="characters"):
        inserted(monkeypatch, 1, "(" + "X" * 90 + ")")


def test_another_motion_code_may_stay_where_the_next_move_says_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert inserted(monkeypatch, 2, "G1", promise=Promise(leaves_motion=True))[2] == "G1"


@pytest.mark.parametrize("between", [(), (3,)], ids=["at once", "behind another edit"])
def test_and_not_where_the_next_move_says_none(
    between: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """X24. would be a rapid into the work."""
    edits = [insertion(3, "G0", promise=Promise(leaves_motion=True))]
    edits += [insertion(line, "(HERE)") for line in between]
    with pytest.raises(SelfCheckError, match="line 4 moves under another motion code"):
        run(monkeypatch, Stub("stub", lambda _: edits))


# --- spindle speeds ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("promise", "right", "wrong"),
    [
        (SpeedCommanded(speed_rpm=1200.0), "S1200", "S1250"),
        (SpeedGivenBack(), "S900", "S901"),
        (SpindleRestarted(), "S900", "S700"),
    ],
)
def test_a_promised_speed_is_looked_after(
    promise: Promise, right: str, wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert inserted(monkeypatch, 2, right, promise=promise)[2] == right
    with pytest.raises(SelfCheckError, match=r"speed|rpm"):
        inserted(monkeypatch, 2, wrong, promise=promise)


def test_a_restarted_spindle_may_wait_for_the_speed_of_the_program(monkeypatch: pytest.MonkeyPatch) -> None:
    program = PROGRAM.replace(b"G0 X30. Z5.", b"G0 X30. Z5. S600")
    edit = insertion(4, "S700", promise=SpindleRestarted())
    assert b"S700" in run(monkeypatch, Stub("stub", lambda _: [edit]), program=program).data
    with pytest.raises(SelfCheckError, match="another speed"):
        run(monkeypatch, Stub("other", lambda _: [edit._replace(first=2, last=2)]))


# --- promises of its own ----------------------------------------------------------------------------------


class Counted(Promise, kw_only=True):
    """So many blocks stand in the output."""

    count: int

    def check(self, written: Written) -> str:
        # The brackets are a line each.
        found = written.region.last - written.region.first - 2
        if found != self.count:
            raise SelfCheckError(f"{found} blocks, {self.count} were promised")
        return f"{found} blocks"


def test_a_new_kind_of_promise_reports_to_its_own_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    first = Stub("first", lambda _: [insertion(1, "(A)", "(B)", promise=Counted(count=2))])
    second = Stub("second", lambda _: [insertion(4, "(C)", promise=Counted(count=1))])
    result = run(monkeypatch, first, second)
    assert (first.seen, second.seen) == (["2 blocks"], ["1 blocks"])
    assert result.reports == ("2 blocks", "1 blocks")
    assert result.cuts == ()
    assert [d.message for d in result.diagnostics] == ["first found 2 blocks", "second found 1 blocks"]


def test_a_new_kind_of_promise_that_does_not_hold_stops_the_output(monkeypatch: pytest.MonkeyPatch) -> None:
    edit = insertion(1, "(A)", "(B)", promise=Counted(count=3))
    with pytest.raises(SelfCheckError, match="2 blocks, 3 were promised"):
        run(monkeypatch, Stub("stub", lambda _: [edit]))


class Unrolled(Promise, kw_only=True):
    """The passes of a cycle, each down to its depth."""

    depths_mm: tuple[float, ...]

    def check(self, written: Written) -> int:
        moves = [
            e.move for e in written.result.effects_of(written.region.body, written.region.last) if e.move
        ]
        depths_mm = tuple(move.end.z for move in moves if move.is_cut)
        if depths_mm != self.depths_mm:
            raise SelfCheckError(f"passes to {depths_mm}")
        return len(depths_mm)


@pytest.mark.parametrize(
    ("blocks", "said"),
    [
        (("G1 Z-1. F0.1", "G0 Z2.", "G1 Z-2.", "G0 Z2."), ""),
        (("G1 Z-1. F0.1", "G0 Z2.", "G1 Z-2.5", "G0 Z2."), "passes to"),
        (("G1 Z-1. F0.1", "G0 Z2.", "G1 Z-2.", "G0 Z3."), "the position of Z"),
    ],
)
def test_a_cycle_can_be_unrolled(blocks: tuple[str, ...], said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block becomes many: what behind it depends on the block finds all as the cycle leaves it."""
    program = PROGRAM.replace(b"G1 Z-3. F0.1", b"G77 Z-2. F0.1")
    promise = Unrolled(depths_mm=(-1.0, -2.0), leaves_motion=True)
    stub = Stub("unroll", lambda _: [Edit(2, 3, blocks, "UNROLL", "", promise)])
    monkeypatch.setattr(passes, "PASSES", (*OURS, stub))
    settings = chipbreak.load("fanuc-lathe", ["control.lathe_system=B"])
    program = program.replace(b"\nX24.", b"\nG1 X24.")
    if said:
        with pytest.raises(SelfCheckError, match=said):
            chipbreak.rewrite(program, settings)
    else:
        assert chipbreak.rewrite(program, settings).reports == (2,)


class Broken(Promise):
    """It cannot even be looked after."""

    def check(self, written: Written) -> None:
        raise ZeroDivisionError("no edges")


def test_a_promise_that_cannot_be_looked_after_does_not_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    edit = insertion(1, "(A)", promise=Broken())
    with pytest.raises(SelfCheckError, match=r"promise of stub at line 2 .*ZeroDivisionError: no edges"):
        run(monkeypatch, Stub("stub", lambda _: [edit]))


# --- passes among each other ------------------------------------------------------------------------------


def test_two_passes_that_change_the_same_lines_are_an_error_that_names_both(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one = Stub("one", lambda _: [Edit(1, 3, ("G0 X20. Z2.", "G1 Z-3. F0.1"), "ONE", "", KEPT)])
    two = Stub("two", lambda _: [Edit(2, 4, ("G1 Z-3. F0.1", "X24."), "TWO", "", KEPT)])
    with pytest.raises(OverlapError) as caught:
        run(monkeypatch, one, two)
    assert isinstance(caught.value, SelfCheckError)
    assert "one (lines 2 to 3)" in str(caught.value)
    assert "two (lines 3 to 4)" in str(caught.value)


def test_a_pass_sees_where_others_stand_and_what_they_promise(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[list[int]] = []

    def look(context: Context) -> list[Edit]:
        seen.append([len(context.planned), *context.lines_of(SpeedCommanded)])
        return []

    first = Stub("first", lambda _: [insertion(2, "S900", promise=SpeedCommanded(speed_rpm=900.0))])
    run(monkeypatch, Stub("before", look), first, Stub("behind", look))
    assert seen == [[0], [1, 2]]


def test_of_two_insertions_before_one_line_what_was_planned_later_stands_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stubs = [Stub(name, lambda _, name=name: [insertion(2, f"({name})")]) for name in ("ONE", "TWO")]
    output = run(monkeypatch, *stubs).data
    assert output.index(b"(TWO)") < output.index(b"(ONE)")


def test_edits_carry_the_name_of_their_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    (edit,) = run(monkeypatch, Stub("stub", lambda _: [insertion(2, "(A)")])).edits
    assert edit.pass_name == "stub"


def test_the_tool_table_is_read_when_it_is_asked_for_and_once() -> None:
    read: list[str] = []
    table = object()
    context = Context(None, None, (), lambda: read.append("read") or table)  # type: ignore[arg-type,return-value,func-returns-value]
    assert not read
    assert context.tools is table


def test_a_refusal_of_a_pass_of_ours_is_no_traceback_of_a_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a pass of ours refuses has a place; one that forgets to say it is a fault of ours."""

    def refuse(context: Context) -> list[Edit]:
        raise RefusalError("TST002", "not so")

    with pytest.raises(RefusalError):
        run(monkeypatch, Stub("stub", refuse))


# --- start-up ---------------------------------------------------------------------------------------------


def test_a_program_that_asks_for_nothing_loads_nothing_that_plans_cuts_or_finds_packages() -> None:
    script = (
        "import sys, chipbreak\n"
        "chipbreak.rewrite(b'G0 X20. Z2.\\nG1 Z-3. F0.1\\nM30\\n', chipbreak.load('generic-lathe'))\n"
        "print([m for m in sys.modules if m == 'importlib.metadata' or m in {"
        "f'chipbreak.vibration.{n}' for n in ('cuts', 'plan', 'blocks', 'measure', 'findings')}])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
