"""JSON files: read without a traceback, and the line of a value for messages."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Any

from chipbreak.tools.data import NO_FORMAT, Errors
from chipbreak.tools.ways_out import EXPORT_AGAIN, IS_IT_THE_RIGHT_FILE

_DECODER = json.JSONDecoder()
_GAP = re.compile(r"[\s,:]*")


def load_json(errors: Errors) -> Any:
    """The value of a JSON text.  Raises ToolFileError."""
    try:
        return _DECODER.decode("\n".join(errors.lines))
    except json.JSONDecodeError as error:
        message = f"this is not JSON: {error.msg.lower()}"
        errors.stop(NO_FORMAT, message, EXPORT_AGAIN, error.lineno, (error.colno - 1, error.colno))
    except (ValueError, RecursionError):  # numbers of thousands of digits, thousands of brackets
        errors.stop(NO_FORMAT, "no library is nested this deep or has such numbers", IS_IT_THE_RIGHT_FILE)


def json_line(errors: Errors, path: Sequence[str | int]) -> int:
    """The line (from 1) of the value at a path of keys and indices in a text that is valid JSON.

    Where the path ends early, the line of the last step that is there.
    """
    text = "\n".join(errors.lines)
    at = _skip(text, 0)
    for step in path:
        inside = _inside(text, at, step)
        if inside is None:
            break
        at = inside
    return text.count("\n", 0, at) + 1


def _inside(text: str, at: int, step: str | int) -> int | None:
    """Where the value of a key or an index starts in the object or array that starts at ``at``."""
    is_object = text[at] == "{"
    if is_object != isinstance(step, str):
        return None
    at = _skip(text, at + 1)
    index = 0
    found = None
    while text[at] not in "]}":
        key: Any = index
        if is_object:
            key, at = _DECODER.raw_decode(text, at)
            at = _skip(text, at)
        if key == step:
            found = at  # of a key that is there twice the last one counts
            if not is_object:
                return found
        _, at = _DECODER.raw_decode(text, at)
        at = _skip(text, at)
        index = index + 1
    return found


def _skip(text: str, at: int) -> int:
    gap = _GAP.match(text, at)
    return gap.end() if gap else at
