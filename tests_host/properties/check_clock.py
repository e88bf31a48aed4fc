"""The settings of a chip that a board file may have: its clock, and the pull of its inputs; on a fake chip the order of voltage, clock and look."""

import sys

from boards.plotter_2014 import BOARD as PICO
from boards.plotter_esp32 import BOARD as ESP32
from passo.config.boardfile import CLOCKS_MHZ, BoardError, check

PICO_2 = dict(PICO, chip="rp2350")
CASES = {
    "check_any_start": (
        ("mhz", "choice", 125, 150, 200), ("now_mhz", "choice", 48, 125, 133, 150, 200, 250), ("vsel", 9, 15),
        ("rise_us", 0, 9000),
    ),
    "check_any_number": (("mhz", -1000, 1000),),
}  # fmt: skip
REGULATOR, COUNTER = 0x40064000, 0x40008080  # test_rp2_registers.py has them from the headers
PARSE_MHZ = 133  # RP2040 datasheet: more wants 1.15 V
RAISED, IN_REGULATION = 12, 1 << 12


class FakeChip:
    """Voltage, clock and frequency counter of an RP2040. Too fast for its voltage, it fails here and now."""

    RP2350 = False
    REGULATOR = REGULATOR
    COUNTER = COUNTER

    def __init__(self):
        self.start(125, 11)

    def start(self, mhz, vsel, rise_us=50, takes=True, lies=False, counts=True):
        self.RP2350 = False
        self.mhz, self.said = mhz, mhz
        self.vsel, self.rise_us = vsel, rise_us
        self.steady_at = self.now = 0
        self.takes, self.lies, self.counts = takes, lies, counts
        self.fc = {}
        self.counted_at = None
        self.events = []

    # --- machine

    def freq(self, hz=None):
        if hz is None:
            return self.said * 1_000_000
        self.events.append(("clock", hz // 1_000_000))
        if not self.takes:
            raise ValueError("cannot change frequency")
        self.said = hz // 1_000_000
        if not self.lies:
            self.mhz = self.said
        self.look()

    def look(self):
        if self.mhz > PARSE_MHZ and not self.RP2350:
            assert self.vsel >= RAISED and self.now >= self.steady_at, "too fast for the voltage"

    def __getitem__(self, address):
        if address == REGULATOR and not self.RP2350:
            return self.vsel << 4 | 1 | (IN_REGULATION if self.now >= self.steady_at else 0)
        offset = address - COUNTER
        if offset == 24:
            done = self.counts and self.counted_at is not None and self.now >= self.counted_at
            return 1 << 4 if done else 1 << 8
        assert offset == 28 and self.now >= self.counted_at, "the count is read before it is done"
        self.events.append(("counted",))
        return self.mhz * 1000 << 5 | 7

    def __setitem__(self, address, value):
        if address == REGULATOR and not self.RP2350:
            assert value & ~0x10F0 == 1, "enabled, and nothing else"
            self.events.append(("voltage", value >> 4 & 15))
            self.vsel = value >> 4 & 15
            self.steady_at = self.now + self.rise_us
            self.look()
            return
        self.fc[address - COUNTER] = value
        if address - COUNTER == 20:
            assert self.fc[0] == 12_000 and self.fc[4] == 0 and self.fc[20] == 9
            self.counted_at = self.now + (1 << self.fc[16])

    def sleep_us(self, us):
        self.now += us


class Module:
    pass


def module(**names):
    made = Module()
    for name in names:
        setattr(made, name, names[name])
    return made


fake = FakeChip()


def import_clock():
    """Import the firmware's module on the fake chip; put the modules that it imports back afterwards."""
    fakes = {
        "machine": module(freq=fake.freq, mem32=fake), "time": module(sleep_us=fake.sleep_us), "passo.ports.rp2.chip": fake,
    }  # fmt: skip
    before = {name: sys.modules.get(name) for name in fakes}
    sys.modules.update(fakes)
    try:
        from passo.ports.rp2 import clock
    finally:
        for name in before:
            if before[name] is None:
                del sys.modules[name]
            else:
                sys.modules[name] = before[name]
    return clock


clock = import_clock()


def refusal(mhz):
    try:
        clock.set_mhz(mhz)
    except RuntimeError as error:
        return str(error)
    raise AssertionError("it says nothing")


def check_any_start(mhz, now_mhz, vsel, rise_us):
    """From a reset or a soft reset, with any clock and voltage that were there before."""
    if now_mhz > PARSE_MHZ:
        vsel = max(vsel, RAISED)
    fake.start(now_mhz, vsel, rise_us)
    clock.set_mhz(mhz)
    assert fake.mhz == mhz and fake.vsel >= vsel
    wanted = []
    if mhz > PARSE_MHZ and vsel < RAISED:
        wanted.append(("voltage", RAISED))
    if now_mhz != mhz:
        wanted.append(("clock", mhz))
    assert fake.events == wanted + [("counted",)], "voltage, clock, look"
    assert wanted[:1] != [("voltage", RAISED)] or fake.now >= 1000, "it is given time to settle"


def check_a_voltage_that_does_not_rise():
    fake.start(125, 11, rise_us=1_000_000)
    assert "core voltage" in refusal(200)
    assert fake.mhz == 125 and fake.events == [("voltage", RAISED)], "the clock is left as it was"


def check_a_clock_that_cannot_be_set():
    fake.start(125, 11, takes=False)
    assert refusal(200) == "clock_mhz: the clock is 125000 kHz, not 200 MHz"


def check_a_clock_that_is_not_what_was_said():
    fake.start(125, 11, lies=True)
    assert refusal(200) == "clock_mhz: the clock is 125000 kHz, not 200 MHz"


def check_a_counter_that_never_ends():
    fake.start(125, 11, counts=False)
    assert refusal(125) == "clock_mhz: the chip's frequency counter does not answer"


def check_an_rp2350_keeps_its_voltage():
    fake.start(125, 11)
    fake.RP2350 = True
    clock.set_mhz(150)
    assert fake.events == [("clock", 150), ("counted",)]


# --- the board file


def asked(board, mhz):
    """The clock of a board file that asks for `mhz`, or the refusal."""
    try:
        return check(dict(board, clock_mhz=mhz))["clock_mhz"]
    except BoardError as error:
        return str(error)


def check_what_is_not_said():
    assert check(PICO)["clock_mhz"] == 125 and check(PICO_2)["clock_mhz"] == 150 and check(ESP32)["clock_mhz"] == 0


def check_any_number(mhz):
    for board in (PICO, PICO_2, ESP32):
        clocks = CLOCKS_MHZ.get(board["chip"], ())
        found = asked(board, mhz)
        if mhz == 0:
            assert found == (clocks[0] if clocks else 0)
        elif mhz in clocks:
            assert found == mhz
        else:
            assert found.startswith("clock_mhz: "), found


def check_refusals_name_what_would_be_right():
    assert asked(PICO, 133) == "clock_mhz: an rp2040 runs at 125 or 150 or 200 here, not 133"
    assert asked(PICO_2, 200) == "clock_mhz: an rp2350 runs at 150 here, not 200"
    assert asked(ESP32, 240) == "clock_mhz: the clock of an esp32 is not set here; leave it out"
    assert asked(PICO, "200") == "clock_mhz: '200' is no int"


def check_every_clock_is_whole_ticks():
    for clocks in CLOCKS_MHZ.values():
        for mhz in clocks:
            assert mhz * 1_000_000 % 12_500_000 == 0


def check_an_inputs_own_pull_down():
    """RP2350-E9: a pin that was high may stay so. Bits of registers have no such pull, and other chips not this fault."""
    pulled = {"name": "stall", "pin": 20, "active": 1, "pull": "down"}
    for board, fault in ((PICO, False), (PICO_2, True)):
        for item in (pulled, dict(pulled, pull="none"), dict(pulled, pull="up")):
            try:
                check(dict(board, inputs=list(board["inputs"]) + [item]))
                said = ""
            except BoardError as error:
                said = str(error)
            assert said.startswith("input stall: an rp2350 may hold a pin up") == (fault and item is pulled), said
