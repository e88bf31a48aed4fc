"""The ring of step words between the feeder and the player.

One producer, one consumer, no lock: only the feeder writes `words` and `head`; only the player owns the count of words
played. Each publishes its counter after its work is done, and a counter is one machine word, so an interrupt between
any two statements sees a consistent ring. Nothing here allocates after the constructor.

    words   . . . [a a a b b b b c] . . .
                   ^played          ^head        both count for ever, modulo 2²⁹
"""

from micropython import const

from passo.arrays import numbers
from passo.motion.line import MAX_RUN
from passo.records import MARKS, MARK_FIELDS, TICKS_PER_MS
from passo.steps.power import Power

_FEW = const(8)  # marks of power that nothing shows
_EACH_SEGMENT = const(128)  # marks: one a segment at most
_EACH_DOT = const(512)
_DOTS = const(1024)  # of the rows that are queued


def mark_items(axes):
    """Return the length of the array of checkpoints of `axes` axes."""
    return MARKS * (MARK_FIELDS + axes)


def fastest(speed, rates):
    """Return the steps a second of the fastest axis. `speed`: that of a checked board file; `rates`: (steps a metre, µm a minute) of each axis."""
    most = 500_000 // speed["min"] if speed["unit"] == "half_period_us" else speed["max"]
    for steps_per_m, um_min in rates:
        most = max(most, steps_per_m * um_min // 60_000_000)
    return most


def ring_size(steps_s, lead_ticks):
    """Return the words of a ring for at most `steps_s`, made `lead_ticks` ahead: as many of them and the longest segment, rounded up to a power of
    two, 1024 … 4096."""
    words = steps_s * (lead_ticks // TICKS_PER_MS) // 1000 + MAX_RUN + 2
    size = 1024
    while size < words and size < 4096:
        size *= 2
    return size


def power_room(board):
    """Return (marks, dots) of a checked board's tool: dots if an option burns rows of them."""
    if not board["spindle"]["pwm"]:
        return _FEW, 0
    return (_EACH_DOT, _DOTS) if getattr(board.get("additions"), "burn", None) else (_EACH_SEGMENT, 0)


class Ring:
    def __init__(self, size=4096, marks=_EACH_SEGMENT, dots=0):
        """`size`: words; `marks` and `dots`: of Power."""
        if size & (size - 1):
            raise ValueError("the ring's size must be a power of two")
        self.size = size
        self.mask = size - 1
        self.words = numbers(size)
        self.words[self.mask] = 0  # the levels before the first word
        self.head = 0
        self.power = Power(marks, dots)  # of the tool, by the words' numbers
