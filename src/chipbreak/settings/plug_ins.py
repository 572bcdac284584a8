"""Passes that other installed packages offer, by the names under which a profile asks for them.

A package offers one in its own metadata: an entry point of the group ``chipbreak.passes`` whose object is a
class of passes.  Installed packages are searched only for a profile that names one.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from chipbreak.settings.checking import IMPOSSIBLE, Layer
from chipbreak.text.nearest import nearest

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "chipbreak.passes"


def offered() -> dict[str, list[EntryPoint]]:
    """Every pass that an installed package offers; more than one entry for a name is a clash."""
    from importlib.metadata import entry_points  # noqa: PLC0415 (slow to import, and few profiles need it)

    found: dict[str, list[EntryPoint]] = {}
    for entry in entry_points(group=GROUP):
        found.setdefault(entry.name, []).append(entry)
    return found


def check_plug_ins(layer: Layer, extra: Iterable[str], with_options: Iterable[str]) -> None:
    """Refuse names of passes that no installed package offers, or that two of them offer.

    ``extra`` are the names in ``passes.extra``, ``with_options`` those that have a section of options.
    """
    keys = {name: f"plugins.{name}" for name in with_options} | dict.fromkeys(extra, "passes.extra")
    if not keys:
        return
    known = offered()
    for name, key in keys.items():
        entries = known.get(name, [])
        if not entries:
            message = f"{key}: no installed package offers a pass {name!r}"
            raise layer.fail(IMPOSSIBLE, key, message, _hint(name, known))
        if len(entries) > 1:
            targets = " and ".join(sorted(entry.value for entry in entries))
            message = f"{key}: the pass {name!r} is offered twice, by {targets}"
            raise layer.fail(IMPOSSIBLE, key, message, "uninstall one of the two packages")


def _hint(name: str, known: Iterable[str]) -> str:
    names = sorted(known)
    near = nearest(name, names, 0.5)
    if near:
        return f"did you mean {near}?"
    return f"offered: {', '.join(names)}" if names else "install the package that offers it"
