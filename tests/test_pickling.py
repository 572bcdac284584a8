"""Settings, results and errors go to another process and come back as they were."""

from __future__ import annotations

import copy
import importlib
import multiprocessing
import pickle
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import pytest

import chipbreak
from chipbreak.cycles.plan import _GroupError
from chipbreak.editing.edits import Edit, OverlapError
from chipbreak.editing.promise import Promise
from chipbreak.macros.parameters import UnsetError
from chipbreak.operations.linear_pattern import TooDifficultError
from chipbreak.settings import profile_names
from chipbreak.syntax.expressions import UnreadableError
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.span import Place
from chipbreak.vibration.cuts import _TooDearBehindError
from chipbreak.vibration.speeds import UnknownSpeedError
from chipbreak.whole_files import NotReplacedError

FOUND = Diagnostic("VIB001", Severity.ERROR, "N is wrong", "write another", Place("a.nc", 3, 2, 5), "G1 N2")
EDIT = Edit(0, 4, ("G4 X1.",), "title", "reason", Promise(), "vibrate")
ERRORS = [
    chipbreak.ChipbreakError("anything"),
    chipbreak.ProgramRejectedError([FOUND, FOUND._replace(severity=Severity.WARNING)]),
    chipbreak.SelfCheckError("the cut does not end at its programmed end"),
    chipbreak.SettingsError(FOUND),
    chipbreak.ToolFileError([FOUND]),
    OverlapError(EDIT, EDIT._replace(first=2, pass_name="check_tools")),
    RefusalError("VIB030", "too fast", "be slower"),
    UnknownSpeedError("VIB057", "no speed", "give one", 7),
    UnreadableError("too deep", 7),
    UnsetError("MCR001", "no beam", "measure it"),
    TooDifficultError("too many ways"),
    NotReplacedError("it has other names"),
    _GroupError(7, RefusalError("CYC007", "no point", "write one")),
    _TooDearBehindError("it would cost more than any behind a refused one may"),
]
Copier = Callable[[Any], Any]


def through_pickle(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


COPIERS = pytest.mark.parametrize("copied", [through_pickle, copy.deepcopy], ids=["pickle", "deepcopy"])


def own_errors() -> Iterator[type[BaseException]]:
    """Every exception that a module of the package defines."""
    names = [module.name for module in pkgutil.walk_packages(chipbreak.__path__, "chipbreak.")]
    for name in names:
        if not name.endswith("__main__"):
            types = [v for v in vars(importlib.import_module(name)).values() if isinstance(v, type)]
            errors = [one for one in types if issubclass(one, BaseException)]
            yield from (one for one in errors if one.__module__.partition(".")[0] == "chipbreak")


def test_every_error_is_tried() -> None:
    assert set(own_errors()) == {type(error) for error in ERRORS}


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
@COPIERS
def test_an_error(error: Exception, copied: Copier) -> None:
    other = copied(error)
    assert type(other) is type(error)
    # The promise of an edit is equal to itself alone, so looks are compared.
    assert (str(other), repr(other), repr(vars(other))) == (str(error), repr(error), repr(vars(error)))


@pytest.mark.parametrize("name", profile_names())
@COPIERS
def test_settings(name: str, copied: Copier) -> None:
    settings = chipbreak.load(name, ["checks.w_mm={ 2 = 0.03 }"])
    other = copied(settings)
    assert other == settings
    assert other.checks.w_mm == {"2": 0.03}


def plain_dicts(value: Any, path: str) -> Iterator[str]:
    """Where a value holds a mapping that could be changed."""
    if isinstance(value, Mapping):
        if not isinstance(value, FrozenTable):
            yield path
        for key, inner in value.items():
            yield from plain_dicts(inner, f"{path}[{key!r}]")
    elif is_dataclass(value):
        for field in fields(value):
            yield from plain_dicts(getattr(value, field.name), f"{path}.{field.name}")
    elif isinstance(value, tuple):
        for index, inner in enumerate(value):
            yield from plain_dicts(inner, f"{path}[{index}]")


@pytest.mark.parametrize("name", profile_names())
def test_nobody_can_change_settings(name: str) -> None:
    settings = chipbreak.load(name, ["checks.w_mm={ 2 = 0.03 }"])
    assert list(plain_dicts(settings, "settings")) == []


def test_a_frozen_table_refuses_every_change() -> None:
    changes: list[Callable[[Any], Any]] = [
        lambda t: t.__setitem__("a", 2),
        lambda t: t.__delitem__("a"),
        lambda t: t.__ior__({"b": 1}),
        lambda t: t.clear(),
        lambda t: t.pop("a"),
        lambda t: t.popitem(),
        lambda t: t.setdefault("b", 1),
        lambda t: t.update(b=1),
    ]
    reading = {"copy", "fromkeys", "get", "items", "keys", "values"}
    assert len(changes) == len({n for n in dir(dict) if n[0] != "_"} - reading) + 3
    table = FrozenTable({"a": 1})
    for change in changes:
        with pytest.raises(TypeError):
            change(table)
    assert table == {"a": 1}
    wider = table | {"b": 2}
    assert isinstance(wider, FrozenTable)
    assert wider == {"a": 1, "b": 2}


PROGRAM = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
REJECTED = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N2\nM30\n"


def filtered(data: bytes, settings: chipbreak.Settings) -> bytes:
    """Work for another process."""
    return chipbreak.rewrite(data, settings, "part.nc").data


def test_another_process_takes_settings_and_gives_errors_back() -> None:
    settings = chipbreak.load("generic-lathe")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(filtered, (PROGRAM, settings)) == filtered(PROGRAM, settings)
        with pytest.raises(chipbreak.ProgramRejectedError) as there:
            pool.apply(filtered, (REJECTED, settings))
    with pytest.raises(chipbreak.ProgramRejectedError) as here:
        filtered(REJECTED, settings)
    assert there.value.diagnostics == here.value.diagnostics
