"""The lines for editors on the page are what these editors read, where a parser for them is at hand."""

from __future__ import annotations

import re
import shutil
import subprocess
import textwrap
import tomllib
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "editors.md"
COMMAND = ["chipbreak", "language-server"]


def lines_for(editor: str) -> str:
    """The indented lines that stand below a sentence that begins with the editor's name."""
    found = re.search(rf"^{editor}[^\n]*:\n\n((?: {{4}}[^\n]*\n|\n)+)", PAGE.read_text("utf-8"), re.MULTILINE)
    assert found is not None
    return textwrap.dedent(found[1])


def test_helix_finds_the_server_of_its_language() -> None:
    read = tomllib.loads(lines_for("Helix"))
    (language,) = read["language"]
    servers = [read["language-server"][name] for name in language["language-servers"]]
    assert [[one["command"], *one["args"]] for one in servers] == [COMMAND]


def test_neovim_reads_its_lines(tmp_path: Path) -> None:
    lines = lines_for("Neovim")
    assert 'cmd = { "chipbreak", "language-server" }' in lines
    compiler = shutil.which("luac") or shutil.which("luac5.4") or shutil.which("luac5.1")
    if compiler is None:
        pytest.skip("needs luac")
    (tmp_path / "init.lua").write_text(lines)
    done = subprocess.run(
        [compiler, "-p", tmp_path / "init.lua"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_emacs_reads_its_lines() -> None:
    lines = lines_for("Emacs")
    assert '("chipbreak" "language-server")' in lines
    code = re.sub(r'"(?:\\.|[^"\\])*"', "", lines)  # parentheses in a text are none
    depths = [code[:at].count("(") - code[:at].count(")") for at in range(len(code) + 1)]
    assert min(depths) == 0
    assert depths[-1] == 0
