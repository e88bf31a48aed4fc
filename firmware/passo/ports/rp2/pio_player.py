"""The waveform player: a PIO state machine plays step words, DMA hands them over, the processor does nothing per step.

    ring ──A──► FIFO (8 words) ──► state machine ──► pins
          ▲ address, then length, of the next run of words
          └──B, C── tables of runs

Channel A copies a run of words of the ring into the FIFO. When a run ends it chains to B and C, which copy the next
run's address and length from the tables into A and so set it going again; a length of 0 ends the chain. `start` appends
runs to the tables. No interrupt takes part: the hand-over costs a few clocks, however busy the processor is.

Which words have been played is read off the hardware: A's read address says how far it has got in the ring; the FIFO's
level and the word pulled but not yet on the pins (the state machine's address tells) are still to come.

At 125 MHz `start` takes 15 µs (90 from a standstill), `played` 12 µs. Nothing here allocates after the constructor.
"""
# Shared with interrupts: state

from array import array

import micropython
import rp2
import uctypes
from micropython import const

from passo.ports.rp2 import chip, programs
from passo.ports.rp2.fields import *
from passo.ports.rp2.registers import *
from passo.records import COUNT_MASK

_ENTRY = const(2)  # bits that count the bytes of a table's entry
_SPARE = const(3)  # entries left free: two for the next append, one for the end mark

# Looks at a register that should be right after a microsecond; as many take 50 µs at least, by viper 200.
_TRIES = const(1000)
STUCK = RuntimeError("the player's DMA or state machine does not answer")  # here: an interrupt must not make one


def create(board, ring, layout, pins, pulse_ticks, min_word_ticks, invert, halt_pin):
    """Return the player of a checked board; `halt_pin()` is asked for the Pin that halts."""
    return PioPlayer(ring, layout, pins[0], pulse_ticks, min_word_ticks, invert, halt_pin())


class PioPlayer:
    """`base`: pin of the lowest bit; `invert`: mask of bits whose electrical level is the opposite of the word's;
    `pulse_ticks`: 0 for coils; `halt_pin`: a Pin that stops everything while it is high, or None."""

    run_bits = 5  # a call of start() takes one or two runs, and seldom are four calls ahead

    def __init__(self, ring, layout, base, pulse_ticks, min_word_ticks, invert, halt_pin=None):
        self.min_word_ticks = min_word_ticks
        self._ring = ring
        cycles = chip.cycles_per_tick()
        make = programs.steps if pulse_ticks else programs.levels
        program = make(layout.bits, cycles, halt_pin is not None)
        self._machine = rp2.StateMachine(0, program, jmp_pin=halt_pin)
        size = 1 << self.run_bits + _ENTRY  # of a table, which is aligned to it for the DMA's address ring
        self._tables = bytearray(3 * size)
        counts = (uctypes.addressof(self._tables) + size - 1) & ~(size - 1)
        self._dma = [rp2.DMA() for _ in range(3)]
        channels = [0x50000000 + 0x40 * dma.channel for dma in self._dma]
        out = base | layout.bits << 20
        self._state = array("I", [0] * PIO_FIELDS)
        for index, value in (
            (PIO_BLOCK, programs.PIO_0), (PIO_MACHINE, programs.PIO_0 + 0xC8), (PIO_A, channels[0]), (PIO_B, channels[1]), (PIO_C, channels[2]),
            (PIO_D, channels[0]), (PIO_ABORT, chip.ABORT),
            (PIO_COUNTS, counts), (PIO_ADDRESSES, counts + size), (PIO_WORDS, uctypes.addressof(ring.words)),
            (PIO_MASK, ring.mask), (PIO_PULSE, pulse_ticks - 2 if pulse_ticks else 0xFFFFFFFF),
            (PIO_PINS, out | (base << 5 | layout.motors << 26 if pulse_ticks else 0)),
            (PIO_TOOL, out | base + layout.bits - 1 << 5 | 1 << 26), (PIO_BITS, layout.bits),
            (PIO_CHANNELS, 1 << self._dma[0].channel | 1 << self._dma[1].channel | 1 << self._dma[2].channel),
            (PIO_BUSY, chip.BUSY), (PIO_CYCLES, pulse_ticks * cycles), (PIO_LAST, (1 << self.run_bits) - 1),
        ):  # fmt: skip
            self._state[index] = value
        self._set_up_dma(channels[0])
        _set_up(self._state)
        for bit in range(layout.bits):
            chip.give_to_pio(base + bit, invert >> bit & 1)
        _drive(self._state)

    def _set_up_dma(self, channel_a, after_a=None):
        """`after_a`: the channel that A chains to, if not B."""
        a, b, c = self._dma
        state = self._state
        ctrl = a.pack_ctrl(size=2, inc_write=False, high_pri=True, treq_sel=0, chain_to=b.channel if after_a is None else after_a)
        a.config(read=state[PIO_WORDS], write=programs.PIO_0 + 4 * BLOCK_TXF, count=0, ctrl=ctrl)
        for dma, table, register, after in (
            (b, state[PIO_ADDRESSES], 0x14, c.channel),  # A's address, which does not start it
            (c, state[PIO_COUNTS], 0x1C, c.channel),  # A's length, which does, unless it is 0
        ):
            ctrl = dma.pack_ctrl(
                size=2, inc_write=False, high_pri=True, ring_size=self.run_bits + _ENTRY, ring_sel=False, chain_to=after
            )
            dma.config(read=table, write=channel_a + register, count=1, ctrl=ctrl)

    @micropython.native
    def start(self):  # ISR: no allocation
        """Play from the ring what is published there; call it again when there is more. True if it has run dry."""
        if self._state[PIO_STUCK]:
            raise STUCK  # the feeding interrupt catches it, and the main loop ends with it: outputs safe, a report
        return append(self._state, self._ring.head)

    def hold(self, on):  # ISR: no allocation
        """While held, start() does nothing: not even one that was under way when an interrupt halted the player."""
        self._state[PIO_HELD] = on

    def stop(self):
        """Play no further word after the one under way."""
        _stop(self._state)

    def halt(self):  # ISR: no allocation
        """Stop at once: the tool drops now, a pulse once it has lasted as long as it should, the other pins keep their levels."""
        _halt(self._state)

    def busy(self):
        """Return True while words are left to play or the last one's ticks still run."""
        return _busy(self._state, self._ring.head)

    @micropython.native
    def words_played(self):  # ISR: no allocation
        """Return the words whose levels have appeared on the pins, modulo 2²⁹."""
        return _words_played(self._state)

    def rest(self, levels):
        """Put `levels` on the pins at once. Only while not busy."""
        _rest(self._state, levels)


