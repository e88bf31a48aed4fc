"""The timer-interrupt player, for pins in any order: a state machine counts the ticks, an interrupt sets the pins.

The state machine takes words from its FIFO, raises its interrupt as each begins and waits for its ticks: it is a timer
of varying period that does not drift. The interrupt plays every word that has begun, and refills the FIFO, six words
ahead. It comes straight from the chip's vectors to machine code in memory, before all other interrupts; MicroPython's own
way, through flash and behind USB, takes 5 µs and up to 13 more. Edges come a microsecond or two after their time, and totals
are exact.
"""
# Shared with interrupts: state

from array import array

import micropython
import rp2
import uctypes
from machine import Pin, mem32
from micropython import const

from passo.ports.rp2 import chip, programs, vectors
from passo.ports.rp2.registers import *
from passo.records import COUNT_MASK

SHORTEST_TICKS = const(500)  # 40 µs

_DEEP = const(6)  # words in the FIFO of eight

# The player's state, an array('I'). First what does not change.
TIMER_BLOCK = const(0)  # addresses: PIO block, state machine
TIMER_MACHINE = const(1)
TIMER_NUMBER = const(2)  # of the state machine in its block
TIMER_FIRST = const(3)  # address of the program
TIMER_WORDS = const(4)  # address of the ring's words
TIMER_MASK = const(5)  # the ring's size − 1
TIMER_BITS = const(6)  # of a word's levels
TIMER_TABLES = const(7)  # address: from levels to pins: 128 entries for the low seven bits, 128 for those above
TIMER_ALL = const(8)  # mask of the pins of all levels
TIMER_STEPS = const(9)  # of the pulses
TIMER_TOOL = const(10)  # of the tool
TIMER_INVERT = const(11)  # of those whose level is the opposite of the word's
TIMER_CYCLES = const(12)  # of the processor, that a pulse lasts
TIMER_PLAYING = const(13)  # as PIO_PLAYING
TIMER_GIVEN = const(14)  # words given to the state machine, modulo 2²⁹
TIMER_PLAYED = const(15)  # words whose levels have appeared, modulo 2²⁹
TIMER_HELD = const(16)  # 1: start() does nothing
TIMER_TOGGLE = const(17)  # address of the register that turns pins over
TIMER_HEAD = const(18)  # words of the ring that are published, modulo 2²⁹
TIMER_FIELDS = const(19)


def create(board, ring, layout, pins, pulse_ticks, min_word_ticks, invert, halt_pin):
    """Return the player of a checked board. It halts by the interrupts of the pins, not by `halt_pin`."""
    return TimerPlayer(ring, layout, pins, pulse_ticks, max(min_word_ticks, SHORTEST_TICKS), invert)


