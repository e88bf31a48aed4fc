"""G-code: every code, every error number, exact units, and lines that nobody would write."""

from math import cos, pi, sin

from draws import Random
from passo import commands, error_texts, errors
from passo.control import arcs
from passo.motion.integers import isqrt
from passo.protocols.gcode import words as gcode_words
from passo.protocols.gcode.parser import GCode
from passo.protocols.gcode.offsets import Offsets
from passo.protocols.gcode.words import F, X, Y, Words

ALPHABET = b"GMXYZHIJKFSPLRTN0123456789.-+ ();/$gmxyz"
GOOD = (
    b"G1 X1.5 Y-2 F300", b"G2 X2 Y0 I1 J0 F100", b"G38.2 Z-5 F50", b"G92 X0 Y0", b"G10 L20 P1 X0 Y0 Z0", b"G4 P0.5",
    b"M3 S1000", b"G28 X0", b"G81 X1 Y2 Z-3 R1 F100", b"G53 G0 X0", b"G43.1 Z1", b"G55", b"M30", b"G93 G1 X1 F2",
    b"G3 I-5 H90 F100", b"G83 X1 Y2 Z-3 R1 Q0.7 F100", b"G82 X1 Z-3 R1 P0.1 F100", b"G10 L1 P1 Z5", b"G43 H1 Z5", b"G64 P0.1 Q0.2",
)
CASES = {
    "check_millimetres_are_exact": (("value", -999_999_999, 999_999_999), ("decimals", 0, 9)),
    "check_inches_are_exact": (("value", -9_999_999, 9_999_999), ("decimals", 0, 5)),
    "check_mutated_lines": (("seed", "seed"),),
    "check_noise": (("line", "bytes", 90),),
    "check_sweep_angles": (("i", -99_999, 99_999), ("j", -99_999, 99_999), ("sweep", 0, 7_200_000), ("clockwise", 0, 1)),
    "check_arc_centres": (
        ("x", -5_000_000, 5_000_000), ("y", -5_000_000, 5_000_000), ("more", 100, 9_000_000), ("way", 0, 3),
    ),
}
RUNS = {"check_mutated_lines": 400, "check_noise": 400}


class Memory:
    """The memory of the offsets."""

    def __init__(self):
        self.kept = {}

    def get(self, key):
        return self.kept.get(key)

    def put(self, key, text):
        self.kept[key] = text


class Machine:
    """Carries out each command at once: 250 steps/mm, on Z 400, on A 53.333."""

    def __init__(self, axes="xyz"):
        self.axes = axes
        self.target = [0] * len(axes)
        self.steps_per_m = [250_000, 250_000, 400_000, 53_333][: len(axes)]
        self.arcs = arcs
        self.settings = self  # of them it asks for one

    def places(self, number):
        """The board has no such setting."""


def made_of(gcode):
    """All commands of the line that was read last, in their order; those of a cycle are made one by one."""
    made = []
    for command in gcode.commands:
        if command.kind != commands.MORE:
            made.append(command)
            continue
        following = next(command.value)
        while following is not None:
            made.append(following)
            following = next(command.value)
    return made


class Shop:
    """A parser with a machine that obeys it."""

    def __init__(self, machine=None):
        self.machine = machine or Machine()
        self.memory = Memory()
        self.gcode = GCode(self.machine.axes, Offsets(len(self.machine.axes), self.memory), self.machine)
        self.made = []

    def do(self, *lines):
        """Interpret and carry out; the commands of the last line."""
        for line in lines:
            error = self.gcode.interpret_line(line)
            assert error == 0, (line, error, error_texts.text(error))
            self.made = made_of(self.gcode)
            for command in self.made:
                if command.kind in (commands.LINE, commands.ARC, commands.PROBE, commands.JOG_TO):
                    self.machine.target = command.target[:]
        return self.made

    def at(self):
        """Return the machine's position, in steps."""
        return tuple(self.machine.target)

    def state(self):
        """All that a refused line must leave as it is."""
        code = self.gcode
        offsets = code.offsets
        return (
            code.motion, code.plane, code.inches, code.absolute, code.per_minute, code.feed, code.system, code.spindle,
            code.rpm, code.coolant, code.tool, code.number, code.initial, code.cycle, tuple(code.position),
            str(offsets.systems), str(offsets.homes), str(offsets.shift), offsets.tool,
        )


