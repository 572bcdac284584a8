"""What a message shows of a program: its own line, in its own encoding, and nothing that a terminal obeys."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from chipbreak.cli import cli
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.encoding import LATIN_1, SHIFT_JIS, UTF_8, encoding_of
from chipbreak.text.source import read
from chipbreak.text.span import Place
from warm import cold, warm

_CUT = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG0 X30.\nM30\n"


def test_place_and_text_of_a_filtered_program_agree() -> None:
    settings = chipbreak.load("fanuc-lathe")
    filtered = chipbreak.rewrite(_CUT.encode(), settings, "b.nc").data
    narrow = chipbreak.load("fanuc-lathe", ["spindle.max_rpm=2000"])
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(filtered, narrow, "b.nc")
    (found,) = caught.value.diagnostics
    assert found.place is not None
    line = filtered.decode().splitlines()[found.place.line - 1]
    assert found.line_text == line == "(CHIPBREAK WAS G1 Z-30. F0.05 N1.5)"
    assert line[found.place.column - 1 : found.place.end_column - 1] == "N1.5"


@pytest.mark.parametrize(("line", "said"), [("/G0 X1. Z1.", "is skipped"), ("G0 X1. Z&", "cannot be read")])
def test_a_reason_names_the_line_of_the_filtered_file(line: str, said: str) -> None:
    settings = chipbreak.load("fanuc-lathe")
    filtered = chipbreak.rewrite(_CUT.replace("M30\n", "").encode(), settings).data
    program = filtered + f"{line}\nG1 Z-30. F0.05 N1.5\nM30\n".encode()
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program, settings)
    number = filtered.count(b"\n") + 1
    assert f"line {number} {said}" in str(caught.value)


@pytest.mark.parametrize(
    ("comment", "encoding", "meant"),
    [
        ("(外径荒加工 X&)", "cp932", SHIFT_JIS),
        ("(外径荒加工 X&)", "utf-8", UTF_8),
        ("(Länge Ø20 X&)", "utf-8", UTF_8),
        ("(Länge Ø20 größer X&)", "latin-1", LATIN_1),
        ("(ЧЕРНОВАЯ обработка X&)", "cp1251", LATIN_1),
        ("(Größe Länge X&)", "cp850", LATIN_1),
    ],
)
def test_a_comment_is_shown_as_its_encoding_means_it(comment: str, encoding: str, meant: str) -> None:
    data = f"G0 X1. {comment} &\nM30\n".encode(encoding)
    assert encoding_of(data) == meant
    settings = chipbreak.load("fanuc-lathe")
    result = chipbreak.rewrite(data, settings)
    assert result.data == data
    shown = result.diagnostics[0].render().splitlines()
    assert shown[1] == f"    G0 X1. {data.decode(meant).splitlines()[0][7:]}" or meant == LATIN_1
    assert shown[2].strip() == "^"


def test_the_caret_stands_under_its_place_behind_wide_characters() -> None:
    data = "G0 X1. (外径) &\nM30\n".encode("cp932") + "(荒加工)".encode("cp932")
    (found,) = chipbreak.check(data, chipbreak.load("fanuc-lathe"))
    assert found.render().splitlines()[2] == "    " + " " * len("G0 X1. (1234) ") + "^"


def test_a_message_quotes_a_program_in_its_encoding() -> None:
    data = "(OP 荒加工X)\nG0 X1. (TOOL (OLD) 外径荒 X5.\nM30\n".encode()
    text = " ".join(d.message for d in chipbreak.check(data, chipbreak.load("fanuc-lathe")))
    assert "å" not in text


def test_nothing_of_a_file_gives_orders_to_a_terminal() -> None:
    data = b"G0 X1. \x1b[2J &\x07\nM30\n"
    (found,) = chipbreak.check(data, chipbreak.load("fanuc-lathe"), "a\x1b[31m\n.nc")
    said = found.render()
    assert "\x1b" not in said and "\x07" not in said
    assert r"a\x1b[31m\x0a.nc:1:8" in said
    assert r"G0 X1. \x1b[2J &\x07" in said
    assert len(said.splitlines()) == 4


def test_a_caret_beyond_the_end_of_its_line() -> None:
    said = Diagnostic("SYN001", Severity.ERROR, "m", "", Place("a", 1, 8, 12), "G0 X1").render()
    assert said.splitlines()[1:] == ["    G0 X1", "           ^^^^"]


@pytest.mark.parametrize("line", ["X", "", "(A)", "G1 X1. Y2."])
def test_the_line_end_of_punched_tape_is_one_line_end(line: str) -> None:
    data = f"%\nO1\n{line}\n\nG0 X& \nM30\n%\n".encode().replace(b"\n", b"\n\r\r")
    source = read(data)
    assert source.line_count == data.count(b"\n\r\r")
    assert b"".join(source.raw(at) for at in range(source.line_count)) == data
    found = chipbreak.check(data, chipbreak.load("fanuc-lathe"))
    assert [d.place.line for d in found if d.place and d.code == "SYN001"][-1] == 5


def test_a_tape_is_filtered_and_put_back() -> None:
    settings = chipbreak.load("fanuc-lathe")
    data = _CUT.encode().replace(b"\n", b"\n\r\r")
    result = chipbreak.rewrite(data, settings)
    assert result.data.replace(b"\n\r\r", b"\n") == chipbreak.rewrite(_CUT.encode(), settings).data
    assert chipbreak.restore(result.data) == data
    sent = result.data.replace(b"\n\r\r", b"\r\n")
    assert chipbreak.restore(sent) == _CUT.encode().replace(b"\n", b"\r\n")


def test_a_return_before_the_line_feed_is_no_tape() -> None:
    assert read(b"X1\r\r\n\r\r\nX2\r\r\n").line_count == 6


@pytest.mark.parametrize(
    ("encoding", "mark"),
    [("utf-16-le", b"\xff\xfe"), ("utf-16-be", b"\xfe\xff"), ("utf-16-le", b""), ("utf-16-be", b"")],
)
def test_utf_16_is_refused_and_its_way_out_works(encoding: str, mark: bytes) -> None:
    settings = chipbreak.load("fanuc-lathe")
    data = mark + _CUT.replace("\n", "\r\n").encode(encoding)
    for run in (chipbreak.rewrite, chipbreak.verify):
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            run(data, settings, "a.nc")
        (found,) = caught.value.diagnostics
        assert (found.code, str(found.place)) == ("SYN005", "a.nc:1:1")
    with pytest.raises(chipbreak.ProgramRejectedError):
        chipbreak.diff(data, data)
    command = re.search(r"iconv -f (\S+) -t (\S+)", found.help)
    assert command is not None
    converted = data.decode(command[1]).encode(command[2])
    assert chipbreak.rewrite(converted, settings).changed


@pytest.mark.parametrize("data", [b"", b"%", b"X1\0\0", b"\0" * 300 + b"%\nG0 X1.\nM30\n%\n", b"\0\0\0\0"])
def test_runout_of_a_tape_is_no_utf_16(data: bytes) -> None:
    assert chipbreak.rewrite(data, chipbreak.load("fanuc-lathe")).data == data


def test_a_name_gives_no_orders_to_a_terminal(tmp_path: Path) -> None:
    name = "a\x1b[31m.nc"
    profile = ["-p", "fanuc-lathe"]
    commands = (["check", *profile], ["filter", *profile], ["explain", *profile], ["restore"], ["diff", name])
    for command in commands:
        done = CliRunner().invoke(cli, [*command, name])
        assert done.exit_code == 2, command
        assert r"cannot read a\x1b[31m.nc" in done.stderr, command
        assert "\x1b" not in done.stderr, command
    program = tmp_path / "b\x1b[31m.nc"
    program.write_bytes(b"(TOOL \x1b[2J)\nG0 X& \nM30\n")
    done = CliRunner().invoke(cli, ["explain", "-p", "fanuc-lathe", str(program)])
    assert done.exit_code == 0
    assert r"b\x1b[31m.nc" in done.output
    assert "\x1b" not in done.output + done.stderr


def test_explain_shows_what_the_stream_has_not_as_escapes() -> None:
    run = ["explain", "-p", "fanuc-lathe", "-"]
    data = f"T0101\n(荒加工)\n{_CUT}".encode("cp932")
    done = cold(run, data, env={"PYTHONIOENCODING": "ascii"})
    assert rb"\u8352" in done.stdout
    done = warm(run, data, env={"PYTHONIOENCODING": "utf-8"})
    assert "荒加工" in done.stdout.decode()


def test_no_number_of_a_message_is_minus_zero() -> None:
    """Lengths and shares with fixed decimals are printed by ``z``, which knows no ``-0.0``."""
    allowed = ("edge_figure.py", "numbers.py", "units.py", "findings.py")
    for file in Path(chipbreak.__file__).parent.rglob("*.py"):
        text = file.read_text("utf-8")
        assert file.name in allowed or not re.findall(r"\{[^{}\"]*:\.[0-9]f\}", text), file
