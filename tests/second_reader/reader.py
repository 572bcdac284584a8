"""What a Fanuc control does with a program: block by block, with all modal groups that a shop uses.

Lengths are mm, X of a lathe a diameter.  The control's own tables (work offsets, tool offsets, reference
points) hold made-up numbers that are all different, so that a wrong one shows in where the machine stands.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

MM_PER_INCH = 25.4
_COMMENT = re.compile(r"\(([^)]*)\)")
_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
_INCREMENTAL = {"U": "X", "V": "Y", "W": "Z"}
_PLANES = {17: ("X", "Y", "I", "J"), 18: ("Z", "X", "K", "I"), 19: ("Y", "Z", "J", "K")}
_REFERENCE = {1: (0.0, 0.0, 0.0), 2: (-100.0, -110.0, -120.0), 3: (-200.0, -210.0, -220.0)}
_SECOND_DEEPEST = 8


@dataclass(frozen=True)
class Control:
    """Which codes say what.  A lathe has U and W; ``system`` is "A", "B" or "C", and "" for a mill."""

    system: str = ""
    block_delete: bool = False

    @property
    def is_lathe(self) -> bool:
        return bool(self.system)

    @property
    def feed_modes(self) -> dict[int, str]:
        return {98: "min", 99: "rev"} if self.system == "A" else {94: "min", 95: "rev"}

    @property
    def units(self) -> dict[int, float]:
        inch, mm = (70, 71) if self.system == "C" else (20, 21)
        return {inch: MM_PER_INCH, mm: 1.0}

    @property
    def shift(self) -> int:
        """The code of the coordinate system, and on a lathe of the highest speed."""
        return 50 if self.system == "A" else 92

    @property
    def turning_cycles(self) -> dict[int, str]:
        """Single passes: along Z, a thread, across."""
        codes = {"A": (90, 92, 94), "B": (77, 78, 79), "C": (20, 21, 24)}.get(self.system, ())
        return dict(zip(codes, ("turn", "thread", "face"), strict=False))

    @property
    def has_distance_codes(self) -> bool:
        return self.system != "A"


@dataclass(frozen=True)
class Record:
    """One thing done: its name and numbers, and the state that it met."""

    name: str
    numbers: tuple[float, ...] = ()
    state: dict[str, object] = field(default_factory=dict)


Words = dict[str, float]


class Machine:
    """The state of a control; ``done`` is what it has done."""

    def __init__(self, control: Control) -> None:
        self.control = control
        lathe = control.is_lathe
        self.scale = 1.0
        self.motion: int | str = 0
        self.plane = 18 if lathe else 17
        self.incremental = False
        self.feed_mode = "rev" if lathe else "min"
        self.feed: tuple[str, float] = ("", 0.0)
        self.rpm: object = 0.0
        self.surface_speed = 0.0
        self.surface = False
        self.most = 0.0
        self.spindle = 5
        self.coolant: set[int] = set()
        self.tool = 0.0
        self.offset = 0.0
        self.length = 0.0
        self.radius: tuple[int, float] = (40, 0.0)
        self.work: float = 54.0
        self.returns_to = 98
        self.cycle: Words = {}
        self.level = 0.0
        self.works = {float(54 + i): [300.0 + 7 * i, 400.0 + 11 * i, 500.0 + 13 * i] for i in range(6)}
        self.external = [0.0, 0.0, 0.0]
        self.local = [0.0, 0.0, 0.0]
        self.shifted = [0.0, 0.0, 0.0]
        self.at = [17.0, 19.0, 23.0]  # in machine coordinates
        self.done: list[Record] = []

    # --- where things are ---------------------------------------------------------------------------------

    def zero(self, axis: int) -> float:
        """The machine coordinate of the program's zero."""
        work = self.works.setdefault(self.work, [1000.0 + 17 * self.work + 3 * i for i in range(3)])
        tool = (0.37 + axis) * self.offset if self.control.is_lathe else 0.0
        length = 31.0 * self.length if axis == 2 and not self.control.is_lathe else 0.0
        parts = (work[axis], self.external[axis], self.local[axis], self.shifted[axis], tool, length)
        return sum(parts)

    def target(self, words: Words) -> list[float]:
        """Where a block goes, in machine coordinates."""
        goal = list(self.at)
        for axis, letter in enumerate("XYZ"):
            if letter in words:
                value = words[letter] * self.scale
                goal[axis] = self.at[axis] + value if self.incremental else self.zero(axis) + value
        if self.control.is_lathe:
            for letter, name in _INCREMENTAL.items():
                if letter in words:
                    axis = "XYZ".index(name)
                    goal[axis] = self.at[axis] + words[letter] * self.scale
        return goal

    def state(self, *without: str) -> dict[str, object]:
        """All that a block may depend on."""
        found = {
            "scale": self.scale,
            "plane": self.plane,
            "incremental": self.incremental,
            "feed": (self.feed_mode, *self.feed),
            "speed": (self.surface, self.surface_speed if self.surface else self.rpm),
            "most": self.most,
            "spindle": self.spindle,
            "coolant": tuple(sorted(self.coolant)),
            "tool": (self.tool, self.offset, self.length, self.radius),
            "zero": tuple(self.zero(axis) for axis in range(3)),
            "at": tuple(self.at),
            "returns_to": self.returns_to,
        }
        return {key: value for key, value in found.items() if key not in without}

    def do(self, name: str, *numbers: float, without: tuple[str, ...] = ()) -> None:
        self.done.append(Record(name, numbers, self.state(*without)))

    # --- one block ----------------------------------------------------------------------------------------

    def block(self, codes: list[float], words: Words, orders: list[int]) -> None:
        """Take a block: modes, what holds for this block alone, numbers, then the motion between M codes."""
        for code in codes:
            self._mode(code)
        once = next((code for code in codes if code in _ONCE or code == self.control.shift), None)
        self._numbers(words, once)
        for order in orders:
            self._before(order)
        if once is not None:
            self._once(once, words)
        elif 65.0 not in codes and 98 not in orders:
            self._move(codes, words)
        for order in orders:
            self._behind(order)

    def _mode(self, code: float) -> None:
        control = self.control
        if code in control.units:
            self.scale = control.units[int(code)]
        elif code in control.turning_cycles:
            self.motion, self.cycle = control.turning_cycles[int(code)], {}
        elif code in control.feed_modes:
            self.feed_mode = control.feed_modes[int(code)]
        elif code in (0, 1, 2, 3):
            self.motion, self.cycle = int(code), {}
        elif code in _PLANES:
            self.plane = int(code)
        elif code in (90, 91) and control.has_distance_codes:
            self.incremental = code == 91
        elif code in (96, 97):
            self._speed_mode(is_surface=code == 96)
        else:
            self._other_mode(code)

    def _speed_mode(self, *, is_surface: bool) -> None:
        """G96 without S takes the last surface speed again; G97 without S what the spindle turns there."""
        if self.surface and not is_surface:
            self.rpm = ("of", self.surface_speed, self.at[0] - self.zero(0))
        self.surface = is_surface

    def _other_mode(self, code: float) -> None:
        if 54 <= code <= 59:
            self.work = code
        elif code in (40, 41, 42):
            self.radius = (int(code), self.radius[1])
        elif code == 49:
            self.length = 0.0
        elif code == 80:
            self.motion, self.cycle = 0, {}
        elif code in (98, 99) and not self.control.is_lathe:
            self.returns_to = int(code)
        elif code in (73, 74, 76, *range(81, 90)) and not self.control.is_lathe:
            self.motion, self.cycle, self.level = f"cycle {code:g}", {}, self.at[2]

    def _numbers(self, words: Words, once: float | None) -> None:
        """F, S, T, H and D are taken where they stand; S beside the code of a zero is a limit."""
        if "F" in words:
            self.feed = (self.feed_mode, words["F"] * self.scale)
        if "S" in words:
            self._take_speed(words["S"], is_limit=once == self.control.shift)
        if "T" in words:
            self._take_tool(words["T"])
        if "D" in words:
            self.radius = (self.radius[0], words["D"])
        if once == 43:
            self.length = words.get("H", self.length)
        if once == 54.1:
            self.work = 1000.0 + words.get("P", 1.0)

    def _take_speed(self, speed: float, *, is_limit: bool) -> None:
        if is_limit:
            self.most = speed
        elif self.surface:
            self.surface_speed = speed * self._per_minute()
        else:
            self.rpm = speed

    def _per_minute(self) -> float:
        """Surface speeds are m/min or feet/min."""
        return 0.3048 if self.scale != 1.0 else 1.0

    def _take_tool(self, number: float) -> None:
        if self.control.is_lathe:
            self.tool, self.offset = divmod(number, 100.0)
        else:
            self.tool = number

    def _before(self, order: int) -> None:
        if order in (3, 4):
            self.spindle = order
        elif order in (7, 8):
            self.coolant.add(order)
        elif order == 6:
            self.spindle = 5
        self.do(f"M{order}", without=_NOT_FOR_ORDERS) if order in (3, 4, 6) else None

    def _behind(self, order: int) -> None:
        if order == 5:
            self.spindle = 5
        elif order == 9:
            self.coolant.clear()
        elif order in (0, 1, 2, 30):
            self.do(f"M{order}", without=_NOT_FOR_ORDERS)

    # --- codes of one block -------------------------------------------------------------------------------

    def _once(self, code: float, words: Words) -> None:
        if code == self.control.shift:
            self._shift(words)
            return
        {
            4: self._dwell,
            10: self._data,
            28: self._home,
            30: self._home,
            43: self._with_length,
            52: self._local,
            53: self._in_machine,
            54.1: self._with_length,
        }[code](words)

    def _dwell(self, words: Words) -> None:
        length_s = words.get("X", words.get("U", words.get("P", 0.0) / 1000.0))
        self.do("dwell", length_s, without=("speed", "most", "feed"))

    def _data(self, words: Words) -> None:
        """G10 L2: a work offset; P0 is the one that holds for all."""
        if words.get("L") != 2:
            return
        number = words.get("P", 0.0)
        table = self.external if number == 0 else self.works[53.0 + number]
        for axis, letter in enumerate("XYZ"):
            if letter in words:
                value = words[letter] * self.scale
                table[axis] = table[axis] + value if self.incremental else value
        for letter, name in _INCREMENTAL.items():
            if self.control.is_lathe and letter in words:
                table["XYZ".index(name)] += words[letter] * self.scale

    def _home(self, words: Words) -> None:
        """Over the place that is said to the reference point, in the axes that are said."""
        between = self.target(words)
        self.at = between
        self.do("rapid", without=_NOT_FOR_RAPIDS)
        named = [_INCREMENTAL.get(letter, letter) for letter in words]
        point = _REFERENCE[int(words.get("P", 1.0))]
        self.at = [point[i] if "XYZ"[i] in named else self.at[i] for i in range(3)]
        self.do("rapid", without=_NOT_FOR_RAPIDS)

    def _with_length(self, words: Words) -> None:
        """The offset holds from this block on, also for its own motion."""
        self._move([], {letter: value for letter, value in words.items() if letter != "P"})

    def _local(self, words: Words) -> None:
        for axis, letter in enumerate("XYZ"):
            if letter in words:
                self.local[axis] = words[letter] * self.scale

    def _shift(self, words: Words) -> None:
        """The place where the machine stands gets these coordinates; U and W move the zero by so much."""
        for axis, letter in enumerate("XYZ"):
            if letter in words:
                self.shifted[axis] += self.at[axis] - self.zero(axis) - words[letter] * self.scale
        for letter, name in _INCREMENTAL.items():
            if self.control.is_lathe and letter in words:
                self.shifted["XYZ".index(name)] -= words[letter] * self.scale

    def _in_machine(self, words: Words) -> None:
        for axis, letter in enumerate("XYZ"):
            if letter in words and not self.incremental:
                self.at[axis] = words[letter] * self.scale
        self.do("rapid", without=_NOT_FOR_RAPIDS)

    # --- motion -------------------------------------------------------------------------------------------

    def _move(self, codes: list[float], words: Words) -> None:
        letters = "XYZUVW" if self.control.is_lathe else "XYZ"
        is_asked = any(letter in words for letter in letters)
        if isinstance(self.motion, str) and self.motion.startswith("cycle"):
            self._drill(words, is_new=any(code >= 73 for code in codes))
        elif not is_asked:
            return
        elif isinstance(self.motion, str):
            self._turn(words)
        elif self.motion in (2, 3):
            self._arc(words)
        else:
            self.at = self.target(words)
            name, without = ("cut", ()) if self.motion else ("rapid", _NOT_FOR_RAPIDS)
            self.do(name, without=without)

    def _arc(self, words: Words) -> None:
        first, second, to_first, to_second = _PLANES[self.plane]
        axes = "XYZ".index(first), "XYZ".index(second)
        begin = [self._radial(axis) for axis in axes]
        self.at = self.target(words)
        end = [self._radial(axis) for axis in axes]
        if "R" in words:
            centre = _centre(begin, end, words["R"] * self.scale, clockwise=self.motion == 2)
        else:
            offsets = [words.get(letter, 0.0) * self.scale for letter in (to_first, to_second)]
            centre = [begin[i] + offsets[i] for i in range(2)]
        self.do("arc", float(self.motion), *centre)

    def _radial(self, axis: int) -> float:
        """A coordinate as arcs count it: X of a lathe as a radius."""
        return self.at[axis] / 2.0 if self.control.is_lathe and axis == 0 else self.at[axis]

    def _turn(self, words: Words) -> None:
        """One pass of a turning cycle, which comes back to where it began; what is not said stays."""
        start = list(self.at)
        for absolute, relative in (("X", "U"), ("Z", "W")):
            if absolute in words or relative in words:
                self.cycle.pop(absolute, None), self.cycle.pop(relative, None)
        self.cycle |= {letter: words[letter] for letter in "XZUWRI" if letter in words}
        self.at = self.target({letter: value for letter, value in self.cycle.items() if letter in "XZUW"})
        self.do(str(self.motion), self.cycle.get("R", 0.0) * self.scale)
        self.at = start

    def _drill(self, words: Words, *, is_new: bool) -> None:
        """A hole; what is not said stays."""
        if not is_new and not any(letter in words for letter in "XYZR"):
            return
        self.cycle |= {letter: words[letter] for letter in "ZRQP" if letter in words}
        begin = self.at[2] if self.incremental else self.level
        plane = self._height("R", begin)
        depth = self._height("Z", plane)
        for _ in range(int(words.get("K", 1.0))):
            flat = {letter: value for letter, value in words.items() if letter in "XY"}
            self.at = [*self.target(flat)[:2], depth]
            self.do(str(self.motion), plane, self.cycle.get("Q", 0.0) * self.scale, self.cycle.get("P", 0.0))
            self.at[2] = self.level if self.returns_to == 98 else plane

    def _height(self, letter: str, begin: float) -> float:
        value = self.cycle.get(letter, 0.0) * self.scale
        return begin + value if self.incremental else self.zero(2) + value


