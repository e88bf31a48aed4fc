"""M62 and M63 on the emulated Pico: when a pin changes, against the first step of the motion that it comes with."""

import base64
import copy

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.programs import stored_job

WITHIN_US = 4  # behind the step's edge
P0, P1 = 20, 21
STEPS = (2, 3, 4)


class Router:
    def __init__(self, make, **changes):
        plain = copy.deepcopy(boards.load("router_3axis"))
        outputs = [*plain["outputs"], {"name": "p0", "pin": P0}, {"name": "p1", "pin": P1, "active": 0}]
        self.machine = make({**plain, "journal": None, "outputs": outputs, **changes})
        self.machine.run_until(lambda: b"$H" in self.machine.replies_so_far() or b"$X" in self.machine.replies_so_far(), 10_000)
        pico = self.machine.pico
        self.steps = []  # cycles of all steps
        for pin in STEPS:
            pico.pads.add_listener(pin, lambda _, state: state == 1 and self.steps.append(pico.cycle))
        self.p0, self.p1 = pico.record_edges(P0), pico.record_edges(P1)
        self.do("$X", "G21G91G17F1500")

    def ask(self, line):
        self.machine.take()
        self.machine.send(line.encode() + b"\n")
        self.machine.run_until(lambda: b"ok" in self.machine.replies_so_far() or b"error" in self.machine.replies_so_far(), 60_000)
        return self.machine.take()

    def do(self, *lines):
        for line in lines:
            said = self.ask(line)
            assert b"ok" in said, (line, said)

    def stream(self, *lines):
        """Lines a few at a time, so that they go through without a stand."""
        for at in range(0, len(lines), 6):
            self.machine.take()
            some = lines[at : at + 6]
            self.machine.send("".join(line + "\n" for line in some).encode())
            self.machine.run_until(lambda: self.machine.replies_so_far().count(b"ok") == len(some), 60_000)

    def marks(self):
        """Steps made as each motion began, by settling between: see places()."""
        self.machine.settle()
        self.machine.run_ms(30)
        return len(self.steps)

    def late_us(self, edges, begins):
        """How long behind the step number begins[n] edge number n came."""
        assert len(edges) == len(begins), (len(edges), begins)
        per_us = CYCLES_PER_US
        return [(cycle - self.steps[begin]) / per_us for (cycle, _), begin in zip(edges, begins)]


def exact(late):
    assert all(0 <= each <= WITHIN_US for each in late), late
    return f"{min(late):.2f} to {max(late):.2f} µs behind the step"


def test_with_the_first_step(make_machine, show):
    """Lines, an arc, chords of another plane in G93, a dwell, from a stand and without one. Each motion's steps are counted once, alone."""
    made = Router(make_machine)
    motions = ["G1X2", "G1X1Y1.5", "G2X3Y3I0J3", "G18G93G2X1Z0I.5K0F60", "G17G94G1X-1F1500", "Y-.5", "X.2", "X.2", "X-3Y-1"]
    begins = [made.marks()]
    for line in motions:
        made.do(line)
        begins.append(made.marks())
    counts = [there - here for here, there in zip(begins, begins[1:])]
    begins = [begins[-1]]
    for count in counts:
        begins.append(begins[-1] + count)
    lines = []
    for number, line in enumerate(motions):
        lines += ["M62P0" if number % 2 == 0 else "M63P0", *(["G4P0.1"] if number == 5 else []), line]
    made.stream(*lines)
    assert made.marks() == begins[-1]
    assert [state for _, state in made.p0] == [1, 0, 1, 0, 1, 0, 1, 0, 1]
    show("M62 and M63 on a Pico", exact(made.late_us(made.p0, begins[:-1])))


