"""What acceleration makes of a block, and the pass over the look-ahead: the arithmetic that every block costs.

    done = measure(rows, at, work, terms)       # the block whose row begins at rows[at]; its steps are in the row
    raised = look_back(rows, work, counts)

One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python. So it keeps to 32-bit
integers, none of which reaches 2³¹, and gives the same bits everywhere. `rows` are block.py's, `terms` profile.Limits',
`work` and `counts` the planner's; their places are named there and stand here as numbers, which is what viper takes. Where viper
is 64 bits wide it reads a negative number as a positive one: bit 30 tells. Exponents are kept 1000 too large instead.

Numbers come in three kinds:

- fractions of 2²⁸: directions; speeds, of the fastest that the machine can be; accelerations, likewise; and squares of
  speeds, which below a 2000th of the fastest are as good as 0
- long floats, of 27 or 28 bits and an exponent: lengths, and what ticks come from. Two steps of long division give a
  quotient of such numbers to 10⁻⁷
- short floats, m · 2ᵉ with m of 15 bits: everything that only decides how fast a speed may change. Where a value must
  not be exceeded it is rounded so at every step, which costs 10⁻³ at most.

The loops that bring numbers to their length are written out where they are needed, and so this module is long: as a
function each would cost every block 26 µs a call, and there are some thirty of them.
"""
# ruff: noqa: F821

import micropython

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.native
def measure(rows, at, work, terms):
    """Fill in the row of a line or arc. 1; or 0, there are no steps; -1, they are too far apart; -2, there are too many.

    In three pieces, because a board wants memory for each in one."""
    result = 1 if work[8] else direction(rows, at, work, terms)
    if result == 1:
        result = units(rows, at, work, terms)
        if result == 1:
            corner(rows, at, work, terms)
        elif result == 2:
            return 1
    return result


@micropython.viper
def direction(rows: ptr32, at: int, work: ptr32, terms: ptr32) -> int:
    """A line's dominant steps, length and direction, and what the axes allow along it. Results as measure()'s."""
    axes = terms[0]
    total = 0
    i = 0
    while i < axes:
        steps = rows[at + 25 + i]
        if steps >> 30 & 1:
            steps = 0 - steps
        steps &= 0x3FFFFFFF
        if steps > total:
            total = steps
        i += 1
    if total == 0:
        return 0
    if total > 2097151:
        return -2
    shift = 0
    high = total
    while high < 4096:
        high <<= 1
        shift += 1
    while high >= 8192:
        high >>= 1
        shift -= 1
    most = 0
    i = 0
    while i < axes:
        steps = rows[at + 25 + i]
        if steps >> 30 & 1:
            steps = 0 - steps
        steps &= 0x3FFFFFFF
        high = terms[16 + i] >> 14
        if shift >= 0:
            steps <<= shift
            along = steps * high + (steps * (terms[16 + i] & 0x3FFF) >> 14)
        else:
            along = (steps & ((1 << (0 - shift)) - 1)) * high >> (0 - shift)
            steps >>= 0 - shift
            along += steps * high + (steps * (terms[16 + i] & 0x3FFF) >> 14)
        work[16 + i] = along
        if along > most:
            most = along
        i += 1
    while most < 0x4000000:
        most <<= 1
        shift += 1
        i = 0
        while i < axes:
            work[16 + i] = work[16 + i] << 1
            i += 1
    # The root of the squares' sum, in digits of 14 bits: a² = aₕ²·2²⁸ + 2aₕaₗ·2¹⁴ + aₗ².
    square = 0
    middle = 0
    low = 0
    i = 0
    while i < axes:
        high = work[16 + i] >> 14
        rest = work[16 + i] & 0x3FFF
        square += high * high
        middle += high * rest
        low += rest * rest >> 14
        i += 1
    square += middle >> 13
    low += (middle & 0x1FFF) << 1
    root = 0
    bit = 0x4000
    while bit:
        if (root + bit) * (root + bit) <= square:
            root += bit
        bit >>= 1
    length = (root << 14) + (((square - root * root) << 14) + low) // (2 * root)
    length_shift = terms[1] - 1000 + shift  # nanometres are length / 2 ** length_shift
    # Directions, and what the axes allow along them.
    fastest = 0x20000000
    strength = 0x20000000
    high = length >> 14
    low = length & 0x3FFF
    i = 0
    while i < axes:
        along = work[16 + i]
        if along:
            bit = along // high
            rest = ((along % high) << 14) - bit * low
            along = (bit << 14) + rest // high
            bit = along
            more = 0
            while bit < 0x8000000 and more < 13:
                bit <<= 1
                more += 1
            bit = (bit >> 13) + 1
            rest = terms[20 + i] // bit
            shift = terms[24 + i] - 1000 + more
            if shift < 0:
                rest >>= 0 - shift
            elif rest < 0x20000000 >> shift:
                rest <<= shift
            else:
                rest = 0x20000000
            if rest < fastest:
                fastest = rest
            rest = terms[28 + i] // bit
            shift = terms[32 + i] - 1000 + more
            if shift < 0:
                rest >>= 0 - shift
            elif rest < 0x20000000 >> shift:
                rest <<= shift
            else:
                rest = 0x20000000
            if rest < strength:
                strength = rest
            if rows[at + 25 + i] >> 30 & 1:
                along = 0 - along
        work[16 + i] = along
        i += 1
    work[13] = total
    work[9] = length
    work[10] = length_shift + 1000
    work[11] = fastest
    work[12] = strength
    return 1


