"""The board's HTTP: requests in any pieces, too long, torn, doubled; the key; the torch's forms."""

import hashlib

from free_machine import FreeMachine, Jogs
from passo import errors
from passo.commands import BAD, CONNECT, HAND_OVER, RUN, SETTING, STATUS, STILL, STOP
from passo.options.independent.commands import ZERO
from passo.ports.virtual import MemoryLine
from passo.protocols.torch import forms
from passo.records import REQUEST_PROVEN
from passo.web.connection import ANSWERED, ASKED, Connection
from passo.web.guard import Guard
from passo.web.session import Hmac
from passo.web.signed import FREE, SignedLine

CASES = {
    "check_in_any_pieces": (("cuts", "list", 12, ("at", 0, 400)),),
    "check_noise": (("noise", "bytes", 300), ("at", 0, 120)),
    "check_answers_in_any_pieces": (("most", 1, 700), ("size", 0, 1500)),
    "check_forms_of_noise": (("noise", "bytes", 60), ("which", 0, 11), ("flags", 0, 3)),
    "check_signed_noise": (("noise", "bytes", 200),),
    "check_signed_lines": (("count", 1, 1 << 20), ("times", 0, 8)),
    "check_whole": (("value", -(1 << 33), 1 << 33),),
    "check_a_proof": (("count", 1, 1 << 20), ("at", 0, 120), ("bit", 0, 6)),
}
RUNS = {"check_a_proof": 40, "check_signed_lines": 20}
KEY = "ABCDEFGHJKLMNPQR"
NONCE = "00112233445566778899aabbccddeeff"
BODY = b"x=100&y=100&xv=100&yv=100"
REQUEST = (
    b"POST /COMMAND HTTP/1.1\r\nHost: 192.168.4.1\r\nContent-Type: application/x-www-form-urlencoded\r\nContent-Length: 25\r\n"
    b"Connection: Keep-Alive\r\nAccept-Encoding: gzip, deflate\r\nUser-Agent: Mozilla/5.0\r\n\r\n" + BODY
)  # as Qt's QNetworkAccessManager sends it


class Wire:
    """A socket: gives the pieces it was made of, takes `most` bytes at a time."""

    def __init__(self, pieces, most=1 << 20):
        self._pieces = list(pieces)
        self._most = most
        self.taken = b""
        self.closed = False

    def recv(self, count):
        if not self._pieces:
            raise OSError(11, "nothing yet")
        piece = self._pieces.pop(0)
        if len(piece) > count:
            self._pieces.insert(0, piece[count:])
        return piece[:count]

    def send(self, data):
        self.taken += bytes(data[: self._most])
        return min(len(data), self._most)

    def fileno(self):
        return 7

    def close(self):
        self.closed = True


def asked(*pieces):
    """The connection behind these pieces, read as far as they go."""
    wire = Wire([piece for piece in pieces if piece])
    connection = Connection(wire, "127.0.0.1", 0)
    for _ in range(200):
        if connection.state == ASKED or not wire._pieces:
            break
        connection.receive()
    return connection


def check_in_any_pieces(cuts):
    """However it is cut up, it is the same request."""
    cuts = sorted([min(cut, len(REQUEST)) for cut in cuts]) + [len(REQUEST)]
    pieces = [REQUEST[start:end] for start, end in zip([0] + cuts, cuts)]
    found = asked(*pieces)
    assert found.state == ASKED and not found.wrong
    assert (found.method, found.path, found.host, found.body) == (b"POST", b"/COMMAND", b"192.168.4.1", BODY)
    assert found.origin is None and not found.json and not found.proof


def check_noise(noise, at):
    """Noise in the middle of a request is refused, waited for, or a field that nobody looks at: never more than that."""
    found = asked(REQUEST[:at], noise, REQUEST[at:])
    if found.state == ASKED and not found.wrong:
        assert found.method and found.path[:1] == b"/" and len(found.body) <= 256


