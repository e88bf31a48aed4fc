"""The air around an emulated Pico W: connections over a UART (uart_radio.py), HTTP and WebSockets on them.

    machine = EmulatedMachine(board, files(board), uf2=pico_w())
    air = Air(machine)
    number = air.get("/panel.js")
    body, ms = air.answer(number)
    page = Page(air)                    # a WebSocket, and the key
    page.order("unlock")
"""

import base64
import json
import shutil
import tempfile
from pathlib import Path

import pytest

from board_browser import KEY, masked
from host_tools.build import tree
from host_tools.emulator import binary
from host_tools.emulator.filesystem import folder_files
from host_tools.emulator.heap import Heap
from host_tools.programs import stored_job
from passo.options.jobs.language_page import PIECE
from passo.web.session import Session

BAUD = 921_600  # as uart_radio.py
UART_BYTES = 2048 + 1024  # of that UART's buffers, on MicroPython's heap: a radio's lie outside of it
RADIO = Path(__file__).with_name("uart_radio.py")


def pico_w():
    """MicroPython for a Pico W; the test skips where there is none."""
    found = sorted((binary.CACHE / "versions").glob("RPI_PICO_W-*.uf2"))
    if not found:
        pytest.skip("NOT TESTED: no MicroPython UF2 for the Pico W")
    return found[-1]


def files(board, module="", changes=()):
    """The firmware's files for `board`, with this radio. `changes`: (old, new) texts of `module` of the package, for an axis more."""
    with tempfile.TemporaryDirectory() as folder:
        firmware = Path(folder) / "firmware"
        shutil.copytree(tree.FIRMWARE, firmware)
        shutil.copyfile(RADIO, firmware / "passo" / "web" / "radio.py")
        if changes:
            path = firmware / "passo" / module
            source = path.read_text(encoding="utf-8")
            for old, new in changes:
                assert source.count(old) == 1
                source = source.replace(old, new)
            path.write_text(source, encoding="utf-8")
        path = Path(folder) / "board.py"
        path.write_text(f"BOARD = {board!r}\n", encoding="utf-8")
        out = Path(folder) / "out"
        tree.build_tree(str(path), out, firmware=firmware)
        return folder_files(out)


class Air:
    """The other end of the UART: connections by number."""

    def __init__(self, machine, baud=BAUD):
        self._machine = machine
        self._baud = baud
        self._wire = machine.pico.uart(1)
        self._come = b""
        self._opened = 0
        self.pages = []  # that are open: a browser answers the board's pings whatever else it waits for
        self.heard = {}
        self.ended = set()

    def now_ms(self):
        return self._machine.now_ms()

    def run_ms(self, milliseconds):
        self._machine.run_ms(milliseconds)

    def say(self, kind, number, data=b""):
        for at in range(0, max(len(data), 1), 200):
            piece = data[at : at + 200]
            self._wire.feed(kind + bytes((number, len(piece))) + piece, self._baud)

    def ask(self, text):
        """Begin a request; the number of its connection."""
        self._opened += 1
        self.heard[self._opened] = b""
        self.say(b"O", self._opened)
        self.say(b"D", self._opened, text.encode())
        return self._opened

    def get(self, path):
        return self.ask(f"GET {path} HTTP/1.1\r\nHost: passo.local\r\nAccept-Encoding: gzip\r\nUser-Agent: Mozilla/5.0\r\n\r\n")

    def collected(self):
        """The heap behind a collection of garbage: the freest of the moments that follow."""
        self.say(b"G", 0)
        found = []
        for _ in range(12):
            self.run_ms(8)
            found.append(Heap(self._machine.pico))
        return max(found, key=lambda heap: heap.free)

    def look(self):
        self._come += self._wire.drain()
        while len(self._come) >= 3 and len(self._come) >= 3 + self._come[2]:
            kind, number, length = self._come[:1], self._come[1], self._come[2]
            self.heard[number] += self._come[3 : 3 + length]
            self._come = self._come[3 + length :]
            if kind == b"C":
                self.ended.add(number)

    def answer(self, number, limit_ms=2000):
        """The body of an answer, once it has ended, and how long it took, ms."""
        begun = self._machine.now_ms()
        while number not in self.ended:
            assert self._machine.now_ms() < begun + limit_ms, self.heard[number]
            self._machine.run_ms(1)
            self.look()
            for page in self.pages:
                page.look()
        head, _, body = self.heard[number].partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 200 OK"), head
        return body, self._machine.now_ms() - begun


class Page:
    """One page over the air."""

    def __init__(self, air):
        self._air = air
        self._at = 0  # bytes that have been read
        self._count = 0
        self.hello = None
        self.state = {}
        self.pushes = 0
        self.answers = {}  # by the number of the order
        self.number = air.ask(
            "GET /ws HTTP/1.1\r\nHost: passo.local\r\nOrigin: http://passo.local\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nAccept-Encoding: gzip\r\nUser-Agent: Mozilla/5.0\r\n\r\n"
        )
        self.until(lambda: self.hello)
        air.pages.append(self)
        self._session = Session(KEY, self.hello["nonce"])

    def look(self):
        self._air.look()
        data = self._air.heard[self.number]
        if not self._at:
            end = data.find(b"\r\n\r\n")
            if end < 0:
                return
            assert b" 101 " in data[:end], data[:end]
            self._at = end + 4
        while len(data) - self._at > 1:
            start = 2 if data[self._at + 1] < 126 else 4
            size = data[self._at + 1] if start == 2 else data[self._at + 2] << 8 | data[self._at + 3]
            if len(data) < self._at + start + size:
                return
            kind, text = data[self._at] & 15, data[self._at + start : self._at + start + size]
            self._at += start + size
            if kind == 9:
                self._air.say(b"D", self.number, masked(10, text))
            elif kind == 1:
                self._hear(json.loads(text))

    def _hear(self, message):
        if message["t"] == "state":
            self.state = message
            self.pushes += 1
        elif message["t"] == "hello":
            self.hello = message
        elif "id" in message:
            self.answers[message["id"]] = message

    def until(self, wanted, limit_ms=3000):
        """Let time pass until something is as wanted. Returns how long it took, ms."""
        begun = self._air.now_ms()
        while not wanted():
            assert self._air.now_ms() < begun + limit_ms, (self.state, self._air.heard[self.number][-200:])
            self._air.run_ms(1)
            self.look()
        return self._air.now_ms() - begun

    def order(self, do, **fields):
        """(answer, ms it took) of an order."""
        self._count += 1
        body = json.dumps({**fields, "do": do, "id": self._count})
        message = f"{self._count}.{self._session.proof(str(self._count), body)}.{body}"
        self._air.say(b"D", self.number, masked(1, message.encode()))
        took = self.until(lambda: self._count in self.answers)
        return self.answers[self._count], took

    def stored(self, what, name, **fields):
        """Order something of a stored job. Returns how long it took, ms."""
        answer, took = self.order("stored", what=what, name=name, **fields)
        assert answer["error"] == 0, answer
        return took

    def upload(self, name, data, packed, look=None):
        """Send a job, up to its last piece; look(): called behind each. Returns how long each took, ms."""
        self.stored("begin", name, size=len(data), crc=f"{stored_job.crc_of(data):08x}", stored=len(packed))
        found = []
        for at in range(0, len(packed), PIECE):
            found.append(self.stored("piece", name, at=at, data=base64.b64encode(packed[at : at + PIECE]).decode()))
            if look:
                look()
        return found
