"""A grammar that another package brings: another shape of block, without a change in this project."""

from __future__ import annotations

from pathlib import Path

import pytest

from chipbreak.dialects import FANUC_MILL, Dialect
from chipbreak.syntax.parse import parse, read_block, read_plain
from chipbreak.text.diagnostics import ProgramRejectedError
from chipbreak.text.source import read

from .controls import SET_OFF
from .test_blocks import show


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("X=10.5", "X=10.5"),
        ("N10 G1 X = -10.5 Y=3 F=.2", "N10 G=1 X=-10.5 Y=3 F=.2"),
        ("N10 G1 X10.5 ; X=1 (A)", "N10 G=1 X=10.5 { X=1 (A)}"),
        ("; ALL (OF IT", "{ ALL (OF IT}"),
        (":1234", "PROGRAM-NUMBER::1234()"),
    ],
)
def test_words_may_be_set_off(text: str, expected: str) -> None:
    assert show(read_block(0, text, SET_OFF)) == expected
    assert (read_plain(0, text, SET_OFF) is None) == text.startswith(":")


@pytest.mark.parametrize(
    "text", ["(A)", "X1 (A)", "/X1", "#1=2", "X==1", "X=1=2", "IF[#1EQ2]GOTO3", "o1 call", "x1"]
)
def test_what_this_control_does_not_have_cannot_be_read(text: str) -> None:
    assert read_block(0, text, SET_OFF).opaque
    assert read_block(0, "X=1", FANUC_MILL).opaque


def test_plain_motion_of_such_a_control_takes_the_fast_road() -> None:
    program = parse(read(b"N10 G1 X=10.5 Y=3. F=100\nN20 X=11.5 Y=-3.\nN30 X12. Y=0\nN40 M3\n"), SET_OFF)
    assert program.special_lines.tolist() == [3]
    assert [program.shapes[index].letters for index in program.plain[:3]] == ["XYF", "XY", "XY"]
    word = program.block(1).word("Y")
    assert word is not None
    assert (word.number, word.value_text) == (-3.0, "-3.")


def _with_grammar(folder: Path, text: str) -> Dialect:
    file = folder / "own.lark"
    file.write_text(text)
    return FANUC_MILL._replace(name="own", grammar=file)


def test_a_grammar_may_import_files_beside_it(tmp_path: Path) -> None:
    (tmp_path / "pieces.lark").write_text("mark: MARK\nMARK.9: /@[0-9]+/\n")
    own = _with_grammar(
        tmp_path,
        "%import .iso (word, COMMENT, BLANK)\n%import .pieces (mark)\n"
        "block: (word | mark | COMMENT)*\n%ignore BLANK\n",
    )
    assert show(read_block(0, "X1 @2 (A)", own)) == "X=1 MARK:@2() {A}"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            "block: word*\nword: LETTER NUMBER\nLETTER: /[A-Z]/\nNUMBER: /[0-9]+/\n",
            "it has no terminal BLANK",
        ),
        ("%import .iso (word, BLANK)\nblock: word* nothing\n%ignore BLANK\n", "nothing"),
        ("%import .nowhere (word)\nblock: word*\n", "there is no grammar file nowhere.lark"),
        ("%import .iso (word, BLANK)\nblock: word* (\n", "own.lark of this control cannot be used"),
    ],
)
def test_a_grammar_that_cannot_be_used_is_said(tmp_path: Path, text: str, why: str) -> None:
    own = _with_grammar(tmp_path, text)
    with pytest.raises(ProgramRejectedError, match=why) as caught:
        parse(read(b"X[1]\n"), own).block(0)
    assert caught.value.diagnostics[0].code == "SYN002"


def test_a_grammar_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(ProgramRejectedError, match=r"own\.lark of this control cannot be used"):
        parse(read(b"X1\n"), FANUC_MILL._replace(grammar=tmp_path / "own.lark"))
