"""Switches over the grbl link: homing, limits, the probe, the door, buttons, and every alarm that comes of them."""

from array import array

from boards.router_3axis import BOARD
from passo import errors
from passo.config.journal import MemorySlots
from passo.records import BATCH_FIELDS, BATCH_STEPS
from router import BANNER, LASER, PULL_OFF, UNHOMED, Machine, World, home

CASES = {}
RUNS = {}
NOT_QUICK = ("check_homing_direction", "check_an_alarm_switches_off", "check_homing_alarms")


def check_homing():
    machine = home(Machine())
    assert machine.controller.position() == [0, 0, 0] and machine.controller.machine.homed
    assert [machine.world.place[axis] for axis in (0, 1)] == [PULL_OFF] * 2 and machine.world.place[2] == -PULL_OFF
    assert machine.status()["MPos"] == "0.000,0.000,0.000" and machine.status()["state"] == "Idle"
    machine.do("G0 X300 Y200 Z-80", "G0 X0 Y0 Z0")
    machine.settle()
    machine.put(b"$H\n")
    machine.cycles(5)
    assert machine.status()["state"] == "Home"
    machine.put(b"\x18")
    assert machine.cycles(4) == ["ALARM:6", BANNER, UNHOMED]
    machine.put(b"$H\n")
    machine.cycles(5)
    machine.put(b"\x84")
    assert machine.cycles(4) == ["ALARM:7", "ok", BANNER, UNHOMED]


def check_homing_direction():
    """$23 as in grbl: a bit that is set homes to the negative end. A grbl user's value for such a machine changes nothing."""
    machine = Machine().ready()
    assert "$23=3" in machine.ask("$$")
    machine.do("$23=3")
    home(machine)
    assert machine.controller.position() == [0, 0, 0]
    assert [machine.world.place[axis] for axis in (0, 1, 2)] == [PULL_OFF, PULL_OFF, -PULL_OFF]
    for mask, axis, level in ((7, 2, -1), (2, 0, 1), (1, 1, 1)):
        machine = home(Machine())
        machine.do("$23=%d" % mask)
        start = machine.world.place[:]
        machine.put(b"$H\n")
        reached = start[axis]
        for _ in range(100_000):
            if "ALARM:9" in machine.cycles():  # the switch is at the other end
                break
            reached = max(reached * level, machine.world.place[axis] * level) * level
        assert (reached - start[axis]) * level > 10_000, mask


def check_homing_alarms():
    for switch, level, alarm in (("limit_z", 0, "ALARM:9"), ("limit_z", 1, "ALARM:8"), ("limit_x", 0, "ALARM:9")):
        machine = Machine()
        machine.world.switches[switch] = level
        machine.said()
        assert machine.ask("$H", 400_000) + machine.cycles(3) == [alarm, "ok", BANNER, UNHOMED]
        assert machine.status()["state"] == "Alarm" and machine.world.tool == 0


def check_nothing_is_done_behind_a_failed_homing():
    """The machine begins anew: lines sent behind it are gone, start-up lines wait, coolant and overrides are as at the start."""
    machine = Machine().ready()
    machine.do("$N0=G91", "M8")
    machine.world.switches["limit_z"] = 1
    machine.put(b"\x91$H\nG0X1\nM3S100\n")
    said = []
    for _ in range(20_000):
        said += machine.cycles()
        if UNHOMED in said:
            break
    assert said == ["ALARM:8", "ok", BANNER, UNHOMED]
    steps = machine.world.steps
    machine.cycles(50)
    assert machine.said() == [] and machine.world.steps == steps and machine.world.tool == 0
    assert machine.world.outputs["flood"] == 0 and machine.controller.machine.overrides[0] == 100
    machine.world.switches["door"] = 0
    machine.cycles(10)
    assert machine.ask("$H") == ["error:13"]
    machine.world.switches["door"] = 1
    machine.cycles(10)
    del machine.world.switches["limit_z"]
    assert machine.ask("$H", 400_000) == ["ok"] and machine.cycles(3) == [">G91:ok"]


