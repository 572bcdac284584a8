"""What a person is asked about a machine that has no files to read."""

from __future__ import annotations

from collections.abc import Callable

from chipbreak.machine_files.found import Found, Value
from chipbreak.settings.sections import Settings
from chipbreak.text.named_tuple import NamedTuple

_ASKED = "asked for"


class Question(NamedTuple):
    """A question, the key that it is for, and the words or the number that may be answered."""

    key: str
    text: str
    choices: tuple[str, ...] = ()
    concerns: Callable[[Settings], bool] = lambda settings: True

    @property
    def expected(self) -> str:
        """What may be answered, for a second try."""
        return f"one of {', '.join(self.choices)}" if self.choices else "a number above 0, or nothing"


def _axes(settings: Settings) -> str:
    return "XZ" if settings.control.x_diameter or "lathe" in settings.control.dialect else "XYZ"


def _turns(axis: str) -> Callable[[Settings], bool]:
    return lambda settings: axis in _axes(settings)


def _numbers_are_open(settings: Settings) -> bool:
    return len(settings.dialect.number_rules) > 1


_OF_AN_AXIS = (
    ("max_velocity_mm_min", "highest feed of {axis} [mm/min]"),
    ("max_acceleration_mm_s2", "acceleration of {axis} [mm/s2]"),
)
QUESTIONS: tuple[Question, ...] = (
    Question(
        "control.decimal_point",
        "X10 without a decimal point is 10 mm (calculator), 0.01 mm (increment), or an error (required)",
        ("calculator", "increment", "required"),
        _numbers_are_open,
    ),
    *(
        Question(f"axes.{axis}.{key}", text.format(axis=axis), (), _turns(axis))
        for axis in "XYZ"
        for key, text in _OF_AN_AXIS
    ),
    Question("spindle.max_rpm", "highest spindle speed [rpm]"),
    Question("command.base_period_ms", "shortest time in which the control takes a new target [ms]"),
)


def answer(question: Question, text: str) -> Found | None:
    """The value of an answer, None where it is none."""
    value: Value
    if question.choices:
        value = text.strip().lower()
        return Found(question.key, value, _ASKED) if value in question.choices else None
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return Found(question.key, value, _ASKED) if 0.0 < value < 1e9 else None
