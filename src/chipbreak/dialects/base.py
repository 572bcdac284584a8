"""The shape of a dialect.  G codes are keyed by ten times their number, so G38.2 is 382."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Literal

from chipbreak.dialects.check_programs import CallTemplates, MacroSet
from chipbreak.dialects.modes import Modes, check_value
from chipbreak.dialects.numbers import NUMBER_RULES, NumberRule
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple

ContourCycle = Literal["along-z", "along-x", "pattern", "finish"]
# Groups whose codes act in their own block only.  The interpreter and the refusals know them by value.
NON_MODAL = "non_modal"
# The group of a G80 that ends a canned cycle and leaves the motion code from before it in force.
CYCLE_END = "cycle_end"

# What a mark of a block says: another program begins, the lines behind it are of that path, its path waits
# for another one, its spindle words are for another spindle.
PROGRAM, PATH, WAIT, SPINDLE = "program", "path", "wait", "spindle"
EVERY_LETTER = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


_CODE_WITH_WORDS = re.compile(r"G(\d+(?:\.\d)?)(?: [PQR]\d*\.?\d+)*")
# The operators of expressions, the strongest first; those of one set are worked out from left to right.
Precedence = tuple[frozenset[str], ...]

_COMPARISONS = frozenset({"EQ", "NE", "GT", "GE", "LT", "LE"})
LOGIC_LAST: Precedence = (
    frozenset({"**"}),
    frozenset({"*", "/", "MOD"}),
    frozenset({"+", "-"}),
    _COMPARISONS,
    frozenset({"AND", "OR", "XOR"}),
)
LOGIC_AS_ARITHMETIC: Precedence = (
    frozenset({"**"}),
    frozenset({"*", "/", "MOD", "AND"}),
    frozenset({"+", "-", "OR", "XOR"}),
    _COMPARISONS,
)


class Code(NamedTuple):
    """What a G code does: it sets ``group`` to ``value``."""

    group: str
    value: str


class MCode(NamedTuple):
    """What an M code does: ``value`` of a ``group`` of functions.

    ``spindle``          ``cw``, ``ccw``, ``stop``
    ``coolant``          ``mist``, ``flood``, ``off``
    ``coolant_through``  through the spindle: ``on``, ``off``
    ``program``          ``end``
    ``stop``             ``always``, ``optional``, ``pallet``: the program stops, and goes on from there
    ``subprogram``       ``call``, ``local-call`` (of a block of this program), ``external-call``, ``return``
    ``tool``             ``change``: the tool that a T word has named comes into the spindle
    ``modes``            ``keep`` what is in force, ``give-back`` what was kept
    ``other_spindle``    turned or stopped by it: ``cw``, ``ccw``, ``stop``
    ``before_move``      True where it acts before its block moves
    ``coolant``          ``flood`` where it switches coolant on besides
    """

    group: str
    value: str
    before_move: bool = False
    coolant: str = ""


PROGRAM_MARKS = FrozenTable({"PROGRAM-NAME": PROGRAM, "PROGRAM-NUMBER": PROGRAM})
# Lathes that work with several paths at once.
PATH_MARKS = PROGRAM_MARKS | FrozenTable({"PATH-MARK": PATH, "HEAD-MARK": PATH, "WAIT-MARK": WAIT})


class Loop(NamedTuple):
    """How a control repeats blocks: the lines before and behind them.

    ``{passes}`` is how often, ``{label}`` one of ``labels``, ``{variable}`` the number of a counter.
    ``reuses``: loops that do not lie in each other may have one label.  ``variables``: the numbers that a
    counter may have; empty where there is none.
    """

    begin: tuple[str, ...]
    end: tuple[str, ...]
    labels: range
    reuses: bool
    variables: tuple[range, ...] = ()

    @property
    def statements(self) -> int:
        """Lines that the control reads in each pass beside the blocks themselves."""
        return 1 + len(self.end)


class Clock(NamedTuple):
    """How a program reads the clock of a control, in milliseconds.

    ``wait`` is a block that keeps it from working out statements before the blocks in front have run,
    ``begin`` sets the clock to zero, ``end`` leaves what it says in ``{variable}``, from ``first_variable``
    on, ``message`` stops and shows ``{text}``.  ``program`` is a number for a program that does such things.
    """

    wait: str
    begin: str
    end: str
    message: str
    first_variable: int
    program: int


class CommentMarks(NamedTuple):
    """What stands before and behind a comment that is written; nothing behind where the line ends it."""

    before: str
    behind: str


PARENTHESES = CommentMarks("(", ")")
SEMICOLON = CommentMarks("; ", "")


def m_table(**groups: Mapping[str, str]) -> FrozenTable[int, MCode]:
    """Build an M code table from ``group={"M3!": "cw", ...}``; ``!`` marks what acts before the move."""
    codes: dict[int, MCode] = {}
    for group, entries in groups.items():
        for names, value in entries.items():
            for name in names.split():
                codes[int(name.strip("M!"))] = MCode(group, value, name.endswith("!"))
    return FrozenTable(codes)


# What nearly every control shares, and what machines with a tool changer have beside it.
COMMON_M_CODES = m_table(
    spindle={"M3!": "cw", "M4!": "ccw", "M5 M19": "stop"},
    coolant={"M7!": "mist", "M8!": "flood", "M9": "off"},
    program={"M2 M30": "end"},
    stop={"M0": "always", "M1": "optional", "M60": "pallet"},
    subprogram={"M97": "local-call", "M98": "call", "M198": "external-call", "M99": "return"},
)
# Lathes with a second and a third spindle number their codes so.
OTHER_SPINDLES = m_table(
    other_spindle={"M103 M203 M303": "cw", "M104 M204 M304": "ccw", "M105 M205 M305": "stop"},
)
CHANGER_M_CODES = COMMON_M_CODES | m_table(tool={"M6": "change"})
THROUGH_SPINDLE = m_table(coolant_through={"M88": "on", "M89": "off"})


class Stops(NamedTuple):
    """What a control that knows no mercy stops at, beside the codes that are not in its tables.

    ``letters``        that words may have
    ``tape_mark``      it stops at the % at the ends of a program
    ``line_chars``     the most characters of a line with its comments, 0 for no limit
    ``code_chars``     the same without comments and blanks
    ``real_time``      characters that it obeys wherever they stand, in comments too
    ``real_time_from`` all bytes from this one on are such, 0 for none
    ``one_command``    a line is one G or M code, in front, and the words of it
    ``has_own_commands`` lines that are no words may be commands of its own
    """

    letters: str
    tape_mark: bool = False
    line_chars: int = 0
    code_chars: int = 0
    real_time: str = ""
    real_time_from: int = 0
    one_command: bool = False
    has_own_commands: bool = False


class NoseRules(NamedTuple):
    """How a lathe's control compensates the nose radius of a tool.

    ``tips``  tip number -> the signs, along Z and X, of the way from the centre of the nose to the tip
    ``rounds_corners``  an outer corner is rounded by an arc; without it straight lines go on until they meet
    ``leads_in_by_itself``  the move that leads in ends square to itself; without it, square to the next one
    """

    tips: Mapping[int, tuple[int, int]]
    rounds_corners: bool = False
    leads_in_by_itself: bool = False


class Dialect(NamedTuple):
    """A control's vocabulary.

    ``grammar``       the file of ``grammar/`` that reads its blocks, without ``.lark``, or another's path
    ``precedence``    the operators of its expressions, the strongest first
    ``g_codes``       ten times the G number -> Code
    ``m_codes``       M number -> MCode
    ``initial``       what is in force at power-on
    ``incremental``   letters that always move incrementally -> the axis (U -> X); empty where they are axes
    ``tool_change``   "T" where a T word changes the tool at once, "M6" where an M code does
    ``number_rules``  the values of ``control.decimal_point`` that it can have, and what each means
    ``offset_digits`` of a T word that changes the tool: its last digits name the offset
    ``speed_limit``   G codes (times ten) that limit the spindle when they stand with S
    ``surface_limit`` the letter that limits the spindle in the block of G96; without it there is no limit
    ``surface_needs_speed`` a G96 without S is refused
    ``lone_dwell_words`` letters that are the time of a G4 which has none of its own words
    ``moves_beside_dwell`` axis words beside G4 are a move behind it, and no time
    ``dwell_word``    the letter of seconds in a G4 block
    ``dwells_per_s``  what a second is in this word: 1000 where it counts milliseconds
    ``machine_retract`` blocks that take the tool to the machine's safe end of travel, in order
    ``kept_variables`` first and last numbers of the variables in which programs may keep values
    ``retract_is_absolute`` these blocks must not stand in incremental mode
    ``axis_letters``  letters that can name a linear axis
    ``set_off``       what stands between the letter of an axis and its value where it is written: "", or "="
    ``comment_marks`` how a comment is written: PARENTHESES or SEMICOLON; the way back reads both
    ``loop``          how blocks are repeated; None where the control has no way that is known
    ``contour_cycles`` the codes (times ten) of cycles whose P and Q name their contour, and which each is
    ``subroutine_cycles`` the codes (times ten) of cycles whose Q names a subroutine with their contour
    ``subroutine_radius``  the letter of a line in such a contour that rounds the corner behind it
    ``subroutine_chamfer`` the same for the chord of such an arc
    ``turning_cycles`` the codes (times ten) that make one pass with each block, and along which axis
    ``deep_drilling`` the codes (times ten) that drill along Z by pecks
    ``nose``          how it compensates nose radii; None where that is not known
    ``place_variables`` numbers and names of the variables that hold the place where the tool stands
    ``speed_variables`` those that hold the spindle speed in force, or its mode
    ``place_settings`` the L of those G10 that work with that place
    ``turns_offsets`` the R of ``G10 L2`` turns a work offset
    ``marks``         what a mark says on this control: its keyword -> PROGRAM, PATH, WAIT or SPINDLE
    ``takes_nested_comments`` a ( inside a comment is a character like another
    ``spindle_word``  the letter that says which spindle S and M3 are for; empty where there is none
    ``line_needs_feed`` a G1 without F is refused, and G94 and G95 end the F before
    ``macros``        the programs that check tools on this control; None where there are none
    ``call_sets``     sets of calls of such programs by name, ``builtin`` those of ``macros``
    ``no_macros``     why there are no built-in calls, where there are none
    ``converts_feed`` over G20 and G21, F and the P of G64 keep their value and not their number
    ``feed_before_units`` F, and S under G96, are read before the G20 or G21 of their block
    ``own_words``     code -> the letters that it takes for itself; F, S, T and M of its block that are not
                      among them act as always
    ``returning_cycles`` cycles (their non-modal values) behind which the tool is back where they began
    ``message_mark`` what a comment begins with that the control shows to the operator
    ``bare_arc_is_line`` an arc block without R, I, J and K moves in a line; without it, it is refused
    ``arc_turns``     the letter that says how many turns an arc makes; empty where there is none
    ``settings``      numbers of $ lines (``$11=0.02``) -> the key of the profile that says the same
    ``stops_at``      what it stops at; None where it is not known to
    ``repeats_codes`` every block says its code: G1, and with S the M code of the spindle
    ``clock``         how a program reads the time; None where it cannot
    ``least_inverse_feed`` no block of inverse time is slower, in the program's own units per minute
    ``holds_programs`` M0 holds a program until somebody lets it go on, and M2 ends it
    """

    name: str
    title: str
    is_lathe: bool
    g_codes: Mapping[int, Code]
    initial: Modes
    tool_change: str
    grammar: str | Path
    precedence: Precedence
    m_codes: Mapping[int, MCode] = COMMON_M_CODES
    number_rules: Mapping[str, NumberRule] = NUMBER_RULES
    offset_digits: int = 2
    lathe_system: str = ""
    incremental: Mapping[str, str] = FrozenTable({})
    speed_limit: frozenset[int] = frozenset()
    surface_limit: str = ""
    machine_retract: tuple[str, ...] = ()
    retract_is_absolute: bool = False
    kept_variables: tuple[tuple[int, int], ...] = ()
    dwell_word: str = "X"
    axis_letters: str = "XYZABC"
    reads_comments_in_lower_case: bool = False
    set_off: str = ""
    comment_marks: CommentMarks = PARENTHESES
    loop: Loop | None = None
    contour_cycles: Mapping[int, ContourCycle] = FrozenTable({})
    turning_cycles: Mapping[int, ContourCycle] = FrozenTable({})
    subroutine_cycles: Mapping[int, ContourCycle] = FrozenTable({})
    subroutine_radius: str = ""
    subroutine_chamfer: str = ""
    nose: NoseRules | None = None
    deep_drilling: frozenset[int] = frozenset()
    place_variables: frozenset[int | str] = frozenset(range(5001, 5061))
    # S and the groups of G96 and G97 of the block before and of this one; Haas has the speed itself as well.
    speed_variables: frozenset[int | str] = frozenset({4119, 4319, 4002, 4202, 4013, 4213, 3027})
    place_settings: frozenset[float] = frozenset()
    turns_offsets: bool = False
    marks: Mapping[str, str] = FrozenTable({})
    takes_nested_comments: bool = True
    spindle_word: str = ""
    line_needs_feed: bool = False
    converts_feed: bool = False
    macros: MacroSet | None = None
    call_sets: Mapping[str, CallTemplates] = FrozenTable({})
    no_macros: str = "the macros measure tools that turn"
    feed_before_units: bool = False
    own_words: Mapping[Code, str] = FrozenTable({})
    returning_cycles: frozenset[str] = frozenset()
    bare_arc_is_line: bool = False
    arc_turns: str = ""
    surface_needs_speed: bool = False
    lone_dwell_words: str = ""
    moves_beside_dwell: bool = False
    dwells_per_s: float = 1.0
    settings: Mapping[int, str] = FrozenTable({})
    stops_at: Stops | None = None
    repeats_codes: bool = False
    least_inverse_feed: float = 0.0
    holds_programs: bool = True
    message_mark: str = ""
    clock: Clock | None = None

    def code(self, group: str, value: str, like: Collection[int] = ()) -> str:
        """The G code that sets a modal group, such as ``G95`` for feed_mode, rev.

        Of several it is the one nearest in number to ``like``, codes (times ten) of the same program: one
        that says G98 wants G99 and not G95.  Words behind the code stand in the value (``G54.1 P3``).  Raises
        KeyError where the control has none.
        """
        value, *words = value.split(" ")
        numbers = [number for number, code in self.g_codes.items() if code == (group, value)]
        if not numbers:
            raise KeyError(f"{group} {value}")
        number = min(numbers, key=lambda n: min((abs(n - other) for other in like), default=0))
        whole, tenth = divmod(number, 10)
        return " ".join([f"G{whole}.{tenth}" if tenth else f"G{whole}", *words])

    def m_code(self, group: str, value: str) -> str:
        """The M code that does this, such as ``M3`` for spindle, cw; the lowest of several.

        Raises KeyError where the control has none.
        """
        does = [number for number, code in self.m_codes.items() if code[:2] == (group, value)]
        if not does:
            raise KeyError(f"{group} {value}")
        return f"M{min(does)}"

    def with_code(self, spindle: str, speed: str) -> str:
        """``S800``, on a control that reads no S alone behind the code of the spindle."""
        return f"{self.m_code('spindle', spindle)} {speed}" if self.repeats_codes else speed

    @property
    def keeps_modes(self) -> bool:
        """True where M codes keep what is in force and give it back."""
        return any(code.group == "modes" for code in self.m_codes.values())

    @property
    def tool_by_word(self) -> bool:
        """True where a T word changes the tool at once."""
        return self.tool_change == "T"

    def tool_of(self, number: int) -> int:
        """The tool of a T word: ``T0212`` is tool 2 where the word changes the tool and names its offset."""
        offsets = 10**self.offset_digits
        return number // offsets if self.tool_by_word and number >= offsets else number

    def can(self, group: str, value: str) -> bool:
        """True when the control has a code for this."""
        return Code(group, value) in self.g_codes.values()

    def code_of(self, text: str) -> Code | None:
        """What ``G61``, or ``G64 P0.01 Q0.005`` with its words, does; None for anything else."""
        match = _CODE_WITH_WORDS.fullmatch(text)
        return self.g_codes.get(round(float(match[1]) * 10)) if match else None


def check_dialect(dialect: Dialect) -> None:
    """Refuse a value that a known modal group does not have, in the codes or at power-on.

    Raises ValueError.
    """
    for code in dialect.g_codes.values():
        check_value(*code)
    for group, value in dialect.initial.items():
        check_value(group, value)


def table(**groups: Mapping[str, str]) -> FrozenTable[int, Code]:
    """Build a G code table from ``group={"G0": "rapid", ...}``; codes may share a cell: ``"G43 G44"``.

    Raises ValueError for a value that a known modal group does not have.
    """
    codes: dict[int, Code] = {}
    for group, entries in groups.items():
        for names, value in entries.items():
            check_value(group, value)
            for name in names.split():
                codes[round(float(name[1:]) * 10)] = Code(group, value)
    return FrozenTable(codes)


# What nearly every ISO 6983 control shares.
COMMON = table(
    motion={"G0": "rapid", "G1": "line", "G2": "cw", "G3": "ccw"},
    plane={"G17": "XY", "G18": "ZX", "G19": "YZ"},
    units={"G20": "inch", "G21": "mm"},
    compensation={"G40": "off", "G41 G41.1": "left", "G42 G42.1": "right"},
    work_offset={
        "G54": "G54",
        "G55": "G55",
        "G56": "G56",
        "G57": "G57",
        "G58": "G58",
        "G59": "G59",
        "G54.1": "G54.1",
        "G59.1": "G59.1",
        "G59.2": "G59.2",
        "G59.3": "G59.3",
    },
    non_modal={
        "G4": "dwell",
        "G9": "exact-stop",
        "G10": "data-setting",
        "G11": "data-setting-end",
        "G28 G28.1 G30 G30.1": "home",
        "G31": "skip",
        "G52": "shift",
        "G53": "machine",
        "G65": "macro-call",
    },
)
