"""The waveform player of a laser: its power changes with the very word that it is marked at.

    A ──► D ──► B ──► C ──► A

A fourth DMA channel, D, takes part in the chain of pio_player.py: as a run of words ends it copies a number from a third
table to the PWM's compare register. Runs are cut eight words behind each mark. A has put the last of these into the
FIFO as the marked word left it for the pins, so that the power changes within a microsecond of its levels; the PWM
takes it up at its next wrap.

If fewer than eight words lie ahead, below 750 steps/s or so, the interrupt that feeds sets the mark's power within 3 ms of its word.
"""
# Shared with interrupts: state, power

from array import array

import micropython
import rp2
import uctypes
from machine import mem32
from micropython import const

from passo.ports.rp2 import chip
from passo.ports.rp2.fields import *
from passo.ports.rp2.pio_player import STUCK, PioPlayer, append
from passo.ports.rp2.registers import CHANNEL_READ
from passo.records import *
from passo.steps.power import scale

_RUN_BITS = const(7)  # 12 000 dots a second are 126 runs in 10.5 ms
_TABLE = const(512)  # bytes: one number for each run
_TABLE_RING = const(9)
_CC = const(12)  # registers of a PWM slice
_TOP = const(16)
_SLICE = const(20)
# An array of our own.
_DUTIES = const(0)  # addresses
_COMPARE = const(1)
_FULL = const(2)  # the duty that is always on
_MARK = const(3)  # the next one that D does not have; they count for ever, modulo 2²⁹
_DUTY = const(4)  # behind the last one that it has
_REST = const(5)  # of that: the rest of rounding for the next, so that short segments of a ramp add up to their energy
_PARTS = const(16_000)  # POWER_MOST << POWER_FINE: of a mark's full power
_LASER_RING = const(1024)  # words: beside a larger ring there is no memory for this player


def create(board, ring, layout, pins, pulse_ticks, min_word_ticks, invert, halt_pin):
    """Return the player of a checked board, without the power if the ring is large; `halt_pin()` is asked for the Pin that halts."""
    rest = ring, layout, pins[0], pulse_ticks, min_word_ticks, invert, halt_pin()
    return PioPlayer(*rest) if ring.size > _LASER_RING else LaserPlayer(board["spindle"]["pin"], *rest)


