"""The port of the RP2040 and the RP2350: its players, and the interrupt that feeds them.

    port = Port(board)          # a checked board file
    app = App(board, port)
    while True:
        app.cycle()              # ends in port.wait()

Words are made in a timer interrupt every 3 ms, 10.5 ms ahead, or 8 if a change has to show soon: neither the main
loop nor its garbage collections delay a step. Halting inputs and serial lines come before it.
"""

import micropython
from machine import Pin, Timer, mem32
from micropython import const

from passo.ports import parts
from passo.ports.chip_port import FEED_NOW, FEED_LATER, ChipPort
from passo.ports.rp2 import chip
from passo.ports.rp2.fields import LEAD_TICKS
from passo.ports.rp2.registers import BLOCK_CTRL
from passo.steps.wiring import inversion_mask, mute_mask, word_pins, word_times

_FEED_MS = const(3)  # every 2 ms, its calls alone would cost a stream of lines a fifth of its speed
_LIVE_TICKS = const(8 * 12_500)
_FAST_BAUD = const(400_000)  # 32 bytes come in less time than one call of the feeder takes
_TIMERS_ON, _TIMERS_OFF = const(0xE000E100), const(0xE000E180)  # NVIC_ISER and NVIC_ICER
_TIMERS = const(8)  # TIMER_IRQ_3


def load(board):
    """Import what a Port of this board will ask for, each by itself: a module that imports others wants memory for all of them."""
    from passo.ports.rp2 import programs  # noqa: F401

    if board["player"] == "pio":
        from passo.ports.rp2 import pio_player  # noqa: F401
    parts.player(board)
    parts.load(board)
    if "usb" in [link["port"] for link in board["links"]]:
        parts.of_line("usb")
        from passo.ports import usb_line  # noqa: F401


class Guard:
    """A halting input from when there is a player: that stands still first, 10 µs after the edge; the rest takes its
    time."""

    def __init__(self, item, port):
        self._item = item
        self._mask = 1 << item.number & 0x3FFFFFFF  # of the pins that one register shows; beyond them `trip` is first
        self._port = port

    # The last edge on a pin comes 20 µs after the input's at worst, 25 are allowed (make bench ARGS=stops).
    @micropython.viper
    def on_edge(self, pin):  # ISR: no allocation
        """Halt if the input is active: stop the state machine, then trip the port. Called in the pin's interrupt."""
        item = self._item
        mask = int(self._mask)
        inputs = ptr32(0xD0000004)
        if mask:
            high = 1 if inputs[0] & mask else 0
            if high != int(item.level):
                return  # a spike of noise is over by now: then nothing has happened
            ptr32(0x50203000)[BLOCK_CTRL] = 1  # the players' state machine: number 0 of block 0
        elif not item.active():
            return
        self._port.trip(item)


class Port(ChipPort):
    def __init__(self, board):
        """`board` is checked. Outputs go to their inactive level here. PWM, serial lines and players are made for the clock
        that there is: it is set before."""
        ChipPort.__init__(self, board, LEAD_TICKS, _LIVE_TICKS)
        if hasattr(self.bank, "levels"):
            self.levels = self.bank.levels

    @micropython.viper
    def levels(self) -> int:
        """Return the pins of all inputs as one integer."""
        return ptr32(0xD0000004)[0] & int(self._mask)

    def serial(self, link):
        """Return the line of a link: ChipPort's, which loses no byte while flash is written, nor at a high baud rate to the feeder's interrupt."""
        line = ChipPort.serial(self, link)
        if link["port"] != "usb" and link["baud"] > _FAST_BAUD:
            count = line.count
            line.count = lambda: self._count_atomically(count)
        # Frames are sent again; an inverter's answer fits into the FIFO.
        if link["port"] != "usb" and not link.get("frames") and "parity" not in link:
            line.join(parts.of_line(link["port"]).create(link))
        return line

    @micropython.viper
    def _count_atomically(self, count) -> int:
        """Call count() with the feeder's interrupt switched off, and return its result. MicroPython locks the UART's FIFO while it empties it
        to count bytes. If the feeder interrupted that, the UART's own interrupt would find the lock taken, and the FIFO would run over."""
        ptr32(0xE000E180)[0] = _TIMERS
        found = int(count())
        ptr32(0xE000E100)[0] = _TIMERS
        return found

    def put_off(self):
        """Leave out the feeder's next calls in the interrupt, until catch_up()."""
        self._aside = FEED_LATER

    def catch_up(self):
        """End put_off(), and make the call that was left out, with the timers' interrupts off."""
        self._aside = FEED_NOW
        if self._left_out:
            self._left_out = False
            mem32[_TIMERS_OFF] = _TIMERS
            self._feed(self)
            mem32[_TIMERS_ON] = _TIMERS

    def feed_watchdog(self):
        """Something takes longer than a cycle may: three sectors of flash that are erased in one call may take 1.2 s. Only at a stand."""
        if self._watchdog is not None:
            chip.long_watchdog()

    def watch(self, pin, handler, edge):
        """Call `handler(pin)` in the interrupt of an edge."""
        pin.irq(handler, edge, hard=True)

    def player(self, ring, layout, board):
        """Build the player, which reads `ring`, mute the pins that the board file mutes, and return it."""
        pins = word_pins(board)
        self._make_player(ring, layout, board, pins)
        muted = mute_mask(board)
        for bit in range(layout.bits):
            if muted >> bit & 1:
                chip.mute(pins[bit])
        return self._player

    def _make_player(self, ring, layout, board, pins):
        """Watch the halting inputs, and build an option's player, or the PioPlayer."""
        for item in self._halting:
            self.watch(item.pin, Guard(item, self).on_edge, Pin.IRQ_RISING if item.level else Pin.IRQ_FALLING)
        own = parts.player(board)
        if own is None:
            from passo.ports.rp2 import pio_player as own
        self._player = own.create(board, ring, layout, pins, *word_times(board), inversion_mask(board, layout), self._halt_pin)
        if hasattr(self._player, "show"):
            self._laser = self._player

    def _halt_pin(self):
        """Return the first halting input's Pin, which a state machine halts at; None if there is none."""
        if not self._halting:
            return None
        item = self._halting[0]
        if not item.level:  # the state machine halts at a high level: the chip sees the pin inverted from here on
            chip.invert_input(item.number)
            item.level = 1
        return item.pin

    def feed_from_interrupt(self, feeder, player):
        self._join(feeder, player)
        chip.yield_timers()
        self._timer = Timer(mode=Timer.PERIODIC, period=_FEED_MS, callback=self._feed, hard=True)
        return True

    def close(self):
        """Stop all interrupts and the watchdog; the outputs stay as they are."""
        ChipPort.close(self)
        if hasattr(self._player, "close"):  # the timer player's interrupt is none of MicroPython's, which would end it
            self._player.close()
        if self._watchdog is not None:
            chip.stop_watchdog()
