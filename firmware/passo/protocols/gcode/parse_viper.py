"""The most frequent lines of G-code, from their bytes to a batch of steps: G0 or G1 with axis words, and perhaps F, S or N.

    lines = parse(text, at, len(text), place, batch, most)  # how many were understood, at most `most`: rows of the batch

A laser is on at the power that the line's S says, and off in a G0.

The first line begins at text[at]; each ends with a line feed or the text. `place` says where the machine is and how lines
count; after a plain line it says where that leads, and where the next line begins; a line of another kind ends the batch, and
has not changed what counts. What is unusual (any other word or character, more than six
decimals, a place beyond the travel or 2.1 m, a very slow feed, another speed of a spindle, a beam that changes
without a step, a mistake) is left to parser.py, which alone knows the rules; what is understood here gives what it
gives, to the nanometre. One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary
Python; see motion/block_viper.py for what that asks of integers.
"""
# ruff: noqa: F821

import micropython

from passo.records import (
    BATCH_FEED, BATCH_FIELDS, BATCH_FIRST, BATCH_FLAGS, BATCH_KIND, BATCH_POWER, BATCH_STEPS, BATCH_TAG, PARSE_AFTER,
    PARSE_AXES, PARSE_DELTAS, PARSE_DYNAMIC, PARSE_FEED, PARSE_FULL, PARSE_HIGH, PARSE_INCHES, PARSE_LEAST, PARSE_LIT,
    PARSE_LOW, PARSE_MODAL, PARSE_NUMBER, PARSE_OFFSET, PARSE_POSITION, PARSE_POWER, PARSE_RELATIVE, PARSE_RESOLUTION,
    PARSE_RPM, PARSE_TARGET, PARSE_TO,
)  # fmt: skip

try:
    ptr32, ptr8
except NameError:
    ptr32 = ptr8 = None  # names that only viper's compiler knows


