"""Patch: PIO blocks that run by the clock.

rp2040py steps a PIO block once after each processor instruction, at most one PIO instruction at a time, and loses time while
the processor sleeps; it ignores FIFO joining, and shows pins set by an executed instruction only at the next step. Here an
alarm of the clock is set for the next PIO instruction, so each happens at its own cycle, also in the middle of a long processor
instruction or of a sleep.

A delay loop (`jmp(x_dec, …)` to itself, or with `jmp(pin, …)`, `nop` and the other counter in it) is skipped in one go: its
counters and its due time move to its last pass. A register access or an edge on its pin before that finds it in the pass where
it would be. So a program costs emulation time for its instructions, not for its delays.

A program that polls its pins and changes nothing from one pass to the next is parked at its wrap target until one of these pins
changes, or a register is accessed; it then goes on in the pass where it would be. One that counts its passes down in X, which it keeps
in OSR meanwhile, is parked too.
"""

from rp2040py.peripherals.pio import RPPIO
from rp2040py.utils.fifo import FIFO

from host_tools.emulator import system_clock

_NEVER = 1 << 60
_WORD = 0xFFFFFFFF
_CONTROL, _MEMORY, _MACHINES = 0x00, 0x48, 0xC8
_MACHINE_SIZE, _MACHINES_END = 0x18, 0x128
_SHIFT_CONTROL, _INSTRUCTION = 0x08, 0x10  # of one machine
_JOIN_SEND, _JOIN_RECEIVE = 1 << 30, 1 << 31
_NOP = 0xA042
_LOOP_INSTRUCTIONS = 4
_ALWAYS, _PIN = 0, 6  # conditions of jmp
_COUNTERS = {2: "x", 4: "y"}  # conditions that count down
_JMP, _WAIT, _IN, _MOV = 0, 1, 2, 5


