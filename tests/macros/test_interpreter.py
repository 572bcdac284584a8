"""The Macro B interpreter by itself."""

from __future__ import annotations

import pytest

from chipbreak.text.diagnostics import RefusalError
from laser_simulator.barrier import Beam, Station
from laser_simulator.tool import SimulatedTool
from macro_interpreter import FANUC_0I_F, FanucControl, Interpreter, Library, Machine, Outcome
from macro_interpreter.controls import FANUC_0I_F_DPI, FANUC_31I_C


def control(*programs: str, **machine: object) -> Interpreter:
    return Interpreter(Library(programs), Machine(**machine), most_blocks=2000)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("made", "text", "expected"),
    [
        (FANUC_0I_F, "#100=#6", 0.001),
        (FANUC_31I_C, "#100=#6", 0.0001),
        (FANUC_0I_F_DPI, "#100=#6", 1.0),
        (FANUC_0I_F, "#100=#20", 1.0),
    ],
)
def test_an_argument_without_a_decimal_point_may_count_increments(
    made: FanucControl, text: str, expected: float
) -> None:
    ran = control(f"O9001\n{text}\nM99\n", control=made)
    ran.run("G65 P9001 K1 T1")
    assert ran.variables.commons[100] == pytest.approx(expected)
    ran.run("G65 P9001 K1. T1.")
    assert ran.variables.commons[100] == 1.0


def test_a_dwell_without_a_decimal_point_counts_milliseconds() -> None:
    ran = control(reads_ahead=False)
    ran.run("G4 X500\nG4 P500")
    assert ran.machine.clock_s == pytest.approx(1.0, abs=0.05)


def test_places_in_inches_are_whole_increments() -> None:
    ran = control()
    ran.run("G20\nG53 X0.00007\n#100=#5021")
    assert ran.machine.at[0] == pytest.approx(0.00254)
    ran.run("G53 X0.00004")
    assert ran.machine.at[0] == 0.0


@pytest.mark.parametrize(
    "text",
    [
        "#3000=1(THE CONTROL SHOWS NO MORE THAN 26)",
        "#3006=1(THE CONTROL SHOWS NO MORE THAN 26)",
        "#3000=201(TOO HIGH)",
    ],
)
def test_an_alarm_that_the_control_does_not_show_is_refused(text: str) -> None:
    with pytest.raises(RefusalError) as caught:
        control().run(text)
    assert caught.value.code == "MAC011"


def test_the_beam_sees_each_edge_when_it_passes() -> None:
    """Between two edges the signal is off, and a fast touch of a slow spindle runs past the edge."""
    made = at_the_beam()
    made.machine.pulse_s = 0.0
    made.run("G91 G31 Z-60. F1000.\nS150 M3\nG31 Y30. F600.\n#100=#5022\nG90")
    assert -5.0 <= made.variables.commons[100] <= -4.0  # type: ignore[operator]
    slow = at_the_beam()
    slow.machine.pulse_s = 0.0
    slow.run("G91 G31 Z-60. F1000.\nS150 M3\nG31 Y14. F600.\nG31 Y30. F0.6\n#100=#5022\nG90")
    assert -5.0 <= slow.variables.commons[100] <= -4.998  # type: ignore[operator]


def test_the_signal_stays_for_a_while() -> None:
    made = at_the_beam()
    made.machine.pulse_s = 0.2
    made.run("G91 G31 Z-60. F1000.\nG31 Y30. F60.\nG90 G53 Y-10.\n#100=#1000\nG4 X0.3\nG53\n#101=#1000")
    assert (made.variables.commons[100], made.variables.commons[101]) == (1.0, 0.0)


