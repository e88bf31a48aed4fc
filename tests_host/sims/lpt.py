"""The router that LPTControl drove, on the virtual port: stepped, lines in memory, and the history of its steps.

    machine = Lpt()
    machine.play("[ +1000 AAAA ]")
    machine.world.path                  # [(tick, x, y, z, tool)]

Small enough for MicroPython.
"""

from boards.lpt_router import BOARD
from passo.app import App
from passo.config.boardfile import check
from passo.ports.virtual import VirtualPort
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW, frame
from passo.protocols.pulses.report import status_from
from router import World


class Slots:
    """The journal's pages of flash."""

    BLOCKS = 2
    SLOTS = 16

    def __init__(self):
        self._written = {}

    def read(self, block, slot):
        return self._written.get((block, slot), b"\xff" * 32)

    def write(self, block, slot, data):
        assert (block, slot) not in self._written, "a page that is not erased"
        self._written[block, slot] = data

    def erase_block(self, block):
        for slot in range(self.SLOTS):
            self._written.pop((block, slot), None)


class Lpt:
    def __init__(self, folder=None, pages=None, jobs=None, more=(), **config):
        """`folder`: of stored jobs; `pages`: the journal's; `jobs`: more keys of their section; `more`: inputs; `config`: keys of the
        section step_program."""
        board = dict(BOARD)
        board["inputs"] = BOARD["inputs"] + list(more)
        if folder:
            board["jobs"] = {"language": "pulses", "folder": folder}
            board["jobs"].update(jobs or {})
        if pages:
            board["journal"] = {"every_ms": 100}
        board = check(board)
        board["step_program"].update(config)
        board = check(board)  # its settings follow
        self.board = board
        self.world = World((0, 0, 0))
        self.world.switches.update({"stop": 0, "job": 1})
        self.world.path = []
        self.port = VirtualPort(board, self.world)
        self.port.pages = pages
        self.app = App(board, self.port)
        self.steps = self.app.controller.features["step_program"]
        self.line = self.port.lines["pc"]
        self.heard = ""
        self.acks = 0
        self.cycle()
        assert self.take() == ["ready"]

    # --- the wire

    def cycle(self):
        self.app.cycle()
        data = self.line.outgoing
        self.line.outgoing = b""
        self.acks += data.count(ACK)
        self.heard += data.replace(ACK, b"").decode()

    def take(self):
        """The lines said since the last time."""
        lines = self.heard.split("\n")
        self.heard = lines.pop()
        return lines

    def put(self, data):
        self.line.incoming += data if isinstance(data, bytes) else data.encode()

    def until(self, wanted, turns=400_000):
        """Turn until a line begins with `wanted`; return all lines up to it."""
        said = []
        while turns:
            said += self.take()
            for line in said:
                if line.startswith(wanted):
                    return said
            self.cycle()
            turns -= 1
        raise AssertionError("no %r: %r" % (wanted, said))

    def tell(self, *words):
        """A control command that must be ok."""
        self.put(frame(*words))
        said = self.answer()
        assert said[-1].startswith("ok"), (words, said)
        return said

    def answer(self):
        """Lines up to the next ok or error."""
        said = []
        for _ in range(200_000):
            said += self.take()
            if said and (said[-1].startswith("ok") or said[-1].startswith("error")):
                return said
            self.cycle()
        raise AssertionError("no answer: %r" % said)

    def ask(self, *words):
        """The answer to a control command."""
        self.put(frame(*words))
        return self.answer()[-1]

    def status(self):
        self.put(frame("?"))
        for line in self.until("<"):
            if line.startswith("<"):
                return status_from(line)

    # --- files

    def send(self, text, verb):
        """A file with flow control; the answer to {end}, or the error that came before."""
        data = text if isinstance(text, bytes) else text.encode()
        self.tell(verb, len(data))
        self.put(b"\n")
        self.acks = 0
        sent = 0
        while sent < len(data):
            room = WINDOW + self.acks * CREDIT - sent
            if room:
                self.put(data[sent : sent + room])
                sent += len(data[sent : sent + room])
            self.cycle()
            for line in self.take():
                if line.startswith("error"):
                    return line
        return self.ask("end")

    def load(self, text):
        said = self.send(text, "load")
        assert said.startswith("ok"), said
        return int(said[3:])

    def play(self, text, times=1):
        """Load and run a file to its end."""
        self.load(text)
        self.tell("run", times)
        self.until("end")

    def run_ms(self, milliseconds):
        end = self.port.now + milliseconds * 12_500
        while self.port.now < end:
            self.cycle()

    def settle(self):
        """Until nothing moves."""
        self.cycle()
        while self.steps.may_change():
            self.cycle()

    def picture(self):
        """[(x, y, z, tool)] after each step."""
        return [row[1:] for row in self.world.path]
