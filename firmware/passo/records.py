"""The fields of every array that several functions share, by name: each is the index of a field in its array.

    rows[row + ROW_TICKS]       # a block in the planner's queue
    state[FEED_HEAD]            # the feeder's state

A kernel takes arrays, because machine code reads an integer of an array in a few cycles and an attribute in hundreds.
`passo build` writes the numbers in place of these names: they cost a board nothing. Every array is an array('i') unless said
otherwise, and every value stays below 2³⁰.
"""

from micropython import const

COUNT_MASK = const(0x1FFFFFFF)  # counts of words, blocks, ticks and milliseconds run modulo 2²⁹: a sum of two stays below 2³⁰
COUNT_HALF = const(0x10000000)  # a count is ahead of another if their difference, modulo 2²⁹, is below this
FARTHEST = const(0x1FFFFFFF)  # position in steps
FASTEST_NM_S = const(0x3FFFFFFF)  # feed of a line that is dealt with in short
BIAS = const(0x20000000)  # makes it positive
INT_MOST = const(0x3FFFFFFF)  # the largest integer that a board keeps off its heap
TICKS_PER_S = const(12_500_000)  # a tick is 80 ns
TICKS_PER_MS = const(12_500)
HOLD_TICKS = const(125_000)  # 10 ms: the longest single word, so that a stop is never far away
LONG_TICKS = const(375_000)  # 30 ms of motion queued: with less a stream is slowed down
LEAD_TICKS = const(375_000)  # 30 ms: how far ahead of the player a main loop makes words
NM_PER_M = const(1_000_000_000)
REST_MS = const(1000)  # a machine that has stood for this time rests: a sender that counts has sent all it may
WINDOW_BITS = const(10)  # of the stream of a stored job
LINES_BYTES = const(1024)  # of G-code lines that a link keeps
JOURNAL_BYTES = const(32)  # of a record of the job's journal, see control/job_journal.py
REGISTER_BIT = const(100)  # pins from here on are bits of shift registers: of the 74HC165 if inputs, of the 74HC595 if outputs
REQUEST_PROVEN = const(1)  # flags of a request over the network: its sender may move the machine
REQUEST_JSON = const(2)  # the answer shall be JSON
NETWORK_PORTS = ("http", "page", "tcp")  # ports of links that are no cable
SETTING_REPORT = const(10)  # this and the next seven: settings that languages ask for too, see config/setting_numbers.py
SETTING_INCHES = const(13)
SETTING_MAX_RPM = const(30)
SETTING_LASER = const(32)