def value(expression: str) -> float | None:
    made = control()
    made.run(f"#1=8.\n#2=3.\n#100={expression}")
    return made.variables.commons[100]


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1+2*3", 7),
        ("[1+2]*3", 9),
        ("8-3-2", 3),
        ("-#1+2", -6),
        # AND stands with *, OR and XOR with +: LinuxCNC reads these as 1 AND .., 0 OR ..
        ("4+3 AND 1", 5),
        ("[4+3] AND 1", 1),
        ("1 OR 2*4", 9),
        ("6 XOR 3+1", 6),
        ("#1 MOD #2", 2),
        ("FIX[2.7]+FIX[-2.7]", 0),
        ("FUP[2.1]", 3),
        ("FUP[-2.1]", -3),
        ("ROUND[2.5]", 3),
        ("ROUND[-2.5]", -3),
        ("ATAN[1]/[-1]", 135),
        ("ATAN[-1]/[1]", 315),
        ("2*ATAN[1]/[1]", 90),
        ("ATAN[1]", 45),
        ("SQRT[16.]+ABS[-1]", 5),
        ("SIN[30.]", 0.5),
        ("ACOS[0]", 90),
        ("LN[EXP[2]]", 2),
        ("BIN[18]+BCD[12]", 30),
        ("#[1+1]", 3),
        ("##2", 0),
        ("#20+1", 1),
        ("[#20 EQ 0]", 0),
        ("[#20 EQ #0]", 1),
        ("[#20 NE 0]", 1),
        ("[#20 GE 0]", 1),
        ("[#20 LT 1]", 1),
    ],
)
def test_expressions(expression: str, expected: float) -> None:
    assert (value(expression) or 0.0) == pytest.approx(expected, abs=1e-9)


def test_vacant_stays_vacant_and_an_axis_word_without_value_is_no_word() -> None:
    made = control()
    made.run("G0 X5. Y#9\n#100=#9\n#101=#9*5")
    assert made.machine.at == (5.0, 0.0, 0.0)
    assert made.variables.commons[100] is None
    assert made.variables.commons[101] == 0.0


def test_arguments_and_levels_of_locals() -> None:
    """G65 has locals of its own, M98 shares those of its caller."""
    inner = "O9002\n#101=#1\n#1=99.\nM98 P9003\n#102=#3\nM99\n"
    outer = "O9001\n#1=#7+#26\nG65 P9002 A4.\n#100=#1\nM99\n"
    made = control(inner, outer, "O9003\n#3=#1\nM99\n")
    made.run("G65 P9001 D2. Z5.")
    commons = made.variables.commons
    assert (commons[100], commons[101], commons[102]) == (7.0, 4.0, 99.0)


def test_a_subprogram_is_repeated() -> None:
    made = control("O9003\n#100=#100+1\nM99\n")
    made.run("#100=0\nM98 P9003 L3\nM98 P9003")
    assert made.variables.commons[100] == 4.0


def test_loops_and_jumps() -> None:
    made = control()
    made.run(
        "#100=0\n#1=0\nWHILE [#1 LT 3] DO1\n#2=0\nWHILE [#2 LT 4] DO2\n#100=#100+1\n"
        "IF [#100 EQ 6] GOTO 10\n#2=#2+1\nEND2\n#1=#1+1\nEND1\n"
        "N10 IF [#100 EQ 6] THEN #101=1\nGOTO 30\n#101=2\nN30"
    )
    assert (made.variables.commons[100], made.variables.commons[101]) == (6.0, 1.0)


def test_alarm_and_stop() -> None:
    made = control()
    assert made.run("#3006=1(TURN THE PART)\n#1=5\n#3000=#1+100(BROKEN)\nG0 X9.") == Outcome(
        105, "BROKEN", ("TURN THE PART",)
    )
    assert made.machine.at == (0.0, 0.0, 0.0)


def at_the_beam() -> Interpreter:
    station = Station(Beam(0.0, 0.0, -100.0), {1: SimulatedTool(length_mm=50.0, holder_mm=0.0)})
    machine = Machine(station, at=(0.0, -20.0, 0.0), work_mm=(10.0, 10.0, 10.0), tool=1)
    machine.angle_deg = 90.0
    return Interpreter(Library(), machine)


