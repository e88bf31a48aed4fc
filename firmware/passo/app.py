"""The composition root: builds the machine of a board file on a port, and runs its main loop.

    app = App(BOARD, port)
    while True:
        app.cycle()

Bytes from each link become commands, commands become motion, events become the bytes of answers. The only module that
knows every room.
"""

import micropython
from micropython import const

from passo import errors
from passo.commands import ACCEPTED, ALARM, DROPPED, JOG, RESTARTED, STATUS, Event
from passo.config.journal import Journal, MemorySlots
from passo.config.setting_numbers import ENABLE_INVERT
from passo.config.settings import Settings
from passo.control.links import HARMLESS, NEVER_WAITS, RIGHTS
from passo.control.motors import Motors
from passo.errors import LATER
from passo.records import COUNT_MASK, LEAD_TICKS, QUEUE_ADDED, QUEUE_RETIRED, TICKS_PER_MS, TICKS_PER_S
from passo.steps.ring import Ring, power_room, ring_size
from passo.steps.word import us_to_ticks

LIVE_TICKS = const(12 * 12_500)  # ahead while what is under way may change at any moment: on the pins within 20 ms; a cycle, two segments
_CALLS_S = const(200)  # half a ring of words has to last as long as such a call of the feeder
_WAITING = const(64)  # commands of one link that may wait for their turn
_READS = const(64)  # enough to empty a serial line: some give 64 bytes at a time
_LOOK_MS = const(12)  # while bytes keep coming, the machine is polled at least so often
_SEVERAL = const(6)  # lines at a time on a chip, where they take time
_ALL = const(0x1FFFFFFF)
_FULL = const(128)  # bytes of a read that left some in the line's buffer
_MORE = const(8)  # such reads a cycle: the whole buffer
_PART = const(1)  # heard: bytes
_WHOLE = const(2)  # and commands
_LINES = const(4)  # of a batch
_KEPT = const(8)  # lines that _heed() has kept: the next cycle begins without a sleep
_REPLY_MS = const(3)  # a PC takes this long, most of them one, to send more when lines have been answered


class Link:
    """One serial line: its protocol, and the commands that wait for their turn."""

    def __init__(self, number, config, serial, protocol, controller):
        self.number = number  # in the board file, from 0
        self.name = config["name"]
        self.serial = serial
        self.protocol = protocol
        self.batch = getattr(protocol, "batch", None)  # for frequent motion, if the language has one
        if self.batch:
            self.take_batch = protocol.take_batch
            self.batch.join(*controller.batches(self.batch))
        self._log = controller.machine.note
        self.buffer_input = getattr(protocol, "buffer_input", None)  # keeps lines, and has real-time bytes carried out before these
        self.heard = False  # bytes have come, see was_heard()
        self.keeps = getattr(protocol, "keeps", False)  # it keeps bytes itself: it may fill batches while commands wait
        self.waiting = []

    def was_heard(self):
        """Return True if bytes have come since the last call."""
        heard = self.heard
        self.heard = False
        return heard

    def add(self, command):
        """Let a command wait behind others. Returns False if _WAITING do, or if it would be a jog behind a jog."""
        waiting = self.waiting
        if len(waiting) >= _WAITING or command.kind == JOG and waiting[-1].kind == JOG:
            return False
        waiting.append(command)
        return True

    def note(self, number):
        """Add to the log, in this link's name."""
        self._log(number, self.name)


