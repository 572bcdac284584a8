"""Questions about the words of a block."""

from __future__ import annotations

from chipbreak.dialects import FANUC_MILL
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import read_block


def block(text: str) -> Block:
    return read_block(0, text, FANUC_MILL)


def test_a_word_with_one_of_some_numbers() -> None:
    one = block("G0 G43 h2 M08 T#1")
    assert one.has("H")
    assert one.has("M", 7, 8)
    assert one.has("G", 43.0)
    assert not one.has("M", 6)
    assert not one.has("S")
    assert one.has("T")
    assert not one.has("T", 1), "the value of a variable is not known"


def test_the_last_word_counts_and_an_expression_is_no_number() -> None:
    one = block("M3 M8 X1. X2. Z[1+1]")
    assert one.number("X") == 2.0
    assert one.number("Z") is None
    assert one.number("Y") is None
    assert one.numbers("M") == (3.0, 8.0)
    assert one.numbers("Z") == ()


def test_words_by_their_letters() -> None:
    one = block("G1 X1. f2. Z3.")
    assert one.has_any("YZ")
    assert not one.has_any("ABC")
    assert [one.text_of(word) for word in one.words_of("ZX")] == ["X1.", "Z3."]
    assert one.has("F")
    assert one.has_letter("f")
    assert not one.has_letter("F")
