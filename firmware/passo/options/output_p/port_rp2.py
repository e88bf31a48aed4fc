"""Outputs that change with a step, on a chip: the state machine raises its interrupt as each word begins, and while a change lies ahead
machine code looks which word that is.

Edges come 1.1 µs behind their step (tests_host/options/output_p/test_pico_outputs.py). Costs nothing while no change lies ahead, else that a word.
"""
# Shared with interrupts: switches, state, own

from array import array

import micropython
import uctypes
from machine import mem32
from micropython import const

from passo.options.output_p.steps import SWITCH_ASKED, SWITCH_FIELDS, SWITCH_FIRST, SWITCH_MOST, SWITCH_NEVER, SWITCH_SHOWN, SWITCH_VALUE, SWITCH_WORD
from passo.ports.rp2 import chip, vectors
from passo.ports.rp2.fields import *
from passo.ports.rp2.pio_player import _words_played
from passo.ports.rp2.registers import *
from passo.records import COUNT_HALF, COUNT_MASK

_STATE = const(0)  # addresses: the player's state, the changes, the register that turns pins over, the mask of interrupts
_SWITCHES = const(1)
_TOGGLE = const(2)
_ENABLE = const(3)


class PinSwitches:
    def __init__(self):
        self._own = None

    def join(self, feeder, player):
        """Take the player, a PioPlayer."""
        self._player = player

    def show_switches(self, switches):
        """Have the player show the changes asked of `switches` from here on."""
        player = self._player
        state = player._state
        enable = state[PIO_BLOCK] + vectors.IRQ1_INTE
        self._own = array("I", [uctypes.addressof(state), uctypes.addressof(switches.marks), chip.TOGGLE, enable])
        self._entry = vectors.enter(vectors.PIO_IRQ_1, _show_due, self._own)
        switches.join(self.expect_words)
        player.start = switches.start

    @micropython.native
    def expect_words(self):  # ISR: no allocation
        """Enable the interrupt; see Switches.join()."""
        _enable_interrupt(self._own)

    def close(self):
        """Disable the interrupt."""
        if self._own:
            vectors.leave(vectors.PIO_IRQ_1)
            mem32[self._own[_ENABLE]] = 0


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return PinSwitches()


@micropython.viper
def _enable_interrupt(own: ptr32):  # ISR: no allocation
    """Enable the interrupt of each word; it comes at once if a word has begun since it came last."""
    ptr32(own[_ENABLE])[0] = 256 << ptr32(own[_STATE])[PIO_NUMBER]


@micropython.viper
def _show_due(own: ptr32):  # ISR: no allocation
    """Show the changes that are due with the word that has begun. Called in its interrupt, 1.1 µs behind the step."""
    state = ptr32(own[_STATE])
    switches = ptr32(own[_SWITCHES])
    pins = ptr32(0xD0000010)
    toggle = ptr32(own[_TOGGLE])
    ptr32(state[PIO_BLOCK])[BLOCK_IRQ] = 1 << state[PIO_NUMBER]  # the next word raises it again
    begun = int(_words_played(state)) - 1
    while switches[SWITCH_SHOWN] != switches[SWITCH_ASKED]:
        at = SWITCH_FIRST + (switches[SWITCH_SHOWN] & (SWITCH_MOST - 1)) * SWITCH_FIELDS
        word = switches[at + SWITCH_WORD]
        if word == SWITCH_NEVER:
            break
        if (begun - word) & COUNT_MASK >= COUNT_HALF:
            return
        pin = switches[at + SWITCH_VALUE] >> 1
        toggle[0] = (pins[0] ^ (switches[at + SWITCH_VALUE] & 1) << pin) & 1 << pin
        switches[SWITCH_SHOWN] = (switches[SWITCH_SHOWN] + 1) & COUNT_MASK
    ptr32(own[_ENABLE])[0] = 0  # until start() finds another
