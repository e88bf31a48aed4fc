"""Machines that come to grief on the virtual board, with a black box: each CAUSES[name]() returns (the box's files, path), the path being all
positions of the motors since the power came, in steps from where the machine's zero is at the end.
"""

import copy
import random
from math import cos, pi, sin

from kills import FEED_MS, FREEZE_MS, HEARTBEAT_MS
from probing import Wall

from host_tools import boards
from host_tools.programs.blackbox import file_of
from host_tools.sim.machine import VirtualMachine
from passo.config.journal import MemorySlots
from passo.protocols.plotter.host import COMMANDS, packet
from passo.records import LEAD_TICKS, TICKS_PER_MS

START = (1500, 1200, -900)


class Doomed:
    """A machine whose host sends lines as `ok` comes back, as many bytes under way as a sender has."""

    def __init__(self, board="router_3axis", start=START, homed=True, **changes):
        self.board = {**copy.deepcopy(boards.load(board)), "blackbox": True, **changes}
        self.slots = MemorySlots()
        self.machine = VirtualMachine(self.board, start=start, slots=self.slots)
        self.machine.run_ms(50)
        if homed:
            self.machine.send(b"$H\n")
            self.machine.run_until(lambda: b"ok" in self.machine.replies_so_far(), 120_000)
        self.machine.take()

    def stream(self, lines, until=lambda: False, ask_ms=0):
        """Send until all is answered, or `until` says so."""
        machine, waiting, sizes = self.machine, list(lines), []
        asked = machine.now_ms()
        said = b""
        while waiting or sizes:
            while waiting and sum(sizes) + len(waiting[0]) <= 127:
                sizes.append(len(waiting[0]))
                machine.send(waiting.pop(0))
            if ask_ms and machine.now_ms() - asked >= ask_ms:
                asked = machine.now_ms()
                machine.send(b"?")
            machine.cycle()
            said = machine.take()
            if until() or b"ALARM" in said:
                return said
            del sizes[: said.count(b"ok") + said.count(b"error")]
        return said

    def press(self, name, active=True):
        self.machine.plant.set_input(self.machine.port.now, name, active)

    def at(self, axis, low, high):
        position = self.machine.app.controller.position()
        return low <= position[axis] <= high

    def boxes(self):
        """Return the pages written, the newest last."""
        return self.machine.app.controller.features["links"]._keep.written

    def boxed(self, ms=1500):
        """({name: bytes} of the newest box, path)."""
        self.machine.run_ms(ms)
        return self.files(*self.boxes()[-1]), self.path()

    def files(self, why, numbers, text):
        settings = {f"settings.{slot}": self.slots.read(slot) for slot in range(2)}
        return {"blackbox.bin": file_of(why, numbers, text), "board.py": f"BOARD = {self.board!r}\n".encode(), **settings}

    def path(self):
        machine = self.machine
        here = machine.app.controller.position()
        by = [there - at for there, at in zip(machine.plant.position, here)]
        path = []
        for _, *place in machine.trace._rows:
            place = [at - shift for at, shift in zip(place, by)]
            if not path or path[-1] != place:
                path.append(place)
        return path


def pieces(count=400, mm=0.6, seed=3):
    """Lines in a walk that crosses itself, arcs among them, inside 10 … 90 mm."""
    rng = random.Random(seed)
    x = y = 40.0
    yield b"G21G90G1X40Y40F2500\n"
    for number in range(count):
        turn = rng.uniform(0, 2 * pi)
        if number % 23 == 5:
            yield b"G3X%.3fY%.3fI%.3f\n" % (x, y, 2 + number % 3)
            continue
        x, y = (min(max(at + mm * step(turn) * rng.randint(1, 4), 12), 90) for at, step in ((x, cos), (y, sin)))
        yield b"G1X%.3fY%.3fZ%.3f\n" % (x, y, -2 - 0.01 * (number % 40))


def amid(doomed, ms):
    """Return a function that is true once `ms` have passed."""
    end = doomed.machine.now_ms() + ms
    return lambda: doomed.machine.now_ms() >= end


