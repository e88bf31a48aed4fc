"""The two ends that `passo prove` talks to: a board on a serial port, and an emulated Pico. Both run code in the raw REPL.

    with PortBoard("/dev/ttyACM0") as board:        # or EmulatedBoard("router_3axis")
        board.restart_interpreter()                               # the interpreter anew, main.py not run
        board.exec("print(1)")                      # '1\\r\\n'; Failure with the board's last line if it raises
        board.start(code); board.expect(b"ready")   # a program that talks while it runs; board.wait_for_end() returns the rest of its output
        board.now_s()                               # the PC's clock; of an emulated board its own outside
    board_file_of(board)                        # the table of its board file
"""

import ast
import contextlib
import io
import struct
import time

from host_tools.failure import Failure
from host_tools.language import _

EXEC_S = 120
ASK_S = 30
_PRESS_S = 30  # for somebody to press the reset button
_SILENCE_S = 1.2  # behind it a program that serves a link obeys Ctrl-C (passo/ports/usb_line.py)


class Silent(Failure):
    """The board does not answer any more, whatever is asked."""


class Board:
    """The raw REPL of a board; both ends have write(), read() and wait_s()."""

    heard = b""
    emulated = False

    def __enter__(self):
        return self

    def __exit__(self, error, *_about):
        if error is not None:
            self.wait_s(_SILENCE_S)
        self.close()

    def take_output(self):
        """Return all bytes received since the last call."""
        self.heard += self.read()
        said, self.heard = self.heard, b""
        return said

    def expect(self, wanted, limit_s=ASK_S):
        """Return the bytes received up to the end of `wanted`. Raises Failure if they do not come in `limit_s`."""
        end = self.now_s() + limit_s
        while wanted not in self.heard:
            if self.now_s() > end:
                raise Failure("the board does not answer any more: {!r} was the last it said", self.heard[-80:].decode("utf-8", "replace"))
            self.wait_s(0.001)
            self.heard += self.read()
        at = self.heard.index(wanted) + len(wanted)
        said, self.heard = self.heard[:at], self.heard[at:]
        return said

    def exec(self, code, limit_s=EXEC_S):
        self.start(code)
        return self.wait_for_end(limit_s)

    def wait_for_end(self, limit_s=EXEC_S):
        """Wait for the end of the program of start(); returns its output, text. Raises Failure if it ended with an error, or not in `limit_s`."""
        said = self.expect(b"\x04", limit_s)[:-1]
        self.check_for_error(limit_s)
        return said.decode("utf-8", "replace")

    def check_for_error(self, limit_s=EXEC_S):
        """Wait for the second half of a program's end, its error. Raises Failure if there is one."""
        error = self.expect(b"\x04", limit_s)[:-1].decode("utf-8", "replace").strip()
        self.expect(b">")
        if error:
            raise Failure("on the board: {}", error.splitlines()[-1])


class EmulatedBoard(Board):
    emulated = True

    def __init__(self, board, uf2=None):
        """A Pico with nothing wired to it. `board`: a name or a path; `uf2`: Passo's, else MicroPython's with the firmware as files."""
        from host_tools.emulator.frozen import board_file
        from host_tools.emulator.machine import firmware_files
        from host_tools.emulator.pico import EmulatedPico

        self.name = _("an emulated Pico")
        self.pico = EmulatedPico(files=board_file(board) if uf2 else firmware_files(str(board)), uf2=uf2).boot()

    def restart_interpreter(self):
        """Soft-reset the interpreter into the raw REPL, main.py not run."""
        self.pico.console.start("pass")
        self.pico.console.expect(b"\x04\x04>")
        self.write(b"\x04")
        self.pico.console.expect(b"raw REPL; CTRL-B to exit\r\n>")
        self.heard = b""

    def start(self, code):
        self.heard = b""
        self.pico.console.start(code)

    def write(self, data):
        self.pico.usb.write(data)

    def read(self):
        return self.pico.console.take_output()

    def wait_s(self, seconds):
        self.pico.run(round(seconds * 1e6))

    def now_s(self):
        return self.pico.now_us / 1e6

    def await_reset(self, limit_s):
        """Run until the board has reset itself, and is back. Raises TimeoutError."""
        self.pico.await_reset(round(limit_s * 1e6))

    def close(self):
        """Nothing is left of it."""