# A block, a line, arc or wait on its way from the planner to the feeder, as a row of Planner.rows, which begins at `row`: an object
# with two dozen attributes would take twice the memory. "Of 2²⁸" is a fraction of the machine's fastest speed, or of its
# square (motion/limits.py). q is the square of a speed in the block's own unit, which is the programmed speed / ROW_TOP.
KIND_LINE = const(0)
KIND_WAIT = const(1)
KIND_INDEPENDENT = const(2)  # axes that run independently of each other
KIND_ARC = const(3)
KIND_STEP_PROGRAM = const(4)  # a path written down step by step
ROW_KIND = const(0)  # KIND_LINE … KIND_STEP_PROGRAM
ROW_TOOL = const(1)  # the tool bit from this block's first word on
ROW_TICKS = const(2)  # WAIT: its length; others: whole ticks a dominant step, of an arc: a step of path
ROW_TICKS_REST = const(3)  # LINE: ticks that remain over all dominant steps, spread evenly; ARC: 128ths of a tick
ROW_FIRST = const(4)  # dominant step to begin at: not 0 if an interrupted block is resumed; STEP_PROGRAM: index
ROW_TAG = const(5)  # a number that the controller wants back when the block has been played
ROW_RAPID = const(6)  # 1: the override for rapid motion counts, not that for the feed
ROW_TOP = const(7)  # the programmed speed, in the block's units
ROW_LIMIT = const(8)  # the highest speed, whatever the override says, in the block's units
ROW_GAIN = const(9)  # q a dominant step; 0: no acceleration, the programmed speed from first to last
ROW_SPAN = const(10)  # ticks a step · 2 · ROW_TOP
ROW_TIME = const(11)  # ticks a unit of speed takes: ROW_TIME / 2 ** ROW_TIME_SHIFT
ROW_TIME_SHIFT = const(12)
ROW_RATIO = const(13)  # its unit of speed over the previous block's: ROW_RATIO / 2 ** ROW_RATIO_SHIFT; 0: it begins at rest
ROW_RATIO_SHIFT = const(14)
ROW_UNIT = const(15)  # q of a square of 2²⁸: · ROW_UNIT / 2 ** ROW_UNIT_SHIFT
ROW_POWER = const(16)  # of the tool, 0 … 1000, at the programmed speed; above POWER_MOST: a row of dots, as DOTS_COUNT says
ROW_DYNAMIC = const(17)  # 1: power in proportion to the speed
ROW_SPEED = const(18)  # as programmed, of 2²⁸
ROW_SQUARE = const(19)  # its square
ROW_CORNER = const(20)  # square of the speed at which the corner at its beginning may be passed
ROW_REACH = const(21)  # square of the speed that it can gain or lose
ROW_EXIT = const(22)  # square of the speed at its end, as planned
ROW_UNIT_SHIFT = const(23)
ROW_FASTEST = const(24)  # square of the speed that the axes allow
ROW_LASTS = const(25)  # ticks that it lasts at the programmed speed, LONG_TICKS at most
ROW_STEPS = const(26)  # then a line's signed steps, one number an axis
# A batch: rows of BATCH_FIELDS on their way to the planner, one a block.
BATCH_KIND = const(0)  # as ROW_KIND; of other than a LINE the planner's row is filled in already
BATCH_FLAGS = const(1)  # 1: the tool is on; 2: rapid motion; 4: power in proportion to the speed
BATCH_FEED = const(2)  # nm/s along the path; 0: as fast as may be; -1: SCRATCH_FEED and SCRATCH_GIVEN say
BATCH_POWER = const(3)  # 0 … 1000, at the speed asked for; of a row of dots the last one's, with DOTS_COUNT and DOTS_FIRST
BATCH_TAG = const(4)
BATCH_FIRST = const(5)  # as ROW_FIRST
BATCH_STEPS = const(6)  # a line's signed steps, one number an axis, four axes at most
BATCH_FIELDS = const(10)
BATCH_ROWS = const(8)  # rows of a batch, at most

# Planner.counts: blocks, for ever, modulo 2²⁹.
QUEUE_ADDED = const(0)
QUEUE_FLUSHED = const(1)  # may be fetched
QUEUE_FETCHED = const(2)
QUEUE_RETIRED = const(3)  # played to their last word
QUEUE_FROZEN = const(4)  # their exits stay as they are
QUEUE_ARC = const(5)  # the block that the next arc's plan is in use for, until it has been played; -1: none
QUEUE_FIELDS = const(6)
QUEUE_SIZE = const(96)  # blocks: 64 that are looked ahead at, 32 in flight

