"""How far the time of a cut may be from its plan, as a share of it.

Feeds are rounded, so it differs by about half a unit in their last place.  The plan keeps closer to it than
the check of the output asks for, so that what is planned passes.
"""

from __future__ import annotations

PLANNED_TIME_SHARE = 0.004
TIME_SHARE = 0.005