class TimerPlayer:
    """`pins`: of the word's bits, lowest first; `invert`: mask of bits whose electrical level is the opposite;
    `pulse_ticks`: 0 for coils. Methods as in pio_player.py."""

    def __init__(self, ring, layout, pins, pulse_ticks, min_word_ticks, invert):
        self.min_word_ticks = min_word_ticks
        self._ring = ring
        cycles = chip.cycles_per_tick()
        self._machine = rp2.StateMachine(0, programs.levels(layout.bits, cycles, False, False))
        self._tables = array("I", [0] * 256)
        state = self._state = array("I", [0] * TIMER_FIELDS)
        for index, value in (
            (TIMER_BLOCK, programs.PIO_0), (TIMER_MACHINE, programs.PIO_0 + 0xC8),
            (TIMER_WORDS, uctypes.addressof(ring.words)), (TIMER_MASK, ring.mask), (TIMER_BITS, layout.bits),
            (TIMER_TABLES, uctypes.addressof(self._tables)), (TIMER_TOOL, 1 << pins[-1]),
            (TIMER_CYCLES, pulse_ticks * cycles), (TIMER_TOGGLE, chip.TOGGLE),
        ):  # fmt: skip
            state[index] = value
        for bit in range(layout.bits):
            half, shift = divmod(bit, 7)
            for levels in range(128):
                if levels >> shift & 1:
                    self._tables[128 * half + levels] |= 1 << pins[bit]
            state[TIMER_ALL] |= 1 << pins[bit]
            state[TIMER_STEPS] |= (layout.pulse_mask >> bit & 1) << pins[bit]
            state[TIMER_INVERT] |= (invert >> bit & 1) << pins[bit]
            Pin(pins[bit], Pin.OUT, value=invert >> bit & 1)
        state[TIMER_FIRST] = (mem32[state[TIMER_MACHINE] + 4 * MACHINE_EXECCTRL] >> 7) & 31
        self._entry = vectors.enter(vectors.PIO_IRQ_1, _play_and_refill, state)
        mem32[programs.PIO_0 + vectors.IRQ1_INTE] = 256

    def close(self):
        """Give back the interrupt."""
        vectors.leave(vectors.PIO_IRQ_1)
        mem32[programs.PIO_0 + vectors.IRQ1_INTE] = 0

    def start(self):  # ISR: no allocation
        """Play from the ring what is published there; call it again when there is more."""
        _start(self._state, self._ring.head)

    def hold(self, on):  # ISR: no allocation
        """While `on`, start() does nothing."""
        self._state[TIMER_HELD] = on

    def stop(self):
        """Play no further word after the one under way."""
        _stop(self._state)

    def halt(self):  # ISR: no allocation
        """Stop at once: no further step, the tool drops; the other pins keep their levels."""
        _halt(self._state)

    def busy(self):
        """Return True while words are left to play or the last one's ticks still run."""
        return _busy(self._state, self._ring.head)

    def words_played(self):  # ISR: no allocation
        """Return the words whose levels have appeared on the pins, modulo 2²⁹."""
        return self._state[TIMER_PLAYED]

    def rest(self, levels):
        """Put `levels` on the pins at once. Only while not busy."""
        _show(self._state, levels)


# A word's pins are set within 2 µs (make bench ARGS=timer).
@micropython.viper
def _play_and_refill(state: ptr32):  # ISR: no allocation
    """Play the words that have begun, and refill the FIFO."""
    number = state[TIMER_NUMBER]
    shift = number << 3
    pio = ptr32(state[TIMER_BLOCK])
    pio[BLOCK_IRQ] = 1 << number  # the next word raises it again
    if state[TIMER_PLAYING] != 1:
        return
    words = ptr32(state[TIMER_WORDS])
    mask = state[TIMER_MASK]
    played = state[TIMER_PLAYED]
    given = state[TIMER_GIVEN]
    level = (pio[BLOCK_FLEVEL] >> shift) & 15
    while (given - level - played) & COUNT_MASK:  # usually one word; more if the interrupt came late
        _show(state, words[played & mask])
        played = (played + 1) & COUNT_MASK
        state[TIMER_PLAYED] = played
        if state[TIMER_STEPS]:
            _wait(state[TIMER_CYCLES])
            _drop(state, state[TIMER_STEPS])
        level = (pio[BLOCK_FLEVEL] >> shift) & 15
    while given != state[TIMER_HEAD] and level < _DEEP:
        pio[BLOCK_TXF + number] = words[given & mask]
        given = (given + 1) & COUNT_MASK
        level += 1
    state[TIMER_GIVEN] = given


@micropython.viper
def _show(state: ptr32, levels: int):
    """Put the levels of a word on the pins: those that change, all at once."""
    table = ptr32(state[TIMER_TABLES])
    pins = ptr32(0xD0000010)
    toggle = ptr32(state[TIMER_TOGGLE])
    want = (table[levels & 127] | table[128 + ((levels >> 7) & 127)]) ^ state[TIMER_INVERT]
    toggle[0] = (pins[0] ^ want) & state[TIMER_ALL]


