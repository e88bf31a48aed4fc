"""A port without pins: hashes the feeder's words, and appends them to a list if there is one. Runs on the board, which gets this text, and on the PC.

    port = Words()                      # or Words(words), a list that gets the words themselves
    app = App(board, port)
    refused = carry_out(app, port, lines)
    port.digest(), port.count
"""

import hashlib

COUNT_MASK = (1 << 29) - 1  # as in passo/records.py, whose constants a build turns into numbers

STILL = 40  # cycles of 1 ms without motion that end a job: longer than a link's gap and the motors' waking


class Words:
    eager = False

    def __init__(self, words=None, min_word_ticks=50):
        self.min_word_ticks = min_word_ticks
        self.count = 0
        self.incoming = self.outgoing = b""
        self._ms = self._played = 0
        self._hash = hashlib.sha256()
        self._words = words

    def digest(self):
        return "".join(["%02x" % byte for byte in self._hash.digest()])

    # the player

    def start(self):
        """Take all words out of the ring at once, and add them to the hash."""
        ring = self._ring
        while self._played != ring.head:
            at = self._played & ring.mask
            count = min((ring.head - self._played) & COUNT_MASK, ring.size - at)
            self._hash.update(memoryview(ring.words)[at : at + count])
            if self._words is not None:
                self._words.extend(ring.words[at : at + count])
            self._played = (self._played + count) & COUNT_MASK
            ring.power.play(self._played)
            self.count += count

    def halt(self):
        pass

    def busy(self):
        return False

    def words_played(self):
        return self._played

    def rest(self, levels):
        pass

    # the port

    def player(self, ring, layout, board):
        self._ring = ring
        self.layout = layout
        return self

    def feed_from_interrupt(self, feeder, player):
        return False

    def serial(self, link):
        return self

    def read(self):
        data = self.incoming
        self.incoming = b""
        return data

    def write(self, data):
        self.outgoing += data

    def input(self, name):
        return False

    def watch_limit(self, name, filter_us=0):
        return None

    def levels(self):
        return 0

    def halting_input(self):
        return None

    def output(self, name, on):
        pass

    def power(self, level):
        pass

    def machine_ms(self):
        return self._ms

    link_ms = machine_ms

    def wait(self, busy, fine, at_once):
        self._ms = (self._ms + 1) & COUNT_MASK


def run_until_still(app):
    """Run the main loop until it has had nothing to do for STILL cycles in a row."""
    still = 0
    while still < STILL:
        app.cycle()
        still = 0 if app.controller.busy() else still + 1


def carry_out(app, port, lines):
    """Carry out lines of G-code, each sent when the one before has been answered; pauses end at once. Returns how many were refused."""
    refused = 0
    for line in lines:
        port.incoming += line.encode() + b"\n"
        port.outgoing = b""
        while not (b"ok" in port.outgoing or b"error" in port.outgoing):
            if app.controller.state == "hold":
                port.incoming += b"~"
            app.cycle()
        refused += b"error" in port.outgoing
    return refused


def draw_packets(app, port, packets):
    """Carry out packets of the plotter's language, each sent when the one before has been answered. Returns how many were not answered."""
    silent = 0
    for packet in packets:
        port.incoming += packet
        port.outgoing = b""
        still = 0
        while not port.outgoing and still < STILL:
            app.cycle()
            still = 0 if app.controller.busy() else still + 1
        silent += not port.outgoing
    return silent
