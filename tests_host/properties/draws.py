"""A small generator of random values, the same on every interpreter, and the values for a check's specification.

    random = Random(7)
    random.between(-10, 10)
    draw(random, ("dx", -65535, 65535))

A specification is a tuple whose first item is the parameter's name:

    (name, low, high)                  an integer, both ends included
    (name, "bytes", longest)           bytes, empty to `longest`
    (name, "choice", a, b, …)          one of the values
    (name, "seed")                     an integer for `Random`
    (name, "list", longest, spec, …)   a list; its items are values of the one specification, or tuples of several
"""

SEED_MAX = 0x3FFFFFFF
WIDEST = 1 << 60


class Random:
    """xorshift64: the high 60 bits are used."""

    def __init__(self, seed):
        self.state = (seed * 0x9E3779B97F4A7C15 + 0x1234567) & 0xFFFFFFFFFFFFFFFF or 1
        for _ in range(4):
            self.next()

    def next(self):
        """The next integer, 0 to 2⁶⁰ − 1."""
        s = self.state
        s ^= (s << 13) & 0xFFFFFFFFFFFFFFFF
        s ^= s >> 7
        s ^= (s << 17) & 0xFFFFFFFFFFFFFFFF
        self.state = s
        return s >> 4

    def between(self, low, high):
        """An integer from `low` to `high`, both included; the range is at most 2⁶⁰ wide."""
        if not 0 <= high - low < WIDEST:
            raise ValueError("between(%d, %d): not a range" % (low, high))
        return low + self.next() % (high - low + 1)

    def choice(self, values):
        return values[self.next() % len(values)]

    def bytes(self, count):
        return bytes([self.next() & 255 for _ in range(count)])


def draw(random, spec):
    """A value for one specification. Ends of ranges and values around zero come up more often than chance has it."""
    kind = spec[1]
    if kind == "bytes":
        return random.bytes(length(random, spec[2]))
    if kind == "choice":
        return random.choice(spec[2:])
    if kind == "seed":
        return random.between(0, SEED_MAX)
    if kind == "list":
        items = spec[3:]
        if len(items) == 1:
            return [draw(random, items[0]) for _ in range(length(random, spec[2]))]
        return [tuple([draw(random, item) for item in items]) for _ in range(length(random, spec[2]))]
    return integer(random, kind, spec[2])


def length(random, longest):
    return integer(random, 0, longest)


def integer(random, low, high):
    """One in four is an end or next to zero, one in four is small, where the range allows."""
    style = random.between(0, 3)
    if style == 0:
        value = random.choice((low, high, low + 1, high - 1, 0, 1, -1))
    elif style == 1:
        value = random.between(-40, 40)
    else:
        value = random.between(low, high)
    return value if low <= value <= high else random.between(low, high)
