"""The timer-interrupt player, for pins in any order: a state machine counts the ticks, an interrupt sets the pins.

The state machine takes words from its FIFO, raises its interrupt as each begins and waits for its ticks: it is a timer
of varying period that does not drift. The interrupt plays every word that has begun, and refills the FIFO, six words
ahead. Edges come some microseconds after their time, and totals are exact. Measured with three axes and garbage
collected without pause: to 36 kHz the lateness varies by 3.2 µs; at 42 kHz the processor no longer keeps up.
"""

from array import array

import micropython
import rp2
import uctypes
from machine import Pin
from micropython import const

from passo.ports.rp2 import chip, programs
from passo.records import COUNT_MASK

SHORTEST_TICKS = const(500)  # 40 µs

_DEEP = const(6)  # words in the FIFO of eight

# Fields of the state that the viper functions share; the first group does not change.
_PIO = const(0)
_SM = const(1)
_NUMBER = const(2)
_FIRST = const(3)
_WORDS = const(4)
_MASK = const(5)
_BITS = const(6)
_TABLES = const(7)  # from levels to pins: 128 entries for the low seven bits, 128 for those above
_ALL = const(8)  # pins of all levels
_STEPS = const(9)  # pins of the pulses
_TOOL = const(10)  # pin of the tool
_INVERT = const(11)  # pins whose level is the opposite of the word's
_SPIN = const(12)  # turns of the loop that a pulse lasts, some twenty cycles each
_PLAYING = const(13)
_GIVEN = const(14)  # words given to the state machine, modulo 2²⁹
_PLAYED = const(15)
_HELD = const(16)
_TOGGLE = const(17)  # address of the register that turns pins over


