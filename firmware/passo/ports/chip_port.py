"""The common part of the ports of all chips: inputs and outputs, power, heartbeat, watchdog, and one call of the feeder.

A chip's Port adds the player, and the timer whose interrupt calls _feed(). If the main loop has not turned for 170 ms
the feeder slows down to a stand, and the watchdog, once it runs, resets the chip after a second.
"""

from time import ticks_diff, ticks_ms

import micropython
from machine import PWM, WDT, Pin, idle
from micropython import const

from passo.ports import parts
from passo.ports.uart_line import UartLine
from passo.records import COUNT_MASK, REGISTER_BIT, TICKS_PER_MS

_HEARTBEAT_MS = const(170)  # so that it stands within 200
_WATCHDOG_MS = const(1000)
_IDLE_MS = const(10)  # the longest cycle while nothing is under way
# The action of a call of the feeder's interrupt:
FEED_NOW = const(0)
_LEAVE_ALONE = const(1)  # nothing: the main loop makes words
FEED_LATER = const(2)  # nothing, once: see put_off()
_FIRST_TICKS = 2 * TICKS_PER_MS  # of words are made before the player starts, and between two looks at it then
_PULLS = {"up": Pin.PULL_UP, "down": Pin.PULL_DOWN, "none": None}


class Input:
    """A pin, and the level at which it is active. A halting one acts in its own interrupt."""

    def __init__(self, entry, port):
        self.name = entry["name"]
        self.number = entry["pin"]
        self.pin = Pin(self.number, Pin.IN, _PULLS[entry["pull"]])
        self.level = entry["active"]
        self._port = port
        if entry["halt"]:
            port.watch(self.pin, self._handle_edge, Pin.IRQ_RISING if self.level else Pin.IRQ_FALLING)

    @micropython.native
    def active(self):
        """Return True while the input has its active level."""
        return self.pin.value() == self.level

    def _handle_edge(self, pin):  # ISR: no allocation
        """Stop the player if the input is still active. A spike of noise is over by now: then nothing has happened."""
        if pin.value() == self.level:
            self._port.trip(self)


