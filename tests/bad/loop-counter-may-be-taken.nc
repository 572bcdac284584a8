(EXPECT VIB080 6:16 -p fanuc-lathe output.form=loop)
G97 S3000 M3
#1=8.
#[#1+25.]=2.
G0 X20. Z2.
G1 Z-30. F0.05 N1.5
M30
