"""What the sections about tool checks must keep to beyond each value by itself."""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.settings.checking import IMPOSSIBLE, Layer
from chipbreak.settings.sections import LEAST_STORE, Checks, Macros


def check_macros(layer: Layer, macros: Macros, dialect: Dialect) -> None:
    """What one key of [macros] alone does not say."""
    if "{angle}" not in macros.orient or set("{}") & set(macros.orient.replace("{angle}", "")):
        message = f'macros.orient = "{macros.orient}": its one field is {{angle}}'
        raise layer.fail(IMPOSSIBLE, "macros.orient", message, 'for example "M19 R{angle}"')
    for key in ("orient", "laser_on", "laser_off"):
        for text in getattr(macros, key).split("\n"):
            if not (text.isascii() and (text.isprintable() or not text)) or len(text) > 72:
                message = f'macros.{key}: "{text}" is no block that a control can read'
                raise layer.fail(IMPOSSIBLE, f"macros.{key}", message, "plain letters and digits, 72 at most")
    if macros.store_last < macros.store_first + LEAST_STORE:
        message = f"macros.store_last = {macros.store_last} leaves no room behind store_first"
        help_text = f"at least {LEAST_STORE}: a tool takes 12 variables, and its teeth times its heights"
        raise layer.fail(IMPOSSIBLE, "macros.store_last", message, help_text)
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
