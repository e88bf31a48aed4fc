"""M62 to M65 over the grbl link: outputs p0 and p1 in step with motion, and all outputs after every kind of stop."""

from draws import Random
from passo.steps.word import TICKS_PER_MS
from router import Machine, World

CASES = {"check_each_change_at_its_step": (("seed", "seed"),)}
RUNS = {"check_each_change_at_its_step": 12}
OUTPUTS = [
    {"name": "enable", "pin": 14, "active": 0, "role": "none"},
    {"name": "flood", "pin": 16, "active": 1, "role": "none"},
    {"name": "reverse", "pin": 15, "active": 1, "role": "none"},
    {"name": "p0", "pin": 17, "active": 1, "role": "none"},
    {"name": "p1", "pin": 18, "active": 0, "role": "none"},
]


class Noted(World):
    """(tick, name, on, X) of each change of p0 and p1. begun: the tick of the step that came next, which is to be the same."""

    def __init__(self):
        World.__init__(self)
        self.changes = []
        self.begun = []

    def edges(self, tick, levels, changed):
        while changed & levels & sum(self._step) and len(self.begun) < len(self.changes):
            self.begun.append(tick)
        World.edges(self, tick, levels, changed)

    def output(self, tick, name, level):
        if name in ("p0", "p1"):
            on = level == (1 if name == "p0" else 0)
            if (self.outputs.get(name) == level) is False:
                self.changes.append((tick, name, on, self.place[0]))
        World.output(self, tick, name, level)

    def on(self):
        return self.outputs.get("p0", 0), 1 - self.outputs.get("p1", 1)


def router():
    return Machine(Noted(), outputs=OUTPUTS).ready()


def check_at_once():
    machine = router()
    machine.do("M64 P0")
    assert machine.world.on() == (1, 0)
    for line, answer in (("M64P0.5", "error:23"), ("M65P1.001", "error:23"), ("M62P-1", "error:"), ("M63P99", "error:"), ("M64", "error:")):
        assert machine.ask(line)[-1].startswith(answer), line
    machine.do("M64P1", "M65 P0")
    assert machine.world.on() == (0, 1)
    machine.do("G1 X50 F3000")
    machine.cycles(20)
    steps = machine.world.steps
    machine.do("M65 P1")
    assert machine.world.on() == (0, 0) and machine.controller.queue.still() is False and machine.world.steps < steps + 400


def check_with_the_next_motion():
    """At the first step's own tick; without a stand in between."""
    machine = router()
    machine.do("G91", "G1 X5 F3000", "M62 P0", "X5", "M63P0", "M62P1", "X5", "M63 P1")
    machine.settle()
    assert machine.world.place[0] == 3000 + 15 * 320
    machine.cycles(50)
    assert [(name, on) for _, name, on, _ in machine.world.changes] == [("p0", True), ("p0", False), ("p1", True)]
    assert [place - 3000 for _, _, _, place in machine.world.changes] == [1600, 3200, 3200]
    assert machine.world.begun == [tick for tick, _, _, _ in machine.world.changes]
    assert machine.world.on() == (0, 1), "M63 waits for a motion"
    machine.do("X1")
    machine.settle()
    assert machine.world.on() == (0, 0)


def check_from_a_stand():
    machine = router()
    machine.do("M62 P0")
    machine.cycles(100)
    assert machine.world.on() == (0, 0)
    begun = machine.port.now
    machine.do("G91", "G1 X1 F600")
    machine.cycles(10)
    assert machine.world.on()[0] and machine.world.changes[0][0] - begun <= 50 * TICKS_PER_MS


def check_behind_an_arc_of_chords():
    """Its last chords are not queued yet as M62 is read: it waits for the motion behind all of them. With G93 no batch keeps the line back."""
    machine = router()
    machine.do("G18G91", "G1X1F3000", "G93", "G2X20Z0I10K0F3")
    assert machine.controller.queue.chords, "or it shows nothing"
    machine.do("M62P0", "G1X5F10")
    machine.settle()
    (change,) = machine.world.changes
    assert change[3] - 3000 == 21 * 320, change


