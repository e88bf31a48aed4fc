"""A line of its own beside the queue, at the stand of a hold: parking takes it, and the block under way goes on behind it.

    detour = Detour(feeder, player)
    detour.begin([0, 0, 400], 5_000_000, tool, power, tag)      # steps of each axis, nm/s; only at a stand
    detour.is_done()                                            # it has been played to its end
    detour.end()                                                # the queue is as it was, and held

Between begin() and end() nothing may be queued: the queue has no room. The queue stays as it was; the row behind it is lent, and the fields
of planner, ramp and feeder for the block under way are kept here. A hold meanwhile stops the line, and end() drops the rest of it. If all
is dropped, forget_line(). Costs 2 kB of memory while it lasts.
"""

from passo.records import *

# Of the feeder's state, what belongs to the block under way.
_BLOCK = (FEED_INDEX, FEED_ROW, FEED_LEFT, FEED_WAIT, FEED_FAST, FEED_KIND, FEED_BEGINS)
# Of the planner's scratch, what may change meanwhile.
_LIVE = (SCRATCH_PERCENT, SCRATCH_PERCENT + 1, SCRATCH_FACTOR, SCRATCH_FACTOR + 1, SCRATCH_EAGER)


class Detour:
    def __init__(self, feeder, player):
        self._feeder = feeder
        self._player = player
        self._kept = None

    def begin(self, deltas, nm_s, tool, power, tag):
        """Begin a line of `deltas` steps at nm_s. Raises ValueError if the planner refuses it."""
        feeder = self._feeder
        planner = feeder.planner
        planner.fits(deltas, 0, nm_s)
        fed = self._close_feeder()
        state, indices, scratch, ramp = feeder.state, planner.indices, planner.scratch, feeder.ramp
        stride = scratch[SCRATCH_STRIDE]
        at = indices[QUEUE_ADDED] % QUEUE_SIZE * stride
        self._kept = (
            [state[field] for field in _BLOCK], state[FEED_LEVELS] & state[FEED_TOOL], indices[:], scratch[:], at, planner.rows[at : at + stride],
            planner.line_state[:], ramp.state[:], planner.power, planner.dynamic, feeder._geometry,
        )  # fmt: skip
        state[FEED_LEFT] = state[FEED_WAIT] = state[FEED_FAST] = state[FEED_BEGINS] = 0
        state[FEED_KIND] = KIND_WAIT
        ramp.stall()
        for field in (QUEUE_FETCHED, QUEUE_FLUSHED, QUEUE_FROZEN, QUEUE_ARC):
            indices[field] = indices[QUEUE_ADDED]  # of QUEUE_ARC: no room, once the line is there
        scratch[SCRATCH_THROUGH] = 0
        scratch[SCRATCH_ASKED] = -1
        planner.set_power(power, False)
        if any(deltas):
            planner.line(deltas, 0, tool, tag, True, nm_s)
        else:
            planner.wait(2 * feeder.min_word_ticks, tool, tag)
        planner.flush()
        feeder.set_hold(False)
        feeder.open = fed

    def is_done(self):
        """Return True once the line has been played to its last word."""
        state = self._feeder.state
        indices = self._feeder.planner.indices
        return indices[QUEUE_FETCHED] == indices[QUEUE_ADDED] and not state[FEED_LEFT] and not state[FEED_WAIT] and not self._player.busy()

    def end(self):
        """Take up the queue where it was, and hold it. Only at a stand."""
        feeder = self._feeder
        planner = feeder.planner
        fed = self._close_feeder()
        state, scratch = feeder.state, planner.scratch
        block, lit, indices, before, at, row, path, cuts, power, dynamic, feeder._geometry = self._kept
        self._kept = None
        for number in range(len(_BLOCK)):
            state[_BLOCK[number]] = block[number]
        state[FEED_LEVELS] = state[FEED_LEVELS] & ~state[FEED_TOOL] | lit
        state[FEED_POWER] = POWER_UNKNOWN
        live = [scratch[field] for field in _LIVE]
        for there, kept in ((planner.indices, indices), (scratch, before), (planner.line_state, path), (feeder.ramp.state, cuts)):
            there[:] = kept
        for number in range(len(_LIVE)):
            scratch[_LIVE[number]] = live[number]
        planner.rows[at : at + len(row)] = row
        planner.set_power(power, dynamic)
        feeder.set_hold(True)
        feeder.open = fed

    def forget_line(self):
        """Forget the line and the queue: everything has been dropped."""
        self._kept = None

    def _close_feeder(self):
        """Stop interrupts from feeding, and retire the blocks played. Returns whether they may feed again."""
        feeder = self._feeder
        fed = feeder.open
        feeder.open = False
        feeder.retire(self._player.words_played())
        return fed
