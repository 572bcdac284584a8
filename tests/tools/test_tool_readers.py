"""Files of tools: what each format says, in mm, and what is refused with its line."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

from chipbreak.tools.data import ToolData, ToolFileError
from chipbreak.tools.files import read_bytes, read_tools

SAMPLES = Path(__file__).parents[2] / "samples" / "tools"
INCH = (25.4, "inches, as a test says")


def tools_of(name: str, text: str | bytes, unit: tuple[float, str] = (1.0, "mm")) -> dict[int, ToolData]:
    data = text.encode() if isinstance(text, str) else text
    return {tool.number: tool for tool in read_tools(name, data, unit)}


def sample(name: str) -> dict[int, ToolData]:
    path = str(SAMPLES / name)
    return {tool.number: tool for tool in read_tools(path, read_bytes(path))}


def errors_of(name: str, text: str | bytes) -> list[str]:
    """``CODE line:column message`` of every error."""
    with pytest.raises(ToolFileError) as caught:
        tools_of(name, text)
    assert all(d.help for d in caught.value.diagnostics)
    shown = []
    for found in caught.value.diagnostics:
        where = f"{found.place.line}:{found.place.column} " if found.place else ""
        shown.append(f"{found.code} {where}{found.message}")
        assert name in (found.place.file if found.place else found.message)
    return shown


def test_fusion_library() -> None:
    tools = sample("bracket.json")
    assert list(tools) == [1, 2, 4]  # a holder is no tool
    assert tools[2].known() == {
        "type": "flat end mill",
        "teeth": 4,
        "diameter_mm": 12.0,
        "length_mm": 38.0,
        "corner_radius_mm": 0.0,
        "holder_mm": 70.0,
        "name": "12 mm carbide end mill",
    }
    assert tools[2].origins["teeth"].endswith("bracket.json, data[1]")


def test_fusion_library_in_inches() -> None:
    ball = sample("bracket.json")[4]
    assert (ball.diameter_mm, ball.length_mm) == (pytest.approx(6.35), pytest.approx(31.75))
    assert ball.corner_radius_mm == pytest.approx(3.175)
    assert ball.teeth == 2  # a count has no unit


def test_fusion_library_without_a_holder_has_no_holder_length() -> None:
    bare = fusion(geometry={"DC": 5, "LB": 60, "assemblyGaugeLength": 60, "SIG": 140})
    tool = tools_of("a.json", bare)[3]
    assert tool.holder_mm is None
    assert (tool.length_mm, tool.point_deg) == (60.0, 140.0)


def test_fusion_library_with_its_unit_as_an_expression() -> None:
    entry = json.loads(fusion())["data"][0]
    del entry["unit"]
    entry["expressions"] = {"tool_unit": "'inches'"}
    assert tools_of("a.json", json.dumps({"data": [entry]}))[3].diameter_mm == 127.0


def test_tools_file_is_a_zip_of_libraries() -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        file.write(SAMPLES / "bracket.json", "tools.json")
    tools = tools_of("shop.tools", packed.getvalue())
    assert tools[2].diameter_mm == 12.0
    assert tools[2].origins["type"] == "shop.tools/tools.json, data[1]"


def test_csv_leaves_empty_cells_unsaid() -> None:
    tools = sample("bracket.csv")
    assert tools[2].known() == {"helix_deg": 45.0}
    assert tools[3].known() == {
        "type": "drill",
        "teeth": 2,
        "diameter_mm": 6.8,
        "length_mm": 62.0,
        "helix_deg": 30.0,
        "point_deg": 118.0,
        "holder_mm": 60.0,
        "name": "6.8, HSS",
    }


HEAD = "number,type,teeth,diameter_mm,length_mm"


@pytest.mark.parametrize(
    ("text", "diameter"),
    [
        (f"{HEAD}\n5,drill,2,6.8,40\n", 6.8),
        ("number;type;teeth;diameter_mm;length_mm\r\n5;drill;2;6,8;40\r\n", 6.8),
        ("number\ttype\tteeth\tdiameter_mm\tlength_mm\n5\tdrill\t2\t6.8\t40", 6.8),
        (f"\ufeff{HEAD}\n\n# a remark\n5,drill,2,6.8\n", 6.8),
        ("length_mm,Diameter_MM,teeth,type,number\n40, 6.8 ,2,DRILL,5\n", 6.8),
        (f"{HEAD}\n5,,,,\n", None),
    ],
    ids=["commas", "semicolons", "tabs", "bom and short row", "other order", "only a number"],
)
def test_csv_as_spreadsheets_write_it(text: str, diameter: float | None) -> None:
    assert tools_of("a.csv", text)[5].diameter_mm == diameter


def test_csv_quotes() -> None:
    assert tools_of("a.csv", f'{HEAD},name\n5,drill,2,6.8,40,"6.8, ""HSS"""\n')[5].name == '6.8, "HSS"'


