"""Runs rp2040py's compiled loop faster, by hiding the PIO blocks from it.

After each instruction the loop asks every PIO block if it is stopped. Ours always are (see `pio`), and asking costs a sixth of
the time. So the loop sees a chip without PIO blocks when it begins; before the first instruction they are back. The two
attributes that it reads then, in this order, do that.

    loop = Loop(chip)
    loop.run()                  # some milliseconds of wall time, or until loop.ended is set

It knows 125 MHz only. At another clock (see `system_clock`) there is a loop in Python in its place.
"""

from host_tools.emulator import system_clock


class Loop:
    __slots__ = ("_blocks", "_chip", "_execute", "_system", "clock", "ended")

    def __init__(self, chip):
        from rp2040py.execute_batch import execute_batch

        self._chip = chip
        self._blocks = chip.pio
        self._execute = execute_batch
        self.clock = chip.clock
        self.ended = False
        self._system = system_clock.clock_of(chip)
        self._system.after.append(self._end_run)

    def _end_run(self):
        self.ended = True

    def run(self):
        """Run some milliseconds of wall time, or until `ended`. Raises the clock's fault if there is one."""
        self.ended = False
        if self._system.hz != system_clock.PARSE_HZ:
            self._run_slowly()
            return
        self.__class__ = _Beginning
        try:
            self._execute(self, 1)
        finally:
            self._chip.pio = self._blocks
        if self._system.fault:
            raise self._system.fault

    def _run_slowly(self):
        """Run instruction by instruction in Python until `ended` or until the RUN pin is low. Raises the clock's fault, such as too low a core
        voltage."""
        core, clock, system = self._chip.core, self.clock, self._system
        while not (self.ended or self._chip.run_pin_low):
            if core.waiting:
                clock.tick(clock.nanos_to_next_alarm)
                if not core.waiting:
                    system.align()
            else:
                clock.tick(core.execute_instruction() * system.cycle_ns)
                if system.fault:
                    raise system.fault


class _Beginning(Loop):
    __slots__ = ()

    @property
    def rp2040(self):
        self._chip.pio = []
        return self._chip

    @property
    def stopped(self):
        self._chip.pio = self._blocks
        self.__class__ = _Running
        return self.ended


class _Running(Loop):
    __slots__ = ()
    stopped = Loop.ended  # the slot itself: read after every instruction
