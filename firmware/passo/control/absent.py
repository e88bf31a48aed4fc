"""Stands where a part of the control is not loaded, because no link's language needs it: nothing is ever under way."""


class Absent:
    kind = ""  # as of Pauses

    def __init__(self):
        self.jogging = self.dropping = False

    def handlers(self):
        return {}

    def _nothing(self, *about):
        return None

    active = standing = substate = laser = _nothing
    show_outputs = poll = report = clear = restart = _nothing
