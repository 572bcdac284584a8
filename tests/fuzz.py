"""Runs the property tests with new seeds until the time is over: ``python tests/fuzz.py [SECONDS [SEED]]``.

``make test`` draws the same examples every time.  This draws others: round after round with another seed,
each round with the tests in another order, so that a short search reaches other tests than the last one.
When the time is over no further test is started and no further example tried; one that has failed is still
made small first.

The file is also the pytest plugin that does so; the two numbers reach it in the environment.
"""

from __future__ import annotations

import functools
import os
import random
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis.errors import UnsatisfiedAssumption

TESTS = Path(__file__).parent
SEED, END = "CHIPBREAK_FUZZ_SEED", "CHIPBREAK_FUZZ_END"
COMMAND = [
    *(sys.executable, "-m", "pytest", "-p", "fuzz", "-m", "hypothesis", "-n", "auto", "-q", "-rfE"),
    *("--no-header", "--hypothesis-profile=fuzz", "--maxfail=1"),
]
FOUND = """
Seed {seed} has found something.  To see it again:
    {python} -m pytest -m hypothesis --hypothesis-profile=fuzz --hypothesis-seed={seed} {tests}
To keep it, so that every `make test` tries it: add the example that is shown above to its test as
    @example(...)
above its @given(...), or a test of its own where the example says more than its law.  A program that the
filter spoils or refuses becomes a file in tests/cases/ or tests/bad/.  Then mend the kind, not the case.
"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Shuffle the tests, every worker in the same way, and let none of them try examples for ever."""
    random.Random(os.environ[SEED]).shuffle(items)
    for handle in {id(one): one for item in items if (one := _handle(item)) is not None}.values():
        handle.inner_test = until_the_end(handle.inner_test, float(os.environ[END]))


def _handle(item: pytest.Item) -> Any:
    """Where hypothesis keeps what it calls for each example; tests of one function share it."""
    return getattr(getattr(item, "obj", None), "hypothesis", None)


def until_the_end(inner: Callable[..., object], end: float) -> Callable[..., object]:
    """The test of one example, which does nothing when the time is over, unless an example has failed."""
    has_failed = False

    @functools.wraps(inner)
    def bounded(*arguments: object, **named: object) -> object:
        nonlocal has_failed
        if time.time() > end and not has_failed:
            return None
        try:
            return inner(*arguments, **named)
        except Exception as error:
            has_failed = has_failed or not isinstance(error, UnsatisfiedAssumption)
            raise

    return bounded


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Start no test when the time is over."""
    if time.time() > float(os.environ[END]):
        pytest.skip("the time is over")


def search(seconds: float, first_seed: int | None) -> int:
    """Search for so long; 0 when nothing was found."""
    end = time.time() + seconds
    seeds = random.SystemRandom()
    seed = seeds.randrange(2**32) if first_seed is None else first_seed
    rounds = 0
    while time.time() < end:
        print(f"seed {seed}", flush=True)
        environment = os.environ | {SEED: str(seed), END: str(end), "PYTHONPATH": str(TESTS)}
        command = [*COMMAND, f"--hypothesis-seed={seed}", str(TESTS)]
        if subprocess.run(command, env=environment, check=False).returncode:
            print(FOUND.format(seed=seed, python=sys.executable, tests=TESTS))
            return 1
        seed = seeds.randrange(2**32)
        rounds += 1
    print(f"nothing found in {rounds} rounds")
    return 0


if __name__ == "__main__":
    arguments = sys.argv[1:]
    sys.exit(search(float(arguments[0] if arguments else 120), int(arguments[1]) if arguments[1:] else None))
