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

from array import array

import micropython
import rp2
import uctypes
from micropython import const

from passo.ports.rp2 import chip, programs
from passo.records import COUNT_MASK

_RUNS = const(64)  # entries of each table; 64 words, so aligned to 256 bytes for the DMA's address ring
_RUNS_RING = const(8)
_SPARE = const(3)  # entries left free: two for the next append, one for the end mark

# Fields of the state that the viper functions share; the first group does not change.
_PIO = const(0)  # addresses: PIO block, state machine, DMA channels, tables, words
_SM = const(1)
_A = const(2)
_B = const(3)
_C = const(4)
_D = const(5)  # of a player that has a fourth; else A's again
_COUNTS = const(6)
_ADDRESSES = const(7)
_WORDS = const(8)
_ABORT = const(9)
_MASK = const(10)
_NUMBER = const(11)  # of the state machine in its block
_FIRST = const(12)  # address of the program
_PULSE = const(13)  # pulse ticks − 2, for the program's ISR; −1 where there are no pulses
_PINS = const(14)  # pin control: words' pins and pulse pins
_TOOL = const(15)  # pin control: the tool's pin as the one to set
_BITS = const(16)
_CHANNELS = const(17)  # mask of them, for the abort register
_BUSY = const(18)
_PLAYING = const(19)  # 0 still, 1 playing, 2 the last word ends
_ARMED = const(20)  # words of the ring that stand in the table, modulo 2²⁹
_SLOT = const(21)  # the table's end mark
_PLAYED = const(22)  # words played, while not playing
_HELD = const(23)
_STUCK = const(24)  # 1: a register that was waited for never came to its value

# Looks at a register that should be right after two or three of them; as many take a fifth of a millisecond.
_TRIES = const(1000)
STUCK = RuntimeError("the player's DMA or state machine does not answer")  # here: an interrupt must not make one


class PioPlayer:
    """`base`: pin of the lowest bit; `invert`: mask of bits whose electrical level is the opposite of the word's;
    `pulse_ticks`: 0 for coils; `halt_pin`: a Pin that stops everything while it is high, or None."""

    def __init__(self, ring, layout, base, pulse_ticks, min_word_ticks, invert, halt_pin=None, machine_id=0):
        self.min_word_ticks = min_word_ticks
        self._ring = ring
        cycles = chip.cycles_per_tick()
        make = programs.steps if pulse_ticks else programs.levels
        program = make(layout.bits, cycles, halt_pin is not None)
        self._machine = rp2.StateMachine(machine_id, program, jmp_pin=halt_pin)
        block, number = divmod(machine_id, 4)
        pio = 0x50200000 + 0x100000 * block
        self._tables = bytearray(3 * 4 * _RUNS)
        counts = (uctypes.addressof(self._tables) + 4 * _RUNS - 1) & ~(4 * _RUNS - 1)
        self._dma = [rp2.DMA() for _ in range(3)]
        channels = [0x50000000 + 0x40 * dma.channel for dma in self._dma]
        out = base | layout.bits << 20
        self._state = array("I", [0] * 25)
        for index, value in (
            (_PIO, pio), (_SM, pio + 0xC8 + 0x18 * number), (_A, channels[0]), (_B, channels[1]), (_C, channels[2]),
            (_D, channels[0]), (_ABORT, chip.ABORT),
            (_COUNTS, counts), (_ADDRESSES, counts + 4 * _RUNS), (_WORDS, uctypes.addressof(ring.words)),
            (_MASK, ring.mask), (_NUMBER, number), (_PULSE, pulse_ticks - 2 if pulse_ticks else 0xFFFFFFFF),
            (_PINS, out | (base << 5 | layout.axes << 26 if pulse_ticks else 0)),
            (_TOOL, out | base + layout.bits - 1 << 5 | 1 << 26), (_BITS, layout.bits),
            (_CHANNELS, 1 << self._dma[0].channel | 1 << self._dma[1].channel | 1 << self._dma[2].channel),
            (_BUSY, chip.BUSY),
        ):  # fmt: skip
            self._state[index] = value
        self._set_up_dma(channels[0], 8 * block + number)
        _set_up(self._state)
        for bit in range(layout.bits):
            chip.give_to_pio(base + bit, block, invert >> bit & 1)
        _drive(self._state)

    def _set_up_dma(self, channel_a, request, after_a=None):
        """`after_a`: the channel that A chains to, if not B."""
        a, b, c = self._dma
        state = self._state
        a.config(
            read=state[_WORDS], write=state[_PIO] + 0x10 + 4 * state[_NUMBER], count=0,
            ctrl=a.pack_ctrl(size=2, inc_write=False, high_pri=True, treq_sel=request,
                             chain_to=b.channel if after_a is None else after_a),
        )  # fmt: skip
        for dma, table, register, after in (
            (b, state[_ADDRESSES], 0x14, c.channel),  # A's address, which does not start it
            (c, state[_COUNTS], 0x1C, c.channel),  # A's length, which does, unless it is 0
        ):
            ctrl = dma.pack_ctrl(
                size=2, inc_write=False, high_pri=True, ring_size=_RUNS_RING, ring_sel=False, chain_to=after
            )
            dma.config(read=table, write=channel_a + register, count=1, ctrl=ctrl)

    def start(self):  # ISR: no allocation
        """Play from the ring what is published there; call it again when there is more. True where it has run dry."""
        return append(self._state, self._ring.head)

    def hold(self, on):  # ISR: no allocation
        """While held, start() does nothing: not even one that was under way when an interrupt halted the player."""
        self._state[_HELD] = on

    def stop(self):
        """Play no further word after the one under way."""
        _stop(self._state)

    def halt(self):  # ISR: no allocation
        """No further edge: pulses and tool drop now, the other pins keep their levels."""
        _halt(self._state)

    def busy(self):
        """True while words are left to play or the last one's ticks still run."""
        return _busy(self._state, self._ring.head)

    def played(self):  # ISR: no allocation
        """Words whose levels have appeared on the pins, modulo 2²⁹."""
        return _played(self._state)

    def rest(self, levels):
        """Put `levels` on the pins at once. Only while not busy."""
        _rest(self._state, levels)