# (lines before, line, number of the error)
ERRORS = (
    ((), b"10", errors.LETTER),
    ((), b"-X1", errors.LETTER),
    ((), b"X1%", errors.LETTER),
    ((), b".5", errors.LETTER),
    ((), b"X1 \x7f", errors.LETTER),
    ((), b"G", errors.NUMBER),
    ((), b"G1 X F100", errors.NUMBER),
    ((), b"X1.2.3", errors.NUMBER),
    ((), b"X--1", errors.NUMBER),
    ((), b"X1-1", errors.NUMBER),
    ((), b"X.", errors.NUMBER),
    ((), b"X1234567890", errors.NUMBER),
    ((), b"F-1", errors.NEGATIVE),
    ((b"G81 X1 Z-1 R2 F60", b"G91"), b"X2", errors.VALUE_MISSING),
    ((b"G81 X1 Z-1 R2 F60", b"G20"), b"X2 Z-1", errors.VALUE_MISSING),
    ((b"G91 G83 X1 Z-1 R2 Q1 F60", b"G90"), b"X2 R1", errors.VALUE_MISSING),
    ((b"G83 X1 Z-1 R2 Q1 F60", b"G20"), b"X2 R1 Z0", errors.VALUE_MISSING),
    ((), b"S-1", errors.NEGATIVE),
    ((), b"T-1", errors.NEGATIVE),
    ((), b"N-1", errors.NEGATIVE),
    ((), b"G4 P-1", errors.NEGATIVE),
    ((), b"G5", errors.UNSUPPORTED),
    ((), b"G-1", errors.UNSUPPORTED),
    ((), b"M48", errors.UNSUPPORTED),
    ((), b"M107", errors.UNSUPPORTED),
    ((), b"G1 E4 F100", errors.UNSUPPORTED),
    ((), b"G1 A4 F100", errors.UNSUPPORTED),
    ((), b"G38.1 X1 F100", errors.UNSUPPORTED),
    ((), b"G43.2 H1", errors.UNSUPPORTED),
    ((), b"G18 G81 X1 Z-1 R2 F100", errors.UNSUPPORTED),
    ((b"G81 X1 Z-1 R2 F100",), b"G19 X2", errors.UNSUPPORTED),
    ((b"G10 L1 P1 Z5",), b"G43 H2", errors.NO_SUCH_TOOL),
    ((b"G10 L1 P1 Z5",), b"G43 H1 G0 Z5 X999999999", errors.JOG_TRAVEL),
    ((), b"G43 H256", errors.TOOL_NUMBER),
    ((), b"G10 L1 P0 Z5", errors.TOOL_NUMBER),
    ((), b"G10 L1 P256 Z5", errors.TOOL_NUMBER),
    ((), b"G10 L1 P1 X5", errors.TOOL_LENGTH_AXIS),
    ((), b"G10 L1 P1 Z5 R3", errors.WORDS_UNUSED),
    ((), b"G73 X1 Z-1 R1 F100", errors.VALUE_MISSING),
    ((), b"G83 X1 Z-1 R1 Q0 F100", errors.NUMBER_RANGE),
    ((), b"G83 X1 Z-1 R1 Q-1 F100", errors.NUMBER_RANGE),
    ((), b"G82 X1 Z-1 R1 P-1 F100", errors.NEGATIVE),
    ((), b"G82 X1 Z-1 R1 Q1 F100", errors.WORDS_UNUSED),
    ((), b"G81 X1 Z-9999999 R1 F100", errors.JOG_TRAVEL),
    ((b"G81 X1 Z-1 R1 F100",), b"G82 X1 Z-1", errors.VALUE_MISSING),
    ((), b"G81 G43.1 Z-1 R1 F100", errors.TWO_AXIS_COMMANDS),
    ((), b"G61 P1", errors.WORDS_UNUSED),
    ((), b"G10 L3 P1 X0", errors.UNSUPPORTED),
    ((), b"G10 L2 P1 X0 R30", errors.UNSUPPORTED),
    ((), b"G17 G18", errors.SAME_GROUP),
    ((), b"G20 G21", errors.SAME_GROUP),
    ((), b"G90 G91", errors.SAME_GROUP),
    ((), b"G93 G94", errors.SAME_GROUP),
    ((), b"G54 G55", errors.SAME_GROUP),
    ((), b"G4 P1 G53", errors.SAME_GROUP),
    ((), b"G0 G80", errors.SAME_GROUP),
    ((), b"M3 M4", errors.SAME_GROUP),
    ((), b"M7 M8", errors.SAME_GROUP),
    ((), b"M0 M30", errors.SAME_GROUP),
    ((), b"G1 X1", errors.NO_FEED),
    ((), b"G1", errors.NO_FEED),
    ((), b"G2 X1 I1", errors.NO_FEED),
    ((), b"G38.2 X1", errors.NO_FEED),
    ((), b"G1 X1 F0", errors.NO_FEED),
    ((b"G93 G1 X1 F2",), b"X2", errors.NO_FEED),
    ((b"F100", b"G93"), b"G1 X1", errors.NO_FEED),
    ((b"G93 G1 X1 F2",), b"G94 X2", errors.NO_FEED),
    ((), b"G1.5 X1 F100", errors.NOT_INTEGER),
    ((), b"G21.5", errors.NOT_INTEGER),
    ((), b"M3.2", errors.NOT_INTEGER),
    ((), b"G2 X2 I1 P1.5 F100", errors.NOT_INTEGER),
    ((), b"G0 G1 X1 F100", errors.TWO_AXIS_COMMANDS),
    ((), b"G0 X1 G92", errors.TWO_AXIS_COMMANDS),
    ((), b"G28 G92 X1", errors.TWO_AXIS_COMMANDS),
    ((), b"G43.1 Z1 G1 X1 F100", errors.TWO_AXIS_COMMANDS),
    ((), b"X1 X2", errors.REPEATED_WORD),
    ((), b"N1 N1", errors.REPEATED_WORD),
    ((), b"G92", errors.NO_AXIS_WORDS),
    ((), b"G10 L2 P1", errors.NO_AXIS_WORDS),
    ((), b"G38.2 F100", errors.NO_AXIS_WORDS),
    ((), b"G2 I1 F100", errors.NO_AXIS_WORDS),
    ((), b"N10000001", errors.LINE_NUMBER),
    ((), b"G4", errors.VALUE_MISSING),
    ((), b"G10 X1", errors.VALUE_MISSING),
    ((), b"G10 L2 X1", errors.VALUE_MISSING),
    ((), b"G10 P1 X1", errors.VALUE_MISSING),
    ((), b"G81 X1 Z-1 F100", errors.VALUE_MISSING),
    ((), b"G81 X1 R1 F100", errors.VALUE_MISSING),
    ((), b"G59.1", errors.NO_SUCH_SYSTEM),
    ((), b"G59.3", errors.NO_SUCH_SYSTEM),
    ((), b"G10 L2 P7 X0", errors.NO_SUCH_SYSTEM),
    ((), b"G53 G2 X1 I1 F100", errors.MACHINE_COORDINATES),
    ((b"G80",), b"G53 X1", errors.MACHINE_COORDINATES),
    ((), b"G80 X1", errors.AXIS_WORDS_UNUSED),
    ((b"G80",), b"X1", errors.AXIS_WORDS_UNUSED),
    ((), b"G2 Z1 I1 F100", errors.NO_AXIS_IN_PLANE),
    ((), b"G18 G2 Y1 I1 F100", errors.NO_AXIS_IN_PLANE),
    ((), b"G2 X2 I7 F100", errors.TARGET),
    ((), b"G2 X0 R1 F100", errors.TARGET),
    ((), b"G2 X0 I0 F100", errors.TARGET),
    ((), b"G38.2 X0 F100", errors.TARGET),
    ((), b"G0 X999999999", errors.JOG_TRAVEL),
    ((), b"G81 X1 Z2 R1 F100", errors.TARGET),
    ((), b"G2 X10 R4 F100", errors.RADIUS),
    ((), b"G2 X1 F100", errors.NO_CENTRE),
    ((), b"G18 G2 X1 J1 F100", errors.NO_CENTRE),
    ((), b"G1 X1 F100 P2", errors.WORDS_UNUSED),
    ((), b"L2", errors.WORDS_UNUSED),
    ((), b"G0 X1 I1", errors.WORDS_UNUSED),
    ((), b"G2 X2 R1 I1 F100", errors.WORDS_UNUSED),
    ((), b"G43.1 X1", errors.TOOL_LENGTH_AXIS),
    ((), b"G43.1", errors.TOOL_LENGTH_AXIS),
    ((), b"G43.1 X1 Z1", errors.TOOL_LENGTH_AXIS),
    ((), b"T256", errors.TOOL_NUMBER),
)
JOG_ERRORS = (
    (b"X1", errors.NO_FEED),
    (b"F100", errors.NO_AXIS_WORDS),
    (b"G1 X1 F100", errors.JOG_WORDS),
    (b"M3 X1 F100", errors.JOG_WORDS),
    (b"G92 X1 F100", errors.JOG_WORDS),
    (b"G17 X1 F100", errors.JOG_WORDS),
    (b"G93 X1 F100", errors.JOG_WORDS),
    (b"X1 F100 S100", errors.WORDS_UNUSED),
    (b"X1 F100 I1", errors.WORDS_UNUSED),
    (b"X1 F-100", errors.NEGATIVE),
)


