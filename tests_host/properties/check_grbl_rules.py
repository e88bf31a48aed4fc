"""Rules of grbl that a sender's author relies on and an ordinary job never meets: the lines that each state allows, the effect of
the door, a hold and a reset on spindle, coolant and overrides, and the reports."""

from router import BANNER, LASER, UNHOMED, Machine, answers, home

CASES = {}
RUNS = {}
NOT_QUICK = ("check_hard_limits_count_in_every_state",)


def check_numbers_with_many_decimals():
    """As a CAM program's rounding leaves them."""
    machine = Machine().ready()
    zeros = "." + 28 * "0"
    for line, said in (
        ("G1 X1%s1 F600%s1" % (zeros, zeros), "ok"), ("G0%s X2" % zeros, "ok"), ("G20 G0 Y%s1" % zeros, "ok"),
        ("G21 N%s1 T%s1" % (zeros, zeros), "ok"), ("S%s1" % zeros, "ok"), ("G1 F%s1 X1" % zeros, "error:22"),
        ("G4 P0", "ok"), ("$110=4000" + zeros, "ok"), ("G10 L2 P1%s X%s1" % (zeros, zeros), "ok"),
    ):  # fmt: skip
        assert machine.ask(line) == [said], line
    machine.settle()
    assert machine.controller.position() == [640, 0, 0]


def check_codes_with_decimals():
    machine = Machine().ready()
    for code in ("G90.1", "G28.2", "G30.3", "G92.2", "G92.3", "G38.1", "G43.2"):
        assert machine.ask(code) == ["error:20"], code
    for code in ("G1.5", "G17.1", "G53.1", "M3.1"):
        assert machine.ask(code) == ["error:23"], code


def check_comments_behind_a_dollar():
    machine = Machine().ready()
    assert answers(machine.ask("$g (modes)")) == ["ok"]
    assert machine.ask("$110 = 4000 ; (slow)") == ["ok"] and machine.controller.machine.settings.value(110) == 4_000_000
    assert machine.ask("$I=ab(c)d;e") == ["ok"] and machine.ask("$I")[0] == "[VER:1.1h.20190830:ABD]"


def check_check_mode_takes_programmes_only():
    machine = home(Machine())
    machine.do("$C")
    for line in ("$H", "$#", "$I", "$N", "$110=1", "$RST=$", "$SLP", "$J=X1F100"):
        assert machine.ask(line, 50) == ["error:8"], line
    assert machine.ask("$G")[1] == "ok" and machine.ask("$$")[-1] == "ok"
    machine.world.switches["door"] = 0
    machine.cycles(10)
    assert machine.status()["state"] == "Check"
    machine.world.switches["door"] = 1
    machine.do("G91")
    assert machine.ask("G38.2 Z-5 F100") == ["ok"]  # nothing was probed, and the programme goes on from there
    assert "ALARM:2" in machine.ask("G0 Z-78")
    assert machine.world.place[2] == -640


def check_sleep_in_an_alarm():
    """A reset alone wakes it."""
    machine = Machine()
    machine.said()
    machine.do("$SLP")
    assert machine.status()["state"] == "Sleep"
    assert machine.ask("$X") == ["error:9"] and machine.ask("$H") == ["error:8"]
    machine.put(b"\x18")
    assert machine.cycles(3) == [BANNER, UNHOMED]


def check_no_homing_no_soft_limits():
    machine = home(Machine())
    machine.do("$22=0")
    assert "$20=0" in machine.ask("$$")
    machine.do("G0 X-1")
    machine.settle()
    assert machine.controller.position() == [-320, 0, 0]
    assert "$20=0" in Machine(slots=machine.slots).ask("$$")


def check_a_setting_counts_for_the_next_line():
    """Also where both come at once."""
    machine = Machine().ready()
    machine.put("$110=600\n$120=100\nG0 X2\nX4\n")
    assert machine.cycles(3) == ["ok"] * 4
    fastest = 0
    while machine.controller.state == "run":
        fastest = max(fastest, int(machine.status()["FS"].split(",")[0]))
    assert 590 <= fastest <= 600, fastest


def check_a_reset_in_a_dwell_loses_nothing():
    for line in ("G4 P60", "M3 S100"):
        machine = Machine(tool={"pin": 8, "active": 1, "on_ms": 5000, "off_ms": 0}).ready()
        machine.put(line + "\n")
        machine.cycles(10)
        assert machine.status()["state"] == "Run"
        machine.put(b"\x18")
        assert machine.cycles(5) == [BANNER] and machine.status()["state"] == "Idle", line


def check_a_missed_probe_is_told_before_the_answer():
    machine = Machine().ready()
    assert machine.ask("G38.2 Z-1 F200") == ["ALARM:5", "[PRB:0.000,0.000,-1.000:0]", "ok"]
    machine.do("$X")
    machine.world.floor = 0
    assert machine.ask("G38.2 Z-2 F200") == ["ALARM:4", "[PRB:0.000,0.000,-1.000:0]", "ok"]
    machine.do("$X")
    machine.world.floor = None
    assert machine.ask("G38.3 Z-2 F200")[-2:] == ["[PRB:0.000,0.000,-2.000:0]", "ok"]


