"""The most frequent commands, several at a time on their way from a language to the machine: lines to go, points to draw.

    batch.join(*controller.batches(batch))
    while answers := language.take_batch(data, now_ms):   # opens the batch, fills rows, has the machine take them
        ...
    batch.close(batch)

A batch belongs to one link. The controller fills in what a language has to know, the language the rows. A command that a row cannot hold comes as a Command.
"""

from micropython import const

LINES = const(0)
POINTS = const(1)
POINT_BYTES = const(5)


class _Batch:
    moves = True  # if the machine stands, begin the motion of the rows taken before it is answered

    def __init__(self, link):
        self.link = link  # its number
        self.count = 0  # rows filled last
        self.begun = False  # open() has said yes, and close() has not been called since
        self.room = 0  # the controller's, as the next ones: the number of rows

    def join(self, open, accept, close, arc=None):
        """Take the functions of Controller.batches()."""
        self.open, self.accept, self.close, self.arc = open, accept, close, arc


class Lines(_Batch):
    """Rows of BATCH_FIELDS (records.py), each a line from where the one before it ends."""

    kind = LINES

    def __init__(self, link, rows, most, slow_tool, dots):
        """`rows`: array of BATCH_ROWS rows; `most`: lines that are taken at a time; `slow_tool`: a change of the tool takes time,
        and no row may bring one about; `dots`: where the powers of a row of dots go, DOTS_… of it."""
        _Batch.__init__(self, link)
        self.rows = rows
        self.most = most
        self.slow_tool = slow_tool
        self.dots = dots
        # the controller's:
        self.taker = None  # (TRACE_… array, the kernel that queues rows, what it takes behind rows and count): one until these change
        self.target = None  # the position of the first row's start, steps of each axis: an array that is the machine's own
        self.reach = None  # (lowest, highest) positions of the axes if the travel counts; one object until that changes
        self.tool = False  # the tool before the first row
        self.power = 0  # and its power, thousandths
        self.dynamic = False


class Points(_Batch):
    """Points of POINT_BYTES each: 1 for a line or 0, x and y in steps, high byte first. They are kept until DRAW."""

    kind = POINTS
    moves = False

    def __init__(self, link):
        _Batch.__init__(self, link)
        self.data = None  # the controller's: where they go, at most `room`,
        self.offset = 0  # from this byte on,
        self.most_x = self.most_y = 0  # none beyond these
