"""The machine's owner: checks every command before anything moves, holds state and position, answers.

    result = controller.accept(command)    # 0: done or begun; LATER: ask again; a number of errors: refused
    controller.poll()                      # once a main loop turn
    for event in controller.take_events(): …

Positions are steps from machine position zero, which is where the head stands after homing (before it: where it was
switched on). What is done is shared out: `queue` hands motion to the planner, `objects` draws stored objects, `program`
carries out motion as it comes, `pauses` holds and resumes, `inputs` watches switches, `links` knows who may command,
`resets` begins anew.
"""

import gc

import micropython
from micropython import const

from passo import commands, errors
from passo.commands import ACCEPTED, ALARM, DROPPED, FINISHED, NOTICE, REFUSED, Command, Event
from passo.control.absent import Absent
from passo.control.homing import RUNNING, Homing
from passo.control.inputs import Inputs
from passo.control.links import Links
from passo.control.log import Log
from passo.control.queue import Queue
from passo.control.resets import Resets

LATER = const(-1)
_PAUSING = ("hold", "resume", "door")  # inputs
# The machine came to its stand as it should: where it is remains known.
_ORDERLY = (errors.ALARM_SOFT_LIMIT, errors.ALARM_PROBE_STATE, errors.ALARM_PROBE_MISSED)


