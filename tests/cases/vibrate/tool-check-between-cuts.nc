; flags: -p fanuc-mill --set macros.beam_x_mm=120 --set macros.beam_y_mm=-35 --set macros.beam_z_mm=-400 --set macros.safe_z_mm=0 --set macros.master_length_mm=150 --set macros.master_diameter_mm=20 --set macros.master_tool=90 --set checks.last_use=none --set output.segments=stroke
T2 M6
S1300 M3
(ROUGH POCKET)
G0 X10. Y20.
G43 H2 Z15.
G95
(VIB N1.5)
G1 X12. F0.3
(VIB OFF)
G0 Z15.
(CONTOUR FINISH)
G0 X0. Y0.
Z2.
(VIB N1.5)
G1 X2. F0.3
(VIB OFF)
G0 Z15.
M5
M30
; --- output
; flags: -p fanuc-mill --set macros.beam_x_mm=120 --set macros.beam_y_mm=-35 --set macros.beam_z_mm=-400 --set macros.safe_z_mm=0 --set macros.master_length_mm=150 --set macros.master_diameter_mm=20 --set macros.master_tool=90 --set checks.last_use=none --set output.segments=stroke
G91 G28 Z0.
G90
G65 P8900
T2 M6
G91 G28 Z0.
G90
G65 P8901 T2. S1300.
G65 P8902 T2. Z20.
S1300 M3
(ROUGH POCKET)
G0 X10. Y20.
G43 H2 Z15.
G95
(VIB N1.5)
S1250
G1 X10.16 F0.48
X10.200 F0.12000
X10.480 F0.84000
X10.400 F0.24000
X10.800 F1.20000
X10.600 F0.60000
X11.060 F1.38000
X10.800 F0.78000
X11.260 F1.38000
X11.000 F0.78000
X11.400 F1.20000
X11.200 F0.60000
X11.480 F0.84000
X11.400 F0.24000
X11.560 F0.48000
X11.600 F0.12000
X12. F0.3
(VIB OFF)
G0 Z15.
S1300
G91 G28 Z0.
G90
M5
G65 P8903 T2. W0.02 D1.
S1300 M3
G0 X12. Y20.
G0 G43 H2 Z15.
(CONTOUR FINISH)
G0 X0. Y0.
Z2.
(VIB N1.5)
S1250
G1 X0.16 F0.48
X0.200 F0.12000
X0.480 F0.84000
X0.400 F0.24000
X0.800 F1.20000
X0.600 F0.60000
X1.060 F1.38000
X0.800 F0.78000
X1.260 F1.38000
X1.000 F0.78000
X1.400 F1.20000
X1.200 F0.60000
X1.480 F0.84000
X1.400 F0.24000
X1.560 F0.48000
X1.600 F0.12000
X2. F0.3
(VIB OFF)
G0 Z15.
M5
S1300
M30