def check_a_dwell_is_no_motion():
    """From a stand, and behind a motion. As LinuxCNC: a dwell takes no change with it, the motion behind it does."""
    machine = router()
    begun = machine.port.now
    machine.do("G91", "M62P0", "G4P0.5", "M62P1", "G4P0.3", "G1X5F3000")
    machine.settle()
    machine.do("M63P0", "G4P0.2", "G4P0.2")
    machine.settle()
    machine.cycles(50)
    assert [(name, on) for _, name, on, _ in machine.world.changes] == [("p0", True), ("p1", True)]
    for tick, _, _, place in machine.world.changes:
        assert tick - begun >= 800 * TICKS_PER_MS and place == 3000
    machine.do("G1X1")
    machine.settle()
    assert machine.world.on() == (0, 1)


def motions(random):
    """Lines of random motions: both ways along each axis, arcs of two planes, tiny and long ones, with tools and dwells between."""
    lines = []
    for _ in range(random.between(3, 9)):
        by = random.between(1, 200) / 50
        kind = random.between(0, 5)
        way = "-" if random.between(0, 1) else ""
        if kind < 3:
            lines.append("G17G94G1%s%s%.2fF%d" % ("XYZ"[kind], way, by / 4 if kind == 2 else by, 200 * random.between(1, 15)))
        elif kind == 3:
            lines.append("G17G94G3X%sY.5R%.2fF1200" % (way + "1", 1 + by))
        elif kind == 4:
            lines.append("G18G93G2X%.2fZ0I%.2fK0F20" % (by, by / 2))  # by two hundredths: both are whole
        else:
            lines.append("G94G1X%s.02F900" % way)
    return lines


def check_each_change_at_its_step(seed):
    """The steps made as each comes are those of the motions before it: counted one by one, on a machine without changes."""
    random = Random(seed)
    lines = motions(random)
    counted = router()
    counted.do("G91", "G1X20Y10Z-1F3000")
    counted.settle()
    steps = []
    for line in lines:
        steps.append(counted.world.steps)
        counted.do(line)
        counted.settle()
    machine = router()
    changes = []
    show = machine.world.output
    machine.world.output = lambda tick, name, level: (name[0] == "p" and changes.append(machine.world.steps), show(tick, name, level))
    machine.do("G91", "G1X20Y10Z-1F3000")
    dwells = [random.between(0, 4) for _ in lines]
    if random.between(0, 1):
        machine.settle()
    for number, line in enumerate(lines):
        machine.do("M6%dP%d" % (2 + number % 2, number % 3 % 2))
        if dwells[number] < 2:
            machine.do(("G4P0.02", "M8")[dwells[number]])
        machine.do(line)
    machine.settle()
    assert changes == steps, (lines, changes, steps)


