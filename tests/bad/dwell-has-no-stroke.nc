(EXPECT VIB085 4:15 vibration.waveform=dwell)
G97 S1200 M3
G0 X20. Z2.
G1 Z-30. F0.1 E3 Q1.4
M30