@micropython.viper
def _run(state: ptr32, instruction: int):
    """Have the state machine, enabled or not, carry out one instruction."""
    ptr32(state[_SM])[4] = instruction


@micropython.viper
def _still(state: ptr32):
    """No DMA channel is active. None is enabled either: one that is aborted may set off the next (RP2350-E5). One that
    does not stop is left alone: the state machine does not run, and nothing is played any more."""
    for field in range(_A, _D + 1):
        channel = ptr32(state[field])
        channel[4] = channel[4] & ~1
    abort = ptr32(state[_ABORT])
    abort[0] = state[_CHANNELS]
    tries = _TRIES
    while abort[0] & state[_CHANNELS]:
        tries -= 1
        if tries == 0:
            state[_STUCK] = 1
            return


@micropython.viper
def _empty(state: ptr32):
    """The FIFO is empty: joining it otherwise and back does that."""
    flip = ptr32(state[_SM] + 0x1000)
    join = 1
    join <<= 31
    flip[2] = join
    flip[2] = join


@micropython.viper
def _quiet(state: ptr32):
    """State machine off and restarted, its FIFO empty, no DMA channel active."""
    bit = 1 << state[_NUMBER]
    ptr32(state[_PIO] + 0x3000)[0] = bit
    _still(state)
    _empty(state)
    ptr32(state[_PIO] + 0x2000)[0] = bit << 4 | bit << 8


@micropython.viper
def _set_up(state: ptr32):
    """After the program has been loaded: pins low but not yet driven."""
    sm = ptr32(state[_SM])
    state[_FIRST] = (sm[1] >> 7) & 31
    _quiet(state)
    sm[5] = state[_PINS]
    _put(state, 0)
    _run(state, 0x6000 | state[_BITS])  # out(pins, bits)


@micropython.viper
def _drive(state: ptr32):
    """The pins become outputs."""
    _put(state, (1 << state[_BITS]) - 1)
    _run(state, 0x6080 | state[_BITS])  # out(pindirs, bits)


@micropython.viper
def _put(state: ptr32, value: int):
    """Bring `value` into the state machine's OSR; its FIFO is empty."""
    ptr32(state[_PIO])[4 + state[_NUMBER]] = value
    _run(state, 0x8080)  # pull(noblock)


@micropython.viper
def _count(state: ptr32) -> int:
    """Words played, read off A, the FIFO and the state machine; read twice, until no word was just changing places."""
    pio = ptr32(state[_PIO])
    sm = ptr32(state[_SM])
    a = ptr32(state[_A])
    shift = state[_NUMBER] << 3
    read = 0
    level = 0
    address = 0
    tries = _TRIES
    while tries:
        read = a[0]
        level = (pio[3] >> shift) & 15
        address = sm[3]
        if a[0] == read and (pio[3] >> shift) & 15 == level:
            break
        tries -= 1
    if tries == 0:
        state[_STUCK] = 1
    armed = state[_ARMED]  # after the address: an interrupt in between only makes it larger
    left = (armed - ((read - state[_WORDS]) >> 2)) & state[_MASK]
    if address == state[_FIRST] + 1:
        left += 1
    return (armed - left - level) & COUNT_MASK


@micropython.viper
def _played(state: ptr32) -> int:
    if state[_PLAYING] == 1:
        return int(_count(state))
    return state[_PLAYED]


@micropython.viper
def _busy(state: ptr32, head: int) -> bool:
    if state[_PLAYING] == 0:
        return False
    sm = ptr32(state[_SM])
    if state[_PLAYING] == 1 and int(_count(state)) != head:
        return True
    return sm[3] != state[_FIRST]


