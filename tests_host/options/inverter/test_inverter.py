"""The spindle's inverter, played by pymodbus: the frames are its own, the registers those of host_tools/sim/inverter.py."""

import asyncio

import pytest
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ExceptionResponse

from draws import Random

from host_tools import boards
from host_tools.sim.inverter import SimInverter
from host_tools.sim.machine import VirtualMachine
from passo import errors
from passo.options.inverter.errors import ALARM_INVERTER_FAULT, ALARM_INVERTER_GARBLED, ALARM_INVERTER_LATE, ALARM_INVERTER_REFUSED, ALARM_INVERTER_SILENT

pytestmark = pytest.mark.quick

MAKES = ("delta", "yl620", "h100", "nowforever", "teco")
SPINDLE = {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": 0, "coolant_ms": 0}
FAIL_MS = 100 + 3 * (100 + 23 + 5) + 3 * 8  # a period, three time-outs, cycles of 8 ms


class Context:
    """The store of registers, as pymodbus calls it."""

    def __init__(self, inverter):
        self.inverter = inverter

    async def async_setValues(self, device, function, address, values):
        if function == 5:
            values = [0xFF00 if value else 0 for value in values]
        for value in values:
            self.inverter.write_register(function, address, value)
        self.inverter.written[address] = values
        return 0

    async def async_getValues(self, device, function, address, count):
        if address in self.inverter.written and function in (5, 6):
            return [bool(value) if function == 5 else value for value in self.inverter.written[address]]
        return [self.inverter.read_register(function, address + number) for number in range(count)]


class Pymodbus(SimInverter):
    """pymodbus decodes each request and encodes each reply."""

    def __init__(self, config):
        super().__init__(config, lambda: 0.0)
        self.framer = FramerRTU(DecodePDU(True))
        self.context = Context(self)
        self.written = {}
        self.exception = None  # the code that it answers each request with
        self.busy = 0  # or this many with "busy"
        self.spoil = 0  # the number of replies with a wrong CRC
        self.cut = 0  # or end too soon

    def reply_to(self, request):
        used, pdu = self.framer.handleFrame(request, self.address, 0)
        assert used == len(request) and pdu is not None, request.hex()
        if self.exception or self.busy:
            reply = ExceptionResponse(pdu.function_code, self.exception or 6)
            self.busy = max(0, self.busy - 1)
        else:
            reply = asyncio.run(pdu.datastore_update(self.context, self.address))
        reply.dev_id = self.address
        frame = self.framer.buildFrame(reply)
        if self.spoil:
            self.spoil -= 1
            frame = frame[:-1] + bytes((frame[-1] ^ 0x10,))
        if self.cut:
            self.cut -= 1
            frame = frame[:3]
        return frame


class Spindle:
    def __init__(self, make="delta", **keys):
        board = boards.load("router_3axis")
        board["inverter"] = {"make": make, "port": "uart1", "tx": 20, "rx": 21, **keys}
        board["spindle"] = SPINDLE
        self.inverter = Pymodbus({"make": make, "address": 1})
        self.machine = VirtualMachine(board, start=(3000, 2500, -1800), trace=None, inverter=self.inverter)
        self.inverter.now_ms = self.machine.now_ms
        self.run(50)
        self.machine.send(b"$X\n")
        self.run(50)
        self.machine.take()

    def run(self, milliseconds):
        self.machine.run_ms(milliseconds)

    def start(self, line=b"M3 S12000"):
        """The spindle comes to its speed; returns how long the answer took, ms."""
        begun = self.machine.now_ms()
        self.machine.take()
        self.machine.send(line + b"\n")
        self.machine.run_until(lambda: b"ok" in self.machine.replies_so_far(), 20_000)
        return self.machine.now_ms() - begun

    @property
    def state(self):
        return self.machine.app.controller.machine

    @property
    def x(self):
        return self.machine.plant.position[0]

    def tool(self):
        return self.machine.app.controller.queue.lit()

    def failed(self, alarm, since_ms, limit_ms=FAIL_MS):
        """The alarm comes in time; axes at a stand, position kept, tool off, the inverter told to stop or silent."""
        self.machine.run_until(lambda: self.state.alarm, limit_ms - (self.machine.now_ms() - since_ms))
        assert self.state.alarm == alarm
        self.run(400)
        place = list(self.machine.plant.position)
        assert not self.tool() and self.machine.app.controller.queue.still()
        assert list(self.machine.app.controller.position())[0] + 3000 == place[0]
        self.machine.take()
        self.machine.send(b"G1X50F1000\n")
        self.run(300)
        assert b"error:9" in self.machine.replies_so_far() and list(self.machine.plant.position) == place
        assert self.inverter.silent or self.inverter.way == 0


def cut(spindle, length_mm=60):
    spindle.machine.send(b"G1X%dF1000\n" % length_mm)
    at = spindle.x
    spindle.run(300)
    assert spindle.x > at and spindle.tool()


@pytest.mark.parametrize("make", MAKES)
def test_start_speed_and_stop(make):
    spindle = Spindle(make)
    inverter = spindle.inverter
    took = spindle.start()
    assert inverter.way == 3 and inverter.asked_hz == 200 and inverter.hz >= 190
    assert 950 <= took <= 1300, "200 Hz at 200 Hz/s, less 5 %"
    spindle.start(b"S18000")
    assert inverter.hz >= 285
    cut(spindle, 5)
    spindle.machine.settle()
    begun = spindle.machine.now_ms()
    spindle.start(b"M5")
    spindle.machine.run_until(lambda: inverter.way == 0, 60 + begun - spindle.machine.now_ms())
    assert not spindle.tool() and not spindle.state.alarm


@pytest.mark.parametrize("make", MAKES)
def test_the_other_way_round_only_from_a_standstill(make):
    spindle = Spindle(make)
    inverter = spindle.inverter
    spindle.start()
    turned = []
    put = inverter.write_register

    def watch(function, register, value):
        before = inverter.way
        put(function, register, value)
        if inverter.way == 4 != before:
            turned.append(inverter.hz)

    inverter.write_register = watch
    assert spindle.start(b"M4") >= 1900, "down and up again"
    assert inverter.way == 4 and inverter.hz >= 190 and turned[0] <= 2


def test_nothing_moves_before_it_is_at_speed():
    spindle = Spindle()
    at = spindle.x
    spindle.machine.send(b"M3 S24000\nG1X10F1000\n")
    while spindle.inverter.hz < 380:
        spindle.machine.cycle()
        assert spindle.x == at
    spindle.run(500)
    assert spindle.x > at


def test_the_door_and_its_end():
    spindle = Spindle()
    spindle.start()
    cut(spindle)
    spindle.machine.send(b"\x84")
    spindle.run(500)
    assert spindle.inverter.way == 0 and not spindle.tool()
    spindle.run(1500)
    at = spindle.x
    spindle.machine.send(b"~")
    while spindle.inverter.hz < 190:
        spindle.machine.cycle()
        assert spindle.x == at
    spindle.run(500)
    assert spindle.x > at and spindle.inverter.way == 3


def test_a_reset_stops_it():
    for data in (b"\x18", b"\x84"):
        spindle = Spindle()
        spindle.start()
        cut(spindle)
        begun = spindle.machine.now_ms()
        spindle.machine.send(data)
        spindle.machine.run_until(lambda: spindle.inverter.way == 0, 600)
        if data == b"\x18":
            assert spindle.machine.now_ms() - begun <= 150, "a request under way, then this one"


def test_speed_override():
    spindle = Spindle()
    spindle.start()
    spindle.machine.send(b"\x9a" * 3)
    spindle.run(1000)
    assert spindle.inverter.asked_hz == 260 and not spindle.state.alarm


# --- failures, each in the middle of a cut


@pytest.mark.parametrize("make", MAKES)
def test_silence(make):
    spindle = Spindle(make)
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.silent = True
    spindle.failed(ALARM_INVERTER_SILENT, begun)
    assert spindle.inverter.way == 3, "it hears nothing: the tool's pin has to cut its enable"
    spindle.inverter.silent = False
    spindle.run(1100)
    assert spindle.inverter.way == 0, "stop is sent until it is confirmed"


@pytest.mark.parametrize("make", MAKES)
def test_wrong_crc(make):
    spindle = Spindle(make)
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.spoil = 100
    spindle.failed(ALARM_INVERTER_GARBLED, begun)


@pytest.mark.parametrize("make", MAKES)
@pytest.mark.parametrize("reply_ms", [140, 180, 240, 300])
def test_replies_that_are_always_late(make, reply_ms):
    """One to a question for the speed is no number of a fault, an echo no garbled reply."""
    spindle = Spindle(make)
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.reply_ms = reply_ms
    spindle.failed(ALARM_INVERTER_LATE, begun, FAIL_MS + 131)


@pytest.mark.parametrize("make", MAKES)
def test_two_late_replies_are_forgiven_whatever_they_say(make):
    spindle = Spindle(make)
    inverter = spindle.inverter
    spindle.start()
    for reply_ms in (124, 126, 131, 150, 200, 240):
        for at in range(4):  # of each kind of request
            until = len(inverter.requests) + at
            spindle.machine.run_until(lambda until=until: len(inverter.requests) >= until, 2000)
            inverter.reply_ms, until = reply_ms, len(inverter.requests) + 1
            spindle.machine.run_until(lambda until=until: len(inverter.requests) >= until, 2000)
            inverter.reply_ms = 5
            spindle.run(1200)
            assert not spindle.state.alarm, (reply_ms, at)
    if inverter.make["fault"]:
        inverter.fault = 7
        spindle.machine.run_until(lambda: spindle.state.alarm, 400)
        assert spindle.state.alarm == ALARM_INVERTER_FAULT


@pytest.mark.parametrize("make", MAKES)
def test_one_reply_in_five_is_lost_or_late(make):
    """Three in a row end the cut; never as a fault, a speed or a garbled reply."""
    random, spindle = Random(1), Spindle(make)
    inverter = spindle.inverter
    write = inverter.write

    def noisy(data):
        inverter.silent, inverter.reply_ms = random.between(0, 9) == 0, random.choice((5, 5, 5, 5, 5, 5, 5, 50, 110, 128, 200))
        write(data)

    inverter.write = noisy
    alarms = []
    for _again in range(4):
        spindle.machine.send(b"$X\nM3S%d\n" % random.choice((9000, 12000, 18000)))
        spindle.run(4000)
        alarms.append(spindle.state.alarm)
        spindle.machine.send(b"\x18")
        spindle.run(2500)
    assert set(alarms) <= {0, ALARM_INVERTER_LATE, ALARM_INVERTER_SILENT}, alarms


def test_cut_replies():
    spindle = Spindle()
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.cut = 100
    spindle.failed(ALARM_INVERTER_GARBLED, begun)


@pytest.mark.parametrize("make", MAKES)
def test_two_bad_replies_are_forgiven(make):
    spindle = Spindle(make)
    spindle.start()
    for name in ("spoil", "cut"):
        setattr(spindle.inverter, name, 2)
        spindle.run(1000)
        assert not spindle.state.alarm and getattr(spindle.inverter, name) == 0


@pytest.mark.parametrize("make", ("delta", "nowforever", "teco"))
def test_a_fault(make):
    spindle = Spindle(make)
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.fault = 7
    spindle.failed(ALARM_INVERTER_FAULT, begun)
    assert any(entry[2] == "inverter: fault 7" for entry in spindle.state.log.entries)


@pytest.mark.parametrize("make", ("yl620", "h100"))
def test_a_fault_that_shows_in_the_speed_only(make):
    spindle = Spindle(make)
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.fault = 7
    spindle.failed(errors.ALARM_SPINDLE_SPEED, begun, 1500)


def test_an_exception():
    spindle = Spindle()
    spindle.start()
    cut(spindle)
    begun = spindle.machine.now_ms()
    spindle.inverter.exception = 2
    spindle.machine.run_until(lambda: spindle.state.alarm, 200)
    spindle.inverter.exception = None
    spindle.failed(ALARM_INVERTER_REFUSED, begun)


def test_a_busy_device_is_asked_again():
    spindle = Spindle()
    spindle.start()
    spindle.inverter.busy = 2
    spindle.run(1000)
    assert not spindle.state.alarm and not spindle.inverter.busy


def test_a_spindle_that_does_not_come_to_speed():
    spindle = Spindle(spin_up_ms=3000)
    at = spindle.x
    spindle.machine.send(b"M3 S24000\nG1X10F1000\n")
    begun = spindle.machine.now_ms()
    while not spindle.state.alarm:
        spindle.inverter.hz = min(spindle.inverter.hz, 150)
        spindle.machine.cycle()
    assert spindle.x == at and 2900 <= spindle.machine.now_ms() - begun <= 3200
    spindle.failed(errors.ALARM_SPINDLE_SPEED, begun, 3500)


def test_silence_from_the_start():
    spindle = Spindle()
    spindle.inverter.silent = True
    spindle.run(5000)
    assert not spindle.state.alarm
    spindle.machine.send(b"M3 S12000\n")
    spindle.failed(ALARM_INVERTER_SILENT, spindle.machine.now_ms(), FAIL_MS + 100)
    spindle.inverter.silent = False
    spindle.run(1200)
    spindle.machine.send(b"$X\n")
    spindle.run(100)
    spindle.start()
    cut(spindle)