class TimerPlayer:
    """`pins`: of the word's bits, lowest first; `invert`: mask of bits whose electrical level is the opposite;
    `pulse_ticks`: 0 for coils."""

    def __init__(self, ring, layout, pins, pulse_ticks, min_word_ticks, invert, machine_id=0):
        self.min_word_ticks = min_word_ticks
        self._ring = ring
        block, number = divmod(machine_id, 4)
        cycles = chip.cycles_per_tick()
        self._machine = rp2.StateMachine(machine_id, programs.clock(layout.bits, cycles))
        self._tables = array("I", [0] * 256)
        for bit in range(layout.bits):
            half, place = divmod(bit, 7)
            for levels in range(128):
                if levels >> place & 1:
                    self._tables[128 * half + levels] |= 1 << pins[bit]
        pio = 0x50200000 + 0x100000 * block
        inverted = 0
        for bit in range(layout.bits):
            inverted |= (invert >> bit & 1) << pins[bit]
        pulses = 0
        for bit in range(layout.bits):
            pulses |= (layout.pulse_mask >> bit & 1) << pins[bit]
        self._state = array("I", [0] * 18)
        for index, value in (
            (_PIO, pio), (_SM, pio + 0xC8 + 0x18 * number), (_NUMBER, number), (_WORDS, uctypes.addressof(ring.words)),
            (_MASK, ring.mask), (_BITS, layout.bits), (_TABLES, uctypes.addressof(self._tables)), (_ALL, 0),
            (_STEPS, pulses), (_TOOL, 1 << pins[-1]), (_INVERT, inverted), (_SPIN, pulse_ticks * cycles // 16),
            (_TOGGLE, chip.TOGGLE),
        ):  # fmt: skip
            self._state[index] = value
        for bit in range(layout.bits):
            self._state[_ALL] |= 1 << pins[bit]
            Pin(pins[bit], Pin.OUT, value=invert >> bit & 1)
        _set_up(self._state)
        self._machine.irq(self._begun, hard=True)

    @micropython.viper
    def _begun(self, machine):  # ISR: no allocation
        state = ptr32(self._state)
        head = int(self._ring.head)
        if state[_PLAYING] != 1:
            return
        words = ptr32(state[_WORDS])
        table = ptr32(state[_TABLES])
        pins = ptr32(0xD0000010)
        toggle = ptr32(state[_TOGGLE])
        pio = ptr32(state[_PIO])
        shift = state[_NUMBER] << 3
        mask = state[_MASK]
        played = state[_PLAYED]
        given = state[_GIVEN]
        level = (pio[3] >> shift) & 15
        while (given - level - played) & COUNT_MASK:  # usually one word; more where the interrupt came late
            word = words[played & mask]
            want = (table[word & 127] | table[128 + ((word >> 7) & 127)]) ^ state[_INVERT]
            toggle[0] = (pins[0] ^ want) & state[_ALL]
            played = (played + 1) & COUNT_MASK
            state[_PLAYED] = played
            if state[_STEPS]:
                spin = state[_SPIN]
                while spin > 0:
                    spin -= 1
                toggle[0] = (pins[0] ^ state[_INVERT]) & state[_STEPS]
            level = (pio[3] >> shift) & 15
        while given != head and level < _DEEP:
            pio[4 + state[_NUMBER]] = words[given & mask]
            given = (given + 1) & COUNT_MASK
            level += 1
        state[_GIVEN] = given

    def start(self):  # ISR: no allocation
        """Play from the ring what is published there; call it again when there is more."""
        _start(self._state, self._ring.head)

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
        _show(self._state, levels)


@micropython.viper
def _set_up(state: ptr32):
    sm = ptr32(state[_SM])
    state[_FIRST] = (sm[1] >> 7) & 31


@micropython.viper
def _show(state: ptr32, levels: int):
    """Put the levels of a word on the pins: those that change, all at once."""
    table = ptr32(state[_TABLES])
    pins = ptr32(0xD0000010)
    toggle = ptr32(state[_TOGGLE])
    want = (table[levels & 127] | table[128 + ((levels >> 7) & 127)]) ^ state[_INVERT]
    toggle[0] = (pins[0] ^ want) & state[_ALL]


@micropython.viper
def _start(state: ptr32, head: int):
    number = state[_NUMBER]
    if state[_HELD]:
        return
    if state[_PLAYING] == 0:
        _still(state)
        state[_GIVEN] = state[_PLAYED]
        ptr32(state[_SM])[4] = state[_FIRST]  # jmp
        ptr32(state[_PIO] + 0x2000)[0] = 1 << number
    if state[_PLAYING] == 2:
        state[_GIVEN] = state[_PLAYED]
    state[_PLAYING] = 1
    given = state[_GIVEN]
    if given == state[_PLAYED] and given != head and state[_HELD] == 0:
        # None is left to raise the interrupt. It takes over with this one, before the next line here.
        state[_GIVEN] = (given + 1) & COUNT_MASK
        ptr32(state[_PIO])[4 + number] = ptr32(state[_WORDS])[given & state[_MASK]]


@micropython.viper
def _still(state: ptr32):
    """State machine off and restarted, FIFO and interrupt cleared."""
    bit = 1 << state[_NUMBER]
    ptr32(state[_PIO] + 0x3000)[0] = bit
    _empty(state)
    ptr32(state[_PIO] + 0x2000)[0] = bit << 4 | bit << 8
    ptr32(state[_PIO])[12] = bit


@micropython.viper
def _empty(state: ptr32):
    """The FIFO is empty: joining it otherwise and back does that."""
    flip = ptr32(state[_SM] + 0x1000)
    join = 1
    join <<= 31
    flip[2] = join
    flip[2] = join


@micropython.viper
def _halt(state: ptr32):
    ptr32(state[_PIO] + 0x3000)[0] = 1 << state[_NUMBER]
    state[_PLAYING] = 0
    pins = ptr32(0xD0000010)
    toggle = ptr32(state[_TOGGLE])
    toggle[0] = (pins[0] ^ state[_INVERT]) & (state[_STEPS] | state[_TOOL])


@micropython.viper
def _stop(state: ptr32):
    if state[_PLAYING] != 1:
        return
    state[_PLAYING] = 2
    bit = 1 << state[_NUMBER]
    ptr32(state[_PIO] + 0x3000)[0] = bit
    _empty(state)
    ptr32(state[_PIO] + 0x2000)[0] = bit


@micropython.viper
def _busy(state: ptr32, head: int) -> bool:
    if state[_PLAYING] == 0:
        return False
    if state[_PLAYING] == 1 and state[_PLAYED] != head:
        return True
    return ptr32(state[_SM])[3] != state[_FIRST]


@micropython.viper
def _played(state: ptr32) -> int:
    return state[_PLAYED]
