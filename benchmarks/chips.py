"""Do chips break on a real control?  The filter's blocks and naive ones, run on LinuxCNC's simulated machine.

    sudo python benchmarks/chips.py               the whole grid, some minutes
    sudo python benchmarks/chips.py --only arc    the programs with "arc" in their name

Needs LinuxCNC (tests/linuxcnc/install.sh) and root.  *Naive* is one block for every 4 ms with F = length /
time, as if the control followed it, in the program's own G64.  Chips are worked out from the sampled places
of the axes by ``tests/linuxcnc/chips.py``, which knows nothing of the filter.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from linuxcnc import available
from linuxcnc.vibrated import NAIVE, Job, Outcome, grid, run

HEAD = (
    "program",
    "m/s²",
    "wave, F",
    "asked Hz, N",
    "naive Hz, N",
    "naive breaks",
    "filter Hz, N",
    "filter breaks",
)


def share_broken(outcome: Outcome) -> float:
    """How many of the vibrations at full stroke ended a chip."""
    turns = outcome.vibration().turns
    return min(1.0, outcome.chips().broken / max(1, turns - 1)) if turns else 0.0


def reached(outcome: Outcome) -> str:
    hertz = outcome.vibration().frequency_hz
    return f"{hertz:.2f}, {hertz * 60.0 / outcome.promise.wave.speed_rpm:.3f}"


def breaks(outcome: Outcome) -> str:
    share = share_broken(outcome)
    return "yes" if share > 0.9 else "**no**" if share < 0.1 else f"{share:.0%} of the chips"


def row(job: Job, naive: Outcome, ours: Outcome) -> tuple[str, ...]:
    cut = ours.promise.plan
    mode = next((s.split("=")[1] for s in job.sets if s.startswith("output.feed_mode")), "rev")
    share = f" {cut.wave.alpha_share:.2g}" if "vibration.alpha=0.75" in job.sets else ""
    return (
        f"{job.shape.name}, S{cut.wave.speed_rpm:g}",
        f"{job.acceleration_mm_s2 / 1000:g}",
        f"{cut.wave.waveform}{share}, {mode}",
        f"{1.0 / cut.wave.period_s:.2f}, {cut.solution.per_rev:.3f}",
        reached(naive),
        breaks(naive),
        reached(ours),
        breaks(ours),
    )


def main() -> int:
    """Print the table; 0 when every cut of the filter breaks its chips."""
    summary, usage = (__doc__ or "").split("\n", 1)
    parser = argparse.ArgumentParser(
        description=summary, epilog=usage, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", metavar="WORD", default="", help="programs with this in their name")
    only = parser.parse_args().only
    if not available():
        print("LinuxCNC's simulated machine cannot be started here", file=sys.stderr)
        return 2
    jobs = [job for job in grid() if job.breaks and only in str(job)]
    naive, ours = run(jobs, *NAIVE, speed=1.0), run(jobs, speed=1.0)
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    for columns in map(row, jobs, naive, ours):
        print("| " + " | ".join(columns) + " |")
    for name, outcomes in (("naive", naive), ("filter", ours)):
        whole, none = (
            sum(test(share_broken(one)) for one in outcomes)
            for test in (lambda s: s > 0.9, lambda s: s < 0.1)
        )
        print(f"\n{name}: {whole} of {len(jobs)} cuts break every chip, {none} break none", end="")
    print()
    return int(any(share_broken(one) <= 0.9 for one in ours))


if __name__ == "__main__":
    sys.exit(main())
