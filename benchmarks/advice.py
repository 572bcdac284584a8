"""Follow the advice of refusals: every way out that is named must be taken, and must break the chips.

    python benchmarks/advice.py                     300 refused cuts, drawn at random
    python benchmarks/advice.py --refused 50 --seed 7

Cuts (lines, facing, tapers, corners, chamfers, arcs, fillets; feeds, speeds, wishes) are drawn for the
controls of the shipped profiles, with slow axes.  Of each that is refused for what the machine can do, the
ways out are read from the message and its help, the program is changed by each, and filtered again.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import chipbreak

REFUSED = ("VIB030", "VIB031", "VIB032", "VIB034", "VIB036", "VIB060", "VIB062")
FILTERS = ("acc_dec_ms=8", "position_gain_1_s=90")
SERVO = tuple(f"axes.{axis}.{number}" for axis in "XZ" for number in FILTERS)
LATHE = "G21 G18 G99 G97 S{s} M3\n"
CENTRE = "G21 G18 G7 G90 G95 G97 S{s} M3\n"
PER_MINUTE = "G21 G18 G90 G94\nM3 S{s}\n"
GRBL = ("planner.model=junction", "axes.X.steps_per_mm=800", "axes.Z.steps_per_mm=800")
CONTROLS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "generic, resting": ("generic-lathe", LATHE.replace("G99", "G95"), ("planner.model=trapezoid",)),
    "fanuc, resting": ("fanuc-lathe", LATHE, ("planner.model=trapezoid",)),
    "fanuc, stopping": ("fanuc-lathe", LATHE, ("planner.model=trapezoid", "planner.reversal_stop_ms=2")),
    "fanuc, filters": ("fanuc-lathe", LATHE, ("planner.model=after-interpolation", *SERVO)),
    "fanuc, look-ahead": (
        "fanuc-lathe",
        LATHE,
        ("planner.model=look-ahead", "planner.joint_speed_mm_min=600", "output.feed_mode=minute", *SERVO),
    ),
    "mitsubishi, filters": ("mitsubishi-lathe", LATHE, ("planner.model=after-interpolation", *SERVO)),
    "haas, resting": ("haas-lathe", LATHE, ("planner.model=trapezoid",)),
    "linuxcnc": ("linuxcnc-lathe", CENTRE, ()),
    "linuxcnc, minute": ("linuxcnc-lathe", CENTRE, ("output.feed_mode=minute",)),
    "linuxcnc, inverse": ("linuxcnc-lathe", CENTRE, ("output.feed_mode=inverse",)),
    "grblhal": ("grblhal-lathe", PER_MINUTE.replace("G90", "G7 G90"), GRBL),
    "grbl": ("grbl", PER_MINUTE, GRBL),
}
SHAPES = {
    "line": "G0 X20. Z2.\nG1 Z-20. F{f}",
    "facing": "G0 X60. Z0.\nG1 X20. F{f}",
    "taper": "G0 X20. Z2.\nG1 X30. Z-20. F{f}",
    "corner": "G0 X20. Z2.\nG1 Z-15. F{f}\nX40.",
    "chamfer": "G0 X20. Z2.\nG1 Z-15. F{f}\nX24. Z-17.\nZ-30.",
    "arc": "G0 X20. Z0.\nG3 X40. Z-10. R10. F{f}",
    "fillet": "G0 X20. Z2.\nG1 Z-10. F{f}\nG2 X24. Z-12. R2.\nG1 X40.",
}
WISHES = (
    "N1.5",
    "N1.5",
    "N2.5",
    "N0.5",
    "N1.25 ALPHA0.75",
    "N1.5 Q1.8",
    "N1.5 WAVE SINE",
    "N1.5 EDGES2",
    "AUTO",
)
ACCELERATIONS = (300, 500, 1000, 2000, 3000)
SLOWER = re.compile(r"N ([0-9.]+) with the same feed works at f ([0-9.]+) Hz")
LOWER = re.compile(r"N ([0-9.]+) f ([0-9.]+) Hz \(S [0-9.]+\) with the same feed and stroke")
FEWER = re.compile(r"E ([0-9.]+) \(S [0-9.]+, f [0-9.]+ Hz\) with the same feed")
NEEDS = re.compile(r"needs ([0-9.e+]+) m/s2")
DWELL = re.compile(r"WAVE DWELL with E ([0-9.]+)")
AUTO = re.compile(r"\(VIB AUTO\) in place")
LARGER = re.compile(r"Q ([0-9.]+) with the same S, N and f")
SPEED = re.compile(r"S ([0-9.]+) with this feed")
FEED = re.compile(r"a feed of ([0-9.]+) mm/rev")


@dataclass(frozen=True)
class Drawn:
    """A cut for a control: feed in mm per revolution, and what its directive says."""

    control: str
    shape: str
    speed_rpm: float
    feed_mm_rev: float
    wish: str
    acceleration_mm_s2: float
    sets: tuple[str, ...] = ()

    def run(self) -> chipbreak.Result:
        """Filter it.  Errors: ProgramRejectedError."""
        profile, _, sets = CONTROLS[self.control]
        limits = [f"axes.{axis}.max_acceleration_mm_s2={self.acceleration_mm_s2}" for axis in "XZ"]
        if sets is GRBL:
            limits += [f"axes.{axis}.max_velocity_mm_min=8000" for axis in "XZ"]
        settings = chipbreak.load(profile, [*sets, *limits, "vibration.refused=error", *self.sets])
        return chipbreak.rewrite(self.text.encode(), settings)

    @property
    def text(self) -> str:
        """The program."""
        _, head, _ = CONTROLS[self.control]
        feed = self.feed_mm_rev * (self.speed_rpm if self.is_per_minute else 1.0)
        cut = SHAPES[self.shape].format(f=f"{feed:.6g}")
        return f"{head.format(s=f'{self.speed_rpm:g}')}(VIB {self.wish})\n{cut}\nG0 X80.\nM30\n"

    def ways(self, said: str) -> Iterator[tuple[str, Drawn]]:
        """What a refusal names, each with the cut that follows it."""
        kept = " ".join(re.findall(r"(?:ALPHA|EDGES)[0-9.]+|Q[0-9.]+|WAVE [A-Z]+", self.wish))
        unstroked = " ".join(re.findall(r"(?:ALPHA|EDGES)[0-9.]+", self.wish))
        without_q = re.sub(r"Q[0-9.]+", "", self.wish)
        wishes = {
            SLOWER: ("slower", "N{} F{} " + kept),
            LOWER: ("slower", "N{} F{} " + kept),
            FEWER: ("fewer vibrations", "E{} " + kept),
            DWELL: ("dwell", "E{} WAVE DWELL " + unstroked),
            LARGER: ("larger stroke", without_q + " Q{}"),
            AUTO: ("auto", "AUTO " + kept),
        }
        for pattern, (kind, wish) in wishes.items():
            for match in pattern.finditer(said):
                yield kind, replace(self, wish=wish.format(*match.groups()))
        # Of several blocks that are refused, what does for all of them.
        for speed in sorted(map(float, SPEED.findall(said)))[:1]:
            feed = self.feed_mm_rev * (self.speed_rpm / speed if self.is_per_minute else 1.0)
            yield "other speed", replace(self, speed_rpm=speed, feed_mm_rev=feed)
        for feed in sorted(map(float, FEED.findall(said)))[:1]:
            yield "other feed", replace(self, feed_mm_rev=feed)
        for need in NEEDS.findall(said) if self.wish != "AUTO" else ():
            yield "acceleration", replace(self, acceleration_mm_s2=float(need) * 1000.0)

    @property
    def is_per_minute(self) -> bool:
        """True where F of the program is mm per minute."""
        return "G94" in CONTROLS[self.control][1]


def drawn(rng: random.Random) -> Drawn:
    """Any cut."""
    return Drawn(
        rng.choice(list(CONTROLS)),
        rng.choice(list(SHAPES)),
        rng.choice((400, 800, 1200, 1800, 2400, 3000, 4000)),
        rng.choice((0.05, 0.08, 0.12, 0.2, 0.3, 0.4)),
        rng.choice(WISHES),
        rng.choice(ACCELERATIONS),
    )


def refusal_of(cut: Drawn) -> str:
    """Message and help of what the machine cannot do; empty where it can, or where it is something else."""
    try:
        cut.run()
    except chipbreak.ProgramRejectedError as error:
        said = [one for one in error.diagnostics if one.severity.value == "error"]
        if all(one.code in REFUSED for one in said):
            return " ".join(f"{one.message} {one.help}" for one in said)
    return ""


def fault_of(cut: Drawn) -> str:
    """Why a cut is not taken, or does not break its chips; empty where it does."""
    try:
        result = cut.run()
    except chipbreak.ChipbreakError as error:
        return f"refused: {error}"
    if not result.cuts:
        return "left as it was"
    return "" if all(one.verdict.breaks for one in result.cuts) else "does not break"


def main() -> int:
    """Print each way that fails, and the figures."""
    summary, usage = (__doc__ or "").split("\n", 1)
    parser = argparse.ArgumentParser(
        description=summary, epilog=usage, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--refused", type=int, default=300, help="how many refused cuts")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = random.Random(options.seed)
    followed: Counter[str] = Counter()
    failed = refused = silent = 0
    while refused < options.refused:
        cut = drawn(rng)
        said = refusal_of(cut)
        if not said:
            continue
        refused += 1
        ways = list(cut.ways(said))
        silent += not ways
        if not ways:
            print(f"no way named: {cut}\n    {said}")
        for kind, way in ways:
            followed[kind] += 1
            fault = fault_of(way)
            failed += bool(fault)
            if fault:
                print(f"FAILED {kind}: {cut}\n    {said}\n    {way.wish}: {fault}")
    count = sum(followed.values())
    print(f"{refused} refused cuts, {count} ways named, {failed} fail, {silent} cuts without any")
    print(", ".join(f"{kind} {count}" for kind, count in followed.most_common()))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
