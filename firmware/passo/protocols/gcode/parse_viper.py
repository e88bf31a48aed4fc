"""The most frequent lines of G-code, from their bytes to a batch of steps: G0 or G1 with axis words, and perhaps F, S or N.

    lines = parse_lines(text, at, len(text), fields, batch, dots, read_dots, most)  # how many were understood, at most `most`: rows of the batch

A laser is on at the power that the line's S says, and off in a G0. A row of dots, such as `S0:500:1000` or `S=@@OT_H`, is an option's:
read_dots() puts the powers into `dots`, DOTS_… of Power.marks. A row that finds no room there ends the batch, and waits.

The first line begins at text[at]; each ends with a line feed or the text. `fields` says where the machine is and how lines count; after a
plain line it says where that leads, and where the next line begins; a line of another kind ends the batch, and has not changed what counts.
An arc, a G2 or G3 with I or J, ends the batch too: PARSE_ARC says that it is read, GCode.take_arc() does the rest. An unusual line (any
other word or character, more than six decimals, a position beyond the travel or 2.1 m, a very slow feed, another speed of a spindle, a beam
that changes without a step, a mistake) is left to parser.py, which alone knows the rules; a line read here gives the same as there, to the
nanometre. One text for all interpreters; see motion/block_viper.py for its rules on integers.
"""

import micropython

from passo.protocols.gcode.parse_records import *
from passo.records import *


@micropython.viper
def parse_lines(text: ptr8, begin: int, count: int, fields: ptr32, batch: ptr32, dots: ptr32, read_dots, most: int) -> int:
    """Read plain lines from text[begin:count] to rows of `batch`, at most `most`. Returns how many. See above."""
    lines = 0
    fields[PARSE_ARC] = 0
    fields[PARSE_NO_ROOM] = 0
    while lines < most and begin < count:
        after = int(read_line(text, begin, count, fields, dots, read_dots))
        row = fields[PARSE_DOTS]
        longest = 81  # bytes, its end among them
        if row:
            longest = 244 if fields[PARSE_HAVE] & HAS_S == 0 else 128
        if after == 0 or after - begin > longest or fields[PARSE_HAVE] & HAS_AXES == 0:
            break
        if row and fields[PARSE_MOTION] != 1:
            break
        if fields[PARSE_MOTION] and fields[PARSE_SPEED] < fields[PARSE_LEAST]:
            break
        if fields[PARSE_FULL] == 1 and fields[PARSE_TURNS] != fields[PARSE_RPM]:
            break
        if int(set_deltas(fields)) == 0 or int(set_power(fields)) == 0:
            break
        have = fields[PARSE_HAVE]
        if fields[PARSE_MOTION] > 1 or have & (HAS_I | HAS_J | HAS_K):
            if fields[PARSE_MOTION] > 1 and have & (HAS_I | HAS_J) and fields[PARSE_ARCS] and have & (HAS_X | HAS_X << 1) and have & HAS_X << 3 == 0:
                fields[PARSE_ARC] = after
            break
        if row:
            head = dots[DOTS_HEAD]
            fields[PARSE_POWER] = fields[PARSE_LAST] | row << DOTS_COUNT | head << DOTS_FIRST
            dots[DOTS_HEAD] = (head + row) & dots[DOTS_MASK]
        accept_line(fields, batch, lines * BATCH_FIELDS)
        fields[PARSE_POWER] = fields[PARSE_POWER] & DOTS_POWER
        lines += 1
        begin = after
        fields[PARSE_AFTER] = after
    return lines


