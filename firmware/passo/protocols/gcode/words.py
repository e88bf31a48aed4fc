"""Cuts a line of G-code into words, bytes to integers, in one pass and without allocating.

    words = Words()
    error = words.scan_line(b"G1 X-1.25 (left) F300") # 0
    words.codes[0]                                  # 100: G1, in hundredths; M codes from M_CODES on
    words.word_value(X, 6)                         # -1250000: the value in millionths

`S0:500` gives S more than one power: a row of dots. `S=@@OT_H` is a packed row, which ends the line: two characters a dot, `@` (0) to `_` (31), 32 · the first +
the second, in thousandths of full power. Blanks are dropped wherever they stand, `(…)` and `;…` are comments, `/` is ignored, small letters are capitals. A byte 00 is an
error, in a comment too: it stands where a break or noise has taken another byte's place. A number has at most nine digits that count,
and twelve decimals; further decimals are dropped.
"""

from array import array
from micropython import const

from passo import errors

LONGEST = const(80)  # characters of a line, blanks and comments aside
ROW_LONGEST = const(127)  # of one with a row of dots
PACKED_LONGEST = const(243)  # of one with a packed row: it fits into a frame
M_CODES = const(1_000_000)
_CODES = const(40)  # G and M words a line of 80 characters can hold
_NINE_DIGITS = const(100_000_000)
_DECIMALS = const(12)

# Letters as bits of a mask: as constants they take no memory on a board.
A = const(0)  # the fourth axis: that of an axis's number is (X + axis) % 26
F = const(5)
G = const(6)
H = const(7)
I = const(8)
J = const(9)
K = const(10)
L = const(11)
M = const(12)
N = const(13)
P = const(15)
Q = const(16)
R = const(17)
S = const(18)
T = const(19)
X = const(23)
Y = const(24)
Z = const(25)
_DOT = const(26)  # a power behind S's first
_POWERS = tuple([10**exponent for exponent in range(_DECIMALS + 1)])


def _letter_mask(letters):
    """Return the mask of letters, A bit 0."""
    mask = 0
    for letter in letters:
        mask |= 1 << ord(letter) - 65
    return mask


_KNOWN = _letter_mask("FGHIJKLMNPQRSTXYZ")
_NEVER_NEGATIVE = _letter_mask("FHNPST")


