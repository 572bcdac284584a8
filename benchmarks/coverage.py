"""How much of real lathe programs vibrates, and what keeps the rest from it.

    python benchmarks/coverage.py FOLDER...              every file below, N chosen by the machine
    python benchmarks/coverage.py FOLDER --set vibration.n=1.5 --files
    python benchmarks/coverage.py --page > docs/coverage.md

The machine is ``fanuc-lathe`` with the trapezoid law and 5 m/s² in X and Z, unless ``--profile`` and
``--set`` say otherwise.  A program counts as *out* when the filter gives output.  Length is that of the feed
moves of G1 to G3, G71 to G73 written out, without G70; passes on the way back through air, and moves with the
spindle stopped, are no cuts.

``--page`` asks another question of every lathe program at hand (``samples``, the tests, and the folders of
``CHIPBREAK_CORPUS`` that have lathe in their name): does every roughing cut vibrate when the profile says
nothing but ``n`` and ``only = ["rough"]``?  What control a program is for, and which code turns its spindle,
is no wish: where a program shows it, a profile beside it (``tests/shop``) or in ``benchmarks/facts`` says it.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from chipbreak import ChipbreakError, ProgramRejectedError, load, rewrite
from chipbreak.kinematics.toolpath import path_of
from chipbreak.model.block_effect import Move
from chipbreak.model.from_source import interpret_source
from chipbreak.pipeline import Result
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import RefusalError, Severity
from chipbreak.text.source import read
from chipbreak.vibration.chain import leg_of

MACHINE = (
    'planner.model="trapezoid"',
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
)
AUTO = 'vibration.n="auto"'
ROUGH = 'vibration.only=["rough"]'
# The program's own wishes would answer another question.
_WISH = re.compile(rb"\(VIB[^)\r\n]*\)")
_FINISHING = re.compile(rb"\bG70\s*[PQ][^\r\n]*", re.IGNORECASE)
ROOT = Path(__file__).resolve().parents[1]
FACTS = ROOT / "benchmarks" / "facts"
AT_HAND = ("samples", "tests/shop")
TOO_SHORT = "VIB013"
OTHER_CONTROLS = b"$"  # Okuma: $NAME.MIN%
SUFFIXES = frozenset({".nc", ".ngc", ".cnc", ".tap", ".txt"})
HEAD = """# Coverage

Does a lathe program come out with every roughing cut vibrated, when the profile says nothing but `n` and
`only = ["rough"]`? With `n = 1.5` the profile is `fanuc-lathe` (`linuxcnc-lathe` for `.ngc`) as it is
shipped; with `n = "auto"` it has the trapezoid law and 5 m/s2 in X and Z besides, for the machine must choose
by something. Which control a program is for, and which code of its builder turns the spindle, are facts of
the machine: where a program shows them, its profile says them (*The machine of a program* below), and nothing
else. A program roughs where a cycle, a comment or the name of a tool says so. A cut in which not even
two vibrations have room (VIB013) counts as met; what a program itself asks for, `(VIB ...)`, is taken out.
Programs of controls that are not read here (Okuma, whose files begin with `$`) are left out.

The last column is about length: of all cuts of G1 to G3 and G71 to G73 (no threads, no rapids, no ways back
through air, nothing while the spindle stands), how much vibrates with `n = "auto"` and nothing else. Cuts
that finish count in it, and vibrate only when they are asked for by name. This page is printed by

```text
CHIPBREAK_CORPUS=FOLDER python benchmarks/coverage.py --page > docs/coverage.md
```

