"""M10 and M11 over the grbl link: a vacuum cleaner, which every stop switches off, and a clamp, which lets go only on M11."""

from passo import errors
from passo.config.boardfile import check
from passo.options.output_clamp.errors import SPINDLE_TURNS
from router import PLAIN, Machine

VACUUM, CLAMP = {"name": "vacuum", "pin": 17, "active": 1}, {"name": "clamp", "pin": 18, "active": 1}
FLOOD = {"name": "flood", "pin": 16, "active": 1}


def machine_with(*outputs, **changes):
    return Machine(**check(dict(PLAIN, outputs=[FLOOD] + list(outputs), **changes))).ready()


def on(machine, name):
    return machine.world.outputs.get(name, 0)


def stops():
    """[(name, what brings it about)] of everything that stops or ends something."""

    def put(data, turns=60):
        return lambda machine: (machine.put(data), machine.cycles(turns))

    def door(machine):
        machine.world.switches["door"] = 0
        machine.cycles(300)

    def limit(machine):
        machine.world.switches["stop"] = 1
        machine.cycles(20)

    def beyond(machine):
        machine.do("$H", "$20=1", "M10", "M8")
        assert machine.ask("G53 G0 X900")[0] == "ALARM:2"
        machine.cycles(50)

    return [
        ("reset", put(b"\x18")), ("door", door), ("limit", limit), ("M2", lambda machine: machine.do("M2")),
        ("M30", lambda machine: machine.do("M30")), ("sleep", lambda machine: machine.do("$SLP")),
        ("soft limit", beyond),
    ]  # fmt: skip


def check_a_vacuum_is_off_in_every_safe_state():
    for name, stop in stops():
        machine = machine_with(VACUUM)
        assert on(machine, "vacuum") == 0
        machine.do("M10", "M8")
        assert on(machine, "vacuum") == 1, name
        stop(machine)
        assert on(machine, "vacuum") == on(machine, "flood") == 0, name
    machine = machine_with(VACUUM)
    machine.do("M10", "M9")
    assert on(machine, "vacuum") == 1, "M9 is the coolant's"
    machine.do("M11")
    assert on(machine, "vacuum") == 0


def check_a_vacuum_comes_back_behind_the_door():
    machine = machine_with(VACUUM)
    machine.do("M10")
    machine.world.switches["door"] = 0
    machine.cycles(100)
    assert on(machine, "vacuum") == 0
    machine.world.switches["door"] = 1
    machine.put(b"~")
    machine.cycles(3000)
    assert on(machine, "vacuum") == 1


def check_a_clamp_holds_through_every_stop():
    for name, stop in stops():
        machine = machine_with(CLAMP, VACUUM)
        machine.do("M10", "M3 S900")
        machine.settle()
        stop(machine)
        assert on(machine, "clamp") == 1, name
        assert on(machine, "vacuum") == 0, "M10 is the clamp's"


def check_a_clamp_lets_go_at_a_stand_and_never_beneath_a_spindle():
    machine = machine_with(CLAMP)
    machine.do("M10", "M3 S900")
    machine.settle()
    refused = "error:%d" % SPINDLE_TURNS
    assert machine.ask("M11")[-1] == refused and on(machine, "clamp") == 1
    machine.put(b"!")
    machine.cycles(50)
    machine.put(b"\x9e~")  # spindle stop in a hold
    machine.cycles(50)
    assert machine.ask("M11")[-1] == refused and on(machine, "clamp") == 1
    machine.do("M5", "G91", "G1 X2 F600", "M11")
    assert machine.controller.queue.still() and on(machine, "clamp") == 0
    assert machine.world.place[0] == machine.controller.position()[0] + 3000


def check_numbers():
    """M64 P and M65 P, if the name says so; other outputs keep theirs."""
    machine = machine_with({"name": "p1_vacuum", "pin": 17, "active": 1}, {"name": "p2_clamp", "pin": 18, "active": 0}, {"name": "p0", "pin": 15, "active": 1})
    machine.do("M64 P1", "M64 P2", "M64 P0")
    assert (on(machine, "p1_vacuum"), on(machine, "p2_clamp"), on(machine, "p0")) == (1, 0, 1)
    machine.do("M3 S900")
    assert machine.ask("M65 P2")[-1] == "error:%d" % SPINDLE_TURNS
    machine.do("M5", "M11", "M65 P1")
    assert (on(machine, "p1_vacuum"), on(machine, "p2_clamp"), on(machine, "p0")) == (0, 1, 1)
    for line in ("M64 P3", "M62 P1", "M63 P2"):
        assert machine.ask(line)[-1] == "error:%d" % errors.NUMBER_RANGE, line
    alone = machine_with({"name": "p1_vacuum", "pin": 17, "active": 1})
    alone.do("M64 P1")
    assert on(alone, "p1_vacuum") == 1 and alone.ask("M64 P2")[-1] == "error:%d" % errors.NUMBER_RANGE


def check_a_status_says_it():
    machine = machine_with({"name": "p1_vacuum", "pin": 17, "active": 1}, CLAMP)
    machine.do("M10")
    fields = {}
    for _ in range(40):
        fields.update(machine.status())
    assert fields["Clamp"] == "1" and fields["Vac"] == "0P1"


def check_a_board_without_them_knows_no_such_code():
    machine = machine_with()
    assert machine.ask("M10")[-1] == machine.ask("M11")[-1] == "error:%d" % errors.UNKNOWN_COMMAND


def check_while_checking_nothing_switches():
    machine = machine_with(VACUUM)
    machine.do("$C", "M10")
    assert on(machine, "vacuum") == 0
