"""Patch: the chip runs at the clock of its PLL, and checks the core voltage that the clock needs.

rp2040py has no PLL, frequency counter or regulator: it and its UARTs always run at 125 MHz, so baud rates are wrong, because
MicroPython runs them from the USB PLL.

    system = clock_of(chip)
    system.hz, system.cycle_ns
    system.cycle(), system.nanos_at(cycle)      # system clocks since power-on, whatever the clock was meanwhile

The clock changes when clk_sys takes the system PLL's output, or that one changes; on the way there (on the crystal, the
ring oscillator, the USB PLL) it is left at what it was, and a reset puts it to 125 MHz at once. Above 133 MHz with less than
1.15 V, or before the regulator has settled, a chip may do anything: here `fault` is set, and the loops raise it.
"""

from host_tools.emulator.cycles import CYCLE_NS

PARSE_HZ = 125_000_000
_UNRAISED_HZ = 133_000_000  # RP2040 datasheet: more wants 1.15 V
_RAISED = 0b1100
_CRYSTAL_HZ = 12_000_000
_SETTLE_NS = 50_000  # an assumption: the datasheet gives no time
_COUNT_NS = 1000  # of the frequency counter, times 2 to the power of its interval
_ROUNDING = 0.01  # cycles: rounding of floats

_CLOCKS, _SYS_PLL, _USB_PLL = 0x40008, 0x40028, 0x4002C
_SYS_CONTROL, _SYS_DIVIDER, _PERIPHERAL_CONTROL = 0x3C, 0x40, 0x48
_REFERENCE, _INTERVAL, _SOURCE, _STATUS, _RESULT = 0x80, 0x90, 0x94, 0x98, 0x9C
_CLK_SYS, _DONE, _RUNNING = 9, 1 << 4, 1 << 8
_VREG, _IN_REGULATION = 0, 1 << 12
_LOCK = 1 << 31


class Undervolted(Exception):
    """The clock is too fast for the core voltage."""


class Pll:
    """The registers of a PLL, as the bus wants them."""

    _RESET = (1, 0x2D, 0, 0x77000)  # CS, PWR, FBDIV_INT, PRIM

    def __init__(self, changed):
        self._changed = changed
        self.reset()

    def reset(self):
        self._values = list(self._RESET)

    @property
    def hz(self):
        """Its output, Hz; 0 while it is off."""
        control, power, multiplier, dividers = self._values
        after = (dividers >> 16 & 7) * (dividers >> 12 & 7)
        if power & 0x29 or not after:  # PD, POSTDIVPD, VCOPD
            return 0
        return _CRYSTAL_HZ // max(1, control & 63) * multiplier // after

    def read_uint32(self, offset):
        """Return a register of the PLL, with the lock bit if its PLL and VCO have power; 0 behind the four registers."""
        if offset >> 2 > 3:
            return 0
        value = self._values[offset >> 2]
        return value | (_LOCK if offset == 0 and not self._values[1] & 0x21 else 0)

    def write_uint32(self, offset, value):
        if offset >> 2 <= 3:
            self._values[offset >> 2] = value & ~_LOCK
            self._changed()

    def write_uint32_atomic(self, offset, value, kind):
        before = self.read_uint32(offset)
        self.write_uint32(offset, (value, before ^ value, before | value, before & ~value)[kind])