class ChipPort:
    def __init__(self, board, lead_ticks, live_ticks):
        """`board` is checked. Outputs go to their inactive level here. `lead_ticks`: how far ahead words are made;
        `live_ticks`: where what is under way may change at any moment."""
        self._leads = lead_ticks, live_ticks
        self.lead_ticks = lead_ticks
        self.bank = None  # the part that serves inputs and outputs which are on no pin of the chip
        self.veto = None  # the part that forbids motion: the outputs are its affair, too
        self._parts = []  # of options: each may have join(feeder, player), close(), and check() for each call of the feeder
        self._inputs = {}
        self._outputs = {}
        modules = dict(parts.load(board))
        if "bank" in modules:
            self._add(board, "bank", modules.pop("bank"))
            self.bank.exchange()
        for entry in board["outputs"]:
            active = entry["active"]
            if entry["pin"] >= REGISTER_BIT:
                pin = self.bank.output(entry)
            else:
                pin = Pin(entry["pin"], Pin.OUT, value=1 - active)
            self._outputs[entry["name"]] = pin, active
        spindle = board["spindle"]
        self._pwm = PWM(Pin(spindle["pin"]), freq=spindle["pwm_hz"], duty_u16=0) if spindle["pwm"] else None
        self._shown = 0  # power
        self._laser = None  # the player, where it sees to the power of the words it plays
        self._player = self._feeder = self._timer = self._watchdog = None
        self._looks = ()  # functions that each call of the feeder calls: of parts that follow the steps, and have no interrupt of their own
        self._aside = FEED_NOW
        self._behind = False  # the interrupt has left out a call while the main loop made words
        self._left_out = False  # the call that was to come later has been left out
        self._trip = None  # the halting input that has stopped the player, until halting_input() has returned it
        self._failed = None  # the exception that an interrupt raised
        self._beat_ms = ticks_ms()
        self._lines = []
        self._watches = {}  # of limits and homing's sensors
        self._mask = 0  # of their pins
        for entry in board["inputs"]:
            if entry["pin"] >= REGISTER_BIT:
                self._inputs[entry["name"]] = self.bank.input(entry)
            else:
                self._inputs[entry["name"]] = Input(entry, self)
                self._mask |= 1 << entry["pin"]
        self._halting = [self._inputs[entry["name"]] for entry in board["inputs"] if entry["halt"]]
        for name in sorted(modules):
            self._add(board, name, modules[name])
        if self.bank is not None:
            self.bank.begin(self, board, self._mask)

    def _add(self, board, name, module):
        """Make a part of an option."""
        self._parts.append(module.create(board, self, self._inputs, self._outputs))
        setattr(self, name, self._parts[-1])

    # --- what the contract of ports asks for

    def serial(self, link):
        """Return the line of a link of the board file: UsbLine or UartLine."""
        if link["port"] == "usb":
            from passo.ports.usb_line import UsbLine  # here: not every board has memory for it

            own = parts.of_line(link["port"])
            line = UsbLine(own and own.create(link))
        else:
            line = UartLine(link)
        self._lines.append(line)
        return line

    @micropython.native
    def input(self, name):
        """Return True while the input of this name is in its active state."""
        return self._inputs[name].active()

    def levels(self):
        """Return the states of all inputs as one integer, the first input's in the highest bit."""
        levels = 0
        for item in self._inputs.values():
            levels = levels << 1 | item.active()
        return levels

    def output(self, name, on):
        """Switch an output of the board file on or off."""
        if self.veto is not None:
            self.veto.output(name, on)
            return
        pin, active = self._outputs[name]
        pin.value(active if on else 1 - active)

    def power(self, level):  # ISR: no allocation
        """Show the tool's analogue power, 0 … 1000, at once."""
        if self._laser is not None:
            self._laser.show(level)
        elif level != self._shown:
            if self._pwm is not None:
                self._pwm.duty_u16(level * 65535 // 1000)
            self._shown = level  # last: if an interrupt has shown another meanwhile, the next one shows it again

    def machine_ms(self):
        """Return the time in ms, modulo 2²⁹."""
        return ticks_ms() & COUNT_MASK

    link_ms = machine_ms

    def halting_input(self):
        """Return the name of the halting input that stopped the player since the last call, or is active now; or None. With a name, the feeder makes
        no more words until the caller opens it again."""
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

    @micropython.native
    def wait(self, busy, fine=False, at_once=False):
        """End a cycle of the main loop: sleep a while, no longer than until a byte comes; `at_once`: not at all. Raises what an interrupt could not
        deal with: it has halted the player."""
        if self._failed is not None:
            raise self._failed
        self._beat_ms = ticks_ms()
        if self._feeder is not None:
            self._feeder.brake = False
        if self._watchdog is not None:
            self._watchdog.feed()
        while not at_once:
            for line in self._lines:
                if line.any():
                    return
            if ticks_diff(ticks_ms(), self._beat_ms) >= (1 if busy else _IDLE_MS):
                return
            idle()  # until an interrupt: a byte, the feeder's call, or a millisecond

    @micropython.native
    def set_out(self, live):
        """Let the blocks queued for a machine that stands move off now, not only at the feeder's next call. `live`: the motion under way
        may change at any moment.
        """
        self.lead_ticks = self._leads[live]
        ring = self._feeder.ring
        if self._player.words_played() != ring.head:
            return  # the interrupt is left alone while words play: a main loop in step with it would starve them
        self._aside = _LEAVE_ALONE
        played = self._player.words_played()
        if self._trip is None and played == ring.head:
            self._set_out(played)
            if self._trip is not None:
                self.power(0)
        self._aside = FEED_NOW

    def put_off(self):
        """Leave out the feeder's next call if it comes before catch_up(), which then makes it. App brackets the answer to `?` by the two: it
        takes up to 2 ms, and the call would add one. Default: do nothing, as on an ESP32, whose soft timer cannot be held off."""

    catch_up = put_off

    def make(self, kind, config):
        """Return the part that create() of an option's port.py makes, by the option's key: few boards have one."""
        return parts.of_option(kind, "port").create(self, self._inputs, config)

    def watch_limit(self, name, filter_us=0):
        """Return the watch of an input's pin: its interrupt stops the player once a limit has been active for `filter_us`, and keeps the
        moment of a change for homing (a Latch). The first call for a name sets its filter: Switches asks at the start, homing later.
        Return None if the pin has no interrupt of its own."""
        if self.veto is not None:
            return self.veto.watches.get(list(self._inputs).index(name))
        item = self._inputs[name]
        if name not in self._watches and item.pin is not None and item not in self._halting:
            from passo.ports.limit_watch import LimitWatch  # here: not every board has one

            self._watches[name] = LimitWatch(item, filter_us, self)
        return self._watches.get(name)

    def writing(self, on):
        """Flash is about to be erased or written, all interrupts off for up to 0.4 s at a time, or it has been."""
        self.feed_watchdog()
        for line in self._lines:
            if hasattr(line, "writing"):
                line.writing(on)

    def feed_watchdog(self):
        """Something takes longer than a cycle may, and is still going on. Only at a stand."""
        if self._watchdog is not None:
            self._watchdog.feed()

    # --- what start.py asks for

    def guard(self):
        """Start the watchdog: from now on the main loop has to run."""
        if self._watchdog is None:
            self._watchdog = WDT(timeout=_WATCHDOG_MS)

    def close(self):
        """Stop all interrupts and let go of the lines; the outputs stay as they are."""
        if self._timer is not None:
            self._timer.deinit()
        for item in self._halting:
            if item.pin is not None:
                item.pin.irq(None)
        for part in self._parts + self._lines:
            getattr(part, "close", int)()

    # --- interrupts

    def _join(self, feeder, player):
        """Give feeder and player to the parts of options that follow the steps. Nothing is fed before the app has something to play: until
        then features add attributes to the player, and meanwhile an interrupt would find none of its attributes."""
        self._feeder = feeder
        feeder.open = False
        for part in self._parts:
            if hasattr(part, "join"):
                part.join(feeder, player)
        self._looks = tuple([part.check for part in self._parts if hasattr(part, "check")])

    @micropython.native
    def _feed(self, timer):  # ISR: no allocation
        """A call of the feeder; `timer`: self where the main loop makes up for one."""
        feeder = self._feeder
        if timer is not self:
            for look in self._looks:
                look()
        if ticks_diff(ticks_ms(), self._beat_ms) > _HEARTBEAT_MS:
            feeder.brake = True
        aside = self._aside
        if aside:
            if aside == FEED_LATER:
                self._aside = FEED_NOW
                self._left_out = True
            else:
                self._behind = True
        elif self._trip is None and feeder.open:
            try:
                player = self._player
                played = player.words_played()
                if played == feeder.ring.head or self._behind:
                    self._behind = False
                    self._set_out(played)
                else:
                    amid = feeder.fill(played, self.lead_ticks)
                    if player.start() and amid:
                        feeder.count_late()  # making these took longer than those before them lasted
                if self._pwm is not None and self._laser is None:
                    self.power(feeder.ring.power.level)
            except Exception as error:  # out of here it would end the timer, and leave the tool as it is
                self._failed = error
                self.trip(None)
            if self._trip is not None:
                self.power(0)  # a halting input came in between

    def _set_out(self, played):  # ISR: no allocation
        """From a standstill, or a call behind, the first words go out before the others are made: these are handed over in
        small parts, so that the player never has to wait for the last of them."""
        feeder = self._feeder
        player = self._player
        ring = feeder.ring
        lead_ticks = _FIRST_TICKS
        feeder.fill(played, lead_ticks)
        if ring.head == played:
            # Of the last word, which has begun since; where the main loop does not run, a laser does not burn on in one place.
            self.power(0 if feeder.brake and self._laser is not None else ring.power.level)
        while ring.head != played:
            player.start()
            if lead_ticks >= self.lead_ticks or self._trip is not None:
                return
            lead_ticks += _FIRST_TICKS
            if feeder.amid() and not player.busy():
                feeder.count_late()
            feeder.fill(played, lead_ticks)  # lead and lateness count from where it stood

    def trip(self, item):  # ISR: no allocation
        """Halt the player, set the tool's power to 0 and keep `item` as the cause. Called in an interrupt, or by a poll."""
        self._trip = item
        if self._player is not None:
            self._player.hold(True)
            self._player.halt()
            self.power(0)
        if self.bank is not None:
            self.bank.exchange()  # the tool may show there
        if self.veto is not None and item in self._halting:
            self.veto.note_halt(item)
