"""The REPL of an emulated Pico, as mpremote uses it: the raw REPL, over USB.

    console = Console(pico)
    console.exec("print(1 + 1)")        # '2\\r\\n'; raises RemoteError with the traceback
    console.start("while True: pass")   # returns once it runs
    console.send(b"\\x03")
    console.expect(b"KeyboardInterrupt")

Time limits are microseconds of emulated time.
"""

SLICE_US = 200
EXEC_LIMIT_US = 60_000_000
PROMPT_LIMIT_US = 10_000_000
_INTERRUPT, _RAW, _FRIENDLY, _RUN = b"\r\x03\x03", b"\x01", b"\x02", b"\x04"


class RemoteError(Exception):
    """The code on the Pico raised: its output so far and the traceback."""


class Console:
    def __init__(self, pico):
        self.text = bytearray()  # output of the Pico that has not been taken
        self._pico = pico
        pico.usb.heard = self.text.extend

    def send(self, data):
        self._pico.usb.write(data)

    def take_output(self):
        """Return the output since the last `take_output`."""
        said = bytes(self.text)
        self.text.clear()
        return said

    def expect(self, wanted, limit_us=PROMPT_LIMIT_US):
        """Wait for `wanted`; returns the output up to its end. Raises TimeoutError."""
        if not self._pico.run_until(lambda: wanted in self.text, limit_us, SLICE_US):
            raise TimeoutError(f"{wanted!r} was not said; the last was {bytes(self.text[-300:])!r}")
        end = self.text.index(wanted) + len(wanted)
        said = bytes(self.text[:end])
        del self.text[:end]
        return said

    def start(self, code, limit_us=PROMPT_LIMIT_US):
        """Interrupt what runs, and start `code`."""
        self.text.clear()
        self.send(_INTERRUPT)
        self._pico.run(5000)
        self.send(_RAW)
        self.expect(b"raw REPL; CTRL-B to exit\r\n>", limit_us)
        self.send(code.encode() + _RUN)
        self.expect(b"OK", limit_us)

    def exec(self, code, limit_us=EXEC_LIMIT_US):
        """Run `code` and return what it printed. Globals stay for the next call."""
        self.start(code)
        output = self.expect(b"\x04", limit_us)[:-1].decode()
        error = self.expect(b"\x04", limit_us)[:-1].decode()
        if error:
            raise RemoteError(output + error)
        return output

    def soft_reset(self):
        """As Ctrl-D at the prompt: the interpreter starts anew and runs main.py."""
        self.text.clear()
        self.send(_INTERRUPT)
        self._pico.run(5000)
        self.send(_FRIENDLY + _RUN)
