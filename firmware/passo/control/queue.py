"""The commands handed to the planner: the position and the tool at their end, and how to drop them.

Positions are steps of each axis from machine position zero.
"""

from array import array

import micropython

from passo.motion.row_viper import room
from passo.records import QUEUE_ADDED, QUEUE_RETIRED, ROW_DYNAMIC, SEEN_FIELDS, SEEN_LIT, SEEN_ROOM
from passo.steps.word import TICKS_PER_MS, TICKS_PER_S


class Queue:
    def __init__(self, board, planner, feeder, player, port):
        self._board = board
        self._axes = board["axes"]
        self._planner = self.planner = planner  # the second for plain lines, see Program.followed(), and for the journal
        self._feeder = feeder
        self._player = player
        self.analogue = feeder.ring.power
        self.power = port.power if board["spindle"]["pwm"] else int  # power(level): show it, 0 … 1000, at once; int() does nothing: there is no output
        self._origin = array("i", [0] * len(self._axes))
        self.here = self._origin[:]  # see look()
        self.seen = array("i", [0] * SEEN_FIELDS)
        self.target = array("i", [0] * len(self._axes))  # the position at the queue's end: one array, which kernels write too
        self._deltas = [0] * len(self._axes)  # of the line being added
        self._rested = None  # the tool bit that rest() has shown, and the words played then
        self._rested_at = 0
        self.tool = False  # the tool bit at the queue's end
        self.waiting = False  # something is queued that has not been released to the feeder yet
        self._walker = None  # of axes that run on their own, see take_walker()
        self.arcs = None  # the arithmetic of arcs for languages; None if this board has no memory for them
        self.chords = None  # of an arc that is handed to the planner piece by piece, see StreamQueue.feed()

    def position(self, edge=None):
        """Return the machine's position, exact at this moment, or at the moment of `edge`, a Latch."""
        return list(self.position_view(edge))

    def position_view(self, edge=None):
        """Return position() in an array shared with the feeder, which the next question to it overwrites: allocates nothing."""
        return self._from_origin(self._feeder.position_view(self._player.words_played(), edge))

    def look(self, played=None):
        """Read the machine's position and state at one moment: `here`, the position, and `seen` (SEEN_…), good until the next look."""
        if played is None:
            played = self._player.words_played()
        seen = self.seen
        self._feeder.look(played, self._origin, self.here, seen)
        if self.chords:
            seen[SEEN_ROOM] = 0
        if self._rested is not None and self._rested_at == played:
            seen[SEEN_LIT] = self._rested

    def _from_origin(self, found):
        """Shift a position since power-up to machine zero, in place, and return it. Steps."""
        origin = self._origin
        for axis in range(len(found)):
            found[axis] -= origin[axis]
        return found

    def set_origin(self, axes=-1):
        """Make this position machine zero, for the axes of a mask. Only at a stand, with nothing queued."""
        found = self._feeder.position_view(self._player.words_played())
        for axis in range(len(found)):
            if axes >> axis & 1:
                self._origin[axis] = found[axis]
            self.target[axis] = found[axis] - self._origin[axis]

    def shift(self, axis, steps):
        """Correct the position: an axis stands `steps` further than has been stepped. Only at a stand; the target stays."""
        self._origin[axis] -= steps

    @micropython.native
    def room(self):
        """Return how many more blocks can be queued now; none behind an arc that is not all queued yet."""
        return 0 if self.chords else room(self._planner.indices)

    @micropython.native
    def empty(self):
        """Return True if the planner has no block left and no arc is being queued."""
        return self._planner.empty() and not self.chords

    @micropython.native
    def still(self):
        """Return True when everything queued has been played to its last tick."""
        indices = self._planner.indices
        return indices[QUEUE_ADDED] == indices[QUEUE_RETIRED] and not self.chords and not self._player.busy()

    def standing(self):
        """Return True when a hold has come to its stand."""
        return self._feeder.standing() and not self._player.busy()

    def blocks_queued(self):
        """Return how many blocks have been queued since the start, modulo 2²⁹."""
        return self._planner.indices[QUEUE_ADDED]

    def retire(self):
        """Notice at once which blocks have been played: the feeder looks only when it makes words."""
        feeder = self._feeder
        fed = feeder.open
        feeder.open = False  # an interrupt that feeds leaves it alone meanwhile
        feeder.retire(self._player.words_played())
        feeder.open = fed

    def blocks_played(self):
        """Return how many blocks have been played to their last word, modulo 2²⁹."""
        return self._planner.indices[QUEUE_RETIRED]

    def silent(self):
        """Return True while nothing plays."""
        return not self._player.busy()

    def flush(self):
        """Release all that is queued: nothing follows it. Of an arc in chords, behind the last one."""
        self.waiting = False
        if self.chords:
            self.chords.flush = True
        else:
            self._planner.flush()

    def inside(self, target):
        """Return True if `target` (steps) is within the machine's travel."""
        for axis in range(len(target)):
            low, high = self.reach(axis)
            if not low <= target[axis] <= high:
                return False
        return True

    def reach(self, axis):
        """Return the (lowest, highest) position of an axis in steps. One that homes at its high end has its zero there."""
        config = self._axes[axis]
        homing = self._board["homing"]
        if homing and config["name"] in homing["high_end"]:
            return -config["travel_steps"], 0
        return 0, config["travel_steps"]

    # --- adding

    def tool_ms(self, on):
        """Return how long a change of the tool takes, ms: tool.on_ms or tool.off_ms."""
        return self._board["tool"]["on_ms" if on else "off_ms"]

    def tool_ticks(self, on):
        """Return the ticks that a change of the tool takes, at least one, so that it shows on the pin."""
        return max(self.tool_ms(on) * TICKS_PER_MS, 2 * self._feeder.min_word_ticks)

    def set_tool(self, on, tag):
        """Queue a change of the tool and the time it takes. `tag`: the number of its block."""
        self.tool = on
        self._planner.wait(self.tool_ticks(on), on, tag)
        self.waiting = True

    def lift(self, tag=0):
        """Queue the tool off, and the time it takes, if it is on at the queue's end."""
        if self.tool:
            self.set_tool(False, tag)

    def line(self, target, ticks, tool, tag, rapid=False):
        """Queue a line to `target` (steps, the first axes) that lasts ticks(deltas). Raises ValueError if the planner cannot."""
        if tool != self.tool:
            self._change_tool(tool, tag)
        deltas = self.deltas(target)
        self._planner.line(deltas, ticks(deltas), tool, tag, rapid)
        self.lead(target)
        self.waiting = True

    def deltas(self, target):
        """Return the steps of each axis from the queue's end to `target`, in a list that the next call overwrites."""
        deltas = self._deltas
        here = self.target
        count = len(target)
        for axis in range(len(deltas)):
            deltas[axis] = target[axis] - here[axis] if axis < count else 0
        return deltas

    def lead(self, target):
        """Set `target`: the queue ends at `target` (the first axes)."""
        here = self.target
        for axis in range(len(target)):
            here[axis] = target[axis]

    def _change_tool(self, tool, tag):
        """Queue a change of the tool ahead of a motion; a tool that takes no time changes as the motion begins."""
        if tool != self.tool and self.tool_ms(tool):
            self.set_tool(tool, tag)
        self.tool = tool

    def travel(self, ways):
        """Queue one line: `ways` are (axis, steps, its highest speed in steps/s). Checks no travel, and leaves `target` to the
        caller."""
        deltas = [0] * len(self._axes)
        ticks = 0
        for axis, steps, steps_s in ways:
            deltas[axis] = steps
            ticks = max(ticks, abs(steps) * TICKS_PER_S // steps_s)
        self._planner.line(deltas, ticks, False, 0)
        self.flush()

    def axis(self, axis, edge=None):
        """Return the position of an axis, now or at the moment of `edge`, a Latch, in steps from the place where the machine was switched on."""
        return self._feeder.position_view(self._player.words_played(), edge)[axis]

    def begin(self):
        """Release what is queued: nothing more is coming for now. See StreamQueue."""

    def close(self):
        """Make no words until the app finds the motors ready: at a stand, before motion that may have to wake them. An
        interrupt that feeds may come before the app looks."""
        self._feeder.open = False

    def walk(self, walker):
        """Play a step program, whose walker has begun. Call settle() when it has been played."""
        self._planner.walk(walker, walker.tool)
        self.flush()

    def index(self):
        """Return the index in the step program under way, exact at this moment; None if there is none."""
        return self._feeder.index(self._player.words_played())

    def spot(self):
        """Return (index in the step program under way or None, position), of one moment; the position as of position_view()."""
        index, found = self._feeder.spot(self._player.words_played())
        return index, self._from_origin(found)

    def take_walker(self, walker):
        """From here on drop() clears this walker, too."""
        self._walker = walker

    def run(self, walker):
        """Play `walker` from now on. Leaves `target` to the caller."""
        walker.start()
        self._planner.walk(walker, self.tool)
        self.flush()

    def settle(self):
        """Set `target` to the position of the machine. Only at a stand."""
        self.lead(self.position_view())

    # --- stopping

    def halt(self):
        """Stop inside the word under way, the tool off; drop() is to follow."""
        self._feeder.open = False
        self._player.halt()
        self._rested = False
        self._rested_at = self._player.words_played()
        self.power(0)
        self._feeder.retire(self._player.words_played())

    def drop(self):
        """Drop everything, after halt() or at the stand of a hold. The position stays exact. The feeder makes no words until the app finds
        the motors ready: an interrupt that feeds would begin the planner's blocks anew.
        """
        self._feeder.open = False
        position = self._feeder.cancel(self._player.words_played())
        self._planner.clear()
        self.chords = None
        if self._walker is not None:
            self._walker.clear()
        self.power(0)
        self.tool = self.waiting = False
        for axis in range(len(position)):
            self.target[axis] = position[axis] - self._origin[axis]

    def dynamic(self):
        """Return True if the power of the block under way, or of the last one, follows the speed."""
        planner = self._planner
        at = planner.row()
        return planner.dynamic if at < 0 else planner.rows[at + ROW_DYNAMIC] > 0

    def restore_power(self):
        """Show the power of the last mark, as it counts now; at a stand it is none where it follows the speed."""
        if self._player.busy():
            self.power(self.analogue.level)
        else:
            self._show_power(not self.dynamic())

    def _show_power(self, on):
        """Show the power of the last mark, or none until the next. Only at a stand."""
        self.analogue.show(self._player.words_played(), on)
        self.power(self.analogue.level)

    def lend(self):
        """Return (feeder, player) to a feature that moves pins at a stand."""
        return self._feeder, self._player

    def hold(self, on):
        """Bring the machine to a stand, or let it go on."""
        self._feeder.set_hold(on)

    def lit(self):
        """Return True while the tool's bit is on at the pins."""
        played = self._player.words_played()
        if self._rested is not None and self._rested_at == played:
            return self._rested
        ring = self._feeder.ring
        return bool(ring.words[(played - 1) & ring.mask] & self._feeder.layout.tool_mask)

    def pins(self, tool):
        """Return the pins as the last word has left them, no step's pulse among them, and the tool on or off."""
        layout, ring = self._feeder.layout, self._feeder.ring
        levels = ring.words[(self._player.words_played() - 1) & ring.mask] & layout.levels_mask
        return levels & ~(layout.pulse_mask | layout.tool_mask) | (layout.tool_mask if tool else 0)

    def rest(self, tool):
        """Switch the tool's pin and power now, while the machine stands and nothing plays."""
        self._rested = tool
        self._rested_at = self._player.words_played()
        self._player.rest(self.pins(tool))
        if tool:
            self.restore_power()
        else:
            self._show_power(False)
