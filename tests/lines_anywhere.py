"""Lines and words put anywhere into a program, for searches with an interpreter that we did not write.

What a generator writes is what its author thought of: a block that may be skipped stands where he put it, and
says again what he knew to be lost.  Here a line of any kind stands between any two others, a word beside any
others, a number is another one, lines change places.
"""

from __future__ import annotations

import re
from random import Random

# What both controls know; then what only one of them does.
_LINES = """
G54 | G55 | G17 | G18 | G19 | F0.1 | F200. | F5. | S0 | S1000 M4 | S1000 | M3 | M4 | M5 | M3 S500
G97 S1200 | G96 S100 | G96 | G97 | G90 | G91 | G20 | G21 | G40 | G80 | G0 | G28 X5. | G53 G0 X0. Z0.
G52 X1. | G52 X0. | G10 L2 P1 X1. Z2. | G10 L2 P0 Z1. | T1 | T2 M6 | M6 | M0 | M1 | M7 | M8 | M9 | M8 M3
/G0 X5. | /G1 Z-1. | /M3 | /M5 | /F3. | /S900 | /G98 | /G20 | /G91 | /M8 | /G96 S90 | (VIB AUTO)
(VIB N0.5) | (VIB N1.5) | (VIB OFF) | (FINISH) | M98 P100 | M99 | M2 | M30 | % | X13. | Z7. | X9. Z9.
G1 Z8. F0.1 | G1 X9. F0.1 | G0 X12. Z9. | G2 X12. Z8. R5. | G3 X12. Z8. R5. | G1 X12. Z7. F0.2 M8
G1 Z6. M5 | G1 Z6. S400 | S1500 F0.15 | M3 S900 F0.1 G1 Z8. | G0 X8. G20 | G1 X8. G95 F0.1
G1 X8. G94 F60. | N100 G1 Z7. | N5 X8. | G83 X1. Z-2. R1. Q0.5 F100. | G4 P1.
"""
_LINUXCNC = """
G59.1 | G61 | G64 | G64 P0.01 | G64 P0.1 Q0.02 | G93 | G94 | G95 | G98 | G99 | G96 D2000 S80 | G7 | G8
G90.1 | G91.1 | G92 X1 Z1 | G92.1 | G92.2 | G92.3 | G43 H2 | G49 | G43.1 Z1 | G10 L20 P1 X1 | G33 Z-5 K1
G33.1 Z-5 K1 | G28.1 | G30.1 | G53 G1 X1 F10 | M70 | M72 | M73 | M48 | M49 | M61 Q2 | M62 P1 | M19 R0
G41 D1 | G42.1 D0.5 | #1=5 | #1=#5420 | F#<_feed> | X#5420 | S#<_rpm> | o900 if [1 EQ 1] | o900 else
o900 endif | o901 while [1 EQ 0] | o901 endwhile | o902 repeat [2] | o902 endrepeat | o903 sub
o903 return | o903 endsub | o903 call | o200 call | G4 P.1 X9 | G2 X9 Z9 R9 | G3 I1 J0 P2 | G38.2 Z-5 F5
G1 X7 A5 | G1 W1 F1 | g1 z8 f.1 | G[10*2] | G[94] | G[95] | G[17] | G[8] | G[90+1] | G[64] | G[61] | M[5]
G[96] S[80] | M[4]
"""
_FANUC = """
T0101 | T0202 | T0100 | G98 | G99 | G50 S2000 | G92 S2000 | G50 X20. Z10. | G92 X20. Z10. | G50 U1. | U1.
W-1. | G1 U-1. F0.1 | G1 W-2. | G0 U2. W1. | G1 X8. W-1. F0.08 | G4 X1. | G4 P500 | G4 U1. S400
G28 U0 W0 | G30 P2 U0 W0 | G91 G28 Z0. | G54.1 P2 | G90 X10. Z5. F0.1 | G94 X10. Z5. F0.1
G92 X10. Z5. F1. | G1 X12. F0.1 N1.5 | G1 W-3. F0.1 E2. | G1 Z6. T0202 | G81 X5. Y5. Z-3. R2. F100.
"""
_WORDS = """
M2 M0 M1 M5 M3 M4 M8 M9 M7 T2 S500 S2000 F0.1 F50. G53 G28 G91 G90 G20 G21 G94 G95 G98 G99 G96 G97 G40 G43
G49 G54 G55 G80 G0 G2 G3 G17 G18 G92 G52 X9. Z8. U1. W-1. I1. K1. R5. Q0.2 L2 H1 D1 / (x) N77 G61 G64 M6
M30
"""
_NUMBERS = ("0.", "1.", "2.", "0.1", "7.3", "90.")
_NUMBER = re.compile(r"-?[0-9]+\.[0-9]*")


def _items(text: str) -> tuple[str, ...]:
    return tuple(one.strip() for line in text.strip().split("\n") for one in line.split("|"))


LINES = {"linuxcnc": _items(_LINES) + _items(_LINUXCNC), "fanuc": _items(_LINES) + _items(_FANUC)}
WORDS = tuple(_WORDS.split())


def changed(draw: Random, text: str, control: str) -> str:
    """The program with one to four things changed; its last line stays the last."""
    lines = [line.rstrip("\r") for line in text.split("\n")]
    for _ in range(draw.choice((1, 1, 2, 2, 3, 4))):
        _change(draw, lines, LINES[control])
    return "\n".join(lines)


def _change(draw: Random, lines: list[str], others: tuple[str, ...]) -> None:
    stop = max(len(lines) - 2, 1)
    at = draw.randrange(stop)
    kind = draw.random()
    if kind < 0.5:
        lines.insert(at, draw.choice(others))
    elif kind < 0.82:
        word = draw.choice(WORDS)
        lines[at] = f"{lines[at]} {word}" if draw.random() < 0.6 else f"{word} {lines[at]}"
    elif kind < 0.88:
        lines[at] = _with_another_number(draw, lines[at])
    elif kind < 0.91:
        other = draw.randrange(stop)
        lines[at], lines[other] = lines[other], lines[at]
    elif kind < 0.95:
        lines.insert(draw.randrange(stop), lines[at])
    elif len(lines) > 3:
        lines.pop(at)


def _with_another_number(draw: Random, line: str) -> str:
    found = list(_NUMBER.finditer(line))
    if not found:
        return line
    number = draw.choice(found)
    other = draw.choice((*_NUMBERS, "-" + number[0].lstrip("-"), number[0] + "5"))
    return line[: number.start()] + other + line[number.end() :]
