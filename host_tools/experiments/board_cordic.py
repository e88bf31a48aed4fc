"""Runs on the board and on the PC: the end of an arc by the document's CORDIC of 15 steps in floating point, and by the firmware's.

    document_end(radius, degrees)       # (x, y), −99 … 99 degrees
    firmware_end(radius, angle)         # integers; angle in 2⁻³² turn
"""

from math import atan, pi

from passo.motion.cordic import rotate

GAIN = 0.607252935  # 1/K of 15 steps, put into the start vector


def document_end(radius, degrees):
    """Return the end (x, y) of an arc from (radius, 0) by `degrees`: CORDIC of 15 steps in floating point, as the mill's document of 2004 has it."""
    x = radius * GAIN
    y = 0.0
    left = degrees
    divisor = 2.0
    for _step in range(15):
        divisor /= 2
        dx = x * divisor
        dy = y * divisor
        turned = 180 * atan(divisor) / pi
        if left < 0:
            x += dy
            y -= dx
            left += turned
        else:
            x -= dy
            y += dx
            left -= turned
    return x, y


def firmware_end(radius, angle):
    """Return the end (x, y), integers, of an arc from (radius, 0) by `angle` in 2⁻³² turn."""
    return rotate(radius, 0, angle)
