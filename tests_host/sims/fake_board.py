"""A MicroPython board behind a pty, as far as mpremote can tell.

Runs under the unix port with a folder as its file system: answers the raw REPL's control characters on stdin and
stdout, and runs what it is sent. `machine.reset()` leaves a file `.reset` behind, `machine.bootloader()` one of its name.
"""

import os
import sys

CTRL_A, CTRL_B, CTRL_D, CTRL_E = b"\x01", b"\x02", b"\x04", b"\x05"


class Machine:
    @staticmethod
    def reset():
        open(".reset", "w").close()

    @staticmethod
    def bootloader():
        open(".bootloader", "w").close()


class BoardOs:
    """The os module, but `stat("")` is the root, as on the file systems of a board."""

    def __getattr__(self, name):
        return getattr(os, name)

    def stat(self, path):
        return os.stat(path or ".")


def write(data):
    sys.stdout.buffer.write(data)


def run(source, names):
    """One piece of code, answered as the raw REPL does: OK, output, 0x04, error, 0x04, prompt."""
    write(b"OK")
    error = b""
    try:
        exec(source, names)
    except BaseException as raised:
        error = ("Traceback (most recent call last):\n%s: %s" % (type(raised).__name__, raised)).encode()
    write(CTRL_D + error + CTRL_D + b">")


def serve():
    names = {"__name__": "__main__"}
    source = b""
    while True:
        byte = sys.stdin.buffer.read(1)
        if not byte:
            return
        if byte == CTRL_A:
            write(b"raw REPL; CTRL-B to exit\r\n>")
            source = b""
        elif byte == CTRL_D and source == b"":
            names = {"__name__": "__main__"}
            write(b"OK\r\nMPY: soft reboot\r\nraw REPL; CTRL-B to exit\r\n>")
        elif byte == CTRL_D:
            run(source, names)
            source = b""
        elif source == CTRL_E and byte == b"A":
            # The faster way of sending code, which mpremote asks for, is refused; it then sends it plainly.
            sys.stdin.buffer.read(1)
            write(b"R\x00")
            source = b""
        elif byte not in (b"\r", b"\x03", CTRL_B) or source:
            source += byte


sys.modules["machine"] = Machine
sys.modules["os"] = BoardOs()
os.chdir(sys.argv[1])
sys.path[0] = ""  # modules are looked for in its files, as on a board
serve()
