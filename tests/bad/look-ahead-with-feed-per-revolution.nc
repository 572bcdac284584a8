(EXPECT VIB089 4:1 checks.strict=true planner.model=look-ahead axes.Z.acc_dec_ms=4 axes.Z.position_gain_1_s=300 axes.Z.max_acceleration_mm_s2=5000)
G97 S3000 M3
G0 X20. Z2.
G1 Z-30. F0.05 E2
M30
