"""What comes most often, several at a time on its way from a language to the machine: lines to go, points to draw.

    open, accept, close = controller.batches(batch)
    if language.collect(data, now_ms):                          # bytes have come that may be rows
        if open(batch) and language.begin():   # the machine takes some now, as the language has them
            while language.fill(b""):                           # batch.count of them
                answers = language.accepted(accept(batch))
            close(batch)

A batch belongs to one link. The controller fills in what a language has to know, the language the rows. What a row may not
express comes as a Command.
"""

from micropython import const

LINES = const(0)
POINTS = const(1)


def thousandths(power):
    """Of a power in millionths, at least 1 if it is not off."""
    return max((power + 500) // 1000, 1) if power else 0


class Lines:
    """Rows of BATCH_FIELDS (records.py), each a line from where the one before it ends."""

    kind = LINES

    def __init__(self, link, rows, most, slow_tool):
        """`link`: its number; `rows`: array of BATCH_ROWS rows; `most`: rows that one filling takes; `slow_tool`: a change of
        the tool takes time, and no row may bring one about."""
        self.link = link
        self.rows = rows
        self.most = most
        self.slow_tool = slow_tool
        self.count = 0  # rows filled
        self.taken = 0  # of them the machine has queued so many last
        self.more = False  # there may be more of them at once
        # the controller's:
        self.room = 0  # for so many rows
        self.target = None  # where the first row begins, steps of each axis: an array that is the machine's own
        self.reach = None  # (lowest, highest) positions of the axes if the travel counts; one object until that changes
        self.tool = False  # the tool before the first row
        self.power = 0  # and its power, thousandths
        self.dynamic = False


class Points:
    """Points of five bytes each: 1 for a line or 0, x and y in steps, high byte first."""

    kind = POINTS

    def __init__(self, link):
        self.link = link
        self.count = 0
        self.more = False
        # the controller's:
        self.data = None  # where they go,
        self.offset = 0  # from this byte on,
        self.room = 0  # at most so many,
        self.most_x = self.most_y = 0  # none beyond these
