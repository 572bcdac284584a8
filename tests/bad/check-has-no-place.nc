(EXPECT CHK002 8:1 -p fanuc-mill macros.beam_x_mm=120 macros.beam_y_mm=-35 macros.beam_z_mm=-400 macros.safe_z_mm=0 macros.master_length_mm=150 macros.master_diameter_mm=20 checks.strict=true)
T1 M6
S1000 M3
G0 X1. Y2.
G43 Z15. H1
G41 D1 X5.
G1 Z-1. F100.
(FINISH)
X9.
G0 Z15.
G40 X1.
M30
