"""Until every axis is homed the machine stays locked, whichever of them are; unlocked by hand, it says that soft limits do not hold."""

from passo import errors
from passo.config import setting_numbers as table
from router import Machine, World, answers

AXES = "XYZ"
FAR = {"X": "G53G0X400", "Y": "G53G0Y-90", "Z": "G53G0Z50"}
CAUTION = "[MSG:Caution: not homed, soft limits do not hold]"
UNLOCKED = "[MSG:Caution: Unlocked]"
CASES = {
    "check_an_axis_alone_unlocks_nothing": (("first", 0, 2), ("second", 0, 2), ("third", 0, 2)),
    "check_a_homed_machine_stays_homed": (("axis", 0, 2), ("far", 0, 2)),
    "check_what_loses_the_position_loses_all_axes": (("first", 0, 2), ("second", 0, 2), ("how", 0, 4)),
}
RUNS = {"check_an_axis_alone_unlocks_nothing": 8, "check_a_homed_machine_stays_homed": 4, "check_what_loses_the_position_loses_all_axes": 6}
EXAMPLES = {
    "check_an_axis_alone_unlocks_nothing": ((0, 1, 2), (2, 2, 1)),
    "check_what_loses_the_position_loses_all_axes": tuple([(how % 3, (how + 1) % 3, how) for how in range(5)]),
}
NOT_QUICK = ("check_an_axis_alone_unlocks_nothing", "check_a_homed_machine_stays_homed", "check_what_loses_the_position_loses_all_axes")


class BothEnds(World):
    """A machine with a switch at both ends of each axis."""

    def input(self, tick, name):
        at = self.place["xyz".find(name[-1])] if name[:6] == "limit_" else 0
        return 1 if abs(at) > 2000 else World.input(self, tick, name)


def started():
    """A router near its switches, locked."""
    machine = Machine(World((700, 680, -660)))
    machine.said()
    return machine


def letters(known):
    return [letter for letter in AXES if letter not in known]


def refuses(machine):
    """G-code and jogs of every axis are refused, and nothing moves."""
    before = machine.world.place[:]
    for axis in AXES:
        for line in ("G53G0%s-1" % axis, FAR[axis], "G1%s1F600" % axis, "$J=G91%s1F600" % axis):
            assert machine.ask(line) == ["error:9" if line[0] == "G" else "error:8"], line
    machine.settle()
    assert machine.world.place == before


def limited(machine):
    """Every axis keeps to its travel."""
    for axis in AXES:
        before = machine.world.place[:]
        assert machine.ask("$J=" + FAR[axis].replace("G0", "") + "F900") == ["error:15"], axis
        assert "ALARM:2" in machine.ask("G90" + FAR[axis]) + machine.cycles(5), axis
        assert machine.world.place == before
        machine.put(b"\x18")
        machine.cycles(5)
        machine.ask("$X")


def check_an_axis_alone_unlocks_nothing(first, second, third):
    machine = started()
    known = set()
    for axis in (first, second, third):
        said = machine.ask("$H" + AXES[axis])
        known.add(AXES[axis])
        left = letters(known)
        if not left:
            break
        assert said == ["ALARM:11", "[MSG:Homing required: %s]" % " ".join(left), "ok"], said
        record = machine.controller.machine
        assert record.state == "alarm" and not record.homed and record.alarm == errors.ALARM_HOMING_REQUIRED
        assert machine.controller.machine.report()["unhomed"] == "".join(left)
        refuses(machine)
    for axis in letters(known):
        said = machine.ask("$H" + axis)
    assert said == ["ok"] and machine.controller.machine.homed and machine.status()["state"] == "Idle"
    assert machine.controller.machine.report()["unhomed"] is None
    limited(machine)


