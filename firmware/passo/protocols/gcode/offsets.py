"""Work coordinates: the offsets between the machine's zero and the programme's, in nanometres of each axis.

    programme position = machine position − (G54 … G59, the one selected) − G92 − tool length (Z only)

G54 … G59, G28, G30 and the lengths of tools are kept by `memory` (get(key) → text or None, put(key, text)); G92 and the tool length are
forgotten by a reset. One object serves all links of a machine.
"""

from micropython import const

SYSTEMS = const(6)
TOOL_AXIS = const(2)


class Offsets:
    def __init__(self, axes, memory):
        self._axes = axes
        self._memory = memory
        self.version = 0  # goes up with each change
        self._reference = None  # the height at which the first tool touched the sensor
        self.load()

    def load(self):
        """Load all offsets from the memory; those that it does not have are 0."""
        self.systems = [self._recall_positions("G%d" % (54 + number)) for number in range(SYSTEMS)]
        self.homes = {28: self._recall_positions("G28"), 30: self._recall_positions("G30")}
        self.reset_shift()

    def reset_shift(self):
        """Forget G92 and the tool length."""
        self.shift = [0] * self._axes  # G92
        self.tool = 0
        self.version += 1

    def offset_of(self, system, axis):
        """Return machine position − programme position of `axis`, nm, with G54 + `system` selected."""
        offset = self.systems[system][axis] + self.shift[axis]
        return offset + self.tool if axis == TOOL_AXIS else offset

    def set_system(self, system, positions):
        """Keep the offsets of G54 + `system`, nm."""
        self.systems[system] = positions
        self._keep_positions("G%d" % (54 + system), positions)

    def set_home(self, number, positions):
        """Keep the position of G`number`, 28 or 30, nm."""
        self.homes[number] = positions
        self._keep_positions("G%d" % number, positions)

    def set_shift(self, positions):
        """Set the offsets of G92, nm."""
        self.shift = positions
        self.version += 1

    def set_tool(self, length):
        """Set the tool length, nm."""
        self.tool = length
        self.version += 1

    def length_of(self, tool):
        """Return the length of a tool in the table as text, nm; None if it is not there."""
        return self._memory.get("T%d" % tool)

    def set_length(self, tool, length):
        """Put a tool's length, nm, into the table."""
        self._memory.put("T%d" % tool, str(length))

    def measure_tool(self, position):
        """Set the tool length from the machine position of Z, nm, at which the tool has touched the sensor. The first one is the reference of the
        others."""
        if self._reference is None:
            self._reference = position
        self.set_tool(position - self._reference)

    def _recall_positions(self, key):
        """Return the positions kept by a key; 0 for those missing."""
        try:
            positions = [int(part) for part in (self._memory.get(key) or "0").split(",")]
        except ValueError:
            positions = []
        return (positions + [0] * self._axes)[: self._axes]

    def _keep_positions(self, key, positions):
        """Keep positions by a key."""
        self._memory.put(key, ",".join([str(position) for position in positions]))
        self.version += 1