def check_every_error():
    for before, line, number in ERRORS:
        shop = Shop()
        shop.do(*before)
        state = shop.state()
        error = shop.gcode.interpret_line(line)
        assert error == number, (line, error, number)
        assert shop.gcode.commands == []
        assert shop.state() == state, line


# (lines before, the cycle, all of its motions: steps of X and Z, feed or rapid; P: a dwell in ms)
CYCLES = (
    ((b"G0 Z3",), b"G98 G81 X1 Z-1 R2 F60", ("250 1200", "250 800", "F 250 -400", "250 1200")),
    ((b"G0 Z3",), b"G99 G81 X1 Z-1 R2 F60", ("250 1200", "250 800", "F 250 -400", "250 800")),
    ((), b"G81 X1 Z-1 R2 F60", ("0 800", "250 800", "250 800", "F 250 -400", "250 800")),
    ((b"G0 Z3",), b"G99 G82 X1 Z-1 R2 P0.25 F60", ("250 1200", "250 800", "F 250 -400", "P 250", "250 800")),
    (
        (b"G0 Z3",), b"G83 X1 Z-1 R2 Q1.25 F60",
        ("250 1200", "250 800", "F 250 300", "250 800", "250 402", "F 250 -200", "250 800", "250 -98", "F 250 -400", "250 1200"),
    ),
    ((b"G0 Z3",), b"G99 G73 X1 Z-0.5 R2 Q1.25 F60", ("250 1200", "250 800", "F 250 300", "250 402", "F 250 -200", "250 800")),
    ((b"G0 Z3",), b"G99 G83 X1 Z-1 R2 Q3 F60", ("250 1200", "250 800", "F 250 -400", "250 800")),
    ((b"G0 Z3", b"G99 G83 X1 Z-1 R2 Q2 F60"), b"X2", ("500 800", "500 800", "F 500 0", "500 800", "500 102", "F 500 -400", "500 800")),
    ((b"G0 Z3", b"G99 G82 X1 Z-1 R2 P0.5 F60"), b"X2 P1", ("500 800", "500 800", "F 500 -400", "P 1000", "500 800")),
    # G98 within a series: as LinuxCNC's rs274
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"X2"), b"G98 X3", ("750 1200", "750 800", "F 750 -400", "750 1200")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"G98"), b"X3", ("750 1200", "750 800", "F 750 -400", "750 1200")),
    ((b"G0 Z3", b"G99 G73 X1 Z-1 R2 Q1 F60"), b"G98 G81 X3 Z-1 R2", ("750 1200", "750 800", "F 750 -400", "750 1200")),
    ((b"G0 Z3", b"G91 G99 G81 X1 Z-3 R-1 F60", b"X1", b"G98"), b"X1", ("750 1200", "750 800", "F 750 -400", "750 1200")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"M8", b"G4 P0", b"G28 Z4"), b"G98 X3", ("250 800", "750 1200", "750 800", "F 750 -400", "750 1200")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"R4 X2"), b"G98 R2 X3", ("750 1600", "750 800", "F 750 -400", "750 1200")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"G80"), b"G98 G81 X3 Z-1 R2", ("750 800", "750 800", "F 750 -400", "750 800")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"G1 X2"), b"G98 G81 X3 Z-1 R2", ("750 800", "750 800", "F 750 -400", "750 800")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"M30", b"G98"), b"G81 X3 Z-1 R2 F60", ("750 800", "750 800", "F 750 -400", "750 800")),
    # a shift within the series: heights are the program's numbers
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"G43.1 Z1"), b"G98 X3", ("250 1200", "750 1600", "750 1200", "F 750 0", "750 1600")),
    ((b"G0 Z3", b"G99 G81 X1 Z-1 R2 F60", b"G91"), b"X2 Z-3 R-1 L2", ("750 800", "750 800", "F 750 -400", "750 800", "1250 800", "1250 800", "F 1250 -400", "1250 800")),
)  # fmt: skip


