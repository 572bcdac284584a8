; flags: -p fanuc-mill --set checks.enabled=false --set vibration.edges=2
G97 S600 M3
G0 X0. Y0. Z2.
G91
(VIB E1.2 WAVE DWELL)
G1 Z-1.2 F60.
(VIB OFF)
G0 Z5.
M30
; --- output
; flags: -p fanuc-mill --set checks.enabled=false --set vibration.edges=2
G97 S600 M3
G0 X0. Y0. Z2.
G91
(VIB E1.2 WAVE DWELL)
G1 Z-0.06 F60.
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.060
G4 X0.06
Z-0.12
(VIB OFF)
G0 Z5.
M30