def test_behind_a_hold_a_door_and_a_reset(make_machine, show):
    """A hold leaves outputs and what waits; the door switches off until the machine goes on; a reset drops all for good."""
    made = Router(make_machine)
    machine = made.machine
    first = len(made.steps)
    machine.send(b"G1X3\nM62P0\nM63P1\nM62P1\nG1X3\n")
    machine.run_ms(60)
    machine.send(b"!")
    machine.run_ms(400)
    assert 0 < len(made.steps) - first < 960 and not made.p0
    machine.send(b"~")
    machine.settle()
    (late,) = made.late_us(made.p0, [first + 960])
    assert len(made.p1) <= 2
    assert machine.pico.pads.state_of(P0) == 1 and machine.pico.pads.state_of(P1) == 0
    machine.send(b"G1X3\n")
    machine.run_ms(60)
    machine.plant.set_input(0, "door", True)
    machine.run_ms(600)
    assert machine.pico.pads.state_of(P0) == 0 and machine.pico.pads.state_of(P1) == 1
    machine.plant.set_input(0, "door", False)
    machine.send(b"M63P0\nG1X1\n")
    machine.run_ms(50)
    begun = len(made.p0)
    machine.send(b"~")
    machine.run_ms(4000)
    machine.settle()
    assert [state for _, state in made.p0[begun:]] == [1, 0] and machine.pico.pads.state_of(P1) == 0
    (again,) = made.late_us(made.p0[-1:], [len(made.steps) - 320])
    machine.send(b"G1X3\nM63P1\nM62P0\nG1X3\n")
    machine.run_ms(60)
    machine.send(b"\x18")
    machine.run_ms(300)
    assert machine.pico.pads.state_of(P0) == 0 and machine.pico.pads.state_of(P1) == 1, "all off"
    made.do("$X", "G91G1X1F1500")
    machine.settle()
    assert machine.pico.pads.state_of(P0) == 0 and machine.pico.pads.state_of(P1) == 1, "waiting outputs must be dropped"
    show("M62 behind a hold and a door", exact([late, again]))


def test_of_a_stored_job_and_in_check_mode(make_machine, show):
    plain = boards.load("router_3axis")
    made = Router(make_machine, jobs={"language": "grbl"}, links=[{key: link[key] for key in link if key != "lost"} for link in plain["links"]])
    made.do("$C", "M62P0", "G1X1")
    made.ask("$C")
    made.machine.run_ms(300)
    assert not made.p0
    made.do("$X", "G91")
    data = b"G91G1F3000\nX1\nM62P0\n" + b"X.5\nM63P0\nX.5\nM62P0\n" * 6 + b"X.5\n"
    packed = stored_job.pack_job(data)
    made.do("$FS=A,grbl,%d,%08x,%d" % (len(data), stored_job.crc_of(data), len(packed)))
    for at in range(0, len(packed), 54):
        made.do("$F:" + base64.b64encode(packed[at : at + 54]).decode())
    made.do("$FE")
    made.machine.settle()
    first = len(made.steps)
    made.ask("$F=A")
    made.machine.run_until(lambda: b"Job A done" in made.machine.replies_so_far(), 60_000)
    assert len(made.steps) - first == 320 + 160 * 13
    show("M62 of a stored job", exact(made.late_us(made.p0, [first + 320 + 160 * n for n in range(13)])))


@pytest.mark.slow
def test_beside_a_laser(make_machine, show):
    """Each has its own way to its pin."""
    plain = copy.deepcopy(boards.load("router_3axis"))
    made = Router(make_machine, spindle={**plain["spindle"], "pwm": True, "pin": 22, "laser": True, "spin_up_ms": 0, "coolant_ms": 0})
    made.do("M4S100")
    lines = []
    for number in range(12):
        lines += ["M6%dP0" % (2 + number % 2), "G1X.5S%d" % (100 + 50 * number)]
    first = len(made.steps)
    made.stream(*lines)
    made.machine.settle()
    show("M62 beside a laser on a Pico", exact(made.late_us(made.p0, [first + 160 * n for n in range(12)])))
