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
    (0.6, "vibration.refused", ("error", "leave", "leave")),
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
    (0.1, "output.brackets", ("comments", "none")),
    (0.1, "output.stamp", ("true", "false")),
    (0.1, "control.decimal_point", ("calculator", "increment", "required")),
)
_CHECKED: tuple[tuple[float, str, tuple[object, ...]], ...] = (
    (0.2, "checks.strict", ("true", "false")),
    (0.2, "checks.calls", ("builtin", "renishaw", "haas", "setter")),
    (0.3, "checks.depth", ("limit-line", "breakage", "full")),
    (0.2, "checks.last_use", ("next-part", "none", 1, 0.05)),
    (0.2, "checks.missing", ("control", "error", "skip")),
    (0.1, "checks.only", ("[1]", "[1, 2]", "[9]")),
    (0.1, "checks.ignore", ("[1]", "[2, 3]")),
    (0.1, "checks.sister", ("{1=2}", "{1=11, 2=12}")),
    (0.2, "checks.every", (1, 2, 10)),
    (0.1, "checks.retries", (0, 1, 3)),
)
_PLAIN = ("grbl", "klipper")  # which know neither G97 nor a feed per revolution
_ACCELERATIONS = tuple(f"axes.{axis}.max_acceleration_mm_s2=2000" for axis in "XYZ")
_PLATE = (
    *("macros.beam_x_mm=400", "macros.beam_y_mm=120", "macros.beam_z_mm=-350", "macros.safe_z_mm=0"),
    *("macros.master_length_mm=120", "macros.master_diameter_mm=10", "macros.laser_on=M50"),
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
# Lines that may stand between any two others, whatever these are the middle of.
_BETWEEN = (
    *("M30", "M2", "M99", "M98 P1", "M0", "M1", "M5", "T0202", "M6", "S500", "G4 X1.", "G28 U0 W0", "G53 X0"),
    *("G40", "G42", "G20", "G91", "G94", "G50 S100", "M3 S300", "G96 S100", "G1", "G80", "#1=1", "G0", "G90"),
    *(
        "IF[#1EQ1]GOTO10",
        "GOTO 20",
        "N10",
        "N20 G1 X5.",
        "O2",
        "%",
        "",
        "(VIB N1.5)",
        "(VIB OFF)",
        "(x",
        "M8",
    ),
    *("G2 X1. Z1. R9.", "/M8", "/G1 X3.", "G71 U1. R0.5", "G70 P10 Q20", "G92 X0", "X30.", "Z1.", "U1. W-1."),
    *("G65 P9001", "M97 P5", "G10 L2 P1 X0", "G52 X1.", "G32 Z-9. F1.", "G1 Z-99. F0.1 ,R1.", "X10. Z-99."),
    *("G18", "G17", "G43 H1", "$1", "!2L1"),
)
# Words that may stand in any block, whatever it does.
_BESIDE = (
    *(
        "M30",
        "M2",
        "M99",
        "M0",
        "M1",
        "M5",
        "M3",
        "M8",
        "M98 P1",
        "T2",
        "S500",
        "F0.1",
        "F500.",
        "G4",
        "G53",
        "G28",
    ),
    *(
        "G91",
        "G20",
        "G94",
        "G95",
        "G96",
        "G40",
        "G41",
        "G42",
        "G43",
        "G49",
        "G54",
        "G80",
        "G0",
        "G1",
        "G2",
        "G3",
    ),
    *(
        "G17",
        "G18",
        "G92",
        "G50",
        "X1.",
        "Z-1.",
        "Y1.",
        "U1.",
        "W-1.",
        "I1.",
        "K1.",
        "R1.",
        ",R1.",
        ",C1.",
        "C1.",
    ),
    *("A45.", ",A45.", "Q0.2", "P1", "L2", "H1", "D1", "E2.", "N1.5", "N2.", "f25.", "/", "(x)", "(VIB OFF)"),
    *(
        "#1=1",
        "$1",
        "O5",
        "N77",
        "B1.",
        "G61",
        "G9",
        "G65 P1",
        "G31",
        "G32",
        "G71",
        "G76",
        "G81",
        "X",
        "X#1",
        "%",
    ),
)
_ENDS = ("M30", "M30", "M2", "M99")
_STEPS_MM = (0.12, 0.2, 0.36, 0.5, 1.0, 1.2, 2.0, 2.4, 3.0, 5.0, 6.0, 10.0, 12.5, 20.0, 25.0)


def drawn_sets(draw: random.Random, profile: str) -> tuple[str, ...]:
    """Some settings for a profile, ``section.key=value`` each."""
    sets = _some(draw, _SETS)
    if draw.random() < 0.3:
        sets += draw.choice(_MODELS)
    elif profile.startswith("grbl"):
        sets += _ACCELERATIONS
    if _is_mill(profile) and draw.random() < 0.5:
        sets += ["checks.enabled=true", *_PLATE, *_some(draw, _CHECKED)]
    return tuple(sets)


def _some(draw: random.Random, rows: Sequence[tuple[float, str, tuple[object, ...]]]) -> list[str]:
    return [f"{key}={draw.choice(values)}" for share, key, values in rows if draw.random() < share]


def drawn_profile(draw: random.Random) -> str:
    """Any of the shipped ones."""
    return draw.choice(profile_names())


class _Writer:
    """Writes one program, a line after the other."""

    def __init__(self, draw: random.Random, profile: str) -> None:
        self.draw = draw
        self.is_linuxcnc = profile.startswith("linuxcnc")
        self.is_plain = profile in _PLAIN
        self.is_lathe = profile.endswith("lathe")
        self.lines: list[str] = []
        self.subs: list[str] = []
        self.inch = draw.random() < 0.25
        self.x_mm = draw.choice((20.0, 30.0, 40.0, 60.0))
        self.z_mm = draw.choice((0.0, 1.0, 2.0, 5.0))
        per_rev = draw.random() < 0.6 and not self.is_plain
        self.mode = draw.choice(("G99", "G95") if per_rev else ("G94",) if self.is_plain else ("G98", "G94"))
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
        self.maybe(0.2, "%", "O0001")
        self.maybe(0.2, "G18 G40 G80 G90", "G40 G80", "G18")
        self.lines += ["G20"] if self.inch else ["G21"] if draw.random() < 0.3 else []
        speed = draw.choice((300, 500, 600, 750, 800, 1000, 1200, 1500, 2000, 3000))
        self.lines += [f"M3 S{speed}" if self.is_plain else f"G97 S{speed} M3"]
        self.maybe(0.0 if self.is_plain else 0.1, "G96 S100", "G96 S150")
        self.lines += [self.mode, *([] if self.is_lathe else ["G0 Y0."])]
        self.lines += [f"G0 X{self.number(self.x_mm)} Z{self.number(self.z_mm)}"]
        for _ in range(draw.choice((1, 1, 1, 2, 3))):
            self.maybe(0.6, *_WISHES)
            self.lines += self.cut(f"F{self.number(self.feed_mm)} {self.word()}".rstrip())
            self.maybe(0.2, "M8", "(NOTE)", "", "/M8", "M1", "G4 P1.")
            self.maybe(0.1, "M3 S500", "M3 S1000")
            self.maybe(0.0 if self.is_plain else 0.1, "G50 S1500", "G97 S800 M3", "G96 S120")
            if draw.random() < 0.15 and not self.is_plain:
                call = draw.choice(("T0202", "T2 M6", "T0202 (TOOL 2)", "G28 U0 W0", "M5"))
                self.lines += [f"G0 X{self.number(80.0)}", call, "G97 S900 M3"]
            if draw.random() < 0.3:
                self.z_mm = max(self.z_mm, 0.0)
                self.lines.append(f"G0 X{self.number(self.x_mm)} Z{self.number(self.z_mm)}")
        self.lines += [f"G0 X{self.number(80.0)}", "M30" if self.is_plain else draw.choice(_ENDS)]
        return self.joined()

    def joined(self) -> bytes:
        """The lines with the subprograms, which stand where the control looks for them."""
        lines = [*self.subs, *self.lines] if self.is_linuxcnc else [*self.lines, *self.subs]
        for _ in range(self.draw.choice((0, 0, 0, 1, 2))):
            lines.insert(self.draw.randint(0, len(lines)), self.draw.choice(_BETWEEN))
        for _ in range(self.draw.choice((0, 0, 0, 1, 2))):
            at = self.draw.randrange(len(lines))
            lines[at] = " ".join(self.draw.sample([lines[at], self.draw.choice(_BESIDE)], 2))
        if self.draw.random() < 0.1:
            lines = [line if line[:1] in "N%Oo/" else f"N{100 + at} {line}" for at, line in enumerate(lines)]
        ending = self.draw.choice(("\n", "\n", "\n", "\r\n"))
        return (ending.join(lines) + self.draw.choice((ending, ending, ""))).encode()

    def word(self) -> str:
        """What asks for vibration in a block, or nothing."""
        return self.draw.choice(_WORDS) if self.draw.random() < 0.7 else ""

    def cut(self, words: str) -> list[str]:
        """The blocks of one cut."""
        step_mm = self.draw.choice(_STEPS_MM)
        write = self.draw.choice(
            _CUTS if not self.is_linuxcnc else (*_CUTS, *[_Writer.from_a_subroutine] * 3)
        )
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

    def thread(self, step_mm: float, words: str) -> list[str]:
        code = self.draw.choice(("G32", "G33", "G92", "G76"))
        end = f"Z{self.number(self.z_mm - step_mm)}"
        if code in ("G32", "G33"):
            return [f"{code} {end} {self.draw.choice(('F', 'K'))}1.5"]
        x = self.number(self.x_mm - 1.2)
        return [f"{code} X{x} {end} F1.5", *([f"X{self.number(self.x_mm - 1.8)}"] if code == "G92" else [])]

    def called(self, step_mm: float, words: str) -> list[str]:
        """A cut in a subprogram."""
        move = f"G1 W-{self.number(step_mm)}" if self.is_lathe and not self.is_linuxcnc else "G1 Z-5."
        cut = [*self.draw.choice(([], ["M3 S800", "G0 X20. Z2."])), f"{move} {words}"]
        number = 100 * (len(self.subs) + 1)
        if self.is_linuxcnc:
            self.subs += [f"o{number} sub", *cut, f"o{number} endsub"]
            return [f"o{number} call"]
        self.subs += [f"O{number}", *cut, "M99"]
        return [f"M98 P{number}"]

    def from_a_subroutine(self, step_mm: float, words: str) -> list[str]:
        """A cycle whose contour stands in a subroutine."""
        low_mm, number = max(self.x_mm - 4.0 * step_mm, 2.0), 100 * (len(self.subs) + 1)
        middle_mm, far_mm = (low_mm + self.x_mm) / 2.0, self.z_mm - 12.0
        turn = self.draw.choice(("G1", "G1", f"G3 R{self.number(3.0)}", f"G2 R{self.number(3.0)}"))
        contour = [
            f"G0 X{self.number(low_mm)} Z{self.number(self.z_mm)}",
            f"G1 Z{self.number(self.z_mm - 5.0)}",
            f"{turn} X{self.number(middle_mm)} Z{self.number(self.z_mm - 8.0)}",
            f"G1 Z{self.number(far_mm)}",
            f"X{self.number(self.x_mm + 2.0)}",
        ]
        if self.draw.random() < 0.3:
            contour[3:3] = [f"G1 X{self.number(low_mm)}", f"Z{self.number(far_mm + 2.0)}"]
        self.subs += [f"o{number} sub", *contour, f"o{number} endsub"]
        code = self.draw.choice(("G71", "G71.1", "G71.2", "G72", "G72.1", "G70"))
        place = f"X{self.number(self.x_mm)} Z{self.number(self.z_mm)}"
        depth = (
            "" if code == "G70" else f"I{self.number(self.draw.choice((0.5, 1.0, 2.0)))} R{self.number(0.5)}"
        )
        stock = self.draw.choice(("", f"D{self.number(0.2)}", f"D{self.number(0.2)} U{self.number(0.1)}"))
        words = words if code != "G70" and self.draw.random() < 0.3 else words.split(maxsplit=1)[0]
        cycle = [f"{code} Q{number} {place} {stock} {depth} {words}".strip()]
        return [*cycle, *([f"G70 Q{number} {place} F{self.number(0.1)}"] if self.draw.random() < 0.3 else [])]


class _Mill(_Writer):
    """One program of a machining centre: several tools, each called, brought near, and taken away again."""

    def program(self) -> bytes:
        """All of it."""
        draw = self.draw
        self.maybe(0.3, "%", "O0001", "(PART 1)")
        self.lines += ["G20" if self.inch else "G21", "G17 G40 G80 G90 G94"]
        for tool in range(1, draw.choice((2, 3, 4))):
            again = draw.choice((tool, tool, 1))
            self.lines += draw.choice(([f"T{again} M6"], [f"M6 T{again}"], [f"T{again}", "M6"]))
            self.maybe(0.4, "(FACE)", "(ADAPTIVE ROUGH)", "(2D CONTOUR FINISH)", "(DRILL)")
            self.lines += [f"S{draw.choice((800, 1500, 5000, 12000))} M3", draw.choice(("G54", "G55", ""))]
            self.lines += [f"G0 X{self.number(draw.choice((0, 10, 25)))} Y{self.number(draw.choice((0, 5)))}"]
            self.lines += [f"G43 H{again} Z{self.number(25.0)}", *([] if draw.random() < 0.5 else ["M8"])]
            for _ in range(draw.choice((1, 2, 3))):
                self.lines += draw.choice(_MILLED)(self)
            self.lines += [f"G0 Z{self.number(25.0)}"]
            self.maybe(0.5, "M9", "M5", "M1", "G91 G28 Z0.\nG90", "G28 G91 Z0.\nG90 G49", "G53 G0 Z0.")
        self.lines.append(draw.choice(_ENDS))
        return self.joined()

    def contour(self) -> list[str]:
        x, feed = self.draw.choice((10.0, 20.0, 50.0)), self.draw.choice((80, 200, 600))
        side = self.draw.choice(("", "", "G41 D1 ", "G42 D1 "))
        start = [f"G1 Z-{self.number(self.draw.choice((0.5, 2.0)))} F{feed}."]
        path = [f"G1 {side}X{self.number(x)}", f"Y{self.number(x)}", f"G2 X0 Y0 R{self.number(x)}"]
        return [*start, *path, *(["G40 G1 Y0"] if side else [])]

    def holes(self) -> list[str]:
        code = self.draw.choice(("G81", "G83", "G73", "G84", "G85"))
        first = f"G99 {code} Z-{self.number(5.0)} R{self.number(2.0)} Q{self.number(1.0)} F100."
        return [f"G98 {first[4:]}" if self.draw.random() < 0.5 else first, f"X{self.number(10.0)}", "G80"]

    def by_distances(self) -> list[str]:
        return ["G91", f"G1 X{self.number(10.0)} F200.", f"Y-{self.number(5.0)}", "G90"]

    def vibrated(self) -> list[str]:
        return ["G95", *self.along(5.0, f"F0.1 {self.word()}".rstrip()), "G94"]

    def from_a_subprogram(self) -> list[str]:
        return self.called(5.0, "F100.")


_MILLED = (
    _Mill.contour,
    _Mill.contour,
    _Mill.holes,
    _Mill.by_distances,
    _Mill.vibrated,
    _Mill.from_a_subprogram,
)
_CUTS = (
    *(_Writer.along, _Writer.along, _Writer.by_distance, _Writer.under_g91, _Writer.taper, _Writer.face),
    *(_Writer.arc, _Writer.before_a_dwell, _Writer.chain, _Writer.chain, _Writer.turning_cycle),
    *(_Writer.roughing, _Writer.pecks, _Writer.thread, _Writer.called),
)


def drawn_program(draw: random.Random, profile: str) -> bytes:
    """A whole program for a machine like that of a profile."""
    is_mill = _is_mill(profile) and draw.random() < 0.7
    return (_Mill if is_mill else _Writer)(draw, profile).program()


def _is_mill(profile: str) -> bool:
    return any(word in profile for word in ("mill", "speedio"))
