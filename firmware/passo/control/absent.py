"""Stands where a part of the control is not loaded, because no link's language needs it: nothing is ever under way."""


class Absent:
    kind = ""  # as of Pauses

    def __init__(self):
        self.jogging = self.dropping = False

    def handlers(self):
        return {}

    def _nothing(self, *about):
        return None

    def poll(self, now_ms=0):
        """Nothing to do, and no garbage left by it."""

    active = begin = standing = substate = laser = _nothing
    show_outputs = report = clear = restart = _nothing
