"""Playing a step program: forward, backward, step by step, again and again, with manual moves in between and the way back.

motion.py has the form of a step program. control_orders.py has its arrival and its orders. The machine stops only at
a step, and every start goes on from there: a pause takes the walk off the queue, so that a turn-round, a manual move or a single step may
follow.

Manual moves at a pause are a step program of their own, which the automatic return walks backward.
"""

from micropython import const

from passo.commands import FINISHED, Event
from passo.control.feature import QUEUE_GONE, WORK_GONE
from passo.control.links import NEVER_WAITS, OF_LENDER, RIGHTS
from passo.options.step_program.commands import STEP_PROGRAM, STEP_PROGRAM_ADD
from passo.options.step_program.control_orders import ASK, DRIVES_ON, HAND, IDLE, RETURN, RUN, StepProgramOrders
from passo.records import COUNT_HALF, COUNT_MASK, ENDLESS

_GATHER = const(512)  # units that a stream sets out with, so that the board's pauses for breath do not show


class StepProgramPlayer(StepProgramOrders):
    event_mask = QUEUE_GONE | WORK_GONE

    def __init__(self, board, machine, queue):
        StepProgramOrders.__init__(self, board, machine, queue)
        self._drives = False  # as the program or the operator left them
        self._without = None  # the start of a walk for which no motor has current
        machine.job = self
        self.kept = self.counting = self.announced = False  # for the journal, as drawing.py has them
        self._dropped = False  # at its stand, and not yet cleared

    def _clear_state(self):
        """See the base; no walk is held."""
        StepProgramOrders._clear_state(self)
        self._held = IDLE  # the mode that the machine's hold has interrupted
        self._from = 0  # the start of the walk under way

    def handlers(self):
        RIGHTS[STEP_PROGRAM] = NEVER_WAITS | OF_LENDER
        return {STEP_PROGRAM: self._do_order, STEP_PROGRAM_ADD: self._do_add}

    def owns_axes(self):
        """Return "run" while a program is under way, or is to set out, "hold" at a pause amid it, else ""."""
        if self._mode != IDLE:
            return "run"
        return "hold" if self._midway else "" if self._start_ms is None else "run"

    def may_change(self):
        """Return True during a walk."""
        return self._mode != IDLE

    def on_events(self, what):
        """Forget all motion, or the walk that a stand has taken off the queue."""
        if what & WORK_GONE:
            self._forget_motion()
        if what & QUEUE_GONE and self._mode != IDLE:  # the stand came behind poll(), and the walk is off the queue
            self._next = None
            self._leave_walk(self._mode)
            self._drop_at_stand()

    def _forget_motion(self):
        """Go back to the program's start, now or at the stand, because all motion is dropped; streamed items are forgotten."""
        if self._machine.dropping and self._mode != IDLE:
            self._next = self._drop_at_stand
            return
        self._power_back()
        if self._streaming or self.program.open:
            self._reset_program()
        self._walker.go_to_start()
        self._walker.pause_for(self._least_ticks)
        self._clear_state()

    def _drop_at_stand(self):
        """Switch the tool off at the stand. The next cycle forgets the motion; the journal looks before."""
        self._queue.rest(False)
        self._dropped = self._machine.awake = True

    def _fail_program(self):
        """Forget a stored program; stop a streamed one, the tool off."""
        if not self._streaming:
            self._reset_program()
            return
        self.program.expect_more(False)
        self._at_stand(self._give_up)

    def _give_up(self):
        """Forget the program, the tool off."""
        self._reset_program()
        self._queue.rest(False)

    # --- walking

    def _set_drives(self, on):
        """Switch the drives on or off."""
        self._drives = on
        self._barred = self._barred and not on
        self._machine.motors.drives(on)

    def _power_back(self):
        """Let the motors have current again, behind a walk without it. The position is lost if that has moved."""
        if self._without is not None:
            if self._queue.position() != self._without:
                self._machine.lose_position()  # the motors are not where the steps lead to
            self._without = None
            self._machine.motors.unpower(0)

    def _at_stand(self, action):
        """Do `action` as soon as the machine stands, now if it does."""
        if self._mode == IDLE:
            self._release_hold()
            action()
        else:
            self._next = action
            self._queue.hold(True)

    def _release_hold(self):
        """End the hold."""
        self._machine.end_hold()
        self._queue.hold(False)
        self._held = IDLE

    def _start_walk(self, backward=False, most=ENDLESS):
        """Walk the program from here, `most` units at most."""
        self._backward = backward
        self._most = most
        self._from = self._walker.index
        if backward and self._powers and not self._drives and not self._barred:
            self._set_drives(True)  # as on the way forward, but for the part before the program's first [
        self._begin_walk(self._walker, RUN, backward, most)

    def _begin_walk(self, walker, mode, backward, most=ENDLESS):
        """Queue a walk of `walker`; `mode`: RUN, HAND or RETURN."""
        self._mode = mode
        self._start_ms = None
        self._midway = self._midway or mode == RUN
        walker.follow_walker(self._hand if walker is self._walker else self._walker)
        if not self._drives:
            self._without = self._queue.position()
            self._machine.motors.unpower((1 << self.program.axes) - 1)
        walker.begin(backward, most, self._queue.lit())
        self._queue.close()  # the walk before it may have had no current
        self._queue.walk(walker)

    def poll(self, now_ms):
        """Go on: set out, resume, take a held walk off the queue, or finish one that has been played."""
        machine = self._machine
        if self._held or self._mode != IDLE or self._start_ms is not None:
            machine.awake = True
        if self._dropped:
            self._dropped = False
            self._forget_motion()
            return
        if self._held and not machine.hold:  # resumed by a button
            if self._held == RETURN:
                self._go_back(self._backward)
            elif self._held == RUN:
                self._start_walk(self._backward)
            self._held = IDLE
            return
        if self._mode == IDLE:
            if self._start_ms is not None and not machine.hold and self._has_gathered():
                self._start_walk()
            return
        if self._next is not None or machine.hold:
            if self._queue.standing():
                self._take_off()
        elif self._queue.still():
            self._queue.settle()
            self._finish_walk()

    def _has_gathered(self):
        """Return True once enough of a stream has come to set out, or its time is over."""
        waited = (self._machine.port.machine_ms() - self._start_ms) & COUNT_MASK < COUNT_HALF
        return waited or not self.program.open or self.program.total >= _GATHER

    def _take_off(self):
        """Take the walk off the queue at the stand of a hold, and do what waits for that."""
        mode = self._mode
        lit = self._queue.lit()
        self._queue.drop()
        self._queue.tool = lit
        self._leave_walk(mode)
        action = self._next
        self._next = None
        if action is not None:
            self._release_hold()
            action()
        else:
            self._held = mode
            self._queue.hold(True)

    def _leave_walk(self, mode):
        """Note that no walk is under way, and where it was left."""
        self._mode = IDLE
        self._power_back()
        if mode == RUN:
            self._left_at = self._queue.target[:]
        else:
            self._hand.cut_program()

    def _finish_walk(self):
        """Do what follows a walk that has been played to its end."""
        mode = self._mode
        self._mode = IDLE
        self._power_back()
        if mode == HAND:
            if not self._hand.at_end():
                self._walk_by_hand()
        elif mode == RETURN:
            self._forget_moves()
            if not self._asked:
                self._start_walk(self._backward)
        else:
            self._queue.tool = self._walker.tool
            self._left_at = self._queue.target[:]
            self._arrive_in_program()

    def _arrive_in_program(self):
        """Go on behind a STATION, or end at the program's end or start."""
        walker = self._walker
        done = self._most != ENDLESS and walker.index != self._from
        station = None if self._backward or done else walker.pass_station()
        if station == ASK:
            self._asked = True
            self._tell_end("speed")
            return
        if station is not None:
            self._set_drives(station == DRIVES_ON)
        if walker.at_start() if self._backward else walker.at_end():
            self._end_program()
        else:
            self._go_along()

    def _go_along(self):
        """Walk on, unless it was a single step."""
        if self._most == ENDLESS:
            self._start_walk(self._backward)

    def _end_program(self):
        """End the program, or begin its next pass."""
        program = self.program
        if self._backward:
            forgotten = program.start != 0  # the items streamed first
            self._midway = forgotten and program.open
            if self._powers and not forgotten:
                self._set_drives(False)
            self._tell_end("oldest" if forgotten else "start")
        elif program.open:
            self._go_along()
        elif self._pass < self._passes:
            self._pass += 1
            self._walker.go_to_start()
            self._go_along()
        else:
            self._midway = self._streaming = False
            self._tell_end("end")

    def _tell_end(self, what):
        """Answer the last command with FINISHED and `what`."""
        self._machine.tell(Event(FINISHED, self._command, 0, what))

    # --- for the status report

    def report(self, report):
        """Add `step_program`, a dict, to the status report."""
        walker = self._walker
        index = self._queue.index() if self._mode == RUN else None
        seen = self._hand if self._mode in (HAND, RETURN) else walker
        stepping = self._mode != IDLE and seen.left and not seen.wait_ms
        report["step_program"] = {
            "index": walker.index if index is None else index,
            "total": self.program.total,
            "pass": self._pass,
            "passes": self._passes,
            "backward": self._backward,
            "asked": self._asked,
            "manual": self._hand.index,
            "wait_ms": walker.wait_ms,
            # Tenths of a mm/min: the speed of the first axis's period in whole microseconds.
            "speed": self._lengths[1] * 10 // walker.step_us(1),
            "moving": seen.moving if stepping else 0,
            "negative": seen.negative if stepping else 0,
            "tool": self._queue.lit(),
            "drives": self._drives,
            "room": self.program.size - self.program.cells_used(),
        }
