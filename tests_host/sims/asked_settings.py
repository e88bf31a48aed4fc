"""A shipped board on the virtual port, its settings asked and set in the words of its own language.

    board = SettingBoard("torch_manipulator")
    board.say("$100=48.5")              # ["$100=48.500", "ok"]
    board = SettingBoard("torch_manipulator", board.slots)      # off and on again

Runs under CPython and MicroPython.
"""

from boards import lpt_router, plotter_2014, router_3axis, torch_manipulator, two_motor_kit
from passo.app import App
from passo.config.boardfile import check
from passo.config.journal import MemorySlots
from passo.ports.virtual import Nothing, VirtualPort
from passo.protocols.plotter import host as plotter
from passo.protocols.torch import protocol as torch
from passo.protocols.typed_words import line_of

BOARDS = {
    "torch_manipulator": torch_manipulator.BOARD, "plotter_2014": plotter_2014.BOARD, "lpt_router": lpt_router.BOARD,
    "two_motor_kit": two_motor_kit.BOARD,
    "router_3axis": dict(router_3axis.BOARD, journal=None, links=[dict(link, lost="go_on") for link in router_3axis.BOARD["links"]]),
}  # fmt: skip
_TURNS = 400


def copy(value):
    if isinstance(value, dict):
        return {key: copy(each) for key, each in value.items()}
    return [copy(each) for each in value] if isinstance(value, list) else value


def packets_of(line):
    """The plotter's packets of a line of text."""
    text = line.encode() + b"\n"
    text += b" \n"[: -len(text) % plotter.WORDS_BYTES]
    words = plotter.COMMANDS["WORDS"]
    return [
        plotter.packet(words, at // 3 << 8 | text[at], text[at + 1] << 8 | text[at + 2]) for at in range(0, len(text), plotter.WORDS_BYTES)
    ]


def frames_of(line):
    """The torch's frames of a line, one a character."""
    return [torch.passo(torch.LINE_OF, byte) for byte in line_of(line)]


class SettingBoard:
    def __init__(self, name, slots=None):
        data = check(copy(BOARDS[name]))
        data.pop("jobs", None)
        self.slots = slots or MemorySlots()
        self.port = VirtualPort(data, Nothing(), "stepped")
        self.app = App(data, self.port, None, self.slots)
        self.machine = self.app.controller.machine
        self.settings = self.machine.settings
        self.language = data["links"][0]["protocol"]
        self.line = self.port.lines[data["links"][0]["name"]]
        self.run_ms(100)
        self.line.outgoing = b""

    def run_ms(self, ms):
        for _ in range(ms // 5):
            self.app.poll()
            self.port.advance(5 * 12_500)

    def hear(self, data, ms=20):
        """Return the answer to bytes within `ms`."""
        self.line.outgoing = b""
        self.line.incoming += data
        self.run_ms(ms)
        return self.line.outgoing

    def say(self, line):
        """The lines of the answer."""
        if self.language == "plotter":
            parts = packets_of(line)
            for part in parts[:-1]:
                assert self.hear(part) == b"k"
            said = self.hear(parts[-1])
        elif self.language == "torch":
            said = b""
            for data in frames_of(line):
                said = self.hear(data, 10)
            said = b"".join([torch.answer_from(said[at : at + 17])[1]["text"].encode() for at in range(0, len(said), 17)])
        elif self.language == "pulses":
            said = self.hear(b"{" + line.encode() + b"}")
        else:
            said = self.hear(line_of(line) if self.language == "keys" else line.encode() + b"\n")
        return said.decode().replace("\r", "").split("\n")[:-1]