def check_the_last_change_before_a_motion_counts():
    """However many there are, dwells between them too: a link that waits for room would wait for ever."""
    machine = router()
    machine.do("G91", "G1X1F3000")
    for number in range(40):
        machine.do("M6%dP%d" % (2 + number // 2 % 2, number % 2))
        if number % 7 == 0:
            machine.do("G4P0.01")
    machine.do("M62P1", "G1X1", "M62P0", "M63P1", "G1X1")
    machine.settle()
    machine.cycles(20)
    assert [(name, on, place - 3000) for _, name, on, place in machine.world.changes] == [
        ("p0", False, 320), ("p1", True, 320), ("p0", True, 640), ("p1", False, 640),
    ], machine.world.changes


def check_homing_is_no_motion_of_the_programme():
    """An output that waits as it begins is dropped; outputs that are on go off, as before any homing."""
    machine = router()
    machine.do("M62P0", "$H")
    machine.settle()
    machine.do("G91", "G1X1F3000")
    machine.settle()
    assert not any(on for _, _, on, _ in machine.world.changes), machine.world.changes


def check_refusals():
    machine = router()
    for line, error in (("M62", 28), ("M64 P2", 122), ("M64 P10", 122), ("M62 P0 M63", 21), ("M64 P-1", 4)):
        assert machine.ask(line) == ["error:%d" % error], line
    assert machine.world.on() == (0, 0)


# The outputs left on by each kind of stop: (tool, flood, reverse, p0, enable), and after going on, if it can.
STOPS = {
    "hold": (b"!", (1, 1, 1, 1, 1), (1, 1, 1, 1, 1)),
    "door": (b"\x84", (0, 0, 0, 0, 1), (1, 1, 1, 1, 1)),
    "reset": (b"\x18", (0, 0, 0, 0, 1), None),
    "stop": (None, (0, 0, 0, 0, 1), None),
    "soft limit": (b"G90G1X400F3000\n", (0, 0, 0, 0, 1), None),
    "M2": (b"M2\n", (0, 0, 0, 1, 1), None),
}


def state(machine):
    outputs = machine.world.outputs
    return machine.world.tool, outputs["flood"], outputs["reverse"], machine.world.on()[0], 1 - outputs["enable"]


def check_the_safe_state_of_each_output_on_each_stop():
    for name in STOPS:
        data, stopped, after = STOPS[name]
        machine = router()
        if name == "soft limit":
            machine.do("$20=1", "$H", "G10 L20 P1 X0 Y0 Z0")
        machine.do("M4 S1000", "M8", "M64 P0", "G91")
        machine.do("G1 X20 F3000") if name != "M2" else None
        machine.cycles(30)
        assert state(machine) == (1, 1, 1, 1, 1), name
        if data is None:
            machine.world.switches["stop"] = 1
            machine.cycles(5)
            machine.world.switches["stop"] = 0
        else:
            machine.put(data)
        machine.cycles(300)
        assert state(machine) == stopped, (name, state(machine))
        if after:
            machine.put(b"~")
            machine.cycles(5000)
            assert state(machine) == after, name


def check_a_jog_takes_none_that_waits():
    """A jog is no motion of the programme: waiting outputs are dropped, as by homing. It stays so behind the jog."""
    for jogs in (("$J=G91X2F3000",), ("$J=G91X1F3000", "$J=G91X-1F3000")):
        machine = router()
        machine.do("G91", "M62 P0", "M62 P1")
        machine.do(*jogs)
        machine.settle()
        machine.cycles(50)
        machine.do("G1X1F3000")
        machine.settle()
        machine.cycles(50)
        assert machine.world.on() == (0, 0) and not machine.world.changes, jogs
    machine.do("M62P0", "G1X1", "M62P1")
    machine.settle()
    machine.cycles(50)
    assert machine.world.on() == (1, 0), "p0, whose motion has come, must be on"
    machine.do("$J=G91X1F3000")
    machine.settle()
    machine.cycles(50)
    machine.do("G1X1")
    machine.settle()
    machine.cycles(50)
    assert machine.world.on() == (1, 0)


def check_a_refused_line_keeps_none_that_waits():
    """Waiting outputs of the line and of the lines before it are dropped; one that waits for a queued motion comes with it."""
    for refused in ("M62P1G1X1Q5", "M62P1X99999999", "G1X", "X99999999", "G7"):
        machine = router()
        machine.do("G91", "G1X5F600", "M62P0", "X5", "M62P1")
        assert machine.ask(refused)[-1].startswith("error:"), refused
        machine.do("X5")
        machine.settle()
        machine.cycles(50)
        assert machine.world.on() == (1, 0), refused
        assert [place - 3000 for _, _, _, place in machine.world.changes] == [1600]
        machine.do("M62P1", "X5")
        machine.settle()
        machine.cycles(50)
        assert machine.world.on() == (1, 1), refused