@micropython.viper
def read_line(text: ptr8, at: int, count: int, fields: ptr32, dots: ptr32, read_dots) -> int:
    """Read the words of the line at text[at]. Returns where the next line begins, 0 if this one has to be left to the parser."""
    fields[PARSE_MOTION] = fields[PARSE_MODAL]
    fields[PARSE_SPEED] = fields[PARSE_FEED]
    fields[PARSE_TURNS] = fields[PARSE_RPM]
    fields[PARSE_LINE] = 0
    fields[PARSE_HAVE] = 0
    fields[PARSE_DOTS] = 0
    fields[PARSE_I] = 0
    fields[PARSE_J] = 0
    axis = 0
    while axis < fields[PARSE_AXES]:
        fields[PARSE_TO + axis] = fields[PARSE_POSITION + axis]
        axis += 1
    while True:
        byte = int(text[at]) if at < count else 10
        at += 1
        if byte == 10:
            return at
        if byte == 32 or byte == 13 or byte == 9:
            continue
        letter = byte & 0xDF
        if byte < 65 or letter > 90:
            return 0
        if letter != 83 or at == count or text[at] != 61:
            at = int(read_number(text, at, count, fields))
            if at == 0 or int(read_word(fields, letter)) == 0:
                return 0
        if letter == 83 and at < count and (text[at] == 58 or text[at] == 61):
            if dots[DOTS_MASK] == 0:
                return 0
            read_dots(text, at, count, fields, dots)
            at = fields[PARSE_DOTS_END]
            if at == 0:
                return 0


@micropython.viper
def read_number(text: ptr8, at: int, count: int, fields: ptr32) -> int:
    """Read a word's number, blanks within it left out, as PARSE_VALUE, _DECIMALS, _MINUS and _POINT. Returns where it ends, 0 if
    it is none, or has more than nine digits."""
    value = 0
    digits = 0
    decimals = 0
    point = 0
    minus = 0
    while True:
        byte = int(text[at]) if at < count else 10
        if byte >= 48 and byte <= 57:
            if value >= 100000000:
                return 0
            value = value * 10 + byte - 48
            digits = 1
            decimals += point
        elif byte == 46:
            if point:
                return 0
            point = 1
        elif byte == 45:
            if digits or point or minus:
                return 0
            minus = 1
        elif byte != 32 and byte != 13 and byte != 9:
            break
        at += 1
    fields[PARSE_VALUE] = value
    fields[PARSE_DECIMALS] = decimals
    fields[PARSE_POINT] = point
    fields[PARSE_MINUS] = minus
    return at if digits else 0


@micropython.viper
def read_word(fields: ptr32, letter: int) -> int:
    """Store the word's value and return 1; return 0 if it is no plain one, or the line has it already."""
    if letter >= 88:
        return int(axis_word(fields, letter - 88))
    if letter == 65:
        return int(axis_word(fields, 3))
    if letter == 73 or letter == 74:
        return int(centre_word(fields, letter - 73))
    have = fields[PARSE_HAVE]
    value = fields[PARSE_VALUE]
    if letter == 75:  # of an arc with I or J it means nothing
        fields[PARSE_HAVE] = have | HAS_K
        return 0 if have & HAS_K else 1
    if fields[PARSE_MINUS]:
        return 0
    if letter == 71:
        if value > 3 or fields[PARSE_POINT] or have & HAS_G:
            return 0
        fields[PARSE_HAVE] = have | HAS_G
        fields[PARSE_MOTION] = value
    elif letter == 78:
        if value > 10000000 or fields[PARSE_POINT] or have & HAS_N:
            return 0
        fields[PARSE_HAVE] = have | HAS_N
        fields[PARSE_LINE] = value
    elif letter == 70:
        speed = int(feed_of(value, fields[PARSE_DECIMALS], fields[PARSE_INCHES]))
        if speed < 0 or have & HAS_F:
            return 0
        fields[PARSE_HAVE] = have | HAS_F
        fields[PARSE_SPEED] = speed
    elif letter == 83:
        value = int(with_decimals(value, fields[PARSE_DECIMALS], 3, 50000000))
        if value < 0 or value > 500000000 or have & HAS_S:
            return 0
        fields[PARSE_HAVE] = have | HAS_S
        fields[PARSE_TURNS] = value
    else:
        return 0
    return 1


@micropython.viper
def with_decimals(value: int, decimals: int, wanted: int, most: int) -> int:
    """Return `value` with `wanted` decimals; -1 if it has more, or comes to ten times `most` and above."""
    if decimals > wanted:
        return -1
    while decimals < wanted:
        if value > most:
            return -1
        value *= 10
        decimals += 1
    return value