# Planner.work: the planner's scratch, and the values passed from one block to the next.
SCRATCH_FEED = const(0)  # the speed asked for, of 2²⁸; 0: as fast as may be. An arc's, too
SCRATCH_GIVEN = const(1)  # ticks that a line is to last, as a float; 0: its length over its speed
SCRATCH_GIVEN_SHIFT = const(2)
SCRATCH_STEPS_SHIFT = const(3)
SCRATCH_ARC_TOP = const(4)  # of an arc: its top
SCRATCH_IS_ARC = const(8)
SCRATCH_LENGTH = const(9)  # of the path, nm as SCRATCH_LENGTH / 2 ** SCRATCH_LENGTH_SHIFT, of 27 or 28 bits
SCRATCH_LENGTH_SHIFT = const(10)
SCRATCH_ALONG = const(11)  # the highest speed that the axes allow along the path, of 2²⁸
SCRATCH_STRENGTH = const(12)  # and the highest acceleration
SCRATCH_STEPS = const(13)  # dominant steps; of an arc: its path, steps · 2 ** SCRATCH_STEPS_SHIFT
SCRATCH_SPEED = const(14)  # the speed programmed
SCRATCH_LIMITED = const(15)  # 1: the axes cannot go as fast as asked for
SCRATCH_HEADING = const(16)  # direction at the block's beginning, of 2²⁸, one number an axis
SCRATCH_BEFORE = const(20)  # direction at the end of the block before, one number an axis
SCRATCH_THROUGH = const(24)  # 1: motion may go through from the last block queued to the next without a stand
SCRATCH_FULL = const(25)  # speed and top of the block before, as short floats
SCRATCH_FULL_SHIFT = const(26)
SCRATCH_TOP = const(27)
SCRATCH_TOP_SHIFT = const(28)
SCRATCH_PERCENT = const(29)  # overrides: of the feed, of rapid motion
SCRATCH_STRIDE = const(31)  # integers a row
SCRATCH_SIZE = const(32)  # rows
SCRATCH_ALL = const(33)  # 1: look_back() goes on even if nothing has changed
SCRATCH_FACTOR = const(34)  # squares of the overrides of feed and of rapid motion, of 4096
SCRATCH_START = const(36)  # square of the speed that takes no ramp, of 2²⁸
SCRATCH_ASKED = const(37)  # nm/s that SCRATCH_FEED is of; -1: of none
SCRATCH_EAGER = const(38)  # 1: blocks that come while the machine is under way are released; 2: and a stream goes on: see percent()
SHORT_EXPONENT = const(1)  # from a short float, of 15 bits, to its exponent, 1000 too large
SHORT_STEPS = const(39)
SHORT_LENGTH = const(41)
SHORT_STRENGTH = const(43)
SHORT_SINE = const(45)  # likewise, of 14 bits: twice the sine of half the angle between the lines at a corner
SHORT_TURN = const(47)  # and of half the angle turned through
SCRATCH_LASTS = const(49)  # the sum of ROW_LASTS of all that were added, modulo 2²⁹
SCRATCH_TAKEN = const(50)  # and of those that were fetched
SCRATCH_CHANGE = const(51)  # the change of direction at a corner, one number an axis
SCRATCH_FIELDS = const(55)

# Limits.fields: the limits of the axes, a number or a float as two (motion/limits.py).
LIMIT_AXES = const(0)
LIMIT_FINEST = const(1)  # exponent of the lengths of a step
LIMIT_SPEED = const(2)
LIMIT_SPEED_SHIFT = const(3)
LIMIT_GAIN = const(4)
LIMIT_GAIN_SHIFT = const(5)
LIMIT_TIME = const(6)
LIMIT_TIME_SHIFT = const(7)
LIMIT_CORNER = const(8)
LIMIT_CORNER_SHIFT = const(9)
LIMIT_WHOLE = const(10)  # the fastest speed, nm/s; 0 if it is 2³⁰ or more
LIMIT_STEP = const(16)  # one number an axis, as are the next four: length of a step
LIMIT_FASTEST = const(20)  # highest speed
LIMIT_FASTEST_SHIFT = const(24)
LIMIT_STRONGEST = const(28)  # highest acceleration
LIMIT_STRONGEST_SHIFT = const(32)
LIMIT_FIELDS = const(36)

