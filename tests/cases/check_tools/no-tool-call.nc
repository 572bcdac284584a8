; flags: -p fanuc-mill
T3
S1500 M3
G0 X-40. Y0.
Z10.
G1 Z0. F300.
X40.
G0 Z10.
M30
