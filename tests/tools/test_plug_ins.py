"""Readers of tool files that other packages bring, installed as such a package is."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from chipbreak.tools.data import ToolFileError
from chipbreak.tools.files import read_tools
from chipbreak.tools.plug_ins import GROUP
from chipbreak.tools.readers import READERS

READER = """
from chipbreak.tools.data import Errors, ToolData
from chipbreak.tools.reader import ToolReader

def read(data, name, unit):
    number, diameter = data.split()
    if number == b"0":
        Errors(name).stop("TOL005", "tool 0 is none", "write its number")
    values = {"diameter_mm": float(diameter) * unit.mm}
    return [ToolData.said(int(number), f"{name}, {unit.origin}", values)]

READER = ToolReader((".shop",), read)
"""
Install = Callable[..., None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Puts a package with a reader where Python finds it."""
    monkeypatch.syspath_prepend(tmp_path)

    def put(source: str, name: str = "presetter", value: str = "READER") -> None:
        module = f"chipbreak_test_{name}"
        monkeypatch.delitem(sys.modules, module, raising=False)
        (tmp_path / f"{module}.py").write_text(source)
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: shop-{name}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[{GROUP}]\n{name} = {module}:{value}\n")

    return put


def refusal(name: str, data: bytes) -> str:
    with pytest.raises(ToolFileError) as caught:
        read_tools(name, data)
    (found,) = caught.value.diagnostics
    return f"{found.code} {found.message}; {found.help}"


def test_a_reader_of_another_package(install: Install) -> None:
    install(READER)
    (tool,) = read_tools("Magazine.SHOP", b"7 0.5", (25.4, "inches, as a test says"))
    assert (tool.number, tool.diameter_mm) == (7, 12.7)
    assert tool.origins == {"diameter_mm": "Magazine.SHOP, inches, as a test says"}
    assert refusal("a.shop", b"0 5").startswith("TOL005 a.shop: tool 0 is none")


def test_a_reader_may_know_a_file_by_its_bytes(install: Install) -> None:
    install(
        READER.replace('ToolReader((".shop",), read)', "ToolReader((), read, lambda d, n: d[:1] == b'7')")
    )
    assert [tool.number for tool in read_tools("magazine", b"7 12")] == [7]
    assert refusal("magazine", b"8 12").startswith("TOL002")


def test_our_own_readers_come_first(install: Install) -> None:
    install("raise RuntimeError('nobody asked')".replace("'", '"'))
    for suffix in (suffix for reader in READERS for suffix in reader.suffixes):
        try:
            read_tools(f"a{suffix}", b"")
        except ToolFileError as error:
            assert "TOL011" not in {found.code for found in error.diagnostics}


def test_its_suffix_is_named_among_those_that_are_read(install: Install) -> None:
    install(READER)
    assert refusal("a.xyz", b"").endswith("known: .csv, .toml, .json, .tools, .fctl, .tbl, .shop")


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("READER = 5", "TypeError: chipbreak_test_presetter:READER is no ToolReader"),
        ("", "AttributeError: module 'chipbreak_test_presetter' has no attribute 'READER'"),
        (READER.replace("int(number)", "int(no)"), "NameError: name 'no' is not defined"),
        (READER.replace("return [", "return [5, "), "TypeError: it gave something else than ToolData"),
        (
            READER.replace('(".shop",)', "5"),
            "TypeError: endswith first arg must be str or a tuple of str, not int",
        ),
    ],
    ids=["import", "no reader", "no name", "read", "result", "suffixes"],
)
def test_a_broken_plug_in_is_named(source: str, why: str, install: Install) -> None:
    install(source)
    said = refusal("a.shop", b"7 12")
    name = 'the tool reader "presetter" of the package shop-presetter'
    assert said.startswith(f"TOL011 a.shop: {name} fails: {why}")
    assert said.endswith("; update or remove that package, or give the tools as CSV")


def test_a_broken_plug_in_does_not_stop_another_one(install: Install) -> None:
    install("import no_such_module", "broken")
    install(READER)
    assert [tool.number for tool in read_tools("a.shop", b"7 12")] == [7]
    assert refusal("a.xyz", b"").startswith('TOL011 a.xyz: the tool reader "broken"')