def check_real_time_bytes_in_an_alarm():
    """In an alarm, real-time bytes have no answer and no effect but for the overrides; nor has the door itself. In check mode it is the same."""
    machine = home(Machine())
    machine.do("M3 S500 M8", "G1 X20 F3000")
    machine.cycles(20)
    assert machine.ask("G1 X999") == ["ALARM:2", "[MSG:Reset to continue]", "error:15"]
    machine.put(b"~\x84!~\x85\x9e\xa0\xa1~")
    said = machine.cycles(60)
    machine.world.switches["door"] = 0
    said += machine.cycles(20)
    machine.world.switches["door"] = 1
    machine.put(b"~")
    assert said + machine.cycles(20) == []
    assert machine.status()["state"] == "Alarm" and machine.world.tool == 0
    assert machine.world.outputs["flood"] == 0 and machine.world.outputs["mist"] == 0
    machine.put(b"\x18")
    machine.cycles(3)
    machine.do("$X", "$C")
    machine.put(b"\x84!\xa0~")
    assert machine.cycles(20) == [] and machine.status()["state"] == "Check"
    assert machine.world.tool == 0 and machine.controller.machine.coolant == 0


def check_an_alarm_switches_off():
    """A soft limit at the stand that it brings about, a hard limit at once; a door that was open before does not matter."""
    for laser in (False, True):
        for cause in ("soft", "hard", "held"):
            machine = home(Machine(spindle=LASER) if laser else Machine())
            machine.do("$21=1", "M3 S500 M8", "G1 X20 F3000")
            machine.cycles(20)
            assert machine.world.tool == 1 and machine.world.outputs["flood"] == 1
            if cause == "hard":
                machine.world.switches["limit_y"] = 1
            elif cause == "held":
                machine.put(b"\x84")
                machine.cycles(60)
                assert machine.status()["state"] == "Door:0"
            if cause != "hard":
                machine.put(b"G1 X999\n")
                machine.cycles(1)
                machine.put(b"~")
            machine.cycles(60)
            assert machine.status()["state"] == "Alarm" and machine.world.tool == 0, (laser, cause)
            assert machine.world.outputs["flood"] == 0 and not (laser and machine.world.power_level), (laser, cause)


def check_coolant_is_toggled_in_a_jog():
    machine = home(Machine())
    machine.do("$J=X50F3000")
    machine.cycles(5)
    machine.put(b"\xa0")
    machine.cycles(2)
    assert machine.status()["state"] == "Jog" and machine.world.outputs["flood"] == 1


def check_soft_limits():
    machine = home(Machine())
    steps = machine.world.steps
    for line in ("G0 X-0.01", "G0 X300.01", "G1 Y201 F100", "G0 Z1", "M3 S100 G1 Z-81 F100"):
        assert machine.ask(line) == ["ALARM:2", "[MSG:Reset to continue]", "error:15"], line
        assert machine.ask("$X") == ["error:9"] and machine.ask("G0 X1") == ["error:9"]
        machine.put(b"\x18")
        assert machine.cycles(3) == [BANNER, UNHOMED]
        machine.do("$X")
        assert machine.controller.machine.homed and machine.world.tool == 0
    assert machine.ask("$J=X-1F100") == ["error:15"]
    assert machine.world.steps == steps
    machine.do("$20=0", "G0 X-0.5")
    machine.settle()
    assert machine.controller.position() == [-160, 0, 0]


def check_a_batch_that_leads_out_of_the_travel():
    """Rows of a batch that lead out of the travel raise an alarm, and the waiting ones are dropped. While the machine is not as it should be it takes no
    batch at all.
    """
    machine = home(Machine())
    controller = machine.controller
    batch = machine.app.links[0].batch
    begin, accept, close, _ = controller.batches(batch)
    for line, out in ((2, (-1, 0, 0)), (0, (0, 64_001, 0)), (3, (0, 0, 1))):
        for row in range(4):
            at = row * BATCH_FIELDS
            batch.rows[at : at + BATCH_FIELDS] = array("i", [0, 2, 0, 0, 0, 0, 3, 2, -1, 0])
            if row == line:
                for axis in range(3):
                    batch.rows[at + BATCH_STEPS + axis] = out[axis] - batch.rows[BATCH_STEPS + axis] * row
        assert begin(batch) and batch.room >= 4
        batch.count = 4
        assert accept(batch) == line
        close(batch)
        assert controller.machine.alarm == errors.ALARM_SOFT_LIMIT and not begin(batch)
        machine.cycles(60)
        assert controller.position() == list(controller.queue.target) == [0, 0, 0] and controller.machine.homed
        machine.put(b"\x18")
        machine.cycles(3)
        machine.do("$X", "G0 X0 Y0 Z0")
        machine.settle()
    for line, undo in (("$C", "$C"), ("$SLP", "\x18"), ("M0", "~")):
        machine.put(line + "\n")
        machine.cycles(3)
        assert not begin(batch), line
        machine.put(undo + "\n")
        machine.cycles(5)
        machine.do("$X")
    controller.machine.commander = 1
    assert not begin(batch)