def check_bounds():
    begin = b"POST /HALT HTTP/1.1\r\nHost: a\r\n"
    assert asked(begin + b"X: " + bytes(600)).wrong == 431
    assert asked(begin + (b"X: " + b"a" * 100 + b"\r\n") * 50).wrong == 431
    assert asked(begin + b"Content-Length: 257\r\n\r\n").wrong == 413
    assert asked(begin + b"Content-Length: 99999999\r\n\r\n").wrong == 400
    for field in (b"Host: b", b"Content-Length: -1", b"Transfer-Encoding: chunked", b"Host : b", b"no colon"):
        assert asked(begin + field + b"\r\n\r\n").wrong == 400, field
    assert asked(begin + b"Content-Length: 1\r\nContent-Length: 1\r\n\r\nx").wrong == 400
    assert asked(begin + b"\r\n" + begin + b"\r\n").wrong == 400  # two at once
    for first in (b"GET", b"GET / HTTP/2.0", b"GET http://a/ HTTP/1.1", b"GET  / HTTP/1.1", b"\x16\x03\x01"):
        assert asked(first + b"\r\n\r\n").wrong == 400, first
    assert asked(begin).state != ASKED
    assert asked(b"GET /JOGX%2B?json HTTP/1.1\r\nhost:a\r\n\r\n").path == b"/JOGX+"


def check_answers_in_any_pieces(most, size):
    wire = Wire([], most)
    connection = Connection(wire, "127.0.0.1", 0)
    body = bytes([32 + at % 64 for at in range(size)])
    connection.answer(200, b"text/plain", body, b"X: 1\r\n")
    assert connection.state == ANSWERED
    for _ in range(5000):
        if not connection.send(0):
            break
    head, _, told = wire.taken.partition(b"\r\n\r\n")
    assert told == body and head.find(b"HTTP/1.1 200 OK\r\nContent-Type: text/plain\r\n") == 0
    assert head.find(b"\r\nX: 1\r\nContent-Length: %d" % size) > 0


# --- who may


def guard(key=KEY, admitted=None):
    made = Guard((b"passo.local", b"192.168.4.1"), key, NONCE, lambda peer: peer[:10] == "192.168.4.")
    made.set_admission(admitted, (b"/HALT",))
    return made


def request(proof=b"", peer="192.168.4.2", fields=b"", path=b"/ON", body=b""):
    found = asked(
        b"POST %s HTTP/1.1\r\nHost: passo.local\r\nContent-Length: %d\r\n" % (path, len(body)) + fields
        + (b"X-Passo: %s\r\n" % proof if proof else b"") + b"\r\n" + body
    )  # fmt: skip
    assert found.state == ASKED and not found.wrong
    found.peer = peer
    return found


def proof(count, text=b"POST /ON ", key=KEY):
    signed = b"%s.%d.%s" % (NONCE.encode(), count, text)
    return b"%d.%s" % (count, Hmac(key.encode()).hex_digest(signed).encode())


def check_hmac():
    """RFC 4231, cases 2 and 6."""
    assert Hmac(b"Jefe").hex_digest(b"what do ya want for nothing?").find("5bdcc146bf60754e6a042426089575c7") == 0
    long = Hmac(b"\xaa" * 131).hex_digest(b"Test Using Larger Than Block-Size Key - Hash Key First")
    assert long.find("60e431591ee0b67f0d8a26aacbf5b77f") == 0
    assert hashlib.sha256(b"").digest()[:2] == b"\xe3\xb0"


