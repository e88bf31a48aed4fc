"""Every number that a host may send, at the powers of two and ten and beside them: the same answer on every interpreter.

    MICROPYPATH=build/unix/STATE:tests_host/properties:tests_host/sims:. micropython tests_host/properties/every_number.py LANGUAGE [FIRST STEP]

LANGUAGE: grbl (each word of each kind of line, each setting, jogs), laser (rows of dots), plotter, torch, pulses or keys. Prints the checksum of all answers,
of
where the queue ends and how many words were made, after each; how many there were; and how many were refused. A refused line has made no step. FIRST and STEP
take every so-manyth only: a chip is slow.
"""

import sys
from binascii import crc32

from digest import Sink, board_named, checked
from passo import commands
from passo.app import App
from passo.commands import Command

OF_LINES = ("grbl", "laser")
TURNS = 12  # of 1 ms: until an answer has come, where one comes at once; longer than the silence before a frame
BOARDS = {
    "grbl": "router_3axis", "laser": "laser_xy", "plotter": "plotter_2014", "torch": "torch_manipulator", "pulses": "lpt_router", "keys": "two_motor_kit",
}  # fmt: skip

# `%s` is the number; the machine stands at zero before each.
LINES = (
    "G1X%sF1000", "G0Y%s", "G1Z-%sF500", "G1X1F%s", "G93G1X1F%s", "G1X1Y1Z-1F1000S%s", "M3S%s", "M4S%s", "G20G1X%sF50", "G20G1X.1F%s",
    "G2X1I%sF900", "G2X1Y1J%sF900", "G3X1Y1R%sF900", "G3X1Y1R-%sF900", "G2X1Y1I1P%sF900", "G18G2X1Z-1K%sF900", "G19G3Y1Z-1J%sF900", "G2X%sY%sR%sF900",
    "G4P%s", "T%s", "M6T%s", "G%s", "M%s", "N%sX1", "G10L2P1X%s", "G10L2P%sX1", "G10L%sP1X1", "G10L20P0Y%s", "G92Z%s", "G43.1Z%s",
    "G43H%s", "G10L1P1Z%s", "G81X1Z-1R%sF100", "G81X1Z-%sR0F100", "G82Z-1R0P%sF100", "G83Z-1R0Q%sF100", "G73Z-1R0Q%sF100", "G91G81X1Z-1R1L%sF100",
    "G64P%s", "G61P%s", "G38.2Z-%sF100", "G28X%s", "G53G0X%s", "M62P%s", "M63P%s", "M64P%s", "M65P%s", "M66P%s", "M66P0L%sQ1", "M66P0L3Q%s", "M3S100P%s", "D%s", "Q%s", "E%sX1", "A%s",
    "S%s", "F%s", "$J=X%sF100", "$J=G91X1F%s", "$%s", "$%s=1", "$N%s=G21", "$LINK=%s", "$JR=%s", "$ENC=%s",
)  # fmt: skip
LASER = (
    "M4G1X%sF900S0:5:3", "M3G1X-%sF900S0:5:3", "M4G1X3F%sS0:5:3", "M3G1X3F%sS0:5:3", "M4G1X3F900S%s", "M4G1X3F900S%s:1", "M3G1X3F900S1:%s:9",
    "M4G1X3F900S1:9:%s", "M3G1X%sY%sF900S7:8", "M4G1Y%sF900S1:2", "M4G0X%sS1:2", "G20M4G1X%sF50S1:2", "G93M4G1X1F%sS1:2", "M4S%s", "M3G2X1I%sF900S5",
    "M%sG1X1F900S1:2", "M4G1X1F900S1:2N%s",
)  # fmt: skip
SETTINGS = (
    0, 1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 20, 21, 22, 23, 24, 25, 26, 27, 30, 31, 32, 100, 101, 102, 110, 111, 112, 120, 121, 122, 130, 131, 132,
    140, 141,
)  # fmt: skip
PULSES = (
    "{load %s}", "{stream %s}", "{run %s}", "{repeat %s}", "{speed %s}", "{jog x %s}", "{jog x -%s y 5}", "{link %s}", "{step %s}", "{return %s}",
)  # fmt: skip


def whole():
    """Powers of two and their neighbours, up to beyond what any field holds."""
    for power in range(41):
        for by in (-1, 0, 1):
            yield (1 << power) + by


def texts():
    for number in whole():
        yield "%d" % number
    for power in range(-8, 16):
        ten = "0." + "0" * (-power - 1) + "1" if power < 0 else "1" + "0" * power
        yield ten
        yield ten + "5" if power < 0 else ten + ".5"
        yield "-" + ten
        yield "9" * (power + 1) if power >= 0 else "0." + "0" * -power + "9"


def grbl():
    for line in LINES:
        for text in texts():
            yield (line.replace("%s", text) + "\n").encode()
    for setting in SETTINGS:
        for text in texts():
            yield ("$%d=%s\n" % (setting, text)).encode()


def laser():
    for line in LASER:
        for text in texts():
            yield (line.replace("%s", text) + "\n").encode()
    for setting in (30, 31, 32):
        for text in texts():
            yield ("$%d=%s\n" % (setting, text)).encode()


