(EXPECT VIB035 5:1 planner.model=trapezoid axes.X.max_acceleration_mm_s2=50000)
G97 S1500 M3
G0 X33. Z0.
(VIB N2.5)
G1 Z-9. F0.12
X41.
M30
