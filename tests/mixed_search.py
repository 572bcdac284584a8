"""Draws programs and compares them: ``python tests/mixed_search.py fanuc|linuxcnc [COUNT [FIRST SEED]]``.

Every program is filtered, and another reader runs the original and the result: for Fanuc's words the second
reader of the tests, for LinuxCNC its own interpreter.  The last line says what became of how many; exit code
1 where any differed.
"""

from __future__ import annotations

import sys
from collections import Counter

import chipbreak
from linuxcnc.mixed_programs import program as linuxcnc_program
from linuxcnc.test_mixed_programs import check
from second_reader.compared import checked
from second_reader.programs import program as fanuc_program


def fanuc(seed: int) -> tuple[str, str]:
    """What became of a program in a word, and what the control does otherwise."""
    text, control = fanuc_program(seed)
    found, difference = checked(text, control)
    return found, difference and f"{difference}\n{control}\n{text}"


def linuxcnc(seed: int) -> tuple[str, str]:
    """The same on LinuxCNC's interpreter."""
    mixed = linuxcnc_program(seed)
    try:
        return check(mixed), ""
    except (AssertionError, chipbreak.SelfCheckError) as error:
        machine = "lathe" if mixed.lathe else "mill with checks" if mixed.checked else "mill"
        return "changed", f"{error}\n{machine}\n{mixed.data.decode()}"


def search(control: str, count: int, first: int) -> int:
    """Try so many programs; 1 where any differed."""
    found: Counter[str] = Counter()
    wrong = 0
    for done, seed in enumerate(range(first, first + count), 1):
        word, difference = {"fanuc": fanuc, "linuxcnc": linuxcnc}[control](seed)
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
