(EXPECT CHK011 2:1 -p fanuc-mill checks.strict=true)
T1 M6
S1000 M3
G0 X1. Y2.
G43 Z15. H1
G1 Z-1. F50.
G0 Z15.
M30
