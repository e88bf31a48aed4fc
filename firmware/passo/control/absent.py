"""Stands where a part of the control is not loaded, because no link's language needs it: nothing is ever under way."""


class Absent:
    kind = ""  # as of Pauses
    drawing = False  # as of Objects, and `store`
    count = coolant = 0

    def __init__(self, lift=None):
        self.jogging = self.dropping = False
        self.lift = lift
        self.store = self

    def handlers(self):
        return {}

    def _nothing(self, about=None):
        return None

    def poll(self, now_ms=0):
        """Nothing to do, and no garbage left by it."""

    def free(self):
        return 0

    count_drawn = free
    busy = end = dropped = _nothing
    active = begin = standing = substate = laser = _nothing
    show_outputs = switch_off = report = clear = restart = _nothing