def check_homing_that_is_switched_off_amid_it():
    """$22=0 switches the soft limits off, too: $X, the first motion and reports say it, as if they were on."""
    for lines in (("$22=0", "$X"), ("$X", "$22=0")):
        machine = started()
        machine.do("$HX")
        said = machine.ask(lines[0]) + machine.ask(lines[1])
        assert (CAUTION in said) and machine.status()["state"] == "Idle", said
        said = machine.ask("G91G1X1F600") + machine.cycles(5)
        assert said.count(CAUTION) == 1 and machine.controller.machine.report()["unhomed"] == "YZ", said
    machine = started()
    machine.do("$X", "$22=0")
    assert machine.ask("G91G1X1F600") + machine.cycles(5) == ["ok"], "no axis was homed: as of a machine without switches"


def check_a_homed_machine_stays_homed(axis, far):
    machine = started()
    machine.do("$H", "G53G0X4Y3Z-2")
    machine.settle()
    before = machine.world.place[:]
    assert machine.ask("$H" + AXES[axis]) == ["ok"]
    assert machine.controller.machine.homed and machine.status()["state"] == "Idle"
    assert [at == was for at, was in zip(machine.world.place, before)] == [other != axis for other in range(3)]
    machine.do("$20=0")
    machine.do("$H" + AXES[far], "$20=1")
    limited(machine)


def lose(machine, how):
    if how == 0:  # a halt at speed
        machine.put(b"$J=G91X90F2000\n")
        machine.cycles(60)
        machine.put(b"\x18")
        assert "ALARM:3" in machine.cycles(5)
    elif how == 1:  # homing that is broken off
        machine.put(b"$H\n")
        machine.cycles(60)
        machine.put(b"\x18")
        assert "ALARM:6" in machine.cycles(5)
    elif how == 2:  # a switch
        machine.controller.machine.raise_alarm(errors.ALARM_HARD_LIMIT, "limit_x")
        machine.cycles(3)
        machine.put(b"\x18")
        machine.cycles(5)
    elif how == 3:  # the drivers are without current
        machine.do("$SLP")
        machine.put(b"\x18")
        machine.cycles(5)
    else:  # a feature doubts it: an output that the drives need, motors that another controller had
        machine.controller.machine.lose_position()


def check_what_loses_the_position_loses_all_axes(first, second, how):
    machine = started()
    machine.do("$H", "G53G0X4Y3Z-2")
    machine.settle()
    lose(machine, how)
    assert not machine.controller.machine.homed
    said = machine.ask("$H" + AXES[first])
    assert said == ["ALARM:11", "[MSG:Homing required: %s]" % " ".join(letters(AXES[first])), "ok"], said
    said = machine.ask("$H" + AXES[second])
    left = letters(AXES[first] + AXES[second])
    assert said == ["ALARM:11", "[MSG:Homing required: %s]" % " ".join(left), "ok"], said
    refuses(machine)


