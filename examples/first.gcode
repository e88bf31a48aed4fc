; A square of 20 mm from where the machine stands, and back. Nothing is switched on, Z stays.
G21 G91
G1 X20 F600
Y20
X-20
Y-20
G90
M2
