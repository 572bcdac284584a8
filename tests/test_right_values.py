"""Small programs that once came out wrong, held to their right values (a folder in CHIPBREAK_CASES)."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

import chipbreak

FOLDER = os.environ.get("CHIPBREAK_CASES", "")
N = ("vibration.n=1.5",)
# File, profile, options, and S and stroke of each vibrated cut, or the code of the refusal.
VALUES = [
    ("public/24c-bare-g97-fanuc.nc", "fanuc-lathe", (), ["S1250 STROKE 0.12"]),
    ("public/24e-s-before-g97.nc", "fanuc-lathe", (), ["S1250 STROKE 0.12"]),
    ("public/24f-s-with-dwell-silent.ngc", "linuxcnc-lathe", (), ["S1111 STROKE 0.1245"]),
    ("public/24g-s-with-dwell-fanuc.nc", "fanuc-lathe", (), ["S1250 STROKE 0.12"]),
    ("public/24h-f-with-dwell.ngc", "linuxcnc-lathe", (), ["S1000 STROKE 0.24"]),
    ("public/24k-s-dwell-then-plain.nc", "fanuc-lathe", (), ["S1250 STROKE 0.12"]),
    ("public/01a-units-after-feed.ngc", "linuxcnc-lathe", (), "VIB013"),
    ("public/01d-units-after-feed-next.ngc", "linuxcnc-lathe", (), "VIB013"),
    ("public/32a-two-paths.nc", "fanuc-lathe", (), "VIB069"),
    ("public/32c-path-inline.nc", "fanuc-lathe", (), "VIB048"),
    ("public/09d-unclosed.ngc", "linuxcnc-lathe", (), "SYN003"),
    ("held/start-behind-cycle.nc", "fanuc-lathe", N, ["S1000 STROKE 0.12"]),
    ("held/clamp-rounding.nc", "fanuc-lathe", N, ["S667 STROKE 0.2556"]),
    ("held/bar-puller.nc", "fanuc-lathe", N, ["S1000 STROKE 0.12"]),
    ("held/no-length.nc", "fanuc-lathe", N, ["S1000 STROKE 0.24"]),
    ("held/unreadable-head.nc", "fanuc-lathe", N, ["S1000 STROKE 0.12"]),
    ("held/g71-in-contour.nc", "fanuc-lathe", (), []),
]


@pytest.mark.skipif(not FOLDER, reason="CHIPBREAK_CASES names no folder")
@pytest.mark.parametrize(("name", "profile", "sets", "wanted"), VALUES, ids=[row[0] for row in VALUES])
def test_right_values(name: str, profile: str, sets: tuple[str, ...], wanted: list[str] | str) -> None:
    program = (Path(FOLDER) / name).read_bytes()
    settings = chipbreak.load(profile, sets)
    if isinstance(wanted, str):
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            chipbreak.rewrite(program, settings, name)
        assert wanted in {d.code for d in caught.value.diagnostics if d.severity.value == "error"}
        return
    result = chipbreak.rewrite(program, settings, name)
    titles = re.findall(rb"BEGIN VIB [^)]*(S[0-9.]+ STROKE [0-9.]+)", result.data)
    assert [title.decode() for title in titles] == wanted
    assert chipbreak.restore(result.data) == program
