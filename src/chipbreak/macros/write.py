"""The files of one control: the programs that never change, and those written from the settings."""

from __future__ import annotations

from importlib import resources

from chipbreak.macros.parameters import MacroSettings
from chipbreak.settings.axis_words import AxisWords
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError

NO_MACROS = "MCR004"
_DECIMALS = 4
# Behind the stored edges: the count of workpieces, and ten locked tools.
_KEPT = 11
# The settings in the order of their variables: #120 and up on Fanuc, names on LinuxCNC.
_NUMBERED = (
    (120, "beam_x_mm", "beam_x", "MACHINE X OF THE BEAM'S FOCUS"),
    (121, "beam_y_mm", "beam_y", "MACHINE Y OF THE BEAM"),
    (122, "safe_z_mm", "safe_z", "MACHINE Z CLEAR OF EVERYTHING"),
    (123, "beam_z_mm", "beam_z", "MACHINE Z OF THE BEAM, ROUGHLY"),
    (124, "beam_input", "input", "SIGNAL OF THE BEAM, 1 = BROKEN"),
    (125, "entry_feed", "entry_feed", "FEED DOWN TO THE BEAM"),
    (126, "fast_feed", "fast_feed", "FEED OF THE FIRST TOUCH"),
    (127, "slow_feed", "slow_feed", "FEED OF THE SECOND TOUCH"),
    (128, "clear_mm", "clear", "WAITS SO FAR FROM THE BEAM"),
    (129, "back_mm", "back", "BACK BETWEEN THE TOUCHES"),
    (130, "search_mm", "search", "SEARCHES SO FAR BELOW THE TIP"),
    (131, "alarm_base", "alarm", "FIRST ALARM NUMBER"),
    (132, "retries", "retries", "MEASURES AGAIN BEFORE AN ALARM"),
    (133, "above_mm", "above", "MEASURES SO FAR ABOVE A CORNER"),
    (134, "inset_mm", "inset", "LENGTH SO FAR INSIDE THE EDGE"),
    (135, "resolution_mm", "resolution", "STEP OF A MEASURED VALUE"),
    (136, "runout_mm", "runout", "RUNOUT R' UP TO R PLUS"),
    (137, "length_over_mm", "long", "LENGTH L' UP TO L PLUS"),
    (138, "diameter_mm", "diameter", "DIAMETER WITHIN PLUS OR MINUS"),
    (139, "trace_step_mm", "step", "STEP UP THE EDGE"),
    (140, "store_last", "store_last", "LAST VARIABLE OF STORED EDGES"),
    (141, "master_length_mm", "master_length", "MASTER BAR, LENGTH A"),
    (142, "master_diameter_mm", "master_diameter", "MASTER BAR, DIAMETER"),
    (143, "master_tool", "master_tool", "MASTER BAR, TOOL NUMBER"),
    (144, "turn_sign", "turn_sign", "1 = ANGLES COUNT WITH M3"),
    (145, "store_first", "store", "FIRST VARIABLE OF STORED VALUES"),
)


def macro_files(dialect: str, settings: MacroSettings) -> dict[str, bytes]:
    """The macro programs of a dialect by file name.

    Raises UnsetError (MCR001) for settings that lack something, and RefusalError MCR004 for a dialect without
    macros.
    """
    control = dialect.partition("-")[0]
    if dialect not in ("fanuc-mill", "linuxcnc-mill"):
        message = f"there are no macros for the dialect {dialect}"
        raise RefusalError(NO_MACROS, message, "there are some for fanuc-mill and linuxcnc-mill")
    checked = settings.checked()
    folder = resources.files("chipbreak") / "macros" / control
    files = {f.name: f.read_bytes() for f in folder.iterdir() if f.name.endswith((".nc", ".ngc"))}
    written = _fanuc(checked) if control == "fanuc" else _linuxcnc(checked)
    files |= {name: text.encode("ascii") for name, text in written.items()}
    if control == "fanuc":
        # A memory card wants each program between two marks.
        files = {name: b"%\n" + data + b"%\n" for name, data in files.items()}
    return dict(sorted(files.items()))


def check_axes(words: AxisWords) -> None:
    """Raise RefusalError MCR004 where the axes of a profile are not those that the macros command."""
    for axis, letter in words.letters.items():
        if letter != axis or words.signs[axis] != 1:
            message = f"the macros move {axis} by {axis} words with the tool; this profile says otherwise"
            raise RefusalError(NO_MACROS, message, "give calls to macros of your own under [calls]")


def _value(settings: MacroSettings, key: str) -> str:
    value = getattr(settings, key)
    if key == "store_last":
        value -= _KEPT
    return print_number(float(value), _DECIMALS, point=not isinstance(value, int))


def _fanuc(settings: MacroSettings) -> dict[str, str]:
    lines = ["O9815(CHIPBREAK SETTINGS)"]
    for number, key, _, title in _NUMBERED:
        value = _value(settings, key)
        if key == "beam_input":
            value = str(settings.beam_input + (1000 if settings.beam_input < 1000 else 0))
        lines.append(f"#{number}={value}({title})")
    orient = ["O9822(CHIPBREAK ORIENT)", "(A ANGLE)", "#1=#1-FIX[#1/360.]*360."]
    orient += ["IF [#1 LT 0] THEN #1=#1+360.", settings.orient.format(angle="#1")]
    programs = {9815: lines, 9822: orient}
    programs[9823] = ["O9823(CHIPBREAK LASER ON)", *settings.laser_on.splitlines()]
    programs[9826] = ["O9826(CHIPBREAK LASER OFF)", *settings.laser_off.splitlines()]
    return {f"O{number}.nc": "\n".join([*text, "M99", ""]) for number, text in programs.items()}


def _linuxcnc(settings: MacroSettings) -> dict[str, str]:
    lines = [
        f"#<_cb_{name}> = {_value(settings, key)} ({title.lower()})" for _, key, name, title in _NUMBERED
    ]
    angle = ["#<angle> = [#1 - FIX[#1 / 360] * 360]", settings.orient.format(angle="#<angle>")]
    subs = {"settings": lines, "orient": angle}
    subs |= {"laser_on": settings.laser_on.splitlines(), "laser_off": settings.laser_off.splitlines()}
    return {
        f"cb_{name}.ngc": "\n".join([f"o<cb_{name}> sub", *text, f"o<cb_{name}> endsub", "M2", ""])
        for name, text in subs.items()
    }
