"""Call templates: what the built-in sets say, and what a profile's own set may not say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from chipbreak import settings
from chipbreak.checks.calls import CallValues, CheckKind, calls_of, check_blocks, check_sets
from chipbreak.cli import cli
from chipbreak.dialects import BUILT_IN, FANUC_MILL
from chipbreak.macros.calls import ToolValues
from chipbreak.text.diagnostics import RefusalError
from chipbreak.tools.data import ToolData

MAKERS = [name for name in FANUC_MILL.call_sets if name != BUILT_IN]
DATA = ToolData(2, "flat end mill", 4, 12.0, 38.0, helix_deg=45.0, holder_mm=70.0)
VALUES = CallValues(tool=2, speed_rpm=5300.0, height_mm=20.0, limit_mm=0.02, operation="FINISH", data=DATA)


def texts(profile: str, *options: str, is_inch: bool = False) -> dict[str, tuple[str, ...]]:
    calls = calls_of(settings.load(profile, options))
    return {event.value: calls.text(event, VALUES, is_inch=is_inch) for event in calls.blocks}


def test_fanuc_calls_macros_with_letters() -> None:
    assert texts("fanuc-mill") == {
        "calibrate": ("G65 P8900",),
        "tool_check": ("G65 P8904 T2. K1. D12. R0. H38. E70. Q4. B45.", "G65 P8901 T2. S5300."),
        "trace": ("G65 P8902 T2. Z20.",),
        "chip_check": ("G65 P8903 T2. W0.02 D1.",),
    }


def test_linuxcnc_calls_o_words() -> None:
    assert texts("linuxcnc-mill") == {
        "calibrate": ("o<cb_calibrate> call",),
        "tool_check": (
            "o<cb_tool> call [2] [1] [12.] [0.] [4] [45.]",
            "o<cb_length> call [2] [38.] [70.]",
            "o<cb_tool_check> call [2] [5300]",
        ),
        "trace": ("o<cb_trace> call [2] [20.]",),
        "chip_check": ("o<cb_chip_check> call [2] [0.02] [1]",),
    }


@pytest.mark.parametrize(
    ("depth", "fanuc", "linuxcnc"), [(0, "D0.", "[-1]"), (1, "D1.", "[1]"), (2, "D2.", "[2]")]
)
def test_each_depth_has_its_number(depth: int, fanuc: str, linuxcnc: str) -> None:
    """On LinuxCNC a number that is not given is 0, so the least depth there is -1."""
    values = VALUES._replace(depth=depth)
    blocks = [
        calls_of(settings.load(profile)).text(CheckKind.CHIP_CHECK, values, is_inch=False)
        for profile in ("fanuc-mill", "linuxcnc-mill")
    ]
    assert blocks == [(f"G65 P8903 T2. W0.02 {fanuc}",), (f"o<cb_chip_check> call [2] [0.02] {linuxcnc}",)]


def test_lengths_are_in_the_units_of_the_program() -> None:
    shop = ('calls.a={chip_check="G65 P1 W{limit} A{limit_mm} Z{height} B{height_mm}"}', "checks.calls=a")
    found = texts("fanuc-mill", *shop, is_inch=True)
    assert found["chip_check"] == ("G65 P1 W0.000787 A0.02 Z0.787402 B20.",)


@pytest.mark.parametrize("profile", ["fanuc-mill", "linuxcnc-mill"])
def test_tool_data_is_in_mm_in_inch_programs_too(profile: str) -> None:
    assert texts(profile, is_inch=True)["tool_check"] == texts(profile)["tool_check"]


@pytest.mark.parametrize("profile", ["fanuc-mill", "linuxcnc-mill"])
@pytest.mark.parametrize(
    ("data", "kind", "tip"),
    [
        (DATA, 1, 0.0),
        (DATA._replace(type="bull nose end mill", corner_radius_mm=1.5), 1, 1.5),
        (DATA._replace(type="ball end mill", corner_radius_mm=6.0), 2, 6.0),
        (DATA._replace(type="drill", point_deg=118.0), 3, 118.0),
        (DATA._replace(type="reamer"), 4, 0.0),
    ],
    ids=["flat", "bull nose", "ball", "drill", "reamer"],
)
def test_built_in_calls_hand_over_what_the_macros_take(
    profile: str, data: ToolData, kind: int, tip: float
) -> None:
    """The macros' own writer of these blocks and the built-in templates say the same."""
    macros = settings.load(profile).dialect.macros
    assert macros is not None
    blocks = ToolValues(2, kind, 12.0, tip, 38.0, 70.0, 4, 45.0).blocks(macros)
    calls = calls_of(settings.load(profile))
    written = calls.text(CheckKind.TOOL_CHECK, VALUES._replace(data=data), is_inch=False)
    assert written[: len(blocks)] == blocks


