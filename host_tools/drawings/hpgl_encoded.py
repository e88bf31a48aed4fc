"""HP-GL/2's polylines in a code of their own (PE): numbers to the base of 64 or 32, the last digit of each by other letters.

    decode_moves("…")      # [(pen down, absolute, x, y), … or a pen's number]
"""

_LARGEST_SHIFT = 64


def decode_moves(text):
    """Return [(down, absolute, x, y), or the number of a pen] of a PE instruction. The rest is left out behind a number too large, or behind a pair
    cut off."""
    found, pair, flags, base, bits, waits = [], [], set(), 64, 0, ""
    value = shift = 0
    for letter in text:
        code = ord(letter)
        if letter in "<=":
            flags.add(letter)
        elif letter in ":>":
            waits = letter
        elif letter == "7":
            base = 32
        else:
            ends = 191 if base == 64 else 95  # the lowest code of a number's last digit
            digit = code - (ends if code >= ends else 63)
            if not 0 <= digit < base:
                continue
            value, shift = value + (digit << shift), shift + (6 if base == 64 else 5)
            if shift > _LARGEST_SHIFT:
                return found
            if code < ends:
                continue
            number, value, shift = (value >> 1) * (-1 if value & 1 else 1), 0, 0
            if waits == ":":
                found.append(abs(number))
            elif waits == ">":
                bits = max(-30, min(30, number))
            else:
                pair.append(number / 2.0**bits)
                if len(pair) == 2:
                    found.append(("<" not in flags, "=" in flags, *pair))
                    pair, flags = [], set()
            waits = ""
    return found
