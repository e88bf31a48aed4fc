"""The time that the emulated flash takes to erase and to program: without it, as long as its commands take to send.

    pico.flash_times.set_times(**LONGEST)                # from now on; a Pico begins with TYPICAL
    pico.flash_times.erased, .programmed            # how often, since then

Figures of the W25Q16JV, a Pico's flash, from its data sheet: a sector's erase 45 ms, at most 400; a page's program 0.4 ms, at most 3.

A chip that is busy says so in its status register, and the boot ROM asks until it is not, with all interrupts off.
"""

# Commands of the flash.
_ERASE_SECTOR, _ERASE_BLOCK, _PROGRAM, _STATUS = 0x20, 0xD8, 0x02, 0x05
TYPICAL = {"erase_us": 45_000, "page_us": 400}
LONGEST = {"erase_us": 400_000, "page_us": 3_000}
_BUSY = 1
_SECTORS = 16  # of a block


class FlashTimes:
    def __init__(self, chip, times):
        """`times`: the arguments of set_times()."""
        self._clock = chip.clock
        self._ssi = ssi = chip.ssi
        self._shift, self._apply = ssi._shift_byte, ssi._apply_command
        self._ready_ns = 0.0
        self.set_times(**times)
        ssi._shift_byte, ssi._apply_command = self._answer_status, self._begin_command

    def set_times(self, erase_us, page_us):
        """Set the µs of a sector's erase and of a page's program, and reset both counters."""
        self.times = {"erase_us": erase_us, "page_us": page_us}
        self.erased = self.programmed = 0

    def _begin_command(self):
        """Carry out a flash command at its end. Erasing and programming count here, and keep the flash busy for `times` (µs a sector, a page)."""
        ssi = self._ssi
        opcode = ssi._tx_buffer[0] if ssi._tx_buffer and ssi._write_enabled else 0
        self._apply()
        if opcode in (_ERASE_SECTOR, _ERASE_BLOCK):
            sectors = 1 if opcode == _ERASE_SECTOR else _SECTORS
            self.erased += sectors
            self._ready_ns = self._clock.nanos + sectors * self.times["erase_us"] * 1000
        elif opcode == _PROGRAM:
            self.programmed += 1
            self._ready_ns = self._clock.nanos + self.times["page_us"] * 1000

    def _answer_status(self, byte):
        """Return the byte that answers `byte`; in a status read, wait until the flash is ready and set its busy bit."""
        said = self._shift(byte)
        sent = self._ssi._tx_buffer
        if len(sent) > 1 and sent[0] == _STATUS:
            left_ns = self._ready_ns - self._clock.nanos
            if left_ns > 0:
                self._clock.tick(left_ns)  # asking a million times would take minutes; all else goes on meanwhile
                said |= _BUSY
        return said
