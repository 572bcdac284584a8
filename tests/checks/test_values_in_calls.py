"""The fields of calls as texts, which blocks are written with them, and what a set hands over."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

import chipbreak
from chipbreak.checks.calls import CallSet, CallValues, CheckKind, calls_of, check_blocks
from chipbreak.checks.touch_plate import TouchPlate, touch_plate_of
from chipbreak.text.diagnostics import RefusalError
from chipbreak.tools.data import ToolData

KNOWN = {
    "every": "1",
    "sister": "0",
    "depth": "1",
    "depth_signed": "1",
    "work_offset": "",
    **dict.fromkeys(
        ("setter_x", "setter_y", "safe_z", "setter_depth", "clear", "fast_feed", "slow_feed"), ""
    ),
}


def test_what_is_not_known_has_no_field() -> None:
    assert CallValues().fields(is_inch=False) == KNOWN
    assert CallValues().fields(is_inch=True) == KNOWN


def test_every_field_that_is_known() -> None:
    plate = TouchPlate(-25.4, 50.8, 0.0, 127.0, 12.7, 2540.0, 254.0)
    values = CallValues(7, 1234.6, 2.54, 0.0254, "ROUGH", ToolData(7, teeth=3), 5, 12, 0, plate, "G55")
    said = {
        **{
            "tool": "7",
            "speed_rpm": "1235",
            "operation": "ROUGH",
            "teeth": "3",
            "every": "5",
            "sister": "12",
        },
        **{
            "depth": "0",
            "depth_signed": "-1",
            "work_offset": "G55",
            "height_mm": "2.54",
            "limit_mm": "0.0254",
        },
    }
    assert values.fields(is_inch=False) == said | {
        **{"height": "2.54", "limit": "0.0254", "setter_x": "-25.4", "setter_y": "50.8", "safe_z": "0."},
        **{"setter_depth": "127.", "clear": "12.7", "fast_feed": "2540.", "slow_feed": "254."},
    }
    assert values.fields(is_inch=True) == said | {
        **{"height": "0.1", "limit": "0.001", "setter_x": "-1.", "setter_y": "2.", "safe_z": "0."},
        **{"setter_depth": "5.", "clear": "0.5", "fast_feed": "100.", "slow_feed": "10."},
    }


KEYS = ("setter_x_mm", "setter_y_mm", "setter_z_mm", "safe_z_mm")


def plate_of(**macros: float | None) -> TouchPlate | None:
    given: dict[str, Any] = {"clear_mm": 3.0, "fast_feed": 200.0, "slow_feed": 20.0, **macros}
    return touch_plate_of(cast(chipbreak.Settings, SimpleNamespace(macros=SimpleNamespace(**given))))


def test_the_plate_of_a_profile() -> None:
    places = dict(zip(KEYS, (1.0, 2.0, -300.0, -10.0), strict=True))
    assert plate_of(**places) == TouchPlate(1.0, 2.0, -10.0, 290.0, 3.0, 200.0, 20.0)
    for key in KEYS:
        assert plate_of(**{**places, key: None}) is None


def own(blocks: dict[CheckKind, tuple[str, ...]], tails: dict[CheckKind, str] | None = None) -> CallSet:
    return CallSet("own", blocks, tails or {}, False)


def test_a_block_with_a_value_that_is_not_known_is_left_out() -> None:
    calls = own({CheckKind.TRACE: ("G65 P1 T{tool}", "G65 P2 D{diameter_mm}", "G65 P3 Q{teeth}")})
    values = CallValues(2, data=ToolData(2, teeth=4))
    assert calls.text(CheckKind.TRACE, values, is_inch=False) == ("G65 P1 T2", "G65 P3 Q4")


@pytest.mark.parametrize(("every", "sister", "has_tail"), [(1, 0, False), (2, 0, True), (1, 9, True)])
def test_the_tail_says_what_is_not_usual(every: int, sister: int, has_tail: bool) -> None:
    calls = own({CheckKind.TRACE: ("A", "B Q{teeth}")}, {CheckKind.TRACE: " K{every} U{sister}"})
    tail = f" K{every} U{sister}" if has_tail else ""
    values = CallValues(2, every=every, sister=sister)
    assert calls.text(CheckKind.TRACE, values, is_inch=False) == (f"A{tail}",)
    known = values._replace(data=ToolData(2, teeth=4))
    assert calls.text(CheckKind.TRACE, known, is_inch=False) == ("A", f"B Q4{tail}")
    nothing = own({CheckKind.TRACE: ("B Q{teeth}",)}, {CheckKind.TRACE: " K{every}"})
    assert nothing.text(CheckKind.TRACE, values, is_inch=False) == ()


def test_what_a_set_hands_over() -> None:
    calls = own(
        {CheckKind.TRACE: ("G65 P1 T{tool} D{depth}",), CheckKind.CHIP_CHECK: ("G65 P2 Q{teeth}",)},
        {CheckKind.TOOL_CHECK: " U{sister}"},
    )
    assert calls.has(CheckKind.TRACE) and not calls.has(CheckKind.TOOL_CHECK)
    handed = {
        field: calls.hands_over(field) for field in ("tool", "depth", "teeth", "sister", "every", "limit")
    }
    assert handed == {
        **dict.fromkeys(("tool", "depth", "teeth", "sister"), True),
        "every": False,
        "limit": False,
    }
    assert calls.hands_over_depth() and calls.uses_tool_data()
    assert calls.needs(CheckKind.TRACE, "depth") and not calls.needs(CheckKind.CHIP_CHECK, "depth")
    signed = own({CheckKind.TRACE: ("G65 P1 D{depth_signed} T{tool}",)})
    assert signed.hands_over_depth() and not signed.uses_tool_data()
    assert not own({CheckKind.TRACE: ("G65 P1 T{tool}",)}).hands_over_depth()
    assert calls.counts_on(CheckKind.TRACE) == (CheckKind.TOOL_CHECK, CheckKind.TRACE)
    assert calls.counts_on(CheckKind.CHIP_CHECK) == (CheckKind.CHIP_CHECK,)


def refusal(profile: str, *options: str, name: str = "") -> tuple[str, str, str]:
    settings = chipbreak.load(profile, options)
    with pytest.raises(RefusalError) as caught:
        check_blocks(name, settings) if name else calls_of(settings)
    return caught.value.code, caught.value.message, caught.value.help


def test_of_a_set_that_cannot_be_used_all_is_said() -> None:
    assert refusal("fanuc-mill", "checks.calls=hass") == (
        "SET030",
        'checks.calls: there is no set of calls "hass"',
        "did you mean haas?",
    )
    assert refusal("linuxcnc-mill", "checks.calls=renishaw") == (
        "SET030",
        'checks.calls: the set "renishaw" is for the dialect fanuc-mill, not for linuxcnc-mill',
        "set checks.calls=setter where a touch plate finds broken tools;"
        " or describe your own in [calls.NAME], and set checks.calls",
    )
    code, message, help_text = refusal("fanuc-lathe")
    assert (code, message.partition(": ")[0]) == (
        "SET030",
        "there are no built-in calls for the dialect fanuc-lathe",
    )
    assert help_text == "describe your own in [calls.NAME], and set checks.calls"
    assert refusal("grbl")[2] == (
        "set checks.calls=setter where a touch plate finds broken tools;"
        " or describe your own in [calls.NAME], and set checks.calls"
    )
    assert refusal("fanuc-mill", "checks.calls=haas", "checks.every=2") == (
        "SET035",
        "checks.every is set, but no call of the set haas hands {every} over",
        "use calls that take it, or leave checks.every out",
    )


@pytest.mark.parametrize(
    ("kind", "block", "code", "said", "help_text"),
    [
        (
            "trace",
            "G65 P1 T{tool",
            "SET033",
            "cannot be read: expected '}' before end of string",
            "write fields in braces, such as {tool}",
        ),
        (
            "trace",
            "G65 P1 H{height:.2f}",
            "SET033",
            "cannot be read: {height} takes no format",
            "write fields in braces, such as {tool}",
        ),
        (
            "trace",
            "G65 P1 H{height!r}",
            "SET033",
            "cannot be read: {height} takes no format",
            "write fields in braces, such as {tool}",
        ),
        (
            "trace",
            "G65 P1 H{hight}",
            "SET032",
            "has a field {hight}, which trace does not have",
            "did you mean height?",
        ),
        (
            "calibrate",
            "G65 P1 Q{qqqq}",
            "SET032",
            "has a field {qqqq}, which calibrate does not have",
            "known: every",
        ),
        (
            "trace",
            "(ONLY A COMMENT)",
            "SET033",
            "is no block: it holds no words",
            "write one block a line, as in a program",
        ),
        (
            "trace",
            "G65 P1 (\u00dc)",
            "SET033",
            "is no block: it holds characters that no control reads",
            "write one block a line, as in a program",
        ),
        (
            "trace",
            "G65 P1 T5 M6",
            "SET036",
            "calls a tool, and nothing gives back what was before it",
            "do that in the macro that is called, which gives it back",
        ),
        (
            "trace",
            "O77",
            "SET036",
            "begins a program, and nothing gives back what was before it",
            "do that in the macro that is called, which gives it back",
        ),
        (
            "trace",
            f"G65 P1 ({'X' * 71})",
            "SET034",
            "can become 80 characters long, the limit is 79",
            "split it into two blocks",
        ),
    ],
)
def test_of_a_block_that_cannot_be_used_all_is_said(
    kind: str, block: str, code: str, said: str, help_text: str
) -> None:
    options = (f'calls.a={{{kind}="{block}"}}', "checks.calls=a", "control.max_line_chars=79")
    wanted = (code, f'calls.a.{kind}: "{block}" {said}', help_text)
    assert refusal("fanuc-mill", *options, name="a") == wanted


# The longest text of each field: tools of 2 m and eight digits, lengths to 0.0001 mm, W to a millionth.
LONGEST = {
    **dict.fromkeys(("tool", "sister"), 8),
    **dict.fromkeys(("limit", "limit_mm", "height", "height_mm"), 9),
    **dict.fromkeys(("diameter", "diameter_mm", "length", "length_mm", "holder", "holder_mm"), 9),
    **dict.fromkeys(("tip", "corner_radius", "corner_radius_mm"), 8),
    **{"speed_rpm": 6, "every": 4, "depth": 1, "depth_signed": 2, "operation": 11, "type": 18, "kind": 1},
    **{"teeth": 2, "helix": 6, "point": 6},
}


@pytest.mark.parametrize("field", LONGEST)
def test_a_block_may_become_as_long_as_its_longest_value(field: str) -> None:
    block = f"G65 P1 (({'X' * 60}) ({{{field}}} {{{field}}})"
    options = (f'calls.a={{trace="{block}"}}', "checks.calls=a", "control.max_line_chars=60")
    long = len(block) - 2 * len(f"{{{field}}}") + 2 * LONGEST[field]
    assert refusal("fanuc-mill", *options, name="a")[1].endswith(
        f"can become {long} characters long, the limit is 60"
    )


def test_the_speed_of_a_lathe_is_no_field() -> None:
    options = ('calls.a={trace="G65 P1 S{speed_rpm}"}', "checks.calls=a")
    assert refusal("fanuc-lathe", *options, name="a") == (
        "SET032",
        'calls.a.trace: "G65 P1 S{speed_rpm}": S of a lathe turns the workpiece, not the tool',
        "write the speed of a driven tool as a number",
    )
    check_blocks("a", chipbreak.load("fanuc-mill", options))


def test_a_check_that_is_none_is_refused_by_its_name() -> None:
    assert refusal("fanuc-mill", 'calls.a={chip_chek="G65 P1"}', "checks.calls=a", name="a") == (
        "SET031",
        "calls.a.chip_chek: there is no such check",
        "did you mean chip_check?",
    )


@pytest.mark.parametrize(
    ("safe_z", "is_refused"), [("-10", False), ("-299.5", False), ("-300", True), ("-301", True)]
)
def test_a_plate_lies_below_the_safe_height(safe_z: str, is_refused: bool) -> None:
    plate = [f"macros.{key}={value}" for key, value in zip(KEYS, ("1", "2", "-300", safe_z), strict=True)]
    settings = chipbreak.load("grbl", ["checks.calls=setter", *plate])
    if not is_refused:
        assert calls_of(settings).name == "setter"
        return
    with pytest.raises(RefusalError) as caught:
        calls_of(settings)
    assert (caught.value.code, caught.value.message) == (
        "SET037",
        f"macros.safe_z_mm ({safe_z}) is not above macros.setter_z_mm (-300)",
    )
    assert caught.value.help == (
        "setter_z_mm is the lowest Z of the spindle nose at which a tool must have met the plate"
    )
