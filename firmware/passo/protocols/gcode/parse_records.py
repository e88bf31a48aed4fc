"""The fields of GCode.fields, by which parse_viper.py understands plain lines, and of Lines.fields, which has these."""

from micropython import const

# GCode.fields: what plain lines are understood by, three numbers each if the axes'; positions from PARSE_LOW on have 2²⁹ added.
PARSE_AXES = const(0)
PARSE_RELATIVE = const(1)  # 1: G91
PARSE_MODAL = const(2)  # the G that holds for lines without one: 0 … 3
PARSE_FEED = const(3)  # nm/s
PARSE_POSITION = const(4)  # machine coordinates, nm
PARSE_OFFSET = const(7)  # machine position − programme position, nm
PARSE_RESOLUTION = const(10)  # steps a metre
PARSE_TARGET = const(13)  # steps
PARSE_TO = const(16)  # where the line leads as far as it has been read, nm
PARSE_INCHES = const(19)  # 1: G20
PARSE_NUMBER = const(20)  # of the line
PARSE_AFTER = const(21)  # where the next line begins
PARSE_DELTAS = const(22)  # steps of the last one
PARSE_LOW = const(25)  # the travel, steps
PARSE_HIGH = const(28)
PARSE_LEAST = const(31)  # feed, nm/s: steps are no more than 40 s apart
PARSE_FULL = const(32)  # S of full power; 0: S counts for nothing; 1: it must not change
PARSE_RPM = const(33)  # S
PARSE_LIT = const(34)  # 1: the laser is on
PARSE_POWER = const(35)  # thousandths
PARSE_DYNAMIC = const(36)  # 1: power in proportion to the speed
PARSE_VALUE = const(37)  # of the word being read: its digits
PARSE_DECIMALS = const(38)  # how many of them are behind the point
PARSE_POINT = const(39)  # 1: it has a point
PARSE_MINUS = const(40)  # 1: it is negative
PARSE_HAVE = const(41)  # of the line being read: which words it has
HAS_G = const(1)
HAS_F = const(2)
HAS_N = const(4)
HAS_S = const(8)
HAS_X = const(16)  # then Y and Z
HAS_AXES = const(112)
HAS_I = const(128)
HAS_J = const(256)
PARSE_MOTION = const(42)  # and what they say, or what holds: G
PARSE_SPEED = const(43)  # F, nm/s
PARSE_TURNS = const(44)  # S
PARSE_LINE = const(45)  # N
PARSE_ARCS = const(46)  # 1: G2 and G3 are plain too, with I or J: arcs of X and Y
PARSE_I = const(47)  # nm
PARSE_J = const(48)
PARSE_ARC = const(49)  # where the line behind an arc begins, if parse() has stopped at one; 0: it has not
PARSE_DOTS = const(50)  # powers that S has: a row of dots; 0: it has one
PARSE_LAST = const(51)  # the last of them, thousandths
PARSE_NO_ROOM = const(52)  # 1: parse() has stopped at a row for whose dots there is no room yet
PARSE_FIELDS = const(53)

# Lines.fields: bytes of Lines.text.
LINES_AT = const(0)  # where the oldest line begins
LINES_WHOLE = const(1)  # behind the last line that has come to its end
LINES_END = const(2)  # behind all that has come
LINES_ASKED = const(3)  # 1: `?` was among it
LINES_SLOWLY = const(4)  # 1: what comes has to be looked at byte by byte: see Lines.take_each()
LINES_TAKEN = const(5)  # lines that the machine has taken at the last time
LINES_FILLED = const(6)  # rows filled last
LINES_WAITS = const(7)  # 1: the oldest line is not for the full parser, but waits for room
LINES_FIELDS = const(8)