def test_a_shop_may_use_all_that_is_known_of_a_tool() -> None:
    fields = "D{diameter} H{length} R{corner_radius} E{holder} ({type} {helix})"
    shop = f'calls.shop={{trace=["G65 P1 {fields}"]}}'
    calls = calls_of(settings.load("fanuc-mill", [shop, "checks.calls=shop"]))
    data = DATA._replace(diameter_mm=12.7, corner_radius_mm=0.0)
    (text,) = calls.text(CheckKind.TRACE, CallValues(data=data), is_inch=True)
    assert text == "G65 P1 D0.5 H1.49606 R0. E2.75591 (FLAT END MILL 45.)"


def test_what_a_call_lacks() -> None:
    calls = calls_of(settings.load("fanuc-mill"))
    assert calls.lacking(CheckKind.TOOL_CHECK, CallValues(2, data=ToolData(2, "drill", diameter_mm=6.8))) == [
        "tip",
        "length_mm",
        "holder_mm",
        "teeth",
        "helix",
    ]
    assert calls.lacking(CheckKind.TOOL_CHECK, CallValues(2)) == [
        "kind",
        "diameter_mm",
        "tip",
        "length_mm",
        "holder_mm",
        "teeth",
        "helix",
    ]
    assert calls.lacking(CheckKind.TRACE, CallValues(2)) == calls.lacking(CheckKind.TOOL_CHECK, CallValues(2))
    assert calls.lacking(CheckKind.CHIP_CHECK, CallValues(2)) == []


@pytest.mark.parametrize("profile", ["fanuc-mill", "linuxcnc-mill"])
def test_every_built_in_set_calls_every_event(profile: str) -> None:
    assert set(calls_of(settings.load(profile)).blocks) == set(CheckKind)


@pytest.mark.parametrize(
    ("name", "block"),
    [
        ("haas", "G65 P9853 T2 B0. H0.02"),
        ("renishaw", "G65 P9858 T2 H0.02"),
        ("speedio-renishaw", "G65 P8858 B1 H0.02 T2"),
        ("speedio-blum", "G65 P8915 B2 Q0.02"),
    ],
)
def test_makers_cycles_are_called_behind_an_operation(name: str, block: str) -> None:
    assert texts("fanuc-mill", f"checks.calls={name}") == {"chip_check": (block,)}
    inch = texts("fanuc-mill", f"checks.calls={name}", is_inch=True)
    assert inch == {"chip_check": (block.replace("0.02", "0.000787"),)}


def test_there_is_a_profile_for_each_maker() -> None:
    profiles = {settings.load(name).checks.calls: name for name in settings.profile_names()}
    assert set(MAKERS) <= set(profiles)
    for name in MAKERS:
        assert calls_of(settings.load(profiles[name])).name == name


@pytest.mark.parametrize("profile", ["fanuc-mill", "linuxcnc-mill", "grbl", "speedio-blum"])
def test_a_control_reads_its_own_sets(profile: str) -> None:
    """They are not looked at when a profile is read, only when a check is put in."""
    found = settings.load(profile)
    assert found.dialect.call_sets
    for name in found.dialect.call_sets:
        check_blocks(name, found)


def test_a_set_that_does_not_fit_the_control_is_refused_when_a_check_is_put_in() -> None:
    samples = Path(__file__).parents[2] / "samples"
    found = settings.load(str(samples / "mill-with-laser.toml"), ["control.max_line_chars=60"])
    with pytest.raises(chipbreak.SettingsError, match="the limit is 60"):
        chipbreak.rewrite((samples / "fusion-mill.nc").read_bytes(), found)


