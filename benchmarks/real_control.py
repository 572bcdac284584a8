"""Does LinuxCNC do what the filter promises?  Cuts drawn at random, filtered, run on its simulated machine.

    sudo python benchmarks/real_control.py                  200 cuts, and 60 that nobody has looked at
    sudo python benchmarks/real_control.py --write          and the tables into docs/real-control.md
    sudo python benchmarks/real_control.py --cuts 20 --first 5000

A number is a cut (``tests/linuxcnc/drawn.py``): its path, units, feed modes, wave, stroke, ramp, and the
machine: accelerations, speeds, servo period, highest feed override.  What the axes were commanded in every
servo period is held against the promise by ``tests/linuxcnc/chips.py``, which knows nothing of the filter.
Needs LinuxCNC (tests/linuxcnc/install.sh) and root.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from linuxcnc import available
from linuxcnc.drawn import Cut, Ran, drawn, run_cuts

PAGE = Path(__file__).parents[1] / "docs" / "real-control.md"
BEGIN, END = "<!-- grid -->\n", "<!-- end of grid -->\n"
HEAD = ("cuts", "run", "refused", "N", "stroke", "ramp", "time", "verdict kept", "all kept")
HELD_OUT = 100_000
Group = Callable[[Cut], str]
GROUPS: Sequence[Group] = (
    lambda cut: "all",
    lambda cut: cut.kind.split(", ")[0],
    lambda cut: "wave: " + cut.kind.split(", ")[1],
    lambda cut: "F: " + next(one for one in cut.sets if "feed_mode" in one).split("=")[1],
    lambda cut: f"servo period {cut.machine.servo_period_s * 1000.0:g} ms",
    lambda cut: f"highest override {cut.machine.max_feed_override:g}",
    lambda cut: "inch" if b"G20" in cut.program else "mm",
)


def row(name: str, ran: Sequence[Ran], refused: int) -> tuple[str, ...]:
    """One line of the table: the worst of each figure, and how many cuts keep all."""
    kept = [one.kept for one in ran]
    worst = [
        f"{max((getattr(one, figure) for one in kept), default=0.0):.2%}"
        for figure in ("count_error", "stroke_error", "ramp_error", "time_error")
    ]
    verdicts = sum(one.verdict for one in kept)
    whole = sum(not one.misses for one in ran)
    return (name, str(len(ran)), str(refused), *worst, f"{verdicts} of {len(ran)}", f"{whole} of {len(ran)}")


def table(ran: Sequence[Ran], refused: Sequence[Cut]) -> list[str]:
    """The table in Markdown."""
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    for group in GROUPS:
        names = sorted({group(one.cut) for one in ran} | {group(cut) for cut in refused})
        for name in names:
            some = [one for one in ran if group(one.cut) == name]
            lines.append(f"| {' | '.join(row(name, some, sum(group(cut) == name for cut in refused)))} |")
    return lines


def main() -> int:
    """Print the tables; 0 when every cut keeps its promise."""
    summary, usage = (__doc__ or "").split("\n", 1)
    parser = argparse.ArgumentParser(
        description=summary, epilog=usage, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cuts", metavar="NUMBER", type=int, default=200, help="how many are drawn")
    parser.add_argument("--held", metavar="NUMBER", type=int, default=60, help="how many held out")
    parser.add_argument("--first", metavar="NUMBER", type=int, default=0, help="the number of the first one")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/real-control.md")
    options = parser.parse_args()
    if not available():
        print("LinuxCNC's simulated machine cannot be started here", file=sys.stderr)
        return 2
    told = list[str]()
    missed = list[str]()
    counts = list[int]()
    for title, first, count in (
        ("Cuts that the law was made with", options.first, options.cuts),
        ("Cuts that nobody had looked at", HELD_OUT + options.first, options.held),
    ):
        ran, refused = run_cuts([drawn(seed) for seed in range(first, first + count)])
        told += ["", f"{title}, numbers {first} to {first + count - 1}:", "", *table(ran, refused)]
        counts.append(len(ran))
        missed += [f"* {one.cut}: {', '.join(one.misses)}" for one in ran if one.misses]
    told += ["", *(["Not kept:", "", *missed] if missed else [f"All {sum(counts)} keep all of it."]), ""]
    print("\n".join(told))
    if options.write:
        before, _, rest = PAGE.read_text("utf-8").partition(BEGIN)
        _, _, behind = rest.partition(END)
        PAGE.write_text(before + BEGIN + "\n".join(told) + "\n" + END + behind, "utf-8")
    return int(bool(missed) or not all(counts))


if __name__ == "__main__":
    sys.exit(main())