def plotter():
    """x and y have 16 bits; each command with each of them, and each byte of a command."""
    from passo.protocols.plotter import protocol

    def packet(command, x, y):
        data = bytes((command, x >> 8, x & 255, y >> 8, y & 255))
        return data + bytes((sum(data) & 255,))

    numbers = sorted({number & 0xFFFF for number in whole()})
    for name in (
        "REQUEST", "LINE", "MOVE", "END", "ORIGIN", "SET_SPEED", "UP", "LEFT", "DOWN", "RIGHT", "HALT", "ASK", "LINK", "WORDS",
    ):  # fmt: skip
        command = getattr(protocol, name)
        for number in numbers:
            yield packet(command, number, 3)
            yield packet(command, 5, number)
    for command in range(256):
        yield packet(command, 1, 2)


def torch():
    from passo.options.weaving.language_torch import weave
    from passo.protocols.torch import protocol

    connect = protocol.frame("CONNECT")
    numbers = sorted({sign * number & 0xFFFFFFFF for number in whole() for sign in (-1, 1)})
    numbers = [number - (1 << 32) if number >> 31 else number for number in numbers]
    for number in numbers:
        for place in range(4):
            values = [100, 480, 255, 830]
            values[place] = number
            for make in (protocol.move, protocol.configure):
                try:
                    data = make(*values)
                except (OverflowError, ValueError):
                    data = b""
                yield connect + data
            yield connect + protocol.frame("MOVE", protocol.integers(*values))
        yield connect + weave((number & 255, 500, 900, 40, 40, number & 1), number, 9000, 500)
        yield connect + weave((1, number, 900, 0, 0, 0), 9000, 9000, 5000)
        yield connect + weave((1, 500, number, 0, 0, 0), 9000, 9000, 5000)
        yield connect + weave((2, 500, 900, number, 0, 1), 9000, number, 5000)
        yield connect + weave((3, 500, 900, 0, number, 0), 9000, 0, number)
        yield connect + weave((1, 500, 900, 0, 0, 0), 9000, 0, 5000, (4500, number))
    for what in range(256):
        for value in (0, 1, 2, 127, 128, 255):
            yield connect + protocol.passo(what, value)


def pulses():
    for line in PULSES:
        for text in texts():
            yield line.replace("%s", text).encode()


def keys():
    for key in range(256):
        yield bytes((key,)) + b"CD"
        for motor in b"AB":
            yield bytes((motor, key, 0x49))


TRAFFIC = {"grbl": grbl, "laser": laser, "plotter": plotter, "torch": torch, "pulses": pulses, "keys": keys}


class Desk:
    def __init__(self, language):
        self.port = Sink(counts=language == "laser")  # whose M3 is a word of its own, before the line's motion is refused
        board = board_named(BOARDS[language])
        self.app = App(checked(board), self.port)
        self.language = language
        self.checksum = self.refused = 0

    def _turn(self, turns):
        for _ in range(turns):
            self.app.cycle()

    def clean(self):
        """As after a start, homed, at zero."""
        controller = self.app.controller
        controller.accept(Command(commands.RESET))
        self._turn(2)
        controller.accept(Command(commands.UNLOCK))
        controller.machine.homed = True
        controller.queue.set_origin()
        self._turn(1 if self.language in OF_LINES else TURNS)
        self.port.outgoing = b""

    def _ask(self):
        """Ask a language without refusals for its state."""
        if self.language == "torch":
            from passo.protocols.torch import protocol

            self.port.incoming = protocol.passo(protocol.STATUS_OF)
            self._turn(TURNS)

    def say(self, data):
        """Send it to a machine that stands; add the answer and the words to the sums."""
        self.clean()
        words, stepping = self.port.words, self.port.stepping
        self.port.incoming = data
        self._turn(TURNS)
        self._ask()
        said = self.port.outgoing
        done = self.port.words - words
        if b"error" in said and b"ok" not in said:
            self.refused += 1
            assert not (self.port.stepping - stepping if self.language == "laser" else done), (data, said, done)
        if self.language in OF_LINES:
            said = said[: said.rfind(b"\n") + 1]
        told = b"%s %s %d" % (said, str(list(self.app.controller.queue.target)).encode(), done)
        self.checksum = crc32(told, self.checksum) & 0xFFFFFFFF
        if data[:1] == b"$" and b"=" in data and b"$J" not in data:
            self.port.incoming = b"$RST=*\n$N0=\n$N1=\n"
            self._turn(TURNS)
        return told


def run(language, first=0, step=1, show=None):
    """(checksum, how many, refused)."""
    desk = Desk(language)
    count = 0
    for place, data in enumerate(TRAFFIC[language]()):
        if place % step != first:
            continue
        count += 1
        try:
            told = desk.say(data)
        except Exception:
            print("at", data)
            raise
        if show:
            show(data, told)
    return desk.checksum, count, desk.refused


def main(arguments):
    told = run(arguments[0], *[int(word) for word in arguments[1:3] if word != "-v"], show=print if "-v" in arguments else None)
    print("%08x %d %d" % told)


if __name__ == "__main__":
    main(sys.argv[1:])
