(EXPECT VIB080 5:16 -p fanuc-lathe output.form=loop)
#33=5
G97 S3000 M3
G0 X20. Z2.
G1 Z-30. F0.05 N1.5
M30
