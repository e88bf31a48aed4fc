"""M62 to M65 over the grbl link: outputs p0 and p1 in step with motion, and what every kind of stop makes of all outputs."""

from passo.steps.word import TICKS_PER_MS
from router import Machine, World

OUTPUTS = [
    {"name": "enable", "pin": 14, "active": 0, "role": "none"},
    {"name": "flood", "pin": 16, "active": 1, "role": "none"},
    {"name": "reverse", "pin": 15, "active": 1, "role": "none"},
    {"name": "p0", "pin": 17, "active": 1, "role": "none"},
    {"name": "p1", "pin": 18, "active": 0, "role": "none"},
]
CYCLE_MS = 9  # the virtual port's is 8


class Noted(World):
    """(tick, name, on, X) of each change of p0 and p1."""

    def __init__(self):
        World.__init__(self)
        self.changes = []

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
    """Neither before the motion in front has ended, nor later than two cycles behind; without a stand in between."""
    machine = router()
    machine.do("G91", "G1 X5 F3000", "M62 P0", "X5", "M63P0", "M62P1", "X5", "M63 P1")
    machine.settle()
    assert machine.world.place[0] == 3000 + 15 * 320
    machine.cycles(50)
    assert [(name, on) for _, name, on, _ in machine.world.changes] == [("p0", True), ("p0", False), ("p1", True)]
    most = 50 * 320 * 2 * CYCLE_MS // 1000
    for index, (_, _, _, place) in zip((1, 2, 2), machine.world.changes):
        assert 0 <= place - 3000 - index * 1600 <= most, place
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
    assert 0 <= change[3] - 3000 - 21 * 320 <= 50 * 320 * 2 * CYCLE_MS // 1000, change


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
        assert tick - begun >= 800 * TICKS_PER_MS and 0 <= place - 3000 <= 50 * 320 * 2 * CYCLE_MS // 1000
    machine.do("G1X1")
    machine.settle()
    assert machine.world.on() == (0, 1)


def check_refusals():
    machine = router()
    for line, error in (("M62", 28), ("M64 P2", 122), ("M64 P10", 122), ("M62 P0 M63", 21), ("M64 P-1", 4)):
        assert machine.ask(line) == ["error:%d" % error], line
    assert machine.world.on() == (0, 0)


# What each kind of stop leaves on: (tool, flood, reverse, p0, enable), and after going on, if it can.
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
