"""Encoders at the pins, shared by all ports: they are counted, and compared with the player's steps.

    port.encoders.check()           # from the interrupt that feeds the player, every 3 ms; on the virtual port too
    port.encoders.steps_beyond(0)   # what motor 0 has turned beyond what was stepped, in whole steps
    port.encoders.account_for(0, 3) # these 3 steps are accounted for

Subclasses read the counts: read(counts), modulo 2²⁹ each. A following error beyond its limit halts the player, if `armed`. How late that
is: a motor that stands still is noticed once it has missed limit_steps, by the next check. Counts and steps are not read at one instant:
the player is looked at before and behind them, some 30 µs apart on an RP2040, and its steps in between are allowed for. A rotor lags its
magnetic field by up to two full steps under load, more is lost: no limit should be lower.

On an RP2040 a check of four encoders and a gantry takes 0.34 to 0.41 ms of every 3 ms.
"""

from array import array

import micropython

from passo.records import COUNT_MASK
from passo.options.encoders.steps_viper import (
    FOLLOW_AXIS, FOLLOW_DEN, FOLLOW_ERROR, FOLLOW_FIELDS, FOLLOW_LIMIT, FOLLOW_MOST, FOLLOW_NEGATIVE, FOLLOW_NUM, FOLLOW_OFF,
    FOLLOW_SHIFT, FOLLOW_TOTAL, Follower, follow_steps,
)  # fmt: skip


def _common_divisor(a, b):
    """Return the greatest common divisor of two integers (Euclid)."""
    while b:
        a, b = b, a % b
    return a