def check_host_and_origin():
    for host, origin, status in (
        (b"passo.local", None, 0), (b"192.168.4.1:80", None, 0), (b"PASSO.local", b"http://passo.local", 0),
        (b"evil.example", None, 403), (b"", None, 403), (b"192.168.4.1.evil.example", None, 403),
        (b"passo.local", b"http://evil.example", 403), (b"passo.local", b"null", 403), (b"passo.local", b"https://passo.local", 403),
        (b"passo.local", b"http://passo.local:81", 403), (b"passo.local:81", b"http://passo.local:81", 0),
    ):  # fmt: skip
        fields = b"Host: %s\r\n" % host + (b"Origin: %s\r\n" % origin if origin is not None else b"")
        found = asked(b"POST /HALT HTTP/1.1\r\n" + fields + b"\r\n")
        assert guard().refusal_status(found) == status, (host, origin)
    assert guard().refusal_status(asked(b"POST /HALT HTTP/1.1\r\n\r\n")) == 403


def check_a_proof(count, at, bit):
    """The right one is good once, for this request; one with any bit changed never is."""
    made = guard()
    good = proof(count)
    torn = bytearray(good)
    torn[at % len(good)] ^= 1 << bit
    if torn[at % len(good)] not in b"\r\n" and not chr(torn[at % len(good)]).isspace():
        assert not made.is_proven(request(bytes(torn)), 0)
    assert not made.is_proven(request(good, path=b"/OFF"), 0) and not made.is_proven(request(good, body=b"x=1"), 0)
    assert made.is_proven(request(good), 0)
    assert b"X-Passo-Count: %d\r\n" % count in made.headers() and NONCE.encode() in made.headers()
    assert not made.is_proven(request(good), 0)
    assert made.is_proven(request(proof(count + 1)), 0)
    assert not guard(key=None).is_proven(request(good), 0)


def check_guessing_is_slowed_down():
    made = guard()
    for _ in range(5):
        assert not made.is_proven(request(b"1." + b"0" * 64), 0)
    assert not made.is_proven(request(proof(1)), 999)
    assert made.is_proven(request(proof(1)), 1000)


def check_admission():
    """Without a proof: from the board's own network, while admitted, and with no wrong proof either."""
    made = guard(admitted=lambda: True)
    assert made.is_proven(request(), 0)
    assert not made.is_proven(request(peer="192.168.1.2"), 0)
    assert not made.is_proven(request(b"1." + b"0" * 64), 0)
    made.set_admission(lambda: True, (b"/HALT",), (request().path,))
    assert not made.is_proven(request(), 0), "a path of Passo's own"
    assert not guard(admitted=lambda: False).is_proven(request(), 0)
    assert not guard().is_proven(request(), 0)


# --- lines over TCP


class Listening:
    def __init__(self, wire):
        self._wires = [wire]

    def setblocking(self, blocking):
        pass

    def accept(self):
        if not self._wires:
            raise OSError(11, "nothing yet")
        return self._wires.pop(), ("127.0.0.1", 1)

    def close(self):
        pass


class Open(Wire):
    def setblocking(self, blocking):
        pass


def signed_line(*pieces):
    """Return (the bytes for the language, the bytes for the other end) of a connection that sends `pieces` and goes; {nonce} is put in."""
    wire = Open([])
    line = SignedLine(Listening(wire), KEY)
    line.read()
    nonce = wire.taken[7:-3]
    wire._pieces = [piece(nonce) if callable(piece) else piece for piece in pieces if piece] + [b""]
    given = b""
    for _ in range(len(pieces) + 300):
        given += line.read()
    return given, wire.taken


def line_of(count, body):
    """A proven line, once the nonce is known."""

    def proven(nonce):
        signed = b"%s.%d.%s" % (nonce, count, body)
        return b"%d.%s.%s\n" % (count, Hmac(KEY.encode()).hex_digest(signed).encode(), body)

    return proven


def check_signed_noise(noise):
    """Unsigned bytes reach the language only if they ask or make safe, and the end of the connection ends a jog."""
    given, told = signed_line(noise, b"\n", noise)
    assert not [byte for byte in given if byte not in FREE]
    assert given[-1:] == b"\x85"


