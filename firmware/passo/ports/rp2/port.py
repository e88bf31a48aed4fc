"""The port of the RP2040 and the RP2350: pins, serial lines, clock, the player, and the interrupt that feeds it.

    port = Port(board)          # a checked board file
    app = App(board, port)
    while True:
        app.turn()              # ends in port.wait()

Words are made in a timer interrupt every 2 ms, 12 ms ahead: neither the main loop nor its garbage collections
delay a step. If the main loop has not turned for 200 ms the feeder comes to a stand, and the watchdog, once it runs,
resets the chip after a second.
"""

from time import sleep_ms, ticks_diff, ticks_ms

from machine import PWM, WDT, Pin, Timer
from micropython import const

from passo.ports.rp2 import chip
from passo.ports.rp2 import kernels as thumb
from passo.ports.rp2.serial import UartLine, UsbLine
from passo.steps import kernels
from passo.steps.wiring import inverted_pins, word_pins, word_times
from passo.steps.word import COUNT_MASK

_FEED_MS = const(2)
_LEAD_TICKS = const(12 * 12_500)  # more than the longest word, so that one is always waiting behind it
_HEARTBEAT_MS = const(200)
_WATCHDOG_MS = const(1000)
_PULLS = {"up": Pin.PULL_UP, "down": Pin.PULL_DOWN, "none": None}


class Input:
    """A pin, and the level at which it is active. A halting one acts in its own interrupt."""

    def __init__(self, entry, port):
        self.name = entry["name"]
        self._number = entry["pin"]
        self.pin = Pin(self._number, Pin.IN, _PULLS[entry["pull"]])
        self._active = entry["active"]
        self._port = port
        if entry["halt"]:
            edge = Pin.IRQ_RISING if self._active else Pin.IRQ_FALLING
            self.pin.irq(self._tripped, edge, hard=True)

    def active(self):
        return self.pin.value() == self._active

    def raise_high(self):
        """Make the active level the high one, as the chip sees it; the pin itself stays as it is."""
        if not self._active:
            chip.invert_input(self._number)
            self._active = 1

    def _tripped(self, pin):  # ISR: no allocation
        # A spike of noise is over by now: then nothing has happened.
        if pin.value() == self._active:
            self._port.trip(self)


class Port:
    def __init__(self, board):
        """`board` is checked. Outputs go to their inactive level here."""
        self._board = board
        self._outputs = {}
        for entry in board["outputs"]:
            active = entry["active"]
            self._outputs[entry["name"]] = (Pin(entry["pin"], Pin.OUT, value=1 - active), active)
        self._pwm = None
        spindle = board["spindle"]
        if spindle["pwm"]:
            self._pwm = PWM(Pin(spindle["pin"]), freq=spindle["pwm_hz"], duty_u16=0)
        self._shown = 0  # power
        self._player = None
        self._feeder = None
        self._timer = None
        self._watchdog = None
        self._trip = None  # the halting input that has stopped the player, until the main loop has been told
        self._beat_ms = ticks_ms()
        self._stalled = False  # the feeder holds because the main loop has not turned
        self._lines = []
        self._inputs = {}
        for entry in board["inputs"]:
            self._inputs[entry["name"]] = Input(entry, self)
        self._halting = [self._inputs[entry["name"]] for entry in board["inputs"] if entry["halt"]]

    # --- what the contract of ports asks for

    def player(self, ring, layout):
        """The player of `ring`. Once."""
        pulse_ticks, least = word_times(self._board)
        pins = word_pins(self._board)
        invert = inverted_pins(self._board, layout)
        if self._board["player"] == "timer":
            from passo.ports.rp2.timer_player import SHORTEST_TICKS, TimerPlayer

            self._player = TimerPlayer(ring, layout, pins, pulse_ticks, max(least, SHORTEST_TICKS), invert)
            return self._player
        from passo.ports.rp2.pio_player import PioPlayer

        halt_pin = None
        if self._halting:
            self._halting[0].raise_high()
            halt_pin = self._halting[0].pin
        self._player = PioPlayer(ring, layout, pins[0], pulse_ticks, least, invert, halt_pin)
        return self._player

    def feed_from_interrupt(self, feeder, player):
        self._feeder = feeder
        kernels.use(thumb.walk, thumb.pace)
        chip.yield_timers()
        self._timer = Timer(mode=Timer.PERIODIC, period=_FEED_MS, callback=self._feed, hard=True)
        return True

    def serial(self, link):
        line = UsbLine() if link["port"] == "usb" else UartLine(link)
        self._lines.append(line)
        return line

    def input(self, name):
        """True while the input is in its active state."""
        return self._inputs[name].active()

    def output(self, name, on):
        """Switch an output of the board file on or off."""
        pin, active = self._outputs[name]
        pin.value(active if on else 1 - active)

    def power(self, level):  # ISR: no allocation
        """Show the tool's analogue power, 0 … 1000, at once."""
        if level != self._shown:
            self._shown = level
            if self._pwm is not None:
                self._pwm.duty_u16(level * 65535 // 1000)

    def machine_ms(self):
        return ticks_ms() & COUNT_MASK

    link_ms = machine_ms

    def tripped(self):
        """The name of the halting input that stopped the player since the last call, or is active now; or None."""
        trip = self._trip
        for item in self._halting:
            if item.active():
                trip = item
        if trip is None:
            return None
        if self._feeder is not None:
            self._feeder.open = False  # until the caller has put things in order
        self._trip = None
        if self._player is not None:
            self._player.hold(False)
        return trip.name

    def wait(self, busy, fine=False):
        """End a turn of the main loop: sleep briefly, unless bytes are waiting."""
        self._beat_ms = ticks_ms()
        if self._stalled:
            self._stalled = False
            self._feeder.hold = False
        if self._watchdog is not None:
            self._watchdog.feed()
        for line in self._lines:
            if line.any():
                return
        sleep_ms(1 if busy else 2)

    # --- what start.py asks for

    def guard(self):
        """Start the watchdog: from now on the main loop has to turn."""
        if self._watchdog is None:
            self._watchdog = WDT(timeout=_WATCHDOG_MS)

    def close(self):
        """Stop all interrupts and the watchdog; the outputs stay as they are."""
        if self._timer is not None:
            self._timer.deinit()
        for item in self._halting:
            item.pin.irq(None)
        for line in self._lines:
            line.close()
        if self._watchdog is not None:
            chip.stop_watchdog()

    # --- interrupts

    def _feed(self, timer):  # ISR: no allocation
        feeder = self._feeder
        if ticks_diff(ticks_ms(), self._beat_ms) > _HEARTBEAT_MS and not feeder.hold:
            self._stalled = True
            feeder.hold = True
        if self._trip is None and feeder.open:
            player = self._player
            feeder.fill(player.played(), _LEAD_TICKS)
            player.start()
            if self._pwm is not None:
                self.power(feeder.ring.power.level)

    def trip(self, item):  # ISR: no allocation
        self._trip = item
        if self._player is not None:
            self._player.hold(True)
            self._player.halt()
            self.power(0)