class Index:
    """The index pulse of an encoder: one a turn, so that counts that never came, or came too often, show."""

    def __init__(self, encoders, number, name):
        self.number = number
        self.name = name
        self.seen = 0  # pulses, modulo 2²⁹
        self._encoders = encoders
        self.turn = 4 * encoders.pulses[number]
        self._first = self._last = 0  # counts at the first pulse, and at the last, modulo 2²⁹

    @micropython.native
    def on_edge(self, pin):  # ISR: no allocation
        """Keep the count at this pulse. Called in the pin's interrupt."""
        encoders = self._encoders
        encoders.read(encoders.counts)
        self._last = encoders.counts[self.number]
        if not self.seen:
            self._first = self._last
        self.seen = (self.seen + 1) & COUNT_MASK

    def counts_off(self):
        """Return by how many counts the last pulse is not whole turns from the first."""
        off = (self._last - self._first) & COUNT_MASK
        if off > COUNT_MASK // 2:
            off -= COUNT_MASK + 1
        return (off + self.turn // 2) % self.turn - self.turn // 2

    def accept_last(self):
        """Count whole turns from the last pulse on."""
        self._first = self._last


class Encoders:
    """Has no pins: see port_rp2.py, port_pins.py and port_virtual.py."""

    name = "encoders"  # as what has stopped the player

    def __init__(self, board, port):
        entries = board["encoders"]
        self._port = port
        self._axes = len(board["axes"])
        letters = [axis["name"] for axis in board["axes"]]
        self.names = [entry["motor"] for entry in entries]
        self.pulses = [entry["pulses"] for entry in entries]
        self.table = array("i", [0] * (FOLLOW_FIELDS * len(entries)))
        for number in range(len(entries)):
            entry = entries[number]
            shared = _common_divisor(4 * entry["pulses"], entry["steps"])
            at = number * FOLLOW_FIELDS
            self.table[at + FOLLOW_AXIS] = letters.index(entry["motor"][0])
            self.table[at + FOLLOW_NUM] = 4 * entry["pulses"] // shared
            self.table[at + FOLLOW_DEN] = entry["steps"] // shared
            self.table[at + FOLLOW_NEGATIVE] = 1 if entry["reversed"] else 0
            self.table[at + FOLLOW_LIMIT] = entry["limit_steps"] * self.table[at + FOLLOW_NUM]
        self.counts = array("i", [0] * len(entries))
        self._position = array("i", [0] * self._axes)
        self._after = array("i", [0] * self._axes)
        self._zeros = array("i", [0] * len(entries))  # totals that are shown as 0
        self._first = self._second = self._lag = 0  # of a gantry's motors: where in the table they are, and the largest lag
        self.gantry = ()  # the numbers of both its encoders, if it has them
        gantry = board.get("gantry")
        if gantry and gantry["axis"] in self.names and gantry["axis"] + "2" in self.names:
            self.gantry = self.names.index(gantry["axis"]), self.names.index(gantry["axis"] + "2")
            self._first, self._second = [number * FOLLOW_FIELDS for number in self.gantry]
            self._lag = gantry["limit_steps"] * self.table[self._first + FOLLOW_NUM]
        self.lagging = False  # the player was halted for the gantry's lag
        self.armed = False  # an error beyond its limit halts the player
        self.beyond = 0  # mask of the encoders that it was halted for
        self.checks = 0  # modulo 2²⁹
        self._player = self._follower = None
        self.indexes = []  # Index of those that have one

    def add_index(self, number, name):
        """Return a new Index of an encoder, whose pulse comes on input `name`. The port calls its on_edge()."""
        entry = Index(self, number, name)
        self.indexes.append(entry)
        return entry

    def watch_indexes(self, board, inputs):
        """On a chip: have the edge of each index pulse call on_edge() in its interrupt. `inputs`: the port's {name: Input}."""
        from machine import Pin

        for number in range(len(board["encoders"])):
            name = board["encoders"][number]["index"]
            if name:
                item = inputs[name]
                edge = Pin.IRQ_RISING if item.level else Pin.IRQ_FALLING
                self._port.watch(item.pin, self.add_index(number, name).on_edge, edge)

    def join(self, feeder, player):
        """Compare with the steps of `player` from here on. Called once, before anything is played."""
        self._follower = Follower(feeder)
        self._player = player

    # --- interrupts

    @micropython.native
    def check(self):  # ISR: no allocation
        """Compare counts and steps; halt the player if it is armed and an error, or a gantry's lag, is beyond its limit. 0.41 ms at most on an
        RP2040."""
        if self._player is None:
            return
        follower = self._follower
        position = self._position
        after = self._after
        before = self._player.words_played()
        self.read(self.counts)
        played = self._player.words_played()
        follower.find_position(before, position)
        for axis in range(self._axes):
            after[axis] = position[axis]
        follower.add_steps(before, played, after)
        self.checks = (self.checks + 1) & COUNT_MASK
        beyond = follow_steps(self.table, len(self.counts), self.counts, position, after)
        lagging = False
        if self._lag:
            lag = self.table[self._second + FOLLOW_ERROR] - self.table[self._first + FOLLOW_ERROR]
            lagging = lag > self._lag or lag < -self._lag
        if (beyond or lagging) and self.armed:
            self.beyond = beyond
            self.lagging = lagging
            self.armed = False
            self._port.trip(self)

    # --- main loop

    def arm(self, on):
        """Let errors beyond their limits halt the player, or not."""
        self.armed = on

    def steps_beyond(self, number):
        """Return how far a motor has turned beyond its steps: steps, rounded."""
        num = self.table[number * FOLLOW_FIELDS + FOLLOW_NUM]
        return (2 * self.table[number * FOLLOW_FIELDS + FOLLOW_ERROR] + num) // (2 * num)

    def lag_steps(self):
        """Return how far a gantry's second motor has turned beyond the first: steps, rounded."""
        num = self.table[self._first + FOLLOW_NUM]
        lag = self.table[self._second + FOLLOW_ERROR] - self.table[self._first + FOLLOW_ERROR]
        return (2 * lag + num) // (2 * num)

    def account_for(self, number, steps):
        """Take `steps` off a motor's error, from the next check on."""
        at = number * FOLLOW_FIELDS
        self.table[at + FOLLOW_SHIFT] = -steps * self.table[at + FOLLOW_NUM]

    def clear_error(self, number):
        """Make a motor's error 0, from the next check on."""
        at = number * FOLLOW_FIELDS
        self.table[at + FOLLOW_SHIFT] = -self.table[at + FOLLOW_ERROR]

    def exempt_motor(self, number, off):
        """Ignore the axis's steps for this motor, or not. Only at a stand, behind a check."""
        self.table[number * FOLLOW_FIELDS + FOLLOW_OFF] = 1 if off else 0

    def axis_of(self, number):
        """Return the number of a motor's axis."""
        return self.table[number * FOLLOW_FIELDS + FOLLOW_AXIS]

    def count_of(self, number):
        """Return the counts since the start, or since zero_counts()."""
        return self.table[number * FOLLOW_FIELDS + FOLLOW_TOTAL] - self._zeros[number]

    def zero_counts(self):
        """Let the counts shown, and the largest errors, begin at 0."""
        for number in range(len(self.names)):
            at = number * FOLLOW_FIELDS
            self._zeros[number] = self.table[at + FOLLOW_TOTAL]
            self.table[at + FOLLOW_MOST] = 0

    def largest_error(self, number):
        """Return the largest following error since zero_counts(), in steps."""
        at = number * FOLLOW_FIELDS
        return self.table[at + FOLLOW_MOST] // self.table[at + FOLLOW_NUM]
