"""Plays a black box on the virtual board: the same bytes from a snapshot on, and stops where the machine stopped.

    replay = Replay(box, settings=(slot, slot))     # of blackbox.read(); the two slots of the board's settings, b"" for none
    replay.run()
    replay.path                                     # [position], each step from the snapshot on
    replay.rows, replay.events                      # (ms, *position, tool) of each step; (ms, text)
    replay.faults                                   # differences from the board

Steps depend on the bytes alone, ticks on their timing too. So the replay lets time pass as on the board, except at stops: there it plays on until
the position, and the block, at which the board stopped, to the step, freezes, and only then lets the cause happen: an input, a real-time byte, the
slowing down of a hold. Stops without a byte or an input (an encoder, an inverter, a host that is silent for longer than the machine plays) become
an alarm by their number.
"""

from passo import commands, errors
from passo.config.journal import MemorySlots
from passo.options.blackbox.language_grbl import FAST
from passo.ports.virtual import MemoryLine
from passo.ports.virtual_player import Player
from passo.protocols.gcode.parse_records import LINES_AT, LINES_END, PARSE_FEED, PARSE_MODAL, PARSE_POSITION
from passo.records import TICKS_PER_MS

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs.blackbox import ALARM, DROPPED, HALTED, HOMED, INPUTS, LOGGED, ORDER, PLACES, SAMPLE, STOOD, STOPS
from host_tools.programs.timeline import mm_text
from host_tools.sim.machine import Machine
from host_tools.sim.plant import Plant

_ALARMS = 200
_CAUSE_MS = 200  # before a stop, in which an input may have brought it about
_PATIENCE_MS = 3000  # at a stop, until its alarm is raised by number
_LONGEST_MS = 60_000  # longer than the box lasts
_REAL_TIME = {commands.HOLD: b"!", commands.RESUME: b"~", commands.DOOR: b"\x84", commands.JOG_CANCEL: b"\x85", commands.RESET: b"\x18"}
_STOPPING = commands.RESET, commands.STOP
_LAST_MS = 300
_ASK_MS = 250
_LOST = errors.HOST_LOST, errors.ALARM_HOST_LOST
_FAR = 1 << 40  # no hard end


class Witness(Plant):
    """A plant without hard ends, whose inputs are as the box has them."""

    def __init__(self, board, levels):
        Plant.__init__(self, board)
        self._given = {name: self._active_level(name) if active else 1 - self._active_level(name) for name, active in levels.items()}
        for carriage in self.carriages + ([self.second] if self.second else []):
            carriage.low, carriage.high = -_FAR, _FAR

    def input(self, tick, name):
        return self._given.get(name, 1 - self._active_level(name))

    def give_input(self, tick, name, active):
        """Set an input to its active or inactive level at `tick`; the firmware sees it at once."""
        level = self._active_level(name) if active else 1 - self._active_level(name)
        if level != self._given.get(name):
            self._given[name] = self._levels[name] = level
            Plant._report_input(self, tick, name)

    def _report_input(self, tick, name):
        """Ignore a change of the plant's own sensors: the box has the inputs."""


class FreezingPlayer(Player):
    """Stops at a word, when `due()` says so, until it is thawed."""

    due = None
    frozen = False

    def start(self):
        if not self.frozen:
            Player.start(self)

    def busy(self):
        return not self.frozen and Player.busy(self)

    def run(self, until):
        """Play word by word up to tick `until`; ask `due` after each, and freeze if it says so."""
        while self.now < until:
            plays = self._playing and not self.frozen and self._played != self._ring.head
            Player.run(self, min(until, max(self._next, self.now) + 1) if plays else until)
            if not self.frozen and self.due is not None and self.due():
                self.frozen = True
                Player.halt(self)


