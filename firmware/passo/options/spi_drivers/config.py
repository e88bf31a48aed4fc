"""TMC2130 and TMC5160: datagrams of their SPI, and the registers that a board file's section becomes (datasheets rev. 1.10 and 1.14, 4 and 5).

    data = make_datagram(GSTAT)     # asks for a register
    data = make_datagram(GSTAT, 7)  # writes it

A datagram is an address and 32 bits, highest bit first. The reply meanwhile, a status byte and 32 bits, answers the datagram before: of a
read with the register, of a write with the value written.
"""

from micropython import const

from passo.options.drivers import config as tmc2209
from passo.options.drivers.config import DRV_STATUS, GSTAT, MICROSTEPS, WRITES  # noqa: F401  the registers that both families share; reading GSTAT clears it on a TMC2130

IOIN = const(0x04)  # the chip's version in its high byte
STEPS = const(0x40)  # of it, TMC5160: the pin SD_MODE has the chip take STEP and DIR
VERSIONS = {"tmc2130": 0x11, "tmc5160": 0x30}
BYTES = const(5)


def make_datagram(register, number=None):
    """Return the five bytes that ask for a register, or write `number` to it."""
    if number is None:
        return bytes((register, 0, 0, 0, 0))
    return bytes((register | WRITES, number >> 24 & 255, number >> 16 & 255, number >> 8 & 255, number & 255))


def fault_bits(status):
    """Return DRV_STATUS in the bits of a TMC2209: 1 hot, 2 overheated, 0x3C shorts, 0xC0 open coils."""
    return status >> 26 & 1 | status >> 24 & 2 | status >> 25 & 0xC | (status >> 12 & 3) << 4 | status >> 23 & 0xC0


def current_scale(current_ma, config):
    """Return (CHOPCONF's vsense or GLOBALSCALER, current scale 0 … 31), next below a motor's current in mA RMS; None if it is too much for the
    resistors."""
    mohm = config["sense_mohm"]
    if config["chip"] == "tmc2130":
        return tmc2209.current_scale(current_ma, mohm, 320)
    product = current_ma * mohm * 11585 // 325_000  # 256·32·√2: of both scales
    if product > 8192:
        return None
    for scaled in range(31, 0, -1):
        if product // (scaled + 1) >= (128 if scaled > 15 else 32):  # as the datasheet recommends
            return min(product // (scaled + 1), 256) & 255, scaled
    return 32, 0


def register_rows(motor, config):
    """Return [(register, value)] for a driver of the board file. Only the last two are read back."""
    first, run = current_scale(motor["current_ma"], config)
    hold = run * motor["hold_percent"] // 100
    halvings = MICROSTEPS.index(motor["microsteps"])
    stealth = 4 if motor["stealth"] else 0
    rows = ((0x10, 8 << 16 | run << 8 | hold), (0x11, 20), (0x13, 0))  # IHOLD_IRUN, TPOWERDOWN: 0.4 s, TPWMTHRS
    if config["chip"] == "tmc2130":
        # PWMCONF, GCONF, CHOPCONF. GCONF's small_hysteresis changes nothing here; so no answer of a driver that only hears zeros is all zeros.
        return rows + ((0x70, 0x000401C8), (0x00, 0x4000 | stealth), (0x6C, 0x100100C3 | halvings << 24 | first << 17))
    return ((GSTAT, 7), (0x0B, first)) + rows + ((0x70, 0xC40C001E), (0x00, 8 | stealth), (0x6C, 0x104100C3 | halvings << 24))  # GLOBALSCALER
