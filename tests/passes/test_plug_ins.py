"""Passes of other installed packages: asked for by name, never able to bring a run down without a word."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.settings import SettingsError, load
from chipbreak.settings.show import show_profile
from chipbreak.text.diagnostics import ProgramRejectedError, SelfCheckError

PROGRAM = b"G97 S900 M3\nG0 X20. Z2.\nG1 Z-3. F0.1\nM30\n"
HEAD = """
import sys
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import KEPT, Promise
from chipbreak.passes.base import Pass, Planned
from chipbreak.text.diagnostics import RefusalError

def insert(line, *blocks, promise=KEPT):
    return Edit(line, line, blocks, "SHOP", "the shop wants it", promise)
"""
LABEL = """
class Label(Pass):
    name = "vibrate"
    def plan(self, context):
        text = context.settings.plugins.get("label", {}).get("text", "HELLO")
        return Planned([insert(1, f"({text})")])
"""


def pass_class(body: str, name: str = "Label") -> str:
    return f"class {name}(Pass):\n    name = 'x'\n    def plan(self, context):\n        {body}\n"


def install(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    code: str,
    module: str,
    entries: str = "label = {}:Label",
) -> None:
    """A package as it is after installation: a module, and metadata that offers its passes."""
    folder.mkdir(exist_ok=True)
    (folder / f"{module}.py").write_text(HEAD + code)
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[chipbreak.passes]\n{entries.format(module)}\n")
    monkeypatch.syspath_prepend(str(folder))


def run(*options: str) -> chipbreak.Result:
    return chipbreak.rewrite(PROGRAM, load("generic-lathe", options))


def test_a_pass_runs_only_where_the_profile_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, monkeypatch, LABEL, "shop_named")
    assert not run().changed
    result = run('passes.extra=["label"]', "plugins.label.text=SHOP 4")
    assert b"\n(SHOP 4)\n" in result.data
    assert [edit.pass_name for edit in result.edits] == ["plug-in label"]  # no name of ours can be taken
    assert chipbreak.rewrite(result.data, load("generic-lathe")).data == PROGRAM


def test_passes_run_in_the_order_of_their_names_and_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = pass_class("return Planned([insert(1, '(B)')])", "B") + pass_class(
        "return Planned([insert(1, f'({len(context.planned)})')])", "A"
    )
    install(tmp_path, monkeypatch, code, "shop_order", "b = {0}:B\na = {0}:A")
    result = run('passes.extra=["b", "a", "b"]')
    assert [edit.pass_name for edit in result.edits] == ["plug-in b", "plug-in a"]
    assert b"(0)" in result.data


def test_options_are_handed_over_as_they_are_and_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, monkeypatch, LABEL, "shop_options")
    file = tmp_path / "my.toml"
    options = 'text = "A"\nlimits = [1, 2.5]\nday = 2024-05-01\ndeep = {a = {b = true}}\n'
    file.write_text(f'base = "generic-lathe"\n[passes]\nextra = "label"\n[plugins.label]\n{options}')
    settings = load(file)
    assert settings.passes.extra == ("label",)
    wanted = load(file).plugins["label"]
    assert dict(wanted)["limits"] == [1, 2.5]
    assert dict(wanted)["deep"] == {"a": {"b": True}}
    again = tmp_path / "again.toml"
    again.write_text("\n".join(show_profile(settings)))
    assert {**load(again).plugins["label"], "day": None} == {**wanted, "day": None}


@pytest.mark.parametrize(
    ("options", "said", "help_text"),
    [
        (('passes.extra=["lable"]',), "passes.extra: no installed package offers a pass 'lable'", "label"),
        (("plugins.labels.text=A",), "plugins.labels: no installed package offers", "label"),
        (('passes.extra=["zzzz"]',), "offers a pass 'zzzz'", "offered: label"),
        (("passes.extra=[4]",), "passes.extra = 4 is of the wrong type", "text"),
        (("passes.extras=[]",), "there is no key passes.extras", "extra"),
        (("plugins.label=4",), "plugins.label is a table of options", "[plugins.label]"),
    ],
)
def test_names_and_options_that_cannot_be(
    options: tuple[str, ...],
    said: str,
    help_text: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    install(tmp_path, monkeypatch, LABEL, "shop_wrong")
    with pytest.raises(SettingsError) as caught:
        load("generic-lathe", options)
    assert said in caught.value.diagnostic.message
    assert help_text in caught.value.diagnostic.help
    assert caught.value.diagnostic.place is not None


def test_without_any_such_package_the_help_says_so() -> None:
    with pytest.raises(SettingsError) as caught:
        load("generic-lathe", ['passes.extra=["label"]'])
    assert "install" in caught.value.diagnostic.help


def test_one_name_from_two_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path / "a", monkeypatch, LABEL, "shop_one")
    install(tmp_path / "b", monkeypatch, LABEL, "shop_two")
    with pytest.raises(SettingsError, match=r"offered twice, by shop_one:Label and shop_two:Label"):
        load("generic-lathe", ['passes.extra=["label"]'])


def test_a_refusal_is_an_error_of_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body = "raise RefusalError('SHP001', 'no label on this machine', 'take another')"
    install(tmp_path, monkeypatch, pass_class(body), "shop_refuses")
    with pytest.raises(ProgramRejectedError) as caught:
        run("passes.extra=label")
    (error,) = caught.value.diagnostics
    assert (error.code, error.message, error.help) == ("SHP001", "no label on this machine", "take another")


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return 1 / 0", "ZeroDivisionError: division by zero"),
        ("sys.exit(0)", "SystemExit: 0"),
        ("return None", "TypeError"),
        ("return Planned(['G4'])", "TypeError: 'G4' is no Edit"),
        ("return Planned((), ['wrong'])", "TypeError: 'wrong' is no Diagnostic"),
        ("return Planned([insert(9, '(A)')])", "ValueError: 'SHOP' changes lines that are not there: 9 to 9"),
        ("return Planned([insert(1, 'G4\\nM8')])", "is more than one line"),
        ("return Planned([insert(1, '(\\u20ac)')])", "UnicodeEncodeError"),
        ("return Planned([insert(1, 4)])", "TypeError"),
        ("return Planned([insert(1, '(A)', promise=None)])", "the promise of 'SHOP' is no Promise"),
    ],
)
def test_any_other_fault_is_said_with_the_name_of_the_plug_in(
    body: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = f"shop_fails_{abs(hash(body))}"
    install(tmp_path, monkeypatch, pass_class(body), module)
    with pytest.raises(SelfCheckError, match=r"^plug-in label failed: ") as caught:
        run("passes.extra=label")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("code", "entry"),
    [
        ("raise OSError('no licence')\n", "label = {}:Label"),
        ("", "label = {}:Missing"),
        ("class Label(Pass): pass\n", "label = {}:Label"),  # it has no plan
    ],
)
def test_a_pass_that_does_not_load(
    code: str, entry: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, monkeypatch, code, f"shop_loads_not_{abs(hash((code, entry)))}", entry)
    with pytest.raises(SelfCheckError, match=r"^plug-in label failed: "):
        run("passes.extra=label")


@pytest.mark.parametrize(
    ("blocks", "said"),
    [
        ("'M8'", "the coolant"),
        ("'S500'", "the spindle speed"),
        ("'G91'", "the modal state"),
    ],
)
def test_what_it_writes_is_distrusted_like_all_else(
    blocks: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = pass_class(f"return Planned([insert(1, {blocks})])")
    install(tmp_path, monkeypatch, code, f"shop_writes_{abs(hash(blocks))}")
    with pytest.raises(SelfCheckError, match=said):
        run("passes.extra=label")


def test_findings_that_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = LABEL + "    def findings(self, context, reports):\n        return 1 / 0\n"
    install(tmp_path, monkeypatch, code, "shop_finds")
    with pytest.raises(SelfCheckError, match=r"^plug-in label failed: ZeroDivisionError"):
        run("passes.extra=label")