def check_signed_lines(count, times):
    bodies = [b"G1 X%d" % at for at in range(times)]
    given, told = signed_line(*[line_of(count + at, body) for at, body in enumerate(bodies)])
    assert given == b"".join([body + b"\n" for body in bodies]) + b"\x85" and told.count(b"\n") == 1
    assert signed_line(line_of(count, b"*7e"))[0] == b"~\x85"
    given, told = signed_line(line_of(count, b"G1"), line_of(count, b"G1"), b"?")
    assert given == b"G1\n?\x85" and told.count(b"error:%d" % errors.NOT_ADMITTED) == 1


# --- the torch's forms


class Networked(FreeMachine):
    """A machine with relays, and the torch's HTTP on its second link, whose requests come from memory."""

    def __init__(self, legacy=False, button=""):
        cable = {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "protocol": "torch"}
        wifi = {"name": "wifi", "port": "http", "protocol": "torch"}
        inputs = [{"name": button, "pin": 14}] if button else []
        FreeMachine.__init__(
            self, links=[cable, wifi], network={"legacy_http": legacy, "button": button, "minutes": 2}, inputs=inputs,
            outputs=[{"name": "relay", "pin": 10, "role": "ours"}],
        )  # fmt: skip
        self.phone = self.app.links[1].serial = MemoryLine()
        self.poll(1_000_000)

    def ask(self, path, body=b"", flags=REQUEST_PROVEN):
        """The answer to a request, without its number."""
        self.phone.outgoing = b""
        self.phone.incoming = bytes((9, flags)) + path + b" " + body
        for _ in range(20):
            self.cycle()
            if self.phone.outgoing:
                break
        assert self.phone.outgoing[:1] == b"\x09", path
        return self.phone.outgoing[1:]


def check_each_request():
    machine = Networked()
    assert machine.ask(b"/COMMAND", BODY) == b"code=254&state=stopped&error=112"
    assert machine.ask(b"/ON") == b"code=238&state=stopped&error=0"
    machine.settle()
    assert machine.ask(b"/COMMAND", BODY) == b"code=254&state=running&error=0&x=100&xv=100&y=100&yv=100"
    assert machine.ask(b"/COMMAND", BODY).find(b"error=%d" % errors.BUSY) > 0
    assert machine.ask(b"/INFO").find(b"code=187&state=running&error=0&x=") == 0
    machine.settle()
    told = machine.ask(b"/INFO")
    assert told.find(b"code=187&state=finished&error=0&x=100&y=100&px=100&py=100&") == 0 and told.find(b"&ours=1&spmx=48000&spmy=83000") > 0
    assert machine.ask(b"/COMMAND", b"x=40&y=0&xv=-100&yv=100", 3) == (
        b'{"code": 254, "state": "running", "error": 0, "x": 40, "xv": -100, "y": 0, "yv": 100}'
    )
    machine.settle()
    assert machine.ask(b"/HALT", b"", 0) == b"code=221&state=stopped&error=0&x=-40&y=0&px=60&py=100"
    assert machine.ask(b"/CONFIG", b"jogx=10&jogy=20&xv=100&yv=100") == b"code=153&state=stopped&error=0&jogx=10&jogy=20&xv=100&yv=100"
    for path, place in ((b"/JOGX+", [70, 100]), (b"/JOGX-", [60, 100]), (b"/JOGY+", [60, 120]), (b"/JOGY-", [60, 100])):
        assert machine.ask(path).find(b"&state=running&error=0") > 0
        machine.settle()
        assert machine.made() == place
    assert machine.ask(b"/ORIGIN") == b"code=136&state=finished&error=0"
    assert machine.ask(b"/INFO").find(b"&px=0&py=0&") > 0
    assert machine.ask(b"/OFF") == b"code=204&state=finished&error=0"
    assert machine.ask(b"/COMMAND", BODY).find(b"error=%d" % errors.NO_MOTORS) > 0


def check_nothing_moves_without_a_proof():
    machine = Networked()
    for path in forms.PATHS:
        if path not in (b"/HALT", b"/INFO"):
            assert machine.ask(path, BODY, 0).find(b"error=%d" % errors.NOT_ADMITTED) > 0, path
    machine.settle()
    assert machine.made() == [0, 0] and not machine.app.controller.features["changeover"].ours