class Replay(Machine):
    def __init__(self, box, settings=(b"", b""), trace=True):
        self.box = box
        self.snapshot = snapshot = box.start()
        if snapshot is None:
            raise Failure("the box has no place where a replay may begin: too little is left of what came before")
        self.since = box.rows_since(snapshot)
        if box.table.get("parking") and any(row.kind == ORDER and row.value == commands.DOOR or row.levels and row.levels.get("door") for row in self.since):
            raise Failure("the machine has parked: its ways up and back are not replayed")
        self.stops = [row for row in self.since if row.kind in STOPS]
        self.faults, self.events = [], []
        slots = MemorySlots()
        slots.data = list(settings)
        before = [row for row in box.rows if row not in self.since and row.levels is not None]
        levels = (before or [row for row in self.since if row.levels is not None])[-1 if before else 0 :]
        self.lines = {link["name"]: MemoryLine() for link in box.board["links"]}
        self._plant_of = lambda board: Witness(board, levels[0].levels if levels else {})
        Machine.__init__(self, box.table, self.lines, "stepped", trace=trace, slots=slots, plant=self._plant_of, player=FreezingPlayer)
        self._app, self._record = self.app, self.app.controller.machine
        self._queue, self._feeder = self.app.controller.queue, self.app.feeder
        self._link = self.app.links[self._record.commander]
        self._name = box.board["links"][self._record.commander]["name"]
        self._player = self.port._player
        self._held = self._aborts = False
        self._log = hasattr(self._link.protocol, "sources")  # its text are lines
        self._asks = self._log and any(row.value in _LOST for row in self.since if row.kind == LOGGED)  # the host did
        self._asked_ms = 0
        self._waits_ms = None
        self._clock_ms = 0  # ms of the board − ms here
        self._delivered = snapshot.taken
        self._plays = getattr(self._feeder.planner, "_plays", None)  # of a machine with backlash, steps; as much is taken up at the beginning
        self._taken = [0] * len(snapshot.position)
        self._watch_stops()
        self._restore_state(snapshot)
        self._clock_ms = snapshot.ms - self.now_ms()
        self._zero = [here - there for here, there in zip(self.plant.position, snapshot.position)]
        self._first_row = len(self.trace._rows) if self.trace else 0

    # --- where the board stood

    def _restore_state(self, snapshot):
        """Set the board to the snapshot: position, backlash, homed, alarm and the modal state. A snapshot of the start changes nothing."""
        if snapshot.rows == 0 and snapshot.taken == 0 and snapshot.added == 0:
            return  # the board had just started, as this one
        self.cycle()
        record, queue = self._record, self._queue
        if self._plays:
            self._taken = snapshot.backlash_taken
            for axis, taken in enumerate(self._taken):
                self._feeder.planner._taken[axis] = taken
        for axis, there in enumerate(snapshot.position):
            queue._origin[axis] += queue.position_view()[axis] - there
        queue.lead(snapshot.position)
        record.guarded = 0
        record.homed = bool(snapshot.flags & HOMED)
        if not snapshot.flags & ALARM:
            record.alarm = 0
        elif not record.alarm:
            record.alarm = errors.ALARM_LOCKED
        gcode = getattr(self._link.protocol, "gcode", None)
        if gcode:
            self._restore_gcode(gcode, snapshot)

    def _restore_gcode(self, gcode, snapshot):
        """Set the parser's modal state, position and offsets from the snapshot's words; plain lines that followed have newer ones of the fast
        parser."""
        gcode.leave_batch()
        fast, slow = snapshot.modal[:FAST], snapshot.modal[FAST:]
        axes = gcode.axes
        gcode.motion, gcode.number, gcode.tool, gcode.plane, gcode.coolant, modes = slow[:6]
        gcode.spindle, gcode.system = modes >> 6 & 7, modes >> 9
        gcode.inches, gcode.absolute, gcode.per_minute, gcode.initial = (bool(modes & bit) for bit in (1, 2, 4, 8))
        long = [low | high << 30 for low, high in zip(slow[6::2], slow[7::2])]
        gcode.feed, gcode.rpm = long[:2]
        gcode.position[:axes] = long[2 : 2 + axes]
        gcode.cycle = (modes >> 4 & 3, *long[6:11])
        gcode.offsets.shift = long[11 : 11 + axes]
        gcode.offsets.tool = long[15]
        gcode.offsets.version += 1
        if fast[0] & 1:  # plain lines have gone on from there
            gcode.motion = fast[1] * 100
            gcode.feed, gcode.number, gcode.rpm = fast[1 + PARSE_FEED - PARSE_MODAL], fast[FAST - 2], fast[FAST - 1]
            first = 1 + PARSE_POSITION - PARSE_MODAL
            named = min(3 if gcode.turns else axes, axes)
            gcode.position[:named] = fast[first : first + named]
        gcode._steps = list(snapshot.position[:axes])

    # --- stops

    def _watch_stops(self):
        """Replace the firmware's halt, drop and hold by functions that compare each stop with the record."""
        queue, feeder, machine = self._queue, self._feeder, self._record
        halt, drop, hold, standing = queue.halt, queue.drop, feeder.set_hold, feeder.standing

        def note_halt():
            self._aborts = True
            halt()

        def note_drop():
            """Drop the queue, then compare the stop with the record."""
            drop()
            self._held = False
            self._pass_stop(HALTED if self._aborts else DROPPED)
            self._aborts = False

        def note_hold(on):
            """Hold or go on. While stops are ahead, a hold waits for the recorded one."""
            if self.stops and on:
                self._held = True
                return
            hold(on)
            if not on and self._held and self.stops and self.stops[0].kind == STOOD and self._player.frozen:
                self._pass_stop(STOOD)
            self._held = False

        queue.halt, queue.drop, feeder.set_hold = note_halt, note_drop, note_hold
        feeder.standing = lambda: self._player.frozen if self._held else standing()
        self._player.due = self._must_freeze

    def _must_freeze(self):
        """Return True if position and blocks played are those of the next recorded stop."""
        if not self.stops:
            return False
        row = self.stops[0]
        if list(self._queue.position_view()) != row.position:
            return False
        self._feeder.retire(self._player.words_played())
        return self._queue.blocks_played() >= row.value - self._count_offset()

    def _count_offset(self):
        """Return how many blocks the board had counted before those that are played here."""
        return self.snapshot.added if self._same_count else 0

    _same_count = True  # no stop has emptied the queue yet

    def _pass_stop(self, kind):
        """Drop the recorded stops up to the next one of this kind, and report a fault if it was elsewhere. Called when the firmware stops, or goes
        on."""
        while self.stops:
            row = self.stops.pop(0)
            if kind != STOOD:
                self._same_count = False
            if row.kind == kind:
                here = list(self._queue.position_view())
                if here != row.position:
                    self._add_fault(_("stopped at {}, the board at {}", mm_text(self.box.board, here), mm_text(self.box.board, row.position)))
                break
        self._player.frozen = False

    def _add_fault(self, text):
        self.faults.append((self.now_ms() + self._clock_ms, text))

    # --- time

    def run(self):
        """Play the record from the snapshot to its end; `faults` lists the differences."""
        rows = self.since
        at = 0
        limit = self.now_ms() + self.box.end_ms - self.snapshot.ms + _LONGEST_MS
        self._player.frozen = self._must_freeze()
        while True:
            while at < len(rows) and self._is_due(rows, at):
                self._carry_out(rows[at])
                at += 1
            self._deliver_lines(rows, at)
            ended = at == len(rows) and self._delivered >= self.box.base + len(self.box.text)
            if ended and self._player.frozen:
                self._force_alarm(rows)
            if self.box.why == "end" and at == len(rows) and not self.stops:
                break  # there the app ended
            if ended and not self.stops and not self.port.pending(self.app.controller.busy()):
                break
            if self.now_ms() > limit:
                self._add_fault(_("did not come to its end"))
                break
            if self.stops and not self._player.frozen and ended and not self.port.pending(self.app.controller.busy()):
                self._add_fault(_("never came to {}, where the board stopped", mm_text(self.box.board, self.stops[0].position)))
                break
            if not ended and self._asks and self.now_ms() >= self._asked_ms + _ASK_MS:
                self._asked_ms = self.now_ms()
                self.lines[self._name].incoming += b"?"
            before = self._record.log.count
            state = self._record.state
            self.cycle()
            self._note_events(state, before)
        self.port.advance(TICKS_PER_MS * _LAST_MS)
        if not self.faults:
            self._check_samples()
        return self

    def _check_samples(self):
        """Report a fault unless the path leads through all positions that the board has noted, in their order."""
        path, at, stopped = self.path, 0, False
        for row in self.since:
            stopped = stopped or row.kind in (HALTED, DROPPED)
            if row.kind != SAMPLE or not stopped and row.value < self.snapshot.added:
                continue
            while at < len(path) and path[at] != row.position:
                at += 1
            if at == len(path):
                self.faults.append((row.ms, _("never came to {}, where the board was", mm_text(self.box.board, row.position))))
                return

    def _is_due(self, rows, at):
        """True if a row's time has come. The cause of a stop comes when the machine stands where the board stood."""
        row = rows[at]
        if row.kind in PLACES or row.kind == LOGGED:
            return row.ms <= self._board_ms() or self._player.frozen
        if self._log and self._delivered < row.come and not self._deliver_until(row.come):
            return False
        stop = self._stop_by(rows, at)
        if stop is not None:
            return self._player.frozen and self.stops[0].position == stop.position  # it may have stood there in a hold
        return row.ms <= self._board_ms()

    def _board_ms(self):
        return self.now_ms() + self._clock_ms

    def _stop_by(self, rows, at):
        """Return the stop ahead that row `at` may have caused: an order to stop right before it, or an input shortly before it. None if there is
        none."""
        if rows[at].kind == ORDER and rows[at].value not in _STOPPING:
            return None
        for row in rows[at + 1 :]:
            if row.kind in STOPS:
                near = rows[at].kind == ORDER or row.ms - rows[at].ms <= _CAUSE_MS
                return row if row.kind == HALTED and near and row in self.stops else None
            if row.kind == ORDER:
                return None
        return None

    def _carry_out(self, row):
        """Carry out a recorded change of inputs, or a recorded order as its real-time byte or directly."""
        self._clock_ms = min(self._clock_ms, row.ms - self.now_ms()) if row.kind in (INPUTS, ORDER) else self._clock_ms
        if row.kind == INPUTS:
            for name, active in row.levels.items():
                self.plant.give_input(self.port.now, name, active)
        elif row.kind == ORDER:
            if row.value in _REAL_TIME:
                self.lines[self._name].incoming += _REAL_TIME[row.value]
            else:
                self._record.carry_out(row.value)

    def _deliver_lines(self, rows, at):
        """Deliver the lines that had come by now."""
        come = self.snapshot.taken
        ms = self.snapshot.ms
        end = self.box.base + len(self.box.text)
        for row in rows:
            if row.kind == HALTED and row in self.stops and not self._log and not self._player.frozen:
                end = come  # one of the bytes has stopped it
                break
            if row.ms >= self._board_ms():
                share = (self._board_ms() - ms) / max(row.ms - ms, 1)
                end = come + int(share * (row.come - come))
                break
            come, ms = max(come, row.come), row.ms
        if at < len(rows):
            end = min(end, rows[at].come)
        self._deliver_until(end)

    def _deliver_until(self, end):
        """Deliver the bytes before `end`, by whole lines, as far as there is room. Returns True if all are delivered."""
        line = self.lines[self._name]
        while self._delivered < end:
            text = self.box.bytes_from(self._delivered)
            size = text.find(b"\n") + 1 or len(text) if self._log else end - self._delivered
            if line.incoming or self._link_space() < size:
                return False
            line.incoming += text[:size]
            self._delivered += size
        return not line.incoming

    def _link_space(self):
        """Return how many bytes the link keeps beside those that wait."""
        protocol = self._link.protocol
        return 512 - (protocol._lines.fields[LINES_END] - protocol._lines.fields[LINES_AT]) if self._log else len(self.box.text)

    def _force_alarm(self, rows):
        """Raise the recorded alarm, by its number, if all bytes have come and nothing stops the machine."""
        if self._waits_ms is None:
            self._waits_ms = self.now_ms()
        if self.now_ms() - self._waits_ms < _PATIENCE_MS:
            return
        self._waits_ms = None
        stop = self.stops[0]
        numbers = [row.value for row in rows[rows.index(stop) :] if row.kind == LOGGED and row.value > _ALARMS]
        if stop.kind == STOOD:
            self._pass_stop(STOOD)
        elif numbers:
            self._record.raise_alarm(numbers[0])
        else:
            self._record.abort()

    # --- what is seen

    def _note_events(self, state, logged):
        """Add a changed state, and a new entry of the log, to `events` with the board's ms."""
        record = self._record
        if record.state != state:
            self.events.append((self._board_ms(), record.state))
        if record.log.count != logged:
            self.events.append((self._board_ms(), str(record.log.newest()[1])))

    @property
    def rows(self):
        """Rows (ms of the board, *position, tool) of each step; the axes' position, also of motors with backlash."""
        found = []
        taken, before = list(self._taken), self.snapshot.position
        for tick, *place in self.trace._rows[self._first_row :]:
            motors = [at - by for at, by in zip(place, self._zero)]
            if self._plays:
                taken = [max(0, min(play, there + at - was)) for play, there, at, was in zip(self._plays, taken, motors, before)]
            before = motors
            axes = [at - there + begun for at, there, begun in zip(motors, taken, self._taken)]
            found.append((tick / TICKS_PER_MS + self._clock_ms, *axes, place[-1]))
        return found

    @property
    def path(self):
        """The position behind each step, from the snapshot on, without steps that change nothing."""
        path = [list(self.snapshot.position)]
        for _, *place in self.rows:
            if list(place[: len(self._zero)]) != path[-1]:
                path.append(list(place[: len(self._zero)]))
        return path