@micropython.viper
def parse(text: ptr8, begin: int, count: int, place: ptr32, batch: ptr32, most: int) -> int:
    """See above."""
    most_nm = 0x3FFFFFFF
    most_nm = most_nm << 1 | 1  # 2³¹ − 1: as a constant it would be no small integer of a board
    lines = 0
    while lines < most and begin < count:
        axes = place[PARSE_AXES]
        motion = place[PARSE_MODAL]
        feed = place[PARSE_FEED]
        inches = place[PARSE_INCHES]
        full = place[PARSE_FULL]
        rpm = place[PARSE_RPM]
        number = 0
        have = 0
        at = 0
        while at < 3:
            place[PARSE_TO + at] = place[PARSE_POSITION + at]  # where the line leads, as far as it has been read
            at += 1
        at = begin
        letter = 0
        while True:
            byte = int(text[at]) if at < count else 10
            if byte == 10 and letter == 0:
                break
            if byte == 32 or byte == 13 or byte == 9:
                at += 1
            elif letter == 0:
                letter = byte & 0xDF
                if letter < 88 and letter != 83 and letter != 71 and letter != 70 and letter != 78 or letter > 90 or byte < 65:
                    return lines
                value = 0
                digits = 0
                decimals = 0
                point = 0
                negative = 0
                at += 1
            elif byte >= 48 and byte <= 57:
                if value >= 100000000:
                    return lines
                value = value * 10 + byte - 48
                digits = 1
                decimals += point
                at += 1
            elif byte == 46:
                if point:
                    return lines
                point = 1
                at += 1
            elif byte == 45:
                if digits or point or negative:
                    return lines
                negative = 1
                at += 1
            else:
                # --- a word has ended, and the byte begins the next
                if digits == 0:
                    return lines
                if letter >= 88:
                    letter -= 88
                    if letter >= axes or decimals > 6 or have >> (4 + letter) & 1:
                        return lines
                    have |= 16 << letter
                    if inches:
                        if decimals > 5:
                            return lines
                        while decimals < 5:
                            if value > 845000:
                                return lines
                            value *= 10
                            decimals += 1
                        if value > 8450000:
                            return lines
                        value *= 254
                        decimals = 6
                    while decimals < 6:
                        if value > 214000000:
                            return lines
                        value *= 10
                        decimals += 1
                    if negative:
                        value = 0 - value
                    digits = place[PARSE_POSITION + letter] if place[PARSE_RELATIVE] else place[PARSE_OFFSET + letter]
                    if digits >> 31 & 1:  # where viper is 64 bits wide it reads a negative number as a positive one
                        digits = 0 - ((0 - digits) & most_nm)
                        if value < 0 - most_nm - digits:
                            return lines
                    elif value > most_nm - digits:
                        return lines
                    place[PARSE_TO + letter] = value + digits
                elif letter == 71:
                    if value > 1 or negative or point or have & 1:
                        return lines
                    have |= 1
                    motion = value
                elif letter == 78:
                    if value > 10000000 or negative or point or have & 4:
                        return lines
                    have |= 4
                    number = value
                elif letter == 70 and inches:
                    if negative or decimals > 5 or have & 2:
                        return lines
                    have |= 2
                    while decimals < 5:
                        if value > 1500000:
                            return lines
                        value *= 10
                        decimals += 1
                    if value > 16000000:
                        return lines
                    feed = (value * 127 + 15) // 30  # 10⁻⁵ inches a minute to nm/s, rounded
                else:
                    if negative or decimals > 3:
                        return lines
                    while decimals < 3:
                        if value > 50000000:
                            return lines
                        value *= 10
                        decimals += 1
                    if letter == 70:
                        if value > 40000000 or have & 2:
                            return lines
                        have |= 2
                        feed = (value * 50 + 1) // 3  # micrometres a minute to nm/s, rounded
                    else:
                        if value > 500000000 or have & 8:
                            return lines
                        have |= 8
                        rpm = value
                letter = 0
        after = at + 1
        if have < 16 or motion and feed < place[PARSE_LEAST] or full == 1 and rpm != place[PARSE_RPM] or at - begin > 80:
            return lines
        # --- nanometres to steps: · steps a metre / 10⁹, to the nearest, halves away from zero; in digits of 15 bits, and one above them
        at = 0
        while at < axes:
            place[PARSE_DELTAS + at] = 0
            if have >> (4 + at) & 1:
                value = place[PARSE_TO + at]
                negative = value >> 31 & 1
                if negative:
                    value = 0 - value
                digits = place[PARSE_RESOLUTION + at]
                decimals = digits if value >> 30 & 1 else 0
                value &= 0x3FFFFFFF
                low = (value & 0x7FFF) * (digits & 0x7FFF) + 25856  # half of 10⁹ is 15258 · 2¹⁵ + 25856
                point = (value >> 15) * (digits & 0x7FFF) + (value & 0x7FFF) * (digits >> 15) + 15258 + (low >> 15)
                low &= 0x7FFF
                value = (value >> 15) * (digits >> 15) + (point >> 15) + decimals
                point &= 0x7FFF
                if value >= 1000000000:
                    return lines
                steps = 0
                decimals = 0
                while decimals < 2:
                    # One digit of the quotient by 10⁹ = 30517 · 2¹⁵ + 18944: guessed by the first, then put right.
                    digits = value // 30517
                    value -= digits * 30517
                    while value < 0x8000 and (digits >= 0x8000 or digits * 18944 > (value << 15 | point)):
                        digits -= 1
                        value += 30517
                    value = (value << 15 | point) - digits * 18944
                    steps = steps << 15 | digits
                    point = low
                    decimals += 1
                if steps > 0x1FFFFFFF:
                    return lines
                if negative:
                    steps = 0 - steps
                value = steps + 0x20000000
                if value < place[PARSE_LOW + at] or value > place[PARSE_HIGH + at]:
                    return lines
                value = place[PARSE_TARGET + at]
                if value >> 30 & 1:
                    value = 0 - ((0 - value) & 0x3FFFFFFF)
                steps -= value
                if steps > 2097151 or steps < 0 - 2097151:
                    return lines
                place[PARSE_DELTAS + at] = steps
            at += 1
        if full > 1:
            # --- S in thousandths of full power, to the nearest, but not 0 for more than a millionth
            letter = 1 if motion and rpm else 0
            value = 0
            if letter and rpm < full:
                digits = rpm
                decimals = 0
                while decimals < 3:
                    digits *= 10
                    value = value * 10 + digits // full
                    digits %= full
                    decimals += 1
                if digits << 1 >= full or value == 0 and rpm > (full - 1) // 1000000:
                    value += 1
            elif letter:
                value = 1000
            if letter != place[PARSE_LIT] or value != place[PARSE_POWER]:
                at = 0
                while place[PARSE_DELTAS + at] == 0:
                    at += 1
                    if at == axes:
                        return lines
                place[PARSE_LIT] = letter
                place[PARSE_POWER] = value
        # --- all is right: from here on it counts
        at = 0
        while at < axes:
            place[PARSE_POSITION + at] = place[PARSE_TO + at]
            place[PARSE_TARGET + at] = place[PARSE_TARGET + at] + place[PARSE_DELTAS + at]
            at += 1
        place[PARSE_MODAL] = motion
        place[PARSE_FEED] = feed
        place[PARSE_NUMBER] = number
        place[PARSE_RPM] = rpm
        flags = place[PARSE_LIT]
        if motion == 0:
            flags |= 2
            feed = 0
        if place[PARSE_DYNAMIC]:
            flags |= 4
        row = lines * BATCH_FIELDS
        batch[row + BATCH_KIND] = 0
        batch[row + BATCH_FLAGS] = flags
        batch[row + BATCH_FEED] = feed
        batch[row + BATCH_POWER] = place[PARSE_POWER]
        batch[row + BATCH_TAG] = number
        batch[row + BATCH_FIRST] = 0
        row += BATCH_STEPS
        at = 0
        while at < axes:
            batch[row + at] = place[PARSE_DELTAS + at]
            at += 1
        lines += 1
        begin = after
        place[PARSE_AFTER] = after
    return lines
