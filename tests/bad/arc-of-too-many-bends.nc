(EXPECT VIB034 4:1 -p linuxcnc-lathe axes.X.max_acceleration_mm_s2=10000 axes.Z.max_acceleration_mm_s2=10000)
G21 G18 G90 G7 G97 G95 S2000 M3
G0 X16 Z0
G3 X24 Z-4 I0 K-4 F0.1 N1.25
M2
