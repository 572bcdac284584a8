"""Pieces of programs, good and bad, for property tests."""

from __future__ import annotations

from hypothesis import strategies as st

# Bytes that break parsers: comments of Japanese posts whose second byte is a backslash or that hold a stray
# parenthesis, nested, doubled and unclosed comments, marks of old media, text of other controls.
AWKWARD = [
    "\x95\x5c\x8e\xa6)",
    "(\x95\x5c)",
    "(\x83\x5c\x8aO\x8ca)",
    "(A (B) C)",
    "(A (B))",
    "((A)",
    "(A))",
    "(A (B) )",
    "()",
    "(",
    ")",
    "(NEVER CLOSED",
    "; TO THE END (X1)",
    ";",
    "(PROGRAMADOR:CAROLINE E BRUNO; 27/05)",
    "%",
    "%O1200(TOKARKA)",
    "\0",
    "\0\0\0",
    "\x1a",
    "\x7f",
    "\x0b",
    "\x01",
    "\xb0",
    "\xef\xbb\xbf",
    "\xef",
    "!DEBUG: onParameter('product-id')",
    '{"gc":"g0x0y0"}',
    '<?xml version="1.0"?>',
    "[BILLET X62 Z70",
    "{$TOOL1=1}",
    "GO1 Z-60",
    "G43 H__",
    "P123.22.5",
    'S"6 mm"',
    "E.#234",
    "*55",
]
MACRO = [
    "#101=[#1+2]*3",
    "#114=0#115=0",
    "#<tool length>=-.5",
    "##132=1",
    "#[#141]=2",
    "X[#501+50.]",
    "X#24",
    "Z-#4",
    "G#8",
    "XSIN[30]",
    "X-ATAN[1]/[2]",
    "IF[#1EQ#0]THEN#3000=1(TEXT)",
    "IF[[#1GE#2]OR[#1EQ#2]]DO1",
    "WHILE[#101LE#100]DO1",
    "WH[#1LT5]DO1",
    "END1",
    "GOTO10",
    "GOTO N10",
    "GOTO#140",
    "O100 sub",
    "o<boring> call [5] [#2]",
    "o101 while [#30 lt #1]",
    "o1 endif",
    "O1234",
    "O<NAME>",
    "<NAME>",
    ":1234",
    "$1",
    "$",
]
BLANKS = ["", "", "", " ", "  ", "\t", "\0", "\x1a"]
NUMBERS = [
    "1",
    "0",
    "01",
    "001",
    "1.",
    "1.5",
    ".5",
    "-1",
    "+1",
    "-.5",
    "-0.",
    "--1",
    "-",
    ".",
    "1.2.3",
    "1 2",
    "10",
]
LETTERS = [*"GGGGXYZABCIJKRFNNNMSTHDPQLUVWEO", *"gxyznfo", ",R", ",C", ","]
DELETES = ["/", "/2", "/0", "//", "N10/", "N10 /3", "n 7 /", "/ "]


def _word(parts: tuple[str, str, str, str]) -> str:
    letter, blank, number, after = parts
    return letter + blank + number + after


words = st.tuples(*map(st.sampled_from, (LETTERS, BLANKS, NUMBERS, BLANKS))).map(_word)
good_words = st.tuples(*map(st.sampled_from, ("GGGXYZNFRIM", BLANKS, NUMBERS[:11], BLANKS))).map(_word)
pieces = st.one_of(
    words,
    good_words,
    st.sampled_from(AWKWARD),
    st.sampled_from(MACRO),
    st.sampled_from(DELETES),
    st.text(st.characters(max_codepoint=255, exclude_characters="\r\n"), max_size=4),
)
# Lines nearly all of which can be read, and lines that hold anything.
good_lines = st.tuples(
    st.sampled_from(["", "", "", *DELETES[:3]]),
    st.lists(st.one_of(good_words, st.sampled_from(["(A)", " ", ";", "(B", *MACRO])), max_size=6).map(
        "".join
    ),
).map("".join)
bad_lines = st.lists(pieces, max_size=6).map("".join)
lines = st.one_of(good_lines, bad_lines)
# Lines of a control that sets words off from their values.
_set_off = st.tuples(
    st.sampled_from("GXYZNFRIMS"), st.sampled_from(["=", "=", "", " = ", "=="]), st.sampled_from(NUMBERS[:11])
).map("".join)
set_off_lines = st.lists(st.one_of(_set_off, st.sampled_from([" ", "; X=1", ";", "("])), max_size=6).map(
    "".join
)

ends = st.sampled_from(["\n", "\n", "\r\n", "\r\n", "\r", "\r\r\n", "\n\r", ""])
mixed_programs = st.lists(st.tuples(lines, ends).map("".join), max_size=12).map("".join)
tidy_programs = st.tuples(st.lists(lines, max_size=12), st.sampled_from(["\n", "\r\n", "\r"])).map(
    lambda parts: parts[1].join(parts[0])
)
programs = st.one_of(mixed_programs, tidy_programs).map(lambda text: text.encode("latin-1"))