class PortBoard(Board):
    answer_s = 3  # for the interpreter to be there again after a soft reset

    def __init__(self, port):
        self.name = port
        self._wire = None
        self._open_port()

    def _open_port(self):
        """Open the serial port. Raises Failure with its name and the cause."""
        from mpremote.transport import TransportError
        from mpremote.transport_serial import SerialTransport

        try:
            with contextlib.redirect_stdout(io.StringIO()):
                self._wire = SerialTransport(self.name, timeout=self.answer_s)
        except (TransportError, OSError) as error:
            raise Failure("{}: {}", self.name, str(error)) from None

    def restart_interpreter(self):
        """Soft-reset the interpreter into the raw REPL, main.py not run; try for _PRESS_S seconds, and ask for the reset button. Raises Silent."""
        from mpremote.transport import TransportError

        end = self.now_s() + _PRESS_S
        asked = False
        while True:
            try:
                with contextlib.redirect_stdout(io.StringIO()):
                    if self._wire is None:
                        self._open_port()
                    self._wire.enter_raw_repl(timeout_overall=self.answer_s)
                self.expect(b">")
                break
            except (TransportError, OSError, Failure):
                if self.now_s() > end:
                    raise Silent(
                        "no MicroPython board answers on {}: is it the right port (passo ports), and does no other program use it? A running Passo "
                        "lets go for two seconds after a reset", self.name) from None  # fmt: skip
                if not asked:
                    print(_("the board is at work, or silent: press its reset button, or unplug it and plug it in again"), flush=True)
                    asked = True
                self._drop_port()
                self.wait_s(0.2)
        self.heard = b""

    def start(self, code):
        """Send code in raw paste mode and let it run. Raises Failure if the board does not take it."""
        from mpremote.transport import TransportError

        self.take_output()
        try:
            self._wire.serial.write(b"\x05A\x01")
            if self._wire.serial.read(2) != b"R\x01":
                raise Failure("{} does not take code: it wants MicroPython 1.26 or later", self.name)
            self._wire.raw_paste_write(code.encode())
        except (TransportError, OSError, struct.error) as error:
            raise Failure("{} does not take code: {}", self.name, str(error)) from None

    def write(self, data):
        with self._wire_there():
            self._wire.serial.write(data)

    def read(self):
        with self._wire_there():
            serial = self._wire.serial
            return serial.read(serial.in_waiting) if serial.in_waiting else b""

    @contextlib.contextmanager
    def _wire_there(self):
        """Turn an OSError of the port, such as an unplugged cable, into a Failure."""
        try:
            yield
        except OSError as error:
            raise Failure("{} has gone: {}", self.name, str(error)) from None

    def wait_s(self, seconds):
        time.sleep(seconds)

    def now_s(self):
        return time.monotonic()

    def await_reset(self, limit_s):
        """Wait until the port has gone, as USB does in a reset, and come again. Raises TimeoutError."""
        end = self.now_s() + limit_s
        with contextlib.suppress(Failure):
            while self.now_s() < end:
                self.wait_s(0.02)
                self.read()
            raise TimeoutError(_("the port does not go"))
        self._drop_port()
        while self.now_s() < end:
            self.wait_s(0.2)
            with contextlib.suppress(Failure):
                self._open_port()
                return
        raise TimeoutError(_("the port does not come back"))

    def _drop_port(self):
        """Close the port, even one that has gone: as long as it is open, the board gets another name when it comes back."""
        if self._wire is not None:
            with contextlib.suppress(OSError):
                self._wire.close()
            with contextlib.suppress(OSError):
                self._wire.serial.close()
            self._wire = None

    def close(self):
        """Reset the board, so that it goes back to its own work, and close the port."""
        if self._wire is not None:
            with contextlib.suppress(OSError):
                self._wire.serial.write(b"\r\x03\x02\x04")
        self._drop_port()


def board_file_of(board):
    """Return the table of /board.py. Raises Failure if there is none."""
    board.restart_interpreter()
    try:
        return ast.literal_eval(board.exec("from board import BOARD\nprint(repr(BOARD))"))
    except Failure as failure:
        raise Failure("there is no board file on {}: {}. passo flash puts one there", board.name, failure) from None
