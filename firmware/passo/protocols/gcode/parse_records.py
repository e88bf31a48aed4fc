"""The fields of GCode.fields, by which parse_viper.py understands plain lines, and of Lines.fields, which has these."""

from micropython import const

# GCode.fields: the state by which plain lines are read, four numbers each if the axes'; positions from PARSE_LOW on have 2²⁹ added.
PARSE_AXES = const(0)
PARSE_RELATIVE = const(1)  # 1: G91
PARSE_MODAL = const(2)  # the G that holds for lines without one: 0 … 3
PARSE_FEED = const(3)  # nm/s
PARSE_POSITION = const(4)  # machine coordinates, nm
PARSE_OFFSET = const(8)  # machine position − programme position, nm
PARSE_RESOLUTION = const(12)  # steps a metre
PARSE_TARGET = const(16)  # steps
PARSE_TO = const(20)  # the target of the part of the line read so far, nm
PARSE_INCHES = const(24)  # 1: G20
PARSE_NUMBER = const(25)  # of the line
PARSE_AFTER = const(26)  # the index of the next line
PARSE_DELTAS = const(27)  # steps of the last one
PARSE_LOW = const(31)  # the travel, steps
PARSE_HIGH = const(35)
PARSE_LEAST = const(39)  # feed, nm/s: steps are no more than 40 s apart
PARSE_FULL = const(40)  # S of full power; 0: S counts for nothing; 1: it must not change
PARSE_RPM = const(41)  # S
PARSE_LIT = const(42)  # 1: the laser is on
PARSE_POWER = const(43)  # thousandths
PARSE_DYNAMIC = const(44)  # 1: power in proportion to the speed
PARSE_VALUE = const(45)  # of the word being read: its digits
PARSE_DECIMALS = const(46)  # how many of them are behind the point
PARSE_POINT = const(47)  # 1: it has a point
PARSE_MINUS = const(48)  # 1: it is negative
PARSE_HAVE = const(49)  # of the line being read: which words it has
HAS_G = const(1)
HAS_F = const(2)
HAS_N = const(4)
HAS_S = const(8)
HAS_X = const(16)  # then Y, Z and A
HAS_AXES = const(240)
HAS_I = const(256)
HAS_J = const(512)
HAS_K = const(1024)
PARSE_MOTION = const(50)  # and their values, or the modal ones: G
PARSE_SPEED = const(51)  # F, nm/s
PARSE_TURNS = const(52)  # S
PARSE_LINE = const(53)  # N
PARSE_ARCS = const(54)  # 1: G2 and G3 are plain too, with I or J: arcs of X and Y
PARSE_I = const(55)  # nm
PARSE_J = const(56)
PARSE_ARC = const(57)  # the index of the line behind an arc, if parse() has stopped at one; 0: it has not
PARSE_DOTS = const(58)  # powers that S has: a row of dots; 0: it has one
PARSE_LAST = const(59)  # the last of them, thousandths
PARSE_NO_ROOM = const(60)  # 1: parse() has stopped at a row for whose dots there is no room yet
PARSE_NAMED = const(61)  # axes that plain lines may name, the first
PARSE_KNOWN = const(62)  # counts: odd while all these are filled in and count
PARSE_DOTS_END = const(63)  # the index behind a row; 0: it is left to the parser, or waits
PARSE_FIELDS = const(64)

# Lines.fields: bytes of Lines.text.
LINES_AT = const(0)  # the index of the oldest line
LINES_WHOLE = const(1)  # behind the last line that has come to its end
LINES_END = const(2)  # behind all that has come
LINES_ASKED = const(3)  # 1: `?` was among it
LINES_SLOWLY = const(4)  # 1: the next bytes have to be looked at one by one: see Lines.take_each()
LINES_TAKEN = const(5)  # lines that the machine has taken at the last time
LINES_FILLED = const(6)  # rows filled last
LINES_WAITS = const(7)  # 1: the oldest line is not for the full parser, but waits for room
LINES_SIZE = const(8)  # of Lines.text
LINES_FIELDS = const(9)
