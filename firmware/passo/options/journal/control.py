"""The job's journal: where a program is, kept in raw pages of flash that are written without an erase, also while it moves.

    port.pages.read(block, slot) → 32 bytes, b"" if the block is still to be made; write(block, slot, data); erase(block); BLOCKS, SLOTS

A record is 32 bytes: sequence u16, flags u16, job u32, line u32, four positions i32 in steps, CRC-32 of all before. Records follow
each other through the blocks; the newest whole one counts, so a power cut at any byte of a write leaves the one before. A page takes
0.7 ms, up to 3, in which no interrupt comes: the words that lie ahead, 8 ms and more, play on, and the port keeps the bytes of lines.

An erase takes 45 to 400 ms. So blocks are erased only as a job is announced, whose answer comes after it, and one a second while the
machine has stood for that long; never the one with the newest record.

A position written while it moves is at most `every_ms` old, twice that once half of the slots are used, and so on; at a stand all is
written. The job is a number that the PC makes of its file; lines are those of N words.

A job of commands of a step program, or of points of a drawing, is counted instead, and announced before it comes: JOURNAL with (number,
line, flags, lead, position), which become the first record, so that a job that is gone on with may be interrupted before it has moved.
`lead`: commands or points that come first and are none of the job's, such as the way to the position. A job that is not announced is not
written down. A step program's line is how many of its commands are done, and the position is that behind the last: a step is made or it is
not. A drawing's line is the point under way. The position is known, as homed, as long as it has been counted since the job began. Of a
machine whose rotary axis homes at no sensor it is not known once the board has started anew.
"""

from array import array
from struct import pack, unpack

from binascii import crc32
from micropython import const

from passo import commands, errors
from passo.commands import SPOT_AXES, SPOT_BACK, SPOT_INDEX, SPOT_TIMES
from passo.control.feature import QUEUE_GONE, Feature
from passo.control.links import ASKS, OF_LENDER, RIGHTS
from passo.records import COUNT_MASK, JOURNAL_BYTES, KIND_WAIT, REST_MS, ROW_KIND, ROW_TAG

_WAITS = const(8)  # blocks that wait for a tool, behind a line
DONE = const(1)  # flags: the line has been played to its end, the position is there
HOMED = const(2)
BACK = const(4)  # a step program is played towards its start
_TIMES = const(8)  # the bit from which on stand the times that it is to be played, this one included
_FORM = "<HHIIiiii"
_EMPTY = b"\xff" * 32


def pack_record(sequence, flags, job, line, position):
    """Return the 32 bytes of a record."""
    body = pack(_FORM, sequence, flags, job, line, *position)
    return body + pack("<I", crc32(body) & 0xFFFFFFFF)


def unpack_record(data):
    """Return (sequence, flags, job, line, [positions]) of 32 bytes; None if the record is not whole."""
    if len(data) != JOURNAL_BYTES or unpack("<I", data[28:])[0] != crc32(data[:28]) & 0xFFFFFFFF:
        return None
    fields = unpack(_FORM, data[:28])
    return fields[0], fields[1], fields[2], fields[3], list(fields[4:])


