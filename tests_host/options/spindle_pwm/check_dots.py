"""Rows of dots on the whole firmware: the power burnt at each step; held, reset, and rows with too many dots."""

from draws import Random
from passo import errors
from passo.records import DOTS_HEAD, DOTS_TAIL
from passo.options.spindle_pwm.steps_viper import end_of
from router import LASER, Machine

CASES = {
    "check_rows_are_lines": (("seed", "seed"),), "check_held_amid_rows": (("seed", "seed"),), "check_begins_at_the_nearest_step": (("seed", "seed"),),
}  # fmt: skip
RUNS = {"check_rows_are_lines": 20, "check_held_amid_rows": 15, "check_begins_at_the_nearest_step": 300}
STEPS_MM = 320


def laser(*lines):
    machine = Machine(spindle=LASER).ready()
    machine.world.burnt = []
    machine.do(*lines)
    return machine


def draw_powers(random):
    return [random.choice((0, 0, 1000, random.between(0, 1000))) for _ in range(random.between(1, 16))]


def draw_rows(random, count):
    """Rows, one after the other both ways: ([powers], mm of each dot)."""
    return [(draw_powers(random), random.choice((0.05, 0.1, 0.25)), random.choice(("", "", "-"))) for _ in range(count)]


def text_of(rows):
    return ["G1%s%s%.2fS%s" % ("X", sign, pitch * len(powers), ":".join([str(power) for power in powers])) for powers, pitch, sign in rows]


def packed(powers):
    return "=" + "".join([chr(64 + (power >> 5)) + chr(64 + (power & 31)) for power in powers])


def packed_of(rows):
    return ["G1X%s%.2fS%s" % (sign, pitch * len(powers), packed(powers)) for powers, pitch, sign in rows]


def lines_of(rows):
    return ["G1X%s%.2fS%d" % (sign, pitch, power) for powers, pitch, sign in rows for power in powers]


def burnt(machine):
    machine.settle()
    assert not machine.world.tool or not machine.world.power_level
    return [at[1:] for at in machine.world.burnt]


def check_rows_are_lines(seed):
    """M3: at each step the power that one line a dot gives, packed too."""
    random = Random(seed)
    rows = draw_rows(random, 6)
    made = []
    for texts in (text_of(rows), lines_of(rows), packed_of(rows)):
        machine = laser("M3", "G91", "G1 F%d" % (1000 + 500 * (seed % 9)))
        machine.do(*texts)
        machine.do("X.1S0", "M5")
        made.append(burnt(machine))
        dots = machine.app.ring.power.marks
        assert dots[DOTS_HEAD] == dots[DOTS_TAIL]
    assert made[0] == made[1] == made[2]


def check_begins_at_the_nearest_step(seed):
    random = Random(seed)
    count = random.between(1, 255)
    total = random.choice((random.between(1, 300), random.between(1, 2_097_151)))
    before = 0
    for dot in range(count):
        at = end_of(dot, count, total)
        assert abs(2 * (at * count - (dot + 1) * total)) <= count and at >= before
        before = at
    assert before == total


def check_power_follows_the_speed():
    """M4: dark at rest, the dot's power at the speed programmed, in between in proportion, and as many steps as ever."""
    machine = laser("M4", "G91", "G1 F1200")
    machine.do("X8S" + ":".join(["1000"] * 20), "M5")
    made = burnt(machine)
    powers = [power for _, _, power in made]
    assert len(made) == 8 * STEPS_MM and max(powers) == 1000 and powers[0] < 100 and powers[-1] < 100
    rise = powers[: powers.index(1000)]
    assert rise == sorted(rise)
    last = len(powers) - powers[::-1].index(1000)
    assert powers[last:] == sorted(powers[last:])[::-1]


