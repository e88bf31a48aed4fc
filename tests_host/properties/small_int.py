"""An integer that is as narrow as the small integers of a board.

A 32-bit board holds −2³⁰ to 2³⁰ − 1 without memory of its own; anything larger allocates, which an interrupt may not
do. Interrupt code fed with `Small` values raises OverflowError where the board would allocate:

    Small(1 << 29) + 1          a Small
    Small(1 << 29) * 2          OverflowError

The result of `Small` with a plain integer is `Small`. Values that come out of an array, `range` or `int()` are plain.
"""

LOW = -(1 << 30)
HIGH = (1 << 30) - 1

BINARY = "add sub mul floordiv mod divmod pow lshift rshift and or xor".split()
UNARY = "neg pos abs invert".split()


class Small(int):
    def __new__(cls, value=0):
        value = int(value)
        if not LOW <= value <= HIGH:
            raise OverflowError(f"{value} is not a small integer: a board would allocate memory for it")
        return super().__new__(cls, value)

    def __truediv__(self, other):
        raise TypeError("true division gives a float, which allocates; use //")

    __rtruediv__ = __truediv__

    def __repr__(self):
        return f"Small({int(self)})"


def small(result):
    if isinstance(result, tuple):
        return tuple(Small(item) for item in result)
    return result if result is NotImplemented else Small(result)


def _wrap(name):
    plain = getattr(int, name)

    def method(self, *others):
        return small(plain(self, *others))

    method.__name__ = name
    setattr(Small, name, method)


for _name in BINARY:
    _wrap(f"__{_name}__")
    _wrap(f"__r{_name}__")
for _name in UNARY:
    _wrap(f"__{_name}__")


class SmallRows:
    """An array whose numbers come out as Small, and that stays the array it is of."""

    def __init__(self, rows):
        self._rows = rows

    def __getitem__(self, place):
        return Small(self._rows[place])

    def __setitem__(self, place, value):
        self._rows[place] = Small(value)
