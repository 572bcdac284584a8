; flags: -p linuxcnc-mill
G21 G17 G90
T1 M6
G43
(Begin operation: Adaptive)
S8000 M3
M7
M8
G0 X1 Y2
G0 Z10
G1 Z-2 F300
G1 X30
G0 Z10
(Finish operation: Adaptive)
(Begin operation: Profile)
G0 Z5
G1 Z-2 F300
G1 X1
G0 Z10
(Finish operation: Profile)
M9
M5
M2
; --- output
G21 G17 G90
(CHIPBREAK BEGIN CALIBRATE)
G53 G0 Z0
o<cb_calibrate> call
G80
(CHIPBREAK END 598465BA)
T1 M6
(CHIPBREAK BEGIN TOOL CHECK T1, TRACE T1)
G53 G0 Z0
o<cb_tool_check> call [1] [8000]
o<cb_trace> call [1]
G80
(CHIPBREAK END 72DD010E)
G43
(Begin operation: Adaptive)
S8000 M3
M7
M8
G0 X1 Y2
G0 Z10
G1 Z-2 F300
G1 X30
G0 Z10
(Finish operation: Adaptive)
(CHIPBREAK BEGIN CHIP CHECK T1 W0.02)
M9
G53 G0 Z0
M5
o<cb_chip_check> call [1] [0.02]
S8000 M3
G0 X30. Y2.
M8
M7
(CHIPBREAK END 4B9D7FA3)
(Begin operation: Profile)
G0 Z5
G1 Z-2 F300
G1 X1
G0 Z10
(Finish operation: Profile)
M9
M5
(CHIPBREAK BEGIN CHIP CHECK T1 W0.05)
G53 G0 Z0
o<cb_chip_check> call [1] [0.05]
(CHIPBREAK END 5B0F26BF)
M2
