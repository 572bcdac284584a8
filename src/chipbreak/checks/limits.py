"""W, the limit of an edge check: it depends on what the tool does next."""

from __future__ import annotations

from typing import NamedTuple

from chipbreak.model.kinds import Kind
from chipbreak.model.operations import Operation
from chipbreak.settings.sections import Settings


class Limit(NamedTuple):
    """W, and why."""

    w_mm: float
    reason: str
    next_kind: Kind


def limit_before(operation: Operation, settings: Settings, when: str) -> Limit:
    """W of a check that stands before an operation; ``when`` begins its reason."""
    checks, kind = settings.checks, operation.kind
    own = checks.w_mm.get(str(operation.tool))
    name = "an operation of unknown kind" if kind is Kind.UNKNOWN else kind.value.upper()
    what = f"{when} {name} ({operation.reason})"
    if own is not None:
        return Limit(own, f"{what}: checks.w_mm gives T{operation.tool} W {own:g} mm", kind)
    if kind is Kind.ROUGH:
        return Limit(checks.w_rough_mm, f"{what}: W {checks.w_rough_mm:g} mm", kind)
    if kind in (Kind.FINISH, Kind.SEMI_FINISH):
        return Limit(checks.w_finish_mm, f"{what}: W {checks.w_finish_mm:g} mm", kind)
    stricter_mm = min(checks.w_rough_mm, checks.w_finish_mm)
    return Limit(stricter_mm, f"{what}: neither rough nor finish, so the stricter W {stricter_mm:g} mm", kind)
