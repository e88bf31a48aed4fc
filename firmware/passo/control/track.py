"""Playing a track: forward, backward, step by step, again and again, with manual moves in between and the way back.

What a track is stands in motion/step_program.py, how it comes in track_intake.py. TRACK says what to do with it. Every stand is at
a step, and every start goes on from there: a pause takes the walk off the queue, so that a turn-round, a manual move or
a single step may follow.

Manual moves at a pause are a track of their own, which the automatic return walks backward.
"""

from array import array
from micropython import const

from passo import commands, errors
from passo.commands import FINISHED, Event
from passo.control import setting_numbers as table
from passo.control.track_intake import ASK, DRIVES_ON, TrackIntake, lengths_of
from passo.motion.step_program import StepProgram, run
from passo.motion.step_program_walker import StepProgramWalker
from passo.records import COUNT_HALF, COUNT_MASK, ENDLESS
from passo.steps.word import us_to_ticks

MOST_PASSES = const(100)
_MANUAL_CELLS = const(256)
_GATHER = const(512)  # units that a stream sets out with, so that the board's pauses for breath do not show

_IDLE = const(0)
_RUN = const(1)
_HAND = const(2)  # manual moves
_RETURN = const(3)  # the way back of the manual moves

class Feature(TrackIntake):
    def __init__(self, board, machine, queue):
        config = board["track"]
        axes = board["axes"]
        self._queue = queue
        self._machine = machine
        self._dry_run = config["dry_run"]
        self._default = config["default_mm_min"]
        lengths = lengths_of(axes)
        self._lengths = lengths
        self.fastest = min([lengths[1 << axis] for axis in range(len(axes))]) // config["interval_us"] or 1
        self._least_ticks = us_to_ticks(config["interval_us"])
        self.track = StepProgram(len(axes), config["cells"])
        tool_ticks = array("i", [queue.tool_ticks(False), queue.tool_ticks(True)])
        self._walker = StepProgramWalker(self.track, lengths, tool_ticks)
        self._manual = StepProgram(len(axes), _MANUAL_CELLS)
        self._hand = StepProgramWalker(self._manual, lengths, tool_ticks)
        self._loading = False
        self._streaming = False
        self._drives = False  # as the track or the operator left them
        self._powers = False  # the track switches them on somewhere
        self._barred = False  # the operator wants no current: no move by hand switches them on
        self._without = None  # where a walk began that no motor has current for
        self._origin = [0] * len(axes)  # where the track begins
        self._command = None  # to be told when the track's end, or its start, is reached
        self._mode = _IDLE
        self._reset()

    def _reset(self):
        self.track.clear(self._clamp(self._default))
        self._walker.rewind()
        self._stand()
        self._loading = self._streaming = self._powers = False

    def _stand(self):
        """Nothing is under way, and there are no manual moves to go back."""
        self._mode = _IDLE
        self._start_ms = None  # when what is streamed is to set out at the latest
        self._midway = False  # has set out, and has not come to an end
        self._asked = False  # waits for the operator's speed
        self._held = _IDLE  # the mode that the machine's hold has interrupted
        self._left_at = self._origin  # where it left the track, for moves by hand
        self._next = None  # what to do at the stand: a function without arguments
        self._backward = False
        self._most = ENDLESS
        self._from = 0  # where the walk under way began
        self._pass = self._passes = 1
        self._hand_tool = False
        self._forget_moves()

    def _forget_moves(self):
        self._manual.clear(self._clamp(self._default))
        self._hand.rewind()

    def handlers(self):
        return {commands.TRACK: self._do, commands.TRACK_ADD: self._add}

    def active(self):
        return self._mode != _IDLE or self._midway or self._start_ms is not None

    def live(self):
        return self._mode != _IDLE

    def held(self):
        return self._midway and self._mode == _IDLE

    def clear(self):
        """All motion has been dropped: back to the track's start; what was streamed is forgotten."""
        self._power_back()
        if self._streaming or self._loading:
            self._reset()
        self._walker.rewind()
        self._walker.gap = self._least_ticks
        self._stand()

    def _fail(self):
        """What was stored is forgotten; what was played as it came stops, the tool off."""
        if not self._streaming:
            self._reset()
            return
        self.track.open = False
        self._at_stand(self._give_up)

    def _give_up(self):
        self._reset()
        self._queue.rest(False)

    # --- what to do with it

    def _do(self, command):
        """TRACK."""
        verb = command.value
        if self._mode == _IDLE and not self._queue.still():
            return errors.BUSY
        if verb == commands.TRACK_PACE:
            return self._pace(command)
        if verb == commands.TRACK_PASSES:
            return self._set_passes(command)
        refusal = self._machine.unready()
        if refusal:
            return refusal
        if verb == commands.TRACK_JOG:
            return self._jog(command)
        if verb in (commands.TRACK_HAND_TOOL, commands.TRACK_HAND_DRIVES):
            return self._switch(command)
        if self._loading or not self.track.total:
            return errors.NO_TRACK
        if verb == commands.TRACK_RETURN:
            return self._return(command)
        if verb == commands.TRACK_CONTINUE:
            if self._mode in (_RUN, _RETURN):
                return errors.BUSY
        return self._go(command)

    def _go(self, command):
        """TRACK_GO, TRACK_STEP, TRACK_CONTINUE: `tool` says backward, `power` how many times (0: as set)."""
        if self._mode == _RETURN:
            return errors.BUSY
        if self._moved_by_hand() and command.value != commands.TRACK_CONTINUE:
            return errors.RETURN_OR_CONTINUE
        if (self._streaming or self.track.start) and command.power > 1:
            return errors.NO_TRACK
        if command.power > MOST_PASSES:
            return errors.PASSES
        backward = command.tool
        most = 1 if command.value == commands.TRACK_STEP else ENDLESS
        if self._mode == _IDLE and not self._midway and not self._streaming:
            if not backward and self._walker.at_end():
                if self.track.start:
                    return errors.NO_TRACK  # its beginning was streamed and is forgotten
                self._walker.rewind()
            if self._walker.at_start() and not self.track.start:
                self._origin = self._queue.target[:]
            self._pass = 1
        if command.power:
            self._passes = command.power
        origin = self._origin
        forgotten = self.track.start and not self._midway
        if self._mode == _IDLE and (forgotten or self._moved_by_hand()):  # the rest of the track lies elsewhere now
            target = self._queue.target
            self._origin = [at + to - was for at, to, was in zip(origin, target, self._left_at)]
        if (origin is not self._origin or self._walker.at_start()) and not self._reachable():
            self._origin = origin
            return errors.TRAVEL
        self._command = command
        if not (self._mode == _RUN and backward == self._backward and most == self._most and not self._pausing()):
            self._asked = False
            self._at_stand(lambda: self._go_on(backward, most))
        return self._machine.accepted(command)

    def _go_on(self, backward, most):
        self._forget_moves()
        self._start(backward, most)

    def _pausing(self):
        return self._next is not None or bool(self._machine.hold)

    def _moved_by_hand(self):
        return self._midway and self._hand.place != 0

    def _return(self, command):
        if self._mode in (_RUN, _RETURN):
            return errors.BUSY
        if not self._midway:
            return errors.NO_TRACK
        if self._barred:
            return errors.DRIVES_OFF
        backward = command.tool
        self._command = command
        self._at_stand(lambda: self._go_back(backward))
        return self._machine.accepted(command)

    def _go_back(self, backward):
        self._backward = backward
        self._most = ENDLESS
        self._hand.tool = False
        self._set_drives(True)
        self._walk(self._hand, _RETURN, True)

    def _jog(self, command):
        """`target`: steps of each axis, one axis after the other."""
        if self._mode not in (_IDLE, _HAND) or self._pausing() and self._mode == _HAND:
            return errors.BUSY
        if self._machine.state not in ("idle", "run", "hold"):
            return errors.BUSY
        if self._barred:
            return errors.DRIVES_OFF
        if self._mode == _IDLE and not self._midway:
            self._forget_moves()
        queue = self._queue
        machine = self._machine
        place = [at + by for at, by in zip(queue.target, command.target)]
        if machine.homed and machine.settings.value(table.SOFT_LIMITS) and not queue.inside(place):
            return errors.JOG_TRAVEL
        for axis in range(len(command.target)):
            steps = command.target[axis]
            if steps and not self._manual.append(run(1 << axis, (steps < 0) << axis, abs(steps))):
                return errors.TRACK_FULL
        queue.lead(place)
        if self._mode == _IDLE:
            self._at_stand(self._move)
        return machine.accepted(command)

    def _move(self):
        self._hand.tool = self._hand_tool
        self._set_drives(True)
        self._walk(self._hand, _HAND, False)

    def _switch(self, command):
        """The tool or the drives by hand, at a stand."""
        if self._mode != _IDLE or not self._queue.still():
            return errors.BUSY
        if command.value == commands.TRACK_HAND_DRIVES:
            self._set_drives(command.tool)
            self._barred = not command.tool
        else:
            self._hand_tool = command.tool and not self._dry_run
            self._queue.rest(self._hand_tool)
        return self._machine.accepted(command)

    def _set_drives(self, on):
        self._drives = on
        self._barred = self._barred and not on
        self._machine.motors.drives(on)

    def _power_back(self):
        """The end of a walk, or of a part of it; the next one has current if the drives are on."""
        if self._without is not None:
            if self._queue.position() != self._without:
                self._machine.homed = False  # the motors are not where the steps lead to
            self._without = None
            self._machine.motors.unpower(0)

    def _pace(self, command):
        """`feed` mm/min, from now on to the next speed of the track; it ends the wait for the operator's speed."""
        if command.feed < 1:
            return errors.SPEED_RANGE
        speed = min(command.feed, self.fastest)
        self._walker.set_speed(speed)
        if self._asked:
            self._asked = False
            self.track.correct_speed(self._walker.cell, speed)
            if not self._moved_by_hand():
                self._at_stand(self._start)
        return self._machine.accepted(command)

    def _set_passes(self, command):
        if not 1 <= command.power <= MOST_PASSES:
            return errors.PASSES
        if (self._streaming or self.track.start) and command.power > 1:
            return errors.NO_TRACK
        self._passes = command.power
        return self._machine.accepted(command)

    # --- walking

    def _at_stand(self, action):
        """Do `action` as soon as the machine stands, now if it does."""
        if self._mode == _IDLE:
            self._release_hold()
            action()
        else:
            self._next = action
            self._queue.hold(True)

    def _release_hold(self):
        self._machine.end_hold()
        self._queue.hold(False)
        self._held = _IDLE

    def _start(self, backward=False, most=ENDLESS):
        self._backward = backward
        self._most = most
        self._from = self._walker.place
        if backward and self._powers and not self._drives and not self._barred:
            self._set_drives(True)  # as they were on the way forward, but for what lies before the track's first [
        self._walk(self._walker, _RUN, backward, most)

    def _walk(self, walker, mode, backward, most=ENDLESS):
        self._mode = mode
        self._start_ms = None
        self._midway = self._midway or mode == _RUN
        for other in (self._walker, self._hand):
            if other is not walker:  # its last interval may still run
                walker.gap = max(walker.gap, other.gap)
                other.gap = 0
        if not self._drives:
            self._without = self._queue.position()
            self._machine.motors.unpower((1 << self.track.axes) - 1)
        walker.begin(backward, most, self._queue.lit())
        self._queue.close()  # the walk before it may have had no current
        self._queue.track(walker)

    def poll(self, now_ms):
        machine = self._machine
        if self._held and not machine.hold:  # resumed by a button
            if self._held == _RETURN:
                self._go_back(self._backward)
            elif self._held == _RUN:
                self._start(self._backward)
            self._held = _IDLE
            return
        if self._mode == _IDLE:
            if self._start_ms is not None and not machine.hold and self._gathered():
                self._start()
            return
        if self._next is not None or machine.hold:
            if self._queue.standing():
                self._take()
        elif self._queue.still():
            self._queue.settle()
            self._arrive()

    def _gathered(self):
        """True when enough of a stream has come to set out, or has been waited for."""
        waited = (self._machine.port.machine_ms() - self._start_ms) & COUNT_MASK < COUNT_HALF
        return waited or not self.track.open or self.track.total >= _GATHER

    def _take(self):
        """At the stand of a hold: take the walk off the queue."""
        mode = self._mode
        lit = self._queue.lit()
        self._queue.drop()
        self._queue.tool = lit
        self._mode = _IDLE
        self._power_back()
        if mode == _RUN:
            self._left_at = self._queue.target[:]
        else:
            self._hand.cut()
        action = self._next
        self._next = None
        if action is not None:
            self._release_hold()
            action()
        else:
            self._held = mode
            self._queue.hold(True)

    def _arrive(self):
        """A walk has been played to its end."""
        mode = self._mode
        self._mode = _IDLE
        self._power_back()
        if mode == _HAND:
            if not self._hand.at_end():
                self._move()
        elif mode == _RETURN:
            self._forget_moves()
            if not self._asked:
                self._start(self._backward)
        else:
            self._queue.tool = self._walker.tool
            self._left_at = self._queue.target[:]
            self._arrive_on_track()

    def _arrive_on_track(self):
        walker = self._walker
        done = self._most != ENDLESS and walker.place != self._from
        station = None if self._backward or done else walker.pass_station()
        if station == ASK:
            self._asked = True
            self._tell("speed")
            return
        if station is not None:
            self._set_drives(station == DRIVES_ON)
        if walker.at_start() if self._backward else walker.at_end():
            self._end()
        else:
            self._go_along()

    def _go_along(self):
        """On, unless it was a single step."""
        if self._most == ENDLESS:
            self._start(self._backward)

    def _end(self):
        track = self.track
        if self._backward:
            forgotten = track.start != 0  # what was streamed first
            self._midway = forgotten and track.open
            if self._powers and not forgotten:
                self._set_drives(False)
            self._tell("oldest" if forgotten else "start")
        elif track.open:
            self._go_along()
        elif self._pass < self._passes:
            self._pass += 1
            self._walker.rewind()
            self._go_along()
        else:
            self._midway = self._streaming = False
            self._tell("end")

    def _tell(self, what):
        self._machine.tell(Event(FINISHED, self._command, 0, what))

    # --- for the status report

    def report(self, report):
        """Add what is known of the track: `track`, a dict."""
        walker = self._walker
        place = walker.place
        if self._mode == _RUN:
            place = self._queue.place()
            if place is None:
                place = walker.place
        period_us = walker.step_us(1)
        seen = self._hand if self._mode in (_HAND, _RETURN) else walker
        stepping = self._mode != _IDLE and seen.left and not seen.wait_ms
        report["track"] = {
            "place": place,
            "total": self.track.total,
            "pass": self._pass,
            "passes": self._passes,
            "backward": self._backward,
            "paused": self._midway and self._mode != _RUN,
            "asked": self._asked,
            "manual": self._hand.place,
            "wait_ms": walker.wait_ms,
            # Tenths of a mm/min: what the whole microseconds of the first axis's period amount to.
            "speed": self._lengths[1] * 10 // period_us,
            "moving": seen.moving if stepping else 0,
            "negative": seen.negative if stepping else 0,
            "tool": self._queue.lit(),
            "drives": self._drives,
            "room": self.track.size - self.track.used(),
        }