def shown(command):
    if command.kind == commands.DWELL:
        return "P %d" % (command.value // 1000)
    return "%s%d %d" % ("F " if command.feed else "", command.target[0], command.target[2])


def check_cycles():
    """Every motion, those that are made as they come; before the first, the tops and bottoms of the holes are checked."""
    for before, line, wanted in CYCLES:
        shop = Shop()
        shop.do(*before)
        assert shop.gcode.interpret_line(line) == 0, line
        looked_at = [shown(motion) for motion in shop.gcode.commands[0].also]
        made = [shown(command) for command in made_of(shop.gcode)]
        assert tuple(made) == wanted, (line, made)
        heights = [int(text.split(" ")[-1]) for text in made if text[0] != "P"]
        checked = [int(text.split(" ")[-1]) for text in looked_at + made[:1]]
        assert min(heights) == min(checked) and max(heights) == max(checked)
        assert shop.gcode.position[0] * 250 // 1_000_000 == int(made[-1].split(" ")[0])


def check_all_holes_are_looked_at():
    """Of holes in a row the first and the last, before anything moves."""
    shop = Shop()
    shop.do(b"G0 X1 Z3")
    assert shop.gcode.interpret_line(b"G91 G99 G83 X2 Y1 Z-4 R-1 Q0.5 L5 F60") == 0
    looked_at = [motion.target for motion in shop.gcode.commands[0].also]
    assert [250 * 3, 250, -800] in looked_at and [250 * 11, 1250, -800] in looked_at
    made = made_of(shop.gcode)
    assert made[-1].target == [250 * 11, 1250, 800] and shop.gcode._steps == made[-1].target


def check_words_around_a_cycle():
    """Spindle, coolant and tool change come before the cycle, M0 after it."""
    shop = Shop()
    made = shop.do(b"G0 Z3", b"M3 S500 M8 T1 M6 G81 X1 Z-1 R2 F60 M0")
    kinds = [command.kind for command in made]
    assert kinds[:3] == [commands.SPINDLE, commands.PAUSE, commands.COOLANT] and kinds[-1] == commands.PAUSE, kinds
    assert kinds[3:-1] == [commands.LINE] * 4


def check_a_deep_hole():
    """A thousand pecks are made one by one."""
    shop = Shop()
    shop.do(b"G0 Z3")
    assert shop.gcode.interpret_line(b"G99 G83 X1 Z-8 R2 Q0.01 F60") == 0
    assert len(shop.gcode.commands) == 2
    assert len(made_of(shop.gcode)) == 2 + 3 * 999 + 2


def check_the_third_centre_word_means_nothing():
    """K in G17, J in G18, I in G19 beside the plane's own, as grbl and as FreeCAD's post for it writes it; not beside R, nor alone."""
    for plane, arc, word in ((b"G17", b"G3 X-2 Y2 I-2", b"K"), (b"G18", b"G2 X2 Z-2 K-2", b"J"), (b"G19", b"G3 Y-1.5 Z2.5 J-2 K0.5 P2", b"I")):
        found = []
        for value in (b"", word + b"0.000", word + b"-7.5"):
            shop = Shop()
            shop.do(b"F100", plane)
            (command,) = shop.do(arc + value)
            found.append((command.target, command.centre, command.clockwise, command.turns, command.first, command.second))
        assert found[1] == found[0] == found[2], (plane, found)
        for line, error in ((b"G2 X1 Y1 Z1 R5" + word + b"0", errors.WORDS_UNUSED), (b"G2 X1 Y1 Z1 " + word + b"0", errors.NO_CENTRE)):
            assert shop.gcode.interpret_line(line) == error, line
        assert shop.gcode.interpret_line(b"G1 X1" + word + b"0") == errors.WORDS_UNUSED


def check_z_of_a_machine_of_two_axes():
    """It stands at 0: Z0 moves nothing, least of all X and Y home, any other Z is refused."""
    shop = Shop(Machine("xy"))
    shop.do(b"G10 L2 P1 X1", b"G0 X3 Y4 Z0", b"G28.1", b"G0 X5 Y-2.0 Z-0.000", b"F100")
    stands = shop.at()
    for line in (b"Z0", b"G0 Z0", b"G1 Z0", b"G28 Z0", b"G91 G30 Z0", b"Z0", b"G90 G53 G0 Z0", b"G92 Z0", b"G10 L20 P1 Z0", b"G10 L2 P2 Z0"):
        shop.do(line)
        assert shop.at() == stands and shop.gcode.offsets.systems[0] == [1_000_000, 0] and shop.gcode.offsets.shift == [0, 0], line
    shop.do(b"G92 X0 Z0", b"G91 G2 X1 Y1 Z0 I1", b"G28 X0 Z0", b"G90")
    assert shop.at() == (1000, stands[1] + 250)
    for line in (b"Z1", b"G0 X1 Z-0.001", b"G91 Z0.1", b"G92 Z5", b"G10 L2 P1 Z2", b"G81 X1 Z0 R0", b"G38.2 Z0", b"G2 Z0 I1", b"G43.1 Z0"):
        state = shop.state()
        assert shop.gcode.interpret_line(line) != 0 and shop.state() == state, line


def check_a_refused_line_keeps_the_length():
    shop = Shop()
    shop.do(b"G10 L1 P1 Z2", b"G43 H1")
    for line in (b"G49 G0 X999999999", b"G43 H0 L5", b"G43.1 Z5 X1"):
        assert shop.gcode.interpret_line(line) != 0
        assert shop.gcode.offsets.tool == 2_000_000
    shop.do(b"G0 Z1")
    assert shop.at() == (0, 0, 1200)


def check_every_jog_error():
    for line, number in JOG_ERRORS:
        shop = Shop()
        state = shop.state()
        assert shop.gcode.interpret_line(line, True) == number, line
        assert shop.gcode.commands == [] and shop.state() == state


# (lines, steps of X, Y, Z at the end): 250 steps/mm, on Z 400
PLACES = (
    ((b"G0 X1 Y-2 Z3",), (250, -500, 1200)),
    ((b"g0x1y-2z3",), (250, -500, 1200)),
    ((b"G0 X 1 . 5 (to the right) Y0 ; and so on",), (375, 0, 0)),
    ((b"/G0 X1",), (250, 0, 0)),
    ((b"G00 X01.50000000000001",), (375, 0, 0)),
    ((b"G1 F100 X1", b"Y1", b"Z1"), (250, 250, 400)),
    ((b"G91 G0 X1", b"X1", b"G90 Y1"), (500, 250, 0)),
    ((b"G20 G0 X1",), (6350, 0, 0)),
    ((b"G20 G91 G0 X.001", b"X.001"), (13, 0, 0)),
    ((b"G54 G10 L2 P1 X10", b"G0 X1"), (2750, 0, 0)),
    ((b"G10 L2 P2 X10", b"G0 X1", b"G55 X1"), (2750, 0, 0)),
    ((b"G10 L2 P0 Y10", b"G0 Y1"), (0, 2750, 0)),
    ((b"G0 X5", b"G10 L20 P1 X1", b"G0 X2"), (1500, 0, 0)),
    ((b"G0 X5", b"G92 X0", b"G0 X1"), (1500, 0, 0)),
    ((b"G0 X5", b"G92 X0", b"G92.1", b"G0 X1"), (250, 0, 0)),
    ((b"G10 L2 P1 X10", b"G92 X3", b"G53 G0 X1"), (250, 0, 0)),
    ((b"G43.1 Z1", b"G0 Z1"), (0, 0, 800)),
    ((b"G43.1 Z1", b"G0 Z1", b"G49", b"Z1"), (0, 0, 400)),
    ((b"G0 X3 Y3", b"G28.1", b"G0 X9 Y9", b"G28"), (750, 750, 0)),
    ((b"G0 X3 Y3", b"G30.1", b"G0 X9 Y9", b"G30 X0"), (750, 2250, 0)),
    ((b"G0 X3 Y3 Z3", b"G91 G28 Z1"), (750, 750, 0)),
    ((b"G2 X2 Y0 I1 F100",), (500, 0, 0)),
    ((b"G3 X2 Y0 R1 Z1 F100",), (500, 0, 400)),
    ((b"G18 G2 X2 Z0 I1 F100",), (500, 0, 0)),
    ((b"G19 G3 Y2 Z0 J1 F100",), (0, 500, 0)),
    ((b"G81 X1 Y1 Z-1 R1 F100",), (250, 250, 400)),
    ((b"G0 Z5", b"G99 G81 X1 Y1 Z-1 R1 F100", b"X2"), (500, 250, 400)),
    ((b"G0 Z5", b"G98 G81 X1 Y1 Z-1 R1 F100"), (250, 250, 2000)),
    ((b"G91 G81 X1 Z-2 R1 L3 F100",), (750, 0, 400)),
    ((b"G80", b"G0 X1"), (250, 0, 0)),
    ((b"G0 Z5", b"G98 G82 X1 Z-1 R1 P0.5 F100", b"X2"), (500, 0, 2000)),
    ((b"G0 Z5", b"G99 G83 X1 Z-1 R1 Q0.3 F100", b"X2"), (500, 0, 400)),
    ((b"G0 Z5", b"G99 G73 X1 Z-1 R2 Q0.3 F100", b"G80", b"G0 Y1"), (250, 250, 800)),
    ((b"G91 G73 X1 Z-2 R1 Q0.5 L3 F100",), (750, 0, 400)),
    ((b"G0 Z5", b"G99 G81 X1 Z-1 R1 F100 M3 S500 M8",), (250, 0, 400)),
    ((b"G61.1 G0 X1", b"G64", b"G64 P0.01 Q0.02 X2", b"G61 X3"), (750, 0, 0)),
    ((b"G43 H1", b"G0 Z1"), (0, 0, 400)),
    ((b"G43.1 Z2", b"G43 H1 Z1"), (0, 0, 1200)),  # no table: the length stays, as one that M6 has measured
    ((b"G10 L1 P1 Z2", b"G10 L1 P2 Z3", b"G43 H1 Z1"), (0, 0, 1200)),
    ((b"G10 L1 P1 Z2", b"T1 M6", b"G43", b"G0 Z1"), (0, 0, 1200)),
    ((b"G10 L1 P1 Z2", b"T1 G43 G0 Z1", b"G49 Z1"), (0, 0, 400)),
    ((b"G10 L1 P1 Z2", b"G43 H1", b"G43 H0 Z1"), (0, 0, 400)),
    ((b"G20 G10 L1 P1 Z1", b"G43 H1", b"G21 G0 Z1"), (0, 0, 10560)),
    ((b"G17 G21 G40 G49 G54 G61 G80 G90 G91.1 G94 M5 M9", b"G0 X1"), (250, 0, 0)),
    ((b"", b"(nothing)", b";", b"G"[:0]), (0, 0, 0)),
)


def check_places():
    for lines, place in PLACES:
        shop = Shop()
        shop.do(*lines)
        assert shop.at() == place, (lines, shop.at())


def kinds(made):
    return [command.kind for command in made]


def check_motion_words():
    shop = Shop()
    (line,) = shop.do(b"N12 G1 X1 F600")
    assert (line.kind, line.feed, line.number, line.tool) == (commands.LINE, 10_000_000, 12, False)
    (line,) = shop.do(b"G0 X2")
    assert line.feed == 0 and line.number == 0
    (line,) = shop.do(b"G93 G1 X3 F2.5")
    assert line.per_min == 2500
    (line,) = shop.do(b"G20 G94 X1 F60")
    assert line.feed == 25_400_000 and line.per_min == 0
    for line, value in ((b"G38.2 X2", 0), (b"G38.3 X3", 2), (b"G38.4 X4", 1), (b"G38.5 X5", 3)):
        (probe,) = shop.do(line)
        assert (probe.kind, probe.value) == (commands.PROBE, value)


def check_arcs():
    shop = Shop()
    (arc,) = shop.do(b"G2 X2 Y0 I1 J0 F100")
    assert (arc.first, arc.second, arc.clockwise, arc.centre, arc.turns) == (0, 1, True, (250, 0), 1)
    (arc,) = shop.do(b"G3 X2 Y0 J-1")
    assert (arc.clockwise, arc.centre, arc.target) == (False, (0, -250), [500, 0, 0])
    (arc,) = shop.do(b"G3 X2 Y0 Z3 I1 P4")
    assert arc.turns == 4 and arc.target == [500, 0, 1200]
    (arc,) = shop.do(b"G18 G2 X2 Z5 K1")
    assert (arc.first, arc.second, arc.centre) == (2, 0, (400, 0))
    (arc,) = shop.do(b"G17 G2 X3 Y1 R1")
    assert arc.centre == (250, 0)
    (arc,) = shop.do(b"G3 X3 Y0 R-.5")
    assert arc.centre == (0, -125)


def check_everything_else():
    shop = Shop()
    assert kinds(shop.do(b"M3 S500")) == [commands.SPINDLE]
    assert shop.gcode.commands[0].power == 500000 and shop.gcode.commands[0].value == 3 and shop.gcode.commands[0].tool
    assert kinds(shop.do(b"M3 S500")) == []
    assert kinds(shop.do(b"M8 S600 G1 X1 F100")) == [commands.SPINDLE, commands.COOLANT, commands.LINE]
    assert shop.gcode.commands[1].value == 1 and shop.gcode.commands[2].tool and shop.gcode.commands[2].power == 600000
    assert kinds(shop.do(b"M7")) == [commands.COOLANT] and shop.gcode.commands[0].value == 3
    assert kinds(shop.do(b"M9")) == [commands.COOLANT] and shop.gcode.commands[0].value == 0
    assert kinds(shop.do(b"G4 P1.25")) == [commands.DWELL] and shop.gcode.commands[0].value == 1_250_000
    for line in (b"M0", b"M1", b"T1 M6"):
        assert kinds(shop.do(line)) == [commands.PAUSE]
    assert shop.gcode.tool == 1
    assert kinds(shop.do(b"G0 X5 M0")) == [commands.LINE, commands.PAUSE]
    shop.do(b"G91 G55 G20 G93 G18")
    made = kinds(shop.do(b"M2"))
    assert made == [commands.SPINDLE, commands.COOLANT, commands.OVERRIDE, commands.SYNC] and shop.gcode.ended
    code = shop.gcode
    assert (code.motion, code.absolute, code.system, code.per_minute, code.plane) == (100, True, 0, True, 17)
    assert (code.spindle, code.coolant, code.inches) == (5, 0, True)


def check_laser():
    """The beam is lit on cutting motions only, and a change of power does not stop the machine."""
    shop = Shop()
    shop.gcode.laser = True
    (spindle,) = shop.do(b"M4 S1000")
    assert not spindle.tool
    (line,) = shop.do(b"G1 X1 F100")
    assert line.tool and line.power == 1000000 and line.dynamic
    (line,) = shop.do(b"X2 S300")
    assert line.tool and line.power == 300000
    (line,) = shop.do(b"X3 S0")
    assert not line.tool and line.power == 0
    (line,) = shop.do(b"G0 X4 S300")
    assert not line.tool and line.power == 0
    (line,) = shop.do(b"G1 X5")
    assert line.tool and line.power == 300000
    assert kinds(shop.do(b"S200")) == kinds(shop.do(b"G0 S100")) == [commands.SPINDLE]
    assert kinds(shop.do(b"G28 S50")) == [commands.SPINDLE, commands.LINE]
    made = shop.do(b"M3 G1 X5")
    assert kinds(made) == [commands.SPINDLE, commands.LINE] and made[0].tool and not made[1].dynamic
    (line,) = shop.do(b"G28")
    assert not line.tool


def check_jogs_leave_the_modes():
    shop = Shop()
    shop.do(b"G1 X1 F100")
    assert shop.gcode.interpret_line(b"G91 G20 X1 F10", True) == 0
    (jog,) = shop.gcode.commands
    assert jog.kind == commands.JOG_TO and jog.target == [6600, 0, 0] and jog.feed == 4_233_333
    assert (shop.gcode.absolute, shop.gcode.inches, shop.gcode.motion) == (True, False, 100)
    assert shop.gcode.feed == rate(100)


def rate(mm_min):
    return (mm_min * 1_000_000 + 30) // 60


def check_the_machine_may_be_moved_by_others():
    shop = Shop()
    shop.do(b"G0 X1.0001")
    shop.do(b"G91 X1")
    assert shop.at() == (500, 0, 0)
    shop.machine.target = [25, 0, 0]
    shop.do(b"X1")
    assert shop.at() == (275, 0, 0)


def check_offsets_are_kept():
    shop = Shop()
    shop.do(b"G0 X1 Y2 Z3", b"G10 L20 P3 X0 Y0", b"G28.1", b"G10 L2 P6 Z-1.5")
    again = Offsets(3, shop.memory)
    assert again.systems[2] == [1_000_000, 2_000_000, 0] and again.systems[5] == [0, 0, -1_500_000]
    assert again.homes[28] == [1_000_000, 2_000_000, 3_000_000] and again.homes[30] == [0, 0, 0]
    shop.memory.put("G54", "1,x,3")
    shop.memory.put("G55", "7")
    again.load()
    assert again.systems[0] == [0, 0, 0] and again.systems[1] == [7, 0, 0]


def check_millimetres_are_exact(value, decimals):
    words = Words()
    text = number(value, decimals)
    assert words.scan_line(b"X" + text.encode() + b"F1") == 0
    if decimals <= 6:
        assert words.word_value(X, 6) == value * 10 ** (6 - decimals)
    else:
        by = 10 ** (decimals - 6)
        assert abs(words.word_value(X, 6) * by - value) * 2 <= by
    assert words.word_value(F, 0) == 1 and not words.have >> Y & 1


def check_inches_are_exact(value, decimals):
    words = Words()
    assert words.scan_line(b"X" + number(value, decimals).encode()) == 0
    assert words.word_value(X, 5, 254) * 10**decimals == value * 25_400_000


def number(value, decimals):
    """`value` / 10 ** decimals as text."""
    digits = str(abs(value))
    digits = "0" * (decimals + 1 - len(digits)) + digits
    text = digits[: len(digits) - decimals] + "." + digits[len(digits) - decimals :]
    return "-" + text if value < 0 else text


def check_sweep_angles(i, j, sweep, clockwise):
    """H, an arc's angle instead of its end, in 10⁻⁴ degrees here: within a step of the true end, turns as it says."""
    shop = Shop()
    line = "G%d I%.3f J%.3f H%.4f F100" % (2 if clockwise else 3, i / 1000, j / 1000, sweep / 10_000)
    error = shop.gcode.interpret_line(line.encode())
    if not sweep or not (i or j):
        assert error == errors.TARGET
        return
    assert error == 0, line
    move = shop.gcode.commands[-1]
    angle = sweep / 10_000 * pi / 180 * (-1 if clockwise else 1)
    x, y = i / 4, j / 4  # steps
    end = x - x * cos(angle) + y * sin(angle), y - x * sin(angle) - y * cos(angle)
    assert abs(move.target[0] - end[0]) <= 1 and abs(move.target[1] - end[1]) <= 1
    assert move.kind == commands.ARC and move.turns == (sweep - 1) // 3_600_000 + 1
    assert move.over_half == ((sweep - 1) % 3_600_000 >= 1_800_000)


def check_sweep_angle_lines():
    for line, error in (
        (b"G3 I-5 H-90 F100", errors.NEGATIVE), (b"G3 I-5 H0 F100", errors.TARGET), (b"G3 H90 F100", errors.NO_CENTRE),
        (b"G3 X5 I-5 H90 F100", errors.AXIS_WORDS_UNUSED), (b"G3 I-5 H90 P2 F100", errors.WORDS_UNUSED),
        (b"G3 R5 H90 F100", errors.NO_CENTRE), (b"G1 H90 X1 F100", errors.WORDS_UNUSED), (b"H90", errors.WORDS_UNUSED),
        (b"G3 I0 J0 H90 F100", errors.TARGET), (b"G3 I-5 H90", errors.NO_FEED),
    ):
        assert Shop().gcode.interpret_line(line) == error, line
    shop = Shop()
    shop.do(b"G3 I-5 H90 F100")
    assert shop.at() == (-1250, 1250, 0)
    shop.do(b"I0 J-5 Z1 H180")  # modal, a helix
    assert shop.at() == (-1250, -1250, 400)
    assert shop.do(b"G2 I-5 H360")[-1].turns == 1 and shop.at() == (-1250, -1250, 400)
    assert shop.do(b"G2 I-5 H720")[-1].turns == 2 and shop.at() == (-1250, -1250, 400)
    assert shop.do(b"G2 I-5 H450")[-1].turns == 2 and shop.at() == (-2500, -2500, 400)
    assert shop.do(b"G19 G3 J-4 H90")[-1].target == [-2500, -3500, 2000]


def check_arc_centres(x, y, more, way):
    """Centres by radius lie as far from the start as from the end, on the side that makes the arc short or long."""
    clockwise = bool(way & 1)
    chord = isqrt(x * x + y * y)
    if not chord:
        assert arcs.centre_of(x, y, more, clockwise)[0] == errors.TARGET
        return
    radius = chord // 2 + more
    error, i, j = arcs.centre_of(x, y, -radius if way & 2 else radius, clockwise)
    assert error == 0 and arcs.check_centre(x, y, i, j) == 0
    assert abs(isqrt(i * i + j * j) - radius) <= 2
    left = x * j - y * i  # > 0: the centre lies left of the chord
    if abs(left) > 4 * chord:
        assert (left > 0) == ((not clockwise) == (not way & 2))


def check_mutated_lines(seed):
    """Raises nothing, and a refused line changes nothing."""
    random = Random(seed)
    shop = Shop()
    for _ in range(4):
        line = bytearray(random.choice(GOOD))
        for _ in range(random.between(0, 4)):
            at = random.between(0, len(line) - 1)
            change = random.between(0, 2)
            if change == 0:
                line[at] = random.choice(ALPHABET)
            elif change == 1:
                line = line[:at] + bytes((random.choice(ALPHABET),)) + line[at:]
            elif len(line) > 1:
                line = line[:at] + line[at + 1 :]
        obey(shop, bytes(line))


def check_noise(line):
    obey(Shop(), line)


def obey(shop, line):
    state = shop.state()
    error = shop.gcode.interpret_line(line)
    if error:
        assert shop.gcode.commands == [] and shop.state() == state
        assert error_texts.text(error) != "error %d" % error
    for command in made_of(shop.gcode):
        if command.target:
            shop.machine.target = command.target[:]
            assert max([abs(steps) for steps in command.target]) < 1 << 29


def check_length_counts_what_stays():
    for line, count in ((b"G1 X1", 4), (b"(all of this) G1;and this", 2), (b" /\t", 0), (b"a(b(c)d", 2), (b"x" * 81, 81)):
        assert len(gcode_words.bare_line(line)) == count
