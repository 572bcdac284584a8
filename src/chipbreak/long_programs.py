"""A long program rewritten from an excerpt: what it takes does not grow with what lies between two changes.

The excerpt (``syntax.deciding_lines``) leaves out the middle of long runs of plain motion, and is a program
like any other: all stages run on it, the self-check included.  What was left out goes back, byte for byte,
into what comes out.  That is right where nothing depends on the lines between: no jump, no loop, no
subprogram of this file, no cut that vibrates, no distances, and a cut at both ends of what is left out.
Where one of these cannot be said for sure the program is read whole.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby

from chipbreak.editing.bracket import has_any
from chipbreak.editing.edits import in_order
from chipbreak.editing.restore import regions
from chipbreak.insertion.position_dependencies import HORIZON
from chipbreak.insertion.safe_points import REACH
from chipbreak.model.flow import contour_calls
from chipbreak.model.from_source import interpret_source
from chipbreak.model.interpreted_program import InterpretedProgram, called_programs
from chipbreak.model.plain_run import MODES
from chipbreak.model.shown_points import has_number_without_point
from chipbreak.pipeline import Result, Whole, options_of, run_stages
from chipbreak.settings import Settings
from chipbreak.settings.sections import SHOWN
from chipbreak.syntax.deciding_lines import PIECE_BYTES, read_long
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.excerpt import Excerpt, Gap
from chipbreak.text.long_file import LongFile
from chipbreak.text.source import read
from chipbreak.vibration.request import profile_directive

# A place before the first cut of a run, or behind the last one, is judged by no more lines than these.
AROUND = max(REACH, HORIZON)


def rewrite_long(
    program: LongFile,
    settings: Settings,
    *,
    allow_unbroken: bool = False,
    messages: bool = False,
    progress: Callable[[int], None] | None = None,
    around: int = AROUND,
    piece_bytes: int = PIECE_BYTES,
) -> Result | None:
    """What filtering makes of the excerpt of a program; None where the program must be read whole.

    The options are those of :func:`chipbreak.pipeline.rewrite`, and so is what is raised; OSError too.
    """
    if any(needs_whole(settings) for needs_whole in _WHOLE_BY_PROFILE):
        return None
    excerpt = read_long(program, settings.dialect, around, piece_bytes)
    if excerpt is None or has_any(excerpt.source.data):
        return None
    interpreted = interpret_source(excerpt.source, settings)
    if any(needs_whole(interpreted) for needs_whole in _WHOLE_BY_PROGRAM):
        return None
    whole = Whole.of(interpreted)._replace(excerpt=excerpt)
    if not all(_is_idle(whole, tuple(gaps)) for _, gaps in groupby(excerpt.gaps, key=_run_of(interpreted))):
        return None
    try:
        result = run_stages(whole, None, options_of(allow_unbroken, messages, progress))
    except SelfCheckError:  # of the whole program it counts
        return None
    if not _fits(result, excerpt):
        return None
    return result._replace(changed=bool(result.edits))


def pieces_of(result: Result) -> Iterator[bytes]:
    """What comes out, with what the excerpt left out.  Raises OSError."""
    assert result.whole is not None
    excerpt = result.whole.excerpt
    assert excerpt is not None
    at = 0
    for gap, place in zip(excerpt.gaps, _places(result, excerpt), strict=True):
        yield result.data[at:place]
        yield from excerpt.whole.blocks(gap.start, gap.size)
        at = place
    yield result.data[at:]


def _places(result: Result, excerpt: Excerpt) -> Iterator[int]:
    """Where each gap stands in the output."""
    source = excerpt.source
    output = read(result.data, source.name, encoding=source.encoding)
    edits = in_order(result.edits)
    found = regions(output)
    grown = 0
    done = 0
    for gap in excerpt.gaps:
        while done < len(edits) and edits[done].last <= gap.line:
            edit, region = edits[done], found[done]
            new = int(output.starts[region.last] - output.starts[region.first])
            grown += new - int(source.starts[edit.last] - source.starts[edit.first])
            done += 1
        yield int(source.starts[gap.line]) + grown


# --- what asks for the whole program -----------------------------------------------------------------------
def _asks_for_vibration(settings: Settings) -> bool:
    return profile_directive(settings).on or settings.cycles.unroll == "always"


def _keeps_brackets_beside(settings: Settings) -> bool:
    return settings.output.brackets == "none"


def _has_plug_ins(settings: Settings) -> bool:
    return bool(settings.passes.extra)


def _measures_every_line(settings: Settings) -> bool:
    """A control that stops at a line that is too long, or at a word in it."""
    return settings.dialect.stops_at is not None


def _looks_where_was_cut(settings: Settings) -> bool:
    """A way home past everything that has been cut: the clearance of a turning tool."""
    return settings.dialect.is_lathe and settings.checks.enabled


_WHOLE_BY_PROFILE: tuple[Callable[[Settings], bool], ...] = (
    _asks_for_vibration,
    _keeps_brackets_beside,
    _has_plug_ins,
    _measures_every_line,
    _looks_where_was_cut,
)


def _shows_its_control(interpreted: InterpretedProgram) -> bool:
    """What a program shows of its control it shows by all of its numbers."""
    leaves_it = interpreted.settings.control.decimal_point == SHOWN
    return bool(interpreted.settings.shown.rule) or (
        leaves_it and has_number_without_point(interpreted.program)
    )


def _is_not_straight(interpreted: InterpretedProgram) -> bool:
    """Jumps, loops, calls: a block may be named by its number, and the number be left out."""
    effects = interpreted.effects
    goes = any(effect.block.controls or effect.does("subprogram") for effect in effects)
    return goes or bool(interpreted.flow.targets or interpreted.flow.contours)


def _calls_a_shape(interpreted: InterpretedProgram) -> bool:
    return bool(contour_calls(interpreted.program, interpreted.settings.dialect))


def _has_programs(interpreted: InterpretedProgram) -> bool:
    return bool(called_programs(interpreted))


def _wishes_for_vibration(interpreted: InterpretedProgram) -> bool:
    said = any(
        "VIB" in comment.text.upper()
        for block in interpreted.program.event_blocks()
        for comment in block.comments
    )
    return said or any(effect.vibration or effect.block.has("N") for effect in interpreted.effects)


_WHOLE_BY_PROGRAM: tuple[Callable[[InterpretedProgram], bool], ...] = (
    _shows_its_control,
    _is_not_straight,
    _calls_a_shape,
    _has_programs,
    _wishes_for_vibration,
)


# --- what must hold of what was left out -------------------------------------------------------------------
def _run_of(interpreted: InterpretedProgram) -> Callable[[Gap], int]:
    """The run of plain lines in which a gap is, by the index of the special line behind it."""
    specials: list[int] = interpreted.program.special_lines.tolist()
    return lambda gap: bisect_left(specials, gap.line)


def _is_idle(whole: Whole, gaps: Sequence[Gap]) -> bool:
    """True where a run has cuts before and behind its gaps, and its last words say where it ends."""
    interpreted = whole.interpreted
    program = interpreted.program
    before = gaps[0].line
    behind = gaps[-1].line
    at = _run_of(interpreted)(gaps[0])
    bounds = [program.source.body.start - 1, *program.special_lines.tolist(), program.source.body.stop]
    first, last = bounds[at] + 1, bounds[at + 1]
    if not (first < before <= behind < last and whole.main.has(before) and whole.main.has(behind)):
        return False
    state = interpreted.before(before)
    is_plain = state.modes.motion in MODES and not state.ended and state.modes.distance == "absolute"
    distances = bits_of(interpreted.settings.axis_words.distances)
    has_distances = bool((program.bits[first:last] & distances).any())
    cuts = whole.main.cut_ends(first, before) and whole.main.cut_ends(behind, last)
    return is_plain and not has_distances and bool(cuts)


def _fits(result: Result, excerpt: Excerpt) -> bool:
    """True where nothing vibrates or was written out, and no change stands where something was left out."""
    if result.reports or result.left or result.cycles or result.source is not excerpt.source:
        return False
    return not any(excerpt.gaps_in(edit.first, edit.last) for edit in result.edits)
