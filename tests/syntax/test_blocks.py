"""What a block says: a table from text to items that a machinist can check.

A block is shown as its items in the order they stand: ``/2`` block delete, ``N10`` the sequence number,
``X=1.5`` a word, ``#1:=...`` an assignment, ``IF(...)`` a control word, ``{...}`` a comment.  In expressions
every operation has its own parentheses.
"""

from __future__ import annotations

import pytest

from chipbreak.dialects import FANUC_MILL, GENERIC_LATHE, LINUXCNC_MILL, Dialect
from chipbreak.syntax.expressions import DEEPEST
from chipbreak.syntax.nodes import (
    Assignment,
    Block,
    Call,
    Comment,
    Control,
    Expression,
    Number,
    Variable,
    Word,
)
from chipbreak.syntax.parse import parse, read_block, read_by_grammar, read_plain
from chipbreak.text.source import read

from .controls import every_iso_control


def show(block: Block) -> str:
    assert not block.opaque, f"{block.text!r}: {block.opaque}"
    items = sorted(
        [*block.words, *block.comments, *block.assignments, *block.controls], key=lambda item: item.start
    )
    shown = [f"/{block.skip}"] if block.skip else []
    shown += [f"N{block.sequence.value_text}"] if block.sequence else []
    return " ".join(shown + [_item(item) for item in items])


def _item(item: Word | Comment | Assignment | Control) -> str:
    if isinstance(item, Word):
        value = item.value_text if item.expression is None else _value(item.expression)
        assert (item.number is None) != (item.expression is None)
        return f"{item.letter}={value}"
    if isinstance(item, Comment):
        return f"{{{item.text}}}"
    if isinstance(item, Assignment):
        return f"{_value(item.target)}:={_value(item.value)}"
    label = f":{item.label}" if item.label else ""
    return f"{item.keyword}{label}({', '.join(map(_value, item.arguments))})"


def _value(node: Expression) -> str:
    if isinstance(node, Number):
        return f"{node.value:g}"
    if isinstance(node, Variable):
        return f"#{node.key}" if isinstance(node.key, int | str) else f"#[{_value(node.key)}]"
    if isinstance(node, Call):
        return f"{node.function}[{', '.join(map(_value, node.arguments))}]"
    return f"({_value(node.left)} {node.operator} {_value(node.right)})"


