"""What the sections about tool checks must keep to beyond each value by itself."""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.dialects.check_programs import LINES
from chipbreak.settings.checking import IMPOSSIBLE, Layer
from chipbreak.settings.sections import LEAST_STORE, Checks, Macros

_LONGEST_BLOCK = 72


def check_macros(layer: Layer, macros: Macros, dialect: Dialect) -> None:
    """What one key of [macros] alone does not say."""
    for rule in (_check_orient, _check_blocks, _check_gap, _check_room, _check_store, _check_working):
        rule(layer, macros, dialect)


def _check_orient(layer: Layer, macros: Macros, _: Dialect) -> None:
    if "{angle}" not in macros.orient or set("{}") & set(macros.orient.replace("{angle}", "")):
        message = f'macros.orient = "{macros.orient}": its one field is {{angle}}'
        raise layer.fail(IMPOSSIBLE, "macros.orient", message, 'for example "M19 R{angle}"')


def _check_blocks(layer: Layer, macros: Macros, _: Dialect) -> None:
    for key in ("orient", *LINES):
        for text in getattr(macros, key).split("\n"):
            if not _is_readable(text):
                message = f'macros.{key}: "{text}" is no block that a control can read'
                help_text = f"plain letters and digits, {_LONGEST_BLOCK} at most"
                raise layer.fail(IMPOSSIBLE, f"macros.{key}", message, help_text)


def _check_gap(layer: Layer, macros: Macros, _: Dialect) -> None:
    if macros.gap_ms and not macros.gap_on:
        message = f"macros.gap_ms = {macros.gap_ms:g}, and macros.gap_on does not say what starts it"
        help_text = "write the blocks that let the barrier look for a missing edge, or leave gap_ms out"
        raise layer.fail(IMPOSSIBLE, "macros.gap_ms", message, help_text)


def _check_working(layer: Layer, macros: Macros, dialect: Dialect) -> None:
    """The variables in which the programs work, and those in which they keep values."""
    working = dialect.macros.working if dialect.macros else range(0)
    last = macros.first_variable + len(working) - 1
    if working and last >= macros.store_first and macros.first_variable <= macros.store_last:
        message = (
            f"macros.first_variable = {macros.first_variable}: the macros work in #{macros.first_variable}"
        )
        message += f" to #{last}, and store_first = {macros.store_first}"
        help_text = "let them lie apart from store_first to store_last"
        raise layer.fail(IMPOSSIBLE, "macros.first_variable", message, help_text)


def _is_readable(text: str) -> bool:
    return not text or (text.isascii() and text.isprintable() and len(text) <= _LONGEST_BLOCK)


def _check_room(layer: Layer, macros: Macros, _: Dialect) -> None:
    if macros.store_last < macros.store_first + LEAST_STORE:
        message = f"macros.store_last = {macros.store_last} leaves no room after store_first"
        help_text = f"at least {LEAST_STORE}: a tool takes 12 variables, and its teeth times its heights"
        raise layer.fail(IMPOSSIBLE, "macros.store_last", message, help_text)


def _check_store(layer: Layer, macros: Macros, dialect: Dialect) -> None:
    kept = dialect.kept_variables
    if kept and not any(a <= macros.store_first and macros.store_last <= b for a, b in kept):
        message = f"macros.store_first = {macros.store_first}, store_last = {macros.store_last} cannot be"
        ranges = ", or ".join(f"{first} to {last}" for first, last in kept)
        raise layer.fail(IMPOSSIBLE, "macros.store_first", message, f"this control keeps values in {ranges}")


def check_sisters(layer: Layer, checks: Checks) -> None:
    """A tool cannot take its own place."""
    for tool, sister in checks.sister.items():
        if int(tool) == sister:
            message = f"checks.sister.{tool} = {sister}: a tool is no sister of its own"
            raise layer.fail(IMPOSSIBLE, f"checks.sister.{tool}", message, "name another tool, or none")
