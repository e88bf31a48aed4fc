"""The machine's state: the one record that the controller and its features read and write.

    machine.alarm, machine.state, machine.command …
    machine.raise_alarm(errors.ALARM_HARD_LIMIT, "stop")

Features (feature.py) see this record and the queue. Events of the whole machine (a stop, an alarm, a new beginning) are methods of the
record, which call those of all features.

An attribute has one writer beside this module, unless WRITERS of tests_host/rules/test_writers.py says why it has more. Languages read
what FACE there names, and write nothing.
"""

import micropython
from micropython import const

from passo import commands, errors
from passo.commands import ACCEPTED, ALARM, FINISHED, NOTICE, REFUSED, RESTARTED, Command, Event
from passo.config.setting_numbers import HARD_LIMITS, SOFT_LIMITS
from passo.control.feature import ANEW, HANDED_OVER, OFF, QUEUE_GONE, SAFE, WORK_GONE, overriding
from passo.control.inputs import Inputs
from passo.control.log import Log
from passo.errors import LATER
from passo.records import SEEN_LINE

_LEAST_FREE, _FIRST_OF_AXES = const(10), const(100)  # between them are settings of reports, limits and the tool: it may be on


class MachineState:
    def __init__(self, board, settings, queue, motors, port, guarded=0):
        """`guarded`: mask of the links that move nothing until the machine is homed or unlocked; others may."""
        self.settings = settings
        self.queue = queue
        self.motors = motors
        self.port = port
        self.inputs = Inputs(board, settings, port)
        self.log = Log(port.machine_ms)
        self.note = self.log.add  # note(number, who=None): add to the log
        self.veto = getattr(port, "veto", None)  # of the port, if the board file has an option that forbids motion
        self.squaring = None  # homes both sides of an axis, if an option does
        self.quality = None  # judges how well homing repeats, if an option does
        self.about = ""  # the port's text about itself
        self.awake = True  # something is under way or new: features are polled
        self.homed = False  # each axis with a sensor has been, since the position was lost
        self.known = 0  # mask of the axes that have
        self.cautious = True  # the next motion beyond the reach of soft limits brings a notice
        self.job = None  # the feature that plays commands or points, which counts for the journal; None: lines have numbers of their own
        self.alarm = 0
        self.checking = False  # commands are only checked
        self.sleeping = False  # everything is off until RESET
        self.command = None  # the long command under way, see begin()
        self.poll = None  # poll(now_ms): goes on with it, once a cycle; None: nothing has to
        self.hold = ""  # "hold" or "door" while the machine is held, or on its way to its stand
        self.stood = False  # it has come to its stand
        self.resuming = False  # it waits for spindle or coolant before it goes on
        self.away = False  # it is beside its path, parked
        self.dropping = False  # at the stand, what is left is dropped
        self.jogging = False
        self.active = False  # motion of a program has been queued and has not come to its end
        self.fresh = False  # such motion was queued since the last cycle
        self.drawing = False  # points are taken out of the point buffer
        self.presence = ""  # the input that is active while somebody is at the machine, see admission.py
        self.retracts = False  # after an alarm Z still goes up, before the tool goes off: see host_watch.py
        self.coolant = 0  # as it should be, see COOLANT
        self.spindle = commands.SPINDLE_OFF  # as it should be, see SPINDLE
        self.power = 0  # of the spindle, in millionths of the most
        self.overrides = None  # feed, rapid, spindle: Tools has them
        self.gauge = None  # the feature that measures the spindle's speed: a SpindleSpeed
        self.links = [link["name"] for link in board["links"]]
        self.commander = self.links.index(board["commands"] or self.links[0])  # the link that may command
        self.lender = -1  # the link that commanded when a stored job began to run; -1: none runs
        self.guarded = guarded
        self._locks = bool(guarded)
        self.events = []  # waiting: the app takes them
        self._report = {"position": queue.here, "seen": queue.seen, "log": self.log}  # one for all: used up before the next
        self.blocks = queue.room  # blocks(): how many can be queued now
        self.target = queue.target  # the position at the queue's end, steps of each axis: one array
        self.arcs = queue.arcs
        self.handlers = {}  # of all features, by the kind of command
        self._features = ()
        self.actives = self._reports = self._halts = ()
        self.steps_per_m = settings.steps_per_m
        homing = board["homing"]
        self._homing_first = bool(homing and homing["required"])
        self.guard()

    def join(self, features):
        """Take over `features`, all there are: their handlers and overridden methods. Called once, by the controller."""
        self._features = features
        self.actives = overriding(features, "owns_axes")
        self._reports = overriding(features, "report")
        self._halts = overriding(features, "halt")
        for feature in features:
            self.handlers.update(feature.handlers() or {})
        for feature in features:
            feature.guard(self.handlers)

    # --- what it is doing

    @property
    @micropython.native
    def state(self):
        """The state in a word, as a status report has it: idle, run, hold, jog, home, door, alarm, check or sleep."""
        if self.sleeping:
            return "sleep"
        if self.alarm:
            return "alarm"
        command = self.command
        if command is not None and command.kind == commands.HOME:
            return "home"
        if self.hold:
            return self.hold
        if self.checking:
            return "check"
        if self.jogging:
            return "jog"
        for active in self.actives:
            word = active()
            if word:
                return word
        return "run" if command or self.drawing or self.active else "idle"

    def busy_with(self, kind):
        """Return True if the long command under way is of this kind."""
        return self.command is not None and self.command.kind == kind

    def is_at_speed(self):
        """Return True if the spindle is at speed, or nothing measures it."""
        return self.gauge is None or self.gauge.at_speed

    def fine(self):
        """Return True while inputs decide where the machine stops: cycles of the main loop should be short."""
        command = self.command
        return command is not None and (command.kind == commands.HOME or command.kind == commands.PROBE)

    def axes_are_owned(self):
        """Return True while a feature has the axes to itself; ask only if there are `actives`, whose features may."""
        for active in self.actives:
            if active():
                return True
        return False

    def unready(self):
        """Return 0, or the error that forbids all motion now: LOCKED, NO_MOTORS or NOT_HOMED."""
        if self.alarm or self.sleeping:
            return errors.LOCKED
        if self.motors.detached:
            return errors.NO_MOTORS
        return errors.NOT_HOMED if self._homing_first and not self.homed else 0

    def interlock_error(self, steps, tool=False, note=True):
        """Return 0, or INTERLOCKED if steps of these signs (None or 0: none), or the tool, are forbidden now. `note`: log the
        input."""
        veto = self.veto
        if veto is None or not veto.denied:
            return 0
        wrong = veto.refusal_mask(steps, tool)
        if not wrong:
            return 0
        if note:
            self.note(errors.INTERLOCKED, veto.blocking_input(wrong))
        return errors.INTERLOCKED

    def gate(self):
        """Return 0, LATER, or LOCKED: for commands that wait until the motion before them has ended."""
        if self.alarm or self.sleeping:
            return errors.LOCKED
        if self.command is not None or self.drawing or not self.settle():
            return LATER
        return 0

    def settle(self):
        """Return True if all motion has ended. If not, release what is queued, so that it will."""
        if self.queue.still():
            return True
        self.queue.flush()
        return False

    def report(self, link=None):
        """Return the status report: one dict, which the next call fills in anew. Looks at the queue (Queue.look()) and asks every feature.
        `link`: it has asked for the status, so the number logged last counts as told."""
        report = self._report
        report["link"] = link
        self.queue.look()
        if not self.active:
            self.queue.seen[SEEN_LINE] = 0
        report["state"] = self.state
        report["slows"] = self.dropping or self.retracts
        if self.hold:
            report["substate"] = self.substate()
        for add in self._reports:
            add(report)
        report["alarm"] = self.alarm or None
        report["error"] = self.alarm or self.log.last
        if link:
            self.log.last = 0
        return report

    def substate(self):
        """Return grbl's number behind Hold: (0 at a stand, 1 on the way there) and Door: (0 ready, 1 open, 2 on the way to its
        stand, 3 resuming)."""
        door = self.hold == "door"
        if self.resuming:
            return 3 if door else 1
        if not self.stood:
            return 2 if door else 1
        return 1 if door and self.inputs.door_open() else 0

    # --- events

    def confirm_command(self, command, value=None):
        """Tell the link that `command` is accepted; `value`: its answer. Returns 0."""
        event = command.reply or Event(ACCEPTED, command)
        event.value = value
        self.events.append(event)
        return 0

    def begin(self, command, poll=None):
        """Begin a long command: FINISHED answers it, by finish(), or a refusal if work is dropped. poll(now_ms) goes on with it, once a cycle.
        Returns 0."""
        self.command = command
        self.poll = poll
        return 0

    def finish(self, value=None):
        """End the long command: its link gets the event FINISHED with `value`."""
        command = self.command
        self.command = None
        self.events.append(Event(FINISHED, command, 0, value))

    def tell(self, event):
        """Hand an event to the link of its command."""
        self.events.append(event)

    def notice(self, number, value=None):
        """Tell all links notice `number` of errors.py."""
        self.events.append(Event(NOTICE, None, number, value))

    # --- what concerns all of it

    def carry_out(self, kind):
        """Carry out a command without a link: of a button, or of a feature that asks another one. Its result is ignored."""
        handler = self.handlers.get(kind)
        if handler:
            self.awake = True
            handler(Command(kind))

    def note_motion(self):
        """Note that motion of a program has been queued."""
        self.active = self.fresh = self.awake = True

    def show_outputs(self, on):
        """Switch the features' outputs as set, or all off (`on` False: the door)."""
        for feature in self._features:
            feature.show_outputs(on)

    def inform(self, what):
        """Call on_events(what) of each feature whose event_mask has an event in `what`, masks of feature.py. With WORK_GONE all work is
        dropped, begun or waiting; the caller drops the queue."""
        for feature in self._features:
            if feature.event_mask & what:
                feature.on_events(what)
        if what & (WORK_GONE | QUEUE_GONE):
            self.jogging = self.active = self.fresh = False
        if what & WORK_GONE:
            self.drawing = False
            self.awake = True
            self.command = None

    def drop_at_stand(self):
        """Come to a stand, then drop what is queued."""
        self.dropping = self.awake = True
        self.queue.flush()
        self.queue.hold(True)

    def drop(self):
        """Drop what is queued, at the stand of a hold."""
        self.queue.drop()
        self.inform(QUEUE_GONE)

    def end_hold(self):
        """End the hold."""
        self.hold = ""
        self.dropping = self.stood = self.resuming = False

    def abort(self):
        """Stop inside the word under way, drop everything queued; the tool is off. The position stays exact."""
        self.queue.halt()
        for halt in self._halts:
            halt()
        self.queue.drop()
        if self.hold or self.dropping:
            self.end_hold()

    def hand_over(self, number):
        """Give the command to link `number`: drop all work, switch the tool off."""
        self.commander = number
        self.inform(WORK_GONE | HANDED_OVER)

    def lose_position(self):
        """Mark the position as unknown: no axis is homed, and the journal's count is no longer whole."""
        self.homed = False
        self.known = 0
        self.cautious = True
        if self.job:
            self.job.kept = False

    def change_setting(self, number, value):
        """Change a setting, None: to the board file's value, and keep it. Only at a stand, the tool off if it is one of pins or axes. 0, or why not.
        Behind a change of steps/mm, or of the ends that axes home to, nobody knows where the motors are; offsets stay as they are in millimetres."""
        if self.state not in ("idle", "alarm") or not self.queue.still():
            return errors.BUSY
        if self.queue.lit() and not _LEAST_FREE <= number < _FIRST_OF_AXES:
            return errors.TOOL_ON
        settings = self.settings
        before, frame = settings.snapshot(), settings.frame()
        error = settings.reset(number) if value is None else settings.change(number, value)
        return error or self._keep_settings(before, frame)

    def restore_settings(self, numbers, texts):
        """Restore settings as Settings.restore(), and save. Returns 0, or MEMORY: then nothing has changed."""
        settings = self.settings
        before, frame = settings.snapshot(), settings.frame()
        settings.restore(numbers, texts)
        return self._keep_settings(before, frame)

    def _keep_settings(self, before, frame):
        """Save changed settings. Returns 0, or MEMORY: then all counts again as `before`. Another base of positions: the position is lost."""
        error = self.settings.save(before)
        if frame != self.settings.frame():
            self.lose_position()
        return error

    def shut_down(self, also=0, current=False):
        """Stop at once, forget all work, outputs safe, no current, unless motors keep their `current`. The position is no longer known."""
        self.abort()
        self.lose_position()
        self.inform(WORK_GONE | SAFE | also)
        if not current:
            self.motors.release()

    def raise_alarm(self, number, who=None, also=0):
        """Stop, tool off, lock the machine until it is homed or unlocked. `who`: for the log; `also`: further masks for on_events()."""
        command = self.command
        manner = errors.ALARMS.get(number, 0)
        if manner & errors.AT_STAND:
            # It comes to its stand as it should: where it is remains known.
            self.drop_at_stand()
            self.inform(WORK_GONE | also)
        elif manner & errors.KEEPS_CURRENT:
            self.shut_down(also | OFF, True)
        else:
            self.shut_down(also)
        self.guarded = 0
        self.alarm = number
        self.note(number, who)
        self.events.append(Event(ALARM, None, number))
        if manner & errors.NEEDS_RESET:
            self.notice(errors.NOTICE_RESET_TO_CONTINUE)
        if command is not None:
            self.events.append(Event(REFUSED, command, errors.LOCKED))

    def needs_reset(self):
        """Return a mask that is not 0 in an alarm that only a reset ends."""
        return errors.ALARMS.get(self.alarm, 0) & errors.NEEDS_RESET

    def require_homing(self, axes):
        """Lock the machine until the others, `axes` in words, are homed. Other work under way goes on."""
        self.guarded = 0
        self.alarm = errors.ALARM_HOMING_REQUIRED
        self.events.append(Event(ALARM, None, self.alarm))
        self.notice(errors.NOTICE_HOMING_REQUIRED, axes)

    def break_off_homing(self):
        """End homing that was stopped on its way: the position is lost, and the machine is locked as at the start."""
        self.lose_position()
        if self._locks:
            self.alarm = errors.ALARM_LOCKED

    def unlock(self):
        """End the alarm; the next motion brings a warning if soft limits do not hold."""
        self.guarded = 0
        self.alarm = 0
        self.cautious = True

    def caution(self):
        """Warn at the first motion after the position was lost, or the machine unlocked."""
        self.cautious = False
        self.warn()

    def warn(self):
        """Tell that soft limits do not hold, if they are on, or went off with homing behind some of its axes: the machine is not homed."""
        if not self.homed and (self.known or self.settings.value(SOFT_LIMITS)):
            self.notice(errors.NOTICE_NO_LIMITS)

    def guard(self):
        """Lock the machine if the link that commands is guarded, else unlock it."""
        if self.guarded and self.alarm in (0, errors.ALARM_LOCKED):
            self.alarm = errors.ALARM_LOCKED if self.guarded >> self.commander & 1 else 0

    def announce_restart(self, command=None):
        """Tell all links that the machine begins anew, by `command` or because it was switched on; an active limit locks
        it, an open door holds it."""
        limits = self.settings.value(HARD_LIMITS) and any([self.inputs.read(name) for name in self.inputs.names])
        if limits and not self.alarm:
            self.guarded = 0
            self.alarm = errors.ALARM_LOCKED
        self.events.append(Event(RESTARTED, None, self.alarm, command))
        if limits:
            self.notice(errors.NOTICE_LIMITS)
        if not self.alarm and self.inputs.door_open():
            self.carry_out(commands.DOOR)

    def homing_failed(self, alarm):
        """Alarm and restart, as grbl does: whatever was sent behind the homing is dropped."""
        self.raise_alarm(alarm, None, ANEW)
        self.announce_restart()
