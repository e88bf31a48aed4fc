"""Runs a job of G-code through the firmware as fast as it goes, and hands out its step words as arrays; see job.py.

    runner = Runner(BOARD, sink, due)
    runner.run(lines)                   # an iterable of (number in the file, bytes)

One text for CPython and MicroPython, whose machine code makes words some five times faster:

    MICROPYPATH=build/unix/STATE micropython job_runner.py < job > frames

The job: a line with repr((BOARD, changes, zero, start)), then blocks of lines `number TAB text`, each behind a line with its size;
0 ends them. A frame: HEADER, then the bytes that it counts. job.py writes the one and reads the other.

Methods of `sink`:

    add_words(number, tick, words)          step words that begin at `tick`, one behind the other; `number`: the line under way
    add_note(kind, number, code, text)      a NOTE_… about that line: its text, and the number of an error
    begin(tick, position)                  the job begins: everything before only led there; `position` in steps

Words are played by `BulkPlayer`, which knows when they are due and has no pins: nothing reacts to them.
"""

import io
import struct
import sys
from array import array

import micropython
from micropython import const

from passo.ports.virtual import COARSE_TICKS
from passo.records import COUNT_MASK, QUEUE_ADDED, QUEUE_RETIRED

HEADER = "<BIIq"  # kind, line, bytes that follow, tick or error
WORDS, NOTE_REFUSED, NOTE_ALARM, NOTE_PAUSED, NOTE_PROBED, NOTE_SKIPPED, BEGIN, END, FAILED = range(9)
WINDOW = 120  # bytes under way
STORE = 2048  # words handed out at once
_SETTLE_CYCLES = 50
_LIMITLESS_CYCLES = 2_000_000  # without an answer: 4 hours of a dwell
_FULL = const(86)  # blocks queued, of 96: lines come when there is room for several
_FEW = const(2)  # blocks played in a cycle: three cycles may pass at once, well inside the 30 ms that the feeder keeps ahead
_LONG_TICKS = 3 * COARSE_TICKS
_SPENT = const(0)  # of a box: ticks


class Failed(Exception):
    """The job cannot be run: a text, the values of its fields, and a line of the job or 0."""

    def __init__(self, text, *values, line=0):
        super().__init__(text.format(*values))
        self.line, self.said = line, (text,) + values


@micropython.viper
def copy_due(words: ptr32, mask: int, bits: int, first: int, count: int, ticks: int, store: ptr32, at: int, box: ptr32) -> int:
    """Copy those of the `count` words from words[first] on that begin within the next `ticks` to store[at:]. Returns how many;
    box: the ticks they last."""
    spent = 0
    done = 0
    while done < count and spent < ticks:
        word = words[(first + done) & mask]
        store[at + done] = word
        spent += word >> bits
        done += 1
    box[_SPENT] = spent
    return done


class BulkPlayer:
    """Plays a ring's words by handing them out in great numbers. In the position of passo.ports.virtual_player.Player."""

    def __init__(self, port, ring, layout, pulse_ticks, min_word_ticks, invert):
        self.min_word_ticks = min_word_ticks
        self.now = 0
        self.sink = None
        self.line = 0  # the line under way
        self._due = copy_due
        self._ring = ring
        self._layout = layout
        self._levels = 0
        self._played = 0
        self._next = 0  # tick at which the last word taken ends
        self._playing = False
        self._store = array("I", bytes(4 * STORE))
        self._view = memoryview(self._store)
        self._count = 0  # words in it, which begin at
        self._begun = 0
        self._ends = 0
        self._box = array("I", [0])

    def hand_out(self, sink, due):
        """Words go to `sink` from now on; `due`: copy_due() or what does the same."""
        self._count = 0
        self.sink = sink
        self._due = due

    def start(self):
        self._playing = True

    def stop(self):
        self._playing = False

    def halt(self):
        self._playing = False
        self._next = self.now
        self._show_levels(self._levels & ~(self._layout.pulse_mask | self._layout.tool_mask))

    def busy(self):
        return self._next > self.now or (self._playing and self._played != self._ring.head)

    def words_played(self):
        return self._played

    def levels(self):
        return self._levels

    def rest(self, levels):
        self._show_levels(levels)

    def show_power(self, tick, level):
        pass

    def _show_levels(self, levels):
        """Other levels without a step: a word of no time."""
        if levels != self._levels:
            self._levels = levels
            self._make_room(self.now)
            self._store[self._count] = levels
            self._count += 1

    def _make_room(self, tick):
        """There is room for a word at `tick`, and those in the store end there."""
        if self._count == STORE or tick != self._ends:
            self.flush()
        if not self._count:
            self._begun = self._ends = tick

    def run(self, until):
        """Play everything that is due before the tick `until`."""
        if self._next < self.now:
            self._next = self.now
        ring = self._ring
        while self._playing and self._next < until and self._played != ring.head:
            self._make_room(self._next)
            count = min((ring.head - self._played) & COUNT_MASK, STORE - self._count)
            first = self._played & ring.mask
            box = self._box
            count = self._due(
                ring.words, ring.mask, self._layout.bits, first, count, until - self._next, self._store, self._count, box
            )
            self._count += count
            self._played = (self._played + count) & COUNT_MASK
            self._next += box[_SPENT]
            self._ends = self._next
            self._levels = self._store[self._count - 1] & self._layout.levels_mask & ~self._layout.pulse_mask
            ring.power.play(self._played)
        self.now = until

    def flush(self):
        """Hand out what is stored."""
        if self._count and self.sink is not None:
            self.sink.add_words(self.line, self._begun, self._view[: self._count])
        self._count = 0


