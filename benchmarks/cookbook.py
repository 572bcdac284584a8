"""The table and the figures of docs/cookbook.md, by the commands that stand in it.

``python benchmarks/cookbook.py`` writes the page anew; ``--check`` says whether it would change.  Every row
is the first row of the command behind it, so that anybody can run it with the numbers of another machine.
"""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

CHECKOUT = Path(__file__).parents[1]
PAGE = CHECKOUT / "docs" / "cookbook.md"
PROFILE = "samples/cookbook-lathe.toml"
_BEGIN = "<!-- made by make cookbook -->\n"
_END = "<!-- up to here -->\n"
_MARKED = re.compile(f"{re.escape(_BEGIN)}(.*?){re.escape(_END)}", re.DOTALL)


class Recipe(NamedTuple):
    """A cut as a machinist has it: what is cut, how, V [m/min], feed [mm/rev], diameter and length [mm]."""

    material: str
    cut: str
    surface_m_min: int
    feed_mm_rev: float
    diameter_mm: int
    length_mm: int
    axis: str = "Z"

    def command(self) -> str:
        """The command that says how its chips break."""
        cut = f"--feed {self.feed_mm_rev:g} --diameter {self.diameter_mm} --length {self.length_mm}"
        axis = "" if self.axis == "Z" else f" --axis {self.axis}"
        return f"chipbreak advise -p {PROFILE} --surface {self.surface_m_min} {cut}{axis}"


RECIPES = (
    Recipe("steel C45", "rough turning", 180, 0.25, 50, 60),
    Recipe("steel C45", "facing", 180, 0.15, 60, 25, "X"),
    Recipe("steel C45", "boring", 120, 0.1, 25, 30),
    Recipe("low-carbon steel S235", "rough turning", 200, 0.2, 50, 60),
    Recipe("alloy steel 42CrMo4", "rough turning", 140, 0.2, 45, 80),
    Recipe("stainless 1.4301", "rough turning", 120, 0.2, 40, 60),
    Recipe("stainless 1.4301", "boring", 90, 0.08, 20, 30),
    Recipe("titanium Ti-6Al-4V", "rough turning", 50, 0.15, 40, 60),
    Recipe("Inconel 718", "rough turning", 35, 0.15, 50, 40),
    Recipe("aluminium 6061", "rough turning", 250, 0.15, 40, 60),
    Recipe("copper Cu-ETP", "rough turning", 200, 0.1, 30, 50),
    Recipe("PEEK, POM", "rough turning", 200, 0.12, 30, 50),
)
FIGURES = {
    "figures/cookbook-s-n.svg": f"{RECIPES[0].command()} -o docs/figures/cookbook-s-n.svg",
    "figures/cookbook-chips.svg": f"chipbreak plot -p {PROFILE} samples/cookbook.ngc -f chips"
    " -o docs/figures/cookbook-chips.svg",
}


def chipbreak(command: str, *more: str) -> str:
    """Run a command as the page shows it, in the checkout; what it prints."""
    words = [sys.executable, "-m", *shlex.split(command), *more]
    done = subprocess.run(words, cwd=CHECKOUT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{command}\n{done.stderr}")
    return done.stdout


def row(recipe: Recipe) -> str:
    """A row of the table."""
    told: dict[str, Any] = json.loads(chipbreak(recipe.command(), "--rows", "1", "--json"))
    best = told["rows"][0]
    return " | ".join(
        (
            f"| {recipe.material}",
            recipe.cut,
            f"{recipe.surface_m_min}",
            f"{recipe.feed_mm_rev:g}",
            f"{recipe.diameter_mm}",
            f"{best['speed_rpm']:.0f}",
            f"{best['per_rev']:.3g}",
            f"{best['frequency_hz']:.3g}",
            f"{best['stroke_mm'] / recipe.feed_mm_rev:.2f}",
            f"{best['longest_chip_mm']:.0f}",
            f"{100.0 * best['acceleration_share']:.0f} %",
            f"`{best['directive']}` |",
        )
    )


_COLUMNS = ("material", "cut", "V m/min", "F mm/rev", "D mm", "S rpm", "N", "f Hz", "Q", "chip mm")
_COLUMNS += ("of the axis", "in the program")
HEAD = f"| {' | '.join(_COLUMNS)} |\n| {' | '.join('---' for _ in _COLUMNS)} |\n"


def made() -> str:
    """What stands between the marks of the page."""
    rows = "".join(f"{row(recipe)}\n" for recipe in RECIPES)
    commands = "".join(f"    {recipe.command()}\n" for recipe in RECIPES)
    return f"{HEAD}{rows}\nEach row is the first row of one of these:\n\n{commands}"


def main() -> int:
    """The command."""
    page = PAGE.read_text("utf-8")
    new = _MARKED.sub(lambda match: f"{_BEGIN}{made()}{_END}", page)
    if "--check" in sys.argv[1:]:
        return int(new != page)
    PAGE.write_text(new, "utf-8")
    for name, command in FIGURES.items():
        (PAGE.parent / name).parent.mkdir(exist_ok=True)
        chipbreak(command)
    return 0


if __name__ == "__main__":
    sys.exit(main())
