"""Skips the tests marked ``linuxcnc`` where LinuxCNC is missing, and says so loudly at the end of the run.

``@pytest.mark.linuxcnc`` needs the interpreter; ``@pytest.mark.linuxcnc("machine")`` the simulated machine
as well.
"""

from __future__ import annotations

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


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    skipped = [
        report
        for report in terminalreporter.stats.get("skipped", [])
        if NO_INTERPRETER in str(report.longrepr) or NO_MACHINE in str(report.longrepr)
    ]
    if skipped:
        terminalreporter.write_sep("!", f"{len(skipped)} LINUXCNC TESTS SKIPPED", red=True, bold=True)
        terminalreporter.write_line(HOW, red=True)
