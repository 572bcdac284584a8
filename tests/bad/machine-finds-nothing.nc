(EXPECT VIB036 5:1 -p fanuc-lathe planner.model=trapezoid axes.Z.max_acceleration_mm_s2=500)
G99 G97 S4000 M3
G0 X20. Z2.
(VIB AUTO)
G1 Z-30. F0.3
M30
