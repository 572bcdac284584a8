"""F and S where ways meet: what all bring is known, and what is called known is what each visit has."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak import load
from chipbreak.dialects.modes import Modes
from chipbreak.model import interpreted_program
from chipbreak.model.arrivals import Carried, carried_by, together
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.modal import Setting, State
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from macro_interpreter import Interpreter, Library, Machine

FANUC = "fanuc-mill"
LINUXCNC = "linuxcnc-mill"


def interpreted(program: str, profile: str) -> InterpretedProgram:
    settings = load(profile)
    return interpret(parse(read(program.encode(), "ways.nc"), settings.dialect), settings)


def known(state: State) -> tuple[str, str]:
    """The texts of F and S, empty where they are not known."""
    return tuple("" if one is None else one.text for one in (state.feed, state.speed))  # type: ignore[return-value]


def at_mark(program: str, profile: str) -> tuple[str, str]:
    """F and S in front of the block ``(HERE)``."""
    (line,) = (number for number, text in enumerate(program.split("\n")) if "(HERE)" in text)
    return known(interpreted(program, profile).before(line))


_LOOP = "WHILE[#1LT3]DO1\n(HERE)\nM98 P200\nEND1\nM30\nO200\n"
_LC_LOOP = "o<x> sub\n{}\no<x> endsub\nG94 S900 M3 F100.\no1 while [#1]\n(HERE)\no<x> call\no1 endwhile"


@pytest.mark.parametrize(
    ("profile", "program", "expected"),
    [
        pytest.param(FANUC, _LOOP + "G1 X5.\nM99", ("100.", "900"), id="a call of one that says neither"),
        pytest.param(FANUC, _LOOP + "S900\nM99", ("100.", ""), id="a call of one that says S"),
        pytest.param(FANUC, _LOOP + "G20\nG21\nM99", ("", ""), id="a call of one that changes the units"),
        pytest.param(FANUC, _LOOP + "IF[#1EQ1]GOTO5\nM99\nN5 S500\nM99", ("100.", ""), id="behind its M99"),
        pytest.param(FANUC, _LOOP + "M98 P300\nM99\nO300\nX1.\nM99", ("100.", "900"), id="a call in a call"),
        pytest.param(
            FANUC, _LOOP + "M98 P300\nM99\nO300\nF9.\nM99", ("", "900"), id="a call in a call says F"
        ),
        pytest.param(FANUC, _LOOP + "M98 P301\nM99", ("", ""), id="a call in a call of nobody knows what"),
        pytest.param(FANUC, _LOOP + "M98 P200\nM99", ("", ""), id="one that calls itself"),
        pytest.param(LINUXCNC, _LC_LOOP.format("G1 X5"), ("100.", "900"), id="by its name"),
        pytest.param(LINUXCNC, _LC_LOOP.format("F5"), ("", "900"), id="by its name, says F"),
        pytest.param(LINUXCNC, _LC_LOOP.format("M72"), ("", ""), id="by its name, gives a state back"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\n(HERE)\n#1=#1+1\nEND1", ("100.", "900"), id="in a loop"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\n#1=#1+1\nEND1\n(HERE)", ("100.", "900"), id="behind a loop"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\n(HERE)\nS500\nEND1", ("100.", ""), id="the loop sets S"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\nS500\nEND1\n(HERE)", ("100.", ""), id="or runs not once"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\nF100.\nS900\n(HERE)\nEND1", ("100.", "900"), id="the same"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\nF80.\nF100.\nEND1\n(HERE)", ("100.", "900"), id="given back"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\nG95 F.1\nG94\nEND1\n(HERE)", ("", "900"), id="ended by G95"),
        pytest.param(FANUC, "N10\n(HERE)\nG4 X1.\nIF[#1EQ2]GOTO10", ("100.", "900"), id="a jump back"),
        pytest.param(FANUC, "N10\n(HERE)\nS500\nIF[#1EQ2]GOTO10", ("100.", ""), id="a jump back with S"),
        pytest.param(FANUC, "IF[#1EQ2]GOTO10\nS500\nN10\n(HERE)", ("100.", ""), id="a jump over S"),
        pytest.param(FANUC, "IF[#1EQ2]GOTO10\nS900\nN10\n(HERE)", ("100.", "900"), id="over the same S"),
        pytest.param(FANUC, "S#5\nN10\n(HERE)\nIF[#1EQ2]GOTO10", ("100.", ""), id="a variable"),
        pytest.param(FANUC, "GOTO#1\nN10\n(HERE)", ("100.", "900"), id="a jump that is worked out"),
        pytest.param(FANUC, "GOTO#1\nS500\nN10\n(HERE)", ("100.", ""), id="over S"),
        pytest.param(FANUC, "GOTO#1\nS500\nGOTO10\nN10\n(HERE)", ("100.", ""), id="beside one that is not"),
        pytest.param(FANUC, "GOTO10\nN10\n(HERE)\nM99 P10", ("", ""), id="a return comes in as well"),
        pytest.param(FANUC, "N10\n(HERE)\nM98 P7\nGOTO10", ("", ""), id="a call on the way back"),
        pytest.param(FANUC, "M98 P7\nN10\n(HERE)\nGOTO10", ("100.", "900"), id="a call before it"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\n(HERE)\nEND2", ("", ""), id="not nested"),
        pytest.param(FANUC, "WHILE[#1LT3]DO1\n(HERE)", ("", ""), id="not closed"),
        pytest.param(FANUC, "DO1\n(HERE)\nS900\nEND1", ("100.", "900"), id="for ever"),
        pytest.param(
            FANUC,
            "WHILE[#1LT3]DO1\n(HERE)\nN20\nWHILE[#2LT3]DO2\nIF[#2EQ1]GOTO20\nEND2\nEND1",
            ("100.", "900"),
            id="nests and jumps",
        ),
        pytest.param(
            FANUC,
            "WHILE[#1LT3]DO1\n(HERE)\nWHILE[#2LT3]DO2\nWHILE[#3LT3]DO3\nS1\nEND3\nEND2\nEND1",
            ("100.", ""),
            id="from three loops further in",
        ),
        pytest.param(LINUXCNC, "o1 if [#1 EQ 2]\n(HERE)\nS500\no1 endif", ("100.", "900"), id="in a branch"),
        pytest.param(LINUXCNC, "o1 if [#1]\nS500\no1 endif\n(HERE)", ("100.", ""), id="behind one with S"),
        pytest.param(LINUXCNC, "o1 if [#1]\nS500\no1 else\n(HERE)\no1 endif", ("100.", "900"), id="else"),
        pytest.param(
            LINUXCNC,
            "o1 if [#1]\nS500\no1 else\nS500\no1 endif\n(HERE)",
            ("100.", "500"),
            id="both say it",
        ),
        pytest.param(
            LINUXCNC,
            "o1 if [#1]\nS500\no1 elseif [#2]\nS500\no1 endif\n(HERE)",
            ("100.", ""),
            id="neither condition may be met",
        ),
        pytest.param(
            LINUXCNC, "o1 repeat [3]\nS500\no1 endrepeat\n(HERE)", ("100.", "500"), id="once or more"
        ),
        pytest.param(LINUXCNC, "o1 repeat [#3]\nS500\no1 endrepeat\n(HERE)", ("100.", ""), id="or not"),
        pytest.param(LINUXCNC, "o1 do\nS500\no1 while [#1 LT 3]\n(HERE)", ("100.", "500"), id="do"),
        pytest.param(
            LINUXCNC,
            "o1 do\no2 if [#1]\no1 break\no2 endif\nS500\no1 while [#1]\n(HERE)",
            ("100.", ""),
            id="do, left before S",
        ),
        pytest.param(
            LINUXCNC,
            "o1 while [#1]\n(HERE)\no2 if [#1]\nF5\no1 continue\no2 endif\nF100.\no1 endwhile",
            ("", "900"),
            id="continue",
        ),
        pytest.param(LINUXCNC, "o1 while [#1]\n(HERE)\no<x> call\no1 endwhile", ("", ""), id="with a call"),
        pytest.param(
            LINUXCNC,
            "o1 while [#1]\nS500\no2 if [#1]\no1 break\no2 endif\nS900\no1 endwhile\n(HERE)",
            ("100.", ""),
            id="left with another S",
        ),
        pytest.param(
            LINUXCNC,
            "o1 while [#1]\n(HERE)\no2 if [#1]\nS500\no1 break\no2 endif\nS900\no1 endwhile",
            ("100.", "900"),
            id="what leaves does not come again",
        ),
        pytest.param(
            LINUXCNC,
            "o1 do\nS500\no2 if [#1]\no1 continue\no2 endif\nS900\no1 while [#1]\n(HERE)",
            ("100.", ""),
            id="to the end with another S",
        ),
        pytest.param(
            LINUXCNC,
            "o1 if [#1]\nS500\no1 elseif [#2]\n(HERE)\no1 endif",
            ("100.", "900"),
            id="elseif",
        ),
        pytest.param(LINUXCNC, "o1 else\n(HERE)", ("", ""), id="no branch"),
        pytest.param(LINUXCNC, "o1 break\n(HERE)", ("", ""), id="no loop"),
        pytest.param(
            LINUXCNC, "o1 if [#1]\no1 else\no1 else\n(HERE)\no1 endif", ("", ""), id="one arm too many"
        ),
    ],
)
def test_what_all_ways_bring_is_known(profile: str, program: str, expected: tuple[str, str]) -> None:
    assert at_mark(f"G94 S900 M3 F100.\n{program}\nM30\n", profile) == expected


def test_where_ways_do_not_settle_nothing_is_known() -> None:
    """Each jump brings a change one label further up, and there are more labels than rounds."""
    labels = range(1, 30)
    links = [f"N{n + 100}\nIF[#1EQ2]GOTO{n + 99}" for n in labels]
    program = "\n".join(["G94 S900 F100.", "N100\n(HERE)", *links, "S500", "IF[#1EQ1]GOTO129", "M30", ""])
    assert at_mark(program, FANUC) == ("", "")


# --- programs at random, run by the tests' own control ----------------------------------------------------
@dataclass
class Recorder(Machine):
    """A machine that writes down at each move F, S and the place in X, which is a mark of its own."""

    visits: list[tuple[float, float, float]] = field(default_factory=list)
    words: dict[str, float] = field(default_factory=dict)

    def move(self, target: tuple[float, float, float], feed_mm_min: float = 0.0) -> None:
        self.visits.append((target[0], self.words.get("F", 0.0), self.words.get("S", 0.0)))
        super().move(target, feed_mm_min)


_SETS = st.sampled_from(["S500", "S900", "F80.", "F100.", "(-)"])
Tree = str | tuple[str, list["Tree"], list["Tree"]]  # type: ignore[misc]
_TREES = st.recursive(
    st.lists(_SETS, max_size=2),
    lambda inner: st.lists(
        st.one_of(
            _SETS, st.tuples(st.sampled_from(["while", "over", "back", "either", "call"]), inner, inner)
        ),
        max_size=4,
    ),
    max_leaves=8,
)


class _Writer:
    """A tree of parts as a program; each line of it is followed by a move to a place of its own."""

    def __init__(self) -> None:
        self.marks = itertools.count(1)
        self.numbers = itertools.count(10, 10)
        self.counters = itertools.count(101)
        self.called = itertools.count(201)
        self.programs: list[str] = []

    def lines(self, parts: list[Tree], depth: int = 1) -> Iterator[str]:
        yield f"G1 X{next(self.marks)}."
        for part in parts:
            if isinstance(part, str):
                yield part
            else:
                kind, one, other = part
                kind = "back" if kind == "while" and depth > 3 else kind
                yield from getattr(self, f"_{kind}")(one, other, depth)
            yield f"G1 X{next(self.marks)}."

    def _while(self, one: list[Tree], _: list[Tree], depth: int) -> Iterator[str]:
        counter = f"#{next(self.counters)}"
        yield from (f"{counter}=0", f"WHILE[{counter}LT[#100MOD3]]DO{depth}", "#100=#100+1")
        yield from self.lines(one, depth + 1)
        yield from (f"{counter}={counter}+1", f"END{depth}")

    def _over(self, one: list[Tree], _: list[Tree], depth: int) -> Iterator[str]:
        number = next(self.numbers)
        yield from ("#100=#100+1", f"IF[[#100MOD2]EQ1]GOTO{number}")
        yield from self.lines(one, depth)
        yield f"N{number}"

    def _back(self, one: list[Tree], _: list[Tree], depth: int) -> Iterator[str]:
        number, counter = next(self.numbers), f"#{next(self.counters)}"
        yield from (f"{counter}=0", f"N{number}")
        yield from self.lines(one, depth)
        yield from (f"{counter}={counter}+1", f"IF[{counter}LT2]GOTO{number}")

    def _call(self, one: list[Tree], _: list[Tree], depth: int) -> Iterator[str]:
        """A program that says neither F nor S, jumps, and may call another such one."""
        number = next(self.called)
        inner = any(isinstance(part, tuple) and part[0] == "call" for part in one)
        calls = list(self._call([], [], depth)) if inner else []
        lines = [f"O{number}", "#100=#100+1", "IF[[#100MOD2]EQ1]GOTO5", *calls, "M99", "N5 G4 X.1", "M99"]
        self.programs.append("\n".join(lines))
        yield f"M98 P{number}"

    def _either(self, one: list[Tree], other: list[Tree], depth: int) -> Iterator[str]:
        number, end = next(self.numbers), next(self.numbers)
        yield from ("#100=#100+1", f"IF[[#100MOD2]EQ1]GOTO{number}")
        yield from self.lines(one, depth)
        yield from (f"GOTO{end}", f"N{number}")
        yield from self.lines(other, depth)
        yield f"N{end}"


@pytest.mark.few(50)
@given(_TREES, st.integers(0, 5))
@hypothesis_settings(max_examples=150)
def test_what_is_called_known_is_what_the_control_has_at_each_visit(trees: list[Tree], start: int) -> None:
    writer = _Writer()
    body = "\n".join(writer.lines(trees))
    main = f"G90 G94 G97 S900 M3 F100.\n#100={start}\n{body}\nM30\n"
    machine = Recorder()
    programs = [f"{one}\n" for one in writer.programs]
    control = Interpreter(Library(one.encode() for one in programs), machine, most_blocks=20_000)
    machine.words = control.modes.words
    assert control.run(main).alarm == 0
    program = "".join(["O1\n", main, *programs]) if programs else main
    ours = interpreted(program, FANUC)
    for line, text in enumerate(program.split("\n")):
        if not text.startswith("G1 X"):
            continue
        feed, speed = ours.effect(line).before.feed, ours.effect(line).before.speed
        for at, real_feed, real_speed in machine.visits:
            if at == float(text[4:]):
                assert feed is None or feed.value == real_feed, (program, line)
                assert speed is None or speed.value == real_speed, (program, line)


def test_what_a_return_brings_to_a_number_is_not_known() -> None:
    """``M99 P7`` at the end of a main program is a jump, here with another S."""
    program = b"G99\nG97 S1000 M3\nG0 X52. Z2.\nN7 G0 X50. Z2.\nG1 Z-3. F0.2 N1.5\nS300\nM99 P7\n"
    assert [one.code for one in chipbreak.check(program, chipbreak.load("fanuc-lathe"))] == ["VIB001"]


def test_a_feed_that_was_given_back_in_other_units_is_the_same_where_a_loop_begins() -> None:
    """F in inches before G21: behind the vibrated cut its number is one in mm, equal but for rounding."""
    program = (
        b"G21 G17 G40 G49 G54 G80 G90 G95 G97 G64\nS3000 M3\nG20 F0.05\nG21 S3000 F0.007874\n#201=0\n"
        b"o201 while [#201 lt 2]\n#201=[#201+1]\nG0 X7. Y6. Z8.\nG0 X18. Y13. Z11.\n(VIB N1.5)\nG1 Z5.\n"
        b"(VIB OFF)\nG0 X12. Y18. Z9.\no201 endwhile\nG1 X15.\nM2\n"
    )
    settings = chipbreak.load("linuxcnc-mill", ['planner.model="ideal"', "checks.enabled=false"])
    result = chipbreak.rewrite(program, settings, allow_unbroken=True)
    assert len(result.cuts) == 1
    assert chipbreak.restore(result.data) == program


def test_many_jumps_to_many_blocks_of_one_number_are_put_together_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """300 jumps, each of which may go to any of 300 blocks: not 90,000 ways."""
    looked_at: list[State] = []

    def counted(state: State) -> Carried:
        looked_at.append(state)
        return carried_by(state)

    monkeypatch.setattr(interpreted_program, "carried_by", counted)
    program = "G94 S900 M3 F100.\n" + "IF[#1EQ1]GOTO7\nN7 X1.\n" * 300 + "(HERE)\nM30\n"
    assert at_mark(program, FANUC) == ("100.", "900")
    assert 300 <= len(looked_at) < 2000


_MODES = Modes()
_INCHES = _MODES._replace(units="inch")
_DISTANCES = _MODES._replace(distance="incremental")


def brought(feed: float | None, line: int, modes: Modes = _MODES, *left_open: str) -> Carried:
    setting = None if feed is None else Setting(feed, f"{feed:g}", line, "mm")
    return Carried(setting, None, modes, frozenset(left_open))


@pytest.mark.parametrize(
    ("ways", "expected"),
    [
        pytest.param([], (), id="none"),
        pytest.param([brought(5.0, 8), brought(5.0, 3)], (brought(5.0, 3),), id="the first that said it"),
        pytest.param([brought(5.0, 8), brought(6.0, 3)], (brought(None, 0),), id="another F"),
        pytest.param([brought(5.0, 8), brought(None, 0)], (brought(None, 0),), id="F of nobody knows what"),
        pytest.param(
            [brought(5.0, 8), brought(5.0, 9), brought(5.0, 9, _INCHES)],
            (brought(None, 0, _MODES, "units"),),
            id="other units",
        ),
        pytest.param(
            [brought(5.0, 8), brought(5.0, 9, _DISTANCES)],
            (brought(5.0, 8, _MODES, "distance"),),
            id="another meaning of places",
        ),
        pytest.param(
            [brought(5.0, 8), brought(5.0, 9, _MODES, "plane")],
            (brought(5.0, 8, _MODES, "plane"),),
            id="a mode that was not sure before",
        ),
    ],
)
def test_ways_that_say_the_same_are_one(ways: list[Carried], expected: tuple[Carried, ...]) -> None:
    assert together(ways) == expected