WORDS = {
    "words in a row": ("G1X10.Z-5F0.2", "G=1 X=10. Z=-5 F=0.2"),
    "words with blanks": ("  G01  X 10\tZ -.5", "G=01 X=10 Z=-.5"),
    "signs and points": ("X+1 Y-1. Z.5 A-0. B007", "X=+1 Y=-1. Z=.5 A=-0. B=007"),
    "lower case stays lower case": ("g1 x5 f2", "g=1 x=5 f=2"),
    "N leads": ("N0120 X1", "N0120 X=1"),
    "lower case n leads as well": ("n5 g99", "N5 g=99"),
    "N behind another word is a word": ("M01N02", "M=01 N=02"),
    "N beside a move is a word": ("G1 X20. F0.1 N1.5", "G=1 X=20. F=0.1 N=1.5"),
    "a second N is a word": ("N020N020S12000M03", "N020 N=020 S=12000 M=03"),
    "N with a point": ("N1.5", "N1.5"),
    "N with a comment in front": ("(A) N10 X1", "N10 {A} X=1"),
    "a letter twice": ("H1 h1 d33 D543", "H=1 h=1 d=33 D=543"),
    "corner words": ("G1 X20. ,R2.5", "G=1 X=20. ,R=2.5"),
    "corner word without blanks": ("X0,C1.", "X=0 ,C=1."),
    "corner word with a variable": ("X0,R#144", "X=0 ,R=#144"),
    "a program number": ("O1234", "O=1234"),
    "a program number and its name": ("O0358 ( FANUC 0T )", "O=0358 { FANUC 0T }"),
    "G code with a point": ("G91.1", "G=91.1"),
    "tool and offset": ("T0101M16", "T=0101 M=16"),
    "marks of old media are blanks": ("\0X1\x1a", "X=1"),
    "a byte-order mark is a blank": ("\xef\xbb\xbfG21", "G=21"),
    "nothing": ("", ""),
    "blanks": (" \t ", ""),
}
COMMENTS = {
    "a comment": ("(ROUGH OD)", "{ROUGH OD}"),
    "empty comment": ("()", "{}"),
    "between words": ("N40 M03 (ON) S1000", "N40 M=03 {ON} S=1000"),
    "behind a semicolon": ("T0505 ;bedame de 3mm", "T=0505 {bedame de 3mm}"),
    "a semicolon ends the block": ("X1;", "X=1 {}"),
    "semicolon behind a comment": ("O3003(MLNG HLS IN SPRL);", "O=3003 {MLNG HLS IN SPRL} {}"),
    "semicolon inside a comment": ("(BRUNO; 27/05)", "{BRUNO; 27/05}"),
    "parenthesis behind a semicolon": ("X1;A (B", "X=1 {A (B}"),
    "nested at the end": ("(2D CONTOUR (2))", "{2D CONTOUR (2)}"),
    "nested at the end, with a blank": ("(6MM MILL (HSS) ) X1", "{6MM MILL (HSS) } X=1"),
    "doubled": ("((A))", "{(A)}"),
    "one too many at the end": ("(A)) X1", "{A)} X=1"),
    "never closed": ("X1 (DESBASTE INTERNO", "X=1 {DESBASTE INTERNO}"),
    "opened and never closed": ("(", "{}"),
    "Shift-JIS with a backslash": ("(\x95\x5c\x96\xca)X1", "{\x95\x5c\x96\xca} X=1"),
    "Latin-1": ("(30\xb0)", "{30\xb0}"),
    "words in a comment are no words": ("(X1 #1=2 %)", "{X1 #1=2 %}"),
}
DELETE = {
    "block delete": ("/X3.8767", "/1 X=3.8767"),
    "with a level": ("/2 X1", "/2 X=1"),
    "before the number": ("/ N10 X1", "/1 N10 X=1"),
    "behind the number": ("N10 /2 X1", "/2 N10 X=1"),
    "behind the number without blanks": ("N10/X1", "/1 N10 X=1"),
    "and a comment": ("N175 / (SANGRAMENTO)", "/1 N175 {SANGRAMENTO}"),
    "and a jump": ("/GOTO2", "/1 GOTO:2()"),
    "alone": ("/", "/1"),
}
NAMES = {
    "program number of EIA": (":1234", "PROGRAM-NUMBER::1234()"),
    "with a name": (":0100( FLANGE OP.2 )", "PROGRAM-NUMBER::0100() { FLANGE OP.2 }"),
    "program name": ("O<SHAFT-1>", "PROGRAM-NAME:O<SHAFT-1>()"),
    "program name without O": ("<SHAFT 1>(A)", "PROGRAM-NAME:<SHAFT 1>() {A}"),
    "path mark": ("$1", "PATH-MARK:$1()"),
    "path mark without a number": ("$", "PATH-MARK:$()"),
}
MACRO = {
    "assignment": ("#501=350.(FLANGE DIA.)", "#501:=350 {FLANGE DIA.}"),
    "negative": ("#1=-5", "#1:=-5"),
    "blanks": (" #1 = 2 ", "#1:=2"),
    "many assignments": ("#114=0#115=0#116=#1", "#114:=0 #115:=0 #116:=#1"),
    "assignment and words": ("#1=2 G1 X#1", "#1:=2 G=1 X=#1"),
    "a division in an assignment": ("#1=#2/2", "#1:=(#2 / 2)"),
    "named": ("#<Tool Length> = #<_x>", "#toollength:=#_x"),
    "six digits": ("#900038=1", "#900038:=1"),
    "indirect": ("#101 = #[#141]", "#101:=#[#141]"),
    "indirect target": ("#[#1+2]=3", "#[(#1 + 2)]:=3"),
    "doubled sign": ("##132=1", "#[#132]:=1"),
    "alarm": ("#3000=1(NEED ROTATION AXIS)", "#3000:=1 {NEED ROTATION AXIS}"),
    "words of variables": ("G91G#8X-#4Y0.F#20", "G=91 G=#8 X=(0 - #4) Y=0. F=#20"),
    "lower case words of variables": ("G1X#611f#9;", "G=1 X=#611 f=#9 {}"),
    "words of expressions": ("G0G96X[#501]Z[#505+50.]S250", "G=0 G=96 X=#501 Z=(#505 + 50) S=250"),
    "words of functions": ("XSIN[30] Y-COS[30]", "X=SIN[30] Y=(0 - COS[30])"),
    "jump": ("GOTO 49", "GOTO:49()"),
    "jump with leading zeros": ("GOTO0012", "GOTO:0012()"),
    "jump to a variable": ("GOTO#140", "GOTO(#140)"),
    "jump to an expression": ("GOTO[#1+10]", "GOTO((#1 + 10))"),
    "jump with N": ("GOTO N1", "GOTO:N1()"),
    "condition and jump": ("IF[#1005EQ0]GOTO0012", "IF((#1005 EQ 0)) GOTO:0012()"),
    "condition and assignment": ("IF [#1 EQ #0] THEN #3000=1(A)", "IF((#1 EQ #0)) THEN() #3000:=1 {A}"),
    "condition and word": ("IF[#1GT2]M98P100", "IF((#1 GT 2)) M=98 P=100"),
    "condition with a loop": ("IF[[#1GE#2]OR[#1EQ#2]]DO1", "IF(((#1 GE #2) OR (#1 EQ #2))) DO:1()"),
    "loop": ("WHILE [#101 LE #100] DO1  (Loop)", "WHILE((#101 LE #100)) DO:1() {Loop}"),
    "short loop": ("WH[#1LT5]DO1", "WHILE((#1 LT 5)) DO:1()"),
    "loop without a condition": ("DO2", "DO:2()"),
    "end of a loop": ("N30 END 1", "N30 END:1()"),
    "lower case": ("if[#1eq#0]goto5", "IF((#1 EQ #0)) GOTO:5()"),
}
EXPRESSIONS = {
    "from left to right": ("1-2-3", "((1 - 2) - 3)"),
    "products first": ("1+2*3", "(1 + (2 * 3))"),
    "products on the left": ("1*2+3", "((1 * 2) + 3)"),
    "division": ("8/4/2", "((8 / 4) / 2)"),
    "MOD is a product": ("1+7 MOD 4", "(1 + (7 MOD 4))"),
    "powers first": ("2*3**2", "(2 * (3 ** 2))"),
    "comparisons behind sums": ("#1+1 GT #2*2", "((#1 + 1) GT (#2 * 2))"),
    "brackets": ("[1+2]*3", "((1 + 2) * 3)"),
    "sign of a number": ("2*-3", "(2 * -3)"),
    "sign of a variable": ("2*-#3", "(2 * (0 - #3))"),
    "plus sign": ("+#3", "#3"),
    "minus is an operator behind a number": ("5-3", "(5 - 3)"),
    "minus is an operator behind a variable": ("#5-3", "(#5 - 3)"),
    "arc tangent of two": ("ATAN[1]/[2]", "(ATAN[1] / 2)"),
    "arc tangent of two is one thing": ("2*ATAN[1]/[2]*3", "((2 * (ATAN[1] / 2)) * 3)"),
    "arc tangent of a point": ("ATAN[ABS[#1]/ABS[#2]]", "ATAN[(ABS[#1] / ABS[#2])]"),
    "arc tangent with a comma": ("ATAN[1,2]", "ATAN[1, 2]"),
    "functions": ("sqrt[#140/2*#140/2-#142*#142]", "SQRT[((((#140 / 2) * #140) / 2) - (#142 * #142))]"),
    "function names that begin alike": ("SQR[1]+SIN[1]+ASIN[1]", "((SQR[1] + SIN[1]) + ASIN[1])"),
    "FIX and FUP": ("#113*[FIX[COS[#1]*1000.0]/1000.0]", "(#113 * (FIX[(COS[#1] * 1000)] / 1000))"),
    "ROUND, BIN, BCD, LN, EXP, POW": (
        "ROUND[1]+BIN[2]+BCD[3]+LN[4]+EXP[5]+POW[2,3]",
        "(((((ROUND[1] + BIN[2]) + BCD[3]) + LN[4]) + EXP[5]) + POW[2, 3])",
    ),
    "EXISTS": ("EXISTS[#<a>]", "EXISTS[#a]"),
    "operators without blanks": ("#1EQ#0", "(#1 EQ #0)"),
    "XOR": ("#1XOR#2", "(#1 XOR #2)"),
}
O_WORDS = {
    "sub": ("O100 sub", "O-SUB:100()"),
    "named sub": ("O<boring> sub", "O-SUB:<boring>()"),
    "endsub": ("o100 endsub (end)", "O-ENDSUB:100() {end}"),
    "endsub with a value": ("o100 endsub [#1]", "O-ENDSUB:100(#1)"),
    "call": ("O100 call [5] [#2] [-#3]", "O-CALL:100(5, #2, (0 - #3))"),
    "call without blanks": ("o<a>call[1]", "O-CALL:<a>(1)"),
    "callsub": ("O<g20sub> callsub", "O-CALL:<g20sub>()"),
    "computed call": ("o[#101+2] call", "O-CALL:[#101+2]()"),
    "call by a variable": ("o#5 call", "O-CALL:#5()"),
    "if": ("O101 IF [#<fillet_radius> GT 0]", "O-IF:101((#fillet_radius GT 0))"),
    "elseif": ("o31 elseif [#<direction> EQ 1]", "O-ELSEIF:31((#direction EQ 1))"),
    "else": ("O101 ELSE", "O-ELSE:101()"),
    "endif": ("O101 ENDIF", "O-ENDIF:101()"),
    "while": ("O101 while [#30 lt #1]", "O-WHILE:101((#30 LT #1))"),
    "endwhile": ("O100 ENDWHILE", "O-ENDWHILE:100()"),
    "do": ("O101 do", "O-DO:101()"),
    "repeat": ("o12 repeat [#<rough_passes>]", "O-REPEAT:12(#rough_passes)"),
    "endrepeat": ("o12 endrepeat", "O-ENDREPEAT:12()"),
    "return": ("o<circle> return [#1]", "O-RETURN:<circle>(#1)"),
    "break": ("o135 break", "O-BREAK:135()"),
    "continue": ("o136 continue", "O-CONTINUE:136()"),
    "with a number": ("N5 o100 call", "N5 O-CALL:100()"),
}