def check_soft_limit_while_moving():
    """The machine comes to a stand on its path, and knows where it is."""
    machine = home(Machine())
    machine.do("G1 X20 F3000")
    machine.cycles(20)
    assert machine.ask("G1 X999")[:2] == ["ALARM:2", "[MSG:Reset to continue]"]
    machine.cycles(60)
    place = machine.controller.position()
    assert 0 < place[0] < 6400 and machine.world.place[0] - PULL_OFF == place[0]
    machine.put(b"\x18")
    machine.cycles(3)
    machine.do("$X", "G0 X0")
    machine.settle()
    assert machine.world.place[0] == PULL_OFF


def check_hard_limits():
    machine = home(Machine())
    machine.do("$21=1", "G1 X50 F3000")
    machine.cycles(20)
    machine.world.switches["limit_y"] = 1
    said = machine.cycles(5)
    assert said[:2] == ["ALARM:1", "[MSG:Reset to continue]"]
    place = machine.world.place[:]
    machine.cycles(20)
    assert machine.world.place == place and machine.controller.machine.log.entries[-1][2] == "limit_y" and not machine.controller.machine.homed
    assert machine.ask("$H") == ["error:9"]
    machine.put(b"\x18")
    machine.cycles(3)
    machine.do("$X")


def check_limits_at_the_start():
    """If limits are watched, an active one locks the machine, with a message."""
    machine = Machine().ready()
    machine.world.switches["limit_x"] = 1
    machine.put(b"\x18")
    assert machine.cycles(3) == [BANNER]
    machine.do("$21=1")
    machine.put(b"\x18")
    assert machine.cycles(3) == [BANNER, UNHOMED, "[MSG:Check Limits]"]
    assert machine.ask("G0 X1") == ["error:9"]
    again = Machine(World(start=(-1, 100, -100)), machine.slots)
    assert again.cycles(2)[-1] == "[MSG:Check Limits]"


def check_probing():
    machine = Machine().ready()
    machine.world.floor = -1800 - 1234
    said = machine.ask("G38.2 Z-10 F200")
    assert said[-1] == "ok" and said[0].startswith("[PRB:0.000,0.000,-3.08") and said[0].endswith(":1]")
    assert abs(machine.controller.position()[2] + 1234) < 60
    assert machine.ask("$#")[-2] == said[0]
    machine.do("G38.5 Z0 F50")
    assert machine.controller.position()[2] > -1234
    said = machine.ask("G38.2 Z1 F200")
    assert said == ["[PRB:0.000,0.000,1.000:0]", "ok", "ALARM:5"] or "ALARM:5" in said + machine.cycles(3)
    machine.do("$X", "G0 Z-5")
    machine.settle()
    said = machine.ask("G38.2 Z-10 F200") + machine.cycles(3)
    assert "ALARM:4" in said
    machine.do("$X")
    machine.do("G38.4 Z0 F200", "G38.3 Z1 F200")
    assert machine.status()["state"] == "Idle"


def check_door():
    machine = Machine().ready()
    machine.do("M3 S500 M8", "G1 X20 F3000")
    machine.cycles(20)
    assert machine.world.tool == 1 and machine.world.outputs["flood"] == 1
    machine.world.switches["door"] = 0
    machine.cycles(60)
    assert machine.status()["state"] == "Door:1" and machine.status()["Pn"] == "D" and machine.world.tool == 0
    machine.put(b"~")
    machine.cycles(5)
    assert machine.status()["state"] == "Door:1"
    machine.world.switches["door"] = 1
    machine.cycles(5)
    assert machine.status()["state"] == "Door:0"
    machine.put(b"~")
    machine.settle()
    assert machine.controller.position() == [6400, 0, 0] and machine.world.tool == 1
    machine.put(b"\x84")
    machine.cycles(3)
    assert machine.status()["state"] == "Door:0"
    machine.put(b"~")
    machine.cycles(4200)
    assert machine.status()["state"] == "Idle"