# Steady.state and Ramp.state. The last segment cut:
RAMP_STEPS = const(0)
RAMP_TICKS = const(1)
RAMP_PACE = const(2)  # its mean speed in the block's units; -1: the programmed one
RAMP_Q = const(3)  # the beginning of the next one, in the block's units
RAMP_V = const(4)  # its root, 7 fraction bits
RAMP_START = const(5)  # q that takes no ramp, in the block's units
RAMP_CARRY = const(6)  # of ticks
RAMP_TOTAL = const(7)  # dominant steps of the line
STEADY_FIELDS = const(8)
RAMP_LENGTH = const(8)  # ticks a segment should last
RAMP_S_CURVE = const(9)  # 1: jerk is limited: cut() stops where an option goes on, for which the rest is
RAMP_PATH = const(10)  # of the segment
RAMP_TO_GO = const(11)  # steps of path behind it
RAMP_PART = const(12)  # and 2⁻¹⁷ of one
RAMP_CHANGE = const(13)  # of q, at most
RAMP_CAP = const(14)  # q wanted, in a hold 0
RAMP_HIGH = const(15)  # but for the hold
RAMP_BEGIN = const(16)  # q that it begins with
RAMP_FIELDS = const(17)

# Line.state: a walker along a line.
LINE_AXES = const(0)
LINE_DOMINANT = const(1)  # the axis with most steps
LINE_FALL = const(2)  # twice the dominant steps: a step takes them off an axis's decision
LINE_NEGATIVE = const(3)  # mask of the axes that go backwards
LINE_MOVING = const(4)  # mask of the axes that step
LINE_RISE = const(5)  # three numbers an axis, `axes` times the first, then the second, then the third:
#   rise: twice its steps, what every dominant step adds to its decision
#   decision, with the fall added so that it is never negative: a step is due above the fall
#   made: its signed steps since the feeder last cleared them

# Feeder.state. First the interval of the segment under way, for steps/pace_viper.py:
PACE_SHORT = const(0)  # a word of the shorter interval, without its mask
PACE_TICK = const(1)  # one tick in a word
PACE_REST = const(2)  # PACE_REST / PACE_OVER: the share of the intervals that are a tick longer
PACE_OVER = const(3)
PACE_CARRY = const(4)
FEED_BITS = const(5)  # of a word's levels
FEED_AXES = const(6)
FEED_MASK = const(7)  # the ring's size − 1
FEED_LIMIT = const(8)  # words that may lie between the oldest mark and the next segment
FEED_SETUP = const(9)  # ticks between a change of direction and the next step
FEED_LEVELS = const(10)  # step form of the levels now: directions and tool
FEED_DEBT = const(11)  # ticks of set-up that the intervals to come still owe
FEED_TICKS = const(12)  # of all segments made, modulo 2²⁹, as the next four are
FEED_HEAD = const(13)  # words made
FEED_OLDEST = const(14)  # mark: the last segment played
FEED_NEWEST = const(15)  # mark: the last segment made
FEED_INDEX = const(16)  # dominant steps of its block made so far; of a step program the index
FEED_PACE = const(17)  # mean speed of the segment under way, as RAMP_PACE; 0 at a stand
FEED_PLAYED = const(18)  # words played when segments were last retired
FEED_LEAD = const(19)  # ticks that may lie ahead of the player
FEED_HOLD = const(20)  # 1: come to a stand on the path
FEED_DRIVE = const(21)  # 1: a drive turns steps into levels
FEED_ROW = const(22)  # row of the block under way
FEED_LEFT = const(23)  # dominant steps of it to come, of an arc those of its run; whole words: 1 until they end
FEED_WAIT = const(24)  # ticks of a wait, or of a word longer than a word may be, to come
FEED_TOOL = const(25)  # the tool's bit in the levels
FEED_POWER = const(26)  # of the last mark put; POWER_UNKNOWN: the next segment puts one in any case
FEED_FAST = const(27)  # 1: it is an accelerated line: others may follow it at once
FEED_DRY = const(28)  # 1: all words made have been played
FEED_KIND = const(29)  # of the block under way, as ROW_KIND
FEED_BEGINS = const(30)  # 1: it has no segment yet
FEED_STEPS = const(31)  # of the segment under way: its words
FEED_LASTS = const(32)  # its ticks
FEED_WAITS = const(33)  # 1: it is a wait
FEED_MOVING = const(34)  # masks of the axes that step in it, and of those that go backwards
FEED_NEGATIVE = const(35)
FEED_SHORT = const(36)  # ticks that a line's words lie less far ahead than FEED_LEAD; see Feeder
FEED_POSITION = const(37)  # position after the last word made, of each axis, between −2²⁸ and 2²⁸ − 1

