"""Digital outputs for the programme, M62 to M65: those that the board file names p0 … p9.

M64 and M65 switch at once. M62 and M63 switch as the next motion begins, without a stand: the cycle of the main loop that finds the
motion before it played to its end does it, so 15 ms behind that at most on a chip. G4, a tool's time and parking
are no motion, as in LinuxCNC. If no motion follows, nothing happens. Whatever drops the queue drops what waits for it.

A hold leaves them as they are. The door switches them off until the machine goes on; every alarm, stop and reset for good.
"""

from micropython import const

from passo import commands, errors
from passo.control.feature import ANEW, OFF, QUEUE_GONE, SAFE, WORK_GONE, Feature
from passo.motion.block import WAIT
from passo.records import COUNT_HALF, COUNT_MASK, QUEUE_SIZE, ROW_KIND, SCRATCH_STRIDE

_MOST = const(16)  # changes that wait


class DigitalOutputs(Feature):
    heeds = QUEUE_GONE | WORK_GONE | SAFE | OFF | ANEW

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._port = machine.port
        self._names = [item["name"] for item in board["outputs"]]
        self._on = {}  # by name, of those that have been switched on
        self._waiting = []  # [count of the block that it comes with, name, on]

    def handlers(self):
        return {commands.CODE + code: self._switch for code in range(62, 66)}

    def _switch(self, command):
        machine = self._machine
        name = "p%d" % command.value
        if name not in self._names:
            return errors.NUMBER_RANGE
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        code = command.kind - commands.CODE
        if machine.command is not None or len(self._waiting) >= _MOST or code < 64 and self._queue.chords:  # behind the last of them
            return errors.LATER
        if machine.checking:
            return machine.accepted(command)
        on = code in (62, 64)
        if code >= 64:
            self._put(name, on)
        else:
            self._waiting.append([self._queue.added(), name, on])
        return machine.accepted(command)

    def _put(self, name, on):
        if on:
            self._on[name] = True
        else:
            self._on.pop(name, None)
        self._port.output(name, on)

    def poll(self, now_ms):
        waiting = self._waiting
        if self._machine.away:  # the queue's counts are parking's
            return
        for item in waiting:
            item[0] = self._motion(item[0])
        while waiting and self._begun(waiting[0][0]):
            _, name, on = waiting.pop(0)
            self._put(name, on)

    def _motion(self, count):
        """Return the number of the first block from `count` on that moves."""
        queue = self._queue
        planner = queue.planner
        while count != queue.added() and planner.rows[count % QUEUE_SIZE * planner.scratch[SCRATCH_STRIDE] + ROW_KIND] == WAIT:
            count = (count + 1) & COUNT_MASK
        return count

    def _begun(self, count):
        """True if block number `count` has been queued, and those before it have been played."""
        queue = self._queue
        ready = (queue.retired() - count) & COUNT_MASK < COUNT_HALF
        return ready and queue.added() != count and (queue.retired() != count or not queue.silent())

    # --- stops

    def show_outputs(self, on):
        for name in self._on:
            self._port.output(name, on)

    def heed(self, what):
        self._waiting.clear()
        if what & (SAFE | OFF | ANEW):
            self.halt()

    def halt(self):
        self._waiting.clear()
        for name in self._on:
            self._port.output(name, False)
        self._on.clear()
