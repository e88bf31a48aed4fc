"""The USB port's console as a serial line, clean for bytes. Reading never blocks; writing blocks only while the PC does
not take what has been sent."""

import sys
from select import POLLIN, poll
from time import ticks_diff, ticks_ms

import micropython
from micropython import const

_PACKETS = const(640)  # bytes read in one go: more than a sender may have under way, so that `?` is seen behind it
_FEW = const(64)  # the same where they come one by one
_INTERRUPT = const(3)  # Ctrl-C
_ESCAPE = b"\r\x03"  # the first bytes of mpremote
_SILENCE_MS = const(1000)


class UsbLine:
    """The console's USB port. Ctrl-C is a byte like any other, except as the Enter and Ctrl-C with which tools ask for
    the REPL: these two bytes first after a second's silence end the program by KeyboardInterrupt."""

    def __init__(self, console=None):
        """`console`: takes all that has come in one go, as ports/rp2/line_usb.py; None: nothing does."""
        self._console = console
        self._whole = None  # the console, once it is proven
        self._poll = poll()
        self._poll.register(sys.stdin, POLLIN)
        # Make the objects for reading once: as methods and bytes they would be garbage of each read.
        self._ready = self._poll.ipoll
        self._take = sys.stdin.buffer.readinto
        self._byte = bytearray(1)
        self._data = bytearray(_PACKETS)
        self._view = self._said = memoryview(self._data)
        self.write = sys.stdout.buffer.write  # itself: a method around it would take longer, and `?` waits for both
        self._heard_ms = ticks_ms()
        micropython.kbd_intr(-1)

    def any(self):
        if self._whole:
            return self._whole.any(self._ready)
        for _ in self._ready(0):
            return True
        return False

    @micropython.native
    def read(self):
        """Bytes that have come, at most 640, good until the next read; b"" if none. Raises KeyboardInterrupt when the REPL
        is asked for."""
        count = self._whole.take(self._data, _PACKETS, self._ready) if self._whole else self._read_each()
        if not count:
            return b""
        if count != len(self._said):
            self._said = self._view[:count]
        before_ms = self._heard_ms
        self._heard_ms = ticks_ms()
        if ticks_diff(self._heard_ms, before_ms) >= _SILENCE_MS and bytes(self._said[:2]) == _ESCAPE:
            raise KeyboardInterrupt
        return self._said

    @micropython.native
    def _read_each(self):
        """Return the bytes that have come, read one by one: asked for more than it has, the console waits for them."""
        count = 0
        byte = self._byte
        data = self._data
        take = self._take
        ready = self._ready
        console = self._console
        while count < _FEW:
            for _ in ready(0):
                take(byte)
                data[count] = byte[0]
                count += 1
                break
            else:
                break
            if console and console.check(byte[0]):
                self._whole = console
                break
        return count

    def close(self):
        if self._console:
            self._console.close()
        micropython.kbd_intr(_INTERRUPT)