def check_hard_limits_count_in_every_state():
    """At rest, in jogs, while probing and in a hold; not while homing, and not where they were hit before."""
    for begin in ("", "$J=X50F3000", "G38.2 Z-20 F100", "G1 X50 F3000\n!"):
        machine = home(Machine())
        machine.do("$21=1")
        machine.put(begin + "\n")
        machine.cycles(40)
        machine.world.switches["limit_y"] = 1
        said = machine.cycles(20)
        assert "ALARM:1" in said and "[MSG:Reset to continue]" in said, begin
        machine.put(b"\x18")
        assert machine.cycles(3) == [BANNER, UNHOMED, "[MSG:Check Limits]"]
        machine.do("$X", "G91 G0 Y1")
        machine.settle()
        assert machine.status()["state"] == "Idle" and machine.status()["Pn"] == "Y"
        del machine.world.switches["limit_y"]
        machine.cycles(20)
        assert home(machine).controller.machine.homed
    machine.do("$21=0")
    machine.world.switches["limit_y"] = 1
    machine.cycles(20)
    machine.do("$21=1")
    assert machine.cycles(20) == [] and machine.status()["state"] == "Idle"


# --- door


def opened(machine):
    machine.world.switches["door"] = 0
    machine.cycles(80)
    assert machine.status()["state"] == "Door:1"
    return machine.world.tool, machine.world.outputs["flood"]


def closed(machine):
    machine.world.switches["door"] = 1
    machine.cycles(20)
    machine.put("~")
    machine.cycles(5)
    return machine.world.tool, machine.world.outputs["flood"]


def check_an_open_door_stops_spindle_and_coolant():
    """While moving, at rest, in a hold, in one that has stopped the spindle, and while it speeds up again."""
    for before in ("", "!", b"!\x9e"):
        machine = Machine().ready()
        machine.do("M3 S500 M8", "G1 X9 F3000")
        machine.cycles(20)
        for byte in before if isinstance(before, bytes) else before.encode():
            machine.put(bytes((byte,)))
            machine.cycles(80)
        assert opened(machine) == (0, 0), before
        machine.status()
        assert machine.status()["FS"] == "0,0" and "A" not in machine.status()
        assert closed(machine) == (1, 1), before
        machine.settle()
        assert machine.controller.position() == [2880, 0, 0] and machine.world.tool == 1
        assert opened(machine) == (0, 0)
        assert closed(machine) == (1, 1)
    machine = Machine(tool={"pin": 8, "active": 1, "on_ms": 500, "off_ms": 0}).ready()
    machine.do("M3 S500 M8", "G1 X9 F3000")
    machine.cycles(20)
    opened(machine)
    closed(machine)
    assert machine.status()["state"] == "Door:3" and machine.world.tool == 1
    assert opened(machine) == (0, 0)
    assert closed(machine) == (1, 1)
    machine.settle()
    assert machine.controller.position() == [2880, 0, 0]


def check_nothing_turns_on_behind_an_open_door():
    machine = Machine(spindle={"max_rpm": 24000, "min_rpm": 6000, "pwm": True, "pin": 18}).ready()
    machine.do("M3 S12000")
    machine.settle()
    opened(machine)
    machine.put("S24000\nM8\n")
    machine.cycles(20)
    machine.put(b"\x9a\xa1\x9e")
    machine.cycles(20)
    assert machine.world.tool == machine.world.power_level == machine.world.outputs["flood"] == 0
    assert machine.world.outputs["mist"] == 0
    assert closed(machine)[0] == 1
    machine.settle()
    assert machine.world.outputs["flood"] == 1 and machine.world.power_level == 1000


def check_a_door_ends_a_jog_and_stays_open():
    for cancelled in (b"", b"\x85", b"!"):
        machine = Machine().ready()
        machine.do("$J=X20F3000")
        machine.cycles(20)
        machine.put(cancelled)
        machine.cycles(2)
        opened(machine)
        place = machine.controller.position()
        assert 0 < place[0] < 6400
        assert machine.ask("$J=X0F3000") == ["error:8"]
        closed(machine)
        machine.cycles(20)
        assert machine.status()["state"] == "Idle" and machine.controller.position() == place
        machine.do("$J=G91X1F600")
        machine.settle()
        assert machine.controller.position()[0] == place[0] + 320


# --- spindle, coolant, overrides


def resumed_ms(machine):
    """How long it takes from `~` to the first step."""
    place = machine.controller.position()
    begun = machine.port.now
    machine.put("~")
    for _ in range(500):
        machine.cycles()
        if machine.controller.position() != place:
            break
    return (machine.port.now - begun) // 12_500


