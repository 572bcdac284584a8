"""Programs that a shop could run, in round numbers, and settings that a machine could have.

Lengths that are whole multiples of a move, cuts as short as a vibration, controls that read few blocks: what
spoilt text does not reach.  Nothing here is spoilt, so what is written must go back, stay as it is when it is
filtered again, and be what ``verify`` finds.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from chipbreak.settings import profile_names

_SETS: tuple[tuple[float, str, tuple[object, ...]], ...] = (
    (0.6, "vibration.waveform", ("dwell", "triangle", "sine")),
    (0.4, "vibration.end", ("dwell", "feed")),
    (0.4, "vibration.end_revolutions", (0, 0.5, 1, 1.5, 2, 3, 20)),
    (0.5, "vibration.ramp_vibrations", (0, 0.5, 1, 2, 5)),
    (0.1, "vibration.ramp_s", (0, 0.01, 0.1, 1)),
    (0.2, "vibration.ramp_exponent", (0.5, 1, 2, 3)),
    (0.2, "vibration.alpha", (0.25, 0.5, 0.6, 0.75)),
    (0.2, "vibration.phase", (0.25, 0.5)),
    (0.2, "vibration.edges", (1, 2, 4)),
    (0.2, "vibration.correct", ("spindle", "count")),
    (0.2, "vibration.refused", ("error", "leave")),
    (0.1, "vibration.n", ("auto", 1.5, 0.5)),
    (0.1, "vibration.air", ("leave", "vibrate")),
    (0.3, "output.form", ("loop", "expanded")),
    (0.3, "output.segments", ("stroke", "tick", "auto")),
    (0.3, "output.feed_mode", ("inverse", "minute", "rev")),
    (0.2, "output.decimals", (2, 3, 4, 5)),
    (0.2, "output.feed_decimals", (2, 3, 4, 5)),
    (0.2, "planner.max_blocks_per_s", (50, 100, 250, 500, 1000, 2000)),
    (0.1, "planner.max_bytes_per_s", (960, 3840, 11520)),
    (0.1, "planner.dwell_step_ms", (1, 5, 10, 50)),
    (0.1, "planner.reversal_stop_ms", (0, 1, 4)),
    (0.1, "planner.servo_period_ms", (1, 2, 4)),
    (0.1, "planner.uncertainty", (0, 0.05, 0.2)),
    (0.2, "spindle.settle_s", (0, 0.5, 1)),
    (0.1, "spindle.max_rpm", (500, 1000, 3000)),
    (0.2, "cycles.unroll", ("always", "asked", "never")),
    (0.1, "tools.other_nose_radius_mm", (0.4, 0.8)),
)
_MODELS: tuple[tuple[str, ...], ...] = (
    ("planner.model=ideal",),
    *(
        (
            f"planner.model={model}",
            f"axes.X.max_acceleration_mm_s2={has}",
            f"axes.Z.max_acceleration_mm_s2={has}",
        )
        for model in ("trapezoid", "junction", "linuxcnc")
        for has in (500, 2000, 10000)
    ),
    *(
        (
            "planner.model=after-interpolation",
            f"axes.X.acc_dec_ms={ms}",
            f"axes.Z.acc_dec_ms={ms}",
            "axes.X.position_gain_1_s=30",
            "axes.Z.position_gain_1_s=30",
        )
        for ms in (8, 32, 64)
    ),
)
_WORDS = (
    *("N1.5", "N0.5", "N2.5", "N1.5 f25.", "N1.5 f62.5", "N0.5 f10.", "N1.5 Q0.2", "N0.5 Q0.1", "N1.5 A0.1"),
    *("f20.", "f50.", "E1.", "E1.5", "E2.", "E2.5", "E3.", "E4.", "E5.", "E10."),
)
_WISHES = (
    *("(VIB AUTO)", "(VIB N1.5)", "(VIB WAVE SINE N0.5)", "(VIB E2.5)", "(VIB WAVE DWELL E2.)", "(VIB OFF)"),
    *("(VIB N1.5 Q1.3)", "(VIB EDGES 2 N1.5)"),
)
_STEPS_MM = (0.12, 0.2, 0.36, 0.5, 1.0, 1.2, 2.0, 2.4, 3.0, 5.0, 6.0, 10.0, 12.5, 20.0, 25.0)


def drawn_sets(draw: random.Random) -> tuple[str, ...]:
    """Some settings, ``section.key=value`` each."""
    sets = [f"{key}={draw.choice(values)}" for share, key, values in _SETS if draw.random() < share]
    return (*sets, *(draw.choice(_MODELS) if draw.random() < 0.3 else ()))


def drawn_profile(draw: random.Random) -> str:
    """Any of the shipped ones."""
    return draw.choice(profile_names())


class _Writer:
    """Writes one program, a line after the other."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        self.lines: list[str] = []
        self.inch = draw.random() < 0.25
        self.x_mm = draw.choice((20.0, 30.0, 40.0, 60.0))
        self.z_mm = draw.choice((0.0, 1.0, 2.0, 5.0))
        per_rev = draw.random() < 0.6
        self.mode = draw.choice(("G99", "G95") if per_rev else ("G98", "G94"))
        self.feed_mm = draw.choice((0.05, 0.1, 0.12, 0.2, 0.25) if per_rev else (30, 60, 100, 120, 150, 200))

    def number(self, length_mm: float) -> str:
        """A length as the program says it."""
        return f"{length_mm / 25.4:.4f}" if self.inch else f"{length_mm:.3f}"

    def maybe(self, share: float, *lines: str) -> None:
        """One of some lines, now and then."""
        if self.draw.random() < share:
            self.lines.append(self.draw.choice(lines))

    def program(self) -> bytes:
        """All of it."""
        draw = self.draw
        self.lines += ["G20"] if self.inch else ["G21"] if draw.random() < 0.3 else []
        self.lines.append(f"G97 S{draw.choice((300, 500, 600, 750, 800, 1000, 1200, 1500, 2000, 3000))} M3")
        self.maybe(0.1, "G96 S100", "G96 S150")
        self.lines += [self.mode, f"G0 X{self.number(self.x_mm)} Z{self.number(self.z_mm)}"]
        for _ in range(draw.choice((1, 1, 1, 2, 3))):
            self.maybe(0.6, *_WISHES)
            self.lines += self.cut(f"F{self.number(self.feed_mm)} {self.word()}".rstrip())
            self.maybe(0.2, "M8", "(NOTE)", "")
            self.maybe(0.1, "S500", "S1000")
        self.lines += [f"G0 X{self.number(80.0)}", "M30"]
        return ("\n".join(self.lines) + "\n").encode()

    def word(self) -> str:
        """What asks for vibration in a block, or nothing."""
        return self.draw.choice(_WORDS) if self.draw.random() < 0.7 else ""

    def cut(self, words: str) -> list[str]:
        """The blocks of one cut."""
        step_mm = self.draw.choice(_STEPS_MM)
        write = self.draw.choice(_CUTS)
        return write(self, step_mm, words)

    def along(self, step_mm: float, words: str) -> list[str]:
        self.z_mm -= step_mm
        return [f"G1 Z{self.number(self.z_mm)} {words}"]

    def by_distance(self, step_mm: float, words: str) -> list[str]:
        self.z_mm -= step_mm
        return [f"G1 W-{self.number(step_mm)} {words}"]

    def under_g91(self, step_mm: float, words: str) -> list[str]:
        self.z_mm -= step_mm
        return ["G91", f"G1 Z-{self.number(step_mm)} {words}", "G90"]

    def taper(self, step_mm: float, words: str) -> list[str]:
        self.x_mm += 2.0 * step_mm * self.draw.choice((0.1, 0.5, 1.0))
        self.z_mm -= step_mm
        return [f"G1 X{self.number(self.x_mm)} Z{self.number(self.z_mm)} {words}"]

    def face(self, step_mm: float, words: str) -> list[str]:
        self.x_mm = max(self.x_mm - 2.0 * step_mm, 0.0)
        return [f"G1 X{self.number(self.x_mm)} {words}"]

    def arc(self, step_mm: float, words: str) -> list[str]:
        self.x_mm += 2.0 * step_mm
        self.z_mm -= step_mm
        code = self.draw.choice(("G2", "G3"))
        radius = self.number(step_mm)
        return [f"{code} X{self.number(self.x_mm)} Z{self.number(self.z_mm)} R{radius} {words}"]

    def before_a_dwell(self, step_mm: float, words: str) -> list[str]:
        return [*self.along(step_mm, words), self.draw.choice(("G4 X1.", "G4 P1.", "G4 U1."))]

    def chain(self, step_mm: float, words: str) -> list[str]:
        """Several blocks under one wish; here and there a corner between them."""
        corner = self.draw.choice(("", "", ",R0.5", ",C0.5", ",R2.", "R1.", ",C2."))
        first, *_ = self.along(step_mm, words)
        second, *_ = self.draw.choice((_Writer.taper, _Writer.face, _Writer.arc))(self, step_mm, "")
        return [f"{first} {corner}".rstrip(), second.removeprefix("G1 ").rstrip(), *self.along(1.0, "")]

    def turning_cycle(self, step_mm: float, words: str) -> list[str]:
        code = self.draw.choice(("G90", "G77"))
        x, z = self.number(self.x_mm - 2.0), self.number(self.z_mm - step_mm)
        return [f"{code} X{x} Z{z} {words}", f"X{self.number(self.x_mm - 3.0)}", "G0"]

    def roughing(self, step_mm: float, words: str) -> list[str]:
        x_mm, z_mm = max(self.x_mm - 2.0 * step_mm, 1.0), self.z_mm
        side = self.draw.choice(("", "", " G42", " G41"))
        contour = [
            f"N10 G0{side} X{self.number(x_mm)}",
            f"G1 Z{self.number(z_mm - 5.0)} F{self.number(self.feed_mm)}",
            f"X{self.number(x_mm + 1.0)} {self.draw.choice(('', ',R0.2', ',C0.2'))}".rstrip(),
            f"Z{self.number(z_mm - 10.0)}",
            f"N20{' G40' if side else ''} X{self.number(self.x_mm)}",
        ]
        finish = ["G70 P10 Q20"] if self.draw.random() < 0.6 else []
        depth, tail = self.number(self.draw.choice((0.5, 1.0, 2.0))), f"F{self.number(self.feed_mm)}"
        wish = self.draw.choice(("", " N1.5")) if " N" in words else ""
        left = f"U{self.number(0.4)} W{self.number(0.1)}"
        cycle = [f"G71 U{depth} R{self.number(0.5)}", f"G71 P10 Q20 {left} {tail}{wish}"]
        return [*cycle, *contour, *finish]

    def pecks(self, step_mm: float, words: str) -> list[str]:
        code = self.draw.choice(("G81", "G83", "G85", "G74", "G75"))
        depth = self.number(self.draw.choice((1.0, 2.0, 5.0)))
        place = f"Z{self.number(self.z_mm - step_mm)} R{self.number(self.z_mm)}"
        return [f"{code} {place} Q{depth} {words}", "G80"]


_CUTS = (
    *(_Writer.along, _Writer.along, _Writer.by_distance, _Writer.under_g91, _Writer.taper, _Writer.face),
    *(_Writer.arc, _Writer.before_a_dwell, _Writer.chain, _Writer.chain, _Writer.turning_cycle),
    *(_Writer.roughing, _Writer.pecks),
)


def drawn_program(draw: random.Random) -> bytes:
    """A whole program."""
    return _Writer(draw).program()


def drawn_programs(seed: int, count: int) -> Sequence[bytes]:
    """Several, for who wants to see some."""
    draw = random.Random(seed)
    return [drawn_program(draw) for _ in range(count)]
