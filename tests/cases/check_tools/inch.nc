; flags: -p linuxcnc-mill --set checks.only=[7] --set checks.last_use=none tools.files=["tools.csv"])
G20 G90
T7 M6
S12000 M3
(ROUGH)
G0 X1.25 Y-.375
G43 H7 Z.5
G1 Z-.1 F20.
X3.
G0 Z.5
(FINISH)
Z.1
G1 Z-.12 F20.
X1.25
G0 Z.5
M5
M2
; --- output
G20 G90
(CHIPBREAK BEGIN CALIBRATE)
G53 G0 Z0
o<cb_calibrate> call
G80
(CHIPBREAK END 598465BA)
T7 M6
(CHIPBREAK BEGIN TOOL CHECK T7, TRACE T7)
G53 G0 Z0
o<cb_tool> call [7] [1] [10.] [0.] [4] [30.]
o<cb_length> call [7] [40.] [60.]
o<cb_tool_check> call [7] [12000]
o<cb_trace> call [7]
G80
(CHIPBREAK END 5829FCC4)
S12000 M3
(ROUGH)
G0 X1.25 Y-.375
G43 H7 Z.5
G1 Z-.1 F20.
X3.
G0 Z.5
(CHIPBREAK BEGIN CHIP CHECK T7 W0.02)
G53 G0 Z0
M5
o<cb_chip_check> call [7] [0.000787]
S12000 M3
G0 X3. Y-0.375
(CHIPBREAK END 71439345)
(FINISH)
Z.1
G1 Z-.12 F20.
X1.25
G0 Z.5
M5
M2
