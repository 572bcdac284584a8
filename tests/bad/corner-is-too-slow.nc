(EXPECT VIB060 4:1 -p linuxcnc-lathe axes.X.max_acceleration_mm_s2=10000 axes.Z.max_acceleration_mm_s2=10000)
G21 G18 G90 G8 G97 G95 S2500 M3
G0 X10 Z1
G1 Z-2 F0.1 N1.5
X12 F0.1 N1.5
M2
