"""The player of the ESP32: a timer's callback plays the words that fall due before it comes again.

Every 250 µs it waits for each word due in that time and sets the pins by the GPIO's set and clear registers, clearing
first. Callbacks here are soft: they come between two bytecodes of the main loop, not while machine code runs, words are
made or garbage is collected. So an edge is a few µs off at best, up to about a millisecond late in ordinary use, and some
tens of milliseconds where memory is collected. A late word moves all that follow: no interval is ever shorter than its
word by more than 20 µs, no step is lost, and the motion takes longer. 5000 words a second are the most; from some 1500
on the waiting takes most of the processor.
"""

from array import array
from time import ticks_add, ticks_diff, ticks_us

import micropython
from machine import Pin, Timer, mem32
from micropython import const

from passo.ports.esp32.chip import gpio_base
from passo.records import COUNT_MASK

SHORTEST_TICKS = const(2500)  # 200 µs
WINDOW_US = const(250)
SLACK_US = const(20)  # a word later than this moves those behind it
_TICKS = const(25)  # in 2 µs


class Bank:
    """Up to 32 neighbouring pins, which one register raises and another lowers."""

    def __init__(self, number, pins, layout, invert):
        """`pins`: of the word's bits, lowest first; those of other banks are left alone."""
        self.raising = gpio_base() + (0x14 if number else 0x08)  # bank 0: pins 0 … 31; bank 1: from 32 on
        self.lowering = self.raising + 4
        self.table = array("I", [0] * 256)  # from levels to pins: 128 for the low seven bits, 128 for those above
        self.all = self.pulses = self.tool = self.invert = 0
        for bit in range(len(pins)):
            if pins[bit] // 32 != number:
                continue
            pin = 1 << pins[bit] % 32
            self.all |= pin
            self.invert |= pin if invert >> bit & 1 else 0
            self.pulses |= pin if layout.pulse_mask >> bit & 1 else 0
            self.tool |= pin if layout.tool_mask >> bit & 1 else 0
            half, index = divmod(bit, 7)
            for levels in range(128):
                if levels >> index & 1:
                    self.table[128 * half + levels] |= pin

    @micropython.native
    def show(self, levels):
        """Put a word's levels on the pins."""
        table = self.table
        high = (table[levels & 127] | table[128 + (levels >> 7 & 127)]) ^ self.invert
        mem32[self.lowering] = self.all & ~high
        mem32[self.raising] = high

    @micropython.native
    def drop(self, pins):
        """Bring `pins` to their inactive level."""
        if pins:
            mem32[self.lowering] = pins & ~self.invert
            mem32[self.raising] = pins & self.invert


class TimerPlayer:
    """`pins`: of the word's bits, lowest first; `invert`: mask of bits whose electrical level is the opposite;
    `pulse_ticks`: 0 for coils. Methods as in virtual_player.py."""

    def __init__(self, ring, layout, pins, pulse_ticks, min_word_ticks, invert):
        self.min_word_ticks = max(min_word_ticks, SHORTEST_TICKS)
        self.late = 0  # words that came more than SLACK_US after their time
        self._ring = ring
        self._bits = layout.bits
        self._levels = layout.levels_mask
        self._pulse_us = -(-pulse_ticks * 2 // _TICKS)
        self._banks = [Bank(number, pins, layout, invert) for number in sorted(set([pin // 32 for pin in pins]))]
        self._playing = self._held = self._ending = False
        self._played = 0
        self._due_us = 0  # when the word under way ends and the next begins
        self._rest = 0  # 25ths of 2 µs that have not made a whole one yet
        self._timer = Timer(0)
        for bit in range(len(pins)):
            Pin(pins[bit], Pin.OUT, value=invert >> bit & 1)

    def start(self):
        """Play from the ring what is published there, from WINDOW_US on; call it again when there is more."""
        self._ending = False
        if self._playing or self._held or self._played == self._ring.head:
            return
        self._due_us = ticks_add(ticks_us(), WINDOW_US)
        self._rest = 0
        self._playing = True
        self._timer.init(mode=Timer.PERIODIC, freq=1_000_000 // WINDOW_US, callback=self._play_due)

    @micropython.native
    def _play_due(self, timer):
        """Play all words that are due before the next call."""
        while self._playing:
            if ticks_diff(self._due_us, ticks_us()) > WINDOW_US:
                return
            if self._ending or self._played == self._ring.head:
                if ticks_diff(self._due_us, ticks_us()) <= 0:
                    self._playing = False
                    timer.deinit()
                return
            while ticks_diff(self._due_us, ticks_us()) > 0:
                pass
            self._play()

    @micropython.native
    def _play(self):
        """Play the next word, and wait for its pulse's end."""
        ring = self._ring
        word = ring.words[self._played & ring.mask]
        now_us = ticks_us()
        if ticks_diff(now_us, self._due_us) > SLACK_US:
            self.late += 1
            self._due_us = now_us
        levels = word & self._levels
        for bank in self._banks:
            bank.show(levels)
        self._played = self._played + 1 & COUNT_MASK
        twice = (word >> self._bits) * 2 + self._rest
        self._rest = twice % _TICKS
        self._due_us = ticks_add(self._due_us, twice // _TICKS)
        if self._pulse_us:
            while ticks_diff(ticks_us(), now_us) < self._pulse_us:
                pass
            for bank in self._banks:
                bank.drop(bank.pulses)

    def hold(self, on):
        """While `on`, start() does nothing."""
        self._held = on

    def stop(self):
        """Play no further word after the one under way."""
        self._ending = True

    def halt(self):
        """Stop at once: pulses and tool drop, the other pins keep their levels."""
        self._playing = False
        for bank in self._banks:
            bank.drop(bank.pulses | bank.tool)

    def busy(self):
        """Return True while words are left to play or the last one's ticks still run."""
        if not self._playing:
            return False
        return self._played != self._ring.head and not self._ending or ticks_diff(self._due_us, ticks_us()) > 0

    def words_played(self):
        """Return the words whose levels have appeared on the pins, modulo 2²⁹."""
        return self._played

    def rest(self, levels):
        """Put `levels` on the pins at once. Only while not busy."""
        for bank in self._banks:
            bank.show(levels)

    def close(self):
        """Play no further word, and stop the timer."""
        self._playing = False
        self._timer.deinit()