class Words:
    def __init__(self, known=0):
        """`known`: mask of letters to accept beside those of a machine with three axes."""
        self._known = _KNOWN | known
        self.have = 0  # mask of the letters that have a value, A is bit 0; G and M are not among them
        self.codes = array("i", [0] * _CODES)
        self.count = 0  # of codes
        self.row = None  # thousandths: the values of S if it has several
        self.packed = False  # they are thousandths of full power
        self._mantissa = array("i", [0] * 27)
        self._decimals = bytearray(27)

    def scan_line(self, line):
        """Read a line, bytes. Returns 0, or the number of the first error; then the words mean nothing."""
        self.have = self.count = 0
        self.row, self.packed = None, False
        letter, point = -1, False
        value = digits = decimals = sign = 0
        comment = 0  # the character that began it
        for byte in line:
            if byte <= 32 or byte == 47:
                if not byte:
                    return errors.LETTER
                continue
            if comment:
                if byte == 41 and comment == 40:  # ")" ends what "(" began; nothing ends ";"
                    comment = 0
                continue
            if byte == 40 or byte == 59:
                comment = byte
                continue
            if 48 <= byte <= 57:
                if letter < 0:
                    return errors.LETTER
                digits = 1
                if value < _NINE_DIGITS and decimals < _DECIMALS:
                    value = value * 10 + byte - 48
                    if point:
                        decimals += 1
                elif not point:
                    return errors.NUMBER
            elif byte == 46:
                if point or letter < 0:
                    return errors.LETTER if letter < 0 else errors.NUMBER
                point = True
            elif byte == 45 or byte == 43:
                if letter < 0:
                    return errors.LETTER
                if digits or point or sign:
                    return errors.NUMBER
                sign = 44 - byte
            elif byte == 61 and letter == S and not (digits or point or sign or self.have >> S & 1):
                return self._unpack_row(bare_line(line).partition(b"=")[2])
            else:
                if letter >= 0:
                    error = self._keep_word(letter, -value if sign < 0 else value, digits, decimals)
                    if error:
                        return error
                if byte == 58 and (letter == S or letter == _DOT):
                    if letter == S:
                        self.row = [self.word_value(S, 3)]
                    letter = _DOT
                else:
                    letter = (byte & 0xDF) - 65
                    if not 0 <= letter < 26 or byte < 65:
                        return errors.LETTER
                value = digits = decimals = sign = 0
                point = False
        return self._keep_word(letter, -value if sign < 0 else value, digits, decimals) if letter >= 0 else 0

    def _unpack_row(self, text):
        """Take the powers of a packed row, of digits to the base 32. Returns 0, or the number of an error."""
        for byte in text:
            if byte & 0xE0 != 0x40:
                return errors.LETTER
        if not text or len(text) & 1:
            return errors.NUMBER
        self.row = [(text[at] & 31) << 5 | text[at + 1] & 31 for at in range(0, len(text), 2)]
        self.packed = True
        self.have |= 1 << S
        return errors.NUMBER if max(self.row) > 1000 else 0

    def _keep_word(self, letter, value, digits, decimals):
        """Keep a word's value. Returns 0, or the number of an error."""
        if not digits:
            return errors.NUMBER
        if letter == _DOT:
            self._mantissa[_DOT], self._decimals[_DOT] = value, decimals
            self.row.append(self.word_value(_DOT, 3))
            return errors.NEGATIVE if value < 0 else 0
        bit = 1 << letter
        if letter == G or letter == M:
            return self._keep_code(letter, value, decimals)
        if not bit & self._known:
            return errors.UNSUPPORTED
        if value < 0 and bit & _NEVER_NEGATIVE:
            return errors.NEGATIVE
        if bit & self.have:
            return errors.REPEATED_WORD
        self.have |= bit
        self._mantissa[letter] = value
        self._decimals[letter] = decimals
        return 0

    def _keep_code(self, letter, value, decimals):
        """Keep a G or M code in hundredths. Returns 0, or the number of an error."""
        if decimals > 2 and value % _POWERS[decimals - 2]:
            return errors.UNSUPPORTED
        value = value * 100 // _POWERS[decimals]
        if not 0 <= value < M_CODES or self.count == _CODES:
            return errors.UNSUPPORTED
        self.codes[self.count] = value + M_CODES if letter == M else value
        self.count += 1
        return 0

    def word_value(self, letter, places, by=1):
        """Return `by` times the value of a word in units of 10⁻ᵖˡᵃᶜᵉˢ, rounded to the nearest, halves away from zero."""
        places -= self._decimals[letter]
        value = self._mantissa[letter] * by
        return value * _POWERS[places] if places >= 0 else round_half_away(value, _POWERS[-places])


def bare_line(line, unfinished=False):
    """Return the characters of a line that count: no blanks, no comments, but each 00, and 7F, which stands for a byte beyond ASCII. If it is
    `unfinished`, marks of real-time bytes stay, and an open comment's first character comes last."""
    kept = bytearray()
    comment = 0
    for byte in line:
        if byte <= 32 or byte > 127 or byte == 47:
            if not byte or unfinished and byte < 9:
                kept.append(0)
            continue
        if comment:
            if byte == 41 and comment == 40:
                comment = 0
        elif byte == 40 or byte == 59:
            comment = byte
        else:
            kept.append(byte)
    if unfinished and comment:
        kept.append(comment)
    return kept


def longest_line(line):
    """Return how many characters a line may have, blanks and comments not counted."""
    if b"=" in line and line[:1] != b"$":
        return PACKED_LONGEST
    return ROW_LONGEST if b":" in line else LONGEST


def round_half_away(value, by):
    """Return value / by, `by` > 0, rounded to the nearest, halves away from zero."""
    if value < 0:
        return -((by // 2 - value) // by)
    return (by // 2 + value) // by
