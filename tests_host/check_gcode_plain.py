"""Plain lines, dealt with in short, give what the whole of G-code gives: the same command and modal state, to the nm."""

from check_gcode import ALPHABET, Shop
from draws import Random
from passo.protocols import commands

CASES = {"check_same_as_in_full": (("seed", "seed"),), "check_machine_code": (("seed", "seed"),)}
RUNS = {"check_same_as_in_full": 150, "check_machine_code": 60}
BEFORE = (
    b"G91", b"G90", b"G20", b"G21", b"M3 S500", b"M4 S900", b"M5", b"G92 X3 Y1.5", b"G10 L2 P1 X5 Z-2", b"G54", b"G55",
    b"F200", b"G43.1 Z1.25", b"G2 X2 Y0 I1 J0 F100", b"G93", b"G94", b"G80", b"G1", b"G53 G0 X1", b"G10 L2 P2 X-536.9",
    b"T2",
)  # fmt: skip


def number(random):
    text = str(random.choice((random.between(0, 9), random.between(0, 999), random.between(0, 99_999_999))))
    if random.between(0, 2):
        text += "." + "0" * random.between(0, 2) + str(random.between(0, 99999))[: random.between(0, 7)]
    return random.choice(("-", "", "", "")) + text


def draw_line(random):
    words = random.choice(("", "G0", "G1", "g01", "G00", "N7 G1", "G 1", "N12"))
    for letter in "XYZ":
        if random.between(0, 2):
            words += random.choice((" ", "")) + letter + number(random)
    if random.between(0, 3) == 0:
        words += "F" + number(random).strip("-")
    line = bytearray(words.encode())
    if random.between(0, 3) == 0 and line:
        at = random.between(0, len(line))
        line = line[:at] + bytes((random.choice(ALPHABET),)) + line[at:]
    return bytes(line)


def facts(command):
    return (
        command.kind, list(command.target), command.feed, command.per_min, command.number, command.tool, command.power,
        command.dynamic,
    )  # fmt: skip


def check_same_as_in_full(seed):
    """Two machines, one of which never deals with a line in short; what is refused or waits in between counts too."""
    random = Random(seed)
    short, full = Shop(), Shop()
    dealt = 0
    for shop in (short, full):
        shop.gcode.laser = bool(seed & 1)
        shop.gcode.max_rpm = 1_000_000
    for _ in range(60):
        if random.between(0, 9) == 0:
            line = random.choice(BEFORE)
        else:
            line = draw_line(random)
        error = full.gcode.interpret(line)
        command = short.gcode.plain(line, 0)
        if command is None:
            assert short.gcode.interpret(line) == error, line
            made = short.gcode.commands
        else:
            dealt += 1
            assert error == 0, (line, error)
            made = [command]
        assert [facts(command) for command in made if command.kind == commands.LINE] == [
            facts(command) for command in full.gcode.commands if command.kind == commands.LINE
        ], line
        for shop in (short, full):
            if error:
                shop.gcode._settle()  # as the next line will do
        if random.between(0, 3) == 0:
            short.gcode.leave_plain()
            assert short.state() == full.state(), line
        refused = random.between(0, 15) == 0
        moved = [command for command in full.gcode.commands if command.target]
        for shop in (short, full):
            if moved and not refused:
                shop.machine.target = moved[-1].target[:]
            elif refused:
                shop.gcode.forget_place()
        if random.between(0, 15) == 0:
            for shop in (short, full):
                shop.machine.target = [random.between(0, 0) + at + 7 for at in full.machine.target]
    short.gcode.leave_plain()
    assert dealt or short.state() == full.state()


def check_machine_code(seed):
    """The same array from the same bytes, as machine code and as bytecode."""
    from array import array

    from check_measure import plain_text
    from passo.protocols import gcode_plain_viper as module

    plain = plain_text("protocols/gcode_plain_viper.py")["plain"]
    random = Random(seed)
    place = array("i", [3, 0, 1, 10_000, 0, 0, 0, 0, -5_000_000, 9, 250_000, 83_333, 400_000] + [0] * 9)
    other = place[:]
    for _ in range(50):
        line = draw_line(random)
        place[1] = other[1] = random.between(0, 1)
        place[19] = other[19] = random.between(0, 1)
        text = b"G1\n" + line + random.choice((b"", b"\n", b"\nX1"))
        assert plain(text, 3, len(text), place) == module.plain(text, 3, len(text), other), line
        assert place == other, line


def check_the_frequent_line_is_dealt_with():
    shop = Shop()
    for line in (b"G1 X1.5 F600", b"X2Y3.25", b"N100 G0 Z-5", b"G01X-1.000Y.5Z-0.2", b"g1 x 10 f 1200.5"):
        assert shop.gcode.plain(line, 0) is not None, line
        shop.machine.target = shop.gcode._steps[:]
    for line in (b"G2 X1 I1", b"", b"X1 (note)", b"X1 ; note", b"M3", b"X1 S3", b"X1 X2", b"X", b"G1", b"X600"):
        assert shop.gcode.plain(line, 0) is None, line
