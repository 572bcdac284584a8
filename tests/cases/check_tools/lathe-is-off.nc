; flags: -p fanuc-lathe
T0101 (ROUGH TURN)
G97 S800 M3
G0 X50. Z2.
G1 Z-20. F0.2
G0 X60. Z50.
M30
