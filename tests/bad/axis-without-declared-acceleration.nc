(EXPECT VIB035 4:15 -p fanuc-lathe planner.model=trapezoid axes.X.max_acceleration_mm_s2=5000)
G99 G97 S1250 M3
G0 X30. Z2.
G1 Z-10. F0.1 N1.5
M30
