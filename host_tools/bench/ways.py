"""How many functions of the firmware in how many files a thing passes, on the virtual board: `make bench ARGS=ways`.

    header, rows = ways_table()

Each is counted once, however often it runs, and a call into a kernel is one function, whatever that calls. The main loop's own
cycle is in each of them.
"""

import ast
import json
import re
import socket
import sys
from functools import cache

from host_tools import boards
from host_tools.resources import FIRMWARE
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.radio import LoopbackRadio
from passo.web.session import Session

_BOARD = "router_3axis"
_CYCLES = 500_000  # until a thing has been done
_NEAR_THE_SENSORS = [1500, 1500, -1500]  # steps from machine zero


@cache
def _kernel_lines(path):
    """Return the first lines of the functions that a chip runs as kernels."""
    tree = ast.parse(open(path, encoding="utf-8").read())
    made = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.decorator_list]
    return {node.decorator_list[0].lineno for node in made if "viper" in ast.unparse(node.decorator_list[0])}


def _is_kernel(code):
    return code.co_firstlineno in _kernel_lines(code.co_filename)


class Passed:
    """`with Passed() as passed:` counts what is called inside it."""

    def __init__(self):
        self.functions = set()
        self._inside = 0  # kernels that run

    def __enter__(self):
        sys.setprofile(self._on_event)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)

    def _on_event(self, frame, event, _):
        """Note each call of a function of the firmware, as sys.setprofile() reports it. A kernel counts once, without the functions that it calls;
        comprehensions and lambdas do not count."""
        code = frame.f_code
        if event not in ("call", "return") or not code.co_filename.startswith(str(FIRMWARE)):
            return
        kernel = _is_kernel(code)
        if event == "return":
            self._inside -= kernel
            return
        if not self._inside and not code.co_name.startswith("<"):
            self.functions.add((code.co_filename, code.co_qualname))
        self._inside += kernel

    def count_passed(self):
        return len(self.functions), len({path for path, _ in self.functions})


def _make_machine(*before, start=None):
    """Make a router at rest that has carried out `before`, one after the other. `start`: where it stands, in steps."""
    machine = VirtualMachine(_BOARD, trace=None, start=start)
    _unlock_machine(machine)
    for data in before:
        machine.send(data)
        machine.run_ms(1500)
    machine.take()
    return machine


def _unlock_machine(machine):
    """Unlock the machine, and have it forget that it has told that it is not homed, which its first motion does."""
    machine.send(b"$X\n")
    machine.run_ms(1500)
    machine.app.controller.machine.cautious = False


def _count_until(machine, done):
    """Run the main loop until `done()`; return count_passed() of it. Raises TimeoutError after _CYCLES cycles."""
    with Passed() as passed:
        for _ in range(_CYCLES):
            machine.app.poll()
            machine.app.rest()
            if done():
                return passed.count_passed()
    raise TimeoutError


def _count_line(text, *before):
    """Count from a line's bytes until the first of its words is in the ring."""
    machine = _make_machine(*before)
    ring = machine.port._player._ring
    made = ring.head
    machine.send(text)
    return _count_until(machine, lambda: ring.head != made)


def _count_answer(text, end, *before):
    machine = _make_machine(*before)
    machine.send(text)
    return _count_until(machine, lambda: end in machine.replies_so_far())


def _amid_motion(text, done):
    """Send a text 0.5 s after the start of a line of 50 mm; return the count until `done(machine)`."""
    machine = _make_machine()
    machine.send(b"G91G1X50F1000\n")
    machine.run_ms(500)
    machine.take()
    machine.send(text)
    return _count_until(machine, lambda: done(machine))


def has_stopped(machine, seen=[]):
    """True if the plant has stood for 100 cycles."""
    seen.append(machine.plant.position[:])
    return len(seen) > 100 and seen[-100] == seen[-1]


def _count_idle():
    """Return the count that most idle cycles pass; now and then one has more to do."""
    machine = _make_machine()
    found = []
    for _ in range(100):
        with Passed() as passed:
            machine.app.poll()
            machine.app.rest()
        found.append(passed.count_passed())
    return max(set(found), key=found.count)


