"""Digital outputs for the programme, M62 to M65: those that the board file names p0 … p9.

M64 and M65 switch at once. M62 and M63 switch with the first step of the next motion, without a stand: as marks in the step stream
(steps.py), which an RP2040's player shows within 3 µs. If the port has no marks (an ESP32, the timer player, shift registers, an
interlock), the cycle of the main loop does it that finds the motion before it played to its end: up to 15 ms behind that step. G4, a tool's
time and parking are no motion, as in LinuxCNC. If no motion follows, nothing happens. Whatever drops the queue drops what waits for it; so do homing
and jogs, whose motions are not the programme's. A line that is refused drops what waits for a motion to come, whichever line asked for it.

A hold leaves them as they are. The door switches them off until the machine goes on; every alarm, stop and reset for good.
"""

from passo import commands, errors
from passo.control.feature import ANEW, BY_HAND, HOMING, OFF, QUEUE_GONE, REFUSAL, SAFE, WORK_GONE, Feature
from passo.options.output_p.steps import SWITCH_MOST, Switches
from passo.records import COUNT_HALF, COUNT_MASK, KIND_WAIT, QUEUE_SIZE, ROW_KIND, SCRATCH_STRIDE


class DigitalOutputs(Feature):
    event_mask = QUEUE_GONE | WORK_GONE | SAFE | OFF | ANEW | HOMING | BY_HAND | REFUSAL

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._port = machine.port
        self._pins = {item["name"]: (item["pin"], item["active"]) for item in board["outputs"]}
        self._on = {}  # by name, of those that have been switched on
        self._waiting = []  # [count of the block that it comes with, name, on]
        shower = getattr(machine.port, "switching", None)
        self._marks = Switches(*queue.lend(), machine) if shower else None
        if shower:
            shower.show_switches(self._marks)

    def handlers(self):
        return {commands.CODE + code: self._switch_output for code in range(62, 66)}

    def _switch_output(self, command):
        """Do M62 to M65: switch an output now, or with the next motion. Returns the number of an error, LATER, or 0."""
        machine = self._machine
        name = "p%d" % command.value
        if name not in self._pins:
            return errors.NUMBER_RANGE
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        code = command.kind - commands.CODE
        if machine.command is not None or code < 64 and self._queue.chords:  # behind the last of them
            return errors.LATER
        if machine.checking:
            return machine.confirm_command(command)
        on = code in (62, 64)
        if code >= 64:
            self._put_output(name, on)
        elif not self._replace_waiting(name, on):
            if len(self._waiting) >= SWITCH_MOST:  # for motions that are queued
                return errors.LATER
            block = self._queue.blocks_queued()
            self._waiting.append([block, name, on])
            if self._marks:
                self._marks.ask_change(block, self._mark_value(name, on))
        return machine.confirm_command(command)

    def _replace_waiting(self, name, on):
        """Return True, and let `on` count, if a change of this output waits for the same motion. So no more changes wait for it than there are
        outputs."""
        waiting = self._waiting
        for index in range(len(waiting)):
            item = waiting[index]
            if item[1] == name and self._next_motion(item[0]) == self._queue.blocks_queued():
                item[2] = on
                if self._marks:
                    self._marks.amend_change(len(waiting) - index, self._mark_value(name, on))
                return True
        return False

    def _mark_value(self, name, on):
        """Return pin << 1 | level, as a mark has it."""
        pin, active = self._pins[name]
        return pin << 1 | (active if on else 1 - active)

    def _put_output(self, name, on):
        """Switch an output now."""
        self._note_state(name, on)
        self._port.output(name, on)

    def _note_state(self, name, on):
        """Note that an output is on or off."""
        if on:
            self._on[name] = True
        else:
            self._on.pop(name, None)

    def poll(self, now_ms):
        """Without marks: switch the outputs whose motion has begun."""
        waiting = self._waiting
        if self._marks:
            self._count_shown()
            return
        if self._machine.away:  # the queue's counts are parking's
            return
        for item in waiting:
            item[0] = self._next_motion(item[0])
        while waiting and self._has_begun(waiting[0][0]):
            _, name, on = waiting.pop(0)
            self._put_output(name, on)

    def _next_motion(self, count):
        """Return the number of the first block from `count` on that moves."""
        queue = self._queue
        planner = queue.planner
        while count != queue.blocks_queued() and planner.rows[count % QUEUE_SIZE * planner.scratch[SCRATCH_STRIDE] + ROW_KIND] == KIND_WAIT:
            count = (count + 1) & COUNT_MASK
        return count

    def _has_begun(self, count):
        """Return True if block number `count` has been queued, and those before it have been played."""
        queue = self._queue
        ready = (queue.blocks_played() - count) & COUNT_MASK < COUNT_HALF
        return ready and queue.blocks_queued() != count and (queue.blocks_played() != count or not queue.silent())

    # --- stops

    def _count_shown(self):
        """Note the outputs whose marks the port has shown."""
        for _ in range(self._marks.take_shown()):
            _, name, on = self._waiting.pop(0)
            self._note_state(name, on)

    def _drop_waiting(self):
        """Forget all changes that wait."""
        if self._marks:
            self._marks.clear_changes()
            self._count_shown()
        self._waiting.clear()

    def show_outputs(self, on):
        """Switch the outputs off for an open door, and on again."""
        if self._marks:
            self._count_shown()
        for name in self._on:
            self._port.output(name, on)

    def _drop_last(self):
        """Forget the changes that wait for a motion that is not queued yet."""
        waiting, count = self._waiting, 0
        while count < len(waiting) and self._next_motion(waiting[-1 - count][0]) == self._queue.blocks_queued():
            count += 1
        if count:
            if self._marks:
                self._marks.withdraw_last(count)
            del waiting[len(waiting) - count :]

    def on_events(self, what):
        """Forget the changes that wait, and in a safe state switch all outputs off. A refusal drops those of the next motion only."""
        if what & REFUSAL:
            self._drop_last()
            return
        self._drop_waiting()
        if what & (SAFE | OFF | ANEW):
            self.halt()

    def halt(self):
        """Switch all outputs off, and forget the changes that wait."""
        self._drop_waiting()
        for name in self._on:
            self._port.output(name, False)
        self._on.clear()