@micropython.viper
def feed_of(value: int, decimals: int, inches: int) -> int:
    """Return a feed in nm/s, rounded, below 2³⁰; -1 if it is larger, or too fine. `value` counts millimetres or inches a minute."""
    if inches:
        value = int(with_decimals(value, decimals, 5, 25000000))
        if value < 0 or value > 250000000:
            return -1
        return value * 4 + (value * 7 + 15) // 30  # · 127 / 30, of 10⁻⁵ inches a minute
    value = int(with_decimals(value, decimals, 3, 50000000))
    if value < 0 or value > 64000000:
        return -1
    return value * 16 + (value * 2 + 1) // 3  # · 50 / 3, of micrometres a minute


@micropython.viper
def axis_word(fields: ptr32, axis: int) -> int:
    """Set PARSE_TO of the axis, in nanometres; return 0 if there is no such axis, the line has it already, or it leads beyond 2.1 m."""
    have = fields[PARSE_HAVE]
    if axis >= fields[PARSE_NAMED] or have >> 4 + axis & 1:
        return 0
    fields[PARSE_HAVE] = have | HAS_X << axis
    value = int(length_of(fields))
    if value < 0:
        return 0
    if fields[PARSE_MINUS]:
        value = 0 - value
    most = 0x3FFFFFFF
    most = most << 1 | 1  # 2³¹ − 1: as a constant it would be no small integer of a board
    base = fields[PARSE_POSITION + axis] if fields[PARSE_RELATIVE] else fields[PARSE_OFFSET + axis]
    if base >> 31 & 1:  # if viper is 64 bits wide it reads a negative number as a positive one
        base = 0 - ((0 - base) & most)
        if value < 0 - most - base:
            return 0
    elif value > most - base:
        return 0
    fields[PARSE_TO + axis] = value + base
    return 1


@micropython.viper
def length_of(fields: ptr32) -> int:
    """Return the word's number as nanometres, without its sign; -1 if it is beyond 2.1 m, or too fine."""
    if fields[PARSE_INCHES] == 0:
        return int(with_decimals(fields[PARSE_VALUE], fields[PARSE_DECIMALS], 6, 214000000))
    value = int(with_decimals(fields[PARSE_VALUE], fields[PARSE_DECIMALS], 5, 845000))
    if value < 0 or value > 8450000:
        return -1
    return value * 254


@micropython.viper
def centre_word(fields: ptr32, which: int) -> int:
    """Set PARSE_I (which 0) or PARSE_J (1). Returns 0 if the line has it already, or it is too far; else 1."""
    have = fields[PARSE_HAVE]
    value = int(length_of(fields))
    if value < 0 or have & HAS_I << which:
        return 0
    fields[PARSE_HAVE] = have | HAS_I << which
    fields[PARSE_I + which] = 0 - value if fields[PARSE_MINUS] else value
    return 1


@micropython.viper
def set_deltas(fields: ptr32) -> int:
    """Set PARSE_DELTAS, the steps of each axis from where the machine is to PARSE_TO. Returns 0 if that is beyond the travel, or too far; else 1."""
    axis = 0
    while axis < fields[PARSE_AXES]:
        delta = 0
        if fields[PARSE_HAVE] >> 4 + axis & 1:
            nm = fields[PARSE_TO + axis]
            minus = nm >> 31 & 1
            steps = int(steps_of(0 - nm if minus else nm, fields[PARSE_RESOLUTION + axis]))
            if steps < 0:
                return 0
            if minus:
                steps = 0 - steps
            if steps + 0x20000000 < fields[PARSE_LOW + axis] or steps + 0x20000000 > fields[PARSE_HIGH + axis]:
                return 0
            delta = fields[PARSE_TARGET + axis]
            if delta >> 30 & 1:
                delta = 0 - ((0 - delta) & 0x3FFFFFFF)
            delta = steps - delta
            if delta > 2097151 or delta < 0 - 2097151:
                return 0
        fields[PARSE_DELTAS + axis] = delta
        axis += 1
    return 1