def limit():
    """A limit switch is hit: the machine has lost steps, and the end of the travel is nearer than it knows."""
    doomed = Doomed()
    doomed.machine.send(b"$21=1\n")
    doomed.stream(pieces(), amid(doomed, 6000))
    now = doomed.machine.port.now
    doomed.machine.plant.inject_noise("limit_x", [now + 1000, now + 20_000_000])
    return doomed.boxed()


def emergency_stop():
    """Behind lines that end by CR and LF, with comments, and with questions among them."""
    doomed = Doomed()
    lines = [line.replace(b"\n", b" (chip) \r\n" if number % 5 else b"\r\n") for number, line in enumerate(pieces())]
    doomed.stream(lines, amid(doomed, 7777), ask_ms=90)
    doomed.press("stop")
    return doomed.boxed()


def starved_link():
    """The host asks, sends half of its job, and dies."""
    doomed = Doomed()
    for link in doomed.board["links"]:
        assert link["lost"] == "retract"
    doomed.stream(pieces(150), ask_ms=200)
    doomed.machine.send(b"G1X12Y12F200\n")
    return doomed.boxed(9000)


def reset_amid_an_arc():
    doomed = Doomed()
    doomed.stream([*pieces(90), b"G1X40Y40Z-1\n"])
    doomed.machine.send(b"G2X60Y40I10F1200\n")
    doomed.machine.settle()
    doomed.machine.send(b"G2X40Y40I-10J2F600\nG2X40Y40I-7F600\n")
    doomed.machine.run_ms(4321)
    doomed.machine.send(b"\x18")
    return doomed.boxed()


def watchdog():
    """The main loop hangs: interrupts bring the machine to a stand, the watchdog resets the chip, and memory stays."""
    doomed = Doomed()
    doomed.stream(pieces(), amid(doomed, 5000))
    app, port = doomed.machine.app, doomed.machine.port
    for at_ms in range(0, FREEZE_MS, FEED_MS):
        app.feeder.brake = at_ms > HEARTBEAT_MS
        if app.feeder.open:
            app.feeder.fill(app.player.words_played(), LEAD_TICKS)
            app.player.start()
        port.advance(FEED_MS * TICKS_PER_MS)
    box = app.controller.features["links"]
    return doomed.files("reset", bytes(box.numbers), bytes(box._text)), doomed.path()


def interlock():
    """The mill's interlock: the drive of Y says that it is no longer good."""
    doomed = Doomed("mill_2004", (3000, 2500, -1800), homed=False)
    doomed.machine.send(b"$X\nG21G91G94F300\n")
    doomed.stream([b"G1X%.2fY%.2f\n" % (0.2 + 0.1 * (n % 3), 0.3 - 0.2 * (n % 4)) for n in range(120)], amid(doomed, 2500))
    doomed.press("dy", False)
    return doomed.boxed()


def probe_missed():
    """G38.2 comes to its end and has touched nothing."""
    doomed = Doomed()
    doomed.stream([*pieces(120), b"G1X30Y30Z-4\n", b"G4P0.01\n"])
    doomed.machine.send(b"G38.2Z-9F150\n")
    return doomed.boxed(4000)


def probe_touched_then_reset():
    """The probe has touched, the machine backs off, and somebody presses reset."""
    doomed = Doomed()
    doomed.machine.plant.stock = Wall(2, -2700, -1)
    doomed.stream([*pieces(100), b"G1X30Y30Z-4\n", b"G38.2Z-9F150\n"])
    doomed.machine.send(b"G91G1Z1F60\n")
    doomed.machine.run_ms(500)
    doomed.machine.send(b"\x18")
    return doomed.boxed()


def power_cut():
    """The input that says that the power fails; 15 ms later it has gone."""
    board = boards.load("router_3axis")
    doomed = Doomed(
        inputs=[*board["inputs"], {"name": "power", "pin": 22, "active": 0, "pull": "up"}], journal={"every_ms": 200, "power": "power"}
    )
    doomed.stream(pieces(), amid(doomed, 6500))
    doomed.press("power")
    return doomed.boxed()


