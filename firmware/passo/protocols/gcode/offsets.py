"""Work coordinates: the offsets between the machine's zero and the programme's, in nanometres of each axis.

    programme place = machine place − (G54 … G59, the one selected) − G92 − tool length (Z only)

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
        self._reference = None  # where the first tool touched the sensor
        self.load()

    def load(self):
        """Everything as the memory has it; what it has not is 0."""
        self.systems = [self._recall("G%d" % (54 + number)) for number in range(SYSTEMS)]
        self.homes = {28: self._recall("G28"), 30: self._recall("G30")}
        self.reset()

    def reset(self):
        self.shift = [0] * self._axes  # G92
        self.tool = 0
        self.version += 1

    def of(self, system, axis):
        """Machine place − programme place of `axis` with G54 + `system` selected."""
        offset = self.systems[system][axis] + self.shift[axis]
        return offset + self.tool if axis == TOOL_AXIS else offset

    def set_system(self, system, places):
        self.systems[system] = places
        self._keep("G%d" % (54 + system), places)

    def set_home(self, number, places):
        """`number` 28 or 30."""
        self.homes[number] = places
        self._keep("G%d" % number, places)

    def set_shift(self, places):
        self.shift = places
        self.version += 1

    def set_tool(self, length):
        self.tool = length
        self.version += 1

    def length_of(self, tool):
        """The length of a tool in the table as text, in nanometres; None if it is not there."""
        return self._memory.get("T%d" % tool)

    def set_length(self, tool, length):
        """Put a tool into the table."""
        self._memory.put("T%d" % tool, str(length))

    def measured(self, place):
        """A tool has touched the sensor at this machine place of Z: the first is the reference of the others."""
        if self._reference is None:
            self._reference = place
        self.set_tool(place - self._reference)

    def _recall(self, key):
        text = self._memory.get(key)
        try:
            places = [int(part) for part in text.split(",")] if text else []
        except ValueError:
            places = []
        return (places + [0] * self._axes)[: self._axes]

    def _keep(self, key, places):
        self._memory.put(key, ",".join([str(place) for place in places]))
        self.version += 1