class JobJournal(Feature):
    event_mask = QUEUE_GONE

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._every_ms = board["journal"]["every_ms"]
        self._pages = pages = machine.port.pages
        self._axes = len(board["axes"])
        self._sequence = 0
        self._block = self._slot = 0  # the place of the next record
        self._job = self._line = self._flags = 0
        self._done = 0  # lines up to this one are none of the job's that began last, or were done when it was announced
        self._position = [0] * 4
        self._written = None  # the contents of the newest record
        self._written_ms = 0
        self._empty = [0] * pages.BLOCKS  # slots of each block that are erased
        self._left = 0  # and of all
        self._half = pages.SLOTS * pages.BLOCKS // 2
        self._newest = 0  # the block with the newest record
        self._rest_ms = 0  # since when the machine stands
        self._late = False  # the position at this stand is still to be written
        self._retired = queue.blocks_played()  # blocks, as seen last
        self._moving = False  # by a line of the job
        self._broken = False  # the queue has been dropped amid a line
        self._counted = None  # machine.job, see handlers(); None: lines have numbers
        self._spot = array("i", [0] * (SPOT_AXES + self._axes))
        self._lead = self._times = 0  # as announced, of one that is counted
        self._back = False
        self._astray = 0  # homing does not tell where the machine stands
        self._find_newest(pages)

    def _find_newest(self, pages):
        """Find the newest whole record, count the erased slots, and go to the slot behind it."""
        newest = None
        for block in range(pages.BLOCKS):
            for slot in range(pages.SLOTS):
                data = pages.read(block, slot)
                if not data:  # an erase makes the block
                    break
                if data == _EMPTY:  # most are: 512 of them would be garbage
                    if pages.read(block, pages.SLOTS - 1) == _EMPTY:  # those between are empty, too; else power went amid an erase
                        self._empty[block] += pages.SLOTS - slot
                        break
                    self._empty[block] += 1
                    continue
                record = unpack_record(bytes(data))
                if record and (newest is None or (record[0] - newest[0]) & 0xFFFF < 0x8000):
                    newest = record
                    self._newest = self._block = block
                    self._slot = slot + 1
        self._left = sum(self._empty)
        if newest:
            self._sequence = newest[0] + 1 & 0xFFFF
            self._written = newest[1:]
            self._flags, self._job, self._line, self._position = newest[1:]
            self._flags &= ~HOMED  # a rotor's position may have changed while the board was off
            self._astray = self._job and getattr(self._queue, "turns", 0) & 4
        self._next_free()

    def _next_free(self):
        """Go on to the next slot that has been erased; `_block` is −1 if there is none."""
        pages = self._pages
        for _ in range(pages.BLOCKS + 1 if self._left else 0):
            while self._slot < pages.SLOTS:
                if bytes(pages.read(self._block, self._slot)) == _EMPTY:
                    return
                self._slot += 1
            self._block = (self._block + 1) % pages.BLOCKS
            self._slot = 0
        self._block = -1

    def handlers(self):
        self._counted = self._machine.job  # of a feature that is made in any order
        RIGHTS[commands.JOURNAL] = ASKS | OF_LENDER
        return {commands.JOURNAL: self._do_journal}

    def _do_journal(self, command):
        """Do JOURNAL. `target` None: return (job, line, flags, positions). A number: the job with this number begins. 0: the last job is done,
        nothing is left to resume."""
        machine = self._machine
        if command.target is None:
            flags = self._flags & ~HOMED | self._flag_if_homed()
            return machine.confirm_command(command, (self._job, self._line, flags, self._position[: self._axes]))
        if machine.state not in ("idle", "alarm") or not self._queue.still():
            return errors.BUSY
        if not command.target:
            if self._counted is None:
                self._job = self._line = self._astray = 0
                self._flags = DONE | self._flag_if_homed()
                self._sample_position()
                self._write_record()
            return machine.confirm_command(command)
        self._retired = self._queue.blocks_played()
        self._broken = self._moving = False
        self._line = self._done = 0
        self._sample_position()
        self._begin_job(command.target)
        self._flags |= self._flag_if_homed()
        if self._left < self._half:
            while self._erase_next():
                pass
        self._write_record()
        return machine.confirm_command(command)

    def _begin_job(self, job):
        """Begin a job: its number, or (number, line, flags, lead, position) of one that is counted."""
        number, line, flags, lead, position = job if isinstance(job, tuple) else (job, 0, DONE, 0, None)
        self._job = number
        self._flags = self._astray = 0
        counted = self._counted
        if counted is None:
            return
        self._line = line
        self._flags = flags & ~HOMED
        self._lead = lead
        self._back = bool(flags & BACK)
        self._times = flags >> _TIMES
        self._done = line if flags & DONE else max(line - 1, 0)
        if position is not None:
            self._position[: len(position)] = position
        counted.counted = self._done - lead
        counted.announced = True
        counted.kept = not self._machine.alarm
        counted.counting = False

    def _flag_if_homed(self):
        """Return HOMED if the position is known, else 0."""
        return HOMED if not self._astray and self._machine.homed or self._counted and self._counted.kept else 0

    # --- what is known: of lines of the job alone, which are those with a number

    def _is_counting(self):
        """Return True if queued blocks may be of the job: lines with a number, or an announced job of commands or points."""
        return self._counted is None or self._counted.counting

    def _is_walking(self):
        """Return True if a step program plays."""
        return self._counted is not None and self._counted.write_progress is not None

    def poll(self, now_ms):
        """Write records while a job runs, as often as every_ms, and at each stand; erase a block after REST_MS at rest."""
        machine = self._machine
        still = self._queue.still()
        if not still:
            self._rest_ms = now_ms
        elif self._left < self._half:
            machine.awake = True
            if now_ms - self._rest_ms & COUNT_MASK >= REST_MS:
                self._rest_ms = now_ms
                self._erase_next()
        if not self._job or not self._is_counting():
            return
        if self._is_walking():
            if still or self._is_due(now_ms):
                self._write_spot()
            return
        if not still:
            self._sample_line(now_ms)
            return
        retired = self._queue.blocks_played()
        if self._broken:
            self._broken = False
        elif retired != self._retired:
            self._note_stand(min((retired - self._retired) & COUNT_MASK, _WAITS))
        self._retired = retired
        self._moving = False
        if self._late:
            machine.awake = True
            if self._is_due(now_ms):
                self._late = False
                self._write_record()

    def _sample_line(self, now_ms):
        """Take the line under way and the position; write them if a record is due."""
        if self._machine.away:  # the journal keeps where the path was left
            return
        queue = self._queue
        planner = queue.planner
        queue.retire()
        at = planner.row()
        if at < 0 or planner.rows[at + ROW_TAG] <= self._done:
            return
        line = planner.rows[at + ROW_TAG]
        found = list(queue.position_view())
        queue.retire()
        if at != planner.row():  # another block has begun meanwhile
            return
        self._moving = True
        self._late = False
        self._line = line
        self._position[: self._axes] = found
        self._flags = self._flag_if_homed()
        if self._is_due(now_ms):
            self._write_record()

    def _sample_position(self):
        """Take the position, in steps."""
        self._position[: self._axes] = list(self._queue.position_view())

    def _note_stand(self, count):
        """Note that `count` blocks have been played to a stand: if the last that moved is of the job, its line is done."""
        planner = self._queue.planner
        line = 0
        for back in range(count):
            at = planner.last(back)
            line = planner.rows[at + ROW_TAG]
            if line or planner.rows[at + ROW_KIND] != KIND_WAIT:
                break
        if line <= self._done:
            return
        self._line = line
        self._flags = DONE | self._flag_if_homed()
        self._sample_position()
        if self._left < self._half:
            self._late = True
        else:
            self._write_record()

    def halt(self):
        """Write where the job is: the pins have stopped amid a word, and the queue is dropped next."""
        self._broken = True
        if not self._job or not self._is_counting():
            return
        planner = self._queue.planner
        at = planner.row()
        if at >= 0 and planner.rows[at + ROW_TAG] > self._done:
            self._line = planner.rows[at + ROW_TAG]
            self._flags &= ~DONE
            if not self._machine.away:
                self._sample_position()
            self._write_record()
        if self._is_walking():
            self._write_spot()

    def on_events(self, _):
        """Write the line under way: the commands behind a stand are dropped."""
        if self._moving:
            self._write_record()
        self._broken = True

    def _write_spot(self):
        """Write where the step program is."""
        spot = self._spot
        if not self._counted.write_progress(spot):
            return
        count = max(spot[SPOT_INDEX] - self._lead, 0)
        self._line = self._done - count if self._back else self._done + count
        back = self._back != bool(spot[SPOT_BACK])
        self._flags = DONE | self._flag_if_homed() | (BACK if back else 0) | (self._times or spot[SPOT_TIMES]) << _TIMES
        for axis in range(self._axes):
            self._position[axis] = spot[SPOT_AXES + axis]
        self._write_record()

    def _is_due(self, now_ms):
        """Return True if another record is due: rarer, the fewer slots are left before the next erase."""
        interval = self._every_ms
        share = self._half
        while self._left < share and share > 4:
            interval *= 2
            share //= 2
        if self._block < 0 or now_ms - self._written_ms & COUNT_MASK < interval:
            return False
        self._written_ms = now_ms
        return True

    # --- flash

    def _write_record(self):
        """Write a record to the next erased slot, if anything has changed. 0.7 ms, up to 3, without interrupts."""
        now = self._flags, self._job, self._line, list(self._position)
        if now == self._written or self._block < 0:
            return
        port = self._machine.port
        port.writing(True)
        self._pages.write(self._block, self._slot, pack_record(self._sequence, *now))
        port.writing(False)
        self._sequence = self._sequence + 1 & 0xFFFF
        self._written = now
        self._newest = self._block
        self._empty[self._block] -= 1
        self._left -= 1
        self._slot += 1
        self._next_free()

    def _erase_next(self):
        """Erase the next block behind the newest record that is not erased, in 45 to 400 ms. Returns whether there was one."""
        pages = self._pages
        for ahead in range(1, pages.BLOCKS):
            block = (self._newest + ahead) % pages.BLOCKS
            if self._empty[block] < pages.SLOTS:
                port = self._machine.port
                port.writing(True)
                try:
                    pages.erase_block(block)
                except (OSError, MemoryError):  # there is no room: with the next start it is tried again
                    self._half = 0
                    self._machine.note(errors.MEMORY)
                    return False
                finally:
                    port.writing(False)
                self._left += pages.SLOTS - self._empty[block]
                self._empty[block] = pages.SLOTS
                if self._block < 0:
                    self._block, self._slot = block, 0
                return True
        return False