class SystemClock:
    def __init__(self, chip):
        self._chip = chip
        self._clock = chip.clock
        self.hz, self.cycle_ns = PARSE_HZ, float(CYCLE_NS)
        self.fault = None
        self.before, self.after = [], []  # called before a change and after it
        self._since_ns, self._cycles = chip.clock.nanos, 0  # of the last change
        self._steady_ns = 0.0
        self._counted = None  # (nanoseconds at which it is done, result) of the frequency counter

    def cycle(self):
        """Return the system clocks since power-on."""
        return self._cycles + int((self._clock.nanos - self._since_ns) / self.cycle_ns + _ROUNDING)

    def nanos_at(self, cycle):
        """Return the emulated nanoseconds at a cycle of the clock as it runs now."""
        return self._since_ns + (cycle - self._cycles) * self.cycle_ns

    def align(self):
        """Have a processor that has been woken go on with its next clock."""
        cycle = self.cycle()
        if self._clock.nanos - self.nanos_at(cycle) > _ROUNDING * self.cycle_ns:
            self._clock.tick(self.nanos_at(cycle + 1) - self._clock.nanos)

    def install(self):
        """Put both PLLs into the chip, and patch its clock registers and regulator."""
        chip = self._chip
        self._pll = chip.peripherals[_SYS_PLL] = Pll(self._follow_registers)
        self._usb_pll = chip.peripherals[_USB_PLL] = Pll(self._follow_registers)
        self._patch_clocks()
        self._patch_regulator()

    def _patch_clocks(self):
        """Patch the clock registers: writes change the chip's clock, and the frequency counter counts clk_sys."""
        chip, clocks = self._chip, self._chip.clocks
        read, write, reset = clocks.read_uint32, clocks.write_uint32, clocks.reset
        counter = {_REFERENCE: 0, _INTERVAL: 8}

        def write_uint32(offset, value):
            """Write a clock register; a write to the counter's source begins a count."""
            if offset == _SOURCE:
                took_ns = _COUNT_NS << (counter[_INTERVAL] & 15)
                khz = self.hz // 1000 if value == _CLK_SYS and counter[_REFERENCE] == _CRYSTAL_HZ // 1000 else 0
                self._counted = self._clock.nanos + took_ns, khz << 5
            elif _REFERENCE <= offset < _SOURCE:
                counter[offset] = value
            else:
                write(offset, value)
            if offset in (_SYS_CONTROL, _SYS_DIVIDER, _PERIPHERAL_CONTROL):
                self._follow_registers()

        def read_uint32(offset):
            """Return a clock register's value; status and result (kHz, 5 fractional bits) are the frequency counter's."""
            if offset not in (_STATUS, _RESULT):
                return read(offset)
            if self._counted is None:
                return 0
            done, result = self._counted[0] <= self._clock.nanos, self._counted[1]
            return (_DONE if done else _RUNNING) if offset == _STATUS else done and result

        def restart():
            """Reset clocks, PLLs and core voltage (1.10 V)."""
            reset()
            for base in (_SYS_PLL, _USB_PLL):
                chip.peripherals[base].reset()
            chip.vreg_and_chip_reset.vreg = 0xB1
            self._counted = None
            self._change_clock(PARSE_HZ)

        clocks.read_uint32, clocks.write_uint32, clocks.reset = read_uint32, write_uint32, restart

    def _patch_regulator(self):
        """Patch the core voltage regulator: its in-regulation bit comes _SETTLE_NS after a change of voltage."""
        regulator, clock = self._chip.vreg_and_chip_reset, self._clock
        read, write = regulator.read_uint32, regulator.write_uint32

        def read_uint32(offset):
            value = read(offset)
            return value | _IN_REGULATION if offset == _VREG and clock.nanos >= self._steady_ns else value

        def write_uint32(offset, value):
            """Write the regulator's register, then check the voltage against the clock."""
            if offset == _VREG:
                if (value ^ read(offset)) & 0xF0:
                    self._steady_ns = clock.nanos + _SETTLE_NS
                value &= ~_IN_REGULATION
            write(offset, value)
            self._check_voltage(True)

        regulator.read_uint32, regulator.write_uint32 = read_uint32, write_uint32

    def _follow_registers(self):
        """Set clk_sys and clk_peri as the registers say that were written last."""
        clocks = self._chip.clocks
        takes_pll = clocks.sys_ctrl & 1 and not clocks.sys_ctrl >> 5 & 7
        hz = self._pll.hz * 256 // (clocks.sys_div or 1 << 24)
        if takes_pll and hz:
            self._change_clock(hz)
        chosen = clocks.peri_ctrl >> 5 & 7
        self._chip.clk_peri = (self.hz, self._pll.hz, self._usb_pll.hz)[chosen] if chosen < 3 else _CRYSTAL_HZ

    def _change_clock(self, hz):
        """Run processor, PWM and SysTick at `hz` from now on, between the calls of `before` and `after`; then check the core voltage."""
        if hz == self.hz:
            return
        for told in self.before:
            told()
        self._cycles, self._since_ns = self.cycle(), self._clock.nanos
        self.hz, self.cycle_ns = hz, 1e9 / hz
        chip = self._chip
        chip.clk_sys = hz
        for channel in chip.pwm.channels:
            channel.timer.frequency = hz
        chip.ppb.systick_timer.frequency = hz
        for told in self.after:
            told()
        self._check_voltage(self._clock.nanos >= self._steady_ns)

    def _check_voltage(self, settled):
        vsel = self._chip.vreg_and_chip_reset.vreg >> 4 & 15
        if self.hz > _UNRAISED_HZ and not (vsel >= _RAISED and settled):
            self.fault = Undervolted(f"{self.hz / 1e6:g} MHz with the regulator at {vsel}, or before it has settled")


def clock_of(chip):
    """Return the SystemClock of a chip. It stays at 125 MHz unless install() is called."""
    found = vars(chip).get("system_clock")
    if found is None:
        found = chip.system_clock = SystemClock(chip)
    return found
