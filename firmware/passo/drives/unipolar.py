"""Unipolar motors by four transistors S1…S4, one bit each, S1 lowest."""

WIDTH = 4
PINS = ("s1", "s2", "s3", "s4")

WAVE = bytes((0b0001, 0b0010, 0b0100, 0b1000))  # full step, one coil: S1, S2, S3, S4
FULL = bytes((0b0011, 0b0110, 0b1100, 0b1001))  # full step, two coils
HALF = bytes((0b0001, 0b0011, 0b0010, 0b0110, 0b0100, 0b1100, 0b1000, 0b1001))  # one and two coils in turn

MODES = {"wave": WAVE, "full": FULL, "half": HALF}
OFF = 0
