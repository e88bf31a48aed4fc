"""The plotter's language of 2014: packets of six bytes, `command hiX loX hiY loY checksum`, answered by one byte.

    plotter = Plotter()
    for command in plotter.feed(serial.read(), now_ms): …
    serial.write(plotter.reply(event))

No single byte lost, doubled or flipped can draw a wrong line, as long as the host waits for its answers:

- A flipped byte breaks the checksum. All bytes are then dropped until the line is quiet for `gap_ms`; RESEND follows.
- A lost byte leaves a packet unfinished. After RESYNC_MS it is dropped and RESEND follows.
- A doubled byte makes seven. Their first six could be valid by chance (1 in 256), so six bytes in which a byte
  repeats its neighbour are held for `gap_ms`. If a seventh arrives that would make them another valid packet with one
  of the twins removed, nobody knows which was meant: they are dropped, and RESEND follows.

STOP, STATUS and LINK (the link of number X commands from now on; 0: this one) are extensions. The board never speaks
unasked.
"""

from micropython import const

from passo.protocols import errors
from passo.protocols.commands import (
    ACCEPTED, BAD, DRAW, FINISHED, HAND_OVER, HELLO, HOME, JOG, POINT, SPEED, STATUS, STOP, Command,
)

RESYNC_MS = const(2000)
PACKET = const(6)
_TIME_MASK = const(0x1FFFFFFF)

COMMANDS = {
    "REQUEST": 0x72,
    "LINE": 0x6C,
    "MOVE": 0x6D,
    "END": 0x65,
    "ORIGIN": 0x6F,
    "SPEED": 0x73,
    "UP": 0x38,
    "LEFT": 0x34,
    "DOWN": 0x32,
    "RIGHT": 0x36,
    "STOP": 0x78,
    "STATUS": 0x3F,
    "LINK": 0x74,
}
ANSWERS = {
    0x6B: "REQUEST_OK",
    0x6E: "NEXT",
    0x64: "DONE",
    0x6F: "ORIGIN_OK",
    0x73: "SPEED_OK",
    0x72: "RESEND",
    0x74: "LINK_OK",
}
STATUS_LENGTH = const(12)

_SIMPLE = {
    COMMANDS["REQUEST"]: HELLO,
    COMMANDS["END"]: DRAW,
    COMMANDS["ORIGIN"]: HOME,
    COMMANDS["STOP"]: STOP,
    COMMANDS["STATUS"]: STATUS,
}
_ON_ACCEPTED = {HELLO: b"k", POINT: b"n", JOG: b"n", SPEED: b"s", HAND_OVER: b"t"}
_ON_FINISHED = {DRAW: b"d", HOME: b"o", STOP: b"d"}
_RESEND = b"r"


def packet(command, x=0, y=0):
    """The six bytes of `command` (a byte of COMMANDS) with x and y, 0 … 65535."""
    body = bytes((command, x >> 8 & 255, x & 255, y >> 8 & 255, y & 255))
    return body + bytes((sum(body) & 255,))


def _valid(data):
    return sum(data[: PACKET - 1]) & 255 == data[PACKET - 1]


