(EXPECT VIB079 4:1 checks.strict=true axes.Z.acc_dec_ms=4 axes.Z.position_gain_1_s=200)
G97 S3000 M3
G0 X20. Z2.
G1 Z-30. F0.05 N1.5
M30
