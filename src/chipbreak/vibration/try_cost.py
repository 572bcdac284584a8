"""What it costs to try a cut: to make its blocks and to judge them, in blocks of a straight stroke."""

from __future__ import annotations

from chipbreak.settings.sections import Settings
from chipbreak.trajectory.filters import NO_FILTER
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.plan import CutPlan

_LEAST_UNLIKE = 40  # blocks that any cut costs whose strokes are hardly alike
_STROKES_OF_SEVERAL = 60_000  # what finding the feeds of strokes of several moves costs, few as they may be
_FILTERED = 5
_FILTERED_ON_BENDS = 10
_FEW_CORNERS = 8
_MANY_IN_STROKES = 500  # moves of a cut whose strokes are several moves each


def cost_of(plan: CutPlan, settings: Settings) -> int:
    """What it costs to make the blocks of a plan and to judge them, in blocks of a straight stroke."""
    moves = plan.wave.vibrations * plan.wave.moves_per_vibration
    law = control_along(settings, plan.path, plan.chain.before)
    if law.unlike_stroke_costs > 1 and _has_unlike_strokes(plan, moves):
        return law.unlike_stroke_costs * max(moves, _LEAST_UNLIKE) * len(law.variants())
    if all(axis.filter == NO_FILTER for axis in law.axes):
        return moves
    is_straight = len(plan.path.legs) == 1 and plan.path.arcs[0] is None
    return moves * (_FILTERED if is_straight else _FILTERED_ON_BENDS)


def cost_of_way_out(plan: CutPlan, settings: Settings) -> int:
    """The same for a cut that is tried to be named: however short, it has its ramps to be fitted."""
    law = control_along(settings, plan.path, plan.chain.before)
    has_several = law.runs_whole_periods and plan.wave.form == "tick"
    return max(cost_of(plan, settings), _STROKES_OF_SEVERAL if has_several else 0)


def _has_unlike_strokes(plan: CutPlan, moves: int) -> bool:
    """True where hardly two strokes are alike: of several blocks, which are rounded each on its own."""
    is_long = plan.wave.form == "tick" and moves > _MANY_IN_STROKES
    bends = any(arc is not None for arc in plan.path.arcs) or len(plan.path.corners_mm()) > _FEW_CORNERS
    return bends or is_long
