(EXPECT VIB052 5:1 -p fanuc-lathe planner.model=trapezoid axes.X.max_acceleration_mm_s2=20000 axes.Z.max_acceleration_mm_s2=20000)
G97 S600 M3
G99
G0 X20. Z2.
G2 X30. Z-3. R5 F0.05 N1.5
M30
