"""The queue of a machine with lost motion (motion.py): positions are the axes', what the feeder counts the motors'.

Commands, travel, homing, halts and reports do not know of the play. A machine stopped while it takes up play knows where its axes are, and
the next block takes up the rest.
"""

from passo.control.stream_queue import StreamQueue


class Queue(StreamQueue):
    def __init__(self, board, planner, feeder, player, port):
        StreamQueue.__init__(self, board, planner, feeder, player, port)
        planner.follow_motors(self._motor_positions)
        self.play_taken = planner.play_taken

    def _motor_positions(self):
        """Return the motors' positions at this moment, in steps; the feeder's array."""
        return self._feeder.position_view(self._player.words_played())

    def _ask_undisturbed(self, ask):
        """Return ask(), called while no interrupt retires blocks: the position then belongs to the block retired last."""
        feeder = self._feeder
        fed = feeder.open
        feeder.open = False
        found = ask()
        feeder.open = fed
        return found

    def look(self):
        self._ask_undisturbed(self._look_at_queue)

    def _look_at_queue(self):
        """Retire the blocks played, take a look (see Queue.look()), and turn the motors' position into that of the axes."""
        played = self._player.words_played()
        self._feeder.retire(played)
        StreamQueue.look(self, played)
        self._planner.to_axes(self.here)

    def _since_start(self):
        """Return the axes' positions, in steps since power-up."""
        played = self._player.words_played()
        self._feeder.retire(played)
        return self._planner.to_axes(self._feeder.position_view(played))

    def position_view(self, edge=None):
        """Return the position in steps from the origin, or that at the edge which the Latch `edge` holds."""
        if edge:
            return self._from_origin(self._planner.to_axes(self._feeder.position_view(self._player.words_played(), edge)))
        return self._from_origin(self._ask_undisturbed(self._since_start))

    def axis(self, axis, edge=None):
        """Return an axis's position in steps since power-up; `edge`: see position_view()."""
        return self.position_view(edge)[axis] + self._origin[axis]

    def set_origin(self, axes=-1):
        """Let the axes of a mask count from here (-1: all)."""
        found = self._ask_undisturbed(self._since_start)
        for axis in range(len(found)):
            if axes >> axis & 1:
                self._origin[axis] = found[axis]
        self.settle()

    def drop(self):
        """Drop all that is queued; the axes stay where they are. Only once the player has stopped."""
        self.retire()
        self._planner.stop(self._motor_positions())
        StreamQueue.drop(self)
        self.settle()

    def room(self):
        """Return how many blocks fit in, one less than the planner says: a line may take two."""
        return max(StreamQueue.room(self) - 1, 0)
