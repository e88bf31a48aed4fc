"""A laser on the emulated Pico: the times at which its tool's pin is high, and the duty of its PWM.

rp2040py models the PWM slices: counter, wrap, compare values that count from the next wrap on, and the pins. The tests read the firmware's writes to the
compare register, and once the pin itself.
"""

from functools import lru_cache

import pytest
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.rig import Rig
from test_pico_firmware import TURN, with_fault

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("laser")]
CYCLES_PER_MS = 1000 * CYCLES_PER_US
BOARD = "laser_xy"
STEPS_MM = 80
WITHIN_MS = 0.01  # from a step to its duty, or back, while enough words lie ahead
_CC = 0x0C
_STOP = 15
_STEP, _DIR, _TOOL, _PWM, _ENABLE = 2, 4, 6, 7, 14
_HALF_RAPIDS = b"\x96"  # they bring about the faults below


class Laser:
    """laser_xy, or another board's laser, booted and unlocked. duty: [(cycle, thousandths)] as written; steps: cycles at which X steps."""

    def __init__(self, uf2, files=None, board=BOARD):  # noqa: F811
        board = boards.load(board)
        if files is None:
            stop = {"name": "stop", "pin": _STOP, "active": 0, "pull": "up", "halt": True}
            board = {**board, "inputs": [*board["inputs"], stop]}
        self.machine = EmulatedMachine(board, files, trace=None, uf2=uf2).boot()
        self.slice = self.machine.pico.chip.pwm.channels[_PWM // 2]
        self.duty = []
        stock = self.slice.write_register

        def write(offset, value):
            stock(offset, value)
            if offset == _CC and self.value() != (self.duty[-1][1] if self.duty else 0):
                self.duty.append((self.machine.pico.cycle, self.value()))

        self.slice.write_register = write
        self.machine.run_until(lambda: b"unlock" in self.machine.replies_so_far(), 5000)
        self.steps = self.machine.pico.record_edges(_STEP)
        self.tool = self.machine.pico.record_edges(_TOOL)
        self.say("$X", "G21G91F3000")

    def value(self):
        """The duty that is set, in thousandths."""
        return round((self.slice.cc >> 16) * 1000 / (self.slice.top + 1))

    def say(self, *lines):
        """Have lines answered."""
        self.machine.take()
        self.machine.send("".join(line + "\n" for line in lines).encode())
        self.machine.run_until(lambda: self.machine.replies_so_far().count(b"ok") >= len(lines), 3000)

    def settle(self):
        """Until no step has come for a while."""
        count = -1
        while count != len(self.steps):
            count = len(self.steps)
            self.machine.run_ms(30)

    def lit(self):
        return self.machine.pico.pads.state_of(_TOOL)

    def dark(self):
        return not self.lit() and self.value() == 0

    def places(self):
        """[(cycle, steps made by then)] at each rise of the step's pin."""
        return [cycle for cycle, state in self.steps if state == 1]

    def at(self, steps):
        """Return the cycle of the step that leads from the place `steps`: levels that count from there on begin with it."""
        return self.places()[steps]


@lru_cache
def _booted(uf2):  # noqa: F811
    return Laser(uf2)


@pytest.fixture(scope="session")
def laser(uf2):  # noqa: F811
    return _booted(uf2)


def follows(laser, marks):
    """The duty is as in `marks`, [(cycle, thousandths)], each within WITHIN_MS of its time."""
    assert [value for _, value in laser.duty] == [value for _, value in marks]
    late = [(there - due) / CYCLES_PER_MS for (there, _), (due, _) in zip(laser.duty, marks)]
    assert max(map(abs, late)) <= WITHIN_MS, late
    return late


def test_a_raster_burns_where_it_says(laser, show):
    """At one speed, M3: each dot's power from its first step on, rapids and S0 dark; the tool's pin with the very step."""
    assert laser.dark() and not laser.duty
    pulses = laser.machine.pico.record_edges(_PWM)
    laser.say("M3S0", "G0X1", "G1X.5S500", "X.5S1000", "X.5S0", "X.5S3", "G0X.5", "G1X.5", "X.5S250", "G0X1S0", "M5")
    laser.settle()
    mm = [0, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5]
    powers = [0, 500, 1000, 0, 3, 0, 3, 250, 0]
    marks = [(laser.at(int(at * STEPS_MM)), power) for at, power in zip(mm, powers)][1:]
    late = follows(laser, marks)
    show("the laser's PWM follows its steps", f"within {max(map(abs, late)) * 1000:.1f} µs")
    switched = [laser.at(int(at * STEPS_MM)) for at in (1, 2, 2.5, 3, 3.5, 4.5)]
    assert [state for _, state in laser.tool] == [1, 0] * 3
    for (cycle, _), step in zip(laser.tool, switched):
        assert abs(cycle - step) <= CYCLES_PER_US, "the tool's pin changes with the step"
    assert laser.dark()
    on = sum(b[0] - a[0] for a, b in zip(pulses, pulses[1:]) if a[1] == 1)
    want = sum((b[0] - a[0]) * a[1] / 1000 for a, b in zip(laser.duty, laser.duty[1:]))
    assert abs(on - want) < 0.02 * want, "the pin's share of time must be the duty set"


def test_each_of_many_dots_has_its_power(laser):
    """500 dots a second, on a machine that may change its power at any word."""
    powers = [dot * 397 % 999 + 1 for dot in range(40)]
    laser.say("M3S0", "G0X1", "G1X.1S%d" % powers[0], *["X.1S%d" % power for power in powers[1:]], "G0X1", "M5")
    laser.settle()
    follows(laser, [(laser.at(STEPS_MM + 8 * dot), power) for dot, power in enumerate([*powers, 0])])


def test_each_dot_of_a_row_has_its_power(laser):
    """A thousand dots a second, both ways: the power within WITHIN_MS of its step, the tool's pin with the very step."""
    powers = [0 if dot % 5 == 4 else dot * 397 % 999 + 1 for dot in range(32)]
    rows = [":".join([str(power) for power in powers[first : first + 16]]) for first in (0, 16)]
    laser.say("F6000", "M3S0", "G0X2", *["G1X1.6S" + row for row in rows], "G0X3", "X-1", *["G1X-1.6S" + row for row in rows], "G0X-2", "M5", "F3000")
    laser.settle()
    begins = [2 * STEPS_MM + 8 * dot for dot in range(33)]
    back = [6 * STEPS_MM + 8 * (32 + dot) for dot in range(33)]  # behind the way out and back
    marks = [(laser.at(step), power) for steps in (begins, back) for step, power in zip(steps, [*powers, 0])]
    changes = [mark for before, mark in zip([(0, 0), *marks], marks) if mark[1] != before[1]]
    follows(laser, changes)
    switches = [(cycle, int(power > 0)) for cycle, power in changes]
    switches = [mark for before, mark in zip([(0, 0), *switches], switches) if mark[1] != before[1]]
    assert [state for _, state in laser.tool] == [state for _, state in switches]
    for (cycle, _), (step, _) in zip(laser.tool, switches):
        assert abs(cycle - step) <= CYCLES_PER_US


def test_power_follows_the_speed_and_is_dark_at_a_stand(laser):
    laser.say("M4S800", "G1X6")
    laser.settle()
    top = max(value for _, value in laser.duty)
    peak = [value for _, value in laser.duty].index(top)
    rising = [value for _, value in laser.duty[: peak + 1]]
    falling = [value for _, value in laser.duty[peak:]]
    assert top == 800 and rising == sorted(rising) and falling == sorted(falling, reverse=True)
    assert len(rising) > 8 and len(falling) > 8 and laser.dark()
    last = laser.at(6 * STEPS_MM - 1)  # its interval lasts 4 ms
    assert laser.duty[-1][0] - last < 8 * CYCLES_PER_MS
    assert max(value for cycle, value in laser.duty if cycle > last) < 150
    laser.say("G1X1S300", "G1X-1S600", "M5")
    laser.settle()
    assert laser.dark() and max(value for _, value in laser.duty[-30:]) <= 600


@pytest.mark.slow
def test_a_hold_is_dark_and_goes_on_as_it_was(laser):
    for mode, most in ("M3", 400), ("M4", 400):
        laser.say(mode + "S400", "G1X15")  # long enough for a collection of garbage on the way
        laser.machine.run_ms(90)
        assert laser.lit() and laser.value() == most
        laser.machine.send(b"!")
        laser.machine.run_ms(150)
        assert laser.dark(), mode
        laser.machine.run_ms(100)
        assert laser.dark(), mode
        laser.machine.send(b"~")
        laser.machine.run_ms(80)
        assert laser.lit() and laser.value() == most
        laser.settle()
        laser.say("M5")
        laser.machine.run_ms(10)
        assert laser.dark()
    assert len(laser.places()) == 30 * STEPS_MM


@pytest.mark.parametrize("how", ["reset", "door", "limit"])
def test_it_is_dark_at_once(laser, how):
    """In the middle of dots, the next ones queued: nothing of them is seen any more."""
    if how == "limit":
        laser.machine.pico.drive_pin(9, 0)
        laser.say("$21=1")
    laser.say("M3S900", *["G1X1S%d" % (100 + 7 * dot) for dot in range(8)])
    laser.machine.run_ms(60)
    assert laser.lit() and laser.value() > 0
    begun = laser.machine.pico.cycle
    if how == "reset":
        laser.machine.send(b"\x18")
    else:
        laser.machine.pico.drive_pin(13 if how == "door" else 9, 1)
    laser.machine.run_until(laser.dark, 200)
    took_ms = (laser.machine.pico.cycle - begun) / CYCLES_PER_MS
    assert took_ms < (60 if how == "door" else 20), took_ms
    laser.machine.run_ms(100)
    assert laser.dark() and laser.duty[-1][0] - begun <= took_ms * CYCLES_PER_MS
    said = {"reset": b"ALARM:3", "door": b"Door", "limit": b"ALARM:1"}[how]
    assert said in laser.machine.replies_so_far()


def test_a_beam_that_stands_changes_at_once(laser):
    """M3 burns on at a stand; S alone, M5 and the override count there and then."""
    laser.say("M3S500", "G1X1")
    laser.settle()
    assert laser.lit() and laser.value() == 500
    laser.say("S200")
    laser.machine.run_ms(8)
    assert laser.lit() and laser.value() == 200
    laser.machine.send(b"\x9a")
    laser.machine.run_ms(15)
    assert laser.lit() and laser.value() == 220
    laser.say("G1X0S0")
    laser.machine.run_ms(8)
    assert laser.dark()
    laser.say("G1X0S700")
    laser.machine.run_until(laser.lit, 5)
    laser.machine.run_ms(8)
    assert laser.lit() and laser.value() == 770
    laser.say("M5")
    laser.machine.run_ms(8)
    assert laser.dark()


def test_an_override_counts_once(laser):
    """Words handed over already may still have the old power; once the new one shows, it stays."""
    laser.say("M3S500", "G1X10")
    laser.machine.run_ms(60)

    def shown(phase):
        laser.machine.run_ms(phase / 4)
        known = len(laser.duty)
        laser.machine.send(b"\x9a")
        laser.machine.run_ms(40)
        return [value for _, value in laser.duty[known:]]

    for phase in range(8):
        assert on_a_copy(lambda: shown(phase)) == [550], phase


@pytest.mark.slow
def test_an_override_amid_dots_counts_once(laser):
    powers = [300 + 400 * (dot & 1) + dot for dot in range(40)]
    old, new = powers, [round(power * 11 / 10) for power in powers]
    laser.say("M3S0", "G0X1", *["G1X.2S%d" % power for power in powers[:12]])
    laser.machine.run_until(laser.lit, 300)

    def shown(phase):
        laser.machine.run_ms(phase / 2)
        seen = laser.value()
        laser.machine.send(b"\x9a")
        laser.say(*["G1X.2S%d" % power for power in powers[12:]], "G0X1", "M5")
        laser.settle()
        return seen, [value for _, value in laser.duty]

    wanted = [old[:at] + new[at - again :] + [0] for at in range(1, 40) for again in (0, 1)]
    for phase in range(8):
        seen, values = on_a_copy(lambda: shown(phase))
        assert values in wanted, (phase, values)
        assert seen in old and values.index(seen) + 8 > [value == power for value, power in zip(values, old)].index(False)


def test_a_halt_stays_dark(laser):
    """At any moment of the interrupt that feeds: the power that it was about to show is not shown any more."""
    laser.say("M3S900", "G1X20")
    laser.machine.run_ms(80)
    assert laser.lit() and laser.value() == 900

    def shown(phase):
        laser.machine.run_ms(phase / 25)
        known = len(laser.duty)
        laser.machine.pico.drive_pin(_STOP, 0)
        laser.machine.run_ms(4 if phase % 5 else 20)
        return [value for _, value in laser.duty[known:]], laser.lit()

    for phase in range(50):  # the interrupt comes every 2 ms; the work that it must drop takes some 40 µs
        assert on_a_copy(lambda: shown(phase)) == ([0], 0), phase


PLAY = """
port.close()
ring = app.ring
def play(word):
    ring.words[ring.head & ring.mask] = word
    ring.head += 1
    player.start()
"""
MS_STEP = 12_500 << 5 | 1  # X steps, and a millisecond passes


@pytest.mark.slow
def test_a_chain_under_way_is_not_taken_for_one_that_rests(uf2):  # noqa: F811
    """A run handed over in the moment in which A has ended the one before it, and D has not: A must not be given it twice.

    D is held here. As append() looks where the chain stands (the third time that it reads C's address), the chain takes
    up the new run: A is done with its single word at once, and D has its turn again, but no time.
    """
    board = boards.load(BOARD)
    rig = Rig({**board, "links": board["links"][:1]}, uf2)
    rig.pico.exec(PLAY)
    channels = rig.pico.chip.dma.channels
    (d,) = [channel for channel in channels if channel.read_uint32(4) >> 16 == 0x4005]
    b = channels[d._chain_to]
    c = channels[b._chain_to]
    (a,) = [channel for channel in channels if channel._chain_to == d.index and channel is not d]
    let, read = d.schedule_transfer, c.read_uint32
    waiting, looks = [], []
    d.schedule_transfer = lambda: waiting.append(True)
    rig.pico.exec(f"play({MS_STEP})")
    assert waiting, "A has ended, and D is about to begin"

    def look(offset):
        if offset == 0:
            looks.append(True)
            if len(looks) == 3:
                stock = [channel.schedule_transfer for channel in (a, b, c)]
                for channel in (a, b, c):
                    channel.schedule_transfer = channel.transfer
                d.transfer()
                for channel, schedule in zip((a, b, c), stock):
                    channel.schedule_transfer = schedule
        return read(offset)

    c.read_uint32 = look
    rig.pico.exec(f"play({MS_STEP})")
    assert len(looks) >= 3 and len(waiting) == 2
    d.schedule_transfer = let
    let()
    rig.pico.run(5000)
    assert len([state for _, state in rig.step_edges[0] if state]) == 2 and rig.pico.exec("print(player.words_played())") == "2\r\n"


def burning(uf2, *fault):  # noqa: F811
    laser = Laser(uf2, with_fault(*fault, BOARD))
    laser.say("M3S500", "G1X100")
    laser.machine.run_ms(100)
    assert laser.lit() and laser.value() == 500
    laser.machine.send(_HALF_RAPIDS)
    return laser


@pytest.mark.slow
def test_what_goes_wrong_where_words_are_made_leaves_it_dark(uf2):  # noqa: F811
    """The interrupt that feeds halts at once; the main loop makes all else safe and leaves a report."""
    fault = "        if self.planner.percent[1] != self.planner.percent[0]:\n            raise ValueError('on purpose')\n"
    laser = burning(uf2, "passo/steps/feeder.py", "        state[FEED_DRY] = 0\n", fault)
    laser.machine.run_until(laser.dark, 10)
    made = len(laser.steps)
    laser.machine.run_ms(300)
    assert laser.dark() and laser.machine.pico.pads.state_of(_ENABLE) == 1 and len(laser.steps) == made
    assert b"ValueError: on purpose" in laser.machine.pico.files()["crash.txt"]


@pytest.mark.slow
def test_it_does_not_burn_on_where_a_hang_has_brought_it_to_a_stand(uf2):  # noqa: F811
    fault = "        while self.controller.machine.overrides[1] == 50:\n            pass\n"
    laser = burning(uf2, "passo/app.py", TURN, fault)
    laser.machine.run_ms(280)
    made = len(laser.steps)
    laser.machine.run_ms(400)
    assert laser.value() == 0 and len(laser.steps) == made, "long before the watchdog"
