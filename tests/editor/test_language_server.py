"""The language server, spoken with as an editor does: diagnostics while one types, hover, ways out."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from editor.client import Client
from warm import warm

PROGRAM = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N2\nG0 Z5.\nM30\n"
GOOD = PROGRAM.replace("N2", "N1.5")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("programs")
    (folder / "chipbreak.toml").write_text('base = "generic-lathe"\n')
    return folder


@pytest.fixture(scope="module")
def editor(folder: Path) -> Iterator[Client]:
    client = Client(folder, "--stdio")
    yield client
    assert client.close() == 0


def applied(text: str, action: dict[str, Any], uri: str) -> str:
    (edit,) = action["edit"]["changes"][uri]
    lines = text.split("\n")
    start, end = edit["range"]["start"], edit["range"]["end"]
    assert start["line"] == end["line"]
    units = lines[start["line"]].encode("utf-16-le")
    new = (
        units[: 2 * start["character"]] + edit["newText"].encode("utf-16-le") + units[2 * end["character"] :]
    )
    lines[start["line"]] = new.decode("utf-16-le")
    return "\n".join(lines)


def under(text: str, found: dict[str, Any]) -> str:
    """The text that a diagnostic underlines."""
    start, end = found["range"]["start"], found["range"]["end"]
    units = text.split("\n")[start["line"]].encode("utf-16-le")
    return units[2 * start["character"] : 2 * end["character"]].decode("utf-16-le")


def test_what_is_wrong_and_what_may_be_written(editor: Client, folder: Path) -> None:
    uri = (folder / "a.nc").as_uri()
    (found,) = editor.open(uri, PROGRAM)
    assert (found["code"], found["severity"], found["source"]) == ("VIB005", 1, "chipbreak")
    assert under(PROGRAM, found) == "N2"
    assert "help: N 1.5 or 2.5 breaks best" in found["message"]
    assert editor.hover(uri, 2) == ""
    actions = editor.actions(uri, 2)
    assert [one["title"] for one in actions] == ["write N1.5", "write N2.5"]
    assert editor.actions(uri, 0) == []
    new = applied(PROGRAM, actions[0], uri)
    assert new == GOOD
    editor.change(uri, new)
    assert {one["severity"] for one in editor.shown(uri)} <= {2}
    told = editor.hover(uri, 2)
    assert "asked    S 3000 (active S, line 1), N 1.5 (N word, line 3)" in told
    assert "verdict" in told
    assert "no tool called" in told
    assert editor.hover(uri, 1) == ""


def test_what_is_typed_last_is_what_is_shown(editor: Client, folder: Path) -> None:
    uri = (folder / "typed.nc").as_uri()
    editor.open(uri, GOOD)
    for end in ("N", "N2", "N2.", "N2.0"):
        editor.change(uri, GOOD.replace("N1.5", end))
    last = GOOD.replace("N1.5", "N2.0")
    found = editor.shown(uri)
    while [one["code"] for one in found] != ["VIB005"] or under(last, found[0]) != "N2.0":
        found = editor.shown(uri)  # on a slow day some of the others are judged too


@pytest.mark.parametrize(
    ("wrong", "offered"),
    [
        ("(VIBRATE N1.5)\n" + GOOD.replace(" N1.5", ""), "(VIB N1.5)"),
        ("(OP ROUHG)\n" + GOOD, "(OP ROUGH)"),
        (GOOD.replace("Z2.\n", "Z2. (APPROACH\n"), "(APPROACH)"),
        ("(\u9b31 \U0001f600)" + GOOD.replace("S3000 M3", "S3000 M3 (\U0001f600 OPEN"), "(\U0001f600 OPEN)"),
    ],
)
def test_other_ways_out(editor: Client, folder: Path, wrong: str, offered: str) -> None:
    uri = (folder / "b.nc").as_uri()
    found = next(one for one in editor.open(uri, wrong) if one["severity"] <= 2 and one["code"] != "VIB079")
    line = found["range"]["start"]["line"]
    (action,) = editor.actions(uri, line)
    assert action["title"] == f"write {offered}"
    editor.change(uri, applied(wrong, action, uri))
    assert found["code"] not in {one["code"] for one in editor.shown(uri)}


def test_a_profile_that_cannot_be_used(editor: Client, folder: Path) -> None:
    bad = folder / "bad"
    bad.mkdir()
    (bad / "chipbreak.toml").write_text("[control]\ndialekt = 1\n")
    uri = (bad / "a.nc").as_uri()
    (found,) = editor.open(uri, GOOD)
    assert found["code"].startswith("SET")
    assert found["message"].startswith("the profile cannot be used")
    assert editor.actions(uri, 2) == []
    assert editor.hover(uri, 2) == ""
    (bad / "chipbreak.toml").write_text('base = "generic-lathe"\n')
    editor.change(uri, GOOD + "\n")
    assert "VIB079" in {one["code"] for one in editor.shown(uri)}


def test_closed_programs_are_forgotten(editor: Client, folder: Path) -> None:
    uri = (folder / "c.nc").as_uri()
    assert editor.open(uri, PROGRAM)
    editor.tell("textDocument/didClose", textDocument={"uri": uri})
    assert editor.shown(uri) == []


def test_no_machine_is_said(tmp_path: Path) -> None:
    client = Client(tmp_path)
    (found,) = client.open((tmp_path / "a.nc").as_uri(), GOOD)
    assert found["code"] == "EDT001"
    assert found["message"].startswith("which machine?")
    assert client.close() == 0


def test_what_a_filtered_program_says(editor: Client, folder: Path) -> None:
    import chipbreak

    settings = chipbreak.load("generic-lathe", ["output.brackets=none"])
    result = chipbreak.rewrite(GOOD.encode(), settings)
    uri = (folder / "filtered.nc").as_uri()
    assert result.beside is not None
    (folder / "filtered.nc.chipbreak").write_bytes(result.beside)
    text = result.data.decode()
    assert "RES003" not in {one["code"] for one in editor.open(uri, text)}
    assert "verdict" in editor.hover(uri, 2)
    editor.change(uri, text.replace("Z2.", "Z3."))
    assert {one["code"] for one in editor.shown(uri)} == {"RES003"}


def test_without_the_extra_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "pygls.py").write_text("raise ImportError\n")
    line = [
        sys.executable,
        "-c",
        "import sys; sys.path.insert(0, '.'); from chipbreak.cli import main; main()",
    ]
    done = subprocess.run(
        [*line, "language-server"], cwd=tmp_path, capture_output=True, input=b"", check=False
    )
    assert done.returncode == 2
    assert b"pip install 'chipbreak[editor]'" in done.stderr


def test_a_message_that_is_none_is_said_without_a_traceback() -> None:
    done = warm(["language-server"], b"Content-Length: 5\r\n\r\nabcde")
    assert done.stderr.strip() == b"chipbreak language-server: Unable to handle message"
