"""The black box: the last seconds before an alarm, a crash or a reset.

    box = Links(board, machine, queue)      # in the place of the feature of links.py
    link.serial = box.join(link)            # before its first byte
    box.close()                             # the app ends
    save_left_box(memory)                   # at the next start (port_rp2.py): what a reset has left in memory goes to flash

It keeps the bytes of one link, the one that commands at the start. G-code costs no time as it comes: lines stay in their link's buffer,
which is larger, and once a kilobyte has been taken a snapshot says what the next line is understood by. From there `passo blackbox`
plays them on the virtual board.

`numbers` is one array:

    MAGIC, SIZE of the text, where the text begins in the stream of bytes, rows so far, snapshots so far, rows so far when all was written,
    of the text: taken, come

    BOX_ROWS rows of BOX_ROW numbers: kind; ms; bytes that had come; bytes that had been taken; blocks played since the queue was empty (of
    DROPPED, STOOD and SAMPLE at least so many); position, four axes
        HALTED      the pins have stopped
        DROPPED     what was queued behind a stand is gone
        STOOD       a hold has come to its stand
        SAMPLE      four times a second while it moves: kind + 256 · (feed override + 256 · state, an index of STATES)
        INPUTS      levels, 16 bits each, in the place of the blocks and the position
        LOGGED      a number of errors.py there
        ORDER       of a real-time byte or another link, a kind of commands.py there

    BOX_SNAPSHOTS snapshots: ms, bytes that had been taken, rows so far, blocks queued, flags + 8 · the backlash taken up, position behind
    them, the log's

It is written to flash behind an alarm, once nothing moves, and as the app ends. Watchdog and reset button leave it in memory; a power cut
does not.
"""

from array import array

import micropython
from micropython import const

from passo import commands, errors
from passo.control import links
from passo.control.feature import QUEUE_GONE
from passo.options.blackbox import config as box
from passo.options.blackbox.config import (
    BOX_ADDED,
    BOX_AT,
    BOX_BASE,
    BOX_END,
    BOX_FIRST,
    BOX_HEAD,
    BOX_MAGIC_0,
    BOX_MAGIC_1,
    BOX_NUMBERS,
    BOX_ROW,
    BOX_ROWS,
    BOX_SAMPLED,
    BOX_SAMPLES,
    BOX_SIZE,
    BOX_SNAPSHOT,
    BOX_SNAPSHOTS,
    BOX_TAKEN,
    BOX_TEXT,
    BOX_WRITTEN,
)  # fmt: skip
from passo.records import COUNT_MASK

HALTED, DROPPED, STOOD, SAMPLE, INPUTS, LOGGED, ORDER = 1, 2, 3, 4, 5, 6, 7
STATES = ("idle", "run", "hold", "jog", "home", "alarm", "door", "check", "sleep")
ORDERS = commands.HOLD, commands.RESUME, commands.DOOR, commands.JOG_CANCEL, commands.RESET, commands.STOP
_ROOM = const(2048)  # of the text, for the next lines
_MUCH = const(1200)  # bytes taken between two looks: the next one comes with the next cycle
_KEPT = const(4096)  # of the bytes taken, as the text slides
_EACH = const(1000)  # bytes between snapshots
HOMED, WAITS, ALARM = 1, 2, 4  # flags: it has homed; a line is under way, which no snapshot has; it is locked
_SAMPLE_MS = const(250)
_TURNS = const(3)  # cycles between two looks
_LATER = const(20)  # cycles at a stand, in which what the alarm says goes out


