"""The event log: the last refusals and alarms by number, for every status report and for whoever asks afterwards."""

from micropython import const

_SIZE = const(32)


class Log:
    def __init__(self):
        self.entries = []  # (machine milliseconds, number, who), oldest first, at most 32
        self.last = 0  # the latest number nobody has read; 0: none
        self.pins = None  # a function: what the interlock's inputs have done; None: there is none
        self.counts = {}  # of each number: how many times since the start

    def add(self, now_ms, number, who=""):
        if len(self.entries) >= _SIZE:
            self.entries.pop(0)
        self.entries.append((now_ms, number, who))
        self.counts[number] = self.counts.get(number, 0) + 1
        self.last = number
