"""F and S where loops and branches meet, as LinuxCNC's interpreter has them at each pass."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest
from hypothesis import Phase, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.model.interpreted_program import interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

from . import rs274

pytestmark = pytest.mark.linuxcnc

_SETS = st.sampled_from(["S500", "S900", "F80", "F100", "G93 F7\nG94 F100", "leave", "leave"])
_KINDS = st.sampled_from(["while", "repeat", "do", "if"])
Part = str | tuple[str, list["Part"], list["Part"]]  # type: ignore[misc]
_TREES = st.recursive(
    st.lists(_SETS, max_size=2),
    lambda inner: st.lists(st.one_of(_SETS, st.tuples(_KINDS, inner, inner)), max_size=4),
    max_leaves=10,
)


class _Writer:
    """A tree of parts as a program, with a comment of its own between any two of its lines."""

    def __init__(self) -> None:
        self.marks = itertools.count(1)
        self.numbers = itertools.count(100)

    def lines(self, parts: list[Part], loops: tuple[int, ...] = ()) -> Iterator[str]:
        yield f"(MARK {next(self.marks)})"
        for part in parts:
            if isinstance(part, str):
                yield from self._leave(loops) if part == "leave" else (part,)
            else:
                number = next(self.numbers)
                yield f"#{number}=0"
                yield from getattr(self, f"_{part[0]}")(part, number, loops)
            yield f"(MARK {next(self.marks)})"

    def _leave(self, loops: tuple[int, ...]) -> Iterator[str]:
        """A way out of the loop that it stands in, which is taken now and then."""
        if loops:
            number = next(self.numbers)
            word = ("break", "continue")[number % 2]
            yield from ("#30=[#30+1]", f"o{number} if [[#30 MOD 3] EQ 1]")
            yield from (f"o{loops[-1]} {word}", f"o{number} endif")

    def _while(self, part: Part, number: int, loops: tuple[int, ...]) -> Iterator[str]:
        yield from (f"o{number} while [#{number} LT [#30 MOD 3]]", f"#{number}=[#{number}+1]", "#30=[#30+1]")
        yield from self.lines(part[1], (*loops, number))
        yield f"o{number} endwhile"

    def _repeat(self, part: Part, number: int, loops: tuple[int, ...]) -> Iterator[str]:
        times = ("2", "[#30 MOD 3]")[number % 2]
        yield from ("#30=[#30+1]", f"o{number} repeat [{times}]")
        yield from self.lines(part[1])  # nothing leaves a repeat
        yield f"o{number} endrepeat"

    def _do(self, part: Part, number: int, loops: tuple[int, ...]) -> Iterator[str]:
        yield from (f"o{number} do", f"#{number}=[#{number}+1]")
        yield from self.lines(part[1], (*loops, number))
        yield f"o{number} while [#{number} LT 2]"

    def _if(self, part: Part, number: int, loops: tuple[int, ...]) -> Iterator[str]:
        yield from ("#30=[#30+1]", f"o{number} if [[#30 MOD 2] EQ 1]")
        yield from self.lines(part[1], loops)
        if number % 3:
            yield f"o{number} else" if number % 3 == 1 else f"o{number} elseif [[#30 MOD 3] EQ 1]"
            yield from self.lines(part[2], loops)
        yield f"o{number} endif"


def visits(program: str) -> list[tuple[str, float, float]]:
    """The marks in the order in which the interpreter comes to them, with F and S."""
    judgement = rs274.judge(program.encode(), lathe=False)
    assert judgement.accepted, judgement.message + program
    found, values = [], {"SET_FEED_RATE": 0.0, "SET_SPINDLE_SPEED": 0.0}
    for name, arguments in rs274.calls(judgement.canon):
        if name in values:
            values[name] = float(arguments[-1])
        elif name == "COMMENT" and arguments[0].startswith("MARK"):
            found.append((f"({arguments[0]})", *values.values()))
    return found


@pytest.mark.few(20)
@given(_TREES, st.integers(0, 5))
@hypothesis_settings(max_examples=60, phases=[Phase.explicit, Phase.reuse, Phase.generate], deadline=None)
def test_what_is_called_known_is_what_the_interpreter_has_at_each_pass(parts: list[Part], start: int) -> None:
    body = "\n".join(_Writer().lines(parts))
    program = f"G21 G94 G97 S900 M3 F100\n#30={start}\n{body}\nM2\n"
    settings = chipbreak.load("linuxcnc-mill")
    ours = interpret(parse(read(program.encode(), "ways.ngc"), settings.dialect), settings)
    lines = {text: line for line, text in enumerate(program.split("\n"))}
    passed = visits(program)
    assert passed
    for mark, real_feed, real_speed in passed:
        state = ours.before(lines[mark])
        assert state.feed is None or state.feed.value == real_feed, (program, mark)
        assert state.speed is None or state.speed.value == real_speed, (program, mark)


def test_what_no_pass_changes_is_known() -> None:
    program = "G21 G94 G97 S900 M3 F100\no1 repeat [3]\n(MARK 1)\no1 endrepeat\n(MARK 2)\nM2\n"
    assert visits(program) == [("(MARK 1)", 100.0, 900.0)] * 3 + [("(MARK 2)", 100.0, 900.0)]
    settings = chipbreak.load("linuxcnc-mill")
    ours = interpret(parse(read(program.encode(), "ways.ngc"), settings.dialect), settings)
    for line in (2, 4):
        state = ours.before(line)
        assert state.feed is not None and state.speed is not None
        assert (state.feed.value, state.speed.value) == (100.0, 900.0)