class Links(links.Links):
    event_mask = QUEUE_GONE

    def __init__(self, board, machine, queue):
        links.Links.__init__(self, board, machine, queue)
        self.numbers = array("i", [0] * BOX_NUMBERS)
        self._keep = machine.port.make("blackbox", box.write_box)
        self._now_ms = machine.port.machine_ms
        self._levels = machine.inputs.levels
        self._taken = getattr(queue, "play_taken", None)  # of a machine with backlash
        self._seen = -1  # the last levels
        self._link = self._log = self._fields = self._text = None
        self._at = self._end = 0  # of `_fields`
        self._next = 0  # a snapshot when this many bytes of the text have been taken
        self._before = 0  # bytes taken at the last look: fewer now, and the text has moved up without this box
        self._logged = 0  # entries of the log
        self._halted = None  # bytes that had come, and the position
        self._retired = 0  # blocks, while what is behind them is about to be dropped
        self._stood = self._homed = False
        self._due = 0  # cycles at a stand since an alarm; 0: there is none to write
        self._turn = 0  # cycles until the next look
        self._sampled_ms = 0

    def join(self, link):
        """Begin to record the link that commands. Returns the serial line that the app is to use. A second call changes nothing."""
        if self._link is not None or link.number != self._machine.commander:
            return link.serial
        plain = not hasattr(link.protocol, "sources")
        if plain:
            log = Bytes(link)
        else:
            from passo.options.blackbox.language_grbl import Log  # most boards with a black box speak grbl, not all

            log = Log(*link.protocol.sources(), BOX_TEXT)
        self._link, self._log, self._fields, self._text = link, log, log.fields, log.text
        self._at, self._end = log.at, log.end
        numbers = self.numbers
        numbers[0], numbers[1], numbers[BOX_SIZE] = BOX_MAGIC_0, BOX_MAGIC_1, BOX_TEXT
        for shift in range(8):
            self._text[BOX_TEXT + shift] = BOX_MAGIC_1 >> shift & 0xFF
        self._take_snapshot()
        return log if plain else link.serial

    def guard(self, handlers):
        """Wrap the handlers of real-time commands, so that each is recorded: the text has no real-time bytes."""
        for kind in ORDERS:
            if kind in handlers:
                handlers[kind] = self._with_record(kind, handlers[kind])

    def _with_record(self, kind, handler):
        """Return `handler`, which first records the order `kind`."""
        def record_order(command):
            """Record the order, if no button has given it, and do it."""
            if command.link is not None and self._log.orders:  # a button has no link, and its input is recorded
                self._catch_up()  # by which it is understood
                self._add_row(ORDER, kind)
            return handler(command)

        return record_order

    # --- rows

    def _add_row(self, kind, value):
        """Write a row, or a sample, over the oldest one. Returns the index of its first number."""
        numbers = self.numbers
        if kind & 0xFF == SAMPLE:
            at = BOX_HEAD + (BOX_ROWS + numbers[BOX_SAMPLED] % BOX_SAMPLES) * BOX_ROW
            numbers[BOX_SAMPLED] += 1
        else:
            at = BOX_HEAD + numbers[BOX_ADDED] % BOX_ROWS * BOX_ROW
            numbers[BOX_ADDED] += 1
        numbers[at] = kind
        numbers[at + 1] = self._now_ms()
        numbers[at + 2] = self._note_come()
        numbers[at + 3] = numbers[BOX_BASE] + self._fields[self._at]
        numbers[at + 4] = value
        return at

    def _note_come(self):
        """Write down how many bytes of the text have been taken, and have come. Returns how many have come since the start."""
        numbers = self.numbers
        numbers[BOX_AT] = self._fields[self._at]
        numbers[BOX_END] = self._fields[self._end]
        return numbers[BOX_BASE] + numbers[BOX_END]

    def _add_position_row(self, kind, retired=None):
        """Write a row with the blocks retired and the position, in steps."""
        self._turn = 0  # an alarm may follow, behind which the machine sleeps soon
        at = self._add_row(kind, self._queue.blocks_played() if retired is None else retired) + 5
        found = self._queue.position_view()
        self.numbers[at : at + len(found)] = found

    def _take_snapshot(self):
        """Write a snapshot over the oldest one: the state by which the next line is understood."""
        machine = self._machine
        numbers = self.numbers
        target = self._queue.target
        taken = self._fields[self._at]
        self._next = taken + _EACH
        flags = (HOMED if machine.homed else 0) | (WAITS if machine.command is not None or self._link.waiting else 0) | (ALARM if machine.alarm else 0)
        if self._taken:
            flags |= self._taken() << 3
        at = BOX_FIRST + numbers[BOX_TAKEN] % BOX_SNAPSHOTS * BOX_SNAPSHOT
        numbers[at] = self._now_ms()
        numbers[at + 1] = numbers[BOX_BASE] + taken
        numbers[at + 2] = numbers[BOX_ADDED]
        numbers[at + 3] = self._queue.blocks_queued()
        numbers[at + 4] = flags
        numbers[at + 5 : at + 5 + len(target)] = target
        self._log.write_state(numbers, at + 9)
        numbers[BOX_TAKEN] += 1

    # --- once a cycle

    @micropython.native
    def poll_end(self, still):
        """Look once in _TURNS cycles."""
        turn = self._turn
        if turn:
            self._turn = turn - 1
        else:
            self._look_now(still)

    @micropython.native
    def _look_now(self, still):
        """Record what has changed since the last look; write the box to flash _LATER cycles after an alarm, at a stand."""
        machine = self._machine
        if machine.stood != self._stood or machine.homed != self._homed or machine.log.count != self._logged:
            self._record_changes(machine)
        taken = self._fields[self._at]
        much = taken - self._before > _MUCH
        if taken >= self._next or taken < self._before:
            taken = self._read_on(taken)
        self._before = taken
        if self._levels() != self._seen:
            self._look_at_inputs()
        if machine.dropping:
            self._retired = self._queue.blocks_played()
        if not still:
            now_ms = self._now_ms()
            if (now_ms - self._sampled_ms) & COUNT_MASK >= _SAMPLE_MS:
                self._sampled_ms = now_ms
                self._record_sample(machine)
        elif self._due:
            machine.awake = True  # the alarm goes out first
            self._due += 1
            if self._due > _LATER:
                self.save("alarm")
        # Also while it homes: the first line behind that finds a snapshot made.
        self._turn = 0 if much or self._due or machine.dropping or machine.busy_with(commands.HOME) else _TURNS

    def _look_at_inputs(self):
        """Write a row if the inputs' levels have changed."""
        levels = self._levels()
        if levels != self._seen:
            self._seen = levels
            self.numbers[self._add_row(INPUTS, levels & 0xFFFF) + 5] = levels >> 16 & 0xFFFF

    def _catch_up(self):
        """Record the inputs and the stand before an order or a halt, so that they come first."""
        self._look_at_inputs()
        self._record_stand()

    def _record_stand(self):
        """Write a row if a hold has come to its stand."""
        if self._machine.stood != self._stood:
            self._stood = self._machine.stood
            if self._stood:
                self._add_position_row(STOOD)

    def _record_changes(self, machine):
        """Record a stand, a homing that has ended, and new entries of the log. An alarm makes the box due; a failing power has it written at once."""
        self._record_stand()
        if machine.homed != self._homed:
            self._homed = machine.homed
            self._take_snapshot()  # none before it says where the motors are
        log = machine.log
        if log.count != self._logged:
            before = 0
            for _, number, _ in log.entries[self._logged - log.count :]:
                if number != before:  # each line that waits is refused by the same
                    self._add_row(LOGGED, number)
                    self._due = self._due or int(number > errors.ALARM_LOCKED)
                before = number
            self._logged = log.count
            if machine.alarm == errors.ALARM_POWER and self._due:
                self.save("alarm")  # at once

    def _read_on(self, taken):
        """Make room in the text if less than _ROOM bytes are left, and take a snapshot. Returns the bytes taken, as the text now counts."""
        numbers = self.numbers
        if taken < self._before:  # the language has made room: the text of before is gone
            numbers[BOX_BASE] += 2 * BOX_TEXT
        by = taken - _KEPT
        if by > 0 and self._fields[self._end] > BOX_TEXT - _ROOM:
            self._log.drop_bytes(self._text, by)
            numbers[BOX_BASE] += by
            taken -= by
        self._take_snapshot()
        return taken

    def _record_sample(self, machine):
        """Write a sample: position, state and feed override."""
        overrides = machine.overrides
        state = STATES.index(machine.state) if machine.state in STATES else 0
        self._add_position_row(SAMPLE + 256 * ((overrides[0] if overrides else 100) + 256 * state))

    def halt(self):
        """Record where the pins have stopped, behind the reason of the stop; nothing if the same was recorded last."""
        self._catch_up()
        here = self._note_come(), list(self._queue.position_view())
        if here != self._halted:
            self._halted = here
            self._add_position_row(HALTED)

    def on_events(self, _):
        """Record that the commands behind a stand are dropped."""
        self._add_position_row(DROPPED, self._retired)

    # --- flash

    def close(self):
        """Write the box as the app ends, unless nothing has happened since it was written last."""
        if self.numbers[BOX_ADDED] != self.numbers[BOX_WRITTEN]:
            self.save("end")

    def save(self, why):
        """Write the box to flash, only at a stand; `why`: alarm, end or reset. If flash or memory is full the box is lost."""
        self._due = 0
        numbers = self.numbers
        self._note_come()
        numbers[BOX_WRITTEN] = numbers[BOX_ADDED]
        port = self._machine.port
        port.writing(True)
        try:
            self._keep(why, numbers, self._text, port.feed_watchdog)
        except (OSError, MemoryError):
            pass  # flash or memory is full: this box is lost, and the machine goes on to be made safe
        port.writing(False)


class Bytes:
    """The serial line of a link whose language keeps no lines."""

    at = end = 0
    orders = False  # they are among the bytes

    def __init__(self, link):
        serial = link.serial
        self._read = serial.read
        self.write = serial.write
        self.any = getattr(serial, "any", None)
        self.text = bytearray(BOX_TEXT + 8)
        self.fields = array("i", [0])

    def read(self):
        """Read the line below, and append the bytes to the text; a full text begins anew."""
        data = self._read()
        if data:
            end = self.fields[0] + len(data)
            if end > BOX_TEXT:
                end = len(data)  # as a language that makes room: the bytes of before are lost
            self.text[end - len(data) : end] = data
            self.fields[0] = end
        return data

    def drop_bytes(self, text, by):
        """Forget the first `by` bytes."""
        self.fields[0] -= by
        text[: self.fields[0]] = memoryview(text)[by : by + self.fields[0]]

    def write_state(self, numbers, index):
        """Do nothing: a packet needs no state."""
