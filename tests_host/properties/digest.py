"""The digest of a job: SHA-256 over its step words, the same on every interpreter.

MICROPYPATH=build/unix/STATE:tests_host/properties:tests_host/sims:. micropython tests_host/properties/digest.py job.bin|job.gcode|job.hex [board [steps/mm]]

`job.bin` holds the packets a host sends, `job.gcode` lines of G-code, one after the other as they are answered, to a
machine that is not homed; `job.hex` lines of bytes in hexadecimal, the next one sent when nothing moves any more, or after N cycles if the line ends with `@N`
(with `ramps` as the last argument, axes that run on their own
accelerate); the feeder's words are taken from the ring at once. Prints the digest, the number of words and how many
of them step; of G-code also a checksum of the changes of power, and how many lines were refused. A board with fewer
steps/mm, on all axes, makes a large job quicker.
"""

import gc
import hashlib
import sys
from binascii import crc32, unhexlify

from passo.app import App
from passo.steps.word import COUNT_MASK

SILENT_TURNS = 40  # of 1 ms: longer than a link's gap and the motors' waking


def checked(board):
    """The board file's table is forgotten again, as main.py does it: a chip has little memory for it."""
    from passo.config.boardfile import check

    board = check(dict(board, journal=None, servo=None))  # the port has neither flash nor a servo
    if sys.implementation.name == "micropython":
        sys.modules.pop("passo.config.boardfile")
        del sys.modules["passo.config"].boardfile
        gc.collect()
    return board


class Sink:
    """A port whose player swallows words: it hashes them little-endian, and counts those that step."""

    min_word_ticks = 50
    eager = False

    def __init__(self, counts=True):
        """`counts` False: words are not looked at one by one, which takes its time on a board."""
        self._counts = counts
        self.words = self.stepping = self.marks = 0
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
        while self._played != ring.head:
            at = self._played & ring.mask
            count = min((ring.head - self._played) & COUNT_MASK, ring.size - at)
            self._hash.update(memoryview(ring.words)[at : at + count])
            if self._counts:
                self._count_steps(at, count)
            while (ring.power.next(self._played) - self._played) & COUNT_MASK < count and ring.power.next(self._played) >= 0:
                self._mark(ring.power.next(self._played))
            self._played = (self._played + count) & COUNT_MASK
            self.words += count

    def _count_steps(self, at, count):
        mask = self._layout.levels_mask & ~self._layout.tool_mask
        words = self._ring.words
        for place in range(at, at + count):
            levels = words[place] & mask
            self.stepping += 1 if self._steps(levels) else 0
            self._before = levels

    def _mark(self, word):
        power = self._ring.power
        before = power.level
        power.play((word + 1) & COUNT_MASK)
        if power.level == before:
            return  # the output shows nothing of it
        words = self.words + ((word - self._played) & COUNT_MASK)
        self.marks = crc32(b"%d %d" % (words, power.level), self.marks) & 0xFFFFFFFF

    def _steps(self, levels):
        if self._layout.pulse_mask:
            return levels & self._layout.pulse_mask
        return levels != self._before

    def halt(self):
        pass

    def busy(self):
        return False

    def words_played(self):
        return self._played

    def rest(self, levels):
        self._before = levels & ~self._layout.tool_mask

    # the port

    def player(self, ring, layout, board):
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


def digest(board, job, port=None):
    """Play `job` (a file of packets, open for reading) on `board`; returns the Sink: `port`, if there is one."""
    from passo.protocols.plotter.protocol import PACKET

    port = port or Sink()
    app = App(checked(board), port)
    while True:
        port.incoming = job.read(PACKET)
        if not port.incoming:
            return port
        port.outgoing = b""
        silent = 0
        while not port.outgoing and silent < SILENT_TURNS:
            app.cycle()
            silent = 0 if app.controller.busy() else silent + 1


def digest_lines(board, job, port=None):
    """Carry out `job` (a file of G-code, open for reading) on `board`; returns the Sink, and how many lines were refused.

    A line that has waited long enough is one for the operator: the pause is resumed.
    """
    port = port or Sink()
    app = App(checked(board), port)
    refused = 0
    line = b"$X"
    while line:
        port.incoming += line.strip() + b"\n"
        port.outgoing = b""
        while not (b"ok" in port.outgoing or b"error" in port.outgoing):
            if app.controller.state == "hold":
                port.incoming += b"~"
            app.cycle()
        refused += b"error" in port.outgoing
        line = job.readline()
    silent = 0
    while silent < SILENT_TURNS:
        app.cycle()
        silent = 0 if app.controller.busy() else silent + 1
    return port, refused


def digest_hex(board, job, port=None):
    """Send `job` (a file of lines, open for reading) to `board`; returns the Sink."""
    port = port or Sink()
    app = App(checked(board), port)
    for line in job:
        data, _, turns = line.partition("@")
        port.incoming += unhexlify("".join(data.split()))
        silent = 0
        for _ in range(int(turns) if turns else 1_000_000):
            app.cycle()
            silent = 0 if app.controller.busy() else silent + 1
            if not turns and silent > SILENT_TURNS:
                break
    return port


def copied(value):
    """A value of a board file, down to its last list: others use the same file."""
    if isinstance(value, dict):
        return {key: copied(value[key]) for key in value}
    return [copied(each) for each in value] if isinstance(value, list) else value


def board_named(name, table=None):
    """A file of boards/, or its `table` where it is like another's; NAME+laser has a laser instead of its spindle."""
    name, _, laser = name.partition("+")
    board = copied(table or getattr(__import__("boards." + name), name).BOARD)
    board["links"] = board["links"][:1]  # a second one would only want memory
    if laser:
        board["spindle"] = {"max_rpm": 1000, "pwm": True, "pin": 22, "laser": True}
    return board


def show_lines(path, name="router_3axis", steps_mm=None, counts=True):
    """Print the digest of a file of G-code; where `counts` is False, 0 instead of how many words step."""
    board = board_named(name)
    for axis in board["axes"] if steps_mm else ():
        axis["steps_per_m"] = int(steps_mm) * 1000
    with open(path, "rb") as job:
        port, refused = digest_lines(board, job, Sink(counts))
    print(port.hexdigest(), port.words, port.stepping, "%08x" % port.marks, refused)


def main(arguments):
    if arguments[0].endswith(".gcode"):
        return show_lines(*arguments)
    if arguments[0].endswith(".hex"):
        board = board_named(arguments[1])
        if "ramps" in arguments[2:]:
            board["planning"]["independent_ramps"] = True
        with open(arguments[0]) as job:
            port = digest_hex(board, job)
        print(port.hexdigest(), port.words, port.stepping)
        return
    with open(arguments[0], "rb") as job:
        port = digest(board_named(arguments[1] if len(arguments) > 1 else "plotter_2014"), job)
    print(port.hexdigest(), port.words, port.stepping)


if __name__ == "__main__":
    main(sys.argv[1:])