def test_an_own_set_may_stand_for_a_shipped_one() -> None:
    own = ('calls.haas={tool_check="G65 P9853 T{tool} B0. H{limit}"}', "checks.calls=haas")
    assert texts("fanuc-mill", *own) == {"tool_check": ("G65 P9853 T2 B0. H0.02",)}


def test_built_in_calls_call_the_numbers_of_the_profile_and_other_sets_their_own() -> None:
    moved = ("macros.first_program=9810",)
    assert texts("fanuc-mill", *moved)["calibrate"] == ("G65 P9810",)
    assert texts("fanuc-mill")["calibrate"] == ("G65 P8900",)
    for maker in MAKERS:
        assert texts("fanuc-mill", f"checks.calls={maker}", *moved) == texts(
            "fanuc-mill", f"checks.calls={maker}"
        )


def test_the_number_of_workpieces_and_the_sister_are_handed_over() -> None:
    def written(profile: str, *options: str) -> list[str]:
        calls = calls_of(settings.load(profile, options))
        found = settings.load(profile, options).checks
        values = VALUES._replace(every=found.every, sister=found.sister.get("2", 0))
        return [calls.text(event, values, is_inch=False)[-1] for event in CheckKind]

    assert written("fanuc-mill", "checks.every=3") == [
        "G65 P8900 K3.",
        "G65 P8901 T2. S5300. K3. U0.",
        "G65 P8902 T2. Z20. K3. U0. W0.02 D1.",
        "G65 P8903 T2. W0.02 D1. K3. U0.",
    ]
    assert written("linuxcnc-mill", "checks.every=3", "checks.sister.2=14") == [
        "o<cb_calibrate> call [3]",
        "o<cb_tool_check> call [2] [5300] [3] [14]",
        "o<cb_trace> call [2] [20.] [0] [3] [0.02] [14] [1]",
        "o<cb_chip_check> call [2] [0.02] [1] [3] [14]",
    ]
    own = 'calls.own={chip_check="G65 P1 T{tool} A{every} B{sister}"}'
    assert texts("fanuc-mill", own, "checks.calls=own", "checks.every=4", "checks.sister.9=19")


@pytest.mark.parametrize("key", ["checks.every=2", "checks.sister.2=12", "checks.depth=full"])
@pytest.mark.parametrize("name", MAKERS)
def test_what_the_calls_cannot_say_is_refused(name: str, key: str) -> None:
    with pytest.raises(RefusalError) as caught:
        calls_of(settings.load("fanuc-mill", [f"checks.calls={name}", key]))
    assert caught.value.code == "SET035"
    assert f"no call of the set {name}" in caught.value.message


def test_calls_of_a_machining_centre_are_refused_elsewhere() -> None:
    for profile in ("linuxcnc-mill", "fanuc-lathe"):
        with pytest.raises(RefusalError) as caught:
            calls_of(settings.load(profile, ["checks.calls=renishaw"]))
        assert caught.value.code == "SET030"
        assert "for the dialect fanuc-mill" in caught.value.message


def test_the_speed_of_a_lathe_is_not_that_of_a_tool() -> None:
    with pytest.raises(RefusalError) as caught:
        check_sets(settings.load("fanuc-lathe", ['calls.a={trace="G65 P1 S{speed_rpm}"}', "checks.calls=a"]))
    assert caught.value.code == "SET032"
    assert "turns the workpiece" in caught.value.message


def test_a_shop_may_call_its_own_cycles() -> None:
    shop = 'calls.shop={chip_check=["G53 Z0.", "G65 P9858 T{tool} H{limit} ({operation} {limit_mm} MM)"]}'
    found = texts("fanuc-mill", shop, "checks.calls=shop", is_inch=True)
    assert found == {"chip_check": ("G53 Z0.", "G65 P9858 T2 H0.000787 (FINISH 0.02 MM)")}


