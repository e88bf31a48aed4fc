"""TMC2209 and TMC2226: telegrams of their UART, and the registers that a board file's section becomes (datasheet rev. 1.09, 4 and 5).

    make_telegram(0, GSTAT)         # asks driver 0 for a register: four bytes
    make_telegram(0, GSTAT, 7)      # writes it: eight
    found = reply_value(reply, register)    # of the eight bytes of a reply; None if they are not whole

Bytes go on one wire, low bit first, so a sender that hears the wire hears itself.
"""

from micropython import const

GCONF = const(0x00)
GSTAT = const(0x01)
IFCNT = const(0x02)  # telegrams taken, modulo 256
SLAVECONF = const(0x03)
IOIN = const(0x06)  # the chip's version in its high byte
IHOLD_IRUN = const(0x10)
TPOWERDOWN = const(0x11)
TPWMTHRS = const(0x13)
CHOPCONF = const(0x6C)
DRV_STATUS = const(0x6F)

VERSION = const(0x21)
RESET = const(1)  # of GSTAT: it has been reset, its registers with it
FAILED = const(2)  # it has switched itself off: overheated, or a short
UNDERVOLTAGE = const(4)  # of its charge pump
WARNED = const(1)  # of DRV_STATUS: 120 °C
OVERHEATED = const(2)
SHORTED = const(0x3C)
OPEN = const(0xC0)
MASTER = const(0xFF)  # the address in replies
_SYNC = const(5)
WRITES = const(0x80)
MICROSTEPS = (256, 128, 64, 32, 16, 8, 4, 2, 1)  # by MRES


def telegram_crc(data):
    """Return the CRC-8 of a telegram, polynomial 7, low bits first (datasheet TMC2209 rev. 1.09, 4.2)."""
    found = 0
    for byte in data:
        for _ in range(8):
            found = found << 1 & 0xFF ^ (7 if (found >> 7 ^ byte) & 1 else 0)
            byte >>= 1
    return found


def make_telegram(address, register, number=None):
    """Return the bytes that ask driver `address` for a register, or write `number` to it."""
    data = bytearray((_SYNC, address, register))
    if number is not None:
        data[2] |= WRITES
        for shift in (24, 16, 8, 0):
            data.append(number >> shift & 0xFF)
    data.append(telegram_crc(data))
    return bytes(data)


def reply_value(reply, register):
    """Return the register's 32 bits in a reply of eight bytes; None if it is not whole, or of another register."""
    if len(reply) != 8 or reply[0] != _SYNC or reply[1] != MASTER or reply[2] != register or telegram_crc(reply[:7]) != reply[7]:
        return None
    return reply[3] << 24 | reply[4] << 16 | reply[5] << 8 | reply[6]


def current_scale(current_ma, sense_mohm, full_mv=325):
    """Return (vsense, current scale 0 … 31), next below a motor's current in mA RMS; None if that is too much for the resistors. `full_mv`: the
    voltage across them at full scale; with vsense it is 180 (datasheet, 9)."""
    for vsense, most_mv in ((1, 180), (0, full_mv)):
        scaled = current_ma * (sense_mohm + 20) * 45255 // (most_mv * 1_000_000)  # 32·√2
        if scaled <= 32:
            return vsense, max(scaled - 1, 0)
    return None


def register_rows(driver, sense_mohm):
    """Return [(register, value)] for a driver of the board file. Only the last two can be read back."""
    vsense, run = current_scale(driver["current_ma"], sense_mohm)
    hold = run * driver["hold_percent"] // 100
    return (
        (GSTAT, 7),
        (SLAVECONF, 0x200),  # a reply eight bits behind the request
        (IHOLD_IRUN, 8 << 16 | run << 8 | hold),
        (TPOWERDOWN, 20),  # 0.4 s at rest, then the holding current
        (TPWMTHRS, 0),
        (GCONF, 0x1C0 | (0 if driver["stealth"] else 4)),  # registers, not pins, set it up; steps are filtered
        (CHOPCONF, 0x10010053 | MICROSTEPS.index(driver["microsteps"]) << 24 | vsense << 17),  # interpolated to 256
    )