@micropython.viper
def steps_of(nm: int, resolution: int) -> int:
    """Return nm · resolution / 10⁹, 0 ≤ nm < 2³¹, to the nearest, halves up, by long division in digits of 15 bits; -1 from 2²⁹ on. `resolution` is
    steps a metre."""
    above = resolution if nm >> 30 & 1 else 0
    nm &= 0x3FFFFFFF
    low = (nm & 0x7FFF) * (resolution & 0x7FFF) + 25856  # half of 10⁹ is 15258 · 2¹⁵ + 25856
    middle = (nm >> 15) * (resolution & 0x7FFF) + (nm & 0x7FFF) * (resolution >> 15) + 15258 + (low >> 15)
    high = (nm >> 15) * (resolution >> 15) + (middle >> 15) + above
    if high >= 1000000000:
        return -1
    next_digit = middle & 0x7FFF
    steps = 0
    rounds = 0
    while rounds < 2:
        # One digit of the quotient by 10⁹ = 30517 · 2¹⁵ + 18944: guessed by the first, then put right.
        digit = high // 30517
        high -= digit * 30517
        while high < 0x8000 and (digit >= 0x8000 or digit * 18944 > (high << 15 | next_digit)):
            digit -= 1
            high += 30517
        high = (high << 15 | next_digit) - digit * 18944
        steps = steps << 15 | digit
        next_digit = low & 0x7FFF
        rounds += 1
    return steps if steps <= 0x1FFFFFFF else -1


@micropython.viper
def set_power(fields: ptr32) -> int:
    """Set PARSE_LIT and PARSE_POWER of a laser. Returns 0 if they would change without a step, else 1."""
    if fields[PARSE_FULL] <= 1:
        return 1
    lit = 1 if fields[PARSE_MOTION] and fields[PARSE_TURNS] else 0
    power = int(power_thousandths(fields[PARSE_TURNS], fields[PARSE_FULL])) if lit else 0
    if fields[PARSE_DOTS]:
        power = fields[PARSE_LAST]
        lit = 1 if power else 0
    if fields[PARSE_DOTS] or lit != fields[PARSE_LIT] or power != fields[PARSE_POWER]:
        axis = 0
        while fields[PARSE_DELTAS + axis] == 0:
            axis += 1
            if axis == fields[PARSE_AXES]:
                return 0
        fields[PARSE_LIT] = lit
        fields[PARSE_POWER] = power
    return 1


@micropython.viper
def power_thousandths(part: int, full: int) -> int:
    """Return part / full in thousandths, at most 1000, to the nearest, but not 0 for more than a millionth."""
    if part >= full:
        return 1000
    rest = part
    value = 0
    digits = 0
    while digits < 3:
        rest *= 10
        value = value * 10 + rest // full
        rest %= full
        digits += 1
    if rest << 1 >= full or value == 0 and part > (full - 1) // 1000000:
        value += 1
    return value


@micropython.viper
def accept_line(fields: ptr32, batch: ptr32, row: int):
    """Let the line's values count from here on, and fill in its row."""
    axis = 0
    while axis < fields[PARSE_AXES]:
        fields[PARSE_POSITION + axis] = fields[PARSE_TO + axis]
        fields[PARSE_TARGET + axis] = fields[PARSE_TARGET + axis] + fields[PARSE_DELTAS + axis]
        batch[row + BATCH_STEPS + axis] = fields[PARSE_DELTAS + axis]
        axis += 1
    motion = fields[PARSE_MOTION]
    fields[PARSE_MODAL] = motion
    fields[PARSE_FEED] = fields[PARSE_SPEED]
    fields[PARSE_NUMBER] = fields[PARSE_LINE]
    fields[PARSE_RPM] = fields[PARSE_TURNS]
    flags = fields[PARSE_LIT]
    if motion == 0:
        flags |= 2
    if fields[PARSE_DYNAMIC]:
        flags |= 4
    batch[row + BATCH_KIND] = 0
    batch[row + BATCH_FLAGS] = flags
    batch[row + BATCH_FEED] = fields[PARSE_SPEED] if motion else 0
    batch[row + BATCH_POWER] = fields[PARSE_POWER]
    batch[row + BATCH_TAG] = fields[PARSE_LINE]
    batch[row + BATCH_FIRST] = 0