def check_settings_that_move_zero_lose_it():
    """Steps/mm and the ends that axes home to say what positions are counted by: with others no travel is known, however they were changed."""
    for number in (23, 100, 101, 102):
        for bit in range(3):
            machine = Machine(BothEnds((700, 680, -660)))
            record = machine.controller.machine
            value = record.settings.value(number)
            was, other = (value, value ^ 1 << bit) if number == 23 else (value // 1000, value // 1000 - bit - 1)
            machine.do("$H", "$%d=%d" % (number, was), "$11%d=700" % bit)
            assert record.homed, "it is as it was, and a speed counts nothing"
            for change in ("$%d=%d" % (number, other), "$RST=$"):
                machine.do("$H")
                assert record.homed
                assert "ok" in machine.ask(change)
                machine.cycles(5)
                assert not record.homed and not record.known, change
            assert CAUTION in moved(machine, "G0X1")


def check_lines_that_wait_behind_it_home_on_and_move_nothing():
    """As a sender has them under way: the other axes home, other lines are refused; start-up lines come behind the last axis."""
    machine = started()
    machine.do("$X", "$N0=G91", "$RST=#")
    machine.cycles(5)
    machine.put(b"\x18")
    machine.cycles(5)
    machine.put(b"$HX\nG90\nG0X50\n$J=G91X1F99\n$HY\nM3S100\n$HZ\nG90G53G0X5\n")
    said = []
    while len(answers(said)) < 8:
        said += machine.cycles()
    machine.settle()
    said += machine.said()
    assert [line for line in said if line[:5] != "[MSG:"] == (
        ["ALARM:11", "ok", "error:9", "error:9", "error:8", "ALARM:11", "ok", "error:9", "ok", ">G91:ok", "ok"]
    ), said
    assert machine.status()["MPos"] == "5.000,0.000,0.000"


def moved(machine, line):
    """Return all lines up to the end of the motion."""
    said = machine.ask(line)
    machine.settle()
    return said + machine.said()


def check_caution():
    """At `$X`, at the first motion behind it, in the status until it is homed; once each."""
    for line in ("G0X5", "G1X5F900", "$J=X5F900", "G2X0Y0I2J0F900"):
        machine = started()
        assert machine.ask("$X") == [UNLOCKED, CAUTION, "ok"]
        assert machine.ask("G90") == ["ok"]
        assert sorted(moved(machine, line)) == [CAUTION, "ok"], line
        assert moved(machine, "G0X10") == ["ok"] and machine.controller.machine.report()["unhomed"] == "XYZ"
        assert machine.ask("$HX")[0] == "ALARM:11"
        assert machine.ask("$X") == [UNLOCKED, CAUTION, "ok"]
        assert CAUTION in moved(machine, "G0X11")
        assert machine.ask("$HY") == ["ALARM:11", "[MSG:Homing required: Z]", "ok"], "X is known still"
        assert machine.ask("$HZ") == ["ok"]
        assert moved(machine, "G0X2") == ["ok"]


def check_no_caution_where_no_limit_is_asked_for():
    machine = started()
    machine.do("$20=0")
    assert machine.ask("$X") == [UNLOCKED, "ok"]
    assert moved(machine, "G0X5") == ["ok"]
    machine.do("$20=1")
    assert CAUTION in moved(machine, "G0X6"), "they are asked for now, and do not hold"
    machine.do("$22=0")
    assert machine.controller.machine.report()["unhomed"] is None
    assert machine.controller.machine.settings.value(table.SOFT_LIMITS) == 0
    machine.put(b"\x18")
    machine.cycles(5)
    assert moved(machine, "G0X7") == ["ok"]


def check_a_switch_is_heeded_while_others_are_to_be_homed():
    """A limit, or the emergency stop on its input: the axis that was homed is lost, too."""
    machine = started()
    machine.do("$X", "$21=1")
    assert machine.ask("$HX")[0] == "ALARM:11"
    machine.world.switches["limit_y"] = 1
    said = machine.cycles(100)
    assert "ALARM:1" in said, said
    del machine.world.switches["limit_y"]
    machine.cycles(100)
    machine.put(b"\x18")
    machine.cycles(5)
    assert machine.ask("$HY")[:2] == ["ALARM:11", "[MSG:Homing required: X Z]"]


def check_motors_that_another_controller_had_are_lost():
    outputs = [{"name": "relay", "pin": 14, "active": 1, "role": "ours"}]
    machine = Machine(World((700, 680, -660)), outputs=outputs)
    machine.said()
    machine.do("$X", "$MOTORS=1")
    assert machine.ask("$HX")[0] == "ALARM:11"
    machine.cycles(100)
    assert machine.ask("$HY")[:2] == ["ALARM:11", "[MSG:Homing required: Z]"], "they stay this board's"
    machine.do("$HZ")
    assert machine.controller.machine.homed
    machine.do("$MOTORS=0")
    machine.cycles(100)
    machine.do("$MOTORS=1")
    machine.cycles(100)
    assert not machine.controller.machine.homed and machine.controller.machine.report()["unhomed"] == "XYZ"
