"""The arithmetic of arcs that every run of them costs: lengths on the true circle, how long a run may be, its steps.

One text for all interpreters, as in measure_viper.py: a board compiles it to machine code. `plan` is arc_plan.py's array,
one place longer. Negative numbers come as arguments, never out of an array.
"""
# ruff: noqa: F821

import micropython
from micropython import const

from passo.motion.integers import divide

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows

# arc_plan.py's, known to the compiler.
_RADIUS = const(7)
_SHIFT = const(8)
_D = const(9)
_E = const(10)
_Z_HIGH = const(14)
_FINE = const(20)
_PLAN = const(21)
_LONGEST = const(255)  # most words of a run, so that no product here reaches 2³⁰


@micropython.viper
def straight(plan: ptr32, u: int, w: int) -> int:  # ISR: no allocation
    """How many steps from (u, w) may be one run."""
    if u <= 0 - plan[_E]:
        return 1
    if u < 0:
        ends = 0 - u
        slope = ends
    else:
        ends = plan[_D] - u - 1  # the step onto the diagonal is a run of its own
        slope = u
    if ends < 1:
        return 1
    ratio = (w << 6) // (slope + 1)
    count = _LONGEST
    if ratio < 1024:
        count = 3 * (ratio * w >> 14)  # w² / 85u
    if count > w >> 3:
        count = w >> 3
    steep = plan[_Z_HIGH] >> 15  # whole steps of the third axis a step
    if steep and count * (steep + 1) > 320:
        count = 320 // (steep + 1)
    if count > _LONGEST:
        count = _LONGEST
    if u >= 0 and count > 1:  # the slope grows on the way
        if w < 8192:
            most = w * w // (85 * u + 43 * count)
            if count > most:
                count = most
        else:
            count -= count >> 4
    if count > ends:
        count = ends
    return count if count > 0 else 1


@micropython.viper
def root(plan: ptr32, u: int, w: int, error: int, after: int) -> int:  # ISR: no allocation
    """√(R² − u²), here or one step on, from w and the error: w − error / 2w, less the square of that over 2w.

    It has SHIFT fraction bits."""
    if after:
        error += 2 * u + 1
        if error + w < 0:
            error += 2 * w + 1
            w += 1
    shift = plan[_SHIFT]
    if w < 1:
        return 0
    part = (error << (shift - 1)) // w
    found = (w << shift) - part
    if shift > 14:
        part >>= shift - 14
        found -= (part * part // (2 * w)) >> (28 - shift)
    if found > plan[_RADIUS]:
        found = plan[_RADIUS]
    return found if found > 0 else 0


@micropython.viper
def length(plan: ptr32, near: int, u: int, count: int) -> int:  # ISR: no allocation
    """Length, in 2⁻²⁰ steps, of the true arc from u to u + count, where √(R² − u²) is `near`.

    Leaves w₁ + w₂ in plan[_PLAN]: it is the root of its own equation sum = 2w₁ − count·(2u + count) / sum, which two
    rounds solve to 2·10⁻⁶.
    """
    shift = plan[_SHIFT]
    scale = shift - 8  # what makes R a number of 21 bits
    fall = count * (2 * u + count) << scale
    total = 2 * near
    if total < 256:
        total = 256
    rounds = 2
    while rounds:
        total = 2 * near - int(divide(fall, total >> 8, shift))
        if total > 2 * plan[_RADIUS]:
            total = 2 * plan[_RADIUS]
        if total < 256:
            total = 256
        rounds -= 1
    plan[_PLAN] = total
    by = total >> 8
    excess = int(divide((plan[_RADIUS] - (total >> 1)) >> 7, by, _FINE))  # R / mean w − 1
    long = (count << _FINE) + count * excess
    chord = int(divide(count << scale, by, 12))
    return long - ((long >> 16) * (chord * chord) // 3 >> 8)


@micropython.viper
def walk(
    out: ptr32, at: int, count: int, u: int, w: int, error: int, u_bit: int, both: int, after: ptr32
) -> int:  # ISR: no allocation
    """Write the masks of `count` steps of a circle, `u_bit` or `both`, to out[at:]; returns how often w steps. u, w and
    the error after it are in `after`."""
    made = 0
    end = at + count
    while at < end:
        error += 2 * u + 1
        mask = u_bit
        if u < 0:
            near = error + 2 * w + 1
            if near < 0 - error:
                error = near
                w += 1
                made += 1
                mask = both
        else:
            near = error - 2 * w + 1
            if 0 - near < error:
                error = near
                w -= 1
                made += 1
                mask = both
        u += 1
        out[at] = mask
        at += 1
    after[0] = u
    after[1] = w
    after[2] = error
    return made