def door_then_reset():
    """The door opens, the machine comes to its stand, goes on, is held, and reset."""
    doomed = Doomed()
    doomed.stream(pieces(), amid(doomed, 4000))
    doomed.press("door")
    doomed.machine.run_ms(900)
    doomed.press("door", False)
    doomed.machine.send(b"~")
    doomed.machine.run_ms(5500)
    doomed.machine.send(b"!")
    doomed.machine.run_ms(600)
    doomed.machine.send(b"\x18")
    doomed.machine.run_ms(300)
    doomed.machine.send(b"$SLP\n")
    doomed.machine.run_ms(100)
    doomed.machine.app.stop()
    return doomed.boxed(100)


def soft_limit():
    """A line leads out of the travel: the machine comes to a stand amid those before it."""
    doomed = Doomed()
    doomed.machine.send(b"$20=1\n")
    doomed.stream([*pieces(300), b"G1X400\n"])
    return doomed.boxed(3000)


def crash():
    """The app ends by an exception: start.py stops the machine."""
    doomed = Doomed()
    doomed.stream(pieces(), amid(doomed, 5210))
    doomed.machine.app.stop()
    return doomed.boxed(10)


def plotter_stop():
    """A plotter's packets, and its STOP."""
    doomed = Doomed("plotter_2014", (300, 200), homed=False)
    machine = doomed.machine
    for x, y in ((100, 40), (300, 200), (20, 210)):
        machine.ask(packet(COMMANDS["LINE"], x, y))
    machine.send(packet(COMMANDS["END"]))
    machine.run_ms(2500)
    machine.send(packet(COMMANDS["STOP"]))
    machine.run_ms(300)
    machine.app.stop()
    return doomed.boxed(100)


CAUSES = {
    each.__name__: each
    for each in (
        limit, emergency_stop, starved_link, reset_amid_an_arc, watchdog, interlock, probe_missed, probe_touched_then_reset, power_cut,
        door_then_reset, soft_limit, crash, plotter_stop,
    )
}  # fmt: skip


# --- with other features of a machine


def stopped(*named, how="stop", **changes):
    doomed = Doomed(*named, **changes)
    flat = (line if b"Z" not in line or len(doomed.board["axes"]) > 2 else line[: line.index(b"Z")] + b"\n" for line in pieces())
    doomed.stream(flat, amid(doomed, 6000))
    if how == "stop":
        doomed.press("stop")
    else:
        doomed.machine.send(b"\x18")
    return doomed.boxed()


def long_door():
    """The door is open for longer than the box has samples; the machine goes on, and is stopped much later."""
    doomed = Doomed()
    doomed.stream(pieces(), amid(doomed, 4000))
    doomed.press("door")
    doomed.machine.run_ms(9000)
    doomed.press("door", False)
    doomed.machine.run_ms(100)
    doomed.machine.send(b"~")
    doomed.machine.run_ms(13_000)
    doomed.press("stop")
    return doomed.boxed()


PARKING = {"target_mm": -1, "mm_min": 500, "pull_out_mm": 1, "pull_out_mm_min": 100, "at_end": True}


def parked():
    """Parked behind an open door, and stopped there."""
    doomed = Doomed(parking=PARKING)
    doomed.stream(pieces(), amid(doomed, 4000))
    doomed.press("door")
    doomed.machine.run_ms(2500)
    doomed.press("stop")
    return doomed.boxed()


COMBINED = {
    "long door": long_door,
    "corexy": lambda: stopped("corexy_plotter", (9000, 9000), how="reset"),
    "backlash, stopped": lambda: stopped("router_ballscrew"),
    "backlash, reset": lambda: stopped("router_ballscrew", how="reset"),
    "drivers": lambda: stopped("router_tmc2209"),
    "shift registers": lambda: stopped("router_esp32"),
    "shift registers, reset": lambda: stopped("router_esp32", how="reset"),
    "four axes": lambda: stopped("router_4axis", (*START, 0)),
    "parking, the door closed": lambda: stopped(parking=PARKING),
}  # fmt: skip
