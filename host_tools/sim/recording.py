"""The files that a machine with a plant writes: a trace, and the pins as VCD.

    files = Recording(board, plant, trace="job.csv", vcd=None)
    files.world     # receiver of the pins: the plant, or a VcdTap before it
"""

from host_tools.sim.trace import Trace


class Recording:
    def __init__(self, board, plant, trace, vcd):
        """`trace`: a path, True to keep it in memory, None for none; `vcd`: a path or None."""
        self._files = []
        self.trace = None
        if trace is not None:
            self.trace = Trace(None if trace is True else trace, plant)
            self._files.append(self.trace)
        self.world = plant
        if vcd is not None:
            from host_tools.sim.vcd import VcdTap

            self.world = VcdTap(vcd, board, plant)
            self._files.append(self.world)

    def flush(self):
        for file in self._files:
            file.flush()

    def close(self):
        """Close the files; the second time there are none."""
        while self._files:
            self._files.pop().close()
