"""Profiles and files of tools may come from anywhere: nothing of them is run, and all of them have an end."""

from __future__ import annotations

import io
import json
import os
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

import chipbreak
from chipbreak.machine_files.fanuc_parameters import machine_of_parameters
from chipbreak.machine_files.linuxcnc_ini import machine_of_ini
from chipbreak.settings import SettingsError
from chipbreak.text.bounds import read_bounded
from chipbreak.text.diagnostics import RefusalError
from chipbreak.tools.data import MOST_BYTES, ToolFileError
from chipbreak.tools.files import read_bytes, read_tools

MEGABYTE = 1 << 20
HEADER = "number,type,teeth,diameter_mm,length_mm\n"
FUSION = '{"unit":"millimeters","type":"drill","post-process":{"number":%d},"geometry":{"DC":5,"NOF":2}}'


def many(text: str, size: int, joint: str = "") -> str:
    """So many bytes of it, numbered."""
    return joint.join(text % number for number in range(1, size // len(text)))


@cache
def large(size: int) -> dict[str, str]:
    """Files of so many bytes."""
    return {
        "rows.csv": HEADER + many("%d,flat end mill,4,12,38\n", size),
        "commas.csv": "," * size,
        "cells.csv": HEADER + "," * size,
        "quotes.csv": HEADER + '"' * size,
        "blanks.csv": HEADER + " ," * (size // 2),
        "tools.toml": many('[[tool]]\nnumber = %d\ntype = "drill"\nteeth = 2\n', size),
        "keys.toml": "[[tool]]\n" + many("a%d = 1\n", size),
        "dots.toml": "a" + ".a" * (size // 2) + " = 1\n",
        "nested.toml": "a = " + "[" * size,
        "inline.toml": "a = " + "{a = " * (size // 5),
        "lines.toml": many("a = [[[[[[[%d\n", size),
        "nested.json": "[" * size,
        "objects.json": '{"data":' * (size // 8),
        "number.json": '{"data":[{"post-process":{"number":' + "9" * size + "}}]}",
        "tools.json": '{"data":[' + many(FUSION, size, ",") + "]}",
        "wrong.json": '{"data":[' + many("%d", size, ",") + "]}",
        "lines.tbl": many("T%d P1 D5.0 Z1.0 ;drill\n", size),
        "words.tbl": "T1 " + many("D%d ", size),
        "blanks.tbl": " " * size + "T1",
        "digits.tbl": "T" + "1" * size,
        "bits.fctl": '{"tools":[' + many('{"nr":%d,"path":"x.fctb"}', size, ",") + "]}",
    }


@pytest.mark.parametrize("name", large(1))
@pytest.mark.parametrize("size", [MEGABYTE // 4, pytest.param(MEGABYTE, marks=pytest.mark.long)])
def test_a_megabyte_of_anything_is_read_or_refused_soon(size: int, name: str) -> None:
    data = large(size)[name].encode()
    begin_s = time.process_time()
    try:
        assert read_tools(name, data)
    except ToolFileError as error:
        assert all(len(said.render()) < 1000 for said in error.diagnostics)
    # A quarter of a second to two for a megabyte; without the bounds minutes.
    assert time.process_time() - begin_s < 8.0 * size / MEGABYTE


def bomb(members: int, size: int) -> bytes:
    """A zip of libraries that are all blanks."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for number in range(members):
            file.writestr(f"{number}.json", b" " * size)
    return packed.getvalue()


@pytest.mark.parametrize(("members", "size"), [(3, MOST_BYTES // 2), (1, MOST_BYTES + 1), (2000, 1)])
def test_a_zip_that_unpacks_to_more_than_a_library(members: int, size: int) -> None:
    data = bomb(members, size)
    assert len(data) < MEGABYTE
    tracemalloc.start()
    with pytest.raises(ToolFileError, match="larger than any library"):
        read_tools("a.tools", data)
    assert tracemalloc.get_traced_memory()[1] < 3 * MOST_BYTES
    tracemalloc.stop()


def test_a_name_in_a_zip_leads_nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as file:
        file.writestr("../../outside.json", '{"data":[' + FUSION % 1 + "]}")
    (tmp_path / "in").mkdir()
    monkeypatch.chdir(tmp_path / "in")
    (tool,) = read_tools("a.tools", packed.getvalue())
    assert tool.number == 1
    assert [path.name for path in tmp_path.rglob("*")] == ["in"]


def test_a_library_makes_nobody_read_other_files(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("not to be shown")
    data = json.dumps({"tools": [{"nr": 1, "path": str(secret)}]}).encode()
    with pytest.raises(ToolFileError, match="it is no tool bit") as caught:
        read_tools(str(tmp_path / "a.fctl"), data)
    assert "not to be shown" not in caught.value.diagnostics[0].render()


@pytest.mark.parametrize("read", [read_bytes, machine_of_ini, machine_of_parameters, chipbreak.load])
def test_a_pipe_is_not_waited_for(read: Callable[[str], object], tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.toml")
    with pytest.raises((ToolFileError, SettingsError, RefusalError), match=r"it is no file|cannot be read"):
        read(str(tmp_path / "a.toml"))


def test_a_file_without_end_and_a_large_one(tmp_path: Path) -> None:
    (tmp_path / "large").write_bytes(b" " * (MEGABYTE + 1))
    with pytest.raises(OSError, match="it is larger than 1 MB"):
        read_bounded(tmp_path / "large", MEGABYTE)
    with pytest.raises(OSError, match="it is no file"):
        read_bounded(Path("/dev/zero"), MEGABYTE)
    with pytest.raises(IsADirectoryError):
        read_bounded(tmp_path, MEGABYTE)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 1\n" * (5 * MEGABYTE // 6), "larger than 4 MB"),
        ("a." * MEGABYTE + "a = 1\n", "line 1 has more than 10000 characters"),
        ("a = [" + "\n[" * 100_000, "nested too deeply"),
    ],
)
def test_a_profile_that_is_none(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(SettingsError, match=said):
        chipbreak.load(tmp_path / "a.toml")


def test_bases_of_bases_have_an_end(tmp_path: Path) -> None:
    for number in range(2000):
        (tmp_path / f"{number}.toml").write_text(f'base = "{number + 1}.toml"\n')
    with pytest.raises(SettingsError, match="bases of bases are too many"):
        chipbreak.load(tmp_path / "0.toml")


def test_included_files_have_an_end(tmp_path: Path) -> None:
    for number in range(20):
        (tmp_path / f"{number}.ini").write_text(f"#INCLUDE {number + 1}.ini\n#INCLUDE {number + 1}.ini\n")
    with pytest.raises(RefusalError, match="includes itself"):
        machine_of_ini(tmp_path / "0.ini")
    # As often as there are lines, without going deep.
    (tmp_path / "wide.ini").write_text("#INCLUDE one.ini\n" * 100_000)
    (tmp_path / "one.ini").write_text("[TRAJ]\nLINEAR_UNITS = mm\n")
    with pytest.raises(RefusalError, match="includes itself"):
        machine_of_ini(tmp_path / "wide.ini")


def test_a_number_of_thousands_of_digits_is_no_number(tmp_path: Path) -> None:
    number = "9" * 6000
    file = tmp_path / "a.toml"
    file.write_text(f"vibration.n = {number}")
    for profile, sets in ((file, []), ("fanuc-lathe", [f"control.lathe_system={number}"])):
        with pytest.raises(chipbreak.SettingsError):
            chipbreak.load(profile, sets)
    with pytest.raises(chipbreak.ToolFileError):
        read_tools("a.toml", f"[[tool]]\nnumber = {number}".encode())
