"""How far it is to slow down from a speed and an acceleration to the end of a block, by an S-curve: see smooth.py."""

from micropython import const

from passo.motion.integers import divide
from passo.motion.ramp_ticks import root_of
from passo.motion.smooth_units import Units

_V_BITS = const(7)  # V_BITS, known to the compiler
_FASTEST = const(32_767)


class Way(Units):
    def _need(self, fast, b):  # ISR: no allocation
        """The way to slow down to the block's end, `fast` being the top of the curve; in the same units as `_room`."""
        until = self._until
        size = abs(b)
        most = self._most
        fine = fast < 0x40000  # below 2048: two bits more of the speeds, one of their roots
        if fine:
            fast >>= _V_BITS - 2
            until >>= _V_BITS - 2
            size <<= 1
            most <<= 1
        else:
            fast = fast >> _V_BITS if fast < _FASTEST << _V_BITS else _FASTEST
            until >>= _V_BITS
        drop = fast - until
        if drop <= 0:
            return 0
        square = size * size >> 2 * _V_BITS
        if b < 0:
            left = drop - square
            if left <= 0:
                return 0
            if left < square and not self._on:  # more than can fade till then: it is on the last part of the curve
                square = left
                size = root_of(left, size)
                drop = 2 * left
                fast = until + drop
        near = self._way(size * (fast - square // 3), most)
        if self._on:
            far = self._way_on(fast, until, root_of(drop, 0), most)
        elif self._slow:
            far = (fast + until) * (root_of(drop, 0) * 23_170 >> 16)
        else:
            w = self._w << 2 if fine else self._w
            far = drop + w >> 1 if drop >= w else root_of(w * drop, 0) >> _V_BITS
            far = (fast + until >> 1) * far + (far >> 1 if fast + until & 1 else 0)
        far += near if b > 0 else -near
        if fine:
            far >>= 3 if self._slow else 4
        return far

    def _way_on(self, fast, until, last, most):  # ISR: no allocation
        """From the top of the curve to `until`, the acceleration being at its highest there, or `last`."""
        rest = 0
        if last > most:
            last = most
            rest = fast - (last * last >> 2 * _V_BITS)
            rest = (rest - until) * (rest + until)
            rest = divide(rest, last, 11) if self._slow else rest >> 2
        return self._way(last * (fast - (last * last >> 2 * _V_BITS) // 3), most) + rest

    def _way(self, product, most):  # ISR: no allocation
        if self._slow:
            return product >> 1
        return (product >> 14) * most + ((product & 0x3FFF) * most >> 14)