class Plotter:
    def __init__(self, gap_ms=5, jog_up=(0, 1)):
        """`gap_ms`: silence that ends a burst; `jog_up`: the direction, in axes, of UP (RIGHT is a quarter turn on)."""
        self.gap_ms = gap_ms
        up_x, up_y = jog_up
        self._jogs = {
            COMMANDS["UP"]: (up_x, up_y),
            COMMANDS["DOWN"]: (-up_x, -up_y),
            COMMANDS["RIGHT"]: (up_y, -up_x),
            COMMANDS["LEFT"]: (-up_y, up_x),
        }
        self._bytes = b""
        self._before = -1  # the last byte of the packet before: its echo is a twin too
        self._broken = False  # bytes are being dropped until the line is quiet
        self._since = 0  # when the oldest pending byte came
        self._latest = 0  # when the newest one came

    def feed(self, data, now_ms):
        """Commands in `data`, which may be empty: time alone ends bursts and drops torn packets."""
        commands = []
        if data:
            if not self._bytes:
                self._since = now_ms
            self._latest = now_ms
            self._bytes += data
        quiet = (now_ms - self._latest) & _TIME_MASK >= self.gap_ms
        while not self._broken and len(self._bytes) >= PACKET:
            if not _valid(self._bytes) or self._ambiguous():
                self._broken = True
            elif len(self._bytes) == PACKET and not quiet and self._twins():
                return commands
            else:
                commands.append(self._take(now_ms))
        if self._broken:
            self._bytes = b""
            if quiet:
                commands.append(self._drop(errors.CHECKSUM))
        elif self._bytes and (now_ms - self._since) & _TIME_MASK >= RESYNC_MS:
            commands.append(self._drop(errors.BYTES_DROPPED))
        return commands

    def _twins(self):
        """Places in the first six bytes where a byte repeats the one before it."""
        before = self._before
        places = []
        for place in range(PACKET):
            if self._bytes[place] == before:
                places.append(place)
            before = self._bytes[place]
        return places

    def _ambiguous(self):
        """True if the first seven bytes, one of two twins removed, are a valid packet as well."""
        seven = self._bytes[: PACKET + 1]
        if len(seven) <= PACKET:
            return False
        for place in self._twins():
            if _valid(seven[:place] + seven[place + 1 :]):
                return True
        return False

    def _take(self, now_ms):
        data = self._bytes[:PACKET]
        self._bytes = self._bytes[PACKET:]
        self._since = now_ms
        self._before = data[PACKET - 1]
        code = data[0]
        x = data[1] << 8 | data[2]
        y = data[3] << 8 | data[4]
        if code in _SIMPLE:
            return Command(_SIMPLE[code])
        if code in self._jogs:
            return Command(JOG, target=self._jogs[code])
        if code == COMMANDS["LINE"] or code == COMMANDS["MOVE"]:
            return Command(POINT, target=(x, y), tool=code == COMMANDS["LINE"])
        if code == COMMANDS["SPEED"]:
            return Command(SPEED, value=x)
        if code == COMMANDS["LINK"]:
            return Command(HAND_OVER, value=x)
        return Command(BAD, error=errors.UNKNOWN_COMMAND)

    def _drop(self, error):
        self._bytes = b""
        self._before = -1
        self._broken = False
        return Command(BAD, error=error)

    def reply(self, event):
        """The bytes that tell the host of `event`: none where the language has no word for it."""
        command = event.command
        if command.kind == BAD:
            return b"" if command.error == errors.UNKNOWN_COMMAND else _RESEND
        if event.kind == FINISHED:
            return _ON_FINISHED.get(command.kind, b"")
        if event.kind != ACCEPTED:
            return b""
        if command.kind == STATUS:
            return status_bytes(event.value)
        return _ON_ACCEPTED.get(command.kind, b"")


    def push(self, event):
        """The board never speaks unasked."""
        return b""


STATES = ("idle", "run", "home", "jog", "alarm", "hold")
_SHOWN_AS = {"door": "hold", "check": "idle", "sleep": "alarm"}  # states that the language has no number for


def status_bytes(report):
    """STATUS's answer: `?` state error X Y drawn free checksum; X, Y and the counts of two bytes, high byte first,
    a place left of the origin as 0."""
    fields = [max(0, min(65535, place)) for place in report["position"][:2]]
    fields += [report["drawn"], min(report["free"], 65535)]
    state = _SHOWN_AS.get(report["state"], report["state"])
    body = bytearray((COMMANDS["STATUS"], STATES.index(state), report["error"]))
    for field in fields:
        body.append(field >> 8 & 255)
        body.append(field & 255)
    body.append(sum(body) & 255)
    return bytes(body)


def status_from(data):
    """The fields of a STATUS answer of 12 bytes. Raises ValueError where it is none."""
    if len(data) != STATUS_LENGTH or data[0] != COMMANDS["STATUS"] or sum(data[:-1]) & 255 != data[-1]:
        raise ValueError("not a STATUS answer")
    x, y, drawn, free = [data[place] << 8 | data[place + 1] for place in (3, 5, 7, 9)]
    return {
        "state": STATES[data[1]],
        "error": data[2],
        "x": x,
        "y": y,
        "drawn": drawn,
        "free": free,
    }
