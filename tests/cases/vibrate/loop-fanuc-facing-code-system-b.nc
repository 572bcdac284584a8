; flags: -p fanuc-lathe --set control.lathe_system=B --set output.form=loop --set output.loop_variable=130
G97 S1250 M3
#33=5.
G0 X24. Z0.
G1 X16. F0.1 N1.5
G0 Z#33
M30
; --- output
; flags: -p fanuc-lathe --set control.lathe_system=B --set output.form=loop --set output.loop_variable=130
G97 S1250 M3
#33=5.
G0 X24. Z0.
G1 X23.893 F0.1605
X23.867 F0.0390
X23.680 F0.2805
X23.733 F0.0795
X23.467 F0.3990
X23.600 F0.1995
G91
#130=0
WHILE[#130LT17]DO1
X-0.307 F0.4605
X0.174 F0.2610
X-0.307 F0.4605
X0.173 F0.2595
X-0.306 F0.4590
X0.173 F0.2595
#130=#130+1
END1
G90
X16.493 F0.4605
X16.667 F0.2610
X16.400 F0.4005
X16.533 F0.1995
X16.347 F0.2790
X16.400 F0.0795
X16.293 F0.1605
X16.267 F0.0390
X16. F0.1
G0 Z#33
M30
