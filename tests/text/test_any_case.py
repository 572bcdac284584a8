"""Words in capitals or not are found where Python's own ``re.IGNORECASE`` finds them."""

from __future__ import annotations

import re

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from chipbreak.operations import kind_words
from chipbreak.text.any_case import AnyCase, Hit, capitals
from chipbreak.tools import facts

PATTERNS = {
    f"{module.__name__}.{name}": value
    for module in (kind_words, facts)
    for name, value in vars(module).items()
    if isinstance(value, AnyCase)
}
LAW = {name: re.compile(pattern.source, re.IGNORECASE) for name, pattern in PATTERNS.items()}
# What the expressions themselves are made of, and letters whose capitals are no plain matter.
_WORDS = sorted({word for one in PATTERNS.values() for word in re.findall(r"[^\W\d_]{2,}", one.source)})
_ODD = [*"ßſıİKµÿÉéøÅ#°荒粗ﾀ\x85", "ŉ", "ﬁ", "STRAẞE"]
_texts = st.lists(
    st.one_of(
        st.sampled_from(_WORDS).flatmap(lambda w: st.sampled_from([w, w.lower(), w.capitalize()])),
        st.sampled_from([*_ODD, *" -_.:=/\"'|()", "1", "10.5", "3/8", "MM", " D=", "T1", "OP", "I.D."]),
    ),
    max_size=9,
).flatmap(lambda parts: st.sampled_from(["", " "]).map(lambda gap: gap.join(parts)))


def seen(hit: Hit | re.Match[str] | None) -> object:
    return hit and (hit.start(), hit.end(), hit[0], hit.group(), hit.groups(), hit.lastgroup)


def compare(text: str) -> None:
    for name, pattern in PATTERNS.items():
        law = LAW[name]
        assert seen(pattern.search(text)) == seen(law.search(text)), name
        assert seen(pattern.match(text)) == seen(law.match(text)), name
        assert list(map(seen, pattern.finditer(text))) == list(map(seen, law.finditer(text))), name
        assert pattern.sub(" ", text) == law.sub(" ", text), name


def test_there_are_expressions() -> None:
    assert len(PATTERNS) > 25


@pytest.mark.few(25)
@given(_texts)
@example("(Rough Pocket 1)")
@example("fınısh, fİnish and ſhort drilK")
@example("Straße 3/8 em")
def test_they_find_what_ignoring_case_finds(text: str) -> None:
    compare(text)


def test_they_find_it_in_real_programs(corpus_lines: list[str]) -> None:
    for comment in sorted({found for line in corpus_lines for found in re.findall(r"\(([^()]*)\)", line)}):
        compare(comment)
        compare(comment.swapcase())


def test_names_of_groups_and_escapes_are_no_words() -> None:
    found = AnyCase(r"(?P<name>[a-f]+)\s\bx(?P=name)").search("AbBa XabbA")
    assert found is not None
    assert (found["name"], found.group()) == ("AbBa", "AbBa XabbA")


def test_capitals_stay_where_they_were() -> None:
    for character in [*map(chr, range(0x250)), *_ODD]:
        assert len(capitals(character)) == len(character)
        assert capitals(f"a{character}b") == f"A{capitals(character)}B"


def test_what_takes_no_part_is_none() -> None:
    hit = AnyCase("(?P<a>x)|(?P<b>y)").match("Y")
    assert hit is not None
    assert (hit["a"], hit["b"], hit.groups(), hit.lastgroup) == (None, "Y", (None, "Y"), "b")
