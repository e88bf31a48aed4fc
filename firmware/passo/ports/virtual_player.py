"""The virtual port's player: step words from the ring become edges on virtual pins.

The port calls `run(until)` with ticks that only grow; each edge goes to the world's `edges(tick, levels, changed)`.
The world may stop or halt the player from inside that call, as a limit switch wired to its interrupt would.
"""

from passo.records import COUNT_MASK

_NEVER = -1  # no word


class Player:
    """Plays step words from the ring onto virtual pins; knows nothing of axes.

    A pulse (a bit of `layout.pulse_mask`) falls `pulse_ticks` after its word begins, or as the word ends if that is
    sooner. `invert` is the mask of the pins whose electrical level is the opposite of the word's.
    """

    def __init__(self, port, ring, layout, pulse_ticks, min_word_ticks, invert):
        self.min_word_ticks = min_word_ticks
        self.now = 0  # tick of the edge or cycle under way
        self._ring = ring
        self._layout = layout
        self._pulse_ticks = pulse_ticks
        self._invert = invert
        self._edges = port.world.edges
        self._power = getattr(port.world, "power", None)
        self._shown = 0  # power
        self._switches = self._change = None  # see mark()
        self._levels = 0
        self._played = 0
        self._next = 0  # tick at which the word under way ends
        self._fall = -1  # tick at which its pulses fall; -1 when none is up
        self._playing = False
        port.world.attach(0, layout.pin_names, invert)

    def mark(self, switches, change):
        """Outputs change with the words that `switches` says, by change(tick, value)."""
        self._switches = switches
        self._change = change
        self.start = switches.start

    def start(self):
        """Play words as they come."""
        self._playing = True

    def stop(self):
        """Play no further word after the one under way."""
        self._playing = False

    def halt(self):
        """No further step: the tool drops now, a pulse once it has lasted as long as it should, the other pins keep their levels."""
        dropped = self._layout.tool_mask
        if self._fall < 0:
            if self._playing and self._next > self.now:  # called from inside the edge with which the pulse rose, if one is up
                self._fall = min(self.now + self._pulse_ticks, self._next) if self._levels & self._layout.pulse_mask else -1
            else:
                dropped |= self._layout.pulse_mask
        self._playing = False
        self._next = self.now
        dropped &= self._levels
        if dropped:
            self._levels ^= dropped
            self._edges(self.now, self._levels ^ self._invert, dropped)

    def busy(self):
        """Return True while words are left to play or the last one's ticks still run."""
        return self._next > self.now or (self._playing and self._played != self._ring.head)

    def words_played(self):
        """Return the words whose levels have appeared on the pins, modulo 2²⁹."""
        return self._played

    def rest(self, levels):
        """Put `levels` on the pins at once; a pulse that halt() has left up stays. Only while not busy."""
        self._put(self.now, levels | self._levels & self._layout.pulse_mask if self._fall >= 0 else levels)

    def levels(self):
        """Return the levels at the pins, before polarity."""
        return self._levels

    def show_power(self, tick, level):
        """The tool's analogue power is `level`, 0 … 1000."""
        if level != self._shown and self._power is not None:
            self._shown = level
            self._power(tick, level)

    def _put(self, tick, levels):
        """Put `levels` on the pins at `tick`, and hand the edges on if any level changes."""
        changed = levels ^ self._levels
        if changed:
            self._levels = levels
            self._edges(tick, levels ^ self._invert, changed)

    def run(self, until):
        """Play everything that is due before the tick `until`."""
        if 0 <= self._fall < until:
            self._drop()
        if self._next < self.now:
            self._next = self.now
        if self._playing and self._fall < 0 and self._next < until and self._played != self._ring.head:
            self._play(until)
            if 0 <= self._fall < until:
                self._drop()
        self.now = until

    def _drop(self):
        """End the pulses, whose time it is; the next word never begins before that."""
        self.now = tick = self._fall
        self._fall = -1
        self._put(tick, self._levels & ~self._layout.pulse_mask)

    def _play(self, until):
        """Play words of the ring up to tick `until`: give edges to the world, with pulses falling pulse_ticks later; end if it stops the player."""
        # The host spends most of its time here: everything is local, and nothing is allocated but the ticks.
        layout = self._layout
        bits = layout.bits
        levels_mask = layout.levels_mask
        pulse_mask = layout.pulse_mask
        pulse_ticks = self._pulse_ticks
        invert = self._invert
        edges = self._edges
        words = self._ring.words
        mask = self._ring.mask
        head = self._ring.head
        played = self._played
        tick = self._next
        power = self._ring.power
        marked = power.next(played)
        switched = self._switch(tick) if self._switches else _NEVER
        while tick < until and played != head:
            word = words[played & mask]
            at = played
            played = (played + 1) & COUNT_MASK
            if at == marked:
                power.play(played)
                marked = power.next(played)
                self.show_power(tick, power.level)
            levels = word & levels_mask
            end = tick + (word >> bits)
            self.now = tick
            self._played = played
            self._next = end
            if at == switched:
                switched = self._switch(tick)
            changed = levels ^ self._levels
            if changed:
                self._levels = levels
                edges(tick, levels ^ invert, changed)
            pulses = levels & pulse_mask
            if pulses:
                fall = tick + pulse_ticks
                if fall > end:
                    fall = end
                if not self._playing:  # the world stopped or halted the player inside that edge
                    self._fall = fall if self._levels & pulse_mask else -1
                    break
                if fall >= until:
                    self._fall = fall
                    break
                self.now = fall
                levels ^= pulses
                self._levels = levels
                edges(fall, levels ^ invert, pulses)
            if not self._playing:
                break
            tick = end

    def _switch(self, tick):
        """Change the outputs that are due; the word of the next."""
        return self._switches.show_due(self._played, lambda value: self._change(tick, value))
