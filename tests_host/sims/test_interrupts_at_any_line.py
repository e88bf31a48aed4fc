"""A chip makes words in an interrupt, which may come between any two lines of the firmware: nothing is lost, begun anew or left behind by it."""

import random
import sys
from pathlib import Path

import pytest
from router import LASER, Machine

import passo
from passo.steps.word import TICKS_PER_MS

FIRMWARE = str(Path(passo.__file__).parent)
HARDWARE = str(Path(passo.__file__).parent / "ports")  # stands for the chip here: its lines take no time


class Interrupts:
    """Calls the feeder as a chip's timer does, at lines of the firmware taken by chance, one in `every`, but never within itself."""

    def __init__(self, machine, chance, every):
        self._machine = machine
        self._chance = chance
        self._every = every
        self._left = 1
        self._apart = False  # as after put_off()
        self._feed = machine.app._make_words
        machine.app._make_words = lambda: self._alone(self._feed)
        machine.port.put_off = lambda: self._set_apart(True)
        machine.port.catch_up = lambda: self._set_apart(False)
        self.count = 0

    def _set_apart(self, on):
        self._apart = on

    def _alone(self, do):
        sys.settrace(None)
        try:
            do()
        finally:
            sys.settrace(self._call)

    def __enter__(self):
        sys.settrace(self._call)
        return self

    def __exit__(self, *_):
        sys.settrace(None)

    def _call(self, frame, event, _):
        name = frame.f_code.co_filename
        return self._line if name.startswith(FIRMWARE) and not name.startswith(HARDWARE) else None

    def _line(self, frame, event, _):
        if event == "line" and not self._apart:
            self._left -= 1
            if not self._left:
                self._left = self._chance.randint(1, 2 * self._every)
                self.count += 1
                self._alone(self._interrupt)
        return self._line

    def _interrupt(self):
        app = self._machine.app
        app.feeder.fill(app.player.words_played(), self._chance.choice((2, 20, 100)) * TICKS_PER_MS)
        app.player.start()


def move(machine, chance):
    for _ in range(chance.randint(1, 12)):
        machine.do("G91 G1 X%d Y%d Z-%d F%d" % (chance.randint(1, 3), chance.randint(0, 3), chance.randint(0, 1), chance.randint(600, 3000)))
    if chance.random() < 0.5:
        machine.do("G91 G2 X2 Y2 R2")


def cancel_a_jog(machine, chance):
    machine.do("$J=G91 X%d F%d" % (chance.choice((-40, 40)), chance.randint(300, 3000)))
    machine.cycles(chance.randint(1, 300))
    machine.put(b"\x85")
    machine.settle()


def hold_and_go_on(machine, chance):
    move(machine, chance)
    machine.put("!")
    machine.cycles(chance.randint(1, 300))
    while machine.controller.machine.hold and not machine.controller.machine.stood:
        machine.cycles()
    machine.put("~")
    machine.settle()


def hold_and_reset(machine, chance):
    move(machine, chance)
    machine.put("!")
    machine.cycles(chance.randint(1, 300))
    machine.put(b"\x18")
    machine.cycles(20)
    machine.said()
    machine.ask("$X")


def touch(machine, chance):
    machine.settle()
    machine.world.floor = machine.world.place[2] - chance.randint(20, 100)
    machine.do("G91", "G38.2 Z-5 F%d" % chance.randint(60, 300))
    machine.do("G38.4 Z5 F%d" % chance.randint(60, 300))
    machine.settle()
    machine.world.floor = None


def override(machine, chance):
    move(machine, chance)
    for _ in range(chance.randint(1, 9)):
        machine.put(chance.choice((b"\x91", b"\x92", b"\x93", b"\x94", b"\x90", b"\x95", b"\x96", b"?")))
        machine.cycles(chance.randint(1, 50))


def light(machine, chance):
    machine.do(chance.choice(("M3 S1000", "M4 S500", "M5")))


DEEDS = (move, cancel_a_jog, hold_and_go_on, hold_and_reset, touch, override, light)


@pytest.mark.parametrize("laser", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_the_machine_stands_where_it_says(seed, laser):
    chance = random.Random(seed)
    machine = Machine(**({"spindle": LASER} if laser else {})).ready()
    start, origin = list(machine.world.place), machine.controller.position()
    with Interrupts(machine, chance, 300) as interrupts:
        for _ in range(20):
            chance.choice(DEEDS)(machine, chance)
            machine.settle()
            steps, place = machine.world.steps, machine.controller.position()
            machine.cycles(50)
            assert machine.world.steps == steps  # nothing begins anew
            assert [at - of for at, of in zip(machine.world.place, start)] == [at - of for at, of in zip(place, origin)]
        machine.do("M5", "G90", "G0 X0 Y0 Z0")
        machine.settle()
    assert interrupts.count > 1000
    assert machine.controller.position() == [0, 0, 0]
