"""Asks for the position while the machine steps: on the chip itself, and over a link.

    for took_us, walked in ask_positions(rig, (10000, 7000, -5000), 100_000): …     # raises AssertionError if one is wrong

    asking = Asking(machine, "serial")
    asking.stream_lines([b"G1X9F900\\n", …])
    asking.ask_status()                 # ms from `?` to the answer's first byte
"""

from bisect import bisect_right

from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.rig import ticks_of

ASKED = 400
LIMIT_US = 5_000_000
ANSWER_LIMIT_MS = 500
BUFFER_BYTES = 127  # of a grbl, as senders count it
_ASK = """
from array import array
from passo.steps.position_viper import find
state, marks = feeder.state, feeder.marks
place = array("i", [0] * {each})
asked = array("i", [0] * ({each} * {count}))
def ask():
    begun = ticks_us()
    position = feeder.position(player.words_played())
    return begun, ticks_us(), position
def walk():
    played = player.words_played()
    return (played - marks[find(state, marks, played, place)]) & 0x1FFFFFFF
def nothing():
    begun = ticks_us()
    return ticks_diff(ticks_us(), begun)
threshold = gc.threshold()
gc.threshold(-1)
gc.collect()
planner.line({deltas!r}, {ticks}, False)
planner.flush()
controller.machine.awake = True
while player.words_played() < 500:
    app.cycle()
at = turn = 0
while at < len(asked) and player.busy():
    turn += 1
    if turn % 8 == 0:
        port.wait(True)
    for _ in range(turn * 29 % 200):
        pass
    walked = walk()
    begun, ended, position = ask()
    asked[at] = begun
    asked[at + 1] = ended
    asked[at + 2] = walked if walked < 0x10000000 else 0  # the feeder's interrupt came in between
    for axis in range({each} - 3):
        asked[at + 3 + axis] = position[axis]
    at += {each}
while not planner.empty() or player.busy():
    app.cycle()
gc.threshold(threshold)
print((min([nothing() for _ in range(20)]), list(asked[:at])))
"""


def ask_positions(rig, deltas, steps_s):
    """Ask for a line's position at all times between two runs of the feeder; return [(µs that asking took, words walked since the last checkpoint)].
    Raises AssertionError unless each answer is where the edges had the axes meanwhile."""
    rig.clear_edges()
    each = 3 + rig.axes
    code = _ASK.format(each=each, count=ASKED, deltas=deltas, ticks=ticks_of(deltas, steps_s))
    reading_us, asked = eval(rig.pico.exec(code, limit_us=LIMIT_US))
    timer_us = rig.pico.chip.timer._micros()
    offset = rig.pico.cycle - round(timer_us * CYCLES_PER_US)
    rises = [[cycle for cycle, state in log if state == 1] for log in rig.step_edges]
    found = []
    for at in range(0, len(asked), each):
        begun, ended, walked, *position = asked[at : at + each]
        for axis, place in enumerate(position):
            least, most = (bisect_right(rises[axis], us * CYCLES_PER_US + offset) for us in (begun, ended + 1))
            assert least <= abs(place) <= most, f"axis {axis} at {place}, between {least} and {most} by its edges"
        found.append((ended - begun - reading_us, walked))
    return found


class Asking:
    """A sender of G-code on one link of an emulated machine, which also asks for the status. It takes `think_us` to read an
    answer and send what that makes room for."""

    def __init__(self, machine, link, think_us=0, window=BUFFER_BYTES):
        self._machine = machine
        self._window = window  # bytes under way
        self._pico = machine.pico
        config = next(config for config in machine.board["links"] if config["name"] == link)
        self._wire = None
        if config["port"] == "usb":
            self._pico.usb.heard = self._take_bytes
        else:
            self._wire, self._baud = machine.wire(link), config["baud"]
            self._wire.listeners.append(lambda value: self._take_bytes(bytes((value,))))
        self.said = bytearray()
        self._begins = []  # cycles at which a status has begun
        self._think_cycles = think_us * CYCLES_PER_US
        self._lines = []  # still to be sent
        self.unanswered = []  # lengths of the lines sent

    def _take_bytes(self, data):
        """Take bytes from the board: note the cycle of each "<", and count each "ok" as an answer, `think_us` later if the PC thinks."""
        self._begins += [self._pico.cycle] * data.count(b"<")
        before = self.said.count(b"ok\r\n")
        self.said += data
        answered = self.said.count(b"ok\r\n") - before
        if answered and self._think_cycles:
            self._pico.call_at(self._pico.cycle + self._think_cycles, lambda: self._note_answers(answered))
        else:
            self._note_answers(answered)

    def _note_answers(self, count):
        for _ in range(count):
            self.unanswered.pop(0)
            self._send_waiting()

    def _send_bytes(self, data):
        """Send bytes; return the cycle at which the last one has arrived."""
        if self._wire:
            return self._wire.feed(data, self._baud)
        self._pico.usb.write(data)
        return self._pico.cycle

    def stream_lines(self, lines):
        """Send lines, as many at a time as grbl's buffer takes."""
        self._lines += lines
        self._send_waiting()

    def _send_waiting(self):
        """Send waiting lines while the unanswered bytes fit the window."""
        while self._lines and sum(self.unanswered) + len(self._lines[0]) <= self._window:
            line = self._lines.pop(0)
            self.unanswered.append(len(line))
            self._send_bytes(line)

    def ask_status(self):
        """Send `?`; returns the emulated ms from its arrival to the first byte of the answer. Raises TimeoutError."""
        self._begins.clear()
        asked = self._send_bytes(b"?")
        self._machine.run_until(lambda: self._begins, ANSWER_LIMIT_MS, 200)
        return (self._begins[0] - asked) / CYCLES_PER_US / 1000
