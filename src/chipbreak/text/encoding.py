"""What the bytes of a program mean to a person: its encoding, guessed a file at a time, for messages alone.

Inside, a program is latin-1 text, one character a byte; nothing here ever changes a byte of it.
"""

from __future__ import annotations

import codecs
import re
import unicodedata
from collections.abc import Iterator

LATIN_1, UTF_8, SHIFT_JIS = "latin-1", "utf-8", "cp932"
# So much of the lines that are not ASCII is looked at.
_MOST_BYTES = 1 << 16
# Expressions are compiled where they are used: most programs are ASCII.
_NOT_ASCII = rb"[\x80-\xff]"
_LINE_END = rb"[\r\n]"
# Two characters of two bytes in a row whose first byte no European text has side by side.
_JAPANESE = r"[\u3000-\u30ff\u4e00-\u9fff\uff01-\uff5e]{2}"
_FOREIGN_TO_JAPANESE = r"[\ue000-\uf8ff]"
_WIDE = ("W", "F")
_AS_IT_IS = "chipbreak-as-latin-1"


def _as_latin_1(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode(LATIN_1), error.end


codecs.register_error(_AS_IT_IS, _as_latin_1)


def encoding_of(data: bytes) -> str:
    """UTF_8 or SHIFT_JIS where the bytes are text of it, else LATIN_1.

    Shift-JIS takes nearly any bytes, so it must also read as Japanese: kana or kanji side by side.
    """
    if data.isascii():
        return LATIN_1
    sample = bytearray()
    for line in _lines_not_ascii(data):
        sample += line + b"\n"
        if len(sample) > _MOST_BYTES:
            break
    if _reads(sample, UTF_8) is not None:
        return UTF_8
    japanese = _reads(sample, SHIFT_JIS) or ""
    is_japanese = re.search(_JAPANESE, japanese) and not re.search(_FOREIGN_TO_JAPANESE, japanese)
    return SHIFT_JIS if is_japanese else LATIN_1


def _lines_not_ascii(data: bytes) -> Iterator[bytes]:
    """The lines with such a byte; each byte of the others is looked at once."""
    behind = 0
    while found := re.compile(_NOT_ASCII).search(data, behind):
        begin = max(data.rfind(end, behind, found.start()) + 1 for end in (b"\r", b"\n"))
        end = re.compile(_LINE_END).search(data, found.end())
        yield data[max(begin, behind) : end.start() if end else len(data)]
        behind = end.end() if end else len(data)


def _reads(data: bytes | bytearray, encoding: str) -> str | None:
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return None


def meant(text: str, encoding: str) -> str:
    """Latin-1 text of a program as its encoding means it; what does not belong to it stays as it is."""
    if encoding == LATIN_1 or text.isascii():
        return text
    try:
        return text.encode(LATIN_1).decode(encoding, _AS_IT_IS)
    except UnicodeEncodeError:  # not of a program
        return text


def escaped(text: str) -> str:
    """Text that a terminal shows and does not obey: ``\\x1b`` for what cannot be printed."""
    return text if text.isprintable() else "".join(map(_escaped, text))


def _escaped(character: str) -> str:
    if character.isprintable():
        return character
    number = ord(character)
    return f"\\x{number:02x}" if number <= 0xFF else f"\\u{number:04x}"


def cells(text: str) -> int:
    """How many columns of a terminal a text takes."""
    if text.isascii():
        return len(text)
    return sum(1 + (unicodedata.east_asian_width(c) in _WIDE) for c in text if not unicodedata.combining(c))