class LaserPlayer(PioPlayer):
    """`pin`: that of the PWM, which has been set up; the rest as PioPlayer's."""

    run_bits = _RUN_BITS

    def __init__(self, pin, ring, *rest):
        compare = chip.PWM + _SLICE * (pin >> 1 & 7) + _CC
        self._table = bytearray(2 * _TABLE)
        table = (uctypes.addressof(self._table) + _TABLE - 1) & ~(_TABLE - 1)
        self._laser = array("I", [table, compare, mem32[compare - _CC + _TOP] + 1, 0, 0, _PARTS >> 1])
        self._power = ring.power
        PioPlayer.__init__(self, ring, *rest)

    def _set_up_dma(self, channel_a, after_a=None):
        """Set up the DMA channels of PioPlayer, and channel D behind A: it copies a duty to the PWM's compare register."""
        d = self._last = rp2.DMA()
        PioPlayer._set_up_dma(self, channel_a, d.channel)
        ctrl = d.pack_ctrl(
            size=2, inc_write=False, high_pri=True, ring_size=_TABLE_RING, ring_sel=False, chain_to=self._dma[1].channel
        )
        d.config(read=self._laser[_DUTIES], write=self._laser[_COMPARE], count=1, ctrl=ctrl)
        self._state[PIO_D] = 0x50000000 + 0x40 * d.channel
        self._state[PIO_CHANNELS] |= 1 << d.channel

    @micropython.native
    def show(self, level):  # ISR: no allocation
        """The power is `level`, 0 … 1000, at once. While words play start() does it, so that an older power that D has does not show again."""
        state = self._state
        told = (self._laser[_MARK] - self._power.marks[POWER_TAIL]) & COUNT_MASK  # marks that D has, and nobody has taken up yet
        coming = level and 0 < told < COUNT_HALF
        if state[PIO_HELD] or state[PIO_PLAYING] != 1 or self._ring.head == self.words_played() and not coming:
            _show(state, self._laser, level * self._laser[_FULL] // 1000, 0)

    @micropython.native
    def start(self):  # ISR: no allocation
        """As PioPlayer.start(). A power that D does not have, or that is not the mark's any more, shows now."""
        state = self._state
        if state[PIO_STUCK]:
            raise STUCK
        power = self._power
        return hand_over(state, self._laser, power.marks, self._ring.head, power.fine)


@micropython.viper
def hand_over(state: ptr32, laser: ptr32, power: ptr32, head: int, level: int) -> bool:
    """Append the words up to `head`, in runs that end with the marks; `level`: the power shown, as a mark's. True if the player ran dry meanwhile."""
    if state[PIO_HELD]:
        return False
    mark = int(first_mark(state, laser, power, level))
    last = power[POWER_HEAD]
    full = laser[_FULL]
    dry = False
    while mark != last:
        marked = power[POWER_MARKS + (mark & power[POWER_MASK])]
        word = (head - ((head - (marked >> POWER_WORD)) & POWER_WORDS) + POWER_AHEAD) & COUNT_MASK
        if (head - word) & COUNT_MASK >= COUNT_HALF:
            break
        value = int(scale(power, marked & POWER_LEVEL)) * full + laser[_REST]
        duty = value // _PARTS
        if not _tell(state, laser, word, laser[_DUTY], duty):
            break
        if append(state, word):
            dry = True
        if state[PIO_ARMED] != word:  # no room for more runs
            laser[_MARK] = mark
            return dry
        laser[_DUTY] = duty
        laser[_REST] = value % _PARTS
        mark = (mark + 1) & COUNT_MASK
    laser[_MARK] = mark
    _tell(state, laser, head, laser[_DUTY], laser[_DUTY])
    if append(state, head):
        dry = True
    return dry


@micropython.viper
def first_mark(state: ptr32, laser: ptr32, power: ptr32, level: int) -> int:
    """Return the next mark that D does not have. If all that it has have been played, `level` shows; before the first word its own."""
    mark = laser[_MARK]
    tail = power[POWER_TAIL]
    if state[PIO_PLAYING] != 1 or (mark - tail) & COUNT_MASK >= COUNT_HALF:
        mark = tail
    if mark == tail:
        laser[_DUTY] = (level * laser[_FULL] + (_PARTS >> 1)) // _PARTS
        _show(state, laser, laser[_DUTY], state[PIO_LAST] + 1)
    if state[PIO_PLAYING] != 1 and mark != power[POWER_HEAD]:
        marked = power[POWER_MARKS + (mark & power[POWER_MASK])]
        if ((marked >> POWER_WORD) - state[PIO_PLAYED]) & POWER_WORDS < 2:  # behind a word that only turns: so few words may be there
            laser[_DUTY] = (int(scale(power, marked & POWER_LEVEL)) * laser[_FULL] + (_PARTS >> 1)) // _PARTS
            _show(state, laser, laser[_DUTY], state[PIO_LAST] + 1)
            mark = (mark + 1) & COUNT_MASK
    return mark


@micropython.viper
def _show(state: ptr32, laser: ptr32, duty: int, runs: int):
    """Show a duty at once, and after `runs` runs: all of them if D has no mark that is still to come. While held it is
    dark, also where the halt comes in between."""
    duty |= duty << 16  # for both outputs of the slice
    compare = ptr32(laser[_COMPARE])
    if state[PIO_HELD] == 0:
        compare[0] = duty
    if state[PIO_HELD]:
        compare[0] = 0
    duties = ptr32(laser[_DUTIES])
    while runs:
        runs -= 1
        duties[runs] = duty


@micropython.viper
def _tell(state: ptr32, laser: ptr32, word: int, before: int, duty: int) -> bool:
    """Give D the duty for the end of the words up to `word`, which are to be appended next; `before`: the end of the first of two runs, if
    the ring ends among them. False if they have been appended already.
    """
    duties = ptr32(laser[_DUTIES])
    slot = 0
    armed = state[PIO_PLAYED]
    if state[PIO_PLAYING] == 1:
        slot = state[PIO_SLOT]
        armed = state[PIO_ARMED]
    else:
        ptr32(state[PIO_D])[CHANNEL_READ] = laser[_DUTIES]
    count = (word - armed) & COUNT_MASK
    if count >= COUNT_HALF:
        return False
    if count > state[PIO_MASK] + 1 - (armed & state[PIO_MASK]):
        duties[slot] = before << 16 | before
        slot = (slot + 1) & state[PIO_LAST]
    duties[slot] = duty << 16 | duty
    return True
