(EXPECT VIB005 4:16 vibration.correct=count)
G97 S1250 M3
G0 X20. Z2.
G1 Z-30. F0.05 N3.5
M30
