"""The ring of step words between the feeder and the player.

One producer, one consumer, no lock: only the feeder writes `words` and `head`; only the player owns the count of words
played. Each publishes its counter after its work is done, and a counter is one machine word, so an interrupt between
any two statements sees a consistent ring. Nothing here allocates after the constructor.

    words   . . . [a a a b b b b c] . . .
                   ^played          ^head        both count for ever, modulo 2²⁹
"""

from passo.motion.integers import numbers
from passo.motion.line import MAX_RUN
from passo.records import COUNT_MASK, TICKS_PER_MS
from passo.steps.power import Power


def ring_size(steps_s, lead_ticks):
    """Words of a ring for at most `steps_s`, made `lead_ticks` ahead: as many of them and the longest segment, where the
    largest has room for that."""
    words = steps_s * (lead_ticks // TICKS_PER_MS) // 1000 + MAX_RUN + 2
    size = 1024
    while size < words and size < 4096:
        size *= 2
    return size


class Ring:
    def __init__(self, size=4096):
        if size & (size - 1):
            raise ValueError("the ring's size must be a power of two")
        self.size = size
        self.mask = size - 1
        self.words = numbers(size)
        self.words[self.mask] = 0  # the levels before the first word
        self.head = 0
        self.power = Power()  # of the tool, by the words' numbers

    def publish(self, count):  # ISR: no allocation
        """Hand `count` words, written from `head` on, to the player."""
        self.head = (self.head + count) & COUNT_MASK