def check_a_feed_beyond_the_axes():
    """M4: the power is that part of the one asked for that the speed is of the feed."""
    made = []
    for text in (("X8S" + ":".join(["800"] * 16),), ["X.5S800"] * 16):
        machine = laser("M4", "G91", "G1 F2400")
        machine.do("$110=1200")
        machine.do("X1S800", *text)
        machine.do("M5")
        made.append(max([power for _, x, power in burnt(machine)]))
    assert 300 < made[1] < 500 and abs(made[0] - made[1]) <= 1, made


def check_held_amid_rows(seed):
    """Held and gone on with, three times: the same power at each step, none twice, none left out. At the stand the beam is off."""
    random = Random(seed)
    rows = draw_rows(random, 12)
    mode = random.choice(("M3", "M4"))
    made = []
    for holds in (0, 3):
        machine = laser(mode, "G91", "G1 F600")
        machine.do(*(packed_of if holds and seed & 1 else text_of)(rows))
        machine.put("X.1S0\nM5\n")
        for _ in range(holds):
            machine.cycles(random.between(2, 60))
            if machine.status()["state"] != "Run":
                break  # they have ended
            machine.put("!")
            machine.cycles(400)
            assert machine.status()["state"] == "Hold:0"
            assert not machine.world.tool
            machine.put("~")
        made.append(burnt(machine))
    if mode == "M4":
        made = [[(x, y, power > 0) for x, y, power in each] for each in made]
    assert [at[:2] for at in made[0]] == [at[:2] for at in made[1]]
    wrong = [each for each in zip(*made) if each[0] != each[1]]
    assert not wrong if mode == "M3" else len(wrong) < 40, wrong[:4]


def check_reset_amid_a_row():
    """The reset drops the queue, its dots, too; the beam is off, and the next row burns as ever."""
    machine = laser("M3", "G91", "G1 F600")
    for _ in range(5):
        machine.put("\n".join(["X1.6S" + ":".join(["700"] * 16)] * 20) + "\n")
        machine.cycles(150)
        assert machine.world.tool
        machine.put(b"\x18")
        machine.cycles(100)
        assert not machine.world.tool
        machine.said()
        machine.do("$X", "M3", "G91", "G1 F600")
        dots = machine.app.ring.power.marks
        assert dots[DOTS_HEAD] == dots[DOTS_TAIL]
    machine.world.burnt = []
    machine.do("X1S0:500", "M5")
    assert [power for _, _, power in burnt(machine)] == [0] * 160 + [500] * 160


def check_more_dots_than_there_is_room_for():
    """They wait for room, and all are burnt."""
    machine = laser("M3", "G91", "G1 F6000")
    rows = [[row * 7 % 900 + 1 + dot for dot in range(25)] for row in range(60)]
    machine.do(*["X2.5S" + ":".join([str(power) for power in row]) for row in rows])
    machine.do("M5")
    assert [power for _, _, power in burnt(machine)][16::32] == [power for row in rows for power in row]


def check_more_packed_dots_than_there_is_room_for():
    machine = laser("M3", "G91", "G1 F6000")
    rows = [[row * 37 % 900 + 1 + dot for dot in range(100)] for row in range(20)]
    machine.do(*["N%d X10S%s" % (row, packed(rows[row])) for row in range(20)])
    machine.do("M5")
    assert [power for _, _, power in burnt(machine)][16::32] == [power for row in rows for power in row]


def check_overrides_amid_packed_rows():
    """Of the power at once, of the speed as with plain lines; each dot is burnt in its steps."""
    machine = laser("M3", "G91", "G1 F600")
    machine.put("X16S%s\n" % packed([800] * 100))
    machine.cycles(60)
    machine.put(b"\x9b\x92")
    machine.do("M5")
    made = [power for _, _, power in burnt(machine)]
    assert len(made) == 16 * STEPS_MM and made[0] == 800 and made[-1] == 720 and sorted(made, reverse=True) == made