def check_a_stopped_spindle_is_waited_for():
    """`~` starts what the stop byte has stopped, and waits, as for one that it has started again; nothing waits for a spindle
    that has turned all the time."""
    spindle = {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": 0}
    machine = Machine(spindle=spindle, tool={"pin": 8, "active": 1, "on_ms": 200, "off_ms": 0}).ready()
    machine.do("M3 S500", "G1 X200 F3000")
    machine.cycles(40)
    machine.put("!")
    machine.cycles(80)
    assert machine.world.tool == 1 and resumed_ms(machine) < 50
    for stops, tool in ((1, 0), (2, 1)):
        machine.cycles(40)
        machine.put("!")
        machine.cycles(80)
        for _ in range(stops):
            machine.put(b"\x9e")
            machine.cycles(2)
        assert machine.world.tool == tool
        fields = machine.status()
        assert fields["FS"] == ("0,500" if tool else "0,0") and fields.get("A", "") == ("S" if tool else "")
        assert 200 <= resumed_ms(machine) + 2 * stops <= 250
        assert machine.world.tool == 1


def check_the_stop_byte_lights_no_laser():
    machine = Machine(spindle=LASER).ready()
    machine.do("M3 S500", "G1 X20 F3000")
    machine.cycles(20)
    machine.put("!")
    machine.cycles(80)
    for _ in range(3):
        machine.put(b"\x9e")
        machine.cycles(2)
        assert machine.world.tool == 0 and machine.world.power_level == 0
    machine.put("~")
    machine.cycles(20)
    assert machine.world.tool == 1 and machine.world.power_level == 500


def check_a_laser_is_lit_by_the_mode_alone():
    """M3 burns at a stand while G1, G2 or G3 holds, and only then; M4 never does."""
    machine = Machine(spindle=LASER).ready()
    machine.do("M3 S500", "G1 X2 F3000")
    machine.settle()
    for line, power in (
        ("G0", 0), ("G1", 500), ("S200", 200), ("G80", 0), ("S300", 0), ("G2 X2 I1", 300), ("G0", 0), ("G1", 300), ("M4", 0),
        ("G0", 0), ("G1", 0), ("M5", 0),
    ):  # fmt: skip
        machine.do(line)
        machine.settle()
        assert (machine.world.tool, machine.world.power_level) == (1 if power else 0, power), line
    machine.do("M3", "$J=X0 F3000")  # at once: it has been answered, so nothing is under way
    machine.cycles(20)
    assert machine.world.tool == 0 and machine.status()["state"] == "Jog"


def check_coolant_is_what_it_is():
    """After a toggle the modal state follows, so that the programme can have it its way again."""
    machine = Machine().ready()
    machine.do("M8")
    machine.put(b"\xa0\xa1")
    machine.cycles(2)
    assert " M7 T0" in machine.ask("$G")[0]
    machine.do("M8")
    assert machine.world.outputs["flood"] == 1 and " M7 M8 T0" in machine.ask("$G")[0]


def check_overrides_are_the_programmes():
    """Jogs, probing and homing keep their speeds; motion still under way when they end keeps its own, too."""
    machine = Machine().ready()
    machine.put(b"\x91" * 10 + b"\x97")
    machine.cycles(2)
    machine.do("$J=X40 F1000")
    machine.cycles(60)
    assert machine.status()["FS"] == "1000,0"
    machine.put(b"\x85")
    machine.cycles(100)
    machine.do("G1 X100 F1000")
    machine.cycles(100)
    assert machine.status()["FS"] == "2000,0"
    machine.put(b"\x18")
    machine.cycles(3)
    machine.do("$X")
    machine.put(b"\x92" * 5)
    machine.cycles(2)
    machine.put("G38.3 Z-3 F300\n")
    machine.cycles(150)
    assert machine.status()["FS"] == "300,0"
    took = []
    for override in (b"", b"\x92" * 9 + b"\x97"):
        machine = Machine()
        machine.put(override)
        machine.cycles(2)
        begun = machine.port.now
        home(machine)
        took.append(machine.port.now - begun)
    assert took[0] == took[1]


def check_overrides_are_reported_at_once():
    """With the next report, or the one after it where the offsets are due."""
    machine = Machine().ready()
    machine.status()
    machine.status()

    def told(name):
        fields = machine.status()
        return (machine.status() if "WCO" in fields else fields).get(name)

    for data, shown in ((b"\x91", "110,100,100"), (b"\x97", "110,25,100"), (b"\x9b", "110,25,90")):
        machine.put(data)
        machine.cycles()
        assert told("Ov") == shown and told("Ov") is None
    machine.do("M3 S100")
    assert told("A") == "S"
    machine.do("M8")
    assert told("A") == "SF"
    machine.put(b"\xa1")
    machine.cycles()
    assert told("A") == "SFM"
    machine.do("M30")
    assert told("Ov") == "100,100,100"
