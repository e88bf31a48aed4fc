"""A virtual board that is asked line by line, as a sender does that waits for each answer."""

from host_tools.sim.machine import VirtualMachine


class Asked:
    def __init__(self, board, **options):
        self.machine = VirtualMachine(board, **options)
        self.plant = self.machine.plant
        self.machine.run_ms(100)
        self.machine.take()

    def ask(self, line, limit_ms=120_000):
        """The answer to a line of G-code: up to `ok`, an error or an alarm."""
        self.machine.take()
        self.machine.send(line.encode() + b"\n")
        self.machine.run_until(lambda: any(word in self.machine.replies_so_far() for word in (b"ok", b"error", b"ALARM")), limit_ms)
        return self.machine.take().decode().strip()

    def do(self, *lines):
        for line in lines:
            said = self.ask(line)
            assert said.endswith("ok"), (line, said)

    def stand(self):
        """Until nothing moves; the plant has met no end."""
        self.machine.settle()
        assert not self.plant.errors, self.plant.errors