def test_csv_names_in_latin_1() -> None:
    assert tools_of("a.csv", f"{HEAD},name\n5,,,,,Fräser\n".encode("latin-1"))[5].name == "Fräser"


def test_toml() -> None:
    tool = sample("bracket.toml")[3]
    assert (tool.type, tool.teeth, tool.diameter_mm, tool.helix_deg) == ("drill", 2, 6.8, 30.0)
    assert tool.origins["type"].endswith("bracket.toml, line 1")


def test_linuxcnc_table() -> None:
    tools = sample("tool.tbl")
    assert tools[1].known() == {
        "type": "face mill",
        "teeth": 5,
        "diameter_mm": 50.0,
        "name": "50 mm face mill, 5 FLUTE",
    }
    assert tools[4].known() == {"name": "empty holder"}
    assert tools[2].length_mm is None  # Z is an offset


def test_linuxcnc_table_in_inches_says_whose_units_these_are() -> None:
    tool = tools_of("tool.tbl", "T1 P1 D0.125 Z+0.511 ;1/8 end mill\n", INCH)[1]
    assert tool.diameter_mm == pytest.approx(3.175)
    assert tool.origins["diameter_mm"] == "tool.tbl, line 1 (inches, as a test says)"
    assert tool.origins["type"] == "tool.tbl, line 1"


def test_linuxcnc_table_of_a_lathe_gives_the_nose() -> None:
    tool = tools_of("tool.tbl", "T3 P3 D0.8 I+275 J+335 Q3 ;\n")[3]
    assert (tool.type, tool.corner_radius_mm, tool.diameter_mm) == ("turning tool", 0.4, None)


def test_freecad_library_numbers_its_bits() -> None:
    tools = sample("bracket.fctl")
    assert tools[2].known() == {
        "type": "flat end mill",
        "teeth": 4,
        "diameter_mm": 12.0,
        "name": "12mm Endmill",
    }
    assert (tools[4].type, tools[4].diameter_mm) == ("ball end mill", pytest.approx(6.35))


def test_freecad_bits_in_the_folder_beside(tmp_path: Path) -> None:
    (tmp_path / "Library").mkdir()
    (tmp_path / "Bit").mkdir()
    (tmp_path / "Bit" / "a.fctb").write_bytes((SAMPLES / "12mm_Endmill.fctb").read_bytes())
    library = tmp_path / "Library" / "shop.fctl"
    library.write_text('{"tools": [{"nr": 7, "path": "a.fctb"}]}')
    (tool,) = read_tools(str(library), read_bytes(str(library)))
    assert (tool.number, tool.diameter_mm) == (7, 12.0)


@pytest.mark.parametrize(
    ("parameters", "corner_mm"),
    [
        ('"Diameter": "6,000 mm", "FlatRadius": "1,5 mm"', 1.5),
        ('"Diameter": "0,25 in", "FlatRadius": "0.1 in"', 0.635),
        ('"Diameter": "6 mm", "FlatRadius": "0 mm"', 3.0),
        ('"Diameter": "6 mm", "FlatRadius": "3 mm"', 0.0),
        ('"Diameter": "6 mm", "FlatRadius": "1.5 mm", "TorusRadius": "1.4 mm"', 1.4),
        ('"FlatRadius": "1.5 mm"', None),
    ],
)
def test_a_bull_nose_by_its_flat_end(parameters: str, corner_mm: float | None, tmp_path: Path) -> None:
    library = tmp_path / "a.fctl"
    library.write_text('{"tools": [{"nr": 1, "path": "a.fctb"}]}')
    (tmp_path / "a.fctb").write_text(f'{{"shape": "bullnose.fcstd", "parameter": {{{parameters}}}}}')
    (tool,) = read_tools(str(library), read_bytes(str(library)))
    assert tool.type == "bull nose end mill"
    assert tool.corner_radius_mm == (None if corner_mm is None else pytest.approx(corner_mm))


