"""Any bytes are a file of tools or an error about it, never a traceback."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from chipbreak.tools.data import ToolData, ToolFileError
from chipbreak.tools.files import read_tools
from chipbreak.tools.freecad import read_library_with
from chipbreak.tools.lists import read_traces
from chipbreak.tools.readers import READERS

CSV = "number,type,teeth,diameter_mm,length_mm,corner_radius_mm,helix_deg,name"
SEEDS = [
    CSV,
    '[[tool]]\nnumber = 3\ntype = "drill"\n',
    "T1 P1 D12. Z-3 Q3 ;4 FLUTE END MILL",
    "tooth,height_mm,radius_mm",
    "1,drill,2,6.8,40,0,30,x",
    '{"data": [{"unit": "inches", "geometry": {"DC": 1e999}, "post-process": {"number": 1}}]}',
    "PK\x03\x04",
    '{"tools": [{"nr": 1, "path": "a"}]}',
]
PIECES = st.sampled_from([*SEEDS, *'[]{}",;\t\r\n\0=#()+-.', "1e999", "NaN", "\ufeff", "9" * 5000, "ß", '""'])
TEXTS = st.lists(PIECES | st.text(max_size=8), max_size=12).map("".join).map(str.encode)
JUNK = st.binary(max_size=60) | TEXTS
VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=6),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)


def survives(read: Callable[[], list[ToolData]]) -> None:
    """Tools whose numbers are numbers, or an error that renders."""
    try:
        tools = read()
    except ToolFileError as error:
        assert error.diagnostics
        for found in error.diagnostics:
            assert found.render()
            assert found.code.startswith("TOL")
        return
    for tool in tools:
        known = tool.known()
        assert set(known) == set(tool.origins)
        for value in known.values():
            assert isinstance(value, str) or math.isfinite(value)


@pytest.mark.parametrize("suffix", [*(s for reader in READERS for s in reader.suffixes), ".fctb"])
@given(data=JUNK)
@example(data=b"[" * 100_000)
@example(data=b'{"data":' * 50_000)
@example(data=b'{"data": [' + b"9" * 9000 + b"]}")
@example(data=b"a = " + b"[" * 20_000)
@example(data=b"PK\x05\x06" + b"\0" * 18)
def test_any_bytes(suffix: str, data: bytes) -> None:
    survives(lambda: read_tools(f"x{suffix}", data))


@pytest.mark.few(50)
@given(
    entry=st.dictionaries(
        st.sampled_from(["type", "unit", "geometry", "post-process", "description"]), VALUES
    )
)
def test_any_library_of_fusion(entry: dict[str, object]) -> None:
    whole = {"unit": "inches", "post-process": {"number": 1}, **entry}
    survives(lambda: read_tools("x.json", json.dumps({"data": [whole, entry]}, indent=1).encode()))


@pytest.mark.few(50)
@given(dc=VALUES, nof=VALUES, number=VALUES)
def test_any_values_of_fusion(dc: object, nof: object, number: object) -> None:
    entry = {"unit": "inches", "geometry": {"DC": dc, "NOF": nof}, "post-process": {"number": number}}
    survives(lambda: read_tools("x.json", json.dumps({"data": [entry]}).encode()))


@pytest.mark.few(50)
@given(
    number=VALUES, path=VALUES, parameters=st.dictionaries(st.sampled_from(["Diameter", "Flutes"]), VALUES)
)
def test_any_bit_of_freecad(number: object, path: object, parameters: dict[str, object]) -> None:
    bit = json.dumps({"parameter": parameters, "shape": "drill"}).encode()
    library = json.dumps({"tools": [{"nr": number, "path": path}, {"nr": 1, "path": "a"}]}).encode()
    survives(lambda: read_library_with("x.fctl", library, lambda _: bit))


@pytest.mark.few(50)
@given(data=JUNK)
def test_any_bit_bytes(data: bytes) -> None:
    library = b'{"tools": [{"nr": 1, "path": "a"}]}'
    survives(lambda: read_library_with("x.fctl", library, lambda _: data))


@pytest.mark.few(50)
@given(
    rows=st.lists(st.lists(PIECES | st.sampled_from(["1", "2.5", "-1", "drill"]), max_size=9).map(",".join))
)
def test_any_rows(rows: list[str]) -> None:
    survives(lambda: read_tools("x.csv", "\n".join([CSV, *rows]).encode()))


@given(data=JUNK)
def test_any_trace(data: bytes) -> None:
    for prefix in (b"", b"tooth,height_mm,radius_mm\n"):
        try:
            traces = read_traces("x.csv", prefix + data)
        except ToolFileError:
            continue
        assert all(len(points) for points in traces.values())
