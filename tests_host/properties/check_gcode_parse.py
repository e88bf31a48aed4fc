"""Plain lines, dealt with in short, give what the whole of G-code gives: the same command and modal state, to the nm."""

from array import array

from check_gcode import ALPHABET, Machine, Shop, made_of
from draws import Random
from passo import commands
from passo.batch import Lines as Batch
from passo.commands import thousandths
from passo.protocols.grbl.lines import ARC, Lines
from passo.options.spindle_pwm.language_grbl import read_dots
from passo.protocols.grbl.take_viper import take_lines
from passo.protocols.gcode.parse_records import (
    LINES_AT, LINES_TAKEN, LINES_WAITS, PARSE_ARC, PARSE_ARCS, PARSE_FIELDS, PARSE_FULL, PARSE_HIGH, PARSE_INCHES, PARSE_LEAST, PARSE_LOW,
    PARSE_NAMED, PARSE_RELATIVE,
)  # fmt: skip
from passo.records import (
    BATCH_FEED, BATCH_FIELDS, BATCH_FIRST, BATCH_FLAGS, BATCH_KIND, BATCH_POWER, BATCH_ROWS, BATCH_STEPS, BATCH_TAG,
    DOTS_AT, DOTS_COUNT, DOTS_FIRST, DOTS_HEAD, DOTS_MASK, DOTS_MOST, DOTS_POWER, DOTS_TAIL, POWER_MARKS, TRACE_FIELDS, TRACE_ROOM, TRACE_TAKEN,
)  # fmt: skip
from plain import plain

CASES = {
    "check_same_as_in_full": (("seed", "seed"),), "check_several_at_once": (("seed", "seed"),),
    "check_machine_code": (("seed", "seed"),), "check_arcs": (("seed", "seed"),),
}  # fmt: skip
RUNS = {"check_same_as_in_full": 150, "check_several_at_once": 40, "check_machine_code": 60, "check_arcs": 100}
BEFORE = (
    b"G91", b"G90", b"G20", b"G21", b"M3 S500", b"M4 S900", b"M5", b"M3", b"M4", b"S300", b"S0", b"M4 S.0004", b"G92 X3 Y1.5", b"G10 L2 P1 X5 Z-2", b"G54", b"G55",
    b"F200", b"F64000", b"F45000.5", b"G43.1 Z1.25", b"G2 X2 Y0 I1 J0 F100", b"G93", b"G94", b"G80", b"G1", b"G53 G0 X1", b"G10 L2 P2 X-536.9",
    b"G10 L2 P2 X1500.25", b"G10 L2 P1 Y-2147.483647", b"G92 X2147.4 Y-1", b"T2",
)  # fmt: skip


FAR = ("2146.%03d", "-2147.%03d", "2147.483%03d", "-84.5%03d", "1073.74%03d", "-536.%03d", "600.%03d", "-1999.%03d4", "1400.1%03d")


def number(random):
    if random.between(0, 5) == 0:
        return random.choice(FAR) % random.between(0, 999)
    text = str(random.choice((random.between(0, 9), random.between(0, 999), random.between(0, 99_999_999))))
    if random.between(0, 2):
        text += "." + "0" * random.between(0, 2) + str(random.between(0, 99999))[: random.between(0, 7)]
    return random.choice(("-", "", "", "")) + text


def power(random):
    if random.between(0, 7) == 0:
        return number(random)
    return random.choice(("0", "1", "500", "999.5", "%d" % random.between(0, 1200), "%d.%03d" % (random.between(0, 9), random.between(0, 999))))


def draw_line(random):
    words = random.choice(("", "G0", "G1", "g01", "G00", "N7 G1", "G 1", "N12"))
    for letter in "XYZA":
        if random.between(0, 2) if letter != "A" else not random.between(0, 5):
            words += random.choice((" ", "")) + letter + number(random)
    if random.between(0, 3) == 0:
        words += "F" + random.choice((number(random).strip("-"), "%d.%03d" % (random.between(0, 64_000), random.between(0, 999))))
    if random.between(0, 2) == 0:
        words += random.choice((" S", "S")) + ":".join([power(random) for _ in range(random.choice((1, 1, 1, 2, 3, 9)))])
    if random.between(0, 7) == 0:
        words += random.choice((" S=", "S=", "s=")) + packed([random.between(0, random.choice((1, 1000, 1000, 1023))) for _ in range(random.between(0, 12))])
    if random.between(0, 9) == 0:
        words += "I" + number(random) + random.choice(("", "J" + number(random), "I1", "K0"))
    line = bytearray(words.encode())
    if random.between(0, 3) == 0 and line:
        at = random.between(0, len(line))
        line = line[:at] + bytes((random.choice(ALPHABET),)) + line[at:]
    return bytes(line)


