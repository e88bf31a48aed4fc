"""Outputs that change with a step, on the virtual port: its player tells of each change at the tick of its word."""


class VirtualSwitches:
    def __init__(self, board, port, world):
        self._port = port
        self._world = world
        self._names = {entry["pin"]: entry["name"] for entry in board["outputs"]}

    def join(self, feeder, player):
        """Take the player."""
        self._player = player

    def show_switches(self, switches):
        """Have the player show the changes asked of `switches` from here on."""
        self._player.mark(switches, self._show_change)

    def _show_change(self, tick, value):
        """Give the world the level `value` & 1 of pin `value` >> 1 at a tick."""
        self._world.output(tick, self._names[value >> 1], value & 1)


def create(board, port, world):
    """Return the port's part."""
    return VirtualSwitches(board, port, world)
