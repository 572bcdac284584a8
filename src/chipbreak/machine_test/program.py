"""The program of the test: an air cut from where the tool is, in plus direction and back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from chipbreak.machine_test.groups import Group, ideal_s, longest_mm
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_WAIT_S = 10.0
REST_S = 1.0  # before each group, by which a trace is cut into groups
_DECIMALS = 4
_FEED_DECIMALS = 1


class _Writer(NamedTuple):
    """How blocks are written on a control: the letter of each axis, what a millimetre is in it."""

    settings: Settings
    letters: dict[str, str]
    scales: dict[str, float]
    modal: bool

    def comment(self, text: str) -> str:
        """A comment in capitals, which every control shows."""
        marks = self.settings.dialect.comment_marks
        return f"{marks.before}{text.upper()}{marks.behind}"

    def strokes(self, group: Group) -> Iterator[str]:
        """The blocks of a group."""
        code = "G1 "
        feed = f" F{print_number(group.feed_mm_min, _FEED_DECIMALS)}"
        for move in group.moves_mm.tolist():
            words = [
                self.letters[axis]
                + self.settings.dialect.set_off
                + print_number(way * self.scales[axis], _DECIMALS)
                for axis, way in zip(AXES, move, strict=True)
                if way
            ]
            yield code + " ".join(words) + feed
            feed = ""
            code = "G1 " if self.settings.dialect.repeats_codes else ""

    @property
    def incremental(self) -> str:
        """The code by which words become distances, nothing where letters do."""
        return self.settings.dialect.code("distance", "incremental") if self.modal else ""

    @property
    def absolute(self) -> str:
        """The code that ends that."""
        return self.settings.dialect.code("distance", "absolute") if self.modal else ""


def program_text(settings: Settings, groups: Sequence[Group], variables: Sequence[int]) -> str:
    """The program; ``variables`` are those in which the times are left, one a group, or none.

    Errors: MTS001 where the control has no way to move by distances or no feed per minute.
    """
    writer = _writer_for(settings, groups)
    lines = [*_head(writer, groups, bool(variables))]
    for number, group in enumerate(groups):
        lines += _group(writer, group, variables[number] if variables else None)
    lines += _end(writer, variables)
    return "".join(f"{line}\n" for line in lines if line)


def variables_for(settings: Settings, groups: Sequence[Group]) -> list[int]:
    """The variables in which the control leaves the times; none where it has no clock that programs read."""
    clock = settings.dialect.clock
    return [] if clock is None else [clock.first_variable + number for number in range(len(groups))]


def _writer_for(settings: Settings, groups: Sequence[Group]) -> _Writer:
    dialect = settings.dialect
    axes = sorted({group.axis for group in groups})
    words = settings.axis_words
    distances = {axis: words.distance_letter(axis) for axis in axes}
    modal = any(letter is None for letter in distances.values())
    if (modal and not dialect.can("distance", "incremental")) or not _has_minutes(settings):
        message = f"the test moves by distances, at a feed per minute, and {dialect.title} has no code for it"
        raise RefusalError("MTS001", message, "name the profile of another control with -p")
    letters = {axis: distances[axis] if not modal else words.letters[axis] for axis in axes}
    scales = {
        axis: words.signs[axis] * (2.0 if axis == "X" and settings.control.x_diameter else 1.0)
        for axis in axes
    }
    return _Writer(settings, {a: letter for a, letter in letters.items() if letter}, scales, modal)


def _has_minutes(settings: Settings) -> bool:
    dialect = settings.dialect
    return dialect.can("feed_mode", "minute") or dialect.initial.feed_mode == "minute"


def _head(writer: _Writer, groups: Sequence[Group], timed: bool) -> Iterator[str]:
    settings = writer.settings
    dialect = settings.dialect
    if dialect.clock is not None:
        yield "%"
        yield f"O{dialect.clock.program}{writer.comment('machine test')}"
    axes = sorted({group.axis for group in groups})
    ways = " and ".join(f"{axis}+ by {longest_mm(groups, axis):g} mm" for axis in axes)
    minutes = max(1, round(ideal_s(groups, REST_S) / 60.0))
    yield writer.comment("machine test of chipbreak: moves in air, no work, no tool near anything")
    yield writer.comment(f"jog to where these ways are free: {ways}")
    yield writer.comment("it starts from there, goes no other way, and ends there")
    yield writer.comment(f"spindle off, feed override 100 %, about {minutes} min")
    if timed:
        yield writer.comment("the times are left in variables: write them into the form")
    yield from _wait(writer)
    modes = [("units", "mm"), ("feed_mode", "minute"), ("compensation", "off")]
    codes = [dialect.code(*mode) for mode in modes if dialect.can(*mode)]
    yield from codes if dialect.repeats_codes else [" ".join(codes)]
    planner = settings.planner
    # The overrides stay with the operator, who may want to see it slowly first.
    yield from (planner.smoothing_off, planner.path_mode)
    yield writer.incremental if dialect.clock is None else ""


def _wait(writer: _Writer) -> Iterator[str]:
    """Time to start a trace."""
    dialect = writer.settings.dialect
    knows_stop = any(code[:2] == ("stop", "always") for code in dialect.m_codes.values())
    if dialect.holds_programs and knows_stop:
        yield writer.comment("start the trace, if there is one, then go on")
        yield dialect.m_code("stop", "always")
    else:
        yield writer.comment(f"start the trace, if there is one, within {_WAIT_S:g} s")
        yield _dwell(writer, _WAIT_S)


def _dwell(writer: _Writer, time_s: float) -> str:
    dialect = writer.settings.dialect
    word = writer.settings.control.dwell_word or dialect.dwell_word
    return f"G4 {word}{print_number(time_s * dialect.dwells_per_s, 3)}"


def _group(writer: _Writer, group: Group, variable: int | None) -> Iterator[str]:
    yield writer.comment(f"{group.name} {group.told}")
    yield _dwell(writer, REST_S)
    blocks = writer.strokes(group)
    clock = writer.settings.dialect.clock
    if clock is None or variable is None:
        yield from blocks
        return
    # The control works statements out while it reads ahead, unless a block in front stops that.
    wait = f"{writer.absolute} {clock.wait}".strip()
    yield wait
    yield clock.begin
    yield f"{writer.incremental} {next(blocks)}".strip()
    yield from blocks
    yield wait
    yield clock.end.format(variable=variable)


def _end(writer: _Writer, variables: Sequence[int]) -> Iterator[str]:
    settings = writer.settings
    planner = settings.planner
    dialect = settings.dialect
    yield writer.absolute
    yield planner.smoothing_on
    yield planner.usual_path_mode if planner.path_mode else ""
    if variables and dialect.clock is not None:
        yield dialect.clock.message.format(text=f"TIMES IN {variables[0]} TO {variables[-1]}")
    yield dialect.m_code("program", "end") if dialect.holds_programs else ""
    if dialect.clock is not None:
        yield "%"
