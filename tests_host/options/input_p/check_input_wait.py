"""M66 over the grbl link: the end of a wait for an input, its result, and the effect of real-time bytes on it."""

from boards.router_3axis import BOARD
from check_jobs import make, remove, run, store
from passo.control.motors import RELEASED, RUNNING
from passo.steps.word import TICKS_PER_MS
from router import BANNER, Machine, home

# p0 is active at 1, p1 at 0.
INPUTS = list(BOARD["inputs"]) + [
    {"name": "p0", "pin": 20, "active": 1, "pull": "up", "halt": False, "filter_us": 0},
    {"name": "p1", "pin": 21, "active": 0, "pull": "up", "halt": False, "filter_us": 0},
]
CYCLE_MS = 9  # the virtual port's is 8
CASES = {
    "check_what_ends_a_wait": (
        ("port", 0, 1), ("mode", 0, 4), ("first", 0, 1), ("changes", "list", 4, ("after_ms", 30, 200)), ("timeout_ms", 100, 600),
    ),
    "check_refusals": (("port", -1, 3), ("mode", -1, 6), ("half", 0, 1), ("timeout_ms", -2, 3)),
}  # fmt: skip
RUNS = {"check_what_ends_a_wait": 30}


def router(p0=0, p1=1, **changes):
    machine = Machine(inputs=INPUTS, **changes)
    machine.world.switches.update({"p0": p0, "p1": p1})
    return machine.ready()


def found(machine):
    """Return the last M66's result, from status reports; None: they have none."""
    for _ in range(31):
        fields = machine.status()
        if "In" in fields:
            return int(fields["In"])
    return None


