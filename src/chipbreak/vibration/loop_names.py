"""What the loops of a program may be called: a counter and labels that it does not use itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from chipbreak.dialects.base import Loop
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import Program
from chipbreak.syntax.variables import variables_of
from chipbreak.text.diagnostics import RefusalError


@dataclass(frozen=True)
class LoopNames:
    """What loops may be called in one program: a counter, and labels that are not taken."""

    words: Loop
    variable: int
    labels: Sequence[int]

    def behind(self, loops: int) -> LoopNames:
        """The names that are left when some loops have been written."""
        if self.words.reuses:
            return self
        return LoopNames(self.words, self.variable, self.labels[loops:])

    def lines(self, loop: int, passes: int) -> tuple[list[str], list[str]]:
        """The lines before and behind the blocks of a loop, the ``loop``-th of a cut."""
        label = self.labels[0 if self.words.reuses else loop]
        values = {"variable": self.variable, "label": label, "passes": passes}
        return [t.format(**values) for t in self.words.begin], [t.format(**values) for t in self.words.end]


def free_names(program: Program, settings: Settings) -> LoopNames | None:
    """Names for the loops of a program, None where none are asked for.

    Errors: VIB080 when the program needs the counter itself, or has taken every label.
    """
    words = settings.dialect.loop
    if settings.output.form != "loop" or words is None:
        return None
    variables, labels = _taken(program)
    counter = settings.output.loop_variable
    if words.variables and (counter in variables or None in variables):
        why = f"uses #{counter}" if counter in variables else "uses variables whose number it works out"
        message = f"the program {why}, and loops count in #{counter}"
        other = "" if None in variables else "name another output.loop_variable, or "
        raise RefusalError("VIB080", message, f'{other}take output.form "expanded"')
    free = [label for label in words.labels if label not in labels]
    if not free:
        message = f"the program has loops of its own with every label from {words.labels[0]} on"
        raise RefusalError("VIB080", message, 'take output.form "expanded" for this program')
    return LoopNames(words, counter, free)


def _taken(program: Program) -> tuple[set[int | None], set[int]]:
    """Numbers of variables (None for one that is worked out) and of labels that a program says."""
    variables: set[int | None] = set()
    labels: set[int] = set()
    for block in program.event_blocks():
        for control in block.controls:
            if control.label.isdigit() and control.keyword != "GOTO":
                labels.add(int(control.label))
        variables.update(key for key in variables_of(block) if not isinstance(key, str))
    return variables, labels