def packed(powers):
    return "".join([chr(64 + (power >> 5)) + chr(64 + (power & 31)) for power in powers])


def draw_arc(random):
    """A quarter, half or three quarters of a turn in relative places, or a whole one; now and then about something else."""
    i, j = random.between(-9000, 9000), random.between(-9000, 9000)
    x, y = random.choice(((2 * i, 2 * j), (i + j, j - i), (i - j, i + j), (0, 0)))
    if random.between(0, 9) == 0:
        x += random.between(-9, 9)
    words = random.choice(("G2", "G3", "G02", "N5G3", "")) + "X%.3fY%.3f" % (x / 1000, y / 1000)
    words += random.choice(("", "", "Z-1.5", "F300", "S200", "F0", "P2", "H90", "R1", "M8", "G17", "K0", "K-2.5", "K0", "K1K2", "R1K0"))
    words += random.choice(("I%.3fJ%.3f", "I%.3f J%.3f", "J%.3fI%.3f")) % (i / 1000, j / 1000)
    return words.encode()


class Straight(Machine):
    """A machine that takes batches: controller, program and planner in one."""

    def __init__(self, axes="xyz"):
        Machine.__init__(self, axes)
        self.blocks = 96
        self.travel = None
        self.tool = False  # the queue's, and the planner's
        self.power = 0
        self.dynamic = False
        self.batch = Batch(0, array("i", [0] * (BATCH_FIELDS * BATCH_ROWS)), BATCH_ROWS, False, dots_ring(64))
        self.travel_fields = array("i", [0] * TRACE_FIELDS)
        self.batch.join(None, None, None, self.arc)
        self.refuses = False  # arcs
        self.took = []  # as facts()

    def open(self):
        batch = self.batch
        self.travel_fields[TRACE_ROOM] = self.blocks - 1
        batch.target = array("i", self.target)
        batch.reach = self.travel
        batch.tool, batch.power, batch.dynamic = self.tool, self.power, self.dynamic
        batch.room = self.blocks - 1

    def accept(self, rows, count, *others):
        """Take rows as queue_lines() would queue them."""
        for row in range(count):
            fields = rows[row * BATCH_FIELDS : (row + 1) * BATCH_FIELDS]
            before = self.took[-1][0] if self.took else self.target
            target = [before[axis] + fields[BATCH_STEPS + axis] for axis in range(len(self.axes))]
            flags, nm_s = fields[BATCH_FLAGS], fields[BATCH_FEED]
            assert fields[BATCH_KIND] == fields[BATCH_FIRST] == 0 and bool(flags & 2) == (not nm_s)
            self.tool, self.power, self.dynamic = bool(flags & 1), fields[BATCH_POWER] & DOTS_POWER, bool(flags & 4)
            self.took.append((target, nm_s, 0, fields[BATCH_TAG]) + self.light() + (self.burnt(fields[BATCH_POWER]),))
            self.blocks -= 1
        self.travel_fields[TRACE_ROOM] = self.blocks - 1
        self.travel_fields[TRACE_TAKEN] = count

    def burnt(self, power):
        """The dots of a row, which are given back at once."""
        ring = self.batch.dots
        first, count = power >> DOTS_FIRST, power >> DOTS_COUNT & DOTS_MOST
        places = [first + dot & ring[DOTS_MASK] for dot in range(count)]
        found = [ring[ring[DOTS_AT] + at // 3] >> at % 3 * DOTS_COUNT & DOTS_POWER for at in places]
        if count:
            assert found[-1] == self.power
            ring[DOTS_TAIL] = first + count & ring[DOTS_MASK]
        return found

    def arc(self, batch, command, power):
        if self.refuses:
            return False
        self.tool, self.power, self.dynamic = command.tool, power, command.dynamic
        self.took.append((list(command.target), command.feed, arc_of(command), command.number) + self.light() + ([],))
        self.blocks -= 1
        return True

    def follow(self, gcode, lines, most):
        """Have `gcode` fill batches of `lines`, `most` lines at most, and take them: how many it were."""
        batch = self.batch
        self.open()
        lines.fields[LINES_WAITS] = 0
        if not gcode.open_rows(batch):
            return 0
        travel = self.travel_fields
        count = take_lines(b"", 0, lines.text, lines.fields, gcode.fields, batch.rows, batch.dots, read_dots, most, travel, self.accept, travel, travel, travel, travel, travel)
        if count == ARC:
            count = lines.fields[LINES_TAKEN]
            if gcode.take_arc(batch):
                lines.fields[LINES_AT] = gcode.fields[PARSE_ARC]
                count += 1
        if count:
            self.target = list(self.took[-1][0])
        return count

    def obey(self, made, laser):
        """Take the commands that the full parser makes of a line."""
        for command in made:
            if command.kind == commands.SPINDLE:
                self.tool, self.dynamic = command.tool, False
                self.power = 0 if laser and not command.tool else thousandths(command.power)
            elif command.target:
                self.target = command.target[:]
                self.tool, self.power, self.dynamic = facts(command)[-4:-1]

    def light(self):
        return self.tool, self.power, self.dynamic

    def take_of(self, gcode, lines, most):
        """Call follow(); return the facts of the motion that `lines` make."""
        self.took = []
        self.blocks = 96
        count = self.follow(gcode, lines, most)
        assert count == len(self.took)
        return self.took


def waits(lines):
    """The oldest line is not for interpret(), but waits for room."""
    return lines.fields[LINES_WAITS]


def arc_of(command):
    return command.per_min, command.first, command.second, command.clockwise, tuple(command.centre), command.turns, bool(command.over_half)


def facts(command):
    return (
        list(command.target), command.feed, arc_of(command) if command.kind == commands.ARC else command.per_min, command.number,
        command.tool, thousandths(command.power), command.dynamic, list(command.dots),
    )  # fmt: skip


def dots_ring(count):
    """As Power.marks is, with room for `count` − 1 dots."""
    ring = array("i", [0] * (POWER_MARKS + count))
    ring[DOTS_AT] = POWER_MARKS
    ring[DOTS_MASK] = count - 1
    return ring


def shops(count, laser, max_rpm=1_000_000, slow=False, axes="xyz", rotary=False):
    made = [Shop(Straight(axes)) for _ in range(count)]
    for shop in made:
        if rotary:
            shop.gcode.turns = True
        shop.gcode.laser = laser
        shop.gcode.max_rpm = max_rpm
        shop.machine.batch.slow_tool = slow
    return made


def check_same_as_in_full(seed):
    """Two machines, one of which never uses the fast parser; lines refused or waiting in between count, too."""
    random = Random(seed)
    most = random.choice((1_000_000, 1_000_000, 255_000, 24_000_000, 100_000_000, 2, 1, 333_333_333))
    axes = random.choice(("xyz", "xyza"))
    short, full = shops(2, bool(seed & 1), most, random.between(0, 9) == 0, axes, axes == "xyza" and bool(seed & 2))
    dealt = 0
    for _ in range(60):
        if random.between(0, 9) == 0:
            line = random.choice(BEFORE)
        else:
            line = draw_line(random)
        travel = random.choice((None, None, ([-90_000] * 4, [0, 70_000, 250_000, 900_000])))
        for shop in (short, full):
            shop.machine.travel = travel
        lines = Lines()
        lines.take_bytes(line + b"\n")
        before = short.machine.target[:]
        taken = short.machine.take_of(short.gcode, lines, random.between(1, 4))
        error = full.gcode.interpret_line(line)
        following = made_of(full.gcode)
        made = [facts(command) for command in following if command.kind in (commands.LINE, commands.ARC)]
        whole = not taken
        if taken:
            dealt += 1
            assert error == 0 and not lines.has_lines() and waits(lines) == (type(taken[0][2]) is int), (line, error)
            for axis in range(len(axes)):
                at = taken[0][0][axis]
                assert not travel or at == before[axis] or travel[0][axis] <= at <= travel[1][axis], line
        else:
            assert short.machine.target == before and short.gcode.interpret_line(line) == error, line
            taken = [facts(command) for command in made_of(short.gcode) if command.kind in (commands.LINE, commands.ARC)]
        assert taken == made, line
        for shop in (short, full):
            if error:
                shop.gcode._take_position()  # as the next line will do
        if random.between(0, 3) == 0:
            short.gcode.leave_batch()
            assert short.state() == full.state(), line
        moved = [command for command in following if command.target]
        refused = moved and short.machine.target == before and random.between(0, 5) == 0
        for shop in (short, full):
            if refused:
                shop.gcode.forget_position()
            elif whole or shop is full:
                shop.machine.obey(following, full.gcode.laser)
        assert short.machine.light() == full.machine.light(), line
        if random.between(0, 15) == 0:
            for shop in (short, full):
                shop.machine.target = [at + 7 for at in full.machine.target]
    short.gcode.leave_batch()
    assert dealt or short.state() == full.state()


def check_arcs(seed):
    """Arcs, several of them and lines in a batch, with spindle or laser; a machine that refuses one gets it as a command."""
    random = Random(seed)
    short, full = shops(2, bool(seed & 1), 1_000_000)
    before = random.choice((b"M5", b"M3 S500", b"M4 S900")), b"G91 G1 X1 Y.25 F600"
    for shop in (short, full):
        for line in before:
            shop.do(line)
            shop.machine.obey(shop.made, shop.gcode.laser)
    dealt = 0
    for _ in range(20):
        texts = [random.choice((draw_arc, draw_arc, lambda _: b"G1X.1", lambda _: b"X1Y2"))(random) for _ in range(random.between(1, 3))]
        made = []
        for line in texts:
            if full.gcode.interpret_line(line) == 0:
                made += [facts(command) for command in full.gcode.commands if command.target]
                full.machine.obey(full.gcode.commands, full.gcode.laser)
        lines = Lines()
        lines.take_bytes(b"\n".join(texts) + b"\n")
        short.machine.refuses = random.between(0, 4) == 0
        taken = []
        while lines.has_lines():
            some = short.machine.take_of(short.gcode, lines, random.between(1, 4))
            dealt += len(some)
            taken += some
            if not some:
                error = short.gcode.interpret_line(lines.next_line())
                taken += [facts(command) for command in short.gcode.commands if command.target]
                if error == 0:
                    short.machine.obey(short.gcode.commands, short.gcode.laser)
        assert taken == made, texts
        assert short.machine.light() == full.machine.light()
    short.gcode.leave_batch()
    assert dealt and short.state() == full.state()


def check_several_at_once(seed):
    """As many as there is room for, and as are wanted; the others wait, and give the same when their turn comes."""
    random = Random(seed)
    one, all = shops(2, False)
    texts = [b"G1 F900", b"G91"][: random.between(1, 2)]
    one.do(*texts)
    all.do(*texts)
    whole = [b"X%d.%dY-%d" % (random.between(-9, 9), random.between(0, 99), random.between(0, 9)) for _ in range(12)]
    lines = Lines()
    lines.take_bytes(b"\n".join(whole) + b"\n")
    made = []
    for line in whole:
        single = Lines()
        single.take_bytes(line + b"\n")
        made += one.machine.take_of(one.gcode, single, 4)
    took = []
    while lines.has_lines():
        most = random.between(1, 6)
        before = len(took)
        took += all.machine.take_of(all.gcode, lines, most)
        assert len(took) - before == min(most, len(whole) - before) and waits(lines)
    assert took == made
    lines.take_bytes(b"X1\n")
    all.machine.took = []
    all.machine.blocks = 1  # a block is kept for the tool
    assert all.machine.follow(all.gcode, lines, 4) == 0 and waits(lines) and lines.has_lines()


def check_machine_code(seed):
    """The same arrays from the same bytes, as machine code and as bytecode."""
    from passo.options.spindle_pwm import language_grbl
    from passo.protocols.gcode import parse_viper as module

    ways = ((plain(module)["parse_lines"], plain(language_grbl)["read_dots"]), (module.parse_lines, read_dots))
    random = Random(seed)
    place = array("i", [4, 0, 1, 10_000, 0, 0, 0, 0, 0, -5_000_000, 9, 7, 250_000, 83_333, 400_000, 53_333] + [0] * (PARSE_FIELDS - 16))
    place[PARSE_NAMED] = random.between(3, 4)
    batch = array("i", [0] * (BATCH_FIELDS * BATCH_ROWS))
    sides = ((place, batch, dots_ring(64)), (place[:], batch[:], dots_ring(64)))
    for _ in range(50):
        text = b"G1\n" + b"\n".join([random.choice((draw_line, draw_arc))(random) for _ in range(random.between(1, 3))])
        text += random.choice((b"", b"\n", b"\nX1"))
        relative, inches = random.between(0, 1), random.between(0, 1)
        full = random.choice((0, 1, 255_000, 1_000_000, 100_000_000))
        most = random.between(1, 4)
        room = random.between(1, 63)
        for numbers, _, dots in sides:
            dots[DOTS_TAIL] = dots[DOTS_HEAD] + room & 63
            numbers[PARSE_LOW : PARSE_LOW + 4] = array("i", [0, 0x1FFF0000, 0, 0])
            numbers[PARSE_HIGH : PARSE_HIGH + 4] = array("i", [0x3FFFFFFF, 0x20001000, 0x3FFFFFFF, 0x3FFFFFFF])
            numbers[PARSE_LEAST] = 700
            numbers[PARSE_RELATIVE] = relative
            numbers[PARSE_INCHES] = inches
            numbers[PARSE_FULL] = full
            numbers[PARSE_ARCS] = relative
        done = [parse(text, 3, len(text), *side, read, most) for (parse, read), side in zip(ways, sides)]
        assert done[0] == done[1] and sides[0] == sides[1], text


def check_the_frequent_line_is_dealt_with():
    shop = Shop(Straight())
    for line in (b"G1 X1.5 F600", b"X2Y3.25", b"N100 G0 Z-5", b"G01X-1.000Y.5Z-0.2", b"g1 x 10 f 1200.5", b"X600.5Y-999.9"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        assert shop.machine.follow(shop.gcode, lines, 9) == 1 and not lines.has_lines(), line
    for line in (b"G2 X1 I1", b"", b"X1 (note)", b"X1 ; note", b"M3", b"X1 S-3", b"X1 X2", b"X", b"G1", b"X2200", b"X1 F.001"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        assert shop.machine.follow(shop.gcode, lines, 9) == 0 and lines.has_lines() and not waits(lines), line


def check_a_plain_arc_is_dealt_with():
    shop = Shop(Straight())
    shop.do(b"G91 G1 X1 F600")
    for line in (b"G2 X2 I1", b"X1Y1J1", b"N3 G3 X0 Y0 I5 J-2 Z-1 F300", b"g03x-1y1i-1", b"G2 K-3 X2 I1", b"G20", b"G2 X.2 I.1"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        if line == b"G20":
            shop.do(line)
        else:
            assert shop.machine.follow(shop.gcode, lines, 9) == 1 and not lines.has_lines(), line
    for line in (b"G2 X1 I1", b"G2 I1", b"G2 X1 R1", b"G3 X2 I1 P2", b"G2 Z1 I1", b"X1", b"G1 X1 I1", b"G2 X2 I1 I1", b"G2 X2 I1 K1 K1", b"G1 X1 K1", b"G2 X2 K1", b"G2 I1 H90"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        assert shop.machine.follow(shop.gcode, lines, 9) == 0 and lines.has_lines() and not waits(lines), line
    shop.do(b"G18")
    lines = Lines()
    lines.take_bytes(b"G2 X2 I1\n")
    assert shop.machine.follow(shop.gcode, lines, 9) == 0 and lines.has_lines(), "another plane"


def check_fast_lines_are_dealt_with():
    """A feed of any size up to 2³⁰ nm/s, also the lines behind it that say none."""
    for unit, texts in ((b"G21", (b"32212", b"40000.001", b"63999.999", b"64000")), (b"G20", (b"160.00001", b"1999.9", b"2500"))):
        for text in texts:
            shop = Shop(Straight())
            shop.do(unit)
            for line in (b"G1X1F" + text, b"X2"):
                lines = Lines()
                lines.take_bytes(line + b"\n")
                assert shop.machine.follow(shop.gcode, lines, 9) == 1 and not lines.has_lines(), (unit, line, text)


def check_a_laser_raster_is_dealt_with():
    """Power from line to line, dark rapids in between, whether the power follows the speed or not."""
    for mode in (b"M3", b"M4"):
        (shop,) = shops(1, True)
        shop.machine.obey(shop.do(mode + b" S0 F600"), True)
        facts = []
        for line in (b"G0X1Y1", b"G1X1.1S450", b"X1.2S0", b"X1.3S1000", b"X1.4", b"G0Y1.1", b"G1X1.3S.2", b"X1.2S1500", b"G0X0S300", b"G1X1"):
            lines = Lines()
            lines.take_bytes(line + b"\n")
            facts += shop.machine.take_of(shop.gcode, lines, 9)
        dark = (False, 0)
        lights = [dark, (True, 450), dark, (True, 1000), (True, 1000), dark, (True, 1), (True, 1000), dark, (True, 300)]
        assert [fact[4:-1] for fact in facts] == [light + (mode == b"M4",) for light in lights]
        lines.take_bytes(b"X1S5\n")  # no step to change it with
        assert shop.machine.follow(shop.gcode, lines, 9) == 0 and not waits(lines)


def check_a_spindle_changes_its_speed_at_a_stand():
    shop = Shop(Straight())
    shop.machine.obey(shop.do(b"M3 S500 F600"), False)
    for line, short in ((b"G1 X1 S500", 1), (b"X2 S501", 0), (b"X3", 1)):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        assert shop.machine.follow(shop.gcode, lines, 9) == short, line


def check_rows_are_dealt_with():
    """As LightBurn writes them; a row that finds no room for its dots waits."""
    shop = Shop(Straight())
    shop.gcode.laser = True
    shop.do(b"G91 M4 F6000")
    ring = shop.machine.batch.dots
    for line in (b"G1X1.6S0:10:20:30:500.5:1000:0:7:8:9:10:11:12:13:14:15", b"G1 Y-0.8S875:0:0:0:875:0:0:1", b"X-3 S 1 : 2 F900", b"N9X1F600S9:0"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        taken = shop.machine.take_of(shop.gcode, lines, 9)
        assert len(taken) == 1 and not lines.has_lines(), line
        values = [float(value) for value in line.partition(b"S")[2].replace(b" ", b"").partition(b"F")[0].split(b":")]
        assert taken[0][-1] == [int(value + 0.5) for value in values], line
    for line in (b"G1X-1.6S=@@_H@A", b"N9 Y-.8F600S=" + packed(range(900, 960)).encode(), b"X-30 s=OT"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        taken = shop.machine.take_of(shop.gcode, lines, 9)
        assert len(taken) == 1 and not lines.has_lines(), line
        found = line.partition(b"=")[2]
        assert taken[0][-1] == [(found[at] - 64) * 32 + found[at + 1] - 64 for at in range(0, len(found), 2)], line
        ring[DOTS_TAIL] = ring[DOTS_HEAD]
    for line in (b"X1S=", b"X1S=@", b"X1S=@@@", b"X1S=_I", b"X1S=@a", b"X1S=@@ X2", b"X1S=@@X2", b"X1S5=@@", b"X1S5S=@@", b"X=@@", b"G0X1S=@@", b"S=@@", b"X1S=@@S=@@", b"X1S=@@:5"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        found = shop.machine.follow(shop.gcode, lines, 9) or shop.gcode.interpret_line(line)
        assert found in (1, 2, 25, 36) and not waits(lines), (line, found)
    for line in (b"X1S1:", b"X1S:1", b"X1S1::2", b"X1S1:-2", b"X1S1 X2:3", b"G0X1S1:2", b"X1:2", b"X1S1:2:", b"X1S1:2Z", b"X1S1:2S3", b"S1:2", b"G2X2I1S1:2", b"X1S1:2M3"):
        lines = Lines()
        lines.take_bytes(line + b"\n")
        assert shop.machine.follow(shop.gcode, lines, 9) == 0 and not waits(lines), line
        assert line == b"X1S1:2M3" or shop.gcode.interpret_line(line) in (1, 2, 4, 25, 36), (line, shop.gcode.interpret_line(line))
    lines = Lines()
    lines.take_bytes(b"X1S1:2:3\nX2S4:5\n")
    ring[DOTS_TAIL] = ring[DOTS_HEAD] + 4 & ring[DOTS_MASK]
    assert len(shop.machine.take_of(shop.gcode, lines, 1)) == 1
    ring[DOTS_TAIL] = ring[DOTS_HEAD] + 1 & ring[DOTS_MASK]
    assert shop.machine.follow(shop.gcode, lines, 9) == 0 and waits(lines)
    ring[DOTS_TAIL] = ring[DOTS_HEAD]
    assert shop.machine.take_of(shop.gcode, lines, 9)[0][-1] == [4, 5]
    for line in (b"$100=1", b"$J=X1F600", b"X1M8", b"G1 X2 F300", b"G0Y1"):  # lines without a row do not wait for room for dots
        ring[DOTS_TAIL] = ring[DOTS_HEAD] + 1 & ring[DOTS_MASK]
        lines = Lines()
        lines.take_bytes(line + b"\n")
        shop.machine.follow(shop.gcode, lines, 9)
        assert not waits(lines) or not lines.has_lines(), line