def check_as_a_command_with_too_many_dots():
    """Lines that only the whole of G-code understands wait for room as well."""
    machine = laser("M3", "G91", "G1 F6000")
    machine.do(*["X2.5S%s (row)" % ":".join(["%d" % (1 + row)] * 25) for row in range(60)])
    machine.do("M5")
    assert [power for _, _, power in burnt(machine)][::800] == list(range(1, 61))


def check_refused():
    """By number, and nothing moves or burns: no numbers, no G1, no laser, no room on this machine."""
    machine = laser("M3", "G91", "G1 F600")
    for line, error in (
        ("X1S1:", errors.NUMBER), ("X1S1::2", errors.NUMBER), ("X1S:1", errors.NUMBER), ("X1S1:-2", errors.NEGATIVE), ("X1:2", errors.LETTER),
        ("G0X1S1:2", errors.WORDS_UNUSED), ("S1:2", errors.WORDS_UNUSED), ("G2X2I1S1:2", errors.WORDS_UNUSED), ("G28X1S1:2", errors.WORDS_UNUSED),
        ("X1S1:2S3", errors.REPEATED_WORD), ("X1S" + "1:" * 62 + "1", errors.LINE_TOO_LONG),
        ("X1S=", errors.NUMBER), ("X1S=@@@", errors.NUMBER), ("X1S=_I", errors.NUMBER), ("X1S=@a", errors.LETTER), ("G0X1S=@@", errors.WORDS_UNUSED),
        ("S=OT", errors.WORDS_UNUSED), ("G2X2I1S=@@", errors.WORDS_UNUSED), ("X1S=" + "@A" * 120, errors.LINE_TOO_LONG), ("$J=X1F600S=@@", errors.WORDS_UNUSED),
        ("X1S5S=@@", errors.NUMBER), ("X1S=@@X2", errors.LETTER),
        ("$J=X1F600S1:2", errors.WORDS_UNUSED),
    ):  # fmt: skip
        assert machine.ask(line) == ["error:%d" % error], line
    assert not machine.world.burnt and not burnt(machine)
    machine.do("M5", "G1X1S5:6")
    machine.settle()
    machine.do("$32=0", "M3S100")
    assert machine.ask("G1X1S1:2") == ["error:%d" % errors.UNSUPPORTED]
    machine.settle()
    assert not [at for at in machine.world.burnt if at[3]] and machine.world.steps == STEPS_MM
    for changes in ({"spindle": dict(LASER, laser=False)}, {"spindle": LASER, "tool": {"pin": 8, "active": 1, "on_ms": 50, "off_ms": 0}}):
        machine = Machine(**changes).ready()
        machine.do("$32=1", "M3", "G91", "G1 F600")
        assert machine.ask("X1S1:2") == ["error:%d" % errors.NO_MEMORY]
        machine.settle()
        assert not machine.world.steps


def check_the_board_says_it():
    said = Machine(spindle=LASER).ready().ask("$I")
    assert "[CLUSTER:16]" in said and "[PACKED:100]" in said
    assert "[CLUSTER:16]" not in Machine().ready().ask("$I")


def check_the_first_power_counts_on():
    """Behind a row S is its first power, as in grblHAL; behind a packed one it is as before."""
    machine = laser("M3", "G91", "G1 F600", "X1S300:0:200", "X.5", "M5")
    made = burnt(machine)
    assert [power for _, _, power in made[320:]] == [300] * 160
    machine = laser("M3", "G91", "G1 F600", "X1S300", "X1S" + packed([0, 700]), "X.5", "M5")
    assert [power for _, _, power in burnt(machine)] == [300] * 320 + [0] * 160 + [700] * 160 + [300] * 160


def check_a_row_of_no_steps():
    """Without a step it is a plain line; a row with more dots than steps loses some."""
    machine = laser("M3", "G91", "G1 F600", "X0S200:300", "X.01S1:2:3:4:5:6", "M5")
    made = [power for _, _, power in burnt(machine)]
    assert len(made) == 3 and made == sorted(made)
