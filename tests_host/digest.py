"""The digest of a job: SHA-256 over its step words, the same on every interpreter.

    MICROPYPATH=firmware:tests_host:. micropython tests_host/digest.py job.bin [board]

`job.bin` holds the packets a host sends, one after the other as they are answered, to a machine that is not homed;
what the feeder makes is taken from the ring at once. Prints the digest, the number of words and how many of them step.
"""

import hashlib
import sys

from passo.app import App
from passo.control.boardfile import check
from passo.protocols.plotter import PACKET
from passo.steps.word import COUNT_MASK

SILENT_TURNS = 40  # of 1 ms: longer than a link's gap and the motors' waking


class Sink:
    """A port whose player swallows words: it hashes them little-endian, and counts those that step."""

    min_word_ticks = 50

    def __init__(self):
        self.words = self.stepping = 0
        self.incoming = b""
        self.outgoing = b""
        self._ms = 0
        self._played = 0
        self._hash = hashlib.sha256()
        self._before = 0

    def hexdigest(self):
        return "".join(["%02x" % byte for byte in self._hash.digest()])

    # the player

    def start(self):
        ring = self._ring
        mask = self._layout.levels_mask & ~self._layout.tool_mask
        data = bytearray()
        while self._played != ring.head:
            word = ring.words[self._played & ring.mask]
            data += bytes((word & 255, word >> 8 & 255, word >> 16 & 255, word >> 24))
            levels = word & mask
            self.stepping += 1 if self._steps(levels) else 0
            self._before = levels
            self._played = (self._played + 1) & COUNT_MASK
            self.words += 1
        self._hash.update(data)

    def _steps(self, levels):
        if self._layout.pulse_mask:
            return levels & self._layout.pulse_mask
        return levels != self._before

    def halt(self):
        pass

    def busy(self):
        return False

    def played(self):
        return self._played

    def rest(self, levels):
        self._before = levels & ~self._layout.tool_mask

    # the port

    def player(self, ring, layout):
        self._ring = ring
        self._layout = layout
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

    def tripped(self):
        return None

    def output(self, name, on):
        pass

    def machine_ms(self):
        return self._ms

    link_ms = machine_ms

    def wait(self, busy, fine):
        self._ms = (self._ms + 1) & COUNT_MASK


def digest(board, job):
    """Play `job` (a file of packets, open for reading) on `board`; returns the Sink."""
    port = Sink()
    app = App(check(board), port)
    while True:
        port.incoming = job.read(PACKET)
        if not port.incoming:
            return port
        port.outgoing = b""
        silent = 0
        while not port.outgoing and silent < SILENT_TURNS:
            app.turn()
            silent = 0 if app.controller.busy() else silent + 1


def main(arguments):
    name = arguments[1] if len(arguments) > 1 else "plotter_2014"
    board = getattr(__import__("boards." + name), name).BOARD
    with open(arguments[0], "rb") as job:
        port = digest(board, job)
    print(port.hexdigest(), port.words, port.stepping)


if __name__ == "__main__":
    main(sys.argv[1:])
