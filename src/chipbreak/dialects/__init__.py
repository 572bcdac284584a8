"""What each control understands, as frozen tables: one value per control, no branches on names."""

from chipbreak.dialects.base import NON_MODAL, Code, CommentMarks, Dialect
from chipbreak.dialects.fanuc import FANUC_LATHE_A, FANUC_LATHE_B, FANUC_LATHE_C, FANUC_MILL
from chipbreak.dialects.generic import GENERIC_LATHE
from chipbreak.dialects.linuxcnc import LINUXCNC_LATHE, LINUXCNC_MILL

DIALECTS: tuple[Dialect, ...] = (
    GENERIC_LATHE,
    FANUC_LATHE_A,
    FANUC_LATHE_B,
    FANUC_LATHE_C,
    FANUC_MILL,
    LINUXCNC_LATHE,
    LINUXCNC_MILL,
)

__all__ = [
    "DIALECTS",
    "FANUC_MILL",
    "GENERIC_LATHE",
    "LINUXCNC_MILL",
    "NON_MODAL",
    "Code",
    "CommentMarks",
    "Dialect",
    "find",
]


def find(name: str, lathe_system: str) -> Dialect:
    """The dialect of a name; a lathe with several code systems is found by system too.

    Raises KeyError when there is none.
    """
    named = [d for d in DIALECTS if d.name == name]
    for dialect in named:
        if dialect.lathe_system in ("", lathe_system):
            return dialect
    raise KeyError(name)