@pytest.mark.parametrize(
    ("options", "code", "message", "help_text"),
    [
        (["checks.calls=marposs"], "SET030", "marposs", "builtin, haas, renishaw"),
        (["checks.calls=hass"], "SET030", "hass", "did you mean haas?"),
        (["calls.blum={trace=[]}", "checks.calls=blun"], "SET030", "blun", "did you mean blum?"),
        (['calls.a={chip_chek=["G65 P1"]}'], "SET031", "chip_chek", "did you mean chip_check?"),
        (['calls.a={chip_check=["G65 P1 H{limt}"]}'], "SET032", "{limt}", "limit"),
        (['calls.a={calibrate=["G65 P1 T{tool}"]}'], "SET032", "calibrate does not have", "known: every"),
        (['calls.a={calibrate=["G65 P1 H{limit}"]}'], "SET032", "{limit}", "every"),
        (['calls.a={trace=["G65 P1 T{}"]}'], "SET032", "{}", "tool"),
        (['calls.a={trace=["G65 P1 T{tool"]}'], "SET033", "T{tool", "in braces"),
        (['calls.a={trace=["G65 P1 Z{height:.2f}"]}'], "SET033", "takes no format", "in braces"),
        (['calls.a={trace=["G65 P1 ? T{tool}"]}'], "SET033", "'?' is not expected", "one block"),
        (['calls.a={trace=["(TRACE)"]}'], "SET033", "no words", "one block"),
        (['calls.a={trace=[""]}'], "SET033", "no words", "one block"),
        (['calls.a={trace=["G65 P1\\nM30"]}'], "SET033", "no control reads", "one block"),
        (['calls.a={trace=["G65 P1 (MÜHLE)"]}'], "SET033", "no control reads", "one block"),
        ([f'calls.a={{trace=["G65 P1 ({"X" * 72})"]}}'], "SET034", "81 characters", "split"),
        (
            ['calls.a={trace=["G65 P1 T{tool} Z{height} (' + "X" * 31 + ')"]}'],
            "SET034",
            "61 characters",
            "split",
        ),
    ],
)
def test_a_call_that_could_write_nonsense_is_refused(
    options: list[str], code: str, message: str, help_text: str
) -> None:
    chosen = [] if options[-1].startswith("checks.calls") else ["checks.calls=a", "control.max_line_chars=60"]
    if "81" in message:
        chosen[1] = "control.max_line_chars=255"
    with pytest.raises(RefusalError) as caught:
        check_sets(settings.load("fanuc-mill", [*options, *chosen, "checks.enabled=true"]))
    assert caught.value.code == code
    assert message in caught.value.message
    assert help_text in caught.value.help


@pytest.mark.parametrize("profile", ["generic-lathe", "fanuc-lathe", "linuxcnc-lathe"])
def test_a_lathe_has_no_built_in_calls_and_says_so(profile: str) -> None:
    with pytest.raises(RefusalError) as caught:
        calls_of(settings.load(profile))
    assert caught.value.code == "SET030"
    assert "tools that turn" in caught.value.message
    assert "[calls.NAME]" in caught.value.help


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ('[calls.spare]\nchip_check = ["G65 P1 H{limt}"]\n', "SET032"),
        ('[calls.spare]\nchip_chek = ["G65 P1"]\n', "SET031"),
        ("[checks]\nenabled = true\n", "SET030"),
        ('[checks]\nenabled = true\ncalls = "haas"\n', "SET030"),
        ('[operations]\nruogh = ["X"]\n', "SET020"),
    ],
)
def test_calls_are_checked_when_the_profile_is_read(text: str, code: str, tmp_path: Path) -> None:
    """Also those that this program will never come to."""
    profile = tmp_path / "lathe.toml"
    profile.write_text('base = "fanuc-lathe"\n' + text)
    shown = CliRunner().invoke(cli, ["profile", "show", str(profile)])
    assert shown.exit_code == 2
    assert f"error {code}: {profile}: " in shown.output
    assert "help: " in shown.output


@pytest.mark.parametrize(
    ("block", "what"),
    [
        ("F300.", "sets the feed F"),
        ("G1 F300. Z5.", "sets the feed F"),
        ("T5", "calls a tool"),
        ("T{tool} M6", "calls a tool"),
        ("M6", "calls a tool"),
        ("O1", "begins a program"),
        ("M30", "ends the program"),
        ("M99", "ends the program"),
        ("G20", "changes the units"),
        ("G95", "changes the feed mode"),
        ("G96 S100", "changes the speed mode"),
        ("G92 S2000", "limits the spindle"),
        ("G49", "changes the length offset"),
        ("G66 P8900", "begins or ends a modal macro call"),
        ("IF [#1 EQ 1] GOTO 5", "jumps, loops"),
        ("G68 X0 Y0 R30.", "turns, scales or bends the coordinates"),
        ("G51 X1. Y1. P2000", "turns, scales or bends the coordinates"),
        ("G51.1 X0", "turns, scales or bends the coordinates"),
        ("G16", "turns, scales or bends the coordinates"),
        ("G41 D1", "begins a compensation of the cutter"),
        ("G52 X5.", "moves the zero"),
        ("G92 X0", "moves the zero"),
        ("G10 L2 P1 X5.", "moves the zero"),
        ("G10 L20 P1 X5.", "moves the zero"),
    ],
)
def test_a_call_that_leaves_something_behind_is_refused(block: str, what: str) -> None:
    own = [f'calls.own={{chip_check="{block}"}}', "checks.calls=own"]
    with pytest.raises(RefusalError, match=re.escape(what)) as caught:
        check_sets(settings.load("fanuc-mill", own))
    assert caught.value.code == "SET036"


