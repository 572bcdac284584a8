; flags: -p fanuc-mill --set checks.calls=shop --set 'calls.shop={chip_check=["G53 Z0.", "G65 P9858 T{tool} H{limit}"]}' --set checks.w_mm.6=0.035
T6 M6
S1500 M3
G0 X-40. Y0.
G43 H6 Z10.
G1 Z0. F300.
X40.
G0 Z10.
M5
G91 G28 Z0.
G90
M30
; --- output
T6 M6
S1500 M3
G0 X-40. Y0.
G43 H6 Z10.
G1 Z0. F300.
X40.
G0 Z10.
M5
G91 G28 Z0.
G90
(CHIPBREAK BEGIN CHIP CHECK T6 W0.035)
G91 G28 Z0.
G90
G53 Z0.
G65 P9858 T6 H0.035
(CHIPBREAK END BC06A275)
M30
