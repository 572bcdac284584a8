"""How long a program feeds, as it is written: the time beside which that of its checks is seen."""

from __future__ import annotations

import math

from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.interpreted_program import interpret
from chipbreak.settings import Settings
from chipbreak.syntax.parse import parse
from chipbreak.text.source import Source
from chipbreak.units import S_PER_MIN


def feed_time_s(source: Source, settings: Settings) -> float | None:
    """Seconds of all straight and circular cuts of the main path, None where not one is known.

    Cycles, loops and subprograms count as they stand in the text, and the axes' acceleration not at all: it
    is an estimate from below.
    """
    interpreted = interpret(parse(source, settings.dialect), settings)
    body = interpreted.program.source.body
    known = [_seconds(effect) for effect in interpreted.effects_of(body.start, body.stop)]
    whole = sum(one for one in known if one > 0.0)
    return whole or None


def _seconds(effect: BlockEffect) -> float:
    """How long a block feeds, 0 where it does not or where nobody can know it."""
    move, feed = effect.move, effect.after.feed
    if move is None or not move.is_cut or feed is None or not feed.value > 0.0:
        return 0.0
    mode = effect.after.modes.feed_mode
    if mode == "inverse":
        return S_PER_MIN / feed.value
    speed = effect.after.speed
    per_minute = feed.value if mode == "minute" else feed.value * (speed.value if speed else 0.0)
    length = _length_mm(move)
    return length / per_minute * S_PER_MIN if per_minute > 0.0 and math.isfinite(length) else 0.0


def _length_mm(move: Move) -> float:
    """The way along a line; along an arc that of its chord, or a half circle where it says no more."""
    chord = math.dist(move.start[:3], move.end[:3])
    if move.kind == "line" or not math.isfinite(chord):
        return chord
    radius = move.radius_mm if math.isfinite(move.radius_mm) else _offset_mm(move)
    if not math.isfinite(radius) or radius <= 0.0:
        return chord
    if chord < 1e-6:
        return 2.0 * math.pi * radius
    return 2.0 * radius * math.asin(min(1.0, chord / (2.0 * radius)))


def _offset_mm(move: Move) -> float:
    """How far the centre is, NaN where the block does not say it."""
    if move.offsets is None:
        return math.nan
    said = [one for one in move.offsets[:3] if math.isfinite(one)]
    return math.hypot(*said) if said else math.nan
