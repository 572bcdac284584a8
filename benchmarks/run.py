"""Speed and memory of chipbreak, beside what else reads such programs.

    python benchmarks/run.py                      five rounds of everything, some minutes
    python benchmarks/run.py --only pass-through  one case
    python benchmarks/run.py --quick              ten times smaller, one round: does it still run?
    python benchmarks/run.py --before OTHER/.venv/bin/chipbreak    against another checkout alone

Ratios are the median of those of the rounds; peers come with ``pip install -e '.[bench]'``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from before import before
from edges import long_line, start_up
from expansion import emit, expansion, planned
from passing import modal, pass_through, scaling
from rows import Table, busy, machine, write_json
from stopwatch import BenchmarkError
from subject import Context

CASES: dict[str, Callable[[Context], Table]] = {
    "pass-through": pass_through,
    "modal": modal,
    "scaling": scaling,
    "expansion": expansion,
    "planned": planned,
    "emit": emit,
    "long-line": long_line,
    "start-up": start_up,
}
_BEFORE = "before"


def _arguments() -> argparse.Namespace:
    summary, usage = (__doc__ or "").split("\n", 1)
    parser = argparse.ArgumentParser(
        description=summary, epilog=usage, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="ten times smaller, one round")
    parser.add_argument("--smaller", type=int, default=10, help="with --quick: how many times smaller (10)")
    parser.add_argument("--only", metavar="NAME", action="append", choices=CASES, help=", ".join(CASES))
    parser.add_argument("--rounds", type=int, default=5, help="how often each is run (5)")
    parser.add_argument("--large", action="store_true", help="scaling up to ten million blocks")
    parser.add_argument(
        "--before", metavar="CHIPBREAK", help="run only against this other chipbreak, in turn"
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="write every sample, say to benchmarks/results.json"
    )
    return parser.parse_args()


def main() -> int:
    """Run the cases; 0 when every target is met, 1 when one is missed, 2 when a case could not be run."""
    options = _arguments()
    rounds = 1 if options.quick else options.rounds
    smaller = options.smaller if options.quick else 1
    found = machine()
    print(*(f"{key} {value}" for key, value in found.items()), f"rounds {rounds}", sep=", ")
    print(busy(found), end="\n" if busy(found) else "")
    if options.quick:
        print(f"quick: the programs are {smaller} times smaller than the targets are meant for")
    names = [_BEFORE] if options.before else options.only or list(CASES)
    measured = [_measured(name, rounds, smaller, options) for name in names]
    tables = [table for table in measured if table is not None]
    if options.json is not None:
        write_json(options.json, tables, {**found, "rounds": rounds, "quick": options.quick})
    goals_met = [row.goal.met for table in tables for row in table.rows if row.goal is not None]
    missed = goals_met.count(False)
    print(f"\n{goals_met.count(True)} targets met, {missed} missed")
    if len(tables) < len(names):
        return 2
    return int(missed > 0 and not options.quick)


def _measured(name: str, rounds: int, smaller: int, options: argparse.Namespace) -> Table | None:
    """Run one case and print what it found; None when it could not be run."""
    case = before if name == _BEFORE else CASES[name]
    with tempfile.TemporaryDirectory(prefix="chipbreak-bench-") as folder:
        try:
            table = case(Context(Path(folder), rounds, smaller, options.large, options.before))
        except (BenchmarkError, OSError) as error:
            print(f"\n{name}: *** COULD NOT BE MEASURED: {error}", file=sys.stderr)
            return None
    print(f"\n{table.text()}", flush=True)
    return table


if __name__ == "__main__":
    sys.exit(main())