class TimedPio(RPPIO):
    # The emulator's loop steps blocks that are not stopped. This one is never its business; the block's own flag lies
    # beneath, in the compiled class.
    stopped = True
    skipping = True  # run through delay loops ahead

    def __init__(self, chip, name, first_irq, index):
        self._chip = chip
        self._clock = chip.clock
        self._alarm = chip.clock.create_alarm(self._on_alarm)
        self._system = system_clock.clock_of(chip)
        self._system.before.append(lambda: self.catch_up(False))
        self._system.after.append(self._plan_alarm)
        self._origin = self._system.cycle()  # the cycle at which the block's own count is 0
        self._skips = [None] * 4  # of each machine: (first due, turn, turns, counters, end, lasting), in 1/256 cycles
        self._passes = [None] * 4  # of each machine: (its state, due) as it last began a pass; None: something has happened since
        self._parked = [None] * 4  # (due of the pass that it is parked at, 1/256 cycles of a pass, pins that end it, whether X counts)
        self._loops = {}  # {(machine, address): result of `_find_loop`}
        self._running = False

    # --- the bus

    def read_uint32(self, offset):
        """Run the block up to now and return a register's value."""
        self._unpark_machines()
        self.catch_up(_MACHINES <= offset < _MACHINES_END)
        value = super().read_uint32(offset)
        self._plan_alarm()
        return value

    def write_uint32(self, offset, value):
        """Run the block up to now and write a register; a change of program or configuration forgets the delay loops found."""
        self._unpark_machines()
        configures = offset == _CONTROL or _MEMORY <= offset < _MACHINES_END
        self.catch_up(configures)
        if configures and offset != _CONTROL:
            self._loops.clear()
        super().write_uint32(offset, value)
        if _MACHINES <= offset < _MACHINES_END:
            machine, register = divmod(offset - _MACHINES, _MACHINE_SIZE)
            if register == _SHIFT_CONTROL:
                self._join_fifos(self.machines[machine])
            elif register == _INSTRUCTION:
                self.check_changed_pins()
        self._plan_alarm()

    def reset(self):
        """Reset the block: time counts from now, no loop is skipped and no machine parked."""
        super().reset()
        self._origin = self._system.cycle()
        self._skips = [None] * 4
        self._passes, self._parked = [None] * 4, [None] * 4
        self._loops.clear()
        self._alarm.cancel()

    def _join_fifos(self, machine):
        """Set the FIFOs' sizes: four words each, or eight and none. A change empties them."""
        send, receive = bool(machine.shift_ctrl & _JOIN_SEND), bool(machine.shift_ctrl & _JOIN_RECEIVE)
        sizes = (0, 0) if send and receive else (8, 0) if send else (0, 8) if receive else (4, 4)
        if (machine.tx_fifo.size, machine.rx_fifo.size) == sizes:
            return
        machine.tx_fifo, machine.rx_fifo = FIFO(sizes[0]), FIFO(sizes[1])
        dma = self._chip.dma
        (dma.set_dreq if sizes[0] else dma.clear_dreq)(machine.dreq_tx)
        dma.clear_dreq(machine.dreq_rx)
        self.check_interrupts()

    # --- time

    def input_changes(self, gpio):
        """Run the block up to now. Call it before the level of an input changes, and `input_changed` after it."""
        if not self._running:
            self._unpark_machines(gpio)
            self.catch_up(any(skip and not skip[5] for skip in self._skips))

    def input_changed(self):
        self._plan_alarm()

    def _on_alarm(self):
        self.catch_up(False)
        self._plan_alarm()

    def catch_up(self, unwind):
        """Run the instructions due by now; `unwind`: put delay loops that were run through ahead back to where they are now."""
        if self._running:
            return
        self._running = True
        now = self._system.cycle() - self._origin << 8
        if unwind:
            self._unwind_loops(now)
        while self.next_due_fp <= now:
            self.cycle_fp = self.next_due_fp
            self.advance(0)
        self.cycle_fp = now
        self._running = False

    def _unwind_loops(self, now):
        """Put the counters and times of skipped delay loops back to those of `now` (cycles, 8 fractional bits)."""
        if not any(self._skips):
            return
        for index, skip in enumerate(self._skips):
            if skip is None:
                continue
            self._skips[index] = None
            first, turn, turns, counters, end, _ = skip
            left = turns - min(turns, max(0, (now - first) // turn))
            if left:
                machine = self.machines[index]
                for counter in counters:
                    setattr(machine, counter, getattr(machine, counter) + left)
                machine.next_due_fp = end - left * turn
        self.recompute_due()

    def _plan_alarm(self):
        """Set the alarm for the next instruction, after running through delay loops that begin here."""
        if self._running:
            return
        due = self.next_due_fp
        if due >= _NEVER:
            self._alarm.cancel()
            return
        for machine in self.machines if self.skipping else ():
            if machine.enabled and not machine.waiting and machine.next_due_fp == due:
                if machine.pc == machine.wrap_bottom and not machine.exec_valid:
                    self._park_machine(machine)
                self._skip_loop(machine)
        due = self.next_due_fp
        at_ns = self._system.nanos_at(self._origin + (due + 255 >> 8))
        self._alarm.schedule(max(0.0, at_ns - self._clock.nanos))

    # --- polling loops

    def _park_machine(self, machine):
        """Park a machine that begins a pass, if nothing has happened in the pass before, until something happens."""
        index = machine.index
        due = machine.next_due_fp
        state = (
            machine.x, machine.y, machine.input_shift_reg, machine.input_shift_count, machine.output_shift_reg,
            machine.output_shift_count, machine.rx_fifo.item_count, machine.tx_fifo.item_count,
        )  # fmt: skip
        before, self._passes[index] = self._passes[index], (state, due)
        if before is None or due <= before[1]:
            return
        counts = _counts_down(before[0], state)
        if before[0] != state and not counts:
            return
        pins = self._pins_polled(machine)
        if pins:
            self._parked[index] = due, due - before[1], pins, counts
            machine.next_due_fp = _NEVER
            self.recompute_due()

    def _pins_polled(self, machine):
        """Return the pins that a state machine's program reads; none if it does more than read pins."""
        pins = set()
        for code in self.instructions:
            kind, argument = code >> 13, code & 0xFF
            if kind == _WAIT or kind == _MOV and argument & 7 == 0 or kind == _JMP and argument >> 5 == _PIN:
                return ()
            if kind == _IN and argument >> 5 == 0:
                pins |= {machine.in_base + bit & 31 for bit in range(argument & 31 or 32)}
        return pins

    def _unpark_machines(self, gpio=None):
        """Take back machines that wait in a loop for an input (`gpio`; None: any), with x, OSR and time as of now."""
        for index, parked in enumerate(self._parked):
            if gpio is None or parked is None or gpio in parked[2]:
                self._passes[index] = None
            if parked is None or gpio is not None and gpio not in parked[2]:
                continue
            due, period, _, counts = parked
            now = self._system.cycle() - self._origin << 8
            self._parked[index] = None
            machine, passes = self.machines[index], max(0, (now - due) // period)
            machine.next_due_fp = due + passes * period
            if counts:
                machine.x = machine.x - passes & _WORD
                machine.output_shift_reg = machine.output_shift_reg - passes & _WORD
            self.recompute_due()

    # --- delay loops

    def _skip_loop(self, machine):
        """Run through a delay loop at once if `machine` is at one: set its counters to their end and its due time to that of the last pass."""
        index = machine.index
        skip = self._skips[index]
        if skip is not None:
            if machine.next_due_fp <= skip[4]:
                return  # its last turn is still to come
            self._skips[index] = None
        key = index, machine.pc
        loop, lasting = self._loops.get(key) or self._find_loop(machine)
        if lasting:
            self._loops[key] = loop, lasting
        if loop is None or machine.exec_valid:
            return
        counters, turn = loop
        values = [getattr(machine, counter) for counter in counters]
        turns = values[0]
        if turns < 2 or min(values) < turns:
            return
        for counter, value in zip(counters, values):
            setattr(machine, counter, value - turns)
        first = machine.next_due_fp
        machine.next_due_fp = end = first + turns * turn
        self._skips[index] = first, turn, turns, counters, end, lasting
        self.recompute_due()

    def _find_loop(self, machine):
        """Return ((counters, 1/256 cycles a turn) or None, whether that holds until the machine is configured anew). The first counter is the one
        whose jump closes the loop."""
        if machine.sideset_count:
            return None, True  # side-set pins may change in its first turn
        start = pc = machine.pc
        closing, others, turn, lasting = None, [], 0, True
        for _ in range(_LOOP_INSTRUCTIONS):
            code = self.instructions[pc]
            following = machine.wrap_bottom if pc == machine.wrap_top else pc + 1 & 31
            turn += (1 + (code >> 8 & 31)) * machine.div_fp
            if code >> 13 == 0:
                condition, target = code >> 5 & 7, code & 31
                if condition == _ALWAYS:
                    following = target
                elif condition == _PIN:
                    lasting = False
                    if self._chip.gpio[machine.jmp_pin].input_value:
                        following = target
                elif condition not in _COUNTERS:
                    return None, lasting
                elif target == following:
                    others.append(_COUNTERS[condition])  # counts, and goes on either way
                elif closing is None:
                    closing, following = _COUNTERS[condition], target
                else:
                    return None, lasting
            elif code & 0xE0FF != _NOP:
                return None, lasting
            pc = following
            if pc == start:
                counters = (closing, *others)
                found = closing is not None and len(set(counters)) == len(counters)
                return ((counters, turn) if found else None), lasting
        return None, lasting


def _counts_down(before, state):
    """True if, since a pass began, X has gone down by one, OSR, which holds the former X, likewise, and nothing else has changed."""
    x, osr = state[0], state[4]
    return x == before[0] - 1 and osr == before[4] - 1 == x + 1 and before[1:4] + before[5:] == state[1:4] + state[5:]


def install(chip):
    for index, (base, old) in enumerate(zip((0x50200, 0x50300), list(chip.pio))):
        chip.pio[index] = chip.peripherals[base] = TimedPio(chip, old.name, old.first_irq, index)
