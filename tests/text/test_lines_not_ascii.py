"""The lines by which the encoding of a program is guessed."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st

from chipbreak.text.encoding import _lines_not_ascii

PIECES = st.lists(st.sampled_from([b"G1 X1.", b"\r\n", b"\r", b"\n", b"\x8e\xb2", "ü".encode(), b" ", b"("]))


@given(PIECES)
def test_they_are_all_lines_that_are_not_ascii(pieces: list[bytes]) -> None:
    data = b"".join(pieces)
    assert list(_lines_not_ascii(data)) == [line for line in re.split(rb"[\r\n]", data) if not line.isascii()]
