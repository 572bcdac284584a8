"""Limits of a section that must leave something between them."""

from __future__ import annotations

import re
from collections.abc import Mapping

from chipbreak.dialects.base import Dialect
from chipbreak.settings.checking import IMPOSSIBLE, Layer, hint_at
from chipbreak.settings.sections import OPERATION_KINDS, Axis, Command, Planner, Spindle, Vibration


def check_ranges(layer: Layer, command: Command, spindle: Spindle) -> None:
    """A control can command a frequency, and its spindle a speed."""
    for key in ("multiples", "periods_ms"):
        if getattr(command, key) == ():
            message = f"command.{key} = []: so no frequency can be commanded"
            raise layer.fail(IMPOSSIBLE, f"command.{key}", message, "name one or more, or leave it out")
    if command.max_multiple is not None and command.max_multiple < command.min_multiple:
        message = f"command.max_multiple = {command.max_multiple} lies below min_multiple"
        hint = f"{command.min_multiple} or more, or another command.min_multiple"
        raise layer.fail(IMPOSSIBLE, "command.max_multiple", message, hint)
    if spindle.max_rpm is not None and spindle.max_rpm < spindle.min_rpm:
        message = f"spindle.max_rpm = {spindle.max_rpm:g} lies below min_rpm"
        hint = f"{spindle.min_rpm:g} or more, or another spindle.min_rpm"
        raise layer.fail(IMPOSSIBLE, "spindle.max_rpm", message, hint)


def check_only(layer: Layer, vibration: Vibration) -> None:
    """``vibration.only`` names kinds of operations, and tools as T and a number."""
    for name in vibration.only:
        if name not in OPERATION_KINDS and not re.fullmatch(r"T[1-9][0-9]*", name):
            message = f'vibration.only: "{name}" is no kind of operation and no tool'
            hint = hint_at(name, OPERATION_KINDS)
            raise layer.fail(IMPOSSIBLE, "vibration.only", message, f'{hint}; a tool is "T3"')


def check_filters(layer: Layer, axes: Mapping[str, Axis]) -> None:
    """A bell has two times, and no other filter has the second."""
    for name, axis in axes.items():
        if axis.acc_dec == "bell" and (axis.bell_ms is None or axis.acc_dec_ms is None):
            missing = "bell_ms" if axis.bell_ms is None else "acc_dec_ms"
            message = f'axes.{name}.acc_dec = "bell" has two times, and {missing} is not given'
            raise layer.fail(IMPOSSIBLE, f"axes.{name}.acc_dec", message, f"give axes.{name}.{missing}")
        if axis.bell_ms is not None and axis.acc_dec == "exponential":
            message = f"axes.{name}.bell_ms has no place beside exponential acc/dec"
            hint = f'axes.{name}.acc_dec = "bell", or leave it out'
            raise layer.fail(IMPOSSIBLE, f"axes.{name}.bell_ms", message, hint)


def check_steps(layer: Layer, axes: Mapping[str, Axis]) -> None:
    """The step of an axis is said in one way."""
    for name, axis in axes.items():
        if axis.increment_mm is not None and axis.steps_per_mm is not None:
            message = f"axes.{name} has increment_mm and steps_per_mm, which say the same"
            raise layer.fail(IMPOSSIBLE, f"axes.{name}.steps_per_mm", message, "give one of them")


# End and return of programs, calls: no control has another use for them.
_OTHER_USES = frozenset({30, 98, 99})
# Another block would change what the cut meets: M50 P0, or a variable of the control.
_HOLDS_OVERRIDE = re.compile(r"M([0-9]{2,3})(?: *[PQ] *[0-9.]+)?|#[0-9]{4,}=[0-9.]+", re.IGNORECASE)


def check_override(layer: Layer, planner: Planner, dialect: Dialect) -> None:
    """What takes the feed override from the operator gives it back, and does nothing else."""
    for key, other in (("override_off", "override_on"), ("override_on", "override_off")):
        for text in filter(None, getattr(planner, key)):
            if not _holds_override(text, dialect):
                message = f"planner.{key}: {text!r} is no block that holds overrides or gives them back"
                hint = 'an M code, such as "M50 P0", or a variable of the control, such as "#3004=2"'
                raise layer.fail(IMPOSSIBLE, f"planner.{key}", message, hint)
        if any(getattr(planner, key)) and not any(getattr(planner, other)):
            message = f"planner.{key} = {list(getattr(planner, key))!r} without {other}"
            hint = 'give both, on LinuxCNC "M50 P0" and "M50 P1", or neither'
            raise layer.fail(IMPOSSIBLE, f"planner.{key}", message, hint)


def _holds_override(text: str, dialect: Dialect) -> bool:
    found = _HOLDS_OVERRIDE.fullmatch(text)
    if found is None or not found[1]:
        return found is not None and bool(dialect.place_variables)  # it has variables
    number = int(found[1])
    code = dialect.m_codes.get(number)
    return number not in _OTHER_USES and (code is None or code.group == "override")
