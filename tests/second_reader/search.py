"""Draws programs and compares them: ``python tests/second_reader/search.py [COUNT [FIRST SEED]]``.

Every program is filtered, and a second reader of Fanuc's words runs the original and the result; see
``compared``.  The last line says what became of how many; exit code 1 where any differed.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from second_reader.compared import checked
from second_reader.programs import program


def search(count: int, first: int) -> int:
    found: Counter[str] = Counter()
    wrong = 0
    for seed in range(first, first + count):
        text, control = program(seed)
        word, difference = checked(text, control)
        found[word] += 1
        if difference:
            wrong += 1
            print(f"seed {seed}: {difference}\n{control}\n{text}", flush=True)
    said = ", ".join(f"{number} {word}" for word, number in found.most_common())
    print(f"{count} programs: {said}; {wrong} differ")
    return min(wrong, 1)


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[1:]]
    sys.exit(search(numbers[0] if numbers else 1000, numbers[1] if numbers[1:] else 0))
