"""Spindle, coolant and laser over the grbl link."""

from draws import Random
from passo.steps.word import TICKS_PER_MS
from router import LASER, Machine, World

CASES = {"check_nothing_moves_before_the_spindle": (("seed", "seed"),)}
RUNS = {"check_nothing_moves_before_the_spindle": 8}
SPIN_UP_MS = 400
COOLANT_MS = 250
NOT_QUICK = ("check_nothing_moves_before_the_spindle",)


class Watched(World):
    """Notes when flood and mist come on, and each step with how long spindle and coolant have been on then, in ms."""

    def __init__(self):
        World.__init__(self)
        self.on = {}
        self.cut = []

    def output(self, tick, name, level):
        World.output(self, tick, name, level)
        if not level:
            self.on.pop(name, None)
        elif name not in self.on:
            self.on[name] = tick

    def edges(self, tick, levels, changed):
        before = self.steps
        World.edges(self, tick, levels, changed)
        if self.steps != before:
            spun = tick - self.tool_changes[-1][0] if self.tool else -1
            cooled = min([tick - self.on[name] for name in ("flood", "mist") if name in self.on] or [-1])
            self.cut.append((tick, spun // TICKS_PER_MS, cooled // TICKS_PER_MS))

    def since(self, tick):
        """(least time of the spindle, of the coolant) of the steps from `tick` on."""
        cut = [item for item in self.cut if item[0] >= tick]
        return min([spun for _, spun, _ in cut]), min([cooled for _, _, cooled in cut])


SPINDLE = {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": SPIN_UP_MS, "coolant_ms": COOLANT_MS}


def cutting(length_mm=40, feed=3000):
    """A machine in the middle of a cut."""
    machine = Machine(Watched(), spindle=SPINDLE).ready()
    machine.do("M3 S500 M8", "G1 X%d F%d" % (length_mm, feed))
    machine.cycles(50)
    assert machine.status()["state"] == "Run" and machine.world.tool == 1
    return machine


def stand(machine, data, state):
    machine.put(data)
    machine.cycles(60)
    assert machine.status()["state"] == state
    return machine.port.now


def check_spindle_and_coolant_come_before_the_cut():
    """After the door, after a spindle stopped in a hold, and after one that the operator has started again himself."""
    for data, state, stopped, waits in (
        (b"\x84", "Door:0", True, SPIN_UP_MS), (b"!", "Hold:0", False, 0), (b"!|\x9e", "Hold:0", True, SPIN_UP_MS),
        (b"!|\x9e|\x9e", "Hold:0", False, SPIN_UP_MS), (b"!|\xa0|\xa0", "Hold:0", False, COOLANT_MS),
        (b"!|\x84", "Door:0", True, SPIN_UP_MS), (b"\x84|~|!", "Door:0", True, SPIN_UP_MS), (b"!|\x9e|~|!", "Hold:0", False, 0),
    ):  # fmt: skip
        machine = cutting()
        parts = data.split(b"|")
        stand(machine, parts[0], "Door:0" if parts[0] == b"\x84" else "Hold:0")
        for part in parts[1:]:
            machine.put(part)
            machine.cycles(3)
        machine.cycles(10)
        assert machine.status()["state"] == state and machine.world.tool == (0 if stopped else 1), data
        steps = machine.world.steps
        begun = machine.port.now
        if data == b"!|\x9e|~|!":  # held again while it spun up: the rest of its time
            machine.cycles(10_000 // 8)
        machine.put(b"~")
        machine.cycles(2)
        if waits:
            assert machine.status()["state"] in ("Door:3", "Hold:1"), data
        machine.settle()
        assert machine.world.steps > steps and machine.world.place[0] == 3000 + 12800, data
        if waits == SPIN_UP_MS:
            assert machine.world.since(begun)[0] >= SPIN_UP_MS, data
        if waits == COOLANT_MS or b"\x84" in data:
            assert machine.world.since(begun)[1] >= COOLANT_MS, data
        first = [tick for tick, _, _ in machine.world.cut if tick >= begun][0]
        assert first - begun <= (waits + 100) * TICKS_PER_MS or b"|!" in data, data


def check_the_door_while_the_spindle_comes():
    """It goes off again, and has its whole time again; a hold then stops what has not begun."""
    machine = cutting()
    stand(machine, b"\x84", "Door:0")
    for again in (b"door", b"!"):
        machine.put(b"~")
        machine.cycles(SPIN_UP_MS * 3 // 4)
        assert machine.status()["state"] == "Door:3" and machine.world.tool == 1
        steps = machine.world.steps
        if again == b"door":
            machine.world.switches["door"] = 0
            machine.cycles(20)
            assert machine.status()["state"] == "Door:1"
            machine.world.switches["door"] = 1
            machine.cycles(10)
        else:
            machine.put(again)
            machine.cycles(5)
        assert machine.status()["state"] == "Door:0" and machine.world.tool == 0 and machine.world.outputs["flood"] == 0
        machine.cycles(2 * SPIN_UP_MS)
        assert machine.world.steps == steps
    begun = machine.port.now
    machine.put(b"~")
    machine.settle()
    spun, cooled = machine.world.since(begun)
    assert spun >= SPIN_UP_MS and cooled >= COOLANT_MS


def check_nothing_moves_before_the_spindle(seed):
    """Whatever an operator does: no step sooner than that after spindle or coolant were switched on, and none without the
    spindle."""
    random = Random(seed)
    machine = cutting(20, 600)
    machine.do("G1 X0", "X20")
    begun = machine.port.now
    first = machine.world.tool_changes[0][0]
    for _ in range(20):
        held = machine.status()["state"] == "Hold:0"
        what = random.choice((b"!", b"~", b"\x84", b"door") + ((b"~", b"\x9e", b"\xa0", b"\xa1") if held else ()))
        if what == b"door":
            machine.world.switches["door"] = random.between(0, 1)
        else:
            machine.put(what)
        machine.cycles(random.choice((1, 5, 60, SPIN_UP_MS // 2, SPIN_UP_MS + 50)))
    machine.world.switches["door"] = 1
    for _ in range(50):
        machine.put(b"~")
        machine.cycles(SPIN_UP_MS + 50)
    assert machine.status()["state"] == "Idle"
    for tick, spun, cooled in machine.world.cut:
        if tick > begun:
            assert spun >= SPIN_UP_MS or tick // TICKS_PER_MS - spun <= first // TICKS_PER_MS + 1
            assert cooled == -1 or cooled >= COOLANT_MS
    assert machine.world.place[0] == 3000 + 6400


def check_a_beam_waits_for_the_coolant_only():
    """And it is dark until then, though M3 holds."""
    machine = Machine(Watched(), spindle=dict(LASER, spin_up_ms=SPIN_UP_MS, coolant_ms=COOLANT_MS)).ready()
    machine.do("M3 S500 M8", "G1 X40 F3000")
    machine.cycles(30)
    stand(machine, b"\x84", "Door:0")
    begun = machine.port.now
    machine.put(b"~")
    machine.settle()
    spun, cooled = machine.world.since(begun)
    assert COOLANT_MS <= cooled < SPIN_UP_MS and spun < 30
    assert machine.world.place[0] == 3000 + 12800


def check_the_first_spin_up():
    """M3 itself waits for tool.on_ms, by default not at all; so does a change of direction."""
    for on_ms in (0, 700):
        machine = Machine(Watched(), tool={"pin": 8, "on_ms": on_ms}).ready()
        for line in ("M3 S500", "M4", "M4 S600", "S700", "M5"):
            begun = machine.port.now
            machine.do(line)
            took = (machine.port.now - begun) // TICKS_PER_MS
            waits = line in ("M3 S500", "M4") and on_ms
            assert waits <= took <= waits + 60, (line, took)


def check_times_as_shipped():
    machine = Machine(Watched()).ready()
    machine.do("M3 S500 M8", "G1 X50 F3000")
    machine.cycles(30)
    stand(machine, b"\x84", "Door:0")
    begun = machine.port.now
    machine.put(b"~")
    machine.settle()
    spun, cooled = machine.world.since(begun)
    assert 4000 <= spun <= 4100 and cooled >= 1000


def check_what_is_refused_leaves_the_tool():
    """If a change of the tool takes time, refused motion queues none, whatever refuses it."""
    machine = Machine(spindle=LASER, tool={"pin": 8, "active": 1, "on_ms": 50, "off_ms": 30}).ready()
    machine.do("G0 X5 Y5", "M3 S500")
    machine.settle()
    place = machine.controller.position()
    for line in ("G18 G2 X8 Z-3 R3 F.004", "G17 G2 X5.003 I-.5 J-.25 F.0001", "G3 X5 Y5 Z-90 I.1 F.001", "G1 X5.01 F.0001"):
        machine.cycles(3)
        assert machine.ask(line)[0] in ("error:33", "error:34"), line
        assert machine.controller.queue.still() and not machine.controller.queue.tool, line
        machine.cycles(100)
        assert machine.world.tool_changes == [] and machine.controller.position() == place, line
    for line in ("G17 G3 X5 Y5 I2 F900", "G18 G2 X8 Z-3 R3", "G17 G2 X5.003 I-.5 J-.25", "G1 X9"):
        steps = machine.world.steps
        machine.do(line, "G0 X5 Y5 Z0")
        machine.settle()
        (on, _), (off, _) = machine.world.tool_changes
        assert machine.world.steps > steps and off > on + 50 * 12_500, line
        del machine.world.tool_changes[:]


def check_spindle_and_coolant():
    machine = Machine().ready()
    machine.do("M3 S12000")
    machine.settle()
    assert machine.world.tool == 1 and machine.world.outputs["reverse"] == 0
    fields = machine.status()
    fields = machine.status()
    assert fields["A"] == "S" and fields["FS"] == "0,12000"
    machine.put(b"\x9a")
    assert machine.status()["FS"] == "0,13200"
    machine.do("M4 M7", "G4 P0")
    assert machine.world.outputs["reverse"] == 1 and machine.world.outputs["mist"] == 1
    machine.put(b"\xa0")
    machine.cycles(2)
    assert machine.world.outputs["flood"] == 1
    machine.put(b"!")
    machine.cycles(5)
    machine.put(b"\x9e")
    machine.cycles(2)
    assert machine.world.tool == 0
    machine.put(b"\x9e")
    machine.cycles(2)
    assert machine.world.tool == 1
    machine.put(b"~")
    machine.cycles(3)
    assert machine.ask("M2") == ["[MSG:Pgm End]", "ok"]
    assert machine.world.tool == 0 and machine.world.outputs["mist"] == 0 and machine.world.outputs["flood"] == 0
    machine.do("M3 S100 M8")
    machine.put(b"\x18")
    machine.cycles(3)
    assert machine.world.tool == 0 and machine.world.outputs["flood"] == 0


def check_spindle_power():
    """A spindle by PWM: the weakest signal up to $31, the rest above it; off is nothing."""
    machine = Machine(spindle={"max_rpm": 24000, "min_rpm": 6000, "pwm": True, "pin": 18}).ready()
    for line, level in (("M3 S24000", 1000), ("S6000", 1), ("S15000", 500), ("S100", 1), ("S0", 0), ("S30000", 1000)):
        machine.do(line)
        machine.cycles(3)
        assert machine.world.power_level == level, line
        assert machine.status()["FS"] == "0," + str(min(int(line.split("S")[1]), 24000)), line
    machine.do("$31=0", "S12000")
    machine.cycles(3)
    assert machine.world.power_level == 500
    machine.do("G1 X1 F1000")
    machine.settle()
    assert machine.world.power_level == 500
    machine.do("M5")
    assert machine.world.power_level == 0 and machine.world.tool == 0


def check_laser():
    """The beam is on exactly while cutting, off in rapids, at a stand and in a hold."""
    machine = Machine(spindle=LASER).ready()
    machine.world.path = []
    machine.do("M4 S500", "G0 X2", "G1 X4 F600", "G0 X6", "G1 X8", "X10 S0", "X12 S900")
    machine.settle()
    for _, x, _, _, tool in machine.world.path:
        at = x - 3000
        wanted = 641 <= at <= 1280 or 1921 <= at <= 2560 or 3201 <= at <= 3840
        assert tool == (1 if wanted else 0), at
    machine.do("G1 X30")
    machine.cycles(20)
    assert machine.world.tool == 1
    machine.put(b"!")
    machine.cycles(60)
    assert machine.world.tool == 0
    machine.put(b"~")
    machine.cycles(10)
    assert machine.world.tool == 1
    machine.settle()
    machine.do("M5")
    machine.cycles(5)
    assert machine.world.tool == 0


def check_a_laser_stops_for_its_mode():
    """M3, M4 and M5 wait for the motion before them, as in grbl; a change of S alone goes on without a stand."""
    for change, stops in (("M3", True), ("M3 S500", True), ("M5", True), ("M5 S500", True), ("S300", False)):
        for words in ("\nX20", "X20"):
            machine = Machine(spindle=LASER).ready()
            machine.world.path = path = []
            lines = "G90 F3000\nM4 S500 G1 X10\n%s%s\n" % (change, words)
            if change[0] == "S" and words[0] == "\n":
                continue
            machine.put(lines)
            machine.cycles(100)
            machine.settle()
            at = [number for number in range(len(path)) if path[number][1] == 3000 + 3200][0]
            gap_ms = (path[at + 1][0] - path[at][0]) / 12_500
            slow = path[at][0] - path[at - 40][0] > 40 * 2 * 12_500_000 / (50 * 320)
            assert (gap_ms > 1 and slow) == stops, (lines, gap_ms, slow)
            assert path[-1][1] == 3000 + 6400


def check_power_follows_the_speed():
    """M4: power / S is speed / F, in both ramps and in cruise; M3: the same power throughout."""
    machine = Machine(spindle=LASER).ready()
    machine.world.burnt = []
    machine.do("M4 S800", "G1 X16 F3000")
    machine.settle()
    burnt = machine.world.burnt
    assert max([power for _, _, _, power in burnt]) == 800 and machine.world.power_level == 0 and not machine.world.tool
    for at in range(100, 5000, 50):
        mm_s = 20 / 320 * 12_500_000 / (burnt[at + 10][0] - burnt[at - 10][0])
        wanted = 800 * mm_s / 50
        assert abs(burnt[at][3] - wanted) <= 25, (at, burnt[at][3], wanted)
    assert [power for _, _, _, power in burnt[:3]] < [40] * 3 and burnt[-1][3] < 40
    del burnt[:]
    machine.do("M3 S500", "G1 X0 F3000", "X2 S1", "X4 S1000 F6000")
    machine.settle()
    assert set([power for _, x, _, power in burnt[:5120]]) == set([500])
    assert set([power for _, x, _, power in burnt[5120:5760]]) == set([1])
    assert set([power for _, x, _, power in burnt[5760:]]) == set([1000])
    assert machine.world.tool == 1 and machine.world.power_level == 1000  # as grbl: M3 burns on
    machine.do("M5")
    machine.cycles(3)
    assert machine.world.tool == 0 and machine.world.power_level == 0


def check_power_where_an_axis_is_slower_than_the_feed():
    machine = Machine(spindle=LASER).ready()
    machine.world.burnt = []
    machine.do("M4 S1000", "G1 X40 F10000")  # $110 is 5000
    machine.settle()
    assert 495 <= max([power for _, _, _, power in machine.world.burnt]) <= 501


def check_power_override_acts_at_once():
    machine = Machine(spindle=LASER).ready()
    machine.do("M3 S500", "G1 X40 F3000")
    machine.cycles(30)
    assert machine.world.power_level == 500 and machine.status()["FS"] == "3000,500"
    machine.put(b"\x9a\x9a")
    machine.cycles(1)
    assert machine.world.power_level == 600 and machine.status()["FS"] == "3000,600"
    machine.put(b"\x9b" * 12)
    machine.cycles(4)
    assert machine.world.power_level == 50
    machine.put(b"\x99!")
    machine.cycles(60)
    assert machine.world.power_level == 0 and machine.world.tool == 0 and machine.status()["FS"] == "0,0"
    machine.put(b"~")
    machine.cycles(30)
    assert machine.world.power_level == 500 and machine.world.tool == 1
    machine.put(b"\x18")
    machine.cycles(2)
    assert machine.world.power_level == 0 and machine.world.tool == 0


def check_a_spindle_that_becomes_a_laser_is_dark():
    """`$32=1` at a stand: the tool is off until a motion lights it, and behind M4 off again at its end."""
    for code, override in (("M4", b""), ("M3", b""), ("M4", b"\x9a"), ("M3", b"\x9a")):
        machine = Machine(spindle=dict(LASER, laser=False)).ready()
        machine.do("G91", "G1F600", code + "S500")
        machine.settle()
        assert machine.world.tool == 1
        machine.do("$32=1")
        machine.cycles(50)
        machine.put(override)
        machine.cycles(50)
        assert machine.world.tool == 0 and machine.world.power_level == 0 and machine.status()["FS"] == "0,0", (code, override)
        machine.do("G0X1")
        machine.settle()
        assert machine.world.tool == 0
        machine.do("X1")
        machine.settle()
        assert machine.world.tool == 0
        before = len(machine.world.tool_changes)
        machine.do("G1X1")
        machine.settle()
        machine.cycles(50)
        assert [on for _, on in machine.world.tool_changes[before:]][:1] == [1], "a motion lights it"
        assert machine.world.tool == (code == "M3")
        machine.do("M5")
        machine.settle()
        assert machine.world.tool == 0


def check_a_laser_that_becomes_a_spindle_is_off():
    """`$32=0`: M5 holds from then on, whether the beam was dark or lit, and whatever comes in the same piece; M3 spins it up."""
    for code in ("M4", "M3"):
        for apart in (True, False):
            machine = Machine(spindle=LASER).ready()
            machine.do("G91", "G1F600", code + "S500", "X1")
            machine.settle()
            before = len(machine.world.tool_changes)
            if apart:
                machine.do("$32=0")
                machine.cycles(50)
                assert machine.world.tool == 0 and machine.world.power_level == 0 and machine.status()["FS"] == "0,0", code
                assert " M5 " in machine.ask("$G")[0]
                machine.do("X1", "G0X1", "G1X1S700")
            else:
                machine.put(b"$32=0\nX1\nG0X1\nG1X1S700\n")
            machine.settle()
            machine.cycles(50)
            assert not [on for _, on in machine.world.tool_changes[before:] if on] and machine.world.tool == 0, (code, apart)
            machine.do("M3S400", "X1")
            machine.settle()
            assert machine.world.tool == 1
