"""Random programs for LinuxCNC in which all that a shop writes beside cuts is mixed, and what they do.

The numbers of a program are drawn in the units in force, so the interpreter takes nearly all programs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import NamedTuple

from . import rs274

MM_PER_INCH = rs274.MM_PER_INCH
_M_PER_FOOT = 0.3048


@dataclass
class Writer:
    """Writes one program; it knows the units and the speed mode that its blocks have set."""

    random: Random
    lathe: bool
    lines: list[str] = field(default_factory=list)
    inch: bool = False
    tolerance_inch: bool | None = None  # in inches, in mm, or none said
    offset_inch: bool = False
    surface: bool = False
    incremental: bool = False
    diameter: bool = False
    at: dict[str, float] = field(default_factory=dict)
    subroutines: list[str] = field(default_factory=list)
    labels: int = 200

    def length(self, mm: float) -> str:
        """A length in the units in force, with more digits than the output has."""
        return f"{mm / MM_PER_INCH:.6f}" if self.inch else f"{mm:.4f}".rstrip("0")

    def place(self) -> dict[str, float]:
        axes = "XZ" if self.lathe else "XYZ"
        return {axis: round(self.random.uniform(6.0, 20.0), 2) for axis in axes}

    def words(self, place: dict[str, float]) -> str:
        """Words that go to a place in the modes in force."""
        said = []
        for axis, mm in place.items():
            way = mm - self.at.get(axis, 0.0) if self.incremental else mm
            said.append(axis + self.length(2.0 * way if axis == "X" and self.diameter else way))
        self.at |= place
        return " ".join(said)

    def feed(self) -> str:
        return "F" + self.length(self.random.choice([0.05, 0.08, 0.1, 0.2]))

    def speed(self) -> str:
        return f"S{self.random.choice([100, 120, 150] if self.surface else [1250, 2000, 3000])}"

    def write(self, *lines: str) -> None:
        self.lines += lines

    def rapid(self) -> None:
        self.write("G0 " + self.words(self.place()))

    def cut(self) -> None:
        self.write(f"G1 {self.words(self.place())} {self.feed()}")

    def vibrated(self) -> None:
        place = self.place()
        self.write("G0 " + self.words(place), *([self.feed()] if self.random.random() < 0.5 else []))
        self.write(f"(VIB {self.random.choice(['N1.5', 'N1.5 F62.5', 'E2', 'N0.5'])})")
        # Two axes: a way back through what was just cut needs no spindle speed.
        axes = self.random.sample(list(place), k=self.random.randint(1, 2))
        for at, axis in enumerate(axes):
            place[axis] += self.random.choice([-3.0, -1.5, 1.0, 2.5])
            feed = self.feed() if at == 0 and self.random.random() < 0.7 else ""
            self.write(f"G1 {self.words({axis: place[axis]})} {feed}".rstrip())
        if self.random.random() < 0.8:
            self.write("(VIB OFF)")

    def one_shot(self) -> None:
        code = self.random.choice(["G4 P0.1", "G10 L2 P3 X0 Z0", "G92.1", "G92.2", "G30.1", "G28.1"])
        said = [text for text in (self.speed(), self.feed()) if self.random.random() < 0.6]
        words = [*said, code] if self.random.random() < 0.5 else [code, *said]
        self.write(" ".join(words))

    def units(self) -> None:
        """F and S beside the code are still in the units before."""
        beside = [text for text in (self.speed(), self.feed()) if self.random.random() < 0.3]
        self.inch = not self.inch
        self.write(" ".join([f"G{20 if self.inch else 21}", *beside]))
        if self.random.random() < 0.6:
            self.write(self.feed())

    def own_speed(self) -> None:
        if self.random.random() < 0.5:
            self.write(self.speed())
            return
        self.surface = self.random.random() < 0.6
        code = self.random.choice(["G96 D2500", "G96 D1800", "G96"]) if self.surface else "G97"
        self.write(f"{code} {self.speed()}")

    def thread(self) -> None:
        if self.incremental or self.diameter:
            return
        pitch = self.length(1.0)
        self.write("G0 " + self.words(self.place()))
        if self.random.random() < 0.6:
            numbers = "I-.075 J0.01 K0.045 Q29.5" + self.random.choice(["", " L2 E0.045"])
            self.write(f"G76 P0.05 Z{self.length(5.0)} {numbers}")
        else:
            self.write(f"G33 Z{self.length(4.0)} K{pitch}")
        # The next block may start where the thread has ended.
        if self.random.random() < 0.5:
            self.write("(VIB N1.5)", f"G1 Z{self.length(7.0)} {self.feed()}", "(VIB OFF)")

    def stop(self) -> None:
        self.write(*self.random.choice([["M0"], ["M1"], ["T1 M6", "M3"], ["M5", "M3"], ["M8"], ["M9"]]))

    def arrive(self) -> None:
        """Behind a change of zero a program says where it goes, without distances."""
        was, self.incremental = self.incremental, False
        self.write(*(["G90"] if was else []), "G0 " + self.words(self.place()), *(["G91"] if was else []))
        self.incremental = was

    def zero(self) -> None:
        """Another zero: an offset, one that G10 sets, or G92."""
        axis = self.random.choice("XZ" if self.lathe else "XYZ")
        far = self.length(self.random.choice([-7.0, 4.0, 9.0]))
        offset = f"G{self.random.choice(['54', '55', '56', '59.1', '59.3'])}"
        texts = [offset, f"G10 L2 P{self.random.randint(0, 3)} {axis}{far}", f"G10 L20 P1 {axis}{far}"]
        texts += [f"G92 {axis}{far}", "G92.1", "G92.2", "G92.3"]
        texts += [] if self.lathe else [f"G43.1 Z{far}", "G49", "G43 H2"]
        text = self.random.choice(texts)
        self.write(text)
        if text.startswith(("G43", "G49")):
            self.offset_inch = self.inch
        self.arrive()

    def distance(self) -> None:
        self.incremental = not self.incremental
        self.write("G91" if self.incremental else "G90")

    def diameters(self) -> None:
        if self.lathe:
            self.diameter = not self.diameter
            self.write("G7" if self.diameter else "G8")

    def skipped(self) -> None:
        """A block that a switch may skip; behind it the program says its place again, S and F at times."""
        was, self.incremental = self.incremental, False
        block = self.random.choice(["M8", self.speed(), self.feed(), "G0 " + self.words(self.place())])
        again = [text for text in (self.speed(), self.feed()) if self.random.random() < 0.5]
        self.write(*(["G90"] if was else []), f"/{block}", *again, *(["G91"] if was else []))
        self.incremental = was
        self.arrive()

    def tool(self) -> None:
        """Another tool, or the same one for a finer operation, and a cut or two from above."""
        was, self.incremental = self.incremental, False
        self.write("G90", "G0 Z" + self.length(40.0))
        number = self.random.randint(1, 4)
        if self.random.random() < 0.7:
            self.write(self.random.choice(["M5", "M9", "(NEXT)"]), f"T{number} M6", f"{self.speed()} M3")
        self.write(self.random.choice(["(ROUGH)", "(FINISH)", "(SO)"]))
        place = self.place()
        self.write(f"G0 {self.words({'X': place['X'], 'Y': place['Y']})}")
        self.write(f"G43 H{number} Z{self.length(30.0)}")
        self.offset_inch = self.inch
        self.write(*(["G91"] if was else []))
        self.incremental = was
        self.at["Z"] = 30.0
        for item in self.random.choices([Writer.cut, Writer.vibrated, Writer.arc, Writer.drilled], k=2):
            item(self)
        self.write("G90 G0 Z" + self.length(40.0), *(["G91"] if was else []))
        self.at["Z"] = 40.0

    def called(self) -> None:
        """A subroutine, called once or twice, which may call an earlier one; the modes stay as they were."""
        number = 900 + len(self.subroutines)
        inner = [f"o{self.random.randrange(900, number)} call"] if self.subroutines else []
        body = self._body(inner if self.random.random() < 0.5 else [])
        self.subroutines.append("\n".join([f"o{number} sub", *body, f"o{number} endsub"]))
        self.write(*[f"o{number} call"] * self.random.randint(1, 2))
        self._said_again()

    def looped(self) -> None:
        """A loop of each kind, twice through."""
        self.labels += 1
        label = f"o{self.labels}"
        body = self._body([])
        count = f"#{self.labels}"
        once_more = f"{count}=[{count}+1]"
        forms = [
            [f"{label} repeat [2]", *body, f"{label} endrepeat"],
            [f"{count}=0", f"{label} while [{count} lt 2]", once_more, *body, f"{label} endwhile"],
            [f"{count}=0", f"{label} do", *body, once_more, f"{label} while [{count} lt 2]"],
        ]
        self.write(*self.random.choice(forms))
        self._said_again()

    def _body(self, inner: list[str]) -> list[str]:
        """Some blocks that begin at a place of their own."""
        outer, self.lines = self.lines, []
        self.arrive()
        items = [Writer.vibrated, Writer.cut, Writer.rapid, Writer.one_shot, Writer.arc]
        for item in self.random.choices(items, k=2):
            item(self)
            if inner:
                self.write(*inner)
                self.arrive()
        body, self.lines = self.lines, outer
        # How often a body runs is for the control to know, so a wish for vibration ends in it.
        return [*body, "(VIB OFF)"]

    def _said_again(self) -> None:
        self.write(*[text for text in (self.speed(), self.feed()) if self.random.random() < 0.8])
        self.arrive()

    def kept(self) -> None:
        """Modes that are kept and given back; before them the program says what is from other units."""
        self._say_tolerance_again()
        modes = [
            "G91",
            "G90",
            "G61",
            "G94 F100",
            "G1 F0.3",
            "S900",
            "M8",
            "G20",
            "G97 S800",
            "G96 D2200 S110",
            "G55",
        ]
        self.write(self.feed(), "M70", *self.random.sample(modes, k=2), "M72")
        self._said_again()

    def _say_tolerance_again(self) -> None:
        """``rs274`` has no machine that converts a tolerance, and M72 and cycles say its number again."""
        if self.tolerance_inch is not None and self.tolerance_inch != self.inch:
            self.path_mode(f"G64 P{self.length(0.02)}")

    def path_mode(self, said: str) -> None:
        self.tolerance_inch = self.inch if "P" in said else None
        self.write(said)

    def inverse(self) -> None:
        """Inverse time: every cut says its own."""
        cuts = [f"G1 {self.words(self.place())} F{self.random.choice([2, 5, 12.5])}" for _ in range(2)]
        self.write("G93", *cuts, self.random.choice(["G94", "G95"]) + " " + self.feed(), "G95 " + self.feed())

    def computed(self) -> None:
        """Words that the control works out, also from the speed and the feed in force."""
        self.write(self.random.choice(["G4 P[#<_rpm>/10000]", "#8=#<_rpm>\nG4 P[#8/10000]", "G4 P#<_feed>"]))
        self.write(f"#7={self.length(3.0)}", f"F[{self.length(0.05)}*2]", "G4 P[0.1+0.1]")
        if not self.incremental:
            axis = self.random.choice("XZ")
            self.write(f"G1 {axis}[#7+#7]")
            self.at[axis] = 6.0 / (2.0 if axis == "X" and self.diameter else 1.0)

    def home(self) -> None:
        """Places of the machine; behind them the program says where it goes.

        With a length offset of other units ``rs274``, which has no machine to convert it, goes elsewhere.
        """
        if self.inch or self.offset_inch:
            return
        places = ["G28 Z5", "G30 Z5", "G28"] + ([] if self.incremental else ["G53 G0 Z0", "G53 G0 X0"])
        self.write(self.random.choice(places))
        self.arrive()

    def drilled(self) -> None:
        """A canned cycle of a mill, at a place or two."""
        if self.lathe or self.incremental:
            return
        self._say_tolerance_again()
        code = self.random.choice(
            ["G81", "G82 P0.1", "G83 Q" + self.length(1.0), "G85", "G73 Q" + self.length(1.0)]
        )
        place = self.place()
        at = self.words({"X": place["X"], "Y": place["Y"]})
        again = self.words({"X": place["X"] + 2.0, "Y": place["Y"]})
        deep = f"Z{self.length(-2.0)} R{self.length(21.0)}"
        self.write(
            "G17 G0 Z" + self.length(22.0),
            f"{self.random.choice(['G98', 'G99'])} {code} {at} {deep} {self.feed()}",
        )
        self.write(*([again] if self.random.random() < 0.5 else []), "G80")
        self.arrive()

    def arc(self) -> None:
        """A part of a circle or all of it, by its centre or by its radius, perhaps vibrated."""
        plane = 18 if self.lathe else self.random.choice([17, 17, 18, 19])
        first, second, across = {17: "XYZ", 18: "ZXY", 19: "YZX"}[plane]
        letters = dict(zip("XYZ", "IJK", strict=True))
        place = self.place()
        self.write(*([] if self.lathe else [f"G{plane}"]), "G0 " + self.words(place))
        radius = self.random.choice([1.0, 2.0, 3.5])
        is_vibrated = self.random.random() < 0.4
        wish = [f"(VIB {self.random.choice(['N1.5', 'E2', 'N0.5'])})"] if is_vibrated else []
        # The centre stands beside the start along the first axis; the quarter ends above or below it.
        centre = {first: place[first] + radius, second: place[second]}
        quarter = {first: place[first] + radius, second: place[second] + radius}
        helix = {across: place[across] - 1.0} if not self.lathe and self.random.random() < 0.3 else {}
        code = self.random.choice(["G2", "G3"])
        turns = self.random.choice(["", "", " P1", " P2"])
        form = self.random.choice(["centre", "radius", "circle", "absolute"])
        if form == "radius":
            size = self.random.choice([radius, -radius])
            words = f"{self.words(quarter | helix)} R{self.length(size)}"
        elif form == "circle":
            words = f"{self.words(helix)} {letters[first]}{self.length(radius)}{turns}"
        elif form == "centre":
            words = f"{self.words(quarter | helix)} {letters[first]}{self.length(radius)}{turns}"
        else:
            middle = " ".join(letters[axis] + self.length(centre[axis]) for axis in (first, second))
            words = f"{self.words(quarter | helix)} {middle}"
        before, behind = (["G90.1"], ["G91.1"]) if form == "absolute" else ([], [])
        off = ["(VIB OFF)"] if is_vibrated else []
        self.write(*before, *wish, f"{code} {words} {self.feed()}", *off, *behind)
        self.write(*([] if self.lathe or plane == 17 else ["G17"]))

    def other(self) -> None:
        if self.incremental:
            return
        feed = self.random.choice(["", " F0.1"])
        # Behind a branch no speed is known until S is said again.
        branch = ["o100 if [1 gt 0]", f"G0 Z{self.length(9.0)}", "o100 endif", self.speed()]
        feed_modes = [f"G94 F{self.length(200.0)}", f"G95{feed}"]
        plain = self.random.choice(["G64 P0.01", "G61", "G64", "G55", "G54", "(so)", "G40 G80", "#1=5"])
        said = self.random.choice([[plain], branch, feed_modes, ["/G0 Z" + self.length(12.0)]])
        if said == [plain] and plain.startswith("G6"):
            self.path_mode(plain)
        else:
            self.write(*said)


_ITEMS: tuple[Callable[[Writer], None], ...] = (
    *[Writer.vibrated] * 4,
    *[Writer.units] * 2,
    Writer.one_shot,
    Writer.own_speed,
    Writer.thread,
    Writer.stop,
    Writer.other,
    Writer.cut,
    Writer.rapid,
    Writer.zero,
    Writer.distance,
    Writer.diameters,
    Writer.skipped,
    Writer.called,
    Writer.looped,
    Writer.kept,
    Writer.inverse,
    Writer.computed,
    Writer.home,
    Writer.drilled,
    *[Writer.arc] * 2,
)


class Mixed(NamedTuple):
    """A program, the machine it is for, and whether its tools are checked."""

    data: bytes
    lathe: bool
    checked: bool


def program(seed: int) -> Mixed:
    """The program of a seed."""
    random = Random(seed)
    write = Writer(random, lathe=random.random() < 0.5)
    is_checked = not write.lathe and random.random() < 0.6
    write.write("G21 G18 G8" if write.lathe else "G21 G17", "G40 G54 G80 G90 G95 G97 G64", "M3 S2000")
    write.rapid()
    write.write("F0.1")
    items = [*_ITEMS, *[Writer.tool] * 6] if is_checked else _ITEMS
    if is_checked:
        write.tool()
    for _ in range(random.randint(3, 9)):
        random.choice(items)(write)
    write.rapid()
    labels = iter(range(100, 200))
    text = "\n".join([*write.subroutines, *write.lines, "M2", ""])
    # Every branch has a label of its own.
    text = re.sub(r"o100 if(.*\n.*\n)o100", lambda m: f"o{(n := next(labels))} if{m[1]}o{n}", text)
    return Mixed(_typed(random, text).encode(), write.lathe, is_checked)


def _typed(random: Random, text: str) -> str:
    """The same in another hand: small letters, blanks between words and numbers, block numbers, line ends."""
    if random.random() < 0.6:
        return text
    lines = [_line_typed(random, line) for line in text.split("\n")]
    return random.choice(["\n", "\r\n"]).join(lines)


def _line_typed(random: Random, line: str) -> str:
    if not line or line[0] in "(/oO#":
        return line
    if random.random() < 0.4:
        line = line.lower().replace("f", "F")  # f asks for a frequency
    line = line.replace(" ", random.choice([" ", "", "  ", "\t"]))
    line = re.sub(r"([A-Za-z])([-\d.])", r"\1 \2", line) if random.random() < 0.2 else line
    return f"N{random.randint(1, 9999)} {line}" if random.random() < 0.3 else line


# --- what a program does ----------------------------------------------------------------------------------

_STATES = {
    "SET_FEED_MODE": "feed mode",
    "SELECT_PLANE": "plane",
    "SET_MOTION_CONTROL_MODE": "path mode",
    "SET_NAIVECAM_TOLERANCE": "joined within",
    "SELECT_TOOL": "next tool",
    "CHANGE_TOOL": "tool",
    "SET_G5X_OFFSET": "offset",
    "SET_G92_OFFSET": "shift",
    "USE_TOOL_LENGTH_OFFSET": "length",
}
# How many words stand before the lengths.
_TOLERANCES = {"SET_MOTION_CONTROL_MODE": 1, "SET_NAIVECAM_TOLERANCE": 0}
_PLACES = {"STRAIGHT_FEED", "STRAIGHT_TRAVERSE", "ARC_FEED"}
_ACTS = {"PROGRAM_STOP", "OPTIONAL_PROGRAM_STOP", "CHANGE_TOOL"}
_STARTS = {"START_SPINDLE_CLOCKWISE", "START_SPINDLE_COUNTERCLOCKWISE"}
_COOLANT = {"MIST_ON", "MIST_OFF", "FLOOD_ON", "FLOOD_OFF"}
Record = tuple[str, dict[str, object]]


class _Machine:
    """The state that the canonical calls of a program build up, in mm."""

    def __init__(self) -> None:
        self.state: dict[str, object] = {"feed": 0.0, "speed": 0.0, "limit": 0.0, "pitch": 0.0}
        self.state["path mode"] = ("CANON_CONTINUOUS", 0.0)  # before a program says anything
        self.state["joined within"] = (0.0,)
        self.scale = 1.0
        self.plane = "CANON_PLANE_XY"
        self.typed_speed = 0.0

    def take(self, name: str, said: Sequence[str]) -> None:
        """Take a call."""
        if name in _STATES:
            self.state[_STATES[name]] = self._in_mm(name, said)
            self.plane = said[0] if name == "SELECT_PLANE" else self.plane
        elif name == "USE_LENGTH_UNITS":
            self.scale = MM_PER_INCH if "INCH" in said[0] else 1.0
            self.state["units"] = said[0]
        elif name in ("SET_FEED_RATE", "START_SPEED_FEED_SYNC"):
            what = "feed" if name == "SET_FEED_RATE" else "pitch"
            self.state[what] = float(said[0]) * self.scale
        elif name == "STOP_SPEED_FEED_SYNCH":
            self.state["pitch"] = 0.0
        elif name in _COOLANT:
            self.state[name.split("_", maxsplit=1)[0]] = name
        elif name in _PLACES:
            self._place(name, said)
        self._spindle(name, said)

    def _in_mm(self, name: str, said: Sequence[str]) -> tuple[object, ...]:
        """Tolerances of a path mode are of the units in which they are said; others are compared as said."""
        lengths = _TOLERANCES.get(name, len(said))
        return (*said[:lengths], *(round(float(text) * self.scale, 4) for text in said[lengths:]))

    def _place(self, name: str, said: Sequence[str]) -> None:
        """Where a move ends."""
        texts = rs274.arc_end(said, self.plane) if name == "ARC_FEED" else said[:3]
        self.state["place"] = tuple(float(text) * self.scale for text in texts)

    def _spindle(self, name: str, said: Sequence[str]) -> None:
        """A surface speed is worked out where S is said and where the spindle starts, in the units then."""
        if name == "SET_SPINDLE_MODE":
            self.state["limit"] = float(said[1])
        elif name == "SET_SPINDLE_SPEED":
            self.typed_speed = float(said[1])
        elif name in _STARTS or name == "STOP_SPINDLE_TURNING":
            self.state["spindle"] = name
        else:
            return
        if name != "SET_SPINDLE_MODE" and not name.startswith("STOP"):
            feet = bool(self.state["limit"]) and self.scale != 1.0
            self.state["speed"] = self.typed_speed * (_M_PER_FOOT if feet else 1.0)


def records(canon: Sequence[str]) -> Iterator[Record]:
    """What is done outside the brackets, and the state at the end of each, with all that counts there.

    The speed counts where something depends on it, feed only for cuts and behind brackets.
    """
    machine = _Machine()
    inside = False
    for name, said in rs274.calls(canon):
        machine.take(name, said)
        if name == "COMMENT" and said[0].startswith("CHIPBREAK"):
            inside = "BEGIN" in said[0] or (inside and "END" not in said[0])
            if "END" in said[0]:
                yield "END", _but(machine.state, "speed", "limit")
        elif inside:
            continue
        elif name in ("STRAIGHT_TRAVERSE", "STOP_SPINDLE_TURNING", "PROGRAM_END"):
            yield name, _but(machine.state, "speed", "limit", "feed")
        elif name in _PLACES | _ACTS | _STARTS:
            yield name, dict(machine.state)
        elif name == "DWELL":
            yield f"DWELL {said[0]}", _but(machine.state, "speed", "limit", "feed")


def _but(state: dict[str, object], *names: str) -> dict[str, object]:
    return {key: value for key, value in state.items() if key not in names}


def is_same(one: Record, other: Record) -> bool:
    """True for one thing done in one state; canonical numbers have four decimals, in inches too."""
    keys = one[1].keys() | other[1].keys()
    return one[0] == other[0] and all(_is_near(one[1].get(key), other[1].get(key)) for key in keys)


def differing(one: Record, other: Record) -> str:
    """What differs, for a message."""
    both = [(key, one[1].get(key), other[1].get(key)) for key in sorted(one[1].keys() | other[1].keys())]
    return f"{one[0]}, {other[0]}: {[each for each in both if not _is_near(*each[1:])]}"


def _is_near(one: object, other: object) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return all(map(_is_near, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= 1.01e-4 * MM_PER_INCH + 1e-6 * abs(one)
    return one == other
