"""A machine whose features are polled only while something is under way says and does what one says whose features are always polled."""

from fuzz_grbl import Fuzz

CASES = {"check_sleep_changes_nothing": (("seed", "seed"),)}
RUNS = {"check_sleep_changes_nothing": 10}


class Watched(Fuzz):
    """`sleepless`: features are polled in every cycle."""

    def __init__(self, seed, sleepless):
        self.sleepless = sleepless
        self.slept = 0
        self.wrong = False  # it slept while something was under way
        Fuzz.__init__(self, seed)

    def _turn(self, data=b""):
        machine = self.controller.machine
        machine.awake = machine.awake or self.sleepless
        result = Fuzz._turn(self, data)
        if not machine.awake:
            self.slept += 1
            self.wrong = self.wrong or not self.controller.queue.still() or machine.command is not None or bool(machine.hold)
        return result

    def made(self):
        self.log = []
        try:
            self.run(40)
        except AssertionError:  # check_fuzz.py reports the faults of lines
            pass
        port = self.port
        return self.log, port.words, port.stepping, port.marks, self.lines, self.refused, self.resets


def check_sleep_changes_nothing(seed):
    sleepy = Watched(seed, False)
    assert sleepy.made() == Watched(seed, True).made()
    assert sleepy.slept and not sleepy.wrong