@micropython.viper
def units(rows: ptr32, at: int, work: ptr32, terms: ptr32) -> int:
    """Speed and time, and the ramp's units. 1; 2, it is too slow for a ramp; -1, the steps are too far apart."""
    total = work[13]
    length = work[9]
    length_shift = work[10] - 1000
    fastest = work[11]
    strength = work[12]
    if fastest < 1:
        fastest = 1
    if strength < 1:
        strength = 1
    speed = work[0]
    if speed == 0:
        speed = fastest
    limited = 0
    if speed > fastest:
        speed = fastest
        limited = 1
    work[15] = limited
    work[14] = speed
    full = speed
    full_shift = 0
    while full < 0x8000000:
        full <<= 1
        full_shift += 1
    # --- how long it lasts at that speed: `each` ticks a step, `rest` more over all
    if work[8] == 0:
        if work[1] and not limited:
            ticks = work[1]
            shift = work[2]
        else:
            high = full >> 14
            bit = length // high
            rest = ((length % high) << 14) - bit * (full & 0x3FFF)
            length_by = (bit << 14) + rest // high
            high = length_by >> 15
            low = length_by & 0x7FFF
            bit = terms[2] >> 14
            ticks = (high * bit << 1) + (high * (terms[2] & 0x3FFF) >> 13) + (low * bit >> 14)
            shift = terms[3] - 1000 + full_shift - length_shift
        while shift < 0 and ticks > 0:
            ticks >>= 1
            shift += 1
        if ticks == 0:
            ticks = 1
            shift = 0
        each = ticks // total
        rest = ticks % total
        while shift > 0:
            if each >= 0x10000000:
                return -1
            each <<= 1
            rest <<= 1
            if rest >= total:
                rest -= total
                each += 1
            shift -= 1
        if each > 0x1FFFFFFF:
            return -1
        rows[at + 2] = each if each > 0 else 1
        rows[at + 3] = rest
        steps = total
        while steps >= 0x8000:
            steps >>= 1
            rest >>= 1
        top = 16000
        if each >= 33553:
            top = 0x1FFFFFFF // (each + 1)
        rows[at + 10] = 2 * top * each + 2 * top * rest // steps
        steps_shift = 0
        steps = total
    else:
        steps = total
        steps_shift = work[3] - 1000
        top = work[1]
    high = speed >> 14
    rows[at + 18] = speed
    rows[at + 19] = high * high + (high * (speed & 0x3FFF) >> 13)
    high = fastest >> 14
    rows[at + 24] = high * high + (high * (fastest & 0x3FFF) >> 13)
    rows[at + 20] = 0
    rows[at + 21] = 0
    rows[at + 22] = 0
    rows[at + 7] = top
    if top < 64:
        rows[at + 9] = 0
        work[24] = 0
        return 2
    # --- the ramp's units, in short floats
    while steps < 0x4000:
        steps <<= 1
        steps_shift -= 1
    while steps >= 0x8000:
        steps >>= 1
        steps_shift += 1
    full >>= 13
    full_shift = 13 - full_shift
    topped = top
    top_shift = 0
    while topped < 0x4000:
        topped <<= 1
        top_shift -= 1
    while length >= 0x8000:
        length >>= 1
        length_shift -= 1
    strong = strength
    strong_shift = 0
    while strong < 0x4000:
        strong <<= 1
        strong_shift -= 1
    while strong >= 0x8000:
        strong >>= 1
        strong_shift += 1
    # limit: top · fastest / speed
    most = 2 * top
    if most > 32000:
        most = 32000
    if fastest >> 1 < speed:
        high = fastest
        low = speed
        while high >= 0x8000:
            high >>= 1
            low >>= 1
        high = top * high // (low + 1)
        if high < top:
            high = top
        if high < most:
            most = high
    rows[at + 8] = most
    speeds = full * full >> 15  # of speed², exponent 2·full_shift + 15
    tops = topped * topped >> 15
    # gain: q a step
    high = strong * length >> 15
    high = high * terms[4] >> 15
    low = (speeds * steps >> 15) + 1
    high = (high << 15) // low
    shift = strong_shift - length_shift + terms[5] - 1000 - 2 * full_shift - steps_shift - 15
    while high >= 0x8000:
        high >>= 1
        shift += 1
    high = high * tops
    shift += 2 * top_shift + 15
    while shift < 0 and high:
        high >>= 1
        shift += 1
    while shift > 0 and high < 0x10000000:
        high <<= 1
        shift -= 1
    if shift > 0 or high > 0x1FFFFFFF:
        high = 0x1FFFFFFF
    if high < 2:
        high = 2
    rows[at + 9] = high
    # reach: what the block can gain or lose, gain · steps · speed² / top²
    shift = 0
    while high < 0x4000:
        high <<= 1
        shift -= 1
    while high >= 0x8000:
        high >>= 1
        shift += 1
    high = high * steps >> 15
    high = high * speeds >> 15
    high = (high << 15) // (tops + 1)
    shift += steps_shift + 2 * full_shift - 2 * top_shift - 28 + 15
    while shift < 0 and high:
        high >>= 1
        shift += 1
    while shift > 0 and high < 0x10000000:
        high <<= 1
        shift -= 1
    if shift > 0 or high > 0x1FFFFFFF:
        high = 0x1FFFFFFF
    rows[at + 21] = high
    # unit: q of a square, top² / speed²
    high = (tops << 15) // (speeds + 1)
    shift = 15 + 2 * full_shift - 2 * top_shift - 28
    while high >= 0x8000:
        high >>= 1
        shift -= 1
    rows[at + 15] = high
    rows[at + 23] = shift
    # time: ticks a unit of speed takes
    high = full * terms[6] >> 15
    low = topped * strong >> 15
    high = (high << 15) // (low + 1)
    shift = top_shift + strong_shift - full_shift - terms[7] + 1015
    while high < 0x4000:
        high <<= 1
        shift += 1
    while high >= 0x8000:
        high >>= 1
        shift -= 1
    rows[at + 11] = high
    rows[at + 12] = shift
    rows[at + 13] = 0
    rows[at + 14] = 0
    if work[24]:
        # --- there is a block before, that goes through to this one: the ratio of the units
        high = work[25] * topped >> 15
        low = work[27] * full >> 15
        high = (high << 15) // low  # exactly 1 where nothing changes
        shift = work[28] + full_shift - work[26] - top_shift + 15
        while high < 0x2000:
            high <<= 1
            shift += 1
        while high >= 0x4000:
            high >>= 1
            shift -= 1
        rows[at + 13] = high
        rows[at + 14] = shift
    work[25] = full
    work[26] = full_shift + 1000
    work[27] = topped
    work[28] = top_shift + 1000
    return 1


