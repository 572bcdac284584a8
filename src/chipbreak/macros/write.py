"""The files of one control: the programs that never change, and those written from the settings."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources

from chipbreak.dialects import DIALECTS, Dialect, MacroSet
from chipbreak.dialects.check_programs import LINES, PROBE_MAKERS
from chipbreak.macros.parameters import MacroSettings
from chipbreak.settings.axis_words import AxisWords
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.named_tuple import NamedTuple

NO_MACROS = "MCR004"
MAKERS_NUMBERS = "MCR005"
_DECIMALS = 4
# Behind the stored edges: the count of workpieces, and ten locked tools.
_KEPT = 11


class _Variable(NamedTuple):
    """A setting: the number and the name of its variable, its key in a profile, and what it is."""

    number: int
    key: str
    name: str
    title: str


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
    (149, "bar_within_mm", "bar_within", "MASTER BAR WITHIN, THICKNESS"),
    (151, "settle_s", "settle", "SECONDS UNTIL THE SIGNAL IS OFF"),
    (152, "beam_within_mm", "beam_within", "BEAM WITHIN"),
    (153, "trace_chip_mm", "trace_chip", "NO CHIP AS LONG AS THIS IS MISSED"),
    (154, "gap_s", "gap", "SECONDS TO A MISSING EDGE, 0: CANNOT"),
    (160, "setter_x_mm", "setter_x", "MACHINE X OF THE TOUCH PLATE"),
    (161, "setter_y_mm", "setter_y", "MACHINE Y OF THE TOUCH PLATE"),
    (162, "setter_z_mm", "setter_z", "LOWEST Z OVER THE TOUCH PLATE"),
    (157, "approach_feed", "approach_feed", "FEED FROM THE SAFE HEIGHT"),
    (172, "pulled_mm", "pulled", "A KNOWN TOOL HANGS AT MOST SO MUCH LOWER"),
    (156, "gate_output", "gate", "LINUXCNC: OUTPUT THAT SHOWS THE BEAM"),
    (159, "inch_step_mm", "inch_step", "LEAST STEP IN INCHES, IN MM"),
)


def macro_files(dialect: Dialect, settings: MacroSettings) -> dict[str, bytes]:
    """The macro programs of a control by file name.

    Raises UnsetError (MCR001) for settings that lack something, and RefusalError MCR004 for a dialect without
    macros.
    """
    macros = dialect.macros
    if macros is None:
        message = f"there are no macros for the dialect {dialect.name}"
        known = " and ".join(other.name for other in DIALECTS if other.macros is not None)
        raise RefusalError(NO_MACROS, message, f"there are some for {known}")
    parts = _parts(macros, settings.checked())
    folder = resources.files("chipbreak") / "macros" / str(macros.folder)
    fixed = (file for file in folder.iterdir() if file.name.endswith((".nc", ".ngc")))
    files = {file.name: file.read_bytes().decode("ascii") for file in fixed}
    for name, template in macros.written.items():
        lines = [line for text in template for line in parts.get(text, [text])]
        files[name] = "\n".join([*lines, ""])

    def moved(text: str) -> str:
        return macros.moved(text, settings.first_program, settings.first_variable)

    return {
        moved(name): macros.frame.format(program=moved(files[name])).encode("ascii") for name in sorted(files)
    }


def foreign_files(macros: MacroSet, existing: Mapping[str, bytes]) -> list[str]:
    """The names of those files that another hand has written, sorted."""
    return sorted(name for name, data in existing.items() if macros.mark.encode() not in data)


def makers_numbers(dialect: Dialect, first_program: int) -> Diagnostic | None:
    """A warning where the programs lie among those of probe makers, None where they do not."""
    count = len(dialect.macros.numbers) if dialect.macros else 0
    ours = range(first_program, first_program + count)
    makers = [maker for maker, theirs in PROBE_MAKERS.items() if any(one in theirs for one in ours)]
    if not makers:
        return None
    message = f"O{ours[0]} to O{ours[-1]} are also numbers of programs of {', '.join(makers)}"
    help_text = "look whether they are on the control, or choose others with macros.first_program"
    return Diagnostic(MAKERS_NUMBERS, Severity.WARNING, message, help_text)


def check_axes(words: AxisWords) -> None:
    """Raise RefusalError MCR004 where the axes of a profile are not those that the macros command."""
    for axis, letter in words.letters.items():
        if letter != axis or words.signs[axis] != 1:
            message = f"the macros move {axis} by {axis} words with the tool; this profile says otherwise"
            raise RefusalError(NO_MACROS, message, "give calls to macros of your own under [calls]")


def _parts(macros: MacroSet, settings: MacroSettings) -> dict[str, list[str]]:
    """The lines of the profile for each mark in a program that the settings make."""
    return {
        "{settings}": [
            _setting(macros, settings, variable)
            for variable in (_Variable(*one) for one in _NUMBERED)
            if getattr(settings, variable.key) is not None
        ],
        "{orient}": [settings.orient.format(angle=macros.angle)],
    } | {f"{{{key}}}": getattr(settings, key).splitlines() for key in LINES}


def _setting(macros: MacroSet, settings: MacroSettings, variable: _Variable) -> str:
    value = getattr(settings, variable.key)
    if variable.key == "store_last":
        value -= _KEPT
    if variable.key == "beam_input" and value < macros.first_signal:
        value += macros.first_signal
    text = print_number(float(value), _DECIMALS, point=not isinstance(value, int))
    return macros.setting.format(
        number=variable.number,
        name=variable.name,
        value=text,
        title=variable.title,
        small_title=variable.title.lower(),
    )
