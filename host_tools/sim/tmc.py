"""TMC2209 drivers on one UART wire, as the board's serial line sees them: telegrams, registers, and faults.

    drivers = SimDrivers(board["drivers"], lambda: port.now / 12_500)
    lines["drivers"] = drivers
    drivers["x"].dead = True            # its wire is cut
    drivers["x"].address = 2            # its jumpers are set wrong
    drivers["x"].power_cycle()          # its supply was gone for a moment
    drivers["x"].status |= 1 << 1       # DRV_STATUS: overheated

A telegram with a wrong CRC is ignored. The wire gives the sender's bytes back, `echo`.
"""

CLOCKS = 8  # bits that a reply comes behind its request, at least
_DEFAULTS = {0x00: 0x141, 0x01: 1, 0x02: 0, 0x06: 0x21000000, 0x6C: 0x10000053, 0x6F: 0x80000000}
_READABLE = (0x00, 0x01, 0x02, 0x06, 0x6C, 0x6F)


def crc8(data):
    """Return the CRC of a telegram, bit by bit, as a shift register has it: x⁸ + x² + x + 1, each byte's lowest bit first (TMC2209 datasheet, 4.2)."""
    register = [0] * 8
    for byte in data:
        for bit in range(8):
            into = register[7] ^ (byte >> bit & 1)
            register = [into, register[0] ^ into, register[1] ^ into, *register[2:7]]
    return sum(bit << number for number, bit in enumerate(register))


class SimDriver:
    def __init__(self, address):
        self.address = address
        self.dead = False
        self.frozen = ()  # registers that keep their value
        self.written = None  # called after each register that is
        self.power_cycle()

    def power_cycle(self):
        """Reset all registers, as after a loss of the supply."""
        self.registers = dict(_DEFAULTS)
        if self.written:
            self.written()

    @property
    def can_feel_load(self):
        """True if StallGuard works: TCOOLTHRS is set, and the chopper is StealthChop."""
        return bool(self.registers.get(0x14, 0)) and not self.registers[0x00] & 4

    def diag_level(self, result):
        """Return the level of DIAG with an SG_RESULT."""
        return self.can_feel_load and max(0, result) <= 2 * self.registers.get(0x40, 0)

    @property
    def status(self):
        return self.registers[0x6F]

    @status.setter
    def status(self, value):
        self.registers[0x6F] = value

    def take_telegram(self, telegram):
        """Carry out a telegram; return the reply, or b""."""
        register = telegram[2] & 0x7F
        if telegram[2] & 0x80:
            value = int.from_bytes(telegram[3:7], "big")
            if register == 0x01:
                value = self.registers[1] & ~value  # ones are cleared
            if register not in self.frozen:
                self.registers[register] = value
            self.registers[0x02] = (self.registers[0x02] + 1) & 255
            if self.written:
                self.written()
            return b""
        value = self.registers[register] if register in _READABLE else 0
        body = bytes((5, 0xFF, register)) + value.to_bytes(4, "big")
        return body + bytes((crc8(body),))


class SimDrivers:
    def __init__(self, config, now_ms):
        self._motors = {motor["axis"]: SimDriver(motor["address"]) for motor in config["motors"]}
        self._now_ms = now_ms
        self._bit_ms = 1000 / config["baud"]
        self._coming = bytearray()
        self._due = []  # (ms, bytes)
        self.echo = True
        self.garbles = 0  # replies to come that have a wrong bit

    def __getitem__(self, axis):
        return self._motors[axis]

    # --- the line

    def write(self, data):
        """Take bytes of the board. Echo and replies can be read after the time that they take on the wire."""
        if self.echo:
            self._due.append((self._now_ms() + len(data) * 10 * self._bit_ms, bytes(data)))
        for reply in self.replies_to(data):
            self._due.append((self._now_ms() + ((len(data) + 8) * 10 + CLOCKS) * self._bit_ms, reply))

    def replies_to(self, data):
        """Return the replies to the telegrams that these bytes complete."""
        self._coming += data
        replies = []
        while len(self._coming) >= 4:
            if self._coming[0] != 5:
                del self._coming[0]
                continue
            size = 8 if self._coming[2] & 0x80 else 4
            if len(self._coming) < size:
                break
            telegram = bytes(self._coming[:size])
            del self._coming[:size]
            if crc8(telegram[:-1]) == telegram[-1]:
                replies += self._answer_telegram(telegram)
        return replies

    def _answer_telegram(self, telegram):
        """Return the replies to a telegram, [bytes]: two different ones become their bitwise AND, and the next `garbles` have a bit flipped."""
        heard = [motor.take_telegram(telegram) for motor in self._motors.values() if not motor.dead and motor.address == telegram[1]]
        found = [reply for reply in heard if reply]
        if len(found) > 1:  # two speak at once
            found = [bytes(a & b for a, b in zip(*found))] if found[0] != found[1] else found[:1]
        if found and self.garbles:
            self.garbles -= 1
            found = [bytes((*found[0][:4], found[0][4] ^ 8, *found[0][5:]))]
        return found

    def read(self):
        """Return the bytes that have come by now."""
        data = b""
        while self._due and self._due[0][0] <= self._now_ms():
            data += self._due.pop(0)[1]
        return data

    def any(self):
        """Return 0: the firmware waits for replies by the clock."""
        return 0