_ONCE = (4.0, 10.0, 28.0, 30.0, 43.0, 52.0, 53.0, 54.1)
_NOT_FOR_RAPIDS = ("speed", "most", "feed")
_NOT_FOR_ORDERS = ("most", "feed")


def _centre(begin: list[float], end: list[float], radius: float, *, clockwise: bool) -> list[float]:
    """The centre of an arc by its radius: the shorter arc for a positive one."""
    along = [end[0] - begin[0], end[1] - begin[1]]
    chord = math.hypot(*along)
    height = math.sqrt(max(0.0, radius * radius - chord * chord / 4.0))
    side = (-1.0 if clockwise else 1.0) * (1.0 if radius > 0 else -1.0)
    middle = [(begin[i] + end[i]) / 2.0 for i in range(2)]
    return [middle[0] - side * height * along[1] / chord, middle[1] + side * height * along[0] / chord]


# --- programs ---------------------------------------------------------------------------------------------


@dataclass
class _Program:
    """The lines of a file, and where its programs begin."""

    lines: list[str]
    starts: dict[int, int]

    @classmethod
    def of(cls, text: str) -> _Program:
        lines = text.split("\n")
        starts = {int(found[1]): i for i, line in enumerate(lines) if (found := re.match(r"O(\d+)", line))}
        return cls(lines, starts)