def table(cases: dict[str, tuple[str, str]]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize(("text", "expected"), cases.values(), ids=cases.keys())


@table(WORDS | COMMENTS)
@every_iso_control
def test_words_and_comments(text: str, expected: str, dialect: Dialect) -> None:
    assert show(read_block(0, text, dialect)) == expected
    assert show(read_by_grammar(0, text, dialect)) == expected


@table(DELETE)
@every_iso_control
def test_block_delete(text: str, expected: str, dialect: Dialect) -> None:
    assert show(read_block(0, text, dialect)) == expected
    assert show(read_by_grammar(0, text, dialect)) == expected
    assert (read_plain(0, text, dialect) is None) == ("GOTO" in text)


@table(NAMES)
@every_iso_control
def test_program_names_and_path_marks(text: str, expected: str, dialect: Dialect) -> None:
    assert show(read_block(0, text, dialect)) == expected


@table(MACRO)
@every_iso_control
def test_macro_b(text: str, expected: str, dialect: Dialect) -> None:
    block = read_block(0, text, dialect)
    assert show(block) == expected
    assert block.has_macro


@table(EXPRESSIONS)
@every_iso_control
def test_expressions(text: str, expected: str, dialect: Dialect) -> None:
    assert show(read_block(0, f"#1=[{text}]", dialect)) == f"#1:={expected}"
    assert show(read_block(0, f"X[{text}]", dialect)) == f"X={expected}"


@table(EXPRESSIONS)
@every_iso_control
def test_an_assignment_needs_no_brackets(text: str, expected: str, dialect: Dialect) -> None:
    assert show(read_block(0, f"#1={text}", dialect)) == f"#1:={expected}"


LOGIC = {
    "comparisons": ("#1 EQ 1 AND #2", "((#1 EQ 1) AND #2)", "(#1 EQ (1 AND #2))"),
    "sums": ("#1 + 1 AND #2", "((#1 + 1) AND #2)", "(#1 + (1 AND #2))"),
    "products": ("#1 AND #2 * 2", "(#1 AND (#2 * 2))", "((#1 AND #2) * 2)"),
    "or beside a sum": ("#1 OR 2 - #3", "(#1 OR (2 - #3))", "((#1 OR 2) - #3)"),
    "and or": ("#1 OR #2 AND #3", "((#1 OR #2) AND #3)", "(#1 OR (#2 AND #3))"),
    "xor": ("#1 LT #2 XOR #3", "((#1 LT #2) XOR #3)", "(#1 LT (#2 XOR #3))"),
    "brackets": ("[#1 EQ 1] AND [#2 EQ 2]", "((#1 EQ 1) AND (#2 EQ 2))", "((#1 EQ 1) AND (#2 EQ 2))"),
}


@pytest.mark.parametrize(("text", "logic_last", "as_arithmetic"), LOGIC.values(), ids=LOGIC.keys())
def test_each_control_has_its_own_order_of_operators(text: str, logic_last: str, as_arithmetic: str) -> None:
    """Fanuc reads AND as a product and OR and XOR as sums; LinuxCNC reads all three last."""
    assert show(read_block(0, f"#1=[{text}]", LINUXCNC_MILL)) == f"#1:={logic_last}"
    assert show(read_block(0, f"#1=[{text}]", FANUC_MILL)) == f"#1:={as_arithmetic}"


def test_an_operator_that_the_control_does_not_have_cannot_be_read() -> None:
    no_powers = FANUC_MILL._replace(precedence=FANUC_MILL.precedence[1:])
    block = read_block(0, "X[2 + 3 ** 2]", no_powers)
    assert block.opaque == "this control has no operator **"
    assert block.opaque_column == 8


@table(O_WORDS)
@every_iso_control
def test_o_words(text: str, expected: str, dialect: Dialect) -> None:
    block = read_block(0, text, dialect)
    assert show(block) == expected
    assert block.has_macro


@pytest.mark.parametrize("text", ["%", "%O1200(TOKARKA)", " %", "\xef\xbb\xbf%", "\0%PM", "\x1a%"])
@every_iso_control
def test_a_mark_is_no_block(text: str, dialect: Dialect) -> None:
    block = read_block(0, text, dialect)
    assert block.mark
    assert block.is_empty


@pytest.mark.parametrize(
    ("text", "at"),
    [
        # the caret stands under the first character that cannot be
        ("!DEBUG: 1 fanuc.cps:587", "^"),
        ('{"gc":"g55"}', "^"),
        ("[BILLET X62 Z70", "^"),
        ("GO1 Z-60", " ^"),
        ("G43 H__", "     ^"),
        ("Y 0, C 8;", "   ^"),
        ("X1.2.3", "    ^"),
        ("X--1", "  ^"),
        ("X1 2", "   ^"),
        ("E.#234", " ^"),
        ("G28 X Z", "      ^"),
        ("01000", "^"),
        ("X1 @5", "   ^"),
        ('S"6 mm"', " ^"),
        ("X1)", "  ^"),
        ("(A (B) C)", "        ^"),
        ("X1 /2", "   ^"),
        ("N10 X1 /2", "       ^"),
        ("/0 X1", " ^"),
        ("//X1", " ^"),
        ("N4450%", "     ^"),
        ("X#140/2+#142", "     ^"),
        ("X[1+]", "    ^"),
        ("X[1", "  ^"),
        ("#1=", "  ^"),
        ("#1=[1 2]", "      ^"),
        ("G1 X", "   ^"),
        ("G1 X  ", "   ^"),
        ("IF[#1EQ", "      ^"),
        ("PRES=1", " ^"),
        ("N180 G13 N1=8001", "           ^"),
        ("LA1: X=R3", " ^"),
        ("ELSE", " ^"),
        ("O7997A(NAME)", "      ^"),
        ("X1\x01", "  ^"),
        ("X\xb2", " ^"),
    ],
)
@every_iso_control
def test_a_line_that_cannot_be_read_says_where(text: str, at: str, dialect: Dialect) -> None:
    block = read_block(0, text, dialect)
    assert block.opaque
    assert " " * block.opaque_column + "^" == at
    assert not block.is_empty
    assert not block.words


@every_iso_control
def test_a_word_knows_its_place_address_and_point(dialect: Dialect) -> None:
    x, f = read_block(3, "N10 x-1.0(A)f.2", dialect).words
    assert (x.letter, x.address, x.number, x.has_point, x.start, x.end) == ("x", "X", -1.0, True, 4, 9)
    assert (f.letter, f.address, f.value_text, f.start, f.end) == ("f", "F", ".2", 12, 15)
    assert not read_block(0, "X1", dialect).words[0].has_point


@every_iso_control
def test_a_block_finds_the_last_word_of_an_address(dialect: Dialect) -> None:
    block = read_block(0, "G1 X1 x2", dialect)
    word = block.word("X")
    assert word is not None
    assert word.number == 2
    assert block.word("Y") is None


@pytest.mark.parametrize("text", ["", " ", "N10", "(A)", "N10 (A)", "/", ";"])
@every_iso_control
def test_a_block_that_does_nothing_is_empty(text: str, dialect: Dialect) -> None:
    assert read_block(0, text, dialect).is_empty


@pytest.mark.parametrize(
    ("text", "column", "end"), [("", 1, 2), (" ", 1, 2), ("  \t", 1, 2), ("  G1 ", 3, 5)]
)
def test_a_place_lies_in_its_line(text: str, column: int, end: int) -> None:
    program = parse(read(f"G1\n{text}\nG2".encode()), GENERIC_LATHE)
    place = program.diagnose(1, "SYN001", "something").place
    assert place is not None
    assert (place.line, place.column, place.end_column) == (2, column, end)


@every_iso_control
def test_an_expression_is_read_to_a_depth_that_recursion_bears(dialect: Dialect) -> None:
    nested = {
        depth: read_block(0, f"#1={'ABS[' * depth}#2{']' * depth}", dialect)
        for depth in (DEEPEST, DEEPEST + 1)
    }
    assert [block.opaque for block in nested.values()] == ["", "it is nested too deeply"]