def test_a_flat_end_wider_than_its_tool_cannot_be(tmp_path: Path) -> None:
    library = tmp_path / "a.fctl"
    library.write_text('{"tools": [{"nr": 1, "path": "a.fctb"}]}')
    (tmp_path / "a.fctb").write_text('{"parameter": {"Diameter": "6 mm",\n"FlatRadius": "3.1 mm"}}')
    with pytest.raises(ToolFileError) as caught:
        read_tools(str(library), read_bytes(str(library)))
    (found,) = caught.value.diagnostics
    assert (found.code, found.place and found.place.line) == ("TOL004", 2)


@pytest.mark.parametrize(
    ("remark", "kind"),
    [
        ("drill 5 mm", "drill"),
        ("Probe", "probe"),
        ("M6 tap", "tap"),
        ("90 deg spot drill", "spot drill"),
        ("12mm E.M.", "end mill"),
        ("spare", None),
    ],
)
def test_the_remark_of_a_tool_table_names_the_tool(remark: str, kind: str | None) -> None:
    tool = tools_of("tool.tbl", f"T1 P1 D5 ;{remark}\n")[1]
    assert (tool.type, tool.name) == (kind, remark)


def fusion(**changes: Any) -> str:
    entry = {
        "type": "drill",
        "unit": "millimeters",
        "geometry": {"DC": 5, "NOF": 2},
        "post-process": {"number": 3},
    }
    return json.dumps({"data": [entry | changes]}, indent=1)


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.csv", "", "TOL002 a.csv: this table is empty"),
        ("a.csv", "number,type\n", "TOL003 1:1 there is no column teeth"),
        ("a.csv", f"{HEAD},radius\n", "TOL003 1:41 there is no column"),
        ("a.csv", f"{HEAD},teeth\n", "TOL003 1:41 the column teeth is there twice"),
        ("a.csv", f"{HEAD}\n2,drill,two,5,40\n", "TOL004 2:9 teeth = 'two' is not possible"),
        ("a.csv", f"{HEAD}\n2,drill,2.5,5,40\n", "TOL004 2:9 teeth = '2.5' is not possible"),
        ("a.csv", f"{HEAD}\n2,drill,2,-5,40\n", "TOL004 2:11 diameter_mm = '-5' is not possible"),
        ("a.csv", f"{HEAD}\n2,drill,2,nan,40\n", "TOL004 2:11 diameter_mm = 'nan' is not possible"),
        ("a.csv", f"{HEAD}\n2,drill,2,0,40\n", "TOL004 2:11 diameter_mm = '0' is not possible"),
        ("a.csv", f"{HEAD}\n2,drlil,2,5,40\n", 'TOL004 2:3 type = "drlil" is not known'),
        ("a.csv", f"{HEAD}\n,drill,2,5,40\n", "TOL005 2:1 this row has no tool number"),
        ("a.csv", f"{HEAD}\n2,drill,2,5,40,60\n", "TOL002 2:16 this row has 6 cells"),
        ("a.toml", "[[tool]]\nnumber = 2\nteth = 4\n", "TOL003 3:1 there is no key teth"),
        ("a.toml", "[[tool]]\nnumber = 2\nteeth = true\n", "TOL004 3:1 teeth = True is not possible"),
        ("a.toml", "[[tool]]\nnumber=1\n[[tool]]\nname=3\n", "TOL004 4:1 name is no text"),
        ("a.toml", "[[tool]]\nteeth = 4\n", "TOL005 1:1 this tool has no number"),
        ("a.toml", "a = 1\n[[tool]]\nnumber = 2\n", "TOL003 1:1 there is no key a"),
        ("a.toml", "tool = 3\n", "TOL002 a.toml: there is no [[tool]] in it"),
        ("a.toml", "[[tool]\n", "TOL002 1:7 this is not TOML"),
        ("a.json", "{", "TOL002 1:2 this is not JSON"),
        ("a.json", "[1]", 'TOL002 a.json: there is no list "data"'),
        ("a.json", fusion(unit="furlongs"), "TOL006 5:1 data[0] has no unit that is known"),
        ("a.json", fusion(geometry={"DC": "5"}), "TOL004 7:1 data[0].geometry.DC: diameter_mm is text"),
        ("a.json", fusion(geometry={"DC": -5}), "TOL004 7:1 data[0].geometry.DC: diameter_mm = -5"),
        ("a.json", fusion(geometry={"NOF": 1.5}), "TOL004 7:1 data[0].geometry.NOF: teeth = 1.5"),
        ("a.json", fusion(**{"post-process": {"number": []}}), "TOL004 11:1 data[0].post-process.number"),
        ("a.json", '{"data": [3]}', "TOL002 1:1 data[0] is no tool"),
        ("a.tools", b"PK\x03\x04", "TOL002 a.tools: this zip cannot be read"),
        ("a.fctb", "{}", "TOL005 a.fctb: a tool bit has no tool number"),
        ("a.fctl", "{}", 'TOL002 a.fctl: there is no list "tools"'),
        ("a.fctl", '{"tools": [\n{"nr": 2}]}', "TOL002 2:1 tools[0] names no bit"),
        ("a.fctl", '{"tools": [\n{"path": "x"}]}', "TOL005 2:1 tools[0] has no number"),
        ("a.fctl", '{"tools": [{"nr": -1, "path": "x"}]}', "TOL004 1:1 tools[0].nr"),
        ("a.fctl", '{"tools": [{"nr": 1, "path": "x.fctb"}]}', "TOL001 1:1 tools[0]: x.fctb cannot be read"),
        ("a.tbl", "T1 P1 D12 ;ok\nT2 P2 D12 E5\n", 'TOL003 2:11 "E5" is no word'),
        ("a.tbl", "T1 D1.2.3\n", 'TOL003 1:4 "D1.2.3" is no word'),
        ("a.tbl", "P1 D12\n", "TOL005 1:1 this line has no T"),
        ("a.tbl", "T1 D-12\n", "TOL004 1:4 diameter_mm = -12.0"),
        ("a.txt", "", "TOL002 a.txt: files that end with"),
        ("tools", "", "TOL002 tools: this file has no ending"),
    ],
)
def test_what_cannot_be_is_said_with_its_place(name: str, text: str | bytes, expected: str) -> None:
    assert errors_of(name, text)[0].startswith(expected)


