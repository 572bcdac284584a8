(EXPECT VIB097 4:1 -p fanuc-lathe checks.strict=true planner.model=after-interpolation axes.Z.acc_dec_ms=12 axes.Z.position_gain_1_s=60 planner.uncertainty=0.02)
G97 S1000 M3
G0 X20. Z2.
G1 Z-30. F0.05 N1.5 f25 Q4.1
M30
