"""The frames of docs/reference/languages/frames.md: numbers and bytes to a frame, and back. Board and PC use the same.

    wire = delimit_frames(frame(DATA, 0, 0, 15, b"G1X1\\n"))
    if is_sound(data, begin, end):              # a bytearray; the bytes between two delimiters
        kind, number, ack, credit = parse_header(data, begin)
        text = data[begin + HEAD : end - CHECK]
"""

from binascii import crc32

from micropython import const

FRAME_HELLO = const(1)  # kinds
WELCOME = const(2)
DATA = const(3)
ACK = const(4)
AGAIN = const(5)
URGENT = const(6)
CUT = const(7)
REPORT = const(8)
LEAVE = const(9)
TAKEN = const(10)
CLOSED = const(11)

VERSION = const(1)
NEW = const(1)  # WELCOME: nothing has come yet in this session
MOST = const(244)  # bytes in a frame
LEAST = const(16)
CREDIT_BYTES = const(64)  # of one credit
MOST_CREDIT = const(15)
NUMBERS = const(4096)  # bytes are numbered from 0 to one less, then from 0 again
HEAD = const(6)  # before the bytes of a frame that has come, its first code included
CHECK = const(4)  # behind them
LONGEST = const(254)  # between two delimiters
_DELIMITER = b"\0"
_RESIDUE = const(0x2144DF1C)  # CRC-32 of anything and its own CRC-32, low byte first


def frame(kind, number=0, ack=0, credit=0, data=b""):
    """Return a frame's bytes, without delimiters. `credit`: 0 … MOST_CREDIT; `data`: MOST bytes at most."""
    body = bytes((kind << 4 | number >> 8, number & 255, credit << 4 | ack >> 8, ack & 255, len(data))) + data
    body += crc32(body).to_bytes(4, "little")
    return b"".join([bytes((len(part) + 1,)) + part for part in body.split(_DELIMITER)])


def delimit_frames(*frames):
    """Return the bytes on the wire for these frames, in one piece."""
    return _DELIMITER + _DELIMITER.join(frames) + _DELIMITER


def is_sound(data, begin, end):
    """Return True if data[begin:end], without a delimiter in it, is a whole frame. Puts its zeros back where they belong."""
    at = begin
    while at < end:
        code = data[at]
        data[at] = 0
        at += code
    if at != end or end - begin < HEAD + CHECK or data[begin + HEAD - 1] != end - begin - HEAD - CHECK:
        return False
    return crc32(memoryview(data)[begin + 1 : end]) == _RESIDUE


def parse_header(data, begin):
    """Return (kind, number, ack, credit) of a sound frame."""
    high = data[begin + 1]
    low = data[begin + 3]
    return high >> 4, (high & 15) << 8 | data[begin + 2], (low & 15) << 8 | data[begin + 4], low >> 4