def admission_of(machine):
    return machine.app.controller.features["admission"]


def check_admission_ends():
    """ADMIT comes by cable only, and ends by itself, by 0, and with an alarm."""
    closed = Networked()
    closed.send(forms_admit(5))
    closed.cycle()
    assert not admission_of(closed).is_admitted()
    machine = Networked(legacy=True)
    assert not admission_of(machine).is_admitted()
    for minutes, after_ms, left in ((1, 59_000, True), (1, 61_000, False), (60, 3_500_000, True), (0, 0, False)):
        machine.send(forms_admit(minutes))
        machine.cycle()
        machine.cycle()
        machine.port.advance(after_ms * 12_500)
        machine.cycle()
        assert admission_of(machine).is_admitted() == left, minutes
    machine.send(forms_admit(5))
    machine.cycle()
    assert admission_of(machine).is_admitted()
    machine.app.controller.machine.raise_alarm(errors.ALARM_HARD_LIMIT)
    machine.cycle()
    assert not admission_of(machine).is_admitted()


def forms_admit(minutes):
    from passo.protocols.torch import protocol

    return protocol.passo(protocol.ADMIT_OF, minutes)


class Standing:
    """A machine that stands, with jogs of a step."""

    def __init__(self):
        self.settings = Jogs((1, 1), (1, 1))
        self.steps_per_m = [1, 1]


def check_forms_of_noise(noise, which, flags):
    """A body that is no form asks for nothing but an error, whatever its path."""
    path = forms.PATHS[which]
    found = forms.Forms(Standing()).feed(bytes((1, flags)) + path + b" " + noise, 0)
    free = path in (b"/HALT", b"/INFO")
    if path in (b"/COMMAND", b"/CONFIG", b"/SETTING") or not flags & REQUEST_PROVEN and not free:
        assert [command.kind for command in found] == [BAD]
    else:
        kinds = {b"/ON": [HAND_OVER, CONNECT], b"/OFF": [CONNECT], b"/HALT": [STOP], b"/INFO": [STATUS], b"/ORIGIN": [ZERO]}
        assert [command.kind for command in found] == kinds.get(path, [RUN])


def check_whole(value):
    text = str(value)
    assert forms.parse_whole(text, -(1 << 31), (1 << 32) - 1) == (value if -(1 << 31) <= value < 1 << 32 else None)
    for wrong in ("", "-", "+", " 1", "1 ", "1.0", "1e3", "0x10", "1_0", "²", "--1", text + "a"):
        assert forms.parse_whole(wrong, -(1 << 40), 1 << 40) is None


def check_fields():
    """Every field once, and no other."""
    made = forms.Forms(Standing())

    def kinds(path, body):
        return [command.kind for command in made.feed(bytes((1, REQUEST_PROVEN)) + path + b" " + body, 0)]

    assert kinds(b"/SETTING", b"number=100&value=48.5") == kinds(b"/SETTING", b"value=&number=100") == [SETTING]
    for body in (b"number=100", b"number=100&value=x", b"number=x&value=1", b"number=&value=1", b"number=1=1&value=1", BODY):
        assert kinds(b"/SETTING", body) == [BAD], body
    assert kinds(b"/COMMAND", BODY) == [RUN] and kinds(b"/CONFIG", b"yv=1&xv=1&jogx=2&jogy=3") == [STILL]
    for body in (b"", b"x=1", BODY + b"&z=1", BODY + b"&x=1", BODY.replace(b"x=100", b"x=-100", 1), BODY.replace(b"yv", b"yw"),
                 b"x=4294967296&y=1&xv=1&yv=1", b"x=1&y=1&xv=2147483648&yv=1", b"x=1&y=1&xv=1&yv=1&", b"x=1;y=1;xv=1;yv=1"):  # fmt: skip
        assert kinds(b"/COMMAND", body) == [BAD], body
