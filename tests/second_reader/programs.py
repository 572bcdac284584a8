"""Random programs for Fanuc controls in which all that a shop writes beside vibrated cuts is mixed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from .reader import MM_PER_INCH, Control


@dataclass
class Writer:
    """Writes one program; it knows the modes that its blocks have set."""

    random: Random
    control: Control
    lines: list[str] = field(default_factory=list)
    subprograms: list[list[str]] = field(default_factory=list)
    inch: bool = False
    incremental: bool = False
    surface: bool = False
    per_rev: bool = True
    place: dict[str, float] = field(default_factory=dict)

    @property
    def axes(self) -> str:
        return "XZ" if self.control.is_lathe else "XYZ"

    def length(self, mm: float) -> str:
        text = f"{mm / MM_PER_INCH:.4f}" if self.inch else f"{mm:.3f}".rstrip("0")
        return "0." if float(text) == 0.0 else text

    def write(self, *lines: str) -> None:
        self.lines += lines

    def drawn(self) -> dict[str, float]:
        return {axis: round(self.random.uniform(10.0, 40.0), 2) for axis in self.axes}

    def to(self, place: dict[str, float]) -> str:
        """Words that go to a place, each as a place or as a distance."""
        words = []
        for axis, mm in place.items():
            from_here = mm - self.place.get(axis, 0.0)
            if self.incremental:
                words.append(axis + self.length(from_here))
            elif self.control.is_lathe and axis in self.place and self.random.random() < 0.2:
                words.append("UVW"["XYZ".index(axis)] + self.length(from_here))
            else:
                words.append(axis + self.length(mm))
        self.place |= place
        return " ".join(words)

    def feed(self) -> str:
        per_rev = self.random.choice([0.05, 0.08, 0.1, 0.2])
        return "F" + self.length(per_rev if self.per_rev else per_rev * 2000.0)

    def speed(self) -> str:
        return f"S{self.random.choice([100, 120, 150] if self.surface else [1250, 2000, 3000])}"

    def maybe(self, text: Callable[[], str], chance: float = 0.4) -> list[str]:
        return [text()] if self.random.random() < chance else []

    # --- items --------------------------------------------------------------------------------------------

    def rapid(self) -> None:
        self.write(" ".join(["G0", self.to(self.drawn()), *self.maybe(self.feed, 0.2)]))

    def cut(self) -> None:
        self.write(f"G1 {self.to(self.drawn())} {self.feed()}")

    def arc(self) -> None:
        """A quarter or so in the plane in force, by its radius or by its centre."""
        first, second = ("Z", "X") if self.control.is_lathe else ("X", "Y")
        step = round(self.random.uniform(2.0, 6.0), 2)
        goal = {first: self.place.get(first, 20.0) + step, second: self.place.get(second, 20.0)}
        goal[second] += 2.0 * step if self.control.is_lathe else step
        is_centre = self.random.random() < 0.5 and not self.inch
        letter = "K" if self.control.is_lathe else "I"
        size = (
            f"{letter}{self.length(step)}"
            if is_centre
            else f"R{self.length(step * 1.0 if not self.inch else step * 1.2)}"
        )
        code = "G3" if is_centre else self.random.choice(["G2", "G3"])
        start = {axis: self.place.get(axis, 20.0) for axis in (first, second)}
        self.write("G0 " + self.to(start))
        if is_centre and self.control.is_lathe:
            code = "G3"  # from the end of the face outward, round a centre in front
        self.write(f"{code} {self.to(goal)} {size} {self.feed()}")

    def vibrated(self) -> None:
        self.write(" ".join(["G0", self.to(self.drawn()), *self.maybe(self.feed)]))
        self.write(f"(VIB {self.random.choice(['N1.5', 'N1.5 F62.5', 'E2', 'N0.5'])})")
        for at, axis in enumerate(self.random.sample(self.axes, k=self.random.randint(1, 2))):
            goal = {axis: self.place[axis] + self.random.choice([-3.0, -1.5, 1.0, 2.5])}
            feed = self.feed() if at == 0 and self.random.random() < 0.7 else ""
            self.write(f"G1 {self.to(goal)} {feed}".rstrip())
        if self.random.random() < 0.8:
            self.write("(VIB OFF)")

    def one_shot(self) -> None:
        """Codes of one block beside S and F, whose axis words are no places."""
        dwell = self.random.choice(
            ["G4 X1.", "G4 P500", "G4 U0.5"] if self.control.is_lathe else ["G4 X1.", "G4 P500"]
        )
        g10 = self.random.choice(["G10 L2 P1", "G10 L2 P2", "G10 L2 P0"])
        axis, far = self.random.choice(self.axes), self.length(self.random.choice([-5.0, 3.0, 12.0]))
        code = self.random.choice([dwell, f"{g10} {axis}{far}", f"G52 {axis}{far}", f"G52 {self.zeros()}"])
        beside = [*self.maybe(self.speed), *self.maybe(self.feed)] if code.startswith("G4") else []
        self.write(" ".join([*beside, code] if self.random.random() < 0.5 else [code, *beside]))
        if not code.startswith("G4"):
            self.arrive()

    def zeros(self) -> str:
        return " ".join(f"{axis}0." for axis in self.axes)

    def arrive(self) -> None:
        """Behind a change of zero a program says where it goes, without distances."""
        was, self.incremental = self.incremental, False
        if was:
            self.write("G90")
        self.place = {}
        self.write("G0 " + self.to(self.drawn()))
        if was:
            self.write("G91")
            self.incremental = True

    def zero(self) -> None:
        shift = self.control.shift
        axis, mm = self.random.choice(self.axes), self.length(self.random.uniform(10.0, 20.0))
        texts = [f"G{self.random.randint(54, 59)}", f"G{shift} {axis}{mm}"]
        if self.control.system == "A":
            texts.append(f"G50 {'U' if axis == 'X' else 'W'}{mm}")
        if not self.control.is_lathe:
            texts += ["G54.1 P2", f"G43 H{self.random.randint(1, 3)}", "G49"]
        self.write(self.random.choice(texts))
        self.arrive()

    def home(self) -> None:
        incremental = {"A": "G28 U0 W0", "B": "G91 G28 X0 Z0", "C": "G28 U0 W0"}.get(
            self.control.system, "G91 G28 Z0"
        )
        text = self.random.choice(
            [incremental, "G53 X0. Z0.", "G30 P2 U0 W0" if self.control.is_lathe else "G91 G30 P2 Z0."]
        )
        if "G53" in text and self.incremental:
            return
        self.write(text)
        if text.startswith("G91"):
            self.incremental = True
            self.distance()
        self.arrive()

    def distance(self) -> None:
        if self.control.has_distance_codes:
            self.incremental = not self.incremental
            self.write("G91" if self.incremental else "G90")

    def units(self) -> None:
        self.inch = not self.inch
        code = next(code for code, scale in self.control.units.items() if (scale != 1.0) == self.inch)
        self.write(f"G{code}")
        self.write(self.feed())
        if self.surface:
            self.write(self.speed())

    def own_speed(self) -> None:
        choice = self.random.random()
        if choice < 0.4 or not self.control.is_lathe:
            self.write(self.speed())
        elif choice < 0.6:
            self.write(f"G{self.control.shift} S{self.random.choice([2500, 1800])}")
        else:
            self.surface = self.random.random() < 0.6
            self.write(f"{'G96' if self.surface else 'G97'} {self.speed()}")

    def feed_mode(self) -> None:
        modes = {mode: code for code, mode in self.control.feed_modes.items()}
        self.per_rev = not self.per_rev
        self.write(f"G{modes['rev' if self.per_rev else 'min']} {self.feed()}")

    def order(self) -> None:
        tool = self.random.randint(1, 5)
        change = [f"T{tool:02}{tool:02}"] if self.control.is_lathe else [f"T{tool} M6", f"{self.speed()} M3"]
        texts = [
            ["M0"],
            ["M1"],
            ["M5", "M3"],
            ["M8"],
            ["M9"],
            change,
            ["M5", f"{self.speed()} M3"],
            ["M4"],
            ["M3"],
        ]
        chosen = self.random.choice(texts)
        self.write(*chosen)
        if chosen is change:
            self.arrive()

    def skipped(self) -> None:
        """A block that is skipped by a switch; behind it the program says its place again, and S at times."""
        away = f"G0 {self.random.choice(self.axes)}{self.length(30.0)}"
        block = self.random.choice(["M8", "M1", self.speed(), self.feed(), away, "M5", "M4"])
        was, self.incremental = self.incremental, False
        if was:
            self.write("G90")
        again = [self.speed()] if block.startswith("S") and self.random.random() < 0.5 else []
        self.write(f"/{block}", *again)
        self.write("G0 " + " ".join(axis + self.length(mm) for axis, mm in self.drawn().items()))
        self.place = {}
        self.write("G0 " + self.to(self.drawn()))
        if was:
            self.write("G91")
            self.incremental = True

    def called(self) -> None:
        """A subprogram, called once or more; it leaves the modes as they were."""
        if len(self.subprograms) >= 2:
            return
        outer, self.lines = self.lines, []
        number = 100 + len(self.subprograms)
        place = dict(self.place)
        self.place = {}
        was, self.incremental = self.incremental, False
        self.write(f"O{number}", *(["G90"] if was else []))
        for item in self.random.choices([Writer.vibrated, Writer.cut, Writer.rapid, Writer.one_shot], k=2):
            item(self)
        self.write(*(["G91"] if was else []), "M99")
        self.incremental = was
        self.subprograms.append(self.lines)
        self.lines, self.place = outer, place
        self.write(self.random.choice([f"M98 P{number}", f"M98 P{number} L2"]))
        self.arrive()

    def cycle(self) -> None:
        self.rapid()
        feed = self.feed()
        if self.control.is_lathe:
            code, name = self.random.choice(list(self.control.turning_cycles.items()))
            goal = {axis: self.place[axis] - self.random.choice([1.0, 2.0, 4.0]) for axis in "XZ"}
            words = " ".join(
                axis + self.length(mm if not self.incremental else mm - self.place[axis])
                for axis, mm in goal.items()
            )
            if name == "thread" and not self.per_rev:
                return
            self.write(
                f"G{code} {words} {feed}",
                *self.maybe(lambda: f"X{self.length(-1.0 if self.incremental else goal['X'] - 1.0)}"),
            )
        else:
            z, r = (-5.0, -1.0) if self.incremental else (5.0, 8.0)
            code = self.random.choice(["G81", "G83", "G73", "G82"])
            extra = {"G81": "", "G82": " P500"}.get(code, f" Q{self.length(1.0)}")
            back = self.random.choice(["G98 ", "G99 ", ""])
            self.write(f"{back}{code} Z{self.length(z)} R{self.length(r)}{extra} {feed}")
            self.write(*self.maybe(lambda: f"X{self.length(3.0)}"), "G80")
        self.arrive()


_ITEMS: tuple[Callable[[Writer], None], ...] = (
    *[Writer.vibrated] * 5,
    Writer.rapid,
    Writer.cut,
    Writer.arc,
    Writer.one_shot,
    Writer.zero,
    Writer.home,
    Writer.distance,
    Writer.units,
    Writer.own_speed,
    Writer.feed_mode,
    Writer.order,
    Writer.skipped,
    Writer.called,
    Writer.cycle,
)


def program(seed: int) -> tuple[str, Control]:
    """The program of a seed, and the control it is for."""
    random = Random(seed)
    control = Control(random.choice(["A", "A", "B", "C", "", ""]), block_delete=random.random() < 0.5)
    write = Writer(random, control)
    mm = next(code for code, scale in control.units.items() if scale == 1.0)
    rev = next(code for code, mode in control.feed_modes.items() if mode == "rev")
    distance = ["G90"] if control.has_distance_codes else []
    plane = ["G18"] if control.is_lathe else ["G17", "G49", "G80"]
    write.write("O1", " ".join([f"G{mm}", *plane, "G40", f"G{rev}", *distance]), "G54")
    write.write("T0101" if control.is_lathe else "T1 M6", "G97 S2000 M3" if control.is_lathe else "S2000 M3")
    write.rapid()
    write.write(write.feed())
    for _ in range(random.randint(3, 9)):
        random.choice(_ITEMS)(write)
    write.rapid()
    write.write("M30")
    for subprogram in write.subprograms:
        write.write(*subprogram)
    return "\n".join([*write.lines, ""]), control
