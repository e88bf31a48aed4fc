"""The bits of a parallel port on the pins: as the status image says, remapped, inverted, disabled."""

from passo.app import App
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.ports.virtual import Nothing, VirtualPort
from passo.protocols.pulses.report import port_byte
from passo.steps.wiring import word_pins
from boards.lpt_router import BOARD

LINES = (17, 2, 5, 3, 6, 4, 7, 8)  # GPIOs of D0 to D7
TEXT = b"[AABXP(QRMYZ)C]"
TABLES = ("76543210", "01234567", "7654321-", "-6543210", "7-543210", "76-43210", "3-526-40", "25-071-3", "--------")
CASES = {"check_lines_show_the_image": (("table", 0, len(TABLES) - 1), ("invert", 0, 255))}
RUNS = {"check_lines_show_the_image": 40}
EXAMPLES = {"check_lines_show_the_image": ((0, 0), (1, 0xFF), (3, 0x80), (8, 0x5A))}


class Lines(Nothing):
    """A world that sees the eight lines by their GPIOs. `steps`: their byte whenever a pulse begins."""

    def __init__(self, board):
        self.pins = word_pins(board)
        self.levels = {}
        self.enable = None
        for item in board["outputs"]:
            if item["name"] == "enable":
                self.enable = item["pin"]
                self.levels[self.enable] = 1 - item["active"]
        self.shown = []
        self.rest = 0
        self.pulses = (1 << len(board["axes"])) - 1

    def attach(self, tick, names, levels):
        self.rest = levels
        self._take(levels)

    def _take(self, levels):
        for bit in range(len(self.pins)):
            self.levels[self.pins[bit]] = levels >> bit & 1

    def byte(self):
        value = 0
        for line in range(8):
            value |= self.levels.get(LINES[line], 0) << line
        return value

    def edges(self, tick, levels, changed):
        self._take(levels)
        self.shown.append(self.byte())

    def output(self, tick, name, level):
        if name == "enable":
            self.levels[self.enable] = level
            self.shown.append(self.byte())


def board_of(bits, invert, **more):
    board = dict(BOARD)
    board["step_program"] = dict(BOARD["step_program"])
    board["step_program"].update({"port_pins": list(LINES), "port_bits": bits, "port_invert": invert})
    board["outputs"] = [{"name": "enable", "pin": 9, "active": 1}]  # D7 is high while the drives are on
    board["player"] = "timer"
    board.update(more)
    return board


def wanted(config):
    """The port's byte behind each change, step by step, as the document has it: the steps' bytes with the pulse up."""
    from passo.protocols.pulses.codes import CODES

    shown = []
    drives = tool = 0
    for code in TEXT:
        step = 0
        if code in b"[]":
            drives = code == 0x5B
            continue
        if code in b"()":
            tool = code == 0x28
            continue
        step = CODES[code - 65]
        shown.append(port_byte(step, tool, drives, config))
    return shown


def check_lines_show_the_image(table, invert):
    bits = TABLES[table]
    raw = board_of(bits, invert)
    board = check(raw)
    world = Lines(board)
    app = App(board, VirtualPort(board, world))
    line = app.port.lines["pc"]
    line.incoming = b"{load}" + TEXT + b"{end}{run}"
    for _ in range(3000):
        app.cycle()
        if b"end" in line.outgoing:
            break
    assert b"end" in line.outgoing, line.outgoing
    config = board["step_program"]
    # Directions of axes that stand in a step keep their level on a pin; the document's image clears them.
    last = 0
    for step, byte in zip([code for code in TEXT if 65 <= code <= 90], wanted(config)):
        care = _seen(step, bits)
        if not care:
            continue
        while last < len(world.shown) and world.shown[last] & care != byte & care:
            last += 1
        assert last < len(world.shown), (bits, invert, chr(step), byte)
        last += _pulses_seen(step, bits)  # else there may be nothing to be seen of it
    for line_number in range(8):
        if str(line_number) not in bits:
            assert not any([byte >> line_number & 1 for byte in world.shown]), (bits, line_number)
    assert raw["axes"][0]["pins"] == [2, 5]  # the board file itself stays as it is


def _pulses_seen(step, bits):
    """1 if all pulses of a step appear on a line, else 0."""
    from passo.protocols.pulses.codes import CODES

    for axis in range(3):
        if CODES[step - 65] >> axis & 1 and bits[7 - (2 + 2 * axis)] == "-":
            return 0
    return 1


def _seen(step, bits):
    """Mask of the lines that a step determines: all but directions of axes that do not move."""
    from passo.protocols.pulses.codes import CODES

    mask = 0
    for bit in range(8):
        place = bits[7 - bit]
        direction = bit in (1, 3, 5)
        if place != "-" and (not direction or CODES[step - 65] >> (bit // 2) & 1):
            mask |= 1 << int(place)
    return mask


def check_what_is_wrong_with_lines():
    for change, text in (
        ({"port_pins": [1, 2, 3]}, "eight different GPIOs"), ({"port_pins": [2] * 8}, "eight different"), ({"port_bits": "7654321"}, "once at most"),
        ({"port_bits": "77543210"}, "once at most"), ({"port_invert": 256}, "0 … 255"), ({"port_pins": "ab"}, "eight different"),
    ):  # fmt: skip
        board = board_of("76543210", 0)
        board["step_program"].update(change)
        try:
            check(board)
        except BoardError as error:
            assert text in str(error), str(error)
        else:
            assert False, change
    board = board_of("7654321-", 0, chip="esp32")
    try:
        check(board)
    except BoardError as error:
        assert "RP2040 or RP2350 only" in str(error)
    else:
        assert False
