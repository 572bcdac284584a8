(EXPECT VIB081 4:14 -p linuxcnc-lathe output.form=loop command.periods_ms=[33.3337])
G21 G18 G90 G8 G97 G95 S1250 M3
G0 X10 Z1
G1 Z-3 F0.05 N1.5
M2