def is_order(line):
    """True of $H, $X, $C and the like; not of settings, jogs and $WEAVE."""
    if line[:6] == b"$WEAVE":
        return False
    return line[:1] == b"$" and not line[1:2].isdigit() and line[1:2] not in b"Jj"


def has_probe(line):
    """True if a line of G-code, bytes, has a probing move."""
    return b"G38" in line.upper()


class Resting:
    """The world of a board that nothing is wired to: no input is active."""

    def __init__(self, board):
        self._resting = {}
        for item in board["inputs"]:
            self._resting[item["name"]] = 1 - item["active"]

    def attach(self, tick, names, levels):
        pass

    def edges(self, tick, levels, changed):
        pass

    def output(self, tick, name, level):
        pass

    def servo(self, tick, us):
        pass

    def input(self, tick, name):
        return self._resting[name]

    def run(self, tick):
        pass

    def next_event(self):
        return None


class Runner:
    def __init__(self, board, sink, due=copy_due, changes=(), zero=None, start=None):
        """`board`: a board file's, not checked; `changes`: lines carried out first, as text; `zero`: where the program's zero
        lies on the homed machine, in mm; `start`: where the machine stands then. Raises Failed."""
        from passo.app import App
        from passo.config.boardfile import BoardError, check
        from passo.ports.virtual import VirtualPort

        try:
            board = check(board)
            plain = dict.fromkeys(("journal", "jobs", "card", "network"))  # keys that need flash or a radio, and change no step
            board = check(dict(board, links=board["links"][:1], commands="", **plain))
        except BoardError as error:
            raise Failed("{}", str(error))
        link = board["links"][0]
        link["protocol"] = "grbl"
        self.board = board
        self._sink = sink
        port = VirtualPort(board, Resting(board), player=BulkPlayer)
        self._app = App(board, port)
        self._port = port
        self._player = self._app.player
        self._line = port.serial(link)
        self._under_way = []  # (number, line) sent, not answered
        self._size = 0  # their bytes
        self._paused = None
        self._carry_out(["$X", "$20=0"])
        self._carry_out(changes)
        if zero is not None:
            self._place_zero(zero)
        if start is not None:
            self._app.controller.machine.homed = True
            self._carry_out(["G53G21G90G0" + self._axis_words(start)] if any(start) else [])
        self._player.hand_out(sink, due)
        queue = self._app.controller.queue
        sink.begin(port.now, [int(position) for position in queue.target] if start is not None else [0] * len(board["axes"]))

    def _axis_words(self, positions):
        return "".join([axis["name"].upper() + "%.4f" % position for axis, position in zip(self.board["axes"], positions)])

    def _carry_out(self, lines):
        """Carry out lines, to the end of their motion."""
        for line in lines:
            self._line.incoming += line.encode() + b"\n"
            for _ in range(_SETTLE_CYCLES):
                self._app.cycle()
            while not self._app.controller.queue.still():
                self._app.cycle()
            said = self._line.outgoing.decode()
            self._line.outgoing = b""
            if "error:" in said or "ALARM:" in said:
                raise Failed("the machine refuses {}: {}", line, said.strip().replace("\r\n", ", "))

    def _place_zero(self, zero):
        """The machine has homed and the operator has set G54."""
        board = self.board
        names = [axis["name"].upper() for axis in board["axes"]]
        if not board["homing"]:
            raise Failed("{} does not home: it has no soft limits", board["name"])
        if len(zero) != len(names):
            raise Failed("the machine has {} axes, {}, and {} places are given", len(names), ", ".join(names), len(zero))
        for number, position in enumerate(zero):
            scale = board["axes"][number]["steps_per_m"] / 1000
            low, high = [end / scale for end in self._app.controller.queue.reach(number)]
            if not low <= position <= high:
                raise Failed("{}{:g} is not on the machine, which goes from {:g} to {:g} mm", names[number], position, low, high)
        self._app.controller.machine.homed = True
        self._carry_out(["$20=1", "G21G10L2P1" + self._axis_words(zero)])

    def run(self, lines):
        """Carry out the lines of a job, to the end of their motion. Raises Failed."""
        app = self._app
        lines = iter(lines)
        ahead = self._next_line(lines)
        idle = 0
        while ahead or self._under_way:
            while ahead and self._may_send(ahead[1]):
                self._under_way.append(ahead)
                self._size += len(ahead[1]) + 1
                self._line.incoming += ahead[1] + b"\n"
                ahead = self._next_line(lines)
            self._player.line = self._under_way[0][0]
            if app.controller.state == "hold":
                self._resume_pause()
            app.cycle()
            if self._line.outgoing:
                idle = 0
                self._read_answers()
            else:
                self._play_on()
            idle += 1
            if idle > _LIMITLESS_CYCLES:
                raise Failed("there was never an answer", line=self._under_way[0][0])
        while not app.controller.queue.still():
            app.cycle()
        self._player.flush()

    def _play_on(self):
        """Play until the queue has room, without the other parts of a cycle, which cost ten times as much: no line can come before."""
        app, port = self._app, self._port
        machine = app.controller.machine
        if machine.alarm or machine.hold or machine.command is not None or machine.dropping:
            return
        ticks = COARSE_TICKS
        queued = self._count_queued()
        while queued > _FULL and app.feeder.open:
            app._make_words()
            port.advance(ticks)
            before, queued = queued, self._count_queued()
            ticks = _LONG_TICKS if before - queued <= _FEW else COARSE_TICKS

    def _count_queued(self):
        """Return how many blocks have not been played."""
        indices = self._app.planner.indices
        return (indices[QUEUE_ADDED] - indices[QUEUE_RETIRED]) & COUNT_MASK

    def _next_line(self, lines):
        """Return (number, line) of the next line that is part of a job, or None. Orders ($H, $X) are noted and skipped."""
        for number, line in lines:
            if not is_order(line):
                return number, line
            self._sink.add_note(NOTE_SKIPPED, number, 0, line)
        return None

    def _may_send(self, line):
        """True if `line` may be sent too. Probing is sent alone: the alarm at its end would refuse the next lines."""
        if self._under_way and (has_probe(line) or has_probe(self._under_way[-1][1])):
            return False
        return not self._under_way or self._size + len(line) < WINDOW

    def _resume_pause(self):
        """Act as the operator in a pause: the oldest line without an answer asked for it."""
        if self._under_way and self._under_way[0] != self._paused:
            self._paused = self._under_way[0]
            self._sink.add_note(NOTE_PAUSED, self._paused[0], 0, self._paused[1])
        self._line.incoming += b"~"

    def _read_answers(self):
        """Read the answers of the virtual board; an "ok" or an error ends the oldest line under way."""
        data = self._line.outgoing
        self._line.outgoing = b""
        for said in data.decode().split("\r\n"):
            if said == "ok" or said.startswith("error:"):
                if not self._under_way:
                    continue
                number, line = self._under_way.pop(0)
                self._size -= len(line) + 1
                if said != "ok":
                    self._sink.add_note(NOTE_REFUSED, number, int(said[6:]), line)
            elif said.startswith("ALARM:"):
                self._note_alarm(int(said[6:]))

    def _note_alarm(self, alarm):
        """Note an alarm and unlock with $X. Raises Failed if the alarm wants a reset."""
        from passo import error_texts, errors

        number, line = self._under_way[0] if self._under_way else (0, b"")
        alarm += 200
        if errors.ALARMS.get(alarm, 0) & errors.NEEDS_RESET:
            self._player.flush()
            raise Failed("{}: alarm {}, {}", line.decode(), alarm - 200, error_texts.text(alarm), line=number)
        missed = alarm in (errors.ALARM_PROBE_STATE, errors.ALARM_PROBE_MISSED)
        self._sink.add_note(NOTE_PROBED if missed else NOTE_ALARM, number, alarm, line)
        self._under_way.append((number, b"$X"))
        self._size += 3
        self._line.incoming += b"$X\n"


