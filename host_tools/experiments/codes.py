"""Table 3 and section 5.1 of 2009: the byte of the parallel port beside each code, the steps it makes, and the speeds that are shown.

The bytes are made by the firmware's own status, on the PC or on the chip; the speeds are those of a file that is played.
"""

import re

from host_tools import boards
from host_tools.experiments.authors import Author, author_figure
from host_tools.experiments.places import BOARD, VIRTUAL, program_text
from host_tools.experiments.row import Outcome, Row
from host_tools.failure import Failure
from host_tools.language import _
from passo.protocols.pulses.protocol import ACK, frame
from passo.protocols.pulses.report import status_from

FILE = "[AABXP(QRMYZ)]"  # table 3 without its speed
SPEEDS = ("+1000", "speed asked for"), ("$", "fastest speed"), ("@", "default speed")
STRAIGHT, DIAGONAL = "A", "G"  # X+, and X+Y+
PERIODS, SIDE_CM = 100, 10
MOST_MS = 60_000


class Port:
    """A router of LPTControl: files played, status asked."""

    def __init__(self, place):
        self.machine = place.create_machine("lpt_router")
        self.machine.run_ms(100)

    def send_order(self, *words):
        """Send an order, and wait for its ok. Raises Failure if the machine answers with an error."""
        machine = self.machine
        machine.take()
        machine.send(frame(*words))
        machine.run_until(lambda: re.search(rb"^(ok|error).*\n", machine.replies_so_far().replace(ACK, b""), re.MULTILINE), MOST_MS)
        said = machine.take().replace(ACK, b"").decode("latin-1")
        if "error" in said:
            raise Failure("{!r} was answered by {!r}", words[0], said.strip())

    def play_codes(self, text):
        """Load pulse codes and run them; returns as the run begins. Raises Failure."""
        self.send_order("load", len(text))
        self.machine.send(b"\n" + text.encode())
        self.send_order("end")
        self.send_order("run")

    def ask_status(self):
        """Return the fields of the machine's status."""
        machine = self.machine
        machine.send(frame("?"))
        machine.run_until(lambda: b">" in machine.replies_so_far(), MOST_MS)
        said = machine.take()
        return status_from(re.findall(rb"<state.*?>", said)[-1].decode())


def why_left_out(raw):
    """Return the reason why a board of this board file makes no bytes; "" if it does."""
    return "" if any(link["protocol"] == "pulses" for link in raw["links"]) else _("its firmware does not speak pulses")


def port_bytes(place):
    """Return the port's byte at each code of FILE, as text in hexadecimal."""
    config = {key: boards.load("lpt_router")["step_program"][key] for key in ("port_bits", "port_invert")}
    if place.kind == VIRTUAL:
        from host_tools.experiments.board_codes import port_image

        shown = port_image(FILE, config)
    else:
        chip = place.start_chip("lpt_router")
        chip.exec(program_text("board_codes.py"))
        shown = map(int, chip.exec(f"print(*port_image({FILE!r}, {config!r}))").split())
    return [f"{byte:02X}" for byte in shown]


def read_speeds(place):
    """Return {code: mm/min that the status shows behind it}, for SPEEDS."""
    found = {}
    for code, _name in SPEEDS:
        port = Port(place)
        try:
            port.play_codes(f"[{code} AAAA]")
            port.machine.run_until(lambda: port.ask_status()["state"] == "idle", MOST_MS)
            found[code] = float(port.ask_status()["speed"])
        finally:
            port.machine.close()
    return found


def period_us(place, code):
    """Return the microseconds from one step of a code to the next, at the default speed, by the motors. The first interval, which has the direction's
    set-up in it, is left out."""
    port = Port(place)
    try:
        port.play_codes(f"[{code * (PERIODS + 2)}]")
        port.machine.run_until(lambda: port.ask_status()["state"] == "idle", MOST_MS)
        rows = port.machine.trace.rows()[-PERIODS - 1 :]
        return (rows[-1][0] - rows[0][0]) / PERIODS
    finally:
        port.machine.close()


def run(place):
    """Return the Outcome: bytes of the port, and except on a board the speeds, and the diagonal of a triangle."""
    printed = author_figure("bytes of the port")
    wanted, shown = printed.printed.split(), port_bytes(place)
    outcome = Outcome(_("the file of the document, code by code: the byte that the status shows of the port"))
    for code, byte, ours in zip(FILE, wanted, shown, strict=True):
        outcome.rows.append(Row(_("code {}", code), Author(printed.place, byte), None, "", ours, ours == byte))
    if place.kind != BOARD:
        outcome.how += "; " + _("speeds from the status, of a machine of 12.5 µm a step and 312 µs between pulses: the document does not give those of its own")
        speeds = read_speeds(place)
        for code, name in SPEEDS:
            outcome.add_row(_("speed behind {}", code), author_figure(name), speeds[code], "mm/min")
        label = _("diagonal of a triangle with two sides of 10 cm, by the time that its steps take at the same speed")
        outcome.add_row(label, author_figure("diagonal"), SIDE_CM * period_us(place, DIAGONAL) / period_us(place, STRAIGHT), "cm")
    return outcome