def check_what_ends_a_wait(port, mode, first, changes, timeout_ms):
    """As told in LinuxCNC's manual, against a list of when the input changes."""
    active = (1, 0)[port]
    machine = router()
    name = "p%d" % port
    machine.world.switches[name] = active if first else 1 - active
    want_ms, want, level, at_ms = timeout_ms, -1, first, 0
    if mode == 0 or mode == 3 and first or mode == 4 and not first:
        want_ms, want, changes = 0, first, ()
    times = []
    for after_ms in changes:
        at_ms += after_ms
        level = 1 - level
        times.append(at_ms)
        if want < 0 and at_ms < timeout_ms and level == mode % 2:
            want_ms, want = at_ms, level
    if [ms for ms in times if abs(ms - timeout_ms) <= 3 * CYCLE_MS]:
        return  # the cycle decides
    begun = machine.port.now
    machine.put("M66 P%d L%d Q%d.%03d\n" % (port, mode, timeout_ms // 1000, timeout_ms % 1000))
    said = []
    while not said:
        machine.app.cycle()
        now_ms = (machine.port.now - begun) // TICKS_PER_MS
        while times and times[0] <= now_ms:
            times.pop(0)
            machine.world.switches[name] ^= 1
        said = machine.said()
        assert now_ms < 2000
    assert said == ["ok"] and want_ms - CYCLE_MS <= now_ms <= want_ms + 3 * CYCLE_MS, (now_ms, want_ms)
    assert found(machine) == want


def check_refusals(port, mode, half, timeout_ms):
    """The machine waits and takes the line only if each word is right; in check mode, too, and without reading the input."""
    machine = router()
    line = "M66 P%d L%d%s Q%s0.00%d" % (port, mode, ".5" if half else "", "-" if timeout_ms < 0 else "", abs(timeout_ms))
    error = 0
    if port < 0:
        error = 4
    elif half:
        error = 23
    elif port > 1 or not 0 <= mode <= 4 or mode and timeout_ms <= 0:
        error = 122
    want = "error:%d" % error if error else "ok"
    assert machine.ask(line) == [want], line
    assert found(machine) == (None if error else {0: 0, 4: 0}.get(mode, -1))
    if not error:
        machine = router()
        machine.do("$C")
        assert machine.ask(line) == ["ok"] and found(machine) is None


def check_lines_that_are_no_wait():
    machine = router()
    for line, error in (
        ("M66", 28), ("M66 L0", 28), ("M66 L3 Q1", 28), ("M66 P0.5", 23), ("M66 P0 L1", 122), ("M66 P0 L3 Q0", 122), ("M66 P0 L3 Q0.0001", 122),
        ("M66 P2", 122), ("M66 E0 L0", 20), ("M66 P0 E0 L0", 20), ("M66 P0 L0 R1", 36), ("M66 P0 M64 P0", 25), ("M66 P0 M62", 21),
        ("M62 P0 Q1", 36), ("M64 P0 L1", 36), ("M66.1 P0", 23), ("G4 P1 M66", 28),
    ):  # fmt: skip
        assert machine.ask(line) == ["error:%d" % error], line
    assert machine.ask("M66 P0") == ["ok"] and found(machine) == 0
    assert Machine().ready().ask("M66 P0 L3 Q1") == ["error:102"], "no such input in its board file"
    machine = Machine(inputs=INPUTS)
    assert machine.ask("M66 P0")[-1] == "error:9", "locked: it has not homed"


def check_it_stands_behind_the_motion_before_and_holds_the_one_behind():
    """Changes of the input before the axes stand do not count."""
    machine = router()
    machine.put("G91G1X5F3000\nM66P0L1Q60\nX5\n")
    machine.cycles(5)
    machine.world.switches["p0"] = 1
    machine.cycles(3)
    machine.world.switches["p0"] = 0
    machine.cycles(400)
    assert machine.world.place[0] == 3000 + 5 * 320 and machine.status()["state"] == "Run"
    for _ in range(20):
        machine.cycles(50)
        machine.put("?")
        assert machine.cycles(2)[0][:5] == "<Run|"
    assert machine.world.place[0] == 3000 + 5 * 320
    machine.world.switches["p0"] = 1
    assert "ok" in machine.cycles(3)
    machine.settle()
    assert machine.world.place[0] == 3000 + 10 * 320 and found(machine) == 1


def check_the_line_comes_before_its_motion():
    machine = router()
    machine.put("G91G1X5F3000M66P0L1Q9\n")
    machine.cycles(50)
    assert machine.world.place[0] == 3000
    machine.world.switches["p0"] = 1
    assert "ok" in machine.cycles(5)
    machine.settle()
    assert machine.world.place[0] == 3000 + 5 * 320


def held(machine, byte, state):
    machine.put(byte)
    machine.cycles(4)
    assert machine.status()["state"] == state


def check_its_time_begins_with_it():
    machine = router()
    machine.do("M66P0L4Q9")
    assert found(machine) == 0
    machine.cycles(500)
    begun = machine.port.now
    machine.put("M66P0L3Q0.5\n")
    machine.cycles(2)
    assert found(machine) is None, "the last one is forgotten"
    while "ok" not in machine.cycles():
        pass
    assert 500 - CYCLE_MS <= (machine.port.now - begun) // TICKS_PER_MS <= 500 + 3 * CYCLE_MS and found(machine) == -1


def check_a_hold_stops_its_time_and_its_eyes():
    for byte, state in ((b"!", "Hold:0"), (b"\x84", "Door:0")):
        machine = router()
        begun = machine.port.now
        machine.put("M66P0L1Q0.5\n")
        machine.cycles(10)
        held(machine, byte, state)
        stopped = machine.port.now
        machine.cycles(300)  # more than its time
        assert "ok" not in machine.said() and machine.status()["state"] == state
        waited = machine.port.now - stopped
        machine.put(b"~")
        while "ok" not in machine.cycles():
            pass
        passed_ms = (machine.port.now - begun - waited) // TICKS_PER_MS
        assert 500 - CYCLE_MS <= passed_ms <= 500 + 10 * CYCLE_MS and found(machine) == -1
        machine.put("M66P0L1Q5\n")
        machine.cycles(10)
        held(machine, byte, state)
        machine.world.switches["p0"] = 1
        machine.cycles(100)
        assert "ok" not in machine.said()
        machine.put(b"~")
        assert "ok" in machine.cycles(10) and found(machine) == 1


def check_the_motors_keep_their_current():
    """Through a wait, a hold of it and the door, as through G4; behind it they are released as ever."""
    for wait in ("M66P0L3Q9", "G4P9"):
        machine = router(idle_release_ms=100)
        motors = machine.app.controller.machine.motors
        machine.do("G91G1X1F3000")
        machine.settle()
        for byte in (b"", b"!", b"\x84"):
            machine.cycles(300)
            assert motors.state == RELEASED and machine.world.outputs["enable"] == 1
            machine.put(wait + "\n")
            machine.cycles(300)
            assert motors.state == RUNNING and machine.world.outputs["enable"] == 0, wait
            machine.put(byte)
            machine.cycles(300)
            assert motors.state == RUNNING and machine.world.outputs["enable"] == 0, (wait, byte)
            machine.put(b"~" if byte else b"")
            while "ok" not in machine.cycles():
                assert machine.world.outputs["enable"] == 0, (wait, byte)


def check_reset_and_stops_end_it():
    """The machine stood: no alarm comes of a reset, and its place is kept. Lines sent after it are gone."""
    machine = router()
    machine.put("M66P0L3Q60\nG91G1X5F3000\n")
    machine.cycles(20)
    machine.put(b"\x18")
    assert machine.cycles(4) == [BANNER] and machine.status()["state"] == "Idle"
    machine.world.switches["p0"] = 1
    machine.cycles(200)
    assert machine.said() == [] and machine.world.steps == 0 and found(machine) is None
    machine.do("M66P0L3Q1")
    machine.put("M66P1L3Q60\nG91G1X5F3000\n")
    machine.cycles(20)
    machine.world.switches["stop"] = 1
    said = machine.cycles(5)
    assert "ALARM:1" in said and "error:9" in said and "ok" not in said, said
    machine.world.switches["stop"] = machine.world.switches["p1"] = 0
    machine.cycles(200)
    assert machine.world.steps == 0


def check_a_reset_in_its_hold():
    machine = router()
    machine.put("M66P0L3Q60\n")
    machine.cycles(10)
    held(machine, b"!", "Hold:0")
    machine.put(b"\x18")
    assert machine.cycles(4) == [BANNER] and machine.status()["state"] == "Idle"
    machine.do("M66P0L4Q1")


def check_a_stored_job_waits():
    """As a stream does. A hold, the report and going on work; a reset ends the job."""
    for ended in (False, True):
        machine = make(changes={"inputs": INPUTS})
        machine.world.switches.update({"p0": 0, "p1": 1})
        home(machine.ready())
        store(machine, "CLAMP", b"G91G1X5F3000\nM66P0L3Q900\nG1X5\n")
        start = machine.world.place[0]
        machine.do("$F=CLAMP")
        machine.cycles(1000)
        held(machine, b"!", "Hold:0")
        machine.put(b"~")
        machine.cycles(1000)
        assert machine.world.place[0] == start + 5 * 320 and machine.status()["state"] == "Run"
        machine.said()
        if ended:
            machine.put(b"\x18")
            assert machine.cycles(10)[0] == "[MSG:Job CLAMP: error 157 in line 2]"
        machine.world.switches["p0"] = 1
        if not ended:
            assert "[MSG:Job CLAMP done]" in run(machine)
        machine.settle()
        assert machine.world.place[0] == start + (5 if ended else 10) * 320
        remove(machine)
