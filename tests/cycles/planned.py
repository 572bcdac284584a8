"""What is planned for the cycles of a program, without the rest of the filter."""

from __future__ import annotations

from functools import cache

from chipbreak.cycles.plan import UnrollPlan, plan_unrolling
from chipbreak.editing.edits import Edit
from chipbreak.model.from_source import interpret_source
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.settings import Settings, load
from chipbreak.text.source import read

HEAD = "G21 G40 G99\nT0101\nG97 S1200 M3\nG0 X52. Z2.\n"
TAIL = "G0 X100. Z100.\nM30\n"
Said = tuple[int, str, str, str]
settings_of = cache(load)


def settings(profile: str = "fanuc-lathe", *options: str) -> Settings:
    return settings_of(profile, options)


def interpreted(program: str, *options: str, profile: str = "fanuc-lathe") -> InterpretedProgram:
    return interpret_source(read(program.encode()), settings(profile, *options))


def planned(program: str, *options: str, profile: str = "fanuc-lathe") -> UnrollPlan:
    """With all that can be asked."""
    read_as = interpreted(program, *options, profile=profile)
    return plan_unrolling(read_as, range(read_as.program.source.line_count))


def edits(program: str, *options: str, profile: str = "fanuc-lathe") -> list[Edit]:
    return [one.edit for one in planned(program, *options, profile=profile).edits]


def blocks(edit: Edit) -> list[str]:
    return [text for text in edit.content if isinstance(text, str)]


def refused(program: str, *options: str, profile: str = "fanuc-lathe") -> list[Said]:
    """Line (from 1), code, message and help of what is said of cycles that stay."""
    found = planned(program, *options, profile=profile)
    return [(one.line + 1, one.error.code, one.error.message, one.error.help) for one in found.refused]


def noted(program: str, *options: str) -> list[Said]:
    """The same of cycles that are written out."""
    found = planned(program, *options)
    return [(one.line + 1, one.error.code, one.error.message, one.error.help) for one in found.notes]
