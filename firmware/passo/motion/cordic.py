"""Angles and rotations in shifts and adds: CORDIC (J. E. Volder, IRE Trans. Electronic Computers EC-8, 1959).

    angle, radius = vector(x, y)              # polar form
    x, y = rotate(x, y, angle)                # about 0;0, counter-clockwise

An angle is an integer of 2⁻³² turn; a negative one is clockwise and several turns are allowed. One iteration more
halves what is left of the angle, so coordinates of b bits take b + 4 of them, and the vector carries GUARD bits below
the step. The remaining angle is less than 2⁻⁽ᵇ⁺³⁾, at most 0.18 steps on a radius of √2·2ᵇ, and then the rounding of
each coordinate to a whole step: the result is within one step of the true point for every radius and angle
(0.5·√2 + 0.18 + 2⁻¹⁰ = 0.89).

Big integers are welcome here: it is called once a block.
"""

from micropython import const

TURN = 1 << 32
QUARTER = 1 << 30
GUARD = const(16)  # bits below one step: rounding of up to 50 shifts stays under 2⁻¹⁰
_FINE = const(8)  # angles are kept in 2⁻⁴⁰ turn inside
_FINEST = const(36)

PI_64 = 0x3243F6A8885A308D8  # π · 2⁶⁴
_ANGLES = (
    137438953472, 81134951838, 42869480287, 21761217566, 10922836750, 5466743129, 2734038620, 1367102738, 683561799,
    341782203, 170891265, 85445653, 42722829, 21361415, 10680707, 5340354, 2670177, 1335088, 667544, 333772, 166886, 83443,
    41722, 20861, 10430, 5215, 2608, 1304, 652, 326, 163, 81, 41, 20, 10, 5,
)  # atan(2⁻ⁱ) in 2⁻⁴⁰ turn  # fmt: skip
_INVERSE_GAIN = 667681663043  # of the product of √(1 + 2⁻²ⁱ), in 2⁻⁴⁰


def _bits(value):
    """Return the number of binary digits of `value` ≥ 0."""
    count = 0
    while value:
        value >>= 1
        count += 1
    return count


def rotate(x, y, angle):
    """Return (x, y) turned about 0;0 by `angle` (2⁻³² turn, counter-clockwise), rounded to integers: within one step for every radius. CORDIC, see
    above."""
    iterations = min(_bits(abs(x) | abs(y)) + 4, _FINEST)
    angle &= TURN - 1
    quarters = (angle + (QUARTER >> 1)) // QUARTER
    rest = (angle - quarters * QUARTER) << _FINE  # within an eighth of a turn of zero
    for _ in range(quarters & 3):
        x, y = -y, x
    x <<= GUARD
    y <<= GUARD
    for i in range(iterations):
        if rest >= 0:
            x, y = x - (y >> i), y + (x >> i)
            rest -= _ANGLES[i]
        else:
            x, y = x + (y >> i), y - (x >> i)
            rest += _ANGLES[i]
    half = 1 << (39 + GUARD)
    return (x * _INVERSE_GAIN + half) >> (40 + GUARD), (y * _INVERSE_GAIN + half) >> (40 + GUARD)


def vector(x, y):
    """Return (angle in 2⁻³² turn, 0 … 2³² − 1; length) of the vector (x, y). The angle is within 2⁻³¹ turn; that of 0;0 is 0. CORDIC, see above."""
    if not x and not y:
        return 0, 0
    quarters = 0
    while x <= 0 or abs(y) > x:
        x, y = y, -x
        quarters += 1
    raise_bits = max(48 - _bits(x), GUARD)
    x <<= raise_bits
    y <<= raise_bits
    angle = 0
    for i in range(_FINEST):
        if y >= 0:
            x, y = x + (y >> i), y - (x >> i)
            angle += _ANGLES[i]
        else:
            x, y = x - (y >> i), y + (x >> i)
            angle -= _ANGLES[i]
    angle = (angle + (1 << (_FINE - 1))) >> _FINE
    length = (x * _INVERSE_GAIN + (1 << (39 + raise_bits))) >> (40 + raise_bits)
    return (angle + quarters * QUARTER) & (TURN - 1), length


def arc_length(radius, angle):
    """Return the length of the arc of `angle` (2⁻³² turn) on `radius`, in the radius's unit, rounded."""
    return (radius * angle * 2 * PI_64 + (1 << 95)) >> 96
