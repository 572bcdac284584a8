"""One dialect for each grammar: those of the house, and one that a package could bring."""

from __future__ import annotations

from pathlib import Path

import pytest

from chipbreak.dialects import DIALECTS, FANUC_MILL, GENERIC_LATHE, LINUXCNC_MILL, Dialect

SET_OFF = FANUC_MILL._replace(name="set-off", grammar=Path(__file__).with_name("set_off.lark"))
BY_GRAMMAR: dict[str, Dialect] = {str(dialect.grammar): dialect for dialect in DIALECTS}
ISO = {dialect.name: dialect for dialect in (FANUC_MILL, LINUXCNC_MILL, GENERIC_LATHE)}

every_grammar = pytest.mark.parametrize(
    "dialect", [*BY_GRAMMAR.values(), SET_OFF], ids=[*BY_GRAMMAR, SET_OFF.name]
)
every_iso_control = pytest.mark.parametrize("dialect", ISO.values(), ids=ISO)
