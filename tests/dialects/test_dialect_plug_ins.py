"""Controls and profiles that other packages bring, installed as such a package is."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import chipbreak
from chipbreak.dialects import DIALECTS, FANUC_MILL, dialect_names, find, plug_ins
from chipbreak.settings import SettingsError, load
from chipbreak.settings.profile_files import profile_names

ACME = """
from pathlib import Path
from chipbreak.dialects import GENERIC_LATHE
ACME = GENERIC_LATHE._replace(name="acme", title="Acme lathe", grammar=Path(__file__).with_name("acme.lark"))
"""
GRAMMAR = """
%import .iso (BLANK)
block: (word | COMMENT)*
word: LETTER SEPARATOR? number
number: NUMBER
LETTER: /[A-Za-z]/
SEPARATOR: /=/
NUMBER: /[+-]?(?:[0-9]+\\.?[0-9]*|\\.[0-9]+)/
COMMENT: /;.*/
%ignore BLANK
"""
PROFILE = 'base = "generic-lathe"\n[control]\ndialect = "acme"\n'
Install = Callable[..., Path]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Puts a package with a control and a profile where Python finds it."""
    monkeypatch.syspath_prepend(tmp_path)

    def put(source: str = ACME, name: str = "acme", package: str = "chipbreak_test_acme") -> Path:
        monkeypatch.delitem(sys.modules, package, raising=False)
        folder = tmp_path / package
        folder.mkdir()
        (folder / "__init__.py").write_text(source)
        (folder / "acme.lark").write_text(GRAMMAR)
        (folder / "acme-lathe.toml").write_text(PROFILE)
        info = tmp_path / f"{package}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(
            f"[chipbreak.dialects]\n{name} = {package}:ACME\n[chipbreak.profiles]\n{name} = {package}\n"
        )
        return folder

    return put


def refusal(profile: str, *options: str) -> str:
    with pytest.raises(SettingsError) as caught:
        load(profile, options)
    found = caught.value.diagnostic
    return f"{found.code} {found.message}; {found.help}"


def test_a_control_of_another_package(install: Install) -> None:
    install()
    assert find("acme", "A").title == "Acme lathe"
    settings = load("generic-lathe", ["control.dialect=acme"])
    result = chipbreak.rewrite(b"N10 G0 X=10. Z=1. ; (\nG1 Z=-1.5 F=0.1\n", settings)
    assert not result.diagnostics
    assert "acme" in dialect_names()


def test_a_profile_of_another_package(install: Install) -> None:
    folder = install()
    assert load("acme-lathe").dialect.title == "Acme lathe"
    (folder / "acme-small.toml").write_text('base = "acme-lathe"\n[spindle]\nmax_rpm = 3000\n')
    assert load("acme-small").dialect.name == "acme"
    assert "did you mean acme-lathe?" in refusal("acme-lath")


def test_shipped_names_come_first(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = install("raise RuntimeError('nobody asked')", "fanuc-mill")
    (folder / "fanuc-mill.toml").write_text(PROFILE)
    assert find("fanuc-mill", "A") is FANUC_MILL
    assert load("fanuc-mill").dialect == FANUC_MILL


def test_packages_are_not_searched_for_what_is_shipped(monkeypatch: pytest.MonkeyPatch) -> None:
    def searched() -> None:
        raise AssertionError("installed packages were searched")

    monkeypatch.setattr(plug_ins, "_entries", searched)
    assert [find(dialect.name, dialect.lathe_system) for dialect in DIALECTS] == list(DIALECTS)
    for name in profile_names():
        load(name)


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("ACME = 5", "TypeError: 'int' object is not iterable"),
        ("ACME = ()", "TypeError: it is no Dialect, and no tuple of them"),
        ("ACME = (5,)", "TypeError: it is no Dialect, and no tuple of them"),
        ("other = 1", "AttributeError: module 'chipbreak_test_acme' has no attribute 'ACME'"),
        (ACME.replace('name="acme"', 'name="amce"'), "ValueError: its name is amce"),
    ],
)
def test_a_package_that_fails_is_named(install: Install, source: str, why: str) -> None:
    install(source)
    said = refusal("generic-lathe", "control.dialect=acme")
    assert said.startswith(f"SET006 the dialect 'acme' of chipbreak_test_acme:ACME cannot be used: {why}")


def test_profiles_of_a_package_that_fails_are_said(install: Install) -> None:
    install("import no_such_module")
    assert refusal("acme-lathe").startswith(
        "SET004 the profiles of chipbreak_test_acme cannot be read: Module"
    )


def test_two_packages_with_one_name_are_refused(install: Install) -> None:
    install()
    install(package="chipbreak_test_other")
    assert "the dialect 'acme' is offered twice" in refusal("generic-lathe", "control.dialect=acme")
    assert "the profile 'acme-lathe' is offered twice" in refusal("acme-lathe")


def test_a_control_may_read_numbers_in_fewer_ways(install: Install) -> None:
    rules = 'number_rules={"required": GENERIC_LATHE.number_rules["required"]}'
    install(ACME.replace('name="acme"', f'name="acme", {rules}'))
    assert load("acme-lathe", ["control.decimal_point=required"]).number_rule.reads_whole is False
    said = refusal("acme-lathe", "control.decimal_point=increment")
    assert said.startswith("SET003 control.decimal_point 'increment': Acme lathe does not read numbers so")


def test_an_unknown_control_is_refused_with_all_that_are_here(install: Install) -> None:
    install()
    said = refusal("generic-lathe", "control.dialect=acne")
    assert "'acne' is not known; one of acme, fanuc-lathe" in said
