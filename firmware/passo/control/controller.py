"""The machine's owner: checks every command before anything moves, holds state and position, queues the blocks.

    result = controller.accept(command)    # 0: done or begun; LATER: ask again; a number of errors: refused
    controller.poll()                      # once a main loop turn
    for event in controller.take_events(): …

Positions are steps from the origin, which is where the head stands after homing (before it: where it was switched on).
"""

from micropython import const

from passo.control.homing import RUNNING, Homing
from passo.control.log import Log
from passo.control.store import Store
from passo.motion.integers import NM_PER_M, length_nm
from passo.protocols import commands, errors
from passo.protocols.commands import ACCEPTED, FINISHED, REFUSED, Event
from passo.steps.word import TICKS_PER_MS, TICKS_PER_S

LATER = const(-1)
_BLOCKS_A_POINT = const(2)  # a change of the tool, and the line


class Controller:
    def __init__(self, board, planner, feeder, player, motors, port):
        self._board = board
        self._planner = planner
        self._feeder = feeder
        self._player = player
        self._motors = motors
        self._port = port
        self._axes = board["axes"]
        self._steps_per_m = [axis["steps_per_m"] for axis in self._axes]
        self.log = Log()
        self.store = Store(board["store_points"])
        self._homing = None
        if board["homing"]:
            self._homing = Homing(board["homing"], self._axes, self, port.input)
        self.homed = False
        self.alarm = 0
        self.drawn = 0  # points of the object drawn so far
        self.speed = board["speed"]["default"]
        self._origin = [0] * len(self._axes)
        self._target = [0] * len(self._axes)  # where the queue will end
        self._tool = False  # the tool bit at the queue's end
        self._taken = 0  # points taken from the store for this object
        self._drawing = False
        self._jogging = False
        self._lifting = False  # homing waits for the tool
        self._command = None  # the long command under way
        self._events = []
        self._late = 0
        self._handlers = {
            commands.BAD: self._bad,
            commands.HELLO: self._hello,
            commands.STATUS: self._status,
            commands.STOP: self._stop,
            commands.HOME: self._home,
            commands.SPEED: self._set_speed,
            commands.POINT: self._point,
            commands.DRAW: self._draw,
            commands.JOG: self._jog,
        }

    # --- the face towards the app

    @property
    def state(self):
        if self.alarm:
            return "alarm"
        if self._busy_with(commands.HOME):
            return "home"
        if self._jogging:
            return "jog"
        return "run" if self._drawing or self._command else "idle"

    def busy(self):
        """True while something moves, waits or is about to: time matters."""
        if self._busy_with(commands.HOME) or not self._planner.empty() or self._player.busy():
            return True
        return self._drawing and (self.store.count > 0 or self._command is not None)

    def position(self):
        """Steps of each axis from the origin, exact at this moment."""
        place = self._feeder.position(self._player.played())
        return [place[axis] - self._origin[axis] for axis in range(len(place))]

    def accept(self, command):
        """Carry out or begin `command`. Returns 0, LATER, or the number of the error it was refused with."""
        result = self._handlers[command.kind](command)
        if result > 0:
            self.refuse(command, result)
        return result

    def refuse(self, command, number):
        """Log error `number` and tell the command's link."""
        self._note(number, command.link.name)
        self._events.append(Event(REFUSED, command, number))

    def take_events(self):
        events = self._events
        if events:
            self._events = []
        return events

    def poll(self):
        """One turn: goes on with homing or drawing, ends what has ended, minds the motors' current."""
        now_ms = self._port.machine_ms()
        if self._busy_with(commands.HOME):
            self._poll_homing(now_ms)
        elif self._drawing:
            self._poll_drawing()
        self._poll_end()
        if self._feeder.late != self._late:
            self._late = self._feeder.late
            self._note(errors.WORDS_LATE)
        self._motors.poll(now_ms, not self._planner.empty() or self._player.busy(), self._tool)

    def may_feed(self):
        """True when the motors are ready for the words of what is queued."""
        return self._motors.ready(self._port.machine_ms())

    def fail(self, number, who=None):
        """Alarm: stop at once, tool off, motors released; only homing leads out of it. `who`: for the log."""
        self.shut_down()
        self.alarm = number
        self._note(number, who)

    def shut_down(self):
        """Stop at once, forget all work, outputs safe. The position is no longer known."""
        self.arrest()
        self.store.clear()
        self._drawing = self._jogging = False
        self._command = None
        self.homed = False
        self._motors.release()

    # --- commands

    def _bad(self, command):
        return command.error

    def _hello(self, command):
        return self._accepted(command)

    def _status(self, command):
        report = {
            "state": self.state,
            "error": self.alarm or self.log.last,
            "position": self.position(),
            "drawn": self._count_drawn() & 0xFFFF,
            "free": self.store.free(),
        }
        self.log.last = 0
        return self._accepted(command, report)

    def _stop(self, command):
        if self._busy_with(commands.STOP):
            self._finish()
        if self._busy_with(commands.HOME):
            self.homed = False
        self.arrest()
        self.store.clear()
        self._drawing = self._jogging = False
        self._lift()
        self._planner.flush()
        self._command = command
        return 0

    def _home(self, command):
        if self._homing is None:
            return errors.NO_HOMING
        if self.state not in ("idle", "alarm"):
            return LATER
        self.store.clear()
        self.alarm = 0
        self.homed = False
        self._command = command
        self._lift()
        self._planner.flush()
        self._lifting = True
        return 0

    def _set_speed(self, command):
        limits = self._board["speed"]
        if not limits["min"] <= command.value <= limits["max"]:
            return errors.SPEED_RANGE
        if self.state != "idle":
            return self._locked() or LATER
        self.speed = command.value
        return self._accepted(command)

    def _point(self, command):
        refusal = self._locked()
        if refusal:
            return refusal
        if not self._inside(command.target):
            return errors.TRAVEL
        if self._command is not None or self._jogging:
            return LATER
        if not self.store.free():
            self._drawing = True
            return LATER
        if not self.store.count and not self._drawing:
            self._taken = self.drawn = 0
        x, y = command.target
        self.store.put(x, y, command.tool)
        return self._accepted(command)

    def _draw(self, command):
        refusal = self._locked()
        if refusal:
            return refusal
        if self._command is not None or self._jogging:
            return LATER
        self._command = command
        self._drawing = True
        return 0

    def _jog(self, command):
        refusal = self._locked()
        if refusal:
            return refusal
        if self._drawing or self._command is not None or self.store.count:
            return errors.BUSY
        steps = self._board["jog"]["steps"]
        target = [self._target[axis] + steps * command.target[axis] for axis in range(len(command.target))]
        if not self._inside(target):
            return errors.JOG_TRAVEL
        if not self._planner.room():
            return LATER
        self._jogging = True
        self._line_to(target, self._tool, 0)
        self._planner.flush()
        return self._accepted(command)

    def _accepted(self, command, value=None):
        self._events.append(Event(ACCEPTED, command, 0, value))
        return 0

    def _locked(self):
        if self.alarm:
            return errors.LOCKED
        homing = self._board["homing"]
        return errors.NOT_HOMED if homing and homing["required"] and not self.homed else 0

    def _inside(self, target):
        for axis in range(len(target)):
            if not 0 <= target[axis] <= self._axes[axis]["travel_steps"]:
                return False
        return True

    def _busy_with(self, kind):
        return self._command is not None and self._command.kind == kind

    def _note(self, number, who=None):
        self.log.add(self._port.machine_ms(), number, who)

    # --- what goes on over many turns

    def _poll_homing(self, now_ms):
        if self._lifting:
            self._lifting = not self.still()
            if not self._lifting:
                self._homing.start(now_ms)
            return
        result = self._homing.poll(now_ms)
        if result == 0:
            self._origin = self._feeder.position(self._player.played())
            self._target = [0] * len(self._axes)
            self.homed = True
            self._finish()
        elif result != RUNNING:
            self.fail(result)

    def _poll_drawing(self):
        while self.store.count and self._planner.room() >= _BLOCKS_A_POINT:
            x, y, tool = self.store.take()
            self._taken += 1
            self._line_to((x, y), tool, self._taken)
        if not self.store.count:
            if self._command is not None and self._planner.room():
                self._lift()
            self._planner.flush()

    def _poll_end(self):
        if self.store.count or not self._planner.empty() or self._player.busy():
            return
        if self._jogging:
            self._jogging = False
        elif self._busy_with(commands.DRAW) or self._busy_with(commands.STOP):
            if self._drawing:
                self.drawn = self._taken
            self._drawing = False
            self._finish()

    def _finish(self):
        command = self._command
        self._command = None
        self._events.append(Event(FINISHED, command))

    def _count_drawn(self):
        if not self._drawing:
            return self.drawn
        block = self._planner.playing()
        if block is None and self._planner.empty():
            return self._taken
        return self.drawn if block is None else max(block.tag - 1, self.drawn)

    # --- queueing motion

    def _lift(self):
        """Tool off at the end of the queue, and time for it to get there."""
        if self._tool:
            self._set_tool(False, self._taken + 1)

    def _set_tool(self, on, tag):
        self._tool = on
        ms = self._board["tool"]["on_ms" if on else "off_ms"]
        self._planner.wait(max(ms * TICKS_PER_MS, 2 * self._feeder.min_word_ticks), on, tag)

    def _line_to(self, target, tool, tag):
        if tool != self._tool:
            self._set_tool(tool, tag)
        deltas = [0] * len(self._axes)
        for axis in range(len(target)):
            deltas[axis] = target[axis] - self._target[axis]
            self._target[axis] = target[axis]
        self._planner.line(deltas, self._ticks(deltas), tool, tag)

    def _ticks(self, deltas):
        """How long the line lasts at the speed set, in the board file's sense of speed."""
        speed = self._board["speed"]
        if speed["unit"] == "half_period_us":
            each_us = 2 * self.speed + speed["overhead_us"]
            return max([abs(delta) for delta in deltas]) * each_us * TICKS_PER_MS // 1000
        return length_nm(deltas, self._steps_per_m) * TICKS_PER_S * self._steps_per_m[0] // (self.speed * NM_PER_M)

    # --- the mover that homing uses

    def travel(self, axis, steps, steps_s):
        """Set out on `steps` along one axis, travel limits aside."""
        deltas = [0] * len(self._axes)
        deltas[axis] = steps
        self._planner.line(deltas, abs(steps) * TICKS_PER_S // steps_s, False, 0)
        self._planner.flush()

    def arrest(self):
        """Stop inside the word under way, drop everything queued; the tool is off. The position stays exact."""
        self._feeder.open = False
        self._player.halt()
        position, _, _ = self._feeder.cancel(self._player.played())
        self.drawn = self._count_drawn()
        self._planner.clear()
        self._tool = False
        self._target = [position[axis] - self._origin[axis] for axis in range(len(position))]

    def still(self):
        return self._planner.empty() and not self._player.busy()

    def place(self, axis):
        return self._feeder.position(self._player.played())[axis]