@micropython.viper
def _run(state: ptr32, instruction: int):
    """Have the state machine, enabled or not, carry out one instruction."""
    ptr32(state[PIO_MACHINE])[MACHINE_INSTR] = instruction


@micropython.viper
def _still(state: ptr32):
    """No DMA channel is active. None is enabled either: one that is aborted may set off the next (RP2350-E5). One that
    does not stop is left alone: the state machine does not run, and nothing is played any more."""
    for field in range(PIO_A, PIO_D + 1):
        channel = ptr32(state[field])
        channel[CHANNEL_CTRL] = channel[CHANNEL_CTRL] & ~1
    abort = ptr32(state[PIO_ABORT])
    abort[0] = state[PIO_CHANNELS]
    tries = _TRIES
    while abort[0] & state[PIO_CHANNELS]:
        tries -= 1
        if tries == 0:
            state[PIO_STUCK] = 1
            return


@micropython.viper
def _empty(state: ptr32):
    """Empty the FIFO: joining it otherwise and back does that."""
    flip = ptr32(state[PIO_MACHINE] + ALIAS_XOR)
    join = 1
    join <<= 31
    flip[MACHINE_SHIFTCTRL] = join
    flip[MACHINE_SHIFTCTRL] = join


@micropython.viper
def _quiet(state: ptr32):
    """Switch the state machine off and restart it, its FIFO empty, no DMA channel active."""
    bit = 1 << state[PIO_NUMBER]
    ptr32(state[PIO_BLOCK] + ALIAS_CLEAR)[BLOCK_CTRL] = bit
    _still(state)
    _empty(state)
    ptr32(state[PIO_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = bit << 4 | bit << 8


@micropython.viper
def _set_up(state: ptr32):
    """After the program has been loaded: pins low but not yet driven."""
    sm = ptr32(state[PIO_MACHINE])
    state[PIO_FIRST] = (sm[MACHINE_EXECCTRL] >> 7) & 31
    _quiet(state)
    sm[MACHINE_PINCTRL] = state[PIO_PINS]
    _put(state, 0)
    _run(state, 0x6000 | state[PIO_BITS])  # out(pins, bits)


@micropython.viper
def _drive(state: ptr32):
    """Make outputs of the pins."""
    _put(state, (1 << state[PIO_BITS]) - 1)
    _run(state, 0x6080 | state[PIO_BITS])  # out(pindirs, bits)


@micropython.viper
def _put(state: ptr32, value: int):
    """Bring `value` into the state machine's OSR; its FIFO is empty."""
    ptr32(state[PIO_BLOCK])[BLOCK_TXF + state[PIO_NUMBER]] = value
    _run(state, 0x8080)  # pull(noblock)


@micropython.viper
def _count(state: ptr32) -> int:
    """Words played, read off A, the FIFO and the state machine; read twice, until no word was just changing places."""
    pio = ptr32(state[PIO_BLOCK])
    sm = ptr32(state[PIO_MACHINE])
    a = ptr32(state[PIO_A])
    shift = state[PIO_NUMBER] << 3
    read = 0
    level = 0
    address = 0
    tries = _TRIES
    while tries:
        read = a[CHANNEL_READ]
        level = (pio[BLOCK_FLEVEL] >> shift) & 15
        address = sm[MACHINE_ADDR]
        if a[CHANNEL_READ] == read and (pio[BLOCK_FLEVEL] >> shift) & 15 == level:
            break
        tries -= 1
    if tries == 0:
        state[PIO_STUCK] = 1
    armed = state[PIO_ARMED]  # after the address: an interrupt in between only makes it larger
    left = (armed - ((read - state[PIO_WORDS]) >> 2)) & state[PIO_MASK]
    if address == state[PIO_FIRST] + 1:
        left += 1
    return (armed - left - level) & COUNT_MASK


@micropython.viper
def _words_played(state: ptr32) -> int:
    """Return the words played, modulo 2²⁹: counted while words play, else as of the last stop."""
    if state[PIO_PLAYING] == 1:
        return int(_count(state))
    return state[PIO_PLAYED]


@micropython.viper
def _busy(state: ptr32, head: int) -> bool:
    """Return True while words up to `head` are left to play or the last one's ticks still run."""
    if state[PIO_PLAYING] == 0:
        return False
    sm = ptr32(state[PIO_MACHINE])
    if state[PIO_PLAYING] == 1 and int(_count(state)) != head:
        return True
    return sm[MACHINE_ADDR] != state[PIO_FIRST]


@micropython.viper
def _halt(state: ptr32):
    """Stop at once, amid a word: note the words played, drop the tool, let pulses fall after their full length, and end all DMA. The FIFO stays."""
    clock = ptr32(0xE000E010)
    ptr32(state[PIO_BLOCK] + ALIAS_CLEAR)[BLOCK_CTRL] = 1 << state[PIO_NUMBER]  # the state machine stands still from here
    begun = clock[SYSTICK_NOW]
    if state[PIO_PLAYING] == 1:
        state[PIO_PLAYED] = int(_count(state))
    state[PIO_PLAYING] = 0
    ptr32(state[PIO_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = 16 << state[PIO_NUMBER]  # restart: no delay is left over
    sm = ptr32(state[PIO_MACHINE])
    sm[MACHINE_PINCTRL] = state[PIO_TOOL]
    sm[MACHINE_INSTR] = 0xE000  # set(pins, 0)
    sm[MACHINE_PINCTRL] = state[PIO_PINS]
    if state[PIO_PULSE] >= 0:
        tries = state[PIO_CYCLES]  # each look takes a cycle at least: if SysTick stands still, the wait ends all the same
        while tries > 0 and ((begun - clock[SYSTICK_NOW]) & 0xFFFFFF) < state[PIO_CYCLES]:
            tries -= 1
        sm[MACHINE_INSTR] = 0xE000
    _still(state)  # the FIFO stays as it is: an interrupted `_count` must still come out right


@micropython.viper
def _stop(state: ptr32):
    """Stop behind the word that plays now: note the words played with it, empty the FIFO, and let its ticks run out."""
    if state[PIO_PLAYING] != 1:
        return
    sm = ptr32(state[PIO_MACHINE])
    bit = 1 << state[PIO_NUMBER]
    ptr32(state[PIO_BLOCK] + ALIAS_CLEAR)[BLOCK_CTRL] = bit
    in_hand = 1 if sm[MACHINE_ADDR] == state[PIO_FIRST] + 1 else 0  # it will still be played
    state[PIO_PLAYED] = (int(_count(state)) + in_hand) & COUNT_MASK
    state[PIO_PLAYING] = 2
    _still(state)
    _empty(state)
    ptr32(state[PIO_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = bit


@micropython.viper
def _rest(state: ptr32, value: int):
    """Stop, and set all pins to the levels `value`."""
    if state[PIO_PLAYING] == 1:
        state[PIO_PLAYED] = int(_count(state))
    state[PIO_PLAYING] = 0
    _quiet(state)
    _put(state, value)
    _run(state, 0x6000 | state[PIO_BITS])


@micropython.viper
def _resume(state: ptr32):
    """From standing still, or from the last word's end, to playing; the table is empty and its end mark read."""
    if state[PIO_PLAYING] == 0:
        _quiet(state)
        if state[PIO_PULSE] >= 0:
            _put(state, state[PIO_PULSE])
            _run(state, 0xA0C7)  # mov(isr, osr)
        _run(state, state[PIO_FIRST])  # jmp
        ptr32(state[PIO_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = 1 << state[PIO_NUMBER]
    state[PIO_ARMED] = state[PIO_PLAYED]
    next_word = state[PIO_WORDS] + ((state[PIO_PLAYED] & state[PIO_MASK]) << 2)
    state[PIO_SLOT] = 0
    ptr32(state[PIO_A])[CHANNEL_READ] = next_word
    ptr32(state[PIO_ADDRESSES])[0] = next_word
    ptr32(state[PIO_COUNTS])[0] = 0
    ptr32(state[PIO_B])[CHANNEL_READ] = state[PIO_ADDRESSES] + 4
    ptr32(state[PIO_C])[CHANNEL_READ] = state[PIO_COUNTS] + 4
    for field in range(PIO_A, PIO_D + 1):
        channel = ptr32(state[field])
        channel[CHANNEL_CTRL] = channel[CHANNEL_CTRL] | 1
    state[PIO_PLAYING] = 1


@micropython.viper
def _next_run(state: ptr32) -> int:  # ISR: no allocation
    """Return the run that the chain reads next."""
    return ((ptr32(state[PIO_C])[CHANNEL_READ] - state[PIO_COUNTS]) >> 2) & state[PIO_LAST]


@micropython.viper
def _rests(state: ptr32, after: int) -> int:  # ISR: no allocation
    """1 if the chain has read the end mark in front of `after` just before it was replaced: then C stands behind it and A rests."""
    c = ptr32(state[PIO_C])
    address = c[CHANNEL_READ]
    active = ptr32(state[PIO_A])[CHANNEL_CTRL_TRIG] | ptr32(state[PIO_D])[CHANNEL_CTRL_TRIG]
    active = (active | ptr32(state[PIO_B])[CHANNEL_CTRL_TRIG] | c[CHANNEL_CTRL_TRIG]) & state[PIO_BUSY]
    return 1 if ((address - state[PIO_COUNTS]) >> 2) & state[PIO_LAST] == after and active == 0 and c[CHANNEL_READ] == address else 0


@micropython.viper
def append(state: ptr32, head: int) -> bool:
    if state[PIO_HELD]:
        return False
    dry = False
    if state[PIO_PLAYING] != 1:
        _resume(state)
    elif ptr32(state[PIO_MACHINE])[MACHINE_ADDR] == state[PIO_FIRST] and int(_count(state)) == state[PIO_ARMED]:
        dry = True
    counts = ptr32(state[PIO_COUNTS])
    addresses = ptr32(state[PIO_ADDRESSES])
    mask = state[PIO_MASK]
    first = state[PIO_SLOT]
    after = (first + 1) & state[PIO_LAST]
    # 1 once the chain has read the end mark in `first`: it has to be set going again
    ended = 1 if int(_next_run(state)) == after else 0
    count = (head - state[PIO_ARMED]) & COUNT_MASK
    while count:
        slot = state[PIO_SLOT]
        waiting = (slot - int(_next_run(state))) & state[PIO_LAST]
        if waiting > state[PIO_LAST] - _SPARE and ended == 0:
            break
        run = mask + 1 - (state[PIO_ARMED] & mask)
        if run > count:
            run = count
        armed = (state[PIO_ARMED] + run) & COUNT_MASK
        following = (slot + 1) & state[PIO_LAST]
        addresses[following] = state[PIO_WORDS] + ((armed & mask) << 2)
        counts[following] = 0
        state[PIO_ARMED] = armed
        state[PIO_SLOT] = following
        counts[slot] = run  # last, over the end mark: from here on the chain may take it
        count -= run
    if state[PIO_SLOT] == first:
        return False
    if ended == 0:
        ended = int(_rests(state, after))
    if ended and state[PIO_HELD] == 0:
        ptr32(state[PIO_C])[CHANNEL_READ] = state[PIO_COUNTS] + (first << 2)
        ptr32(state[PIO_B])[CHANNEL_READ_TRIG] = state[PIO_ADDRESSES] + (first << 2)
    return dry
