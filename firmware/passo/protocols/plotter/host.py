"""The PC's end of the plotter's language: its packets, and the answers to them. No board needs it; the rest is in protocol.py.

    wire.write(packet(COMMANDS["LINE"], 644, 454))
    ANSWERS[wire.read(1)[0]]                        # "NEXT"
"""

from micropython import const

from passo.protocols.plotter import protocol as plotter
from passo.protocols.plotter.protocol import PACKET, RESYNC_MS, STATES, Plotter, status_bytes  # noqa: F401

COMMANDS = {
    "REQUEST": plotter.REQUEST, "LINE": plotter.LINE, "MOVE": plotter.MOVE, "END": plotter.END, "ORIGIN": plotter.ORIGIN,
    "SPEED": plotter.SET_SPEED, "UP": plotter.UP, "LEFT": plotter.LEFT, "DOWN": plotter.DOWN, "RIGHT": plotter.RIGHT,
    "STOP": plotter.HALT, "STATUS": plotter.ASK, "LINK": plotter.LINK, "WORDS": plotter.WORDS,
}  # fmt: skip
ANSWERS = {
    0x6B: "REQUEST_OK", 0x6E: "NEXT", 0x64: "DONE", 0x6F: "ORIGIN_OK", 0x73: "SPEED_OK", 0x72: "RESEND", 0x74: "LINK_OK",
}  # fmt: skip
STATUS_LENGTH = const(12)
WORDS_BYTES = const(3)  # of a line of text, in a packet


def packet(command, x=0, y=0):
    """Return the six bytes of `command` (a byte of COMMANDS) with x and y, 0 … 65535."""
    body = bytes((command, x >> 8 & 255, x & 255, y >> 8 & 255, y & 255))
    return body + bytes((sum(body) & 255,))


def words_packets(line):
    """Return the packets of WORDS that carry a line of text, numbered from 0 on."""
    text = line.encode() + b"\n"
    text += b" \n"[: -len(text) % WORDS_BYTES]
    return [packet(COMMANDS["WORDS"], at // WORDS_BYTES << 8 | text[at], text[at + 1] << 8 | text[at + 2]) for at in range(0, len(text), WORDS_BYTES)]


def status_from(data):
    """Return the fields of a STATUS answer of 12 bytes. Raises ValueError if it is none."""
    if len(data) != STATUS_LENGTH or data[0] != COMMANDS["STATUS"] or sum(data[:-1]) & 255 != data[-1]:
        raise ValueError("not a STATUS answer")
    x, y, drawn, free = [data[index] << 8 | data[index + 1] for index in (3, 5, 7, 9)]
    return {"state": STATES[data[1]], "error": data[2], "x": x, "y": y, "drawn": drawn, "free": free}
