"""TMC2130 or TMC5160 drivers on SPI, bit by bit: shift registers of 40 bits, with a CS each or in chains, and faults.

    drivers = SpiDrivers(board["spi_drivers"])
    drivers.exchange(cs, data)          # as a board's line sees them
    drivers["x"].dead = True            # its supply is off: SDO stays low
    drivers["x"].power_cycle()          # it was gone for a moment
    drivers["x"].registers[0x6F] |= 1 << 25     # DRV_STATUS: overheated

SPI mode 3: bits are taken as the clock rises. As CS rises, each chip takes the last 40 bits; as it falls, the answer to them stands in its
register: a status byte, and the register read or the value written.
"""

A_SGT = 4  # SG_RESULT rises by this with SGT
AT_ZERO = -100  # SG_RESULT with an SGT of 0 and the load at which slipping.py has it 0
_MASK = (1 << 40) - 1
_READABLE = {0x00, 0x01, 0x04, 0x12, 0x6A, 0x6B, 0x6C, 0x6F}
_DEFAULTS = {
    "tmc2130": {0x00: 0, 0x01: 1, 0x04: 0x11000000, 0x6C: 0x000101D5, 0x6F: 0x80000000},
    "tmc5160": {0x00: 0, 0x01: 1, 0x04: 0x30000040, 0x6C: 0x10410150, 0x6F: 0x80000000},
}


class SpiDriver:
    def __init__(self, chip):
        self.chip = chip
        self.dead = False
        self.written = None  # called after each register that is
        self.diag = 1  # which of the two pins is wired
        self.frozen = ()  # registers that keep their value
        self.shift = self.answer = 0
        self.taken = []  # (register, value) of each write
        self.power_cycle()

    def power_cycle(self):
        """Reset all registers, as after a loss of the supply."""
        self.registers = dict(_DEFAULTS[self.chip])
        self.answer = 0
        if self.written:
            self.written()

    @property
    def can_feel_load(self):
        """Whether its DIAG pin may tell: stallGuard2 works in spreadCycle, above the speed of TCOOLTHRS; the pin drives the line if it is a push-pull one."""
        gconf = self.registers[0x00]
        return bool(self.registers.get(0x14, 0)) and not gconf & 4 and gconf >> 7 + self.diag & 1 and gconf >> 12 + self.diag & 1

    def diag_level(self, result):
        """Return the level of the DIAG pin at a load; `result`: that of slipping.py. Changes SG_RESULT."""
        sgt = self.registers.get(0x6D, 0) >> 16 & 0x7F
        result = min(max(round(result) + AT_ZERO + A_SGT * (sgt - 128 if sgt > 63 else sgt), 0), 1023)
        self.registers[0x6F] = self.registers[0x6F] & ~0x010003FF | (not result) << 24 | result
        return bool(self.can_feel_load and not result)

    def begin_exchange(self):
        """CS falls: put the status and the answer into the shift register."""
        state = self.registers[0x01] & 3 | (self.registers[0x6F] >> 31 & 1) << 3
        self.shift = state << 32 | self.answer

    def end_exchange(self):
        """CS rises: carry out the 40 bits of the shift register."""
        register, value = self.shift >> 32 & 0x7F, self.shift & 0xFFFFFFFF
        if self.shift >> 39:
            self.answer = value
            self.taken.append((register, value))
            if register == 0x01:
                value = self.registers[1] & ~value if self.chip == "tmc5160" else self.registers[1]
            if register not in self.frozen:
                self.registers[register] = value
            if self.written:
                self.written()
            return
        self.answer = self.registers.get(register, 0) if register in _READABLE else 0
        if register == 0x01 and self.chip == "tmc2130":
            self.registers[1] = 0

    @property
    def output_bit(self):
        """The level of SDO, the highest bit of the shift register; 0 without a supply."""
        return 0 if self.dead else self.shift >> 39

    def shift_bit(self, bit):
        """Shift a bit in as the clock rises; return the bit that leaves."""
        out = self.output_bit
        self.shift = (self.shift << 1 | bit) & _MASK
        return out


class SpiDrivers:
    def __init__(self, config):
        self._motors = {}
        self.chains = {}  # {cs: drivers, the one at the board's TX first}
        for motor in config["motors"]:
            driver = self._motors[motor["axis"]] = SpiDriver(config["chip"])
            self.chains.setdefault(motor["cs"], []).append(driver)
        self.flips = 0  # bits to come that are wrong
        self.exchanges = 0

    def __getitem__(self, axis):
        return self._motors[axis]

    def set_cs(self, cs, level):
        """Set a CS pin: low begins an exchange, high has the chips take their 40 bits."""
        for driver in self.chains.get(cs, ()):
            if level:
                if not driver.dead:
                    driver.end_exchange()
            else:
                driver.begin_exchange()
        self.exchanges += not level

    def output_level(self, cs):
        """Return the line's level, before the clock rises."""
        chain = self.chains.get(cs)
        return chain[-1].output_bit if chain else 0

    def clock_bit(self, cs, bit):
        """A rising edge of SCK with `bit` on SDI: each chip of the chain hands its highest bit on."""
        for driver in self.chains.get(cs, ()):
            bit = driver.shift_bit(bit)

    def exchange(self, cs, data):
        """Exchange `data` at a CS, highest bit first; returns as many bytes."""
        self.set_cs(cs, 0)
        found = 0
        for each in data:
            for place in range(7, -1, -1):
                found = found << 1 | self.output_level(cs)
                self.clock_bit(cs, each >> place & 1)
        self.set_cs(cs, 1)
        if self.flips:
            self.flips -= 1
            found ^= 1 << 9
        return bytearray(found.to_bytes(len(data), "big"))