@micropython.viper
def _wait(cycles: int):
    """Wait for `cycles` cycles of the processor, less than 2²⁴, by SysTick, which counts down."""
    clock = ptr32(0xE000E010)
    begun = clock[SYSTICK_NOW]
    tries = cycles  # each look takes a cycle at least: if SysTick stands still, the wait ends all the same
    while ((begun - clock[SYSTICK_NOW]) & 0xFFFFFF) < cycles:
        tries -= 1
        if tries == 0:
            return


@micropython.viper
def _drop(state: ptr32, pulses: int):
    """Bring these pins, pulses' and the tool's, to their inactive level."""
    pins = ptr32(0xD0000010)
    toggle = ptr32(state[TIMER_TOGGLE])
    toggle[0] = (pins[0] ^ state[TIMER_INVERT]) & pulses


@micropython.viper
def _start(state: ptr32, head: int):
    """Play the ring's words up to `head`; from a stand, give the state machine the first of them."""
    number = state[TIMER_NUMBER]
    if state[TIMER_HELD]:
        return
    if state[TIMER_PLAYING] == 0:
        _still(state)
        state[TIMER_GIVEN] = state[TIMER_PLAYED]
        ptr32(state[TIMER_MACHINE])[MACHINE_INSTR] = state[TIMER_FIRST]  # jmp
        ptr32(state[TIMER_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = 1 << number
    if state[TIMER_PLAYING] == 2:
        state[TIMER_GIVEN] = state[TIMER_PLAYED]
    state[TIMER_HEAD] = head
    state[TIMER_PLAYING] = 1
    given = state[TIMER_GIVEN]
    if given == state[TIMER_PLAYED] and given != head and state[TIMER_HELD] == 0:
        # None is left to raise the interrupt. It takes over with this one, before the next line here.
        state[TIMER_GIVEN] = (given + 1) & COUNT_MASK
        ptr32(state[TIMER_BLOCK])[BLOCK_TXF + number] = ptr32(state[TIMER_WORDS])[given & state[TIMER_MASK]]


@micropython.viper
def _still(state: ptr32):
    """Switch the state machine off and restart it, with its FIFO and interrupt cleared."""
    bit = 1 << state[TIMER_NUMBER]
    ptr32(state[TIMER_BLOCK] + ALIAS_CLEAR)[BLOCK_CTRL] = bit
    _empty(state)
    ptr32(state[TIMER_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = bit << 4 | bit << 8
    ptr32(state[TIMER_BLOCK])[BLOCK_IRQ] = bit


@micropython.viper
def _empty(state: ptr32):
    """Empty the FIFO: joining it otherwise and back does that."""
    flip = ptr32(state[TIMER_MACHINE] + ALIAS_XOR)
    join = 1
    join <<= 31
    flip[MACHINE_SHIFTCTRL] = join
    flip[MACHINE_SHIFTCTRL] = join


@micropython.viper
def _halt(state: ptr32):
    ptr32(state[TIMER_BLOCK] + ALIAS_CLEAR)[BLOCK_CTRL] = 1 << state[TIMER_NUMBER]
    state[TIMER_PLAYING] = 0
    _drop(state, state[TIMER_STEPS] | state[TIMER_TOOL])


@micropython.viper
def _stop(state: ptr32):
    """Stop behind the word that plays now: empty the FIFO, and let its ticks run out."""
    if state[TIMER_PLAYING] != 1:
        return
    state[TIMER_PLAYING] = 2
    bit = 1 << state[TIMER_NUMBER]
    ptr32(state[TIMER_BLOCK] + ALIAS_CLEAR)[BLOCK_CTRL] = bit
    _empty(state)
    ptr32(state[TIMER_BLOCK] + ALIAS_SET)[BLOCK_CTRL] = bit


@micropython.viper
def _busy(state: ptr32, head: int) -> bool:
    if state[TIMER_PLAYING] == 0:
        return False
    if state[TIMER_PLAYING] == 1 and state[TIMER_PLAYED] != head:
        return True
    return ptr32(state[TIMER_MACHINE])[MACHINE_ADDR] != state[TIMER_FIRST]

