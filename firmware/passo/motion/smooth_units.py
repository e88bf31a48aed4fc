"""The units of a block in which smooth.py reckons: what jerk and acceleration do to b, from one block to the next.

b is the square root of the speed, in the block's units, that would come on top while the acceleration fades. In time it
changes by `rate` a tick, at the given jerk; along the path q changes by b · `push` a step.
"""

from micropython import const

from passo.motion.block import GAIN, SPAN, SPEED, TOP
from passo.motion.integers import divide, isqrt
from passo.motion.profile import TICKS_PER_S
from passo.motion.ramp_ticks import root_of

_V_BITS = const(7)  # fraction bits of speeds, as ramp_ticks has them, and of b
_HIGHEST = const(0x3FFFFFFF)
_MOST_B = const(22_900)  # the square root of the fastest
_LEAST_B = const(64)  # of b at the highest acceleration: a higher jerk than that needs is not made use of


class Units:
    def __init__(self, limits):
        """`limits`: profile.Limits with a jerk, nm/s³ along the path."""
        self._shift = self._root = 0  # √(jerk / 2) a tick, of a unit of speed of fastest / 2²⁸: root / 2 ** shift
        while self._root < 1 << 14:
            self._shift += 1
            self._root = isqrt((limits.jerk << 27 + 2 * self._shift) // limits.fastest) // TICKS_PER_S
        self.b = 0
        # Of the block:
        self._rows = None
        self._at = self._behind = 0
        self._rate = 1  # what b grows in a tick: rate / 2 ** rate_shift
        self._rate_shift = 0
        self._push = 1  # what b does to q in a step: b · push / 2 ** 11
        self._most = 1  # b at the highest acceleration
        self._limit = 1  # no b is larger
        self._w = 0  # the speed that acceleration takes to come and go
        self._slow = False  # w is above any speed; then _need() is measured otherwise
        self._scale = 1  # of _need(), a step
        self._first = self._rest = 0  # b and q after one step from rest
        self._half = 0  # of the speed there to its mean one, · 2¹³
        # Of the segment:
        self._wanted = self._cap = self._until = 0  # q and speed wanted, speed at the block's end
        self._high = 0  # q wanted but for a hold
        self._on = False  # slowing down goes on in the block behind
        self._room = self._force = self._change = self._grow = 0
        self._aim = self._b = self._ticks = self._above = self._short = 0
        self._brakes = False
        self._tried = self._speed = 0  # q last tried to end with, and its root
        self._cruise = self._cruise_until = self._cruise_need = 0  # what _need() has last found for a steady speed
        self._spare = 0

    def load(self, rows, at, behind):  # ISR: no allocation
        """Take up the block at rows[at], `behind` being where the next one is; b goes over into its units."""
        self._rows = rows
        self._at = at
        self._behind = behind
        gain = rows[at + GAIN]
        if not gain:
            self.b = 0
            return
        speed = rows[at + SPEED]
        shift = self._shift + 5
        while speed < 0x4000000:
            speed <<= 2
            shift -= 1
        root = root_of(divide(rows[at + TOP], speed >> 6, 34), 0)
        while root >= 0x8000:
            root >>= 1
            shift -= 1
        rate = self._root * root >> 15
        span = rows[at + SPAN]
        by = shift + 2
        while span >= 0x8000:
            span >>= 1
            by -= 1
        push = scaled(span * rate, -by) or 1
        most = quotient(gain, push, 11)
        if most < _LEAST_B:
            most = _LEAST_B
            push = quotient(gain, most, 11)
            rate = quotient(gain, span, 12)
            shift += 7 - by
        while rate >= 0x8000:
            rate >>= 1
            shift -= 1
        while rate < 0x2000:
            rate <<= 1
            shift += 1
        self._most = most
        self._limit = most if most < _MOST_B else _MOST_B
        size = scaled(abs(self.b) * rate // self._rate, self._rate_shift - shift)  # 15 bits by 15
        if size > self._limit:
            size = self._limit
        self.b = size if self.b > 0 else -size
        self._rate = rate
        self._rate_shift = shift
        self._push = push
        self._slow = most > 16_190
        if self._slow:
            self._scale = push
        else:
            self._w = (most * most >> 13) or 1
            self._scale = (gain >> 2) or 1
        self._step_from_rest(gain)

    def _step_from_rest(self, gain):  # ISR: no allocation
        """How fast the first step from rest can end."""
        b = cube_root(self._push)
        self._half = 0x6000  # the acceleration grows all along
        if b <= self._limit:
            rest = (self._push >> 12) * b + ((self._push & 0xFFF) * b >> 12)
            rest += rest >> 1
        else:
            b = self._limit
            w = self._w
            rest = gain - (gain >> 2)
            if not self._slow and gain // w > w // 3:
                rest = gain - w * w // 12
                fast = root_of(rest, 0) >> _V_BITS
                while fast >= 0x2000:
                    fast >>= 1
                    w >>= 1
                self._half = divide(fast * (fast + w // 2) >> 6, fast * fast + w * w // 12 >> 6, 14)
        self._first = b
        self._rest = rest
        self._cruise = -1

    def _at_end(self, q, double):  # ISR: no allocation
        """q after the segment in which b is `double` / 2 on the average."""
        size = abs(double)
        if self._slow:
            change = (self._force >> 12) * size + ((self._force & 0xFFF) * size >> 12)
        else:
            most = 2 * self._most
            change = self._change // most * size + self._change % most * size // most
        if change > self._change:
            change = self._change
        if double < 0:
            return q - change if q > change else 0
        return q + change if change < _HIGHEST - q else _HIGHEST

    def _grown(self, ticks):  # ISR: no allocation
        """How much b may change in `ticks`."""
        shift = self._rate_shift - 1
        while ticks >= 0x8000:
            ticks >>= 1
            shift -= 1
        grown = ticks * (self._rate >> 1)
        if 0 < shift < 29:  # what is less than one counts later
            grown += self._spare & (1 << shift) - 1
            self._spare = grown
        return scaled(grown, -shift) or 1

    def _fading(self, speed):  # ISR: no allocation
        """b that fades in just `speed`."""
        return root_of(speed << _V_BITS, abs(self.b) << _V_BITS) >> _V_BITS

    def _half_ramp(self, speed):  # ISR: no allocation
        """Half the ticks that it takes from rest to `speed`."""
        b = self._fading(speed >> 1)
        limit = self._limit
        if b > limit:
            b = limit + ((speed >> 1) - (limit * limit >> _V_BITS)) * 64 // limit
        shift = self._rate_shift - 14
        while b >= 0x8000:
            b >>= 1
            shift += 1
        return scaled((b << 14) // self._rate, shift)


def scaled(value, shift):  # ISR: no allocation
    """value · 2ˢʰⁱᶠᵗ, 2³⁰ − 1 at most."""
    if shift <= 0:
        return value >> -shift if shift > -31 else 0
    return value << shift if shift < 30 and value <= _HIGHEST >> shift else _HIGHEST


def quotient(value, by, bits):  # ISR: no allocation
    """value · 2ᵇⁱᵗˢ / by to 2⁻¹⁰ or so, 2³⁰ − 1 at most."""
    while by >= 0x200000:
        by >>= 1
        value >>= 1
    return divide(value, by, bits) if value // by < _HIGHEST >> bits else _HIGHEST


def ratio(part, other):  # ISR: no allocation
    """part / (part + other), of 2¹⁴; both ≥ 0."""
    while part >= 0x4000 or other >= 0x4000:
        part >>= 1
        other >>= 1
    return (part << 14) // ((part + other) or 1)


def cube_root(push):  # ISR: no allocation
    """(¾ q a step and b)^⅓: what b is after a step from rest; `push` is q a step and b · 2⁴."""
    shift = 5
    value = push
    while value >= 0x800000:
        value >>= 3
        shift += 1
    value *= 3
    while value < 0x1000000:
        value <<= 3
        shift -= 1
    root = 512
    better = (2 * root + value // (root * root)) // 3
    while better < root:
        root = better
        better = (2 * root + value // (root * root)) // 3
    return scaled(root, shift)