class Frames:
    """A sink that writes frames to a stream of bytes."""

    def __init__(self, out):
        self._out = out

    def add_words(self, number, tick, words):
        self._write_frame(WORDS, number, len(words) * 4, tick, words)

    def add_note(self, kind, number, code, text):
        self._write_frame(kind, number, len(text), code, text)

    def begin(self, tick, position):
        self._write_frame(BEGIN, 0, 4 * len(position), tick, array("i", position))

    def _write_frame(self, kind, number, size, value, data):
        self._out.write(struct.pack(HEADER, kind, number, size, value))
        if size:
            self._out.write(data)


def _lines_of(stream):
    """Yield (number, bytes) of each line of the job. They come in blocks, because reading a line takes a call of the system for each byte."""
    while True:
        size = int(stream.readline() or 0)  # nothing: nobody sends any more
        if not size:
            return
        for line in stream.read(size).split(b"\n"):
            number, text = line.split(b"\t", 1)
            yield int(number), text


def main():
    """Run a job from stdin and write frames to stdout: step words, notes, then END or FAILED with the cause."""
    frames = Frames(sys.stdout.buffer)
    jobs = sys.stdin.buffer
    board, changes, zero, start = eval(jobs.readline().decode())
    try:
        Runner(board, frames, copy_due, changes, zero, start).run(_lines_of(jobs))
        frames.add_note(END, 0, 0, b"")
    except Failed as failed:
        frames.add_note(FAILED, failed.line, 0, repr(failed.said).encode())
    except Exception as error:
        said = io.StringIO()
        sys.print_exception(error, said)
        frames.add_note(FAILED, 0, 0, repr((said.getvalue(),)).encode())


if __name__ == "__main__":
    main()
