"""Spindle, coolant and laser over the grbl link."""

from router import LASER, Machine

CASES = {}
RUNS = {}


def check_what_is_refused_leaves_the_tool():
    """Where a change of the tool takes time, none is queued for motion that is refused, whatever refuses it."""
    machine = Machine(spindle=LASER, tool={"pin": 8, "active": 1, "on_ms": 50, "off_ms": 30}).ready()
    machine.do("G0 X5 Y5", "M3 S500")
    machine.settle()
    place = machine.controller.position()
    for line in ("G18 G2 X8 Z-3 R3 F.004", "G17 G2 X5.003 I-.5 J-.25 F.0001", "G3 X5 Y5 Z-90 I.1 F.001", "G1 X5.01 F.0001"):
        machine.turns(3)
        assert machine.ask(line)[0] in ("error:33", "error:34"), line
        assert machine.controller.queue.still() and not machine.controller.queue.tool, line
        machine.turns(100)
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
    machine.turns(2)
    assert machine.world.outputs["flood"] == 1
    machine.put(b"!")
    machine.turns(5)
    machine.put(b"\x9e")
    machine.turns(2)
    assert machine.world.tool == 0
    machine.put(b"\x9e")
    machine.turns(2)
    assert machine.world.tool == 1
    machine.put(b"~")
    machine.turns(3)
    assert machine.ask("M2") == ["[MSG:Pgm End]", "ok"]
    assert machine.world.tool == 0 and machine.world.outputs["mist"] == 0 and machine.world.outputs["flood"] == 0
    machine.do("M3 S100 M8")
    machine.put(b"\x18")
    machine.turns(3)
    assert machine.world.tool == 0 and machine.world.outputs["flood"] == 0


def check_spindle_power():
    """A spindle by PWM: the weakest signal up to $31, the rest above it; off is nothing."""
    machine = Machine(spindle={"max_rpm": 24000, "min_rpm": 6000, "pwm": True, "pin": 18}).ready()
    for line, level in (("M3 S24000", 1000), ("S6000", 1), ("S15000", 500), ("S100", 1), ("S0", 0), ("S30000", 1000)):
        machine.do(line)
        machine.turns(3)
        assert machine.world.power_level == level, line
        assert machine.status()["FS"] == "0," + str(min(int(line.split("S")[1]), 24000)), line
    machine.do("$31=0", "S12000")
    machine.turns(3)
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
    machine.turns(20)
    assert machine.world.tool == 1
    machine.put(b"!")
    machine.turns(60)
    assert machine.world.tool == 0
    machine.put(b"~")
    machine.turns(10)
    assert machine.world.tool == 1
    machine.settle()
    machine.do("M5")
    machine.turns(5)
    assert machine.world.tool == 0


def check_a_laser_stops_for_its_mode():
    """M3, M4 and M5 wait for the motion before them, as in grbl; what changes only S goes on without a stand."""
    for change, stops in (("M3", True), ("M3 S500", True), ("M5", True), ("M5 S500", True), ("S300", False)):
        for words in ("\nX20", "X20"):
            machine = Machine(spindle=LASER).ready()
            machine.world.path = path = []
            lines = "G90 F3000\nM4 S500 G1 X10\n%s%s\n" % (change, words)
            if change[0] == "S" and words[0] == "\n":
                continue
            machine.put(lines)
            machine.turns(100)
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
    machine.turns(3)
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
    machine.turns(30)
    assert machine.world.power_level == 500 and machine.status()["FS"] == "3000,500"
    machine.put(b"\x9a\x9a")
    machine.turns(1)
    assert machine.world.power_level == 600 and machine.status()["FS"] == "3000,600"
    machine.put(b"\x9b" * 12)
    machine.turns(4)
    assert machine.world.power_level == 50
    machine.put(b"\x99!")
    machine.turns(60)
    assert machine.world.power_level == 0 and machine.world.tool == 0 and machine.status()["FS"] == "0,0"
    machine.put(b"~")
    machine.turns(30)
    assert machine.world.power_level == 500 and machine.world.tool == 1
    machine.put(b"\x18")
    machine.turns(2)
    assert machine.world.power_level == 0 and machine.world.tool == 0