@micropython.viper
def corner(rows: ptr32, at: int, work: ptr32, terms: ptr32):
    """The corner between the block before, where motion goes through from that, and this one."""
    axes = terms[0]
    if work[24]:
        shift = 0
        # The sum of the two directions and their difference, in 2⁻²⁸: their lengths are twice the sine of half the angle
        # between the lines, `sine`, and of half the angle turned through, `root`; both with exponents.
        sine = 0
        sine_shift = 0
        root = 0
        square = 0
        sign = 0
        while sign < 2:
            most = 0
            i = 0
            while i < axes:
                along = work[16 + i] - work[20 + i] if sign else work[16 + i] + work[20 + i]
                if along >> 30 & 1:
                    along = 0 - along
                along &= 0x3FFFFFFF
                work[9 + i] = along
                if along > most:
                    most = along
                i += 1
            sine = root
            sine_shift = shift
            root = 0
            shift = 0
            if most:
                while most < 0x2000:
                    most <<= 1
                    shift -= 1
                while most >= 0x4000:
                    most >>= 1
                    shift += 1
                square = 0
                i = 0
                while i < axes:
                    along = work[9 + i]
                    if shift < 0:
                        along <<= 0 - shift
                    else:
                        along >>= shift
                    work[9 + i] = along
                    square += along * along
                    i += 1
                bit = 0x4000
                while bit:
                    if (root + bit) * (root + bit) <= square:
                        root += bit
                    bit >>= 1
            sign += 1
        high = 0x3FFFFFFF
        if shift > 5 or shift > 3 and root << shift >= 379600:
            # More than 1.4 mrad: a corner. What the axes can do along the change of direction:
            strong = 0x20000000
            i = 0
            while i < axes:
                along = work[9 + i]
                if along:
                    bit = (along << 15) // root + 1
                    rest = terms[28 + i] // bit
                    high = terms[32 + i] - 1000
                    if high < 0:
                        rest >>= 0 - high
                    elif rest < 0x20000000 >> high:
                        rest <<= high
                    else:
                        rest = 0x20000000
                    if rest < strong:
                        strong = rest
                i += 1
            if strong < 1:
                strong = 1
            strong_shift = 0
            while strong < 0x4000:
                strong <<= 1
                strong_shift -= 1
            while strong >= 0x8000:
                strong >>= 1
                strong_shift += 1
            # v² = a · δ · s · (1 + s) / t²
            high = strong * sine >> 15
            low = 0x4000
            if sine_shift > 0:
                low += sine << sine_shift >> 15
            high = high * low >> 15
            high = high * terms[8] >> 15
            high = (high << 15) // ((root * root >> 13) + 1)
            shift = strong_shift + terms[9] - 968 + sine_shift - 2 * shift
            while shift < 0 and high:
                high >>= 1
                shift += 1
            while shift > 0 and high < 0x10000000:
                high <<= 1
                shift -= 1
            if shift > 0 or high > 0x1FFFFFFF:
                high = 0x1FFFFFFF
        rows[at + 20] = high
    work[24] = 1
    i = 0
    while i < axes:
        work[20 + i] = work[16 + i]
        i += 1