@micropython.viper
def _halt(state: ptr32):
    ptr32(state[_PIO] + 0x3000)[0] = 1 << state[_NUMBER]  # the state machine stands still from here
    if state[_PLAYING] == 1:
        state[_PLAYED] = int(_count(state))
    state[_PLAYING] = 0
    ptr32(state[_PIO] + 0x2000)[0] = 16 << state[_NUMBER]  # restart: no delay is left over
    sm = ptr32(state[_SM])
    if state[_PULSE] >= 0:
        sm[4] = 0xE000  # set(pins, 0)
    sm[5] = state[_TOOL]
    sm[4] = 0xE000
    sm[5] = state[_PINS]
    _still(state)  # the FIFO stays as it is: an interrupted `_count` must still come out right


@micropython.viper
def _stop(state: ptr32):
    if state[_PLAYING] != 1:
        return
    sm = ptr32(state[_SM])
    bit = 1 << state[_NUMBER]
    ptr32(state[_PIO] + 0x3000)[0] = bit
    in_hand = 1 if sm[3] == state[_FIRST] + 1 else 0  # it will still be played
    state[_PLAYED] = (int(_count(state)) + in_hand) & COUNT_MASK
    state[_PLAYING] = 2
    _still(state)
    _empty(state)
    ptr32(state[_PIO] + 0x2000)[0] = bit


@micropython.viper
def _rest(state: ptr32, value: int):
    if state[_PLAYING] == 1:
        state[_PLAYED] = int(_count(state))
    state[_PLAYING] = 0
    _quiet(state)
    _put(state, value)
    _run(state, 0x6000 | state[_BITS])


@micropython.viper
def _resume(state: ptr32):
    """From standing still, or from the last word's end, to playing; the table is empty and its end mark read."""
    if state[_PLAYING] == 0:
        _quiet(state)
        if state[_PULSE] >= 0:
            _put(state, state[_PULSE])
            _run(state, 0xA0C7)  # mov(isr, osr)
        _run(state, state[_FIRST])  # jmp
        ptr32(state[_PIO] + 0x2000)[0] = 1 << state[_NUMBER]
    state[_ARMED] = state[_PLAYED]
    next_word = state[_WORDS] + ((state[_PLAYED] & state[_MASK]) << 2)
    state[_SLOT] = 0
    ptr32(state[_A])[0] = next_word
    ptr32(state[_ADDRESSES])[0] = next_word
    ptr32(state[_COUNTS])[0] = 0
    ptr32(state[_B])[0] = state[_ADDRESSES] + 4
    ptr32(state[_C])[0] = state[_COUNTS] + 4
    for field in range(_A, _D + 1):
        channel = ptr32(state[field])
        channel[4] = channel[4] | 1
    state[_PLAYING] = 1


@micropython.viper
def append(state: ptr32, head: int) -> bool:
    if state[_STUCK]:
        raise STUCK  # the feeding interrupt catches it, and the main loop ends with it: outputs safe, a report
    if state[_HELD]:
        return False
    dry = False
    if state[_PLAYING] != 1:
        _resume(state)
    elif ptr32(state[_SM])[3] == state[_FIRST] and int(_count(state)) == state[_ARMED]:
        dry = True
    counts = ptr32(state[_COUNTS])
    addresses = ptr32(state[_ADDRESSES])
    b = ptr32(state[_B])
    c = ptr32(state[_C])
    mask = state[_MASK]
    first = state[_SLOT]
    after = (first + 1) & (_RUNS - 1)
    ended = 0  # 1 once the chain has read the end mark in `first`: it has to be set going again
    if ((c[0] - state[_COUNTS]) >> 2) & (_RUNS - 1) == after:
        ended = 1
    count = (head - state[_ARMED]) & COUNT_MASK
    while count:
        slot = state[_SLOT]
        waiting = (slot - ((c[0] - state[_COUNTS]) >> 2)) & (_RUNS - 1)
        if waiting >= _RUNS - _SPARE and ended == 0:
            break
        run = mask + 1 - (state[_ARMED] & mask)
        if run > count:
            run = count
        armed = (state[_ARMED] + run) & COUNT_MASK
        following = (slot + 1) & (_RUNS - 1)
        addresses[following] = state[_WORDS] + ((armed & mask) << 2)
        counts[following] = 0
        state[_ARMED] = armed
        state[_SLOT] = following
        counts[slot] = run  # last, over the end mark: from here on the chain may take it
        count -= run
    if state[_SLOT] == first:
        return False
    if ended == 0:
        # The chain may have read the end mark just before it was replaced: then C stands behind it and A rests.
        place = c[0]
        active = (ptr32(state[_A])[3] | ptr32(state[_D])[3] | b[3] | c[3]) & state[_BUSY]
        if ((place - state[_COUNTS]) >> 2) & (_RUNS - 1) == after and active == 0 and c[0] == place:
            ended = 1
    if ended and state[_HELD] == 0:
        c[0] = state[_COUNTS] + (first << 2)
        b[15] = state[_ADDRESSES] + (first << 2)
    return dry
