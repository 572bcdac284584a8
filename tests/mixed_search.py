"""Draws programs and compares them: ``python tests/mixed_search.py KIND [COUNT [FIRST SEED]]``.

Every program is filtered, and another reader runs the original and the result: for Fanuc's words the second
reader of the tests (``fanuc``), for LinuxCNC its own interpreter (``linuxcnc``).  ``fanuc-lines`` and
``linuxcnc-lines`` put lines and words anywhere into such programs first; one that the other reader does not
take is passed over, and what differs is to be looked at: a reader may have its own habits.  The last line
says what became of how many; exit code 1 where any differed.
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from random import Random

import chipbreak
from brackets import marked
from lines_anywhere import changed
from linuxcnc.mixed_programs import program as linuxcnc_program
from linuxcnc.test_mixed_programs import check
from second_reader.compared import checked
from second_reader.programs import program as fanuc_program
from second_reader.reader import run


def fanuc(seed: int) -> tuple[str, str]:
    """What became of a program in a word, and what the control does otherwise."""
    text, control = fanuc_program(seed)
    found, difference = checked(text, control)
    return found, difference and f"{difference}\n{control}\n{text}"


def fanuc_lines(seed: int) -> tuple[str, str]:
    """The same with lines and words anywhere."""
    text, control = fanuc_program(seed)
    text = changed(Random(seed), text, "fanuc")
    try:
        run(marked(text.encode("latin-1")).decode("latin-1"), control)
    except (AssertionError, KeyError, ValueError, ZeroDivisionError):
        return "not a program", ""
    found, difference = checked(text, control)
    return found, difference and f"{difference}\n{control}\n{text}"


def linuxcnc(seed: int) -> tuple[str, str]:
    """The same on LinuxCNC's interpreter."""
    return _on_linuxcnc(seed, lambda text: text)


def linuxcnc_lines(seed: int) -> tuple[str, str]:
    """The same with lines and words anywhere."""
    return _on_linuxcnc(seed, lambda text: changed(Random(seed), text, "linuxcnc"))


def _on_linuxcnc(seed: int, change: Callable[[str], str]) -> tuple[str, str]:
    mixed = linuxcnc_program(seed)
    mixed = mixed._replace(data=change(mixed.data.decode("latin-1")).encode("latin-1"))
    try:
        return check(mixed), ""
    except subprocess.TimeoutExpired:
        return "without an end", ""
    except (AssertionError, chipbreak.SelfCheckError) as error:
        machine = "lathe" if mixed.lathe else "mill with checks" if mixed.checked else "mill"
        return "changed", f"{error}\n{machine}\n{mixed.data.decode()}"


KINDS = {
    "fanuc": fanuc,
    "fanuc-lines": fanuc_lines,
    "linuxcnc": linuxcnc,
    "linuxcnc-lines": linuxcnc_lines,
}


def search(kind: str, count: int, first: int) -> int:
    """Try so many programs; 1 where any differed."""
    found: Counter[str] = Counter()
    wrong = 0
    for done, seed in enumerate(range(first, first + count), 1):
        word, difference = KINDS[kind](seed)
        found[word] += 1
        if difference:
            wrong += 1
            print(f"seed {seed}: {difference}", flush=True)
        if done == count or done % 1000 == 0:
            said = ", ".join(f"{number} {word}" for word, number in found.most_common())
            print(f"{done} programs: {said}; {wrong} differ", flush=True)
    return min(wrong, 1)


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[2:]]
    sys.exit(search(sys.argv[1], numbers[0] if numbers else 1000, numbers[1] if numbers[1:] else 0))
