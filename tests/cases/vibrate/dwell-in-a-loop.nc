; flags: -p linuxcnc-lathe --set output.form=loop --set vibration.waveform=dwell --set vibration.end=dwell
G21 G18 G90 G8 G97 G94 S1200 M3
G0 X10 Z1
G1 Z-4 F120 E3
G0 X15
M2
; --- output
; flags: -p linuxcnc-lathe --set output.form=loop --set vibration.waveform=dwell --set vibration.end=dwell
G21 G18 G90 G8 G97 G94 S1200 M3
G0 X10 Z1
M50 P0
M51 P0
S1184
G61
G1 Z0.848 F120
G4 P0.074
G91
o1001 repeat [30]
Z-0.1520
G4 P0.074
o1001 endrepeat
G90
Z-3.8640
G4 P0.074
Z-4.
G4 P0.051
G64
M50 P1
M51 P1
G0 X15
S1200
M2
