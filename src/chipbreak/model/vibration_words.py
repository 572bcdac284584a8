"""Which words of a block ask for vibration.

The custom words N (vibrations per revolution), f (frequency), E (revolutions per vibration) and Q (stroke
as a multiple of the feed) must never be mistaken for what they mean on the control:

* the first N of a block is its sequence number, always, and never gets here;
* a further N counts only beside an axis word and in no block with a jump or a cycle;
* f is a frequency only in a block that also has an upper-case F or another of these words;
* E and Q count only in a plain feed move without a G code that is not known, because cycles and macro calls
  have words of the same letters.
"""

from __future__ import annotations

from collections.abc import Collection

from chipbreak.syntax.nodes import Block, Word

_LETTERS = frozenset("NfEQ")


def vibration_words(
    block: Block, axis_letters: Collection[str], *, cuts: bool, has_once: bool
) -> tuple[Word, ...]:
    """The vibration words of a block.

    ``cuts`` is true under G1, G2 or G3; ``has_once`` where a non-modal code reads the block's words itself.
    """
    if not any(w.letter in _LETTERS for w in block.words):
        return ()
    if has_once or block.statements or not block.has_any(axis_letters):
        return ()
    words = [w for w in block.words if w.letter == "N" or (cuts and w.letter in "EQ")]
    has_feed = block.has_letter("F")
    if words or has_feed:
        words += [w for w in block.words if w.letter == "f"]
    return tuple(sorted(words, key=lambda w: w.start))