class App:
    def __init__(self, board, port, protocols=None, slots=None):
        """`board` is checked. `protocols` may name another protocol for a link: {link name: protocol}; `slots`: where the
        settings are kept, None: nowhere. Raises BoardError."""
        from passo import machine_builder  # here: nothing else needs it

        self.board = board
        for link in board["links"]:
            link["protocol"] = (protocols or {}).get(link["name"], link["protocol"])
        self.port = port
        self.layout, self._drive, off_levels = machine_builder.make_drive(board)
        languages = machine_builder.languages(board)
        names = machine_builder.feature_names(board, languages)
        self.planner = machine_builder.planner(board, self.layout.axes, "program" in names)  # first: it takes the largest pieces of memory
        settings = Settings(board, Journal(slots or MemorySlots()), machine_builder.more_settings(languages), getattr(port, "writing", None))
        self.ring = Ring(ring_size(machine_builder.fastest(board, settings), getattr(port, "lead_ticks", LEAD_TICKS)), *power_room(board))
        self.player = port.player(self.ring, self.layout, board)  # whose pins follow the settings
        inverted = bool(settings.mask_change(ENABLE_INVERT)) and getattr(port, "veto", None) is None  # which knows the board file's only
        self._motors = Motors(port, self.player, self.layout, None if self.layout.kind == "step_dir" else self._drive, off_levels, board, inverted)
        own, queue = machine_builder.lines_of(board), self._make_queue(machine_builder, settings, "program" in names)
        serials = machine_builder.serials(own, board, port)
        guarded = machine_builder.guard_mask(board, languages, settings)
        self._make_controller(settings, queue, guarded, machine_builder.load(names, board, languages))
        self._looked_ms = port.machine_ms()
        self._heard = 0  # by this cycle: _PART, _WHOLE, _LINES, _KEPT
        self._answered_ms = -1  # lines of a batch were answered while the machine moved, and it has not been polled since; −1: none
        self._now_ms = port.link_ms()
        self._speaking = None  # the link whose bytes are being understood
        self._overruled = 0  # the error that ends the rest of them: another link, or an alarm, has stopped the machine
        self.links = []
        shared = {}  # the objects that links of one language share
        most = _SEVERAL if self.interrupt else _ALL
        self._make_links(machine_builder, languages, serials, own, shared, most)
        self._prepare_links()  # before the buffers for links of files
        self.add_file_links(languages, shared, most)
        self.controller.machine.announce_restart()
        self._send_events()

    def _make_links(self, builder, languages, serials, own, shared, most):
        """Make a Link for each link of the board file: its protocol, frames if it has them, and the watch over the host."""
        for number, (config, language, serial) in enumerate(zip(self.board["links"], languages, serials)):
            protocol = builder.speaker(own, language, config, number, self.board, self.controller, shared, most)
            made = Link(number, config, serial, protocol, self.controller)
            if config["frames"]:
                baud = 1_000_000 if config["port"] == "usb" else config["baud"]  # at least
                made.serial = builder.frame_line_class()(made, serial, baud, self.port.link_ms, made.note)
            if config["lost"] != "go_on":
                self.controller.features["host_watch"].watch(number, made.serial if config["frames"] else made)
            self.links.append(made)
        if own:
            own.join(self.links, self.controller)

    def _prepare_links(self):
        """Make now what links make when they are used first, as far as memory lasts."""
        for link in self.links:
            link.serial = self.controller.features["links"].join(link)
            try:
                getattr(link.protocol, "prepare", int)()
            except MemoryError:
                return

    def add_file_links(self, *made):
        """Add the links that features bring, whose bytes come from a file. `made`: languages, shared objects, and lines at a time of the others."""
        for name, language in getattr(self.board.get("additions"), "file_links", ()):
            self._add_link(self.controller.features[name], language, *made)

    def _add_link(self, feature, language, languages, shared, most):
        """A link that a feature brings: it speaks as the first one of its language."""
        index, number = [link["protocol"] for link in self.board["links"]].index(language), len(self.links)
        config = dict(self.board["links"][index], name=self.controller.machine.links[number])
        protocol = languages[index].create(config, number, self.board, self.controller, shared, most)
        self.links.append(Link(number, config, feature.join(number, protocol), protocol, self.controller))
        self._prepare_links()

    def _make_queue(self, builder, settings, streamed):
        """Feeder and queue. `streamed`: as machine_builder.queue() has it."""
        board = self.board
        Queue = builder.queue(board, streamed)
        from passo.steps.feeder import Feeder

        least = self.player.min_word_ticks
        builder.check_speed(board, least)
        settings.limit_steps(min(TICKS_PER_S // (2 * least), self.ring.size * _CALLS_S // 2))
        setup = us_to_ticks(board["drive"]["setup_us"]) if self.layout.kind == "step_dir" else 0
        short = 2 * TICKS_PER_MS if hasattr(self.port, "lead_ticks") else 0  # on a chip, whose interrupt makes words in time
        self.feeder = Feeder(self.ring, self.layout, self.planner, self._drive, setup and max(setup, least), least, builder.burner(board), short)
        self.interrupt = self.port.feed_from_interrupt(self.feeder, self.player)
        self._motors.release()
        return Queue(board, self.planner, self.feeder, self.player, self.port)

    def _make_controller(self, settings, queue, guarded, kinds):
        from passo.control.controller import Controller
        from passo.control.state import MachineState

        machine = MachineState(self.board, settings, queue, self._motors, self.port, guarded)
        self.controller = Controller(self.board, machine, queue, self.feeder, kinds)

    def poll(self):
        """Links, then machine, then answers, then words for the player. False if the machine has to wait, because
        more bytes are coming, or will at once: where interrupts play, those are taken first."""
        heard = self._read_links()
        if self.interrupt and (heard or self._answered_ms >= 0) and self._must_read_on(heard):
            return False
        self._answered_ms = -1
        if self.interrupt:
            self._read_early()
        tripped = self.port.halting_input()
        if tripped and not self.controller.machine.alarm:
            self.controller.handle_stop(tripped)
        machine = self.controller.machine
        self.controller.poll()
        if machine.events:
            self._send_events()
        if self.interrupt:
            self._read_early()  # so that `?` waits half as long
        if machine.awake or self.feeder.open:
            self._make_words()
        return True

    # In small pieces: a function of more than eleven words of variables and stack takes them off the heap, longer than a call.

    @micropython.native
    def _read_links(self):
        """Carry out what the links bring. Returns _PART if bytes came, _WHOLE if more than questions did, _LINES if it were lines."""
        self._heard = 0
        self._now_ms = self.port.link_ms()
        for link in self.links:
            self._speaking = link
            self._overruled = 0
            if link.waiting:
                self._go_on(link)
            data = link.serial.read()
            if data:
                self._heard |= _PART
                link.heard = True
            elif link.keeps and not link.protocol.pending():
                continue
            commands = b""
            if link.batch and (link.keeps or data and not link.waiting):
                commands = self._in_batches(link, data)
                data = b""
            if not commands:
                commands = link.protocol.feed(data, self._now_ms)  # an iterable: each is to be answered before the next is asked for
                if not data and self.interrupt and link.buffer_input and not isinstance(commands, tuple):
                    commands = self._carry_out_between(commands, link)  # a chip takes milliseconds to read each line
            if commands:
                self._carry_out(commands, link)
        self._speaking = None
        return self._heard

    def _read_early(self):
        """Read the links before the controller's turn, so that `?` does not wait for it. While the machine moves, carry out real-time
        bytes and keep lines. At a stand carry out all, as _hear(), so that a line sets out sooner."""
        for link in self.links:
            if link.buffer_input and link.serial.any():
                if not self.feeder.open:
                    self._read_links()
                    break
                self._overruled = 0
                self._take_early(link)

    def _take_early(self, link):
        """Carry out the real-time bytes that `link` has brought, and keep its lines."""
        link.heard = True
        self._heard |= _KEPT
        speaking = self._speaking
        self._speaking = link
        self._carry_out(link.buffer_input(link.serial.read()), link)
        self._speaking = speaking

    def _has_bytes(self):
        for link in self.links:
            if link.serial.any():
                return True
        return False

    def _must_read_on(self, heard):
        """True while more bytes are coming, or a PC may be about to send them, and the machine may wait for them. The motion asked for begins at once."""
        now_ms = self.port.machine_ms()
        moves = self.feeder.open
        coming = heard == _PART or not (heard & _LINES and moves) and self._has_bytes()
        if heard & _WHOLE:
            if not coming:
                self.controller.queue.begin()
            if not moves:
                self._make_words()
            elif heard & _LINES:
                self._answered_ms = now_ms
        if not coming and (self._answered_ms < 0 or (now_ms - self._answered_ms) & COUNT_MASK >= _REPLY_MS):
            return False
        return (now_ms - self._looked_ms) & COUNT_MASK < _LOOK_MS

    @micropython.native
    def _make_words(self):
        """Make words for the player, if there is something to play and the motors are ready."""
        feeder = self.feeder
        indices = self.planner.indices
        opens = indices[QUEUE_ADDED] != indices[QUEUE_RETIRED]
        if opens:
            for ready in self.controller.readies:
                if not ready():
                    opens = False
                    break
        feeder.open = opens
        if not opens:
            return
        live = bool(self.controller.lives) and self.controller.may_change()
        if self.interrupt:
            self.port.set_out(live)
            return
        feeder.fill(self.player.words_played(), LIVE_TICKS if live else LEAD_TICKS)
        self.player.start()

    def cycle(self):
        """poll(), then let time pass."""
        if self.poll():
            self.rest()

    def rest(self):
        """The end of a cycle."""
        machine = self.controller.machine
        self.port.wait(machine.awake and self.controller.busy(), machine.command is not None and machine.fine(), self._heard & _KEPT > 0)
        self._looked_ms = self.port.machine_ms()

    def _go_on(self, link):
        """Commands that wait come first."""
        while link.waiting and self.controller.accept(link.waiting[0]) != LATER:
            link.waiting.pop(0)
            self._send_events()
            self._heard |= _WHOLE

    def _carry_out_between(self, commands, link):
        """Carry out the real-time bytes of `link` before, between and behind `commands`."""
        if link.serial.any():
            self._take_early(link)
        for command in commands:
            yield command
            if link.serial.any():
                self._take_early(link)

    @micropython.native
    def _carry_out(self, commands, link):
        """Begin each command: hand it to the controller, or let it wait behind those of its link. STATUS is answered at once. Refuses a command as
        TOO_MANY_WAITING if _WAITING wait."""
        for command in commands:
            command.link = link
            kind = command.kind
            if kind == STATUS:
                self._tell_status(command)
                continue
            if self._overruled and not RIGHTS.get(kind, 0) & HARMLESS:
                self.controller.refuse(command, self._overruled)
            else:
                self._heard |= _WHOLE
                if RIGHTS.get(kind, 0) & NEVER_WAITS or not link.waiting:
                    if self.controller.accept(command) == LATER:
                        link.waiting.append(command)
                elif not link.add(command):
                    self.controller.refuse(command, errors.TOO_MANY_WAITING)
            self._send_events()

    def _tell_status(self, command):
        """Answer a question for the status directly: as an event the answer would take three calls more."""
        link = command.link
        if self.interrupt:
            self.port.put_off()
        answer = command.reply or Event(ACCEPTED, command)
        answer.value = self.controller.machine.report(link)
        answer = link.protocol.reply(answer)
        if answer:
            link.serial.write(answer)
        if self.interrupt:
            self.port.catch_up()

    @micropython.native
    def _in_batches(self, link, data):
        """Carry out in batches what comes most often in `data`, and in what comes while that is done: as long as there are
        answers, and the machine may wait. Returns commands that have to be carried out before anything else, or b""."""
        take_batch = link.take_batch
        serial = link.serial
        now_ms = self._now_ms
        batch = link.batch
        more = _MORE
        while True:
            answers = take_batch(data, now_ms)
            if not answers:  # this many reads at most: a serial line that is not read in time loses bytes
                if not more or len(data) < _FULL and not (link.buffer_input and self.interrupt and serial.any()):
                    break
                more -= 1
            elif isinstance(answers, bytes):
                if batch.moves and not self.feeder.open and self.interrupt and not serial.any():
                    self._set_off(link)
                serial.write(answers)
                if not self.interrupt or (self.port.machine_ms() - self._looked_ms) & COUNT_MASK >= _LOOK_MS:
                    if self.interrupt and link.buffer_input and serial.any():  # `?` would wait for the batch's end and the other links
                        self._take_early(link)
                    break
            elif more and self.interrupt and isinstance(answers, tuple):
                more -= 1  # a sender of `?` alone must not hold the machine up
                self._carry_out(answers, link)
            else:
                break
            data = serial.read()
        if batch.begun:
            batch.close(batch)
            if self.controller.queue.waiting:
                self._heard |= _WHOLE | _LINES
        return b"" if isinstance(answers, bytes) else answers

    @micropython.native
    def _set_off(self, link):
        """The machine stands, and no more lines are coming: move first, answer then."""
        link.batch.close(link.batch)
        self.controller.queue.begin()
        self._make_words()

    @micropython.native
    def _send_events(self):
        """Tell the links all events: answers to the link of their command, others to every link. An answer may add further events."""
        events = self.controller.machine.events
        while events:
            event = events.pop(0)
            if event.command is None:
                if event.kind in (ALARM, DROPPED, RESTARTED):
                    self._refuse_waiting(event)
                for link in self.links:
                    said = link.protocol.push_bytes(event)
                    if said:
                        link.serial.write(said)
            elif event.command.link:
                link = event.command.link
                said = link.protocol.reply(event)
                if said:
                    link.serial.write(said)

    # --- what was sent before a stop, a reset, an alarm or a hand-over moves nothing after it

    def _refuse_waiting(self, event):
        """Refuse the commands that wait, the bytes that have come and were not read, unless they are harmless, and those that the languages
        hold back. Only of the link that brought this about, what stands behind its word for it was sent after it, and counts."""
        alarm = event.kind == ALARM
        if alarm and event.error in (errors.ALARM_RESET, errors.ALARM_HOMING_RESET, errors.ALARM_HOMING_REQUIRED):
            return  # RESTARTED follows; or what has come may home the other axes, and is refused if it does not
        number = errors.LOCKED if alarm else event.error if event.kind == DROPPED else errors.STOPPED
        cause = None if alarm or event.value is None else event.value.link
        if self._speaking is not cause:
            self._overruled = number
        for link in self.links:
            waiting, link.waiting, reads = link.waiting, [], _READS
            if link is cause or link is self._speaking or event.kind == RESTARTED and event.value is None:
                reads = 0
            while reads:
                data = link.serial.read()
                reads = reads - 1 if data else 0
                for command in link.protocol.feed(data, self._now_ms) if data else ():
                    command.link = link
                    if not RIGHTS.get(command.kind, 0) & HARMLESS:
                        waiting.append(command)
                    elif self.controller.accept(command) == LATER:
                        link.waiting.append(command)
            if waiting:
                self.controller.refuse(waiting.pop(0), number, *waiting)
            if link is not cause:
                said = link.protocol.drop(event)
                if said:
                    link.serial.write(said)

    def stop(self):
        """Halt, tool off, motors without current."""
        self.controller.machine.shut_down()
        getattr(self.controller.features["links"], "close", int)()
