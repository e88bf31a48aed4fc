"""The mill of the soak: inputs that bounce, chatter, stick and break while it moves, judged by mill_inputs.Session."""

from mill_inputs import Session
from soak_bench import Bench

PERIOD = 60  # sequences a round
WHOLE = 4  # one machine in WHOLE has its gantry, encoders and inverter


class Mill(Bench):
    NAME = "mill"

    def __init__(self, seed):
        super().__init__(seed)
        self.session = Session(seed, whole=seed % WHOLE == 0)
        self.machine = self.session.machine

    def close(self):
        self.machine.close()

    @property
    def steps(self):
        return self.session.witness.steps

    def round(self):
        self.rounds += 1
        session = self.session
        for _ in range(PERIOD):
            before = dict(session.kinds)
            self.note(f"sequence {sum(before.values())}")
            session.sequence()
            for kind, count in session.kinds.items():
                if kind != "none" and count > before.get(kind, 0):
                    self.fault(f"input: {kind}")
        self.check_late()
        if self.rounds > 1:
            self.check_heap()
