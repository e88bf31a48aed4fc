"""The centre of an arc, from I J K or from R, in nanometres; what RS274/NGC (NIST IR 6556, 3.5.3) asks of both."""

from micropython import const

from passo.protocols import errors

_CLOSE_NM = const(5_000)  # start and end radius may differ by this, or by a thousandth, but not by _FAR_NM
_FAR_NM = const(500_000)
_FINE = const(40)  # bits after the point


def isqrt(value):
    """Floor of the square root of `value` ≥ 0, by Newton's iteration from above."""
    if value < 2:
        return value
    root = 1
    while root * root < value:
        root <<= 1
    while True:
        better = (root + value // root) >> 1
        if better >= root:
            return root
        root = better


def check_centre(x, y, i, j):
    """0 if the point (x, y) lies on the circle about (i, j) through (0, 0), else an error's number."""
    radius = isqrt(i * i + j * j)
    if not radius:
        return errors.TARGET
    off = abs(isqrt((x - i) * (x - i) + (y - j) * (y - j)) - radius)
    if off > _CLOSE_NM and (off > _FAR_NM or off * 1000 > radius):
        return errors.TARGET
    return 0


def centre_of(x, y, radius, clockwise):
    """(error, i, j): the centre of the arc of `radius` from (0, 0) to (x, y). A negative radius is the long way round."""
    square = x * x + y * y
    if not square:
        return errors.TARGET, 0, 0
    height = 4 * radius * radius - square
    if height < 0:
        chord = isqrt(square)
        if chord - 2 * abs(radius) > _CLOSE_NM // 5:  # a half circle whose R was rounded is still one
            return errors.RADIUS, 0, 0
        height = 0
    slope = isqrt((height << 2 * _FINE) // square)  # height / chord
    if clockwise == (radius > 0):
        slope = -slope
    return 0, (x - (y * slope >> _FINE)) // 2, (y + (x * slope >> _FINE)) // 2
