"""The machine's owner: checks every command before anything moves, carries it out, tells what came of it.

    result = controller.accept(command)    # 0: done or begun; LATER: ask again; a number of errors: refused
    controller.poll()                      # once a cycle of the main loop
    controller.machine.events.pop(0) …      # what has come of it

Positions are steps from machine position zero, which is where the head stands after homing (before it: where it was
switched on). Whatever it is and does stands in `machine`, the record of state.py; `queue` hands motion to the planner; the
rest is the features', which the board file and the languages of its links have asked for.
"""

from passo import commands, errors
from passo.commands import DROPPED, REFUSED, Event
from passo.config.setting_numbers import SOFT_LIMITS
from passo.control.feature import REFUSAL, WORK_GONE, overriding
from passo.control.links import ANY_LINK, ASKS, HARMLESS, OF_LENDER, RIGHTS
from passo.records import COUNT_MASK, REST_MS


class Controller:
    def __init__(self, board, machine, queue, feeder, kinds):
        """`kinds`: {name: class} of the features, in the order in which they are polled; [(name, class)]."""
        self.machine = machine
        self.queue = queue
        self._feeder = feeder
        self._motors = machine.motors
        self._port = machine.port
        self.features = {}  # by name
        features = []
        for name, kind in kinds:
            self.features[name] = kind(board, machine, queue)
            features.append(self.features[name])
        machine.handlers.update({
            commands.BAD: self._refuse_bad,
            commands.HELLO: machine.confirm_command,
            commands.HOME: self._refuse_homing,  # but for a machine with the feature
            commands.STOP: self._stop_now,
            commands.SETTING: self._answer_setting,
        })  # fmt: skip
        machine.join(features)
        self._looks = overriding(features, "look")  # here, and not at each cycle: to fetch a method takes memory
        self._polls = overriding(features, "poll")
        self._holds = overriding(features, "poll_hold")
        self._ends = overriding(features, "poll_end")
        self.lives = overriding(features, "may_change")
        self.readies = overriding(features, "ready") + (machine.motors.ready,)  # all have to say so before words are played
        self._busies = overriding(features, "busy")
        self._stops = overriding(features, "claim_stop")
        self._batches = {}  # (open, accept, close) by their kind
        for feature in features:
            self._batches.update(feature.batches() or {})
        self._late = 0
        self._version = -1  # of the settings, as poll() has found it
        self._limited = -1  # whether soft limits are on, in that version
        self._stood_ms = -1  # since when; −1: it does not
        self._set_amid = False  # settings have changed amid a motion: they are kept when a sender is sure to have sent all it may

    # --- the face towards the app

    @property
    def state(self):
        return self.machine.state

    def busy(self):
        """Return True while something moves, waits or is about to, or poll() does not know yet that it has ended: time matters."""
        machine = self.machine
        if machine.hold and machine.stood:
            return False
        command = machine.command
        if self._stood_ms < 0 or not self.queue.still() or command is not None and command.kind == commands.HOME:
            return True
        for busy in self._busies:
            if busy():
                return True
        return False

    def may_change(self):
        """Return True while a feature may change its motion at any moment: make few words in advance."""
        for live in self.lives:
            if live():
                return True
        return False

    def position(self):
        """Return the steps of each axis from machine zero, exact at this moment."""
        return self.queue.position()

    def accept(self, command):
        """Carry out or begin `command`. Returns 0, LATER, or the number of the error it was refused with."""
        if command.kind == commands.STATUS:
            return self.machine.confirm_command(command, self.machine.report(command.link))
        self.machine.awake = True
        link = command.link
        if link is None or link.number == self.machine.commander or self._may_command(command):
            handler = self.machine.handlers.get(command.kind)
            result = handler(command) if handler else errors.UNKNOWN_COMMAND
        else:
            result = errors.COMMANDED_ELSEWHERE
        if result > 0:
            self.refuse(command, result)
        return result

    def _may_command(self, command):
        """Return True if a link that does not command may send this, by RIGHTS."""
        rights = RIGHTS.get(command.kind, 0)
        if rights & OF_LENDER and command.link.number == self.machine.lender:
            return True
        return rights & (HARMLESS | ANY_LINK) or rights & ASKS and command.value is None and not command.tool

    # --- batches: by the same rules as commands

    def batches(self, batch):
        """Return (open, accept, close), the functions of the feature that takes batches of this kind, `batch` each:

        open    True if the machine takes rows now from the link of `batch`, as many as there is `batch.room` for; else they
                have to come as commands, to wait or to be refused. close() is to follow before anything else is done
        accept  carries out the rows, while it is open. How many: all, but if one leads out of the travel, which is an alarm
        close   no more rows come for now
        arc     (batch, command, power): of LINES, an arc that comes behind the rows, `power` in thousandths. False: it has to come as a command
        """
        return self._batches[batch.kind]

    def refuse(self, command, number, *more):
        """Log error `number` and tell the command's link; also of `more` commands of that link, in one line of the log."""
        machine = self.machine
        machine.note(number, command.link.name)
        if command.link.number == machine.commander:
            machine.inform(REFUSAL)
        for refused in (command,) + more:
            machine.tell(Event(REFUSED, refused, number))

    def poll(self):
        """One cycle: features look at what comes from outside, and if the machine is awake, they go on with their work."""
        now_ms = self._port.machine_ms()
        for look in self._looks:
            look(now_ms)
        machine = self.machine
        if machine.awake or self._version != machine.settings.version:
            self._run_cycle(machine, now_ms)

    def _run_cycle(self, machine, now_ms):
        """Do a cycle's work while the machine is awake. It stays so until nobody has more to do."""
        machine.awake = False
        if self._version != machine.settings.version:
            self._version = machine.settings.version
            limited = machine.settings.value(SOFT_LIMITS)
            if limited != self._limited:
                self._limited = limited
                machine.cautious = True
        for poll in self._polls:
            poll(now_ms)
        if machine.command is not None and machine.poll is not None:
            machine.poll(now_ms)
        still = self.queue.still()
        if machine.hold or machine.dropping:
            for poll in self._holds:
                poll()
        for poll in self._ends:
            poll(still)
        command = machine.command
        kind = -1 if command is None else command.kind
        if still:
            machine.jogging = False
            if kind == commands.STOP:
                machine.finish(machine.report())
            if self._stood_ms < 0:
                self._stood_ms = now_ms
                self._set_amid = machine.settings.dirty
            if machine.settings.dirty:
                self._save_settings(machine, now_ms)
        else:
            self._stood_ms = -1
            if machine.cautious and not machine.alarm and kind != commands.HOME:
                machine.caution()
        if self._feeder.late != self._late:
            self._late = self._feeder.late
            machine.note(errors.WORDS_LATE)
        if (
            self._motors.poll(now_ms, (not still or kind == commands.CODE + 66) and not machine.sleeping, self.queue.tool)  # in each cycle
            or not still or machine.command is not None or machine.drawing or machine.hold or machine.dropping
        ):  # fmt: skip
            machine.awake = True

    def _save_settings(self, machine, now_ms):
        """Save changed settings at a stand; those changed amid a motion only after REST_MS. A failed save is tried again at the next change."""
        settings = machine.settings
        if not settings.failed and (not self._set_amid or (now_ms - self._stood_ms) & COUNT_MASK >= REST_MS) and settings.save():
            machine.note(errors.MEMORY)  # the change counts until the power goes; the next one tries again to store it
        self._set_amid = self._set_amid and settings.dirty
        if settings.dirty and not settings.failed:
            machine.awake = True

    def handle_stop(self, name):
        """Raise the alarm of a stop: the input or feature `name` has stopped the player. A feature that claims the stop raises its own."""
        for stopped in self._stops:
            if stopped(name):
                return
        self.machine.raise_alarm(errors.ALARM_HARD_LIMIT, name)

    def tell(self, text):
        """Set the line about this board, which answers the question of its build."""
        self.machine.about = text

    # --- commands

    def _refuse_bad(self, command):
        """Refuse a command that its language could not read: return the error number in it."""
        return command.error

    def _refuse_homing(self, command):
        """Refuse HOME on a machine without the feature."""
        return errors.NO_HOMING

    def _answer_setting(self, command):
        """Answer with a setting, (number, value, decimals), or the numbers of all; change it first if `value` or `tool` (reset) is given."""
        machine = self.machine
        number, value = command.target, command.value
        if number is None:
            return machine.confirm_command(command, machine.settings.numbers)
        places = machine.settings.places(number)
        if places is None:
            return errors.STATEMENT
        if value is not None or command.tool:
            if value is not None and not places:
                if value % 1000:
                    return errors.NOT_INTEGER
                value //= 1000
            error = machine.change_setting(number, value)
            if error:
                return error
        return machine.confirm_command(command, (number, machine.settings.value(number), places))

    def _stop_now(self, command):
        """Stop inside the word under way and drop all work; STOP ends when the tool is off. Amid homing the position is lost."""
        machine = self.machine
        if machine.busy_with(commands.STOP):
            machine.finish(machine.report())
        elif machine.command is not None:
            machine.tell(Event(REFUSED, machine.command, errors.STOPPED))
        if machine.busy_with(commands.HOME):
            machine.break_off_homing()
        if machine.needs_reset():
            machine.alarm = errors.ALARM_LOCKED  # as a reset does: not every language has one
        machine.abort()
        machine.inform(WORK_GONE)
        machine.tell(Event(DROPPED, None, errors.STOPPED, command))
        self.queue.lift()
        self.queue.flush()
        return machine.begin(command)