class Controller:
    def __init__(self, board, planner, feeder, player, motors, port, settings, streamed=True, stored=True):
        """`streamed`: some language asks for motion as it comes; `stored`: some for stored objects."""
        self._board = board
        self._planner = planner
        self._feeder = feeder
        self._player = player
        self._motors = motors
        self.port = port
        self.settings = settings
        self._axes = board["axes"]
        self.log = Log()
        self.homed = False
        self.alarm = 0
        self.checking = False  # commands are only checked
        self.sleeping = False
        self.detached = False  # the motors are another controller's, and no motion takes them: see Changeover
        self.about = ""  # what the port says of itself, for who asks
        self.arcs_want = 0  # set by the app: bytes that have to be free before the first arc
        self.command = None  # the long command under way
        kind = Queue
        if streamed:
            from passo.control.stream_queue import StreamQueue as kind
        self.queue = kind(board, planner, feeder, player, port)
        self.objects = Absent(self.queue.lift)
        self.pauses = self.program = self.tools = Absent()
        self.inputs = Inputs(board, settings, self, port)
        self._load(streamed, stored, planner)
        self.links = Links(board, self)
        self.resets = Resets(self)
        self._homing = None
        if board["homing"]:
            self._homing = Homing(board["homing"], self._axes, self, self.inputs.read, settings.homing)
        self._parts = []  # those that only some machines have: see add()
        self._lifting = False  # homing waits for the tool
        self._events = []
        self._taken = []  # the two change places: none has to be made
        self._report = {}  # one for all: it is used up before the next
        self._late = 0
        self._still = True  # as poll() has found it
        self._handlers = {
            commands.BAD: self._bad,
            commands.HELLO: self.accepted,
            commands.STOP: self._stop,
            commands.HOME: self._home,
        }
        for part in (self.objects, self.program, self.tools, self.pauses, self.links, self.resets):
            self._handlers.update(part.handlers())

    def _load(self, streamed, stored, planner):
        """The parts that not every board has memory for."""
        board = self._board
        if stored:
            from passo.control.objects import Objects

            self.objects = Objects(board, self.queue, self)
        if streamed:
            from passo.control.pins import Pins
            from passo.control.program import Program
            from passo.control.tools import Tools

            self.pins = Pins(board, self.inputs, self.settings)
            self.program = Program(board, self.queue, self, planner)
            self.tools = Tools(board, self.queue, self, planner, self.port)
        if streamed or board["track"] or [item for item in board["inputs"] if item["name"] in _PAUSING]:
            from passo.control.pauses import Pauses

            self.pauses = Pauses(board, self.queue, self, self.port)

    def add(self, part):
        """Take in a Part (part.py), which calls this itself as it is made."""
        self._parts.append(part)
        self._handlers.update(part.handlers())

    # --- the face towards the app

    @property
    def state(self):
        if self.sleeping:
            return "sleep"
        if self.alarm:
            return "alarm"
        command = self.command
        if command is not None and command.kind == commands.HOME:
            return "home"
        if self.pauses.kind:
            return self.pauses.kind
        if self.checking:
            return "check"
        if self.program.jogging:
            return "jog"
        if self._parts and self._held():
            return "hold"
        running = command or self.objects.drawing or self.program.active() or self._parts and self.occupied()
        return "run" if running else "idle"

    @property
    def steps_per_m(self):
        return [axis["steps_per_m"] for axis in self._axes]

    @property
    def arcs(self):
        """What a language asks about arcs; None where there is no memory for what they take."""
        if self.arcs_want:
            gc.collect()
            if gc.mem_free() < self.arcs_want:
                return None
            self.arcs_want = 0
        # first: loaded inside each other they take stack that interrupts want
        from passo.motion.cordic import end_point  # noqa: F401

        from passo.control import arcs

        self._planner.load_arcs()
        return arcs

    @property
    def blocks(self):
        """How many blocks can be queued now."""
        return self.queue.room()

    def busy(self):
        """True while something moves, waits or is about to, or poll() does not know yet that it has ended: time matters."""
        if self.pauses.kind and self.pauses.standing():
            return False
        return not (self._still and self.queue.still()) or self.busy_with(commands.HOME) or self.objects.busy()

    def live(self):
        """True while what is under way may change at any moment: few words should lie ahead."""
        for part in self._parts:
            if part.live():
                return True
        return False

    def _held(self):
        for part in self._parts:
            if part.held():
                return True
        return False

    def fine(self):
        """True while inputs decide where the machine stops: turns of the main loop should be short."""
        command = self.command
        return command is not None and (command.kind == commands.HOME or command.kind == commands.PROBE)

    def position(self):
        """Steps of each axis from machine zero, exact at this moment."""
        return self.queue.position()

    def accept(self, command):
        """Carry out or begin `command`. Returns 0, LATER, or the number of the error it was refused with."""
        if command.kind == commands.STATUS:
            return self._status(command)
        handler = self._handlers.get(command.kind)
        result = self.links.refusal(command) or (handler(command) if handler else errors.UNKNOWN_COMMAND)
        if result > 0:
            self.refuse(command, result)
        return result

    def refuse(self, command, number, *more):
        """Log error `number` and tell the command's link; also of `more` commands of that link, in one line of the log."""
        self._note(number, command.link.name)
        for refused in (command,) + more:
            self._events.append(Event(REFUSED, refused, number))

    def take_events(self):
        """What has happened since; good until it is asked for again."""
        events = self._events
        if events:
            self._taken.clear()
            self._events = self._taken
            self._taken = events
        return events

    def poll(self):
        """One turn: goes on with homing, drawing and programme, ends what has ended, minds the motors' current."""
        now_ms = self.port.machine_ms()
        self.inputs.poll(now_ms)
        if self.command is not None and self.busy_with(commands.HOME):
            self._poll_homing(now_ms)
        elif self.objects.drawing:
            self.objects.poll()
        for part in self._parts:
            part.poll()
        still = self._still = self.queue.still()
        self.program.poll(still)
        self.pauses.poll(now_ms)
        self.tools.poll(still)
        if still:
            self.program.jogging = False
            if not self.objects.store.count:
                self._poll_end()
        if self._feeder.late != self._late:
            self._late = self._feeder.late
            self._note(errors.WORDS_LATE)
        if self.settings.dirty and still:
            self.settings.save()
        self._motors.poll(now_ms, not self.sleeping and not still, self.queue.tool)

    def may_feed(self):
        """True when the motors are ready for the words of what is queued."""
        for part in self._parts:
            if not part.ready():
                return False
        return self._motors.ready(self.port.machine_ms())

    def lock(self):
        """Nothing moves until the machine is homed or unlocked."""
        self.links.wary = 0
        self.alarm = errors.ALARM_LOCKED

    def shut_down(self):
        """Stop at once, forget all work, outputs safe. The position is no longer known."""
        self.arrest()
        self.forget()
        self.homed = False
        self._release_parts()
        self._motors.release()

    # --- the face towards the parts: also `command`, `state`, `settings`, `checking`, `port` and the parts themselves

    def accepted(self, command, value=None):
        event = command.accepted or Event(ACCEPTED, command)
        event.value = value
        self._events.append(event)
        return 0

    def finish(self, value=None):
        """The long command has done what it was asked."""
        command = self.command
        self.command = None
        self._events.append(Event(FINISHED, command, 0, value))

    def busy_with(self, kind):
        return self.command is not None and self.command.kind == kind

    def unready(self):
        """0, or why nothing may move now."""
        if self.alarm or self.sleeping:
            return errors.LOCKED
        if self.detached:
            return errors.NO_MOTORS
        homing = self._board["homing"]
        return errors.NOT_HOMED if homing and homing["required"] and not self.homed else 0

    def occupied(self):
        """True while one of the added parts has the axes to itself."""
        for part in self._parts:
            if part.active():
                return True
        return False

    def tell(self, event):
        """Hand an event to the link of its command."""
        self._events.append(event)

    def limp(self, mask):
        """The axes of `mask` are without current in what moves from now on; 0: none is."""
        self._motors.limp(mask)

    def unpower(self, axes):
        """The axes of `axes`, all or none, are without current in what moves from now on. Only at a stand."""
        self._motors.unpower(axes)

    def strayed(self):
        """The motors are not where the steps lead to: homing has to find out."""
        self.homed = False

    def drives(self, on):
        """The motors' current on until it is switched off, or off now."""
        self._motors.keep = on
        if not on:
            self._motors.release()

    def notice(self, number, value=None):
        self._events.append(Event(NOTICE, None, number, value))

    def press(self, name):
        """A button: "hold", "resume" or "reset"."""
        kind = {"hold": commands.HOLD, "resume": commands.RESUME, "reset": commands.RESET}[name]
        self._handlers[kind](Command(kind))

    def fail(self, number, who=None):
        """Alarm: stop, tool off. Only homing, or the user's word for it, leads out of it. `who`: for the log."""
        command = self.command
        if number in _ORDERLY:
            self.pauses.drop()
            self.forget()
        elif number == errors.ALARM_HARD_LIMIT or number == errors.ALARM_RESET:
            self.arrest()
            self.forget()
            self.homed = False
            self._release_parts()
            self.tools.switch_off()
        else:
            self.shut_down()
        self.links.wary = 0
        self.alarm = number
        self._note(number, who)
        self._events.append(Event(ALARM, None, number))
        if number in errors.NEED_RESET:
            self.notice(errors.NOTICE_RESET_TO_CONTINUE)
        if command is not None:
            self._events.append(Event(REFUSED, command, errors.LOCKED))

    # --- commands

    def _bad(self, command):
        return command.error

    def _status(self, command):
        report = self._report
        report["state"] = self.state
        report["error"] = self.alarm or self.log.last
        report["log"] = self.log.entries
        self.objects.report(report)
        self.program.report(report)
        self.tools.report(report)
        if self._parts:
            self._report_parts(report)
        report["position"] = self.queue.found()  # last: it does not last
        self.log.last = 0
        return self.accepted(command, report)

    def _report_parts(self, report):
        for part in self._parts:
            part.report(report)
        return report

    def _release_parts(self):
        for part in self._parts:
            part.release()

    def _stop(self, command):
        if self.busy_with(commands.STOP):
            self.finish(self._report_parts({}))
        elif self.command is not None:
            self._events.append(Event(REFUSED, self.command, errors.STOPPED))
        if self.busy_with(commands.HOME):
            self.homed = False
        self.arrest()
        self.forget()
        self._events.append(Event(DROPPED, None, errors.STOPPED, command))
        self.objects.lift()
        self.queue.flush()
        self.command = command
        return 0

    def _home(self, command):
        if self._homing is None:
            return errors.NO_HOMING
        if self.alarm in errors.NEED_RESET:
            return errors.LOCKED
        if self.inputs.door_open():
            return errors.DOOR_OPEN
        if self.detached:
            return errors.NO_MOTORS
        if self.state not in ("idle", "alarm") or not self.queue.still():
            return LATER
        self.objects.store.clear()
        self.links.wary = 0
        self.alarm = 0
        self.homed = False
        self.command = command
        self.objects.lift()
        self.queue.flush()
        self._lifting = True
        return 0

    def _note(self, number, who=None):
        self.log.add(self.port.machine_ms(), number, who)

    def forget(self):
        """Drop all work, begun or waiting; what is queued is the caller's affair."""
        self.objects.clear()
        self.program.clear()
        for part in self._parts:
            part.clear()
        self.command = None

    # --- what goes on over many turns

    def _poll_homing(self, now_ms):
        if self._lifting:
            self._lifting = not self.still()
            if not self._lifting:
                self._homing.start(now_ms)
            return
        result = self._homing.poll(now_ms)
        if result == 0:
            self.queue.set_origin()
            self.homed = True
            self.finish()
        elif result != RUNNING:
            self.resets.homing_failed(result)

    def _poll_end(self):
        if self.busy_with(commands.DRAW) or self.busy_with(commands.STOP):
            self.objects.end()
            self.finish(self._report_parts({}))

    # --- the mover that homing uses

    def travel(self, axis, steps, steps_s):
        """Set out on `steps` along one axis, travel limits aside."""
        self.queue.travel(axis, steps, steps_s)

    def arrest(self):
        """Stop inside the word under way, drop everything queued; the tool is off. The position stays exact."""
        self.queue.halt()
        self.objects.drawn = self.objects.count_drawn()
        self.queue.drop()
        self.pauses.clear()

    def still(self):
        return self.queue.still()

    def place(self, axis):
        return self._feeder.position(self._player.played())[axis]