# A mark of Feeder.marks: a checkpoint at the end of a segment. Then the position, of each axis.
MARK_WORD = const(0)  # words so far, modulo 2²⁹
MARK_TICKS = const(1)
MARK_INDEX = const(2)
MARK_ENDS = const(3)  # 1 if the segment is its block's last
MARK_PACE = const(4)
MARK_FIELDS = const(5)
MARKS = const(64)  # most segments made and not yet played, a power of two

# Power.marks: how many have been put and how many played, for ever, modulo 2²⁹; then a ring of marks, and one of dots.
POWER_HEAD = const(0)
POWER_TAIL = const(1)
POWER_MASK = const(2)  # marks, a power of two, − 1
POWER_WAIT = const(3)  # marks that may wait if another segment is made
DOTS_AT = const(4)  # the index of the first dot: powers, 0 … POWER_MOST, of the rows that are queued, three in a number, each of DOTS_COUNT bits
DOTS_MASK = const(5)  # dots, a power of two, − 1; 0: this machine takes no rows
DOTS_HEAD = const(6)  # index of the next dot to be put; the parser's
DOTS_TAIL = const(7)  # and of the oldest one that has not been burnt; the feeder's
POWER_PERCENT = const(8)  # the percentage of every value
POWER_LEAST = const(9)  # a value up to this one, but 0, shows as the weakest level
POWER_MARKS = const(10)

# A mark of them.
POWER_WORD = const(14)  # the bit from which on stands the word that it counts from, modulo 2¹⁶
POWER_WORDS = const(0xFFFF)
POWER_LEVEL = const(0x3FFF)  # mask of its level, 0 … POWER_MOST << POWER_FINE
POWER_MOST = const(1000)
POWER_AHEAD = const(9)  # words that a Pico has to have as a mark's begins, that one included: options/spindle_pwm/port_rp2.py
POWER_FINE = const(4)  # bits of a mark behind the thousandths: in a ramp 1 % of a weak dot is less than one
POWER_UNKNOWN = const(32_000)
# In ROW_POWER and BATCH_POWER, above ten bits: of ROW_POWER a scale, what each dot counts in thousandths.
DOTS_COUNT = const(10)  # the bit from which on stands how many dots there are, at most DOTS_MOST; 0: no row
DOTS_FIRST = const(18)  # and the index of the first
DOTS_MOST = const(255)
DOTS_POWER = const(0x3FF)  # mask of the bits below

# Program._trace: where the lines of a batch may lead. Positions have 2²⁹ added, so that none is negative; four numbers each.
TRACE_LOW = const(0)
TRACE_HIGH = const(4)
TRACE_AXES = const(8)
TRACE_ROOM = const(9)  # the rows that may still be queued
TRACE_TAKEN = const(10)  # the number of the last rows queued
TRACE_MOVED = const(11)  # 1: some have been since the batch was opened; of the last of them:
TRACE_FLAGS = const(12)  # BATCH_FLAGS
TRACE_POWER = const(13)  # BATCH_POWER
TRACE_FIELDS = const(14)

