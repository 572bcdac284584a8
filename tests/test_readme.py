"""What the README shows is what comes out."""

from __future__ import annotations

import re
from pathlib import Path

import chipbreak
from chipbreak.report import explain_text

README = Path(__file__).parents[1] / "README.md"


def shown(*, behind: str) -> list[str]:
    """The lines of the first indented block behind a sentence, without their indent."""
    text = README.read_text("utf-8").partition(behind)[2]
    block = re.search(r"(?:^(?: {4}.*|)\n)+", text.lstrip("\n"), re.MULTILINE)
    assert block is not None
    return [line[4:] for line in block[0].strip("\n").split("\n")]


def test_the_example() -> None:
    lines = shown(behind="## One block, from byte to byte")
    commands = [i for i, line in enumerate(lines) if line.startswith("$ ")]
    assert [lines[i] for i in commands] == ["$ cat part.nc", "$ chipbreak filter -p generic-lathe part.nc"]
    program, wanted = lines[commands[0] + 1 : commands[1]], lines[commands[1] + 1 :]
    data = "".join(f"{line}\n" for line in program).encode()
    out = chipbreak.rewrite(data, chipbreak.load("generic-lathe")).data.decode().rstrip("\n").split("\n")
    gap = wanted.index("...")
    assert out[:gap] == wanted[:gap]
    assert out[gap - len(wanted) + 1 :] == wanted[gap + 1 :]


def test_the_explanation() -> None:
    wanted = [line.strip() for line in shown(behind="`chipbreak explain` shows all of it:")]
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(program, settings, "part.nc")
    said = [line.strip() for line in explain_text(result, settings)]
    assert said[said.index(wanted[0]) :][: len(wanted)] == wanted