def _count_homing():
    machine = _make_machine(start=_NEAR_THE_SENSORS)
    machine.send(b"$H\n")
    return _count_until(machine, lambda: b"ok" in machine.replies_so_far())


_KEY = "ABCDEFGHJKLMNPQR"
_TEXT = 0x81  # the first byte of a WebSocket's frame that is a text, whole
_MASKED = 0xFE  # two bytes of length follow, then a mask


class _Browser:
    """The page of a router that serves it, and has given it the command."""

    def __init__(self):
        board = {**boards.load(_BOARD), "network": {"host": "passo"}, "links": [
            {"name": "pc", "port": "usb", "protocol": "grbl"}, {"name": "page", "port": "page", "protocol": "grbl"}]}  # fmt: skip
        radio = LoopbackRadio({"http": 0}, _KEY, board)
        self.machine = VirtualMachine(board, trace=None, radio=radio)
        self.socket = socket.create_connection(("127.0.0.1", radio.port_of("http")))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.sendall(
            b"GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        )
        self.socket.setblocking(False)
        self.heard = b""
        self._count = 0
        self.machine.run_until(lambda: self.has_received(b'"hello"'))
        self._session = Session(_KEY, re.search(rb'"nonce": "(\w+)"', self.heard)[1].decode())
        _unlock_machine(self.machine)
        self.send_order(do="give", to="page")
        self.machine.run_ms(1500)

    def has_received(self, text):
        """Read the bytes that have arrived, without waiting; return True if `text` has come since the last order."""
        try:
            self.heard += self.socket.recv(65_536)
        except BlockingIOError:
            pass
        return text in self.heard

    def send_order(self, **order):
        """Send an order over the page's WebSocket in a masked frame (mask 0), with its number and its proof by the key."""
        self._count += 1
        body = json.dumps(order)
        text = f"{self._count}.{self._session.proof(str(self._count), body)}.{body}".encode()
        self.heard = b""
        self.socket.sendall(bytes((_TEXT, _MASKED)) + len(text).to_bytes(2, "big") + bytes(4) + text)


def _press_key(again=False):
    """Return the count from a jog of 1 mm in X by the page's key until it is answered and a word of it is in the ring. `again`: another jog has been
    carried out before."""
    browser = _Browser()
    machine = browser.machine
    if again:
        browser.send_order(do="step", by={"x": 1}, speed=500)
        machine.run_ms(1500)
    ring = machine.port._player._ring
    made = ring.head
    browser.send_order(do="step", by={"x": 1}, speed=500)
    return _count_until(machine, lambda: browser.has_received(b'"step"') and ring.head != made)


_MODES = b"G21G91G94G17F600\n"
WAYS = {
    "a cycle of the main loop, nothing to do": _count_idle,
    "`G1`, from its bytes to its first words": lambda: _count_line(b"G1X5\n", _MODES, b"G1X1\n"),
    "the first `G1`, with `G91` in it": lambda: _count_line(b"G91G1X5F600\n"),
    "`G2`, the same": lambda: _count_line(b"G2X5Y5I5\n", _MODES, b"G2X1Y1I1\n"),
    "the first `G2`": lambda: _count_line(b"G91G2X5Y5I5F600\n"),
    "`?`, to its answer": lambda: _count_answer(b"?", b">", b"?", b"?", b"?"),
    "the first `?`": lambda: _count_answer(b"?", b">"),
    "`!` in motion, to the stand": lambda: _amid_motion(b"!", has_stopped),
    "Ctrl-X in motion, to the banner": lambda: _amid_motion(b"\x18", lambda machine: b"for help" in machine.replies_so_far()),
    "`$H`, to its answer": _count_homing,
    "`$110=`, to its answer": lambda: _count_answer(b"$110=3100\n", b"ok"),
    "a key on the board's own page, to its answer and its first words": _press_key,
    "the same key again": lambda: _press_key(True),
}


def ways_table():
    """Return header and rows of the table."""
    return ["way", "functions", "files"], [[name, *count()] for name, count in WAYS.items()]
