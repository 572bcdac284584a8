; flags: -p fanuc-lathe
G97 S3000 M3
G0 X20. Z2.
G65 P9100 V12. D20.
G28 U0. V0.
M30
