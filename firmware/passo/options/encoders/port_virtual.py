"""Encoders on the virtual port."""

from passo.options.encoders.port import Encoders
from passo.records import COUNT_MASK, TICKS_PER_MS

CHECK_TICKS = 3 * TICKS_PER_MS  # between two checks, as on an RP2040


class VirtualEncoders(Encoders):
    """The world counts: encoder(number) for each entry of the board file's `encoders`, in their order."""

    def __init__(self, board, port, world):
        Encoders.__init__(self, board, port)
        self._encoder = world.encoder
        self.due = CHECK_TICKS  # tick of the next check
        levels = {item["name"]: item["active"] for item in board["inputs"]}
        for number in range(len(board["encoders"])):
            name = board["encoders"][number]["index"]
            if name:
                self._watch_index(world, self.add_index(number, name), levels[name])

    def _watch_index(self, world, index, active):
        """Have the world call on_edge() at each active edge of an index's input."""
        world.listen(lambda tick, name, level: name == index.name and level == active and index.on_edge(None))

    def read(self, counts):
        """Write the world's counts, modulo 2²⁹, to `counts`."""
        for number in range(len(counts)):
            counts[number] = self._encoder(number) & COUNT_MASK

    def run(self, tick):
        """Check, if CHECK_TICKS have passed."""
        if tick >= self.due:
            self.due = tick + CHECK_TICKS
            self.check()


def create(board, port, world):
    """Return the port's part, which the port runs every CHECK_TICKS."""
    made = VirtualEncoders(board, port, world)
    port.clocked.append(made)
    return made