def check_door_at_rest():
    """The machine neither unlocks nor homes while it is open; afterwards a message comes each time it opens; after a reset the machine waits for it."""
    machine = Machine()
    machine.said()
    machine.world.switches["door"] = 0
    assert machine.cycles(10) == []
    assert machine.ask("$X") == ["error:13"] and machine.ask("$H") == ["error:13"]
    machine.world.switches["door"] = 1
    machine.cycles(10)
    assert machine.ask("$X")[0] == "[MSG:Caution: Unlocked]"
    machine.world.switches["door"] = 0
    assert machine.cycles(10) == ["[MSG:Check Door]"]
    machine.put(b"\x18")
    assert machine.cycles(10) == [BANNER, "[MSG:Check Door]"]
    assert machine.status()["state"] == "Door:1"
    assert "ok" in machine.ask("G0 X1")
    machine.world.switches["door"] = 1
    machine.cycles(10)
    assert machine.world.steps == 0
    machine.put(b"~")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0] and machine.status()["state"] == "Idle"


BUTTONS = [{"name": name, "pin": 20 + pin, "active": 0} for pin, name in enumerate(("hold", "resume", "reset"))]


def check_buttons():
    """Inputs named hold, resume and reset do what the bytes do, and show in Pn; noise shorter than $26 does nothing."""
    machine = Machine(inputs=BUTTONS + BOARD["inputs"])
    for name in ("hold", "resume", "reset"):
        machine.world.switches[name] = 1
    machine.cycles(3)
    machine.ready()

    def press(name):
        machine.world.switches[name] = 0
        said = machine.cycles(10)
        pins = machine.status()["Pn"]
        machine.world.switches[name] = 1
        return [pins] + said + machine.cycles(10)

    machine.do("G1 X20 F3000")
    machine.cycles(10)
    assert press("hold") == ["H"]
    machine.cycles(60)
    assert machine.status()["state"] == "Hold:0" and 0 < machine.controller.position()[0] < 6400
    assert press("resume") == ["S"]
    machine.cycles(5)
    assert machine.status()["state"] == "Run"
    machine.settle()
    assert machine.controller.position()[0] == 6400
    assert press("reset") == ["R", BANNER]
    machine.do("$26=200", "G1 X0 F600")
    machine.world.switches["hold"] = 0
    machine.cycles(1)
    machine.world.switches["hold"] = 1
    machine.cycles(10)
    assert machine.status()["state"] == "Run"


def check_inverted_inputs_and_pulses():
    """$5 and $6 turn limits and probe round, $2 the pulses and $0 their length, with the next start."""
    machine = Machine(slots=MemorySlots()).ready()
    machine.do("$5=0", "$6=1")
    assert machine.status()["Pn"] == "XYZP"
    machine.world.switches.update({"limit_x": 0, "limit_y": 1, "limit_z": 1, "probe": 0})
    assert machine.status()["Pn"] == "X"
    assert machine.world.rest == 0 and machine.app.player.min_word_ticks == 76
    machine.do("$5=1", "$6=0", "$2=5", "$0=10")
    again = Machine(slots=machine.slots).ready()
    assert again.world.rest == 0b101 and again.app.player.min_word_ticks == 250
    again.do("G0 X1 Y1 Z1")
    again.settle()
    assert again.controller.position() == [320, 320, 400]
    assert [at - by for at, by in zip(again.world.place, (3000, 2500, -1800))] == [320, 320, 400]


def check_pins_follow_the_settings():
    """Direction and enable turned round with the next start, the drivers' release at once."""
    machine = Machine().ready()
    machine.do("$3=6", "$4=1", "$1=30")
    again = Machine(slots=machine.slots).ready()
    again.do("G0 X1 Y1")
    assert again.world.outputs["enable"] == 1
    again.settle()
    assert [again.world.place[0] - 3000, again.world.place[1] - 2500] == [-320, 320]
    assert again.controller.position() == [320, 320, 0]
    again.cycles(200)
    assert again.world.outputs["enable"] == 0