# An arc's plan: the results of arc.plan(), once a block, in steps. "Along the circle" means its length in steps of the path.
ARC_AXIS_A = const(0)  # the plane's axes: counter-clockwise is from A to B; then the third one, -1: none
ARC_AXIS_B = const(1)
ARC_AXIS_Z = const(2)
ARC_MIRROR = const(3)  # 1: clockwise, walked as its mirror image
ARC_REGION = const(4)  # of the start, as circle.py draws them
ARC_U = const(5)  # the start in it: steps along the region's dominant axis, and along the other
ARC_W = const(6)
ARC_RADIUS = const(7)  # steps · 2 ** ARC_SHIFT, of 29 bits
ARC_SHIFT = const(8)
ARC_INSIDE = const(9)  # u of the last whole step inside the diagonal
ARC_ACROSS = const(10)  # -u of the first one behind the diagonal before it
ARC_STEPS = const(11)  # of the dominant axes
ARC_DIAGONAL = const(12)  # length of the step over a diagonal, 2⁻²⁰ steps
ARC_Z_STEPS = const(13)  # signed steps of the third axis along the circle
ARC_Z_HIGH = const(14)  # its steps a step along the circle: 15 and 15 fraction bits
ARC_Z_LOW = const(15)
ARC_TAIL_A = const(16)  # the last short line, from the circle to the end: signed steps
ARC_TAIL_B = const(17)
ARC_TAIL_Z = const(18)
ARC_PATH = const(19)  # the whole length, steps, and 2⁻²⁰ of one
ARC_PATH_FINE = const(20)
ARC_FIELDS = const(21)
ARCS = const(64)  # most in the queue: a plan takes as much memory again as a block

# Circle.state: a walker along an arc. It begins with the arc's plan, but ARC_REGION, ARC_U and ARC_W are where it is,
# ARC_STEPS those of the circle to come after this run, ARC_PATH − ARC_PATH_FINE / 2²⁰ the steps of path to go from the run's
# beginning, and the tail is 0 once it is begun. Then, of the run:
CIRCLE_WORDS = const(21)
CIRCLE_PATH = const(22)  # its length in 2⁻¹³ steps along the circle
CIRCLE_MOVING = const(23)  # masks of axes, as of a line
CIRCLE_NEGATIVE = const(24)
CIRCLE_U_AXIS = const(25)  # the dominant axis, and the other
CIRCLE_W_AXIS = const(26)
CIRCLE_RISE = const(27)  # which of its words are steps of the circle, by Bresenham's method: all, unless the third axis
CIRCLE_FALL = const(28)  # dominates
CIRCLE_DECISION = const(29)
CIRCLE_Z_RISE = const(30)  # steps of the third axis a word, 21 fraction bits
CIRCLE_Z_BETWEEN = const(31)  # its position between two steps, 21 fraction bits
# Of the arc:
CIRCLE_Z_LEFT = const(32)  # steps of the third axis to come after this run
CIRCLE_Z_SUM = const(33)  # its position between two steps after the run, 21 fraction bits
CIRCLE_Z_OVER = const(34)  # the rest of its rounding, 2⁻²⁰ steps of path
CIRCLE_ERROR = const(35)  # u² + w² − R²
CIRCLE_USED = const(36)  # length of the run, 2⁻²⁰ steps
CIRCLE_NEXT = const(37)  # of the step after it; −1: not known yet
CIRCLE_REST = const(38)  # the rest of rounding CIRCLE_PATH, 2⁻²⁰ steps
CIRCLE_ROOT = const(39)  # √(R² − u²) behind the steps measured last, · 2 ** ARC_SHIFT
CIRCLE_LINE = const(40)  # the state of a line's walker, for the tail; here too the steps made are counted

ENDLESS = const(-1)  # steps to come: no end

# The results of a look at the machine (steps/position_viper.py, motion/speed_viper.py): all of one moment.
SEEN_ROOM = const(0)  # blocks that can be queued
SEEN_ROW = const(1)  # row of the oldest block not played to its last word; -1: none
SEEN_PACE = const(2)  # of the segment under way, as MARK_PACE; 0: none is
SEEN_LIT = const(3)  # 1: the tool's bit is on at the pins
SEEN_LINE = const(4)  # tag of that block, if it moves; 0: none
SEEN_MM_S = const(5)  # speed along the path: whole mm/s, and nm/s above them
SEEN_NM_S = const(6)
SEEN_FASTEST = const(7)  # the machine's fastest speed, of which rows have a share: nm/s >> SEEN_SHIFT, below 2³⁰; 0: no limits
SEEN_SHIFT = const(8)
SEEN_FIELDS = const(9)
