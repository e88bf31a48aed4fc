"""The USB port's bytes on the emulated Pico: the board reads the bytes sent, in bursts of all lengths, and the REPL has its console back."""

import hashlib
from random import Random

import pytest
from emulated import uf2  # noqa: F401

from host_tools.emulator.pico import EmulatedPico
from host_tools.resources import FIRMWARE

MODULES = ("passo/ports/usb_line.py", "passo/ports/rp2/line_usb.py")
PACKAGES = ("passo", "passo/ports", "passo/ports/rp2")
FIRST = 40  # bytes
LIMIT_US = 20_000_000
READ = """
import hashlib
from time import ticks_us
from passo.ports.usb_line import UsbLine
from passo.ports.rp2.line_usb import Console
console = Console()
if {ring}:
    console._fifo = 0
line = UsbLine(console)
heard = hashlib.sha256()
print("ready")
count = turn = longest = 0
while count < {count}:
    turn = turn * 29 % 1009 + 1
    until = ticks_us() + turn % {pause}
    while ticks_us() < until:
        pass
    if not line.any():
        continue
    data = line.read()
    assert data
    heard.update(data)
    count += len(data)
    longest = max(longest, len(data))
    if longest > 640:
        break
{end}
print("[%s,%d,%d]" % (heard.digest().hex(), longest, line._whole is not None))
"""


@pytest.fixture
def board(uf2):  # noqa: F811
    files = {f"{package}/__init__.py": b"" for package in PACKAGES}
    files.update({module: (FIRMWARE / module).read_bytes() for module in MODULES})
    return EmulatedPico(files=files, uf2=uf2).boot()


def send(board, data, random, pause_us):
    """In bursts, which begin before or after the last one has been read."""
    while data:
        burst = random.choice((1, 2, 63, 64, 65, 128, random.randint(1, 700)))
        board.usb.write(data[:burst])
        data = data[burst:]
        board.run(random.randint(1, pause_us))


@pytest.mark.parametrize("ring", [False, True])
@pytest.mark.parametrize("pause, pause_us", [(20, 400), (300, 3000), (1000, 1000)])
def test_bytes_come_as_they_were_sent(board, show, pause, pause_us, ring):
    """The first ones by the interpreter's own way, the rest by Console's: from TinyUSB's buffer, or, as if that had not been found, from the ring."""
    random = Random(pause)
    data = random.randbytes(12_000)
    board.console.start(READ.format(count=len(data), pause=pause, ring=ring, end="line.close()"))
    board.console.expect(b"ready\r\n")
    send(board, data[:FIRST], random, pause_us)
    board.run(20_000)  # proven only once all have been read
    send(board, data[FIRST:], random, pause_us)
    said = board.console.expect(b"]", LIMIT_US).decode()
    digest, longest, proven = said.strip("[]\r\n ").split(",")
    assert digest == hashlib.sha256(data).hexdigest()
    assert proven == "1"
    assert 64 < int(longest) <= 640
    show("console", f"at most {longest} bytes in one go")
    assert board.exec("print(6 * 7)").strip() == "42"


def test_a_program_that_ends_without_close_leaves_a_console_that_works(board):
    board.console.start(READ.format(count=600, pause=20, ring=False, end="raise ValueError('amid')"))
    board.console.expect(b"ready\r\n")
    send(board, bytes(range(32, 126)) * 7, Random(1), 400)
    board.console.expect(b"ValueError: amid", LIMIT_US)
    board.run(100_000)
    assert board.exec("print(6 * 7)").strip() == "42"


def test_the_keys_that_ask_for_the_repl_are_heard_behind_silence(board):
    """As mpremote sends them, while Console has the bytes."""
    board.console.start(READ.format(count=10_000, pause=20, ring=False, end=""))
    board.console.expect(b"ready\r\n")
    send(board, b"G1X1\r\x03" * 20, Random(2), 400)  # amid a stream they are bytes like any others
    board.run(1_500_000)
    assert b"Traceback" not in board.console.text
    board.usb.write(b"\r\x03")
    board.console.expect(b"KeyboardInterrupt", LIMIT_US)