def test_a_skip_move_stops_where_the_beam_breaks_and_says_where() -> None:
    made = at_the_beam()
    made.run("G91 G31 Z-60. F100.\n#100=#5063\nG31 Y30.\n#101=#5062\n#102=#5022\n#103=#1000\nG90")
    commons = made.variables.commons
    assert commons[100] == -70.0  # no contact: the end of the move
    assert commons[101] == pytest.approx(-15.0, abs=1e-6)
    assert commons[102] == pytest.approx(-5.0, abs=1e-6)
    assert commons[103] == 1.0


def test_a_skip_move_in_inches() -> None:
    made = at_the_beam()
    made.run("G20 G91 G31 Z-2.5 F4.\nG31 Y2.\n#101=#5022*25.4\nG90 G21")
    assert made.variables.commons[101] == pytest.approx(-5.0, abs=1e-6)


def test_a_skip_signal_that_is_looked_at_now_and_then_comes_late() -> None:
    made = at_the_beam()
    made.machine.reads_ahead = False
    made.machine.sample_s = 0.001
    made.run("G91 G31 Z-60. F100.\nG31 Y30. F1259.")
    late = made.machine.at[1] + 5.0
    assert 0.0 < late <= 1259.0 / 60000.0


def test_a_move_that_breaks_the_beam_is_on_record() -> None:
    made = at_the_beam()
    made.run("G91 G0 Z-60.\nY20.\nG90")
    assert [round(place[1], 1) for place in made.machine.crossings] == [-5.0]


def test_offsets_and_home() -> None:
    made = control(at=(1.0, 2.0, -3.0), work_mm=(0.0, 0.0, -50.0), reads_ahead=False)
    made.length_offsets_mm[4] = 30.0
    made.run("G90 G43 H4 G0 Z5.\n#100=#5003\n#101=#5043\n#102=#4111\n#103=#4003\nG91 G28 Z0.\nG90 G49")
    commons = made.variables.commons
    assert [commons[n] for n in (100, 101, 102, 103)] == [5.0, 35.0, 4.0, 90.0]
    assert made.machine.at == (1.0, 2.0, 0.0)


def test_reading_ahead_ends_at_moves_in_machine_coordinates_skips_and_tool_changes() -> None:
    for stop in ("G53 X1.", "G53", "G31 X1. F10.", "M6", "M0"):
        made = control(reads_ahead=True)
        made.run(f"G0 Z5.\n#100=#5023\n{stop}\n#101=#5023")
        assert (made.variables.commons[100], made.variables.commons[101]) == (0.0, 5.0), stop


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("MAC001", "M98 P9999"),
        ("MAC001", "GOTO 5"),
        ("MAC002", "WHILE [1 EQ 1] DO1"),
        ("MAC002", "END1"),
        ("MAC002", "WHILE [1 EQ 1] DO4\nEND4"),
        ("MAC003", "WHILE [1 EQ 1] DO1\nEND1"),
        ("MAC003", "N1 GOTO 1"),
        ("MAC004", "G65 P9001"),
        ("MAC004", "M98 P9002"),
        ("MAC005", "#0=1"),
        ("MAC005", "#1=#7000"),
        ("MAC005", "#5021=1"),
        ("MAC005", "#1=#[1.5]"),
        ("MAC006", "#1=1/0"),
        ("MAC006", "#1=SQRT[-1]"),
        ("MAC007", "#1=[1"),
        ("MAC007", "#1=POW[2]"),
        ("MAC008", "G2 X1. R1."),
        ("MAC008", "G7.1 C1."),
        ("MAC008", "M88"),
        ("MAC008", "M99 P10"),
        ("MAC009", "G65 A1."),
        ("MAC009", "G65 P9001 N1."),
        ("MAC010", "G31 X1."),
        ("MAC010", "G91 G53 X1."),
        ("MAC010", "G41 G0 X1."),
    ],
)
def test_what_cannot_be_is_refused(code: str, text: str) -> None:
    made = control("O9001\nG65 P9001\nM99\n", "O9002\nM98 P9002\nM99\n")
    with pytest.raises(RefusalError) as caught:
        made.run(text)
    assert caught.value.code == code
