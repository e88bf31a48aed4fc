"""TMC2209 drivers on a UART of the emulated Pico: set up over one wire that gives the Pico's own bytes back; a cut one is reported and safe."""

from emulated import make_machine, uf2  # noqa: F401

BOARD = "router_tmc2209"


def ask(machine, line, *words, limit_ms=60_000):
    machine.take()
    machine.send(line.encode() + b"\n")
    machine.run_until(lambda: any(word in machine.replies_so_far() for word in words or (b"ok", b"error", b"ALARM")), limit_ms)
    return machine.take()


def test_drivers_are_set_up_and_a_cut_wire_stops_the_machine(make_machine, show):  # noqa: F811
    machine = make_machine(BOARD, start=(900, 700, -1200))
    drivers = machine.drivers.model
    machine.run_until(lambda: b"$X" in machine.replies_so_far() or b"$H" in machine.replies_so_far(), 10_000)
    assert b"ok" in ask(machine, "$X")
    machine.run_until(lambda: all(drivers[axis].registers[0x6C] != 0x10000053 for axis in "xyz"), 1000)
    machine.run_ms(50)
    assert [drivers[axis].registers[0x00] for axis in "xyz"] == [0x1C0, 0x1C0, 0x1C4]
    assert [drivers[axis].registers[0x02] for axis in "xyz"] == [7, 7, 7], "each has taken its seven registers once"
    machine.send(b"G91G1X100F3000\n")
    machine.run_ms(500)
    assert machine.plant.position[0] > 1000
    drivers["y"].dead = True
    begun = machine.now_ms()
    machine.run_until(lambda: b"ALARM" in machine.replies_so_far(), 2000)
    took = machine.now_ms() - begun
    assert took < 250
    machine.run_ms(100)
    stood = list(machine.plant.position)
    machine.run_ms(200)
    assert list(machine.plant.position) == stood and not machine.plant.enabled
    assert b"driver of y: no answer" in ask(machine, "$LOG")
    drivers["y"].dead = False
    assert b"ok" in ask(machine, "$X") and b"ok" in ask(machine, "G91G1X-1F3000")
    machine.run_until(lambda: machine.plant.position[0] != stood[0], 1000)
    machine.settle()
    assert list(machine.plant.position) == [stood[0] - 80, *stood[1:]]
    show("a cut wire of a TMC2209", f"an alarm {took:.0f} ms later")
