"""Skips the tests marked ``linuxcnc`` where LinuxCNC is missing, and says so loudly at the end of the run.

``@pytest.mark.linuxcnc`` needs the interpreter; ``@pytest.mark.linuxcnc("machine")`` the simulated machine
as well.
"""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from . import machine, rs274

NO_INTERPRETER = "LinuxCNC's interpreter (rs274) is not installed"
NO_MACHINE = "LinuxCNC's simulated machine cannot be started here (it needs linuxcnc-uspace and root)"
HOW = (
    "Install: sudo sh tests/linuxcnc/install.sh (Debian 12, package linuxcnc-uspace); run the tests as root."
)


def missing(marker: pytest.Mark) -> str:
    """Why a test with this marker cannot run here; empty when it can."""
    if not rs274.available():
        return NO_INTERPRETER
    if "machine" in marker.args and not machine.available():
        return NO_MACHINE
    return ""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        marker = item.get_closest_marker("linuxcnc")
        if marker and (reason := missing(marker)):
            item.add_marker(pytest.mark.skip(reason=reason))
    items[:] = dealt(items)


def dealt(items: Sequence[pytest.Item]) -> list[pytest.Item]:
    """Tests that wait for a machine evenly among those that compute: if all workers wait, cores are idle."""
    waiting = [item for item in items if _waits(item)]
    computing = [item for item in items if not _waits(item)]
    places = {id(item): at / len(waiting) for at, item in enumerate(waiting)}
    places |= {id(item): at / len(computing) for at, item in enumerate(computing)}
    return sorted(items, key=lambda item: places[id(item)])


def _waits(item: pytest.Item) -> bool:
    marker = item.get_closest_marker("linuxcnc")
    return marker is not None and "machine" in marker.args


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    skipped = [
        report
        for report in terminalreporter.stats.get("skipped", [])
        if NO_INTERPRETER in str(report.longrepr) or NO_MACHINE in str(report.longrepr)
    ]
    if skipped:
        terminalreporter.write_sep("!", f"{len(skipped)} LINUXCNC TESTS SKIPPED", red=True, bold=True)
        terminalreporter.write_line(HOW, red=True)
