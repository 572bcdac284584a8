(EXPECT VIB031 4:16 axes.Z.max_velocity_mm_min=100 planner.model=trapezoid axes.Z.max_acceleration_mm_s2=90000)
G97 S3000 M3
G0 X20. Z2.
G1 Z-30. F0.05 N1.5
M30