@micropython.viper
def look_back(rows: ptr32, work: ptr32, counts: ptr32) -> int:
    """Raise the exits of blocks, from the newest back, as far as one changes; how many blocks back that was."""
    count = (counts[0] - counts[4]) & 0x1FFFFFFF
    if count > 64:
        count = 64
    deepest = count + 2
    stride = work[31]
    behind = (counts[0] - 1) % work[32] * stride
    ends = work[32] * stride
    depth = 0
    while count > 1:
        at = behind - stride
        if at < 0:
            at = ends - stride
        square = 0
        if rows[behind + 9] and rows[at + 9]:
            factor = work[34 + rows[behind + 6]]
            square = rows[behind + 19]
            square = ((square >> 14) * factor << 2) + ((square & 0x3FFF) * factor >> 12)
            if rows[behind + 24] < square:
                square = rows[behind + 24]
            factor = work[34 + rows[at + 6]]
            most = rows[at + 19]
            most = ((most >> 14) * factor << 2) + ((most & 0x3FFF) * factor >> 12)
            if rows[at + 24] < most:
                most = rows[at + 24]
            if most < square:
                square = most
            most = rows[behind + 22] + rows[behind + 21]
            if most < square:
                square = most
            if rows[behind + 20] < square:
                square = rows[behind + 20]
        if square > rows[at + 22]:
            rows[at + 22] = square
            depth = deepest - count
        elif work[33] == 0:
            return depth
        behind = at
        count -= 1
    return depth
