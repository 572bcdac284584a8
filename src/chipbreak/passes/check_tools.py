"""Insert tool checks.

::

    N245 G0 Z15.                 N245 G0 Z15.
    (FINISH POCKET)       ->     M9
    N250 G0 X10. Y20.            G91 G28 Z0.
                                 G90
                                 M5
                                 G65 P8903 T2. W0.02 D1.
                                 S5000 M3
                                 G0 X41.5 Y-3.
                                 M8
                                 G0 G43 H2 Z15.
                                 (FINISH POCKET)
                                 N250 G0 X10. Y20.

What plans these checks is imported where a profile asks for them.
"""

from __future__ import annotations

from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.settings.checking import SettingsError
from chipbreak.text.diagnostics import RefusalError

CHECK_TOOLS = "check_tools"


class CheckTools(Pass):
    """Checks of tools between operations, where the machine can be left and found again."""

    name = CHECK_TOOLS

    def plan(self, context: Context) -> Planned:
        """The insertions of all checks, and what could not be checked.

        Raises ToolFileError for a file of tools, and SettingsError for calls, that cannot be used.
        """
        try:
            return self._plan(context)
        except RefusalError as error:
            raise SettingsError.of(error, context.settings.name) from None

    def _plan(self, context: Context) -> Planned:
        tools = context.tools
        if not context.settings.checks.enabled:
            return Planned()
        from chipbreak.checks.check_edits import edits_of_checks

        edits, found = edits_of_checks(context.interpreted, context.operations, context.main, tools)
        return Planned(edits, found)
