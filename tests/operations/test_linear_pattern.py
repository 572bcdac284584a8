"""Expressions of profiles find what Python's own would find, in a time that cannot explode."""

from __future__ import annotations

import random
import re
import time

import pytest

from chipbreak.operations.kinds import KindRules, kind_of_text
from chipbreak.operations.linear_pattern import LinearPattern, TooDifficultError

PIECES = (
    "A",
    "b",
    r"\d",
    ".",
    "[AB]",
    "[^A]",
    r"\w",
    r"\s",
    r"\b",
    "^",
    "$",
    r"\.",
    "[a-c]",
    r"\B",
    "\u8ef8",
    "]",
)
REPEATS = ("", "", "", "*", "+", "?", "{2}", "{1,2}", "{,2}", "{1,}", "*?", "{}")


def drawn(draw: random.Random, depth: int = 0) -> str:
    """An expression of a few pieces."""
    pieces = []
    for _ in range(draw.randint(1, 3)):
        piece = draw.choice(PIECES)
        if depth < 2 and draw.random() < 0.4:
            inside = "|".join(drawn(draw, depth + 1) for _ in range(draw.randint(1, 2)))
            piece = draw.choice(["({})", "(?:{})"]).format(inside)
        if piece not in ("^", "$", r"\b", r"\B"):
            piece += draw.choice(REPEATS)
        pieces.append(piece)
    return "".join(pieces)


def test_it_finds_what_re_finds() -> None:
    draw = random.Random(4)
    for _ in range(1500):
        expression = drawn(draw)
        ours, theirs = LinearPattern(expression), re.compile(expression, re.IGNORECASE)
        for _ in range(5):
            text = "".join(draw.choice("AaBbC1 .-\u8ef8]{}") for _ in range(draw.randint(1, 7)))
            found, wanted = ours.search(text), theirs.search(text)
            assert (found is None) == (wanted is None), (expression, text)
            if wanted is not None:
                # The first place, and there the longest: re takes the first way that leads through.
                assert text[wanted.start() :].startswith(found), (expression, text)
                assert len(found) >= len(wanted.group()), (expression, text)


@pytest.mark.parametrize(
    "expression",
    ["(A+)+B", "(A|A)*B", "(A|AA)+$B", "(A?){30}A{30}B", "A*A*A*A*A*A*B", "(.*){20}B", "(A*)*(A*)*B"],
)
def test_no_expression_takes_for_ever(expression: str) -> None:
    begin_s = time.process_time()
    rules = KindRules.from_profile({"rough": [f"X{expression}"]})
    for i in range(20):
        assert kind_of_text(f"X{'A' * 380}{i}", rules) is None
    assert time.process_time() - begin_s < 5.0  # Python's own: longer than the world is old


@pytest.mark.parametrize(
    ("expression", "why"),
    [
        ("(", "not closed"),
        (")", "unbalanced"),
        ("[", "not understood"),
        ("*A", "not understood"),
        ("(?=A)B", "not understood"),
        (r"(A)\1", "not understood"),
        ("A++B", "not understood"),
        ("A{3,2}", "the least is more than the most"),
        ("[b-a]", "bad character range"),
        ("(A{999}){999}", "repeats too much"),
        ("(" * 99 + "A" + ")" * 99, "nested too deeply"),
    ],
)
def test_what_cannot_be_followed_is_refused(expression: str, why: str) -> None:
    with pytest.raises(TooDifficultError, match=re.escape(why)):
        LinearPattern(expression)


def test_nothing_repeated_is_nothing() -> None:
    assert LinearPattern("((){9999}){9999}A").search("BA") == "A"


def test_python_warns_of_nothing() -> None:
    """Tests turn warnings into errors; a user would see them among the messages."""
    assert LinearPattern("[[A]+x").search("B[AX") == "[AX"
