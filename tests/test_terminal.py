"""Nothing that a program, a file name, a profile or a tool file says gives orders to a terminal.

Every command is run with control characters in all that it reads; only programs (what is filtered, restored,
or shown as a file that was asked for) keep their bytes.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from chipbreak.cli import cli

ESC = "\x1b[31m"
# A tool list, operations, a cut that vibrates, a line that cannot be read, a stray word, an open comment.
PROGRAM = (
    b"%\nO1 (\x1b[2J TITLE \x9b2J \x7f)\n(T1 D=10. CR=0. - FLAT \x1b]0;x\x07 END MILL)\nG21 G99\n"
    b"T0101 (ROUGH \x1b[5m)\nG97 S3000 M3\nG0 X20. Z2.\n(ROUGH \x1b[7m)\nG1 Z-30. F0.05 N1.5\n"
    b"(VIB N1.5 \x1b[1m)\n(VIB OFF)\nG0 X30.\n"
    b"G1 X40. F0.1 \x1b[0m &\nG65 P\x1b9810\nGOTO20\nN20 M30\n%\n"
)
CLEAN = (
    b"(\x1b[2J)\nG97 S3000 M3\n(ROUGH \x1b[7m)\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5 (\x1b[5m)\nG0 X30.\nM30\n"
)
TOOLS = '[[tools]]\nnumber = 1\ntype = "flat end mill\\u001b[2J"\nname = "\\u001b[31m\\u009b"\n'
PROFILE = (
    'base = "fanuc-lathe"\n[planner]\nsmoothing_on = "G5.1 Q1 (\\u001b[2J \\u007f)"\n[operations]\n'
    'rough = ["\\u001b\\\\[7m"]\n[tools]\ntable_unit = "mm"\n'
)
SPOILED = 'base = "fanuc-lathe"\n[pla\x1bnner]\nx = "\x1b[2J"\n'
NAMES = ("a", "b", "tools.toml", "own.toml", "spoiled.toml", "trace.csv", "clean")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("odd") / f"in{ESC}\x7f"
    folder.mkdir()
    other = PROGRAM.replace(b"Z-30.", b"Z-31.").replace(b"TITLE", b"OTHER")
    settings = (TOOLS.encode(), PROFILE.encode(), SPOILED.encode())
    texts = (PROGRAM, other, *settings, b"tooth,z\n\x1b[2J,1\n", CLEAN)
    for name, data in zip(NAMES, texts, strict=True):
        (folder / f"{ESC}{name}").write_bytes(data)
    return folder


COMMANDS = [
    "check {a} -p generic-lathe",
    "check {a} -p generic-lathe --json",
    "explain {a} -p fanuc-lathe --allow-unbroken",
    "explain {a} -p fanuc-mill",
    "explain {a} -p generic-lathe --json",
    "filter {a} -p fanuc-lathe -o {out}",
    "filter {a} -p linuxcnc-mill -o {out}",
    "filter {a} -p {own} -o {out}",
    "filter {a} -p {spoiled} -o {out}",
    "filter {a} -p \x1b[2J",
    "filter {a} --set \x1b[2J",
    "filter {a} --set \x1b[2J.x=\x1b[2J",
    "filter {a} --set planner.model=\x1b[2J",
    "filter {missing} -p fanuc-lathe",
    "filter {a} {b} -o {out} -p fanuc-lathe",
    "filter -i {missing} -p fanuc-lathe",
    "filter {a} -p fanuc-lathe -o {missing}/x",
    "filter {a} -p fanuc-mill --tools {tools} -o {out}",
    "filter {a} -p fanuc-mill --tools {a}",
    "verify {a} -p fanuc-lathe",
    "restore {missing}",
    "diff {a} {b}",
    "diff {a} {b} -p fanuc-lathe",
    "diff -y {a} {b}",
    "diff --html {a} {b}",
    "diff --json {a} {b}",
    "diff {a} {missing}",
    "tools {a} -p fanuc-mill",
    "tools {a} -p fanuc-mill --tools {tools}",
    "tools {a} -p fanuc-mill --json --tools {tools}",
    "tools {a} -p fanuc-mill --tools {spoiled}",
    "inspect {trace} {trace} --next finish",
    "inspect {trace} {missing} --next finish",
    "batch {folder} -o {out}s -p generic-lathe",
    "batch {missing} -o {out}s -p generic-lathe",
    "profile show {own}",
    "profile show {spoiled}",
    "profile list",
    "profile init {out} --from-ini {spoiled}",
    "profile init {out} --from-ini {a}",
    "profile init {out} --from-parameters {a}",
    "plot {clean} -p generic-lathe -o {out}.svg",
    "plot {clean} -p generic-lathe -o {out}",
    "plot {missing} -p generic-lathe -o {out}.svg",
    "report {clean} -p generic-lathe -o {out}",
    "report {clean} -p generic-lathe -o {missing}/x.html",
    "filter {clean} -p generic-lathe -o {out}",
    "filter -i {clean} -p generic-lathe --backup \x1b[2J",
    "check {clean} -p generic-lathe",
    "explain {clean} -p generic-lathe",
    "verify {clean} -p generic-lathe",
    "profile show \x1b[2J",
    "macros -p {own} -o {out}s",
    "\x1b[2J",
    "--\x1b[2J",
    "filter --\x1b[2J",
    "diff {a} {b} --tolerance \x1b[2J",
    "diff {a} {b} \x1b[2J",
]


def obeyed(text: str) -> list[str]:
    """The lines of a text with characters that a terminal would not show, as plain ASCII."""
    return [ascii(line) for line in text.split("\n") if not line.isprintable()]


@pytest.mark.parametrize("command", COMMANDS, ids=[repr(command) for command in COMMANDS])
def test_no_control_character_reaches_a_terminal(command: str, folder: Path, tmp_path: Path) -> None:
    places = {name.partition(".")[0]: str(folder / f"{ESC}{name}") for name in NAMES}
    named = {**places, "missing": f"{folder}/no{ESC}", "folder": str(folder), "out": f"{tmp_path}/out{ESC}"}
    done = CliRunner().invoke(cli, [part.format(**named) for part in command.split(" ")])
    said = done.output_bytes.decode("utf-8", "surrogateescape")
    assert done.exception is None or isinstance(done.exception, SystemExit)
    assert obeyed(said) == []
    silent = command.startswith(("macros", "plot", "report", "check {clean}"))
    assert silent or said
    if "--json" in command:
        json.loads(done.stdout_bytes or done.stderr_bytes)