def test_the_nearest_column_is_named() -> None:
    with pytest.raises(ToolFileError) as caught:
        tools_of("a.csv", "number,type,teeth,diametre_mm,length_mm\n")
    assert caught.value.diagnostics[0].help == "did you mean diameter_mm?"


def test_a_bit_with_a_unit_nobody_knows(tmp_path: Path) -> None:
    library = tmp_path / "a.fctl"
    library.write_text('{"tools": [{"nr": 1, "path": "a.fctb"}]}')
    (tmp_path / "a.fctb").write_text('{"parameter": {\n"Diameter": "5 ell"}}')
    with pytest.raises(ToolFileError) as caught:
        read_tools(str(library), read_bytes(str(library)))
    (found,) = caught.value.diagnostics
    assert (found.code, found.place and found.place.line) == ("TOL006", 2)


def test_all_errors_at_once_but_not_thousands() -> None:
    found = errors_of("a.csv", HEAD + "\n" + "2,x,y,z,w\n" * 1000)
    assert len(found) == 21
    assert found[-1].startswith("TOL007")


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(ToolFileError) as caught:
        read_bytes("no/such/file.csv")
    assert caught.value.diagnostics[0].code == "TOL001"


@pytest.mark.parametrize("name", ["a\0b.csv", "x" * 5000])
def test_a_name_that_cannot_be(name: str) -> None:
    with pytest.raises(ToolFileError):
        read_bytes(name)
