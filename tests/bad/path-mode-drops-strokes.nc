(EXPECT VIB033 6:13 -p linuxcnc-lathe axes.Z.max_acceleration_mm_s2=20000 planner.path_mode=)
G21 G18 G90 G7 G95
G64 P0.03
G97 S1250 M3
G0 X20 Z2
G1 Z-3 F0.1 N1.5
M2
