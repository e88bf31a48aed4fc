"""A laser on the whole firmware: lines that go in batches give the words and the power that they give as commands."""

from digest import Sink, board_named, checked
from draws import Random
from passo.app import App
from router import LASER, Machine

CASES = {"check_batches_are_commands": (("seed", "seed"),)}
RUNS = {"check_batches_are_commands": 12}
LONG = (
    b"M3", b"M4", b"M5", b"M3 S200", b"M4 S700", b"S0", b"S300", b"G4 P.01", b"G91", b"G90", b"G0", b"G1", b"G28 X1 S50",
    b"G2 X4 Y4 R30 S40 F900", b"G53 G0 X1 S9", b"$31=100", b"$30=255", b"$30=1000", b"\x9a", b"\x9b\x9b",
)  # fmt: skip
SILENT_TURNS = 40


def draw_programme(random):
    lines = [b"$X", b"G21 G90 F%d" % random.between(60, 9000), random.choice((b"M3", b"M4"))]
    if random.between(0, 7) == 0:
        lines.append(b"$32=0")
    for _ in range(50):
        if random.between(0, 15) == 0:
            lines.append(random.choice(LONG))
            continue
        line = random.choice((b"", b"", b"G1", b"G0"))
        for letter in b"XY":
            if random.between(0, 2):
                line += b"%c%d.%d" % (letter, random.between(0, 9), random.between(0, 99))
        if random.between(0, 1):
            line += b"S%d" % random.choice((0, 0, 1000, random.between(0, 1300)))
        if random.between(0, 9) == 0:
            line += b"F%d" % random.between(60, 9000)
        lines.append(line)
    return lines


def play(lines, batches):
    """Return the result of `lines`, one after the other, and how many of them went in batches."""
    port = Sink()
    app = App(checked(board_named("laser_xy")), port)
    link = app.links[0]
    take = link.take_batch
    taken = []

    def counted(data, now_ms):
        answers = take(data, now_ms)
        taken.append(answers.count(b"ok") if isinstance(answers, bytes) else 0)  # else commands
        return answers

    link.take_batch = counted
    if not batches:
        app.links[0].batch = None
    said = b""
    for line in lines:
        port.incoming += line + b"\n"
        port.outgoing = b""
        while not (b"ok" in port.outgoing or b"error" in port.outgoing):
            app.cycle()
        said += port.outgoing
    silent = 0
    while silent < SILENT_TURNS:
        app.cycle()
        silent = 0 if app.controller.busy() else silent + 1
    port.outgoing = b""
    port.incoming = b"$G\n?"
    for _ in range(3):
        app.cycle()
    return (port.hexdigest(), port.words, port.marks, said + port.outgoing), sum(taken)


def check_batches_are_commands(seed):
    lines = draw_programme(Random(seed))
    made, taken = play(lines, True)
    whole, none = play(lines, False)
    assert made == whole and none == 0, lines
    assert taken > 20 or b"$32=0" in lines, (taken, lines)


def check_a_beam_changes_without_a_step():
    """M3 burns at a stand: the S of a line to the machine's own position counts at once, as in grbl."""
    machine = Machine(spindle=LASER).ready()
    machine.do("M3 S500", "G1 X2 F3000")
    machine.settle()
    for line, power in (("X2 S800", 800), ("X2 S0", 0), ("X2 S10", 10), ("G0 X2", 0), ("G1 X2", 10)):
        machine.do(line)
        machine.settle()
        assert (machine.world.tool, machine.world.power_level) == (1 if power else 0, power), line


def check_a_beam_changes_on_an_arc_without_a_step():
    """The S of an arc shorter than a step counts at once, too."""
    machine = Machine(spindle=LASER).ready()
    machine.do("M3 S500", "G1 X2 F3000")
    machine.settle()
    steps = machine.world.steps
    for line, power in (("G3 X2 Y0.0001 I-5 S800", 800), ("G2 X2 Y0 I-5 S0", 0), ("G3 Y.0001 R5 S10", 10)):
        machine.do(line)
        machine.settle()
        assert (machine.world.tool, machine.world.power_level) == (1 if power else 0, power), line
        assert machine.world.steps == steps


def check_a_rapid_with_a_power_does_not_stand():
    """`G0 X… S…` between lines that burn takes no longer than `G0 X…`, and is as dark."""
    made = []
    for rapid in ("G0 X4", "G0 X4 S0"):
        machine = Machine(spindle=LASER).ready()
        machine.world.burnt = []
        machine.do("M4 S500", "G1 X2 F3000", rapid, "G1 X6 S500")
        machine.settle()
        begun = machine.world.burnt[0][0]
        made.append([(tick - begun, x - 3000, power) for tick, x, _, power in machine.world.burnt])
        for _, x, power in made[-1]:
            assert not power or x <= 641 or x > 1280, x
    assert made[0] == made[1]
