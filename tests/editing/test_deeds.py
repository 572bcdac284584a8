"""What a block does beside moving is not lost with it, whichever pass writes others in its place."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.editing.bracket import CHANGES, UNROLLED_CYCLES
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import KEPT
from chipbreak.editing.render import render
from chipbreak.model.interpreted_program import interpret
from chipbreak.self_check import verify, verify_unrolled
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.source import read

HEAD = "G21 G90 G94 G97\nG0 X1. Z2.\n"


def _said(block: str, content: str, profile: str, *, unrolls: bool) -> str:
    """What the self-check says where ``content`` stands for ``block``; nothing where it holds."""
    settings = chipbreak.load(profile)
    program = (HEAD + block + "\nM30\n").encode()
    interpreted = interpret(parse(read(program), settings.dialect), settings)
    lines = block.count("\n") + 1
    edits = [Edit(2, 2 + lines, tuple(content.split("\n")), "TEST", "a reason", KEPT, "test")]
    layer = UNROLLED_CYCLES if unrolls else CHANGES
    output = b"".join(render(interpreted.program, edits, settings, layer))
    try:
        if unrolls:
            verify_unrolled(interpreted, output, edits, layer)
        else:
            verify(interpreted, output, edits)
    except SelfCheckError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("unrolls", [False, True])
@pytest.mark.parametrize(
    ("block", "content", "lost"),
    [
        ("#1=2 M8", "M8", "#1=2 of line 3"),
        ("# 1 = [2 + 1] M8", "#1=[2+1]\nM8", ""),
        ("#1=2\n#2=3", "#2=3", "#1=2 of line 3"),
        ("M8\nM26", "M8", "M26 of line 4"),
        ("M08 G4 X1.", "M8\nG4 X1.", ""),
        ("T0101", "M8", "T101 of line 3"),
        ("M#1", "M8", "M#1 of line 3"),
        ("IF[#1EQ2]GOTO9", "M8", "IF[#1EQ2] of line 3"),
        ("G0 X1. Z2.", "G0 X1.", ""),
    ],
)
def test_what_a_block_did_is_looked_for(block: str, content: str, lost: str, unrolls: bool) -> None:
    said = _said(block, content, "fanuc-lathe", unrolls=unrolls)
    assert said == (f"{lost} is lost in the new blocks" if lost else ""), said


@pytest.mark.parametrize(
    ("profile", "block", "content", "lost"),
    [
        ("linuxcnc-lathe", "G0 X1. (MSG, LOOK)", "G0 X1.", "(MSG, LOOK) of line 3"),
        ("linuxcnc-lathe", "G0 X1. (MSG, LOOK)", "(MSG, LOOK)\nG0 X1.", ""),
        ("linuxcnc-lathe", "G0 X1. (MSG, A) (PLAIN)", "(MSG, A)\nG0 X1.", "(MSG, A) (PLAIN) of line 3"),
        ("linuxcnc-lathe", "G0 X1. (PLAIN)", "G0 X1.", ""),
        ("fanuc-lathe", "G0 X1. (MSG, LOOK)", "G0 X1.", ""),  # it shows nobody anything
    ],
)
def test_comments_count_where_the_control_acts_on_them(
    profile: str, block: str, content: str, lost: str
) -> None:
    said = _said(block, content, profile, unrolls=False)
    assert said == (f"{lost} is lost in the new blocks" if lost else ""), said
