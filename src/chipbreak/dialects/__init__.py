"""What each control understands: one frozen object a control, and nowhere a branch on its name.

A package of its own may bring further controls.  It offers a :class:`Dialect` (or a tuple of them, one for
each lathe code system) under its name, and, if it has profiles for it, the package in which the files lie::

    [project.entry-points."chipbreak.dialects"]
    acme = "acme_chipbreak:ACME"
    [project.entry-points."chipbreak.profiles"]
    acme = "acme_chipbreak"

Then ``-p acme-lathe`` finds ``acme_chipbreak/acme-lathe.toml``, and ``dialect = "acme"`` in it the object.  A
block of another shape is a grammar file in that package: ``grammar=Path(__file__).with_name("acme.lark")``,
see ``grammar/README.md``.  Shipped names come first; no package can take their place.
"""

from chipbreak.dialects.base import NON_MODAL, Code, CommentMarks, Dialect
from chipbreak.dialects.check_programs import BUILT_IN, PROBE_MAKERS, CallTemplates, MacroSet
from chipbreak.dialects.fanuc import FANUC_LATHE_A, FANUC_LATHE_B, FANUC_LATHE_C, FANUC_MILL
from chipbreak.dialects.generic import GENERIC_LATHE
from chipbreak.dialects.grbl import GRBL, GRBLHAL_LATHE
from chipbreak.dialects.klipper import KLIPPER
from chipbreak.dialects.linuxcnc import LINUXCNC_LATHE, LINUXCNC_MILL
from chipbreak.dialects.plug_ins import offered, offered_names

DIALECTS: tuple[Dialect, ...] = (
    GENERIC_LATHE,
    FANUC_LATHE_A,
    FANUC_LATHE_B,
    FANUC_LATHE_C,
    FANUC_MILL,
    LINUXCNC_LATHE,
    LINUXCNC_MILL,
    GRBLHAL_LATHE,
    GRBL,
    KLIPPER,
)

__all__ = [
    "BUILT_IN",
    "DIALECTS",
    "FANUC_MILL",
    "GENERIC_LATHE",
    "LINUXCNC_MILL",
    "NON_MODAL",
    "PROBE_MAKERS",
    "CallTemplates",
    "Code",
    "CommentMarks",
    "Dialect",
    "MacroSet",
    "dialect_names",
    "find",
]


def dialect_names() -> list[str]:
    """The names of all dialects that are here, in alphabetical order."""
    return sorted({dialect.name for dialect in DIALECTS}.union(offered_names()))


def find(name: str, lathe_system: str) -> Dialect:
    """The dialect of a name; a lathe with several code systems is found by system too.

    Where the program is to show it (``shown``), that is the first of them until it does.

    Shipped ones come first.  Raises KeyError when there is none, and RefusalError (SET006) for one of an
    installed package that cannot be used.
    """
    named = tuple(dialect for dialect in DIALECTS if dialect.name == name) or offered(name)
    for dialect in named:
        if dialect.lathe_system in ("", lathe_system) or lathe_system == "shown":
            return dialect
    raise KeyError(name)