with a folder of real programs written by others, which are not part of the repository.
"""


@dataclass
class Coverage:
    """What became of one program: lengths in mm, and the reasons with the length that each one costs."""

    name: str
    is_out: bool = False
    cuts: int = 0
    vibrated_mm: float = 0.0
    total_mm: float = 0.0
    seconds: float = 0.0
    reasons: Counter[str] = field(default_factory=Counter)


def length_mm(move: Move) -> float:
    """How long a feed move is; 0 where a place is not known."""
    try:
        found = path_of([leg_of(move)]).length_mm
    except (RefusalError, ValueError):
        return 0.0
    return 0.0 if math.isnan(found) else found


def total_mm(data: bytes, settings: Settings) -> float:
    """The length of all cuts of a program as it is written."""
    interpreted = interpret_source(read(data), settings)
    body = interpreted.program.source.body
    moves = (e.move for e in interpreted.effects_of(body.start, body.stop) if not e.in_contour)
    return sum(length_mm(move) for move in moves if move is not None and move.is_cut)


def measure(path: Path, settings: Settings, plain: Settings) -> Coverage:
    """Run one program."""
    found = Coverage(path.name)
    data = path.read_bytes()
    began = time.perf_counter()
    try:
        result = rewrite(data, settings, str(path))
    except ProgramRejectedError as error:
        worst = next(one for one in error.diagnostics if one.severity is Severity.ERROR)
        found.reasons[f"rejected {worst.code}: {worst.message[:70]}"] += 1
    except ChipbreakError as error:
        found.reasons[f"rejected {type(error).__name__}: {str(error)[:70]}"] += 1
    else:
        found.is_out = True
        take(found, result)
    found.seconds = time.perf_counter() - began
    try:
        roughed = _FINISHING.sub(b"", data)
        found.total_mm = total_mm(rewrite(roughed, plain, str(path)).source.data, settings)
    except ChipbreakError:
        found.total_mm = total_mm(data, settings)
    return found


def take(found: Coverage, result: Result) -> None:
    """What vibrates, and the length that each reason leaves."""
    found.cuts = len(result.cuts)
    found.vibrated_mm = sum(cut.plan.path.length_mm for cut in result.cuts)
    for left in result.left:
        if left.is_cut or not left.said.code:
            found.reasons[f"{left.said.code or 'air'}: {left.said.message[:70]}"] += 1


@dataclass
class Answer:
    """What became of the roughing cuts of a program with one N: how many vibrate, and why others do not."""

    vibrated: int = 0
    roughs: bool = True
    reasons: Counter[str] = field(default_factory=Counter)

    @property
    def is_whole(self) -> bool:
        """True where every roughing cut vibrates that is long enough."""
        return self.vibrated > 0 and all(reason.startswith(TOO_SHORT) for reason in self.reasons)


def answer_of(path: Path, asked: Sequence[str]) -> Answer:
    """Run a program with a profile that asks for its roughing cuts."""
    profile = profile_of(path)
    found = Answer()
    try:
        result = rewrite(_WISH.sub(b"", path.read_bytes()), load(profile, [ROUGH, *asked]), path.name)
    except ProgramRejectedError as error:
        worst = next(one for one in error.diagnostics if one.severity is Severity.ERROR)
        found.reasons[f"{worst.code}: {worst.message}"] += 1
        return found
    except ChipbreakError as error:
        found.reasons[f"{type(error).__name__}: {error}"] += 1
        return found
    found.vibrated = len(result.cuts)
    for left in result.left:
        if left.is_cut and left.said.code:
            found.reasons[f"{left.said.code}: {left.said.message}"] += 1
    found.roughs = bool(found.vibrated or found.reasons)
    return found


def programs_at_hand() -> dict[str, list[Path]]:
    """The lathe programs by where they come from."""
    found = {name: programs_in(ROOT / name) for name in AT_HAND}
    corpus = os.environ.get("CHIPBREAK_CORPUS")
    if corpus:
        folders = [one for one in sorted(Path(corpus).rglob("*lathe*")) if one.is_dir()]
        found["programs of others"] = [path for one in folders for path in programs_in(one)]
    return found


def programs_in(folder: Path) -> list[Path]:
    """The programs of a folder, by name."""
    paths = [path for path in sorted(folder.iterdir()) if path.suffix.lower() in SUFFIXES]
    lathes = [path for path in paths if "mill" not in path.stem]
    return [path for path in lathes if not path.read_bytes().startswith(OTHER_CONTROLS)]


class Asked(NamedTuple):
    """A program with the answers to both questions."""

    path: Path
    one: Answer
    auto: Answer
    length: Coverage

    @property
    def roughs(self) -> bool:
        """True where something of it is asked."""
        return self.one.roughs or self.auto.roughs

    @property
    def is_whole(self) -> bool:
        """True where both answers are."""
        return self.one.is_whole and self.auto.is_whole


def asked_of(path: Path) -> Asked:
    """Ask all questions of a program."""
    profile = profile_of(path)
    settings = load(profile, [*MACHINE, AUTO])
    plain = load(profile, [*MACHINE, 'cycles.unroll="always"'])
    one = answer_of(path, ["vibration.n=1.5"])
    auto = answer_of(path, [*MACHINE, AUTO])
    return Asked(path, one, auto, measure(path, settings, plain))


def profile_of(path: Path) -> str:
    """The profile of a program: that of its facts, or the shipped one of its control."""
    facts = facts_of(path)
    if facts is not None:
        return str(facts)
    return "linuxcnc-lathe" if path.suffix == ".ngc" else "fanuc-lathe"


def facts_of(path: Path) -> Path | None:
    """The profile with what a program shows of its machine, None where there is none."""
    places = (path.with_suffix(".toml"), FACTS / f"{path.stem}.toml")
    return next((place for place in places if place.is_file()), None)


def facts_row(path: Path, facts: Path) -> str:
    """A program, the keys that its profile says, and by what the program shows them."""
    text = facts.read_text("utf-8")
    said = tomllib.loads(text)
    base = said.pop("base")
    keys = [f"`{part}.{key} = {value!r}`" for part, keys in said.items() for key, value in keys.items()]
    shown = text.split("\n", 1)[0].removeprefix("# ")
    return f"| {path.name} | {', '.join([f'`{base}`', *keys])} | {shown} |".replace("'", '"')


def print_page() -> None:
    """The page: a table of counts, and each program that is not whole, with its reasons."""
    answers = {name: [asked_of(path) for path in paths] for name, paths in programs_at_hand().items()}
    print(HEAD)
    print("| programs | at hand | rough | all vibrated, n = 1.5 | all vibrated, n = auto | of the length |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, asked in answers.items():
        print(f"| {name} | {' | '.join(map(str, counts_of(asked)))} | {share_of(asked)} |")
    every = [one for asked in answers.values() for one in asked]
    at_hand, rough, *whole = counts_of(every)
    shares = [f"{count} ({count / max(rough, 1):.0%})" for count in whole]
    print(f"| together | {at_hand} | {rough} | {' | '.join(shares)} | {share_of(every)} |")
    print("\n## The others\n\n| program | n = 1.5 | n = auto |\n| --- | --- | --- |")
    print("\n".join(row_of(*one[:3]) for one in every if one.roughs and not one.is_whole))
    print("\n## The machine of a program\n\n| program | profile | it shows that |\n| --- | --- | --- |")
    found = [(one.path, facts_of(one.path)) for one in every]
    print("\n".join(facts_row(path, facts) for path, facts in found if facts is not None))


def counts_of(asked: Sequence[Asked]) -> list[int]:
    """How many there are, how many rough, and of how many all vibrates, with each N."""
    rough = [one for one in asked if one.roughs]
    whole = [sum(one.one.is_whole for one in rough), sum(one.auto.is_whole for one in rough)]
    return [len(asked), len(rough), *whole]


def share_of(asked: Sequence[Asked]) -> str:
    """How much of the length of all cuts vibrates."""
    vibrated = sum(one.length.vibrated_mm for one in asked)
    total = sum(one.length.total_mm for one in asked)
    return f"{vibrated / total:.0%} of {total / 1000.0:.1f} m" if total else "no cuts"


def row_of(path: Path, one: Answer, auto: Answer) -> str:
    """A program that is not whole: how many of its cuts vibrate, and the reasons of the others."""
    return f"| {path.name} | {told(one)} | {told(auto)} |"


def told(answer: Answer) -> str:
    """``3 vibrate; 2 x VIB013: too short to vibrate ...``."""
    if answer.is_whole:
        return "all"
    reasons = [f"{count} x {reason}" for reason, count in answer.reasons.most_common(3)]
    said = "; ".join([f"{answer.vibrated} vibrate", *reasons]) if reasons else "no cut is asked"
    return said.replace("|", "/")


def main() -> int:
    """Print a line a file where asked, the shares, and the reasons, the most frequent first."""
    summary, usage = (__doc__ or "").split("\n", 1)
    parser = argparse.ArgumentParser(
        description=summary, epilog=usage, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--page", action="store_true", help="print docs/coverage.md")
    parser.add_argument("--profile", default="fanuc-lathe")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="sets")
    parser.add_argument("--files", action="store_true", help="a line a file")
    options = parser.parse_args()
    if options.page:
        print_page()
        return 0
    asked = [
        *MACHINE,
        *([] if any("vibration.n" in one for one in options.sets) else [AUTO]),
        *options.sets,
    ]
    settings = load(options.profile, asked)
    control = [one for one in options.sets if not one.startswith("vibration.")]
    plain = load(options.profile, [*MACHINE, *control, 'cycles.unroll="always"'])
    paths = [p for f in options.folders for p in (sorted(f.rglob("*")) if f.is_dir() else [f]) if p.is_file()]
    all_of = [measure(path, settings, plain) for path in paths]
    if options.files:
        for one in all_of:
            print_file(one)
    print_shares(all_of)
    return 0


def print_file(one: Coverage) -> None:
    """A line for a file, and its most frequent reasons."""
    share = one.vibrated_mm / one.total_mm if one.total_mm else 0.0
    state = "out" if one.is_out else "---"
    cuts = f"{one.cuts:4} cuts {share:4.0%} of {one.total_mm:8.0f} mm"
    print(f"{state} {cuts} {one.seconds:5.1f} s {one.name}")
    for reason, count in one.reasons.most_common(3):
        print(f"        {count:4} x {reason}")


def print_shares(all_of: Sequence[Coverage]) -> None:
    """What comes out, how much of it vibrates, and the reasons of what does not."""
    count = len(all_of)
    out = sum(one.is_out for one in all_of)
    cutting = sum(one.cuts > 0 for one in all_of)
    vibrated = sum(one.vibrated_mm for one in all_of)
    total = sum(one.total_mm for one in all_of)
    print(f"{out} of {count} programs come out, {cutting} with a vibrated cut")
    print(f"{vibrated:.0f} of {total:.0f} mm vibrate ({vibrated / total if total else 0.0:.0%})")
    seconds = [one.seconds for one in all_of]
    print(f"{sum(seconds):.1f} s in all, at most {max(seconds, default=0.0):.1f} s")
    reasons: Counter[str] = Counter()
    for one in all_of:
        reasons.update(one.reasons)
    for reason, times in reasons.most_common(25):
        print(f"{times:6} x {reason}")


if __name__ == "__main__":
    sys.exit(main())
