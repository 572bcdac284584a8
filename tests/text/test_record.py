"""Records are frozen dataclasses to whoever uses them."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, field, fields, is_dataclass, replace

import pytest

from chipbreak.text.record import Record, ValueRecord


class Place(ValueRecord):
    x: float
    z: float = 2.0
    names: tuple[str, ...] = field(default_factory=tuple, metadata={"told": "as they are said"})


class Named(Place, kw_only=True):
    name: str


class Alone(Record):
    x: float = 1.0


class Further(Alone, kw_only=True):
    y: float


def test_made_by_place_and_by_name() -> None:
    assert vars(Place(1.0)) == {"x": 1.0, "z": 2.0, "names": ()}
    assert Place(1.0, names=("A",)) == Place(names=("A",), x=1.0)
    assert vars(Named(1.0, 3.0, name="B")) == {"x": 1.0, "z": 3.0, "names": (), "name": "B"}
    assert vars(Further(y=3.0)) == {"x": 1.0, "y": 3.0}


@pytest.mark.parametrize(
    ("args", "values"),
    [((), {}), ((1.0, 2.0, (), 4.0), {}), ((1.0,), {"x": 1.0}), ((1.0,), {"y": 1.0})],
    ids=["nothing", "too many", "twice", "unknown"],
)
def test_wrong_values_are_refused(args: tuple[object, ...], values: dict[str, object]) -> None:
    with pytest.raises(TypeError, match="Place"):
        Place(*args, **values)  # type: ignore[arg-type]


def test_keywords_only_is_kept() -> None:
    with pytest.raises(TypeError, match="Named"):
        Named(1.0, 2.0, (), "B")  # type: ignore[call-arg, misc]


@pytest.mark.parametrize("one", [Place(1.0), Named(1.0, name="B"), Alone(), Further(y=1.0)])
def test_never_changed(one: Place | Alone) -> None:
    with pytest.raises(FrozenInstanceError):
        one.x = 2.0  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        one.other = 2.0  # type: ignore[union-attr]
    with pytest.raises(FrozenInstanceError):
        del one.x  # type: ignore[misc]
    assert one.x == 1.0


def test_equal_by_values_or_by_itself() -> None:
    assert Place(1.0) == Place(1.0) and hash(Place(1.0)) == hash(Place(1.0))
    assert Place(1.0) != Place(2.0)
    assert Place(1.0) != Named(1.0, name="")
    assert Alone() != Alone()
    assert repr(Named(1.0, name="B")) == "Named(x=1.0, z=2.0, names=(), name='B')"


@pytest.mark.parametrize("one", [Place(1.0), Named(1.0, name="B")])
def test_dataclasses_and_pickle_know_it(one: Place) -> None:
    assert is_dataclass(one)
    assert [each.name for each in fields(one)][:3] == ["x", "z", "names"]
    assert fields(one)[2].metadata == {"told": "as they are said"}
    assert replace(one, z=5.0).z == 5.0 and replace(one, z=5.0) != one
    assert pickle.loads(pickle.dumps(one)) == one == copy.deepcopy(one)
