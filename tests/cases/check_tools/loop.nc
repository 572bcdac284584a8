; flags: -p linuxcnc-mill
G90 G21
o100 while [#1 lt 3]
T1 M6
S1500 M3
(ROUGH)
G0 X-40 Y0
G0 Z10
G1 Z0 F300
G1 X40
G0 Z10
#1 = [#1 + 1]
o100 endwhile
M2