def run(text: str, control: Control) -> list[Record]:
    """What a control does with a program outside the brackets, and the state at the end of each bracket."""
    machine = Machine(control)
    outside: list[Record] = []
    is_inside = False
    for line in _executed(_Program.of(text), 0, control, 0):
        for comment in _COMMENT.findall(line):
            if comment.startswith("CHIPBREAK BEGIN"):
                is_inside = True
            elif comment.startswith("CHIPBREAK END"):
                is_inside = False
                machine.do("END", without=("speed", "most"))
                outside.append(machine.done[-1])
        before = len(machine.done)
        machine.block(*_words(line))
        outside += machine.done[before:] if not is_inside else []
    return outside


def _executed(program: _Program, first: int, control: Control, depth: int) -> Iterator[str]:
    """The lines in the order in which the control comes to them."""
    assert depth <= _SECOND_DEEPEST
    for whole in program.lines[first:]:
        is_optional = _COMMENT.sub("", whole).strip().startswith("/")
        if is_optional and control.block_delete:
            continue
        line = whole.replace("/", "", 1) if is_optional else whole
        _, words, orders = _words(line)
        yield line
        if 98 in orders:
            for _ in range(int(words.get("L", 1.0))):
                yield from _executed(program, program.starts[int(words["P"])], control, depth + 1)
        if 99 in orders or 30 in orders or 2 in orders:
            return


def _words(line: str) -> tuple[list[float], Words, list[int]]:
    """G codes, words by letter, M codes."""
    codes: list[float] = []
    words: Words = {}
    orders: list[int] = []
    for letter, text in _WORD.findall(_COMMENT.sub("", line)):
        if letter == "G":
            codes.append(float(text))
        elif letter == "M":
            orders.append(int(text))
        elif letter not in "NO":
            words[letter] = float(text)
    return codes, words, orders