def test_a_work_offset_is_given_back_before_the_tool_goes_to_a_place() -> None:
    program = (
        b"G20 G90 G54\nT7 M6\nS12000 M3\n(ROUGH)\nG0 X1.25 Y-.375\nG43 H7 Z.5\nG1 Z-.1 F20.\nX3.\nG0 Z.5\n"
        b"(FINISH)\nZ.1\nG1 Z-.12 F20.\nX1.25\nG0 Z.5\nM5\nM2\n"
    )
    own = ['calls.own={chip_check="G55"}', "checks.calls=own", "checks.enabled=true"]
    lines = chipbreak.rewrite(program, settings.load("fanuc-mill", own)).data.splitlines()
    called = lines.index(b"G55")
    there = next(at for at in range(called, len(lines)) if lines[at].startswith(b"G0 X3."))
    assert called < lines.index(b"G54", called) < there


def test_a_call_may_set_the_length_of_a_tool() -> None:
    check_sets(settings.load("fanuc-mill", ['calls.own={chip_check="G10 L11 P1 R0"}', "checks.calls=own"]))


@pytest.mark.parametrize(
    ("field", "longest"),
    [
        # Tools of 2 m and eight digits, lengths to 0.0001 mm.
        ("diameter", "1999.9999"),
        ("length", "1999.9999"),
        ("tool", "99999999"),
    ],
)
def test_a_block_is_as_long_as_its_values_can_make_it(field: str, longest: str) -> None:
    block = "G65 P1 " + f"A{{{field}}} " * 8
    own = [f'calls.own={{tool_check="{block.rstrip()}"}}', "checks.calls=own"]
    wanted = len(block.rstrip()) + 8 * (len(longest) - len(f"{{{field}}}"))
    with pytest.raises(RefusalError, match=f"can become {wanted} characters long") as caught:
        check_sets(settings.load("fanuc-mill", own))
    assert caught.value.code == "SET034"


@pytest.mark.parametrize(
    "block",
    [
        *(
            "G65 P1 F100. S500 T{tool}",
            "M98 P5",
            "S500",
            "M5",
            "M3 S500",
            "M4",
            "M8",
            "M7",
            "M9",
            "M19",
            "G91",
        ),
        *("G90 G0 Z50.", "G4 X1.", "G40", "G53 G0 Z0.", "#100=1", "G18", "G80", "G55"),
    ],
)
@pytest.mark.parametrize("next_blocks", ["G0 X5. Y5.", "M5\nM9\nS900 M3", "M3", "M9", "S900 M3", "M5\nM3"])
def test_what_other_calls_change_is_given_back(block: str, next_blocks: str) -> None:
    """The self-check compares what is in force behind the calls with the original."""
    program = (
        "%\nO1\nG90 G21 G40 G80 G54\nT1 M6\nS1000 M3\nM8\nG0 X1. Y1.\nG43 H1 Z15.\n(ROUGH)\nG1 Z-1. F100.\n"
        f"G0 Z15.\n(FINISH)\n{next_blocks}\nG0 X2. Y2.\nG43 H1 Z15.\nG1 Z-1. F100.\nG0 Z15.\nM30\n%\n"
    ).encode()
    own = [f'calls.own={{chip_check="{block}"}}', "checks.calls=own", "checks.enabled=true"]
    result = chipbreak.rewrite(program, settings.load("fanuc-mill", own))
    assert result.data.count(b"BEGIN CHIP CHECK T1") == 2
