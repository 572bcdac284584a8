(EXPECT CHK012 3:1 -p grbl checks.strict=true checks.enabled=true checks.calls=setter macros.setter_x_mm=-10 macros.setter_y_mm=-20 macros.setter_z_mm=-90 macros.safe_z_mm=-2)
G90 G21 G94 G54
G59
T1
S1000 M3
G0 X1 Y2
G0 Z15
G1 Z-1 F50
G0 Z15
M30
