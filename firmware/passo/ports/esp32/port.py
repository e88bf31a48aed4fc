"""The port of the ESP32 family: its player, and the timer that feeds it.

    port = Port(board)          # a checked board file
    app = App(board, port)
    while True:
        app.cycle()              # ends in port.wait()

All callbacks are soft here: see timer_player.py for the cost. A halting input acts once the main loop gets to
it, usually within a millisecond, within some tens where memory is being collected: an emergency stop belongs into the
drivers' power or enable line. Words are made every 5 ms, 30 ms ahead. The watchdog of this chip cannot be stopped: after
the app's end a timer feeds it.

With shift registers (`shift` of the board file) words are made every 2 ms, 24 ms ahead, and i2s_player.py plays them: the
limits above are then those of halting inputs only.
"""

from machine import Timer
from micropython import const

from passo.ports.chip_port import ChipPort
from passo.ports.esp32.timer_player import TimerPlayer
from passo.records import LEAD_TICKS
from passo.steps.wiring import inversion_mask, word_pins, word_times

_FEED_MS = const(5)
_FEED_TIMER = const(1)  # TimerPlayer has timer 0
_KEEP_MS = const(300)
_PUMP_MS = const(2)


class Port(ChipPort):
    def __init__(self, board):
        ChipPort.__init__(self, board, LEAD_TICKS, LEAD_TICKS)
        self._pumps = hasattr(self.bank, "make_player")  # the bank plays the words
        if self._pumps:
            self.lead_ticks = self.bank.lead_ticks
            self._leads = self.lead_ticks, self.lead_ticks

    def watch(self, pin, handler, edge):
        """Call `handler(pin)` soon after an edge."""
        pin.irq(handler, edge)

    def player(self, ring, layout, board):
        """Build the player, which reads `ring`, and return it: that of the output bank if it pumps words, else TimerPlayer."""
        pulse_ticks, least = word_times(board)
        pins = word_pins(board)
        invert = inversion_mask(board, layout)
        if self._pumps:
            self._player = self.bank.make_player(ring, layout, pins, pulse_ticks, invert)
        else:
            self._player = TimerPlayer(ring, layout, pins, pulse_ticks, least, invert)
        return self._player

    def feed_from_interrupt(self, feeder, player):
        self._join(feeder, player)
        self._timer = Timer(_FEED_TIMER)
        self._timer.init(mode=Timer.PERIODIC, period=_PUMP_MS if self._pumps else _FEED_MS, callback=self._feed_and_look)
        return True

    def _feed_and_look(self, timer):
        """Halt if a halting input is active, make words, and pump them to the bank. Called by the timer; an error in the pump also halts."""
        for item in self._halting:  # an edge is forgotten where too many callbacks are waiting
            if self._trip is None and item.active():
                self.trip(item)
        self._feed(timer)
        player = self._player
        if not self._pumps or self._aside:  # the main loop has not made all words of a beginning yet
            return
        try:
            before = player.under_runs
            player.pump()
            if before != player.under_runs and self._feeder.amid():
                self._feeder.count_late()
        except Exception as error:
            self._failed = error
            self.trip(None)

    def close(self):
        """Stop the callbacks; the watchdog, where it runs, is fed from now on. The outputs stay as they are."""
        ChipPort.close(self)
        if self._player is not None:
            self._player.close()
        if self._watchdog is not None:
            self._timer.init(mode=Timer.PERIODIC, period=_KEEP_MS, callback=lambda timer: self._watchdog.feed())
