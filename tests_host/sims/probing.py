"""Something that a probe runs into, for the plants of tests: it closes the probe's circuit and remembers where."""


class Wall:
    """Behind `steps` of one axis, on the side of `sign` (1: it is met on the way up). `steps` can be moved."""

    def __init__(self, axis, steps, sign):
        self.axis = axis
        self.steps = steps
        self.sign = sign
        self.met = []  # the machine's position at each change, contact or its end
        self._touches = False

    def touches(self, position):
        """The method of host_tools.sim.stock.Stock."""
        touches = (position[self.axis] - self.steps) * self.sign >= 0
        if touches != self._touches:
            self._touches = touches
            self.met.append(list(position))
        return touches


def said(received, steps_mm):
    """The position of the last [PRB:…] in steps, and whether it touched."""
    place, touched = received.decode().split("[PRB:")[-1].split("]")[0].split(":")
    return [round(float(each) * by) for each, by in zip(place.split(","), steps_mm)], touched == "1"
