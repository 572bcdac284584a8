(EXPECT VIB032 4:15 planner.max_blocks_per_s=200 vibration.waveform=sine)
G97 S1250 M3
G0 X30. Z2.
G1 Z-10. F0.1 N1.5
M30
