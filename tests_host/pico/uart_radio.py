"""A radio for the emulated Pico W, which takes the place of passo/web/radio.py there: connections over UART1, as frames.

A frame is `kind connection length data`; kind O opens a connection, D brings data, C closes it, G collects garbage. rp2040py's own
Wi-Fi carries outbound connections only.
"""

import gc
import io

from machine import UART, Pin, disable_irq, enable_irq

BAUD = 921_600
_POLL = 3
_IN, _OUT = 1, 4
_SENT = 512  # bytes at once; lwIP takes more
_PIECE = 240  # of a frame


class Mux:
    def __init__(self):
        self.uart = UART(1, BAUD, tx=Pin(20), rx=Pin(21), rxbuf=2048, txbuf=1024)
        self.opened = []
        self.sockets = {}
        self._data = b""

    def pump(self):
        state = disable_irq()  # any() holds a lock: an interrupt amid it keeps that of the UART from emptying the FIFO, whose bytes get lost
        waiting = self.uart.any()
        enable_irq(state)
        if waiting:
            self._data += self.uart.read(waiting)  # no more: looking for another byte takes the lock, too
        while len(self._data) >= 3 and len(self._data) >= 3 + self._data[2]:
            kind, number, length = self._data[0], self._data[1], self._data[2]
            data = self._data[3 : 3 + length]
            self._data = self._data[3 + length :]
            if kind == 0x47:
                gc.collect()
            elif kind == 0x4F:
                self.sockets[number] = Socket(self, number)
                self.opened.append(self.sockets[number])
            elif number in self.sockets:
                self.sockets[number].put(data, kind == 0x43)

    def say(self, kind, number, data=b""):
        self.uart.write(bytes((kind, number, len(data))) + data)


class Socket(io.IOBase):
    def __init__(self, mux, number):
        self._mux = mux
        self._number = number
        self._come = b""
        self._ended = False

    def put(self, data, ended):
        self._come += data
        self._ended = self._ended or ended

    def ioctl(self, request, argument):
        if request != _POLL:
            return 0
        return argument & (_OUT | (_IN if self._come or self._ended else 0))

    def setblocking(self, blocking):
        pass

    def setsockopt(self, *option):
        pass

    def recv(self, count):
        if not self._come and not self._ended:
            raise OSError(11)
        data, self._come = self._come[:count], self._come[count:]
        return data

    def send(self, data):
        data = data[:_SENT]
        for at in range(0, len(data), _PIECE):
            self._mux.say(0x44, self._number, bytes(data[at : at + _PIECE]))
        return len(data)

    def close(self):
        self._mux.say(0x43, self._number)
        self._mux.sockets.pop(self._number, None)


class Listener(io.IOBase):
    """Is asked before the sockets, for all of them."""

    def __init__(self, mux):
        self._mux = mux

    def ioctl(self, request, argument):
        if request != _POLL:
            return 0
        self._mux.pump()
        return argument & (_IN if self._mux.opened else 0)

    def setblocking(self, blocking):
        pass

    def accept(self):
        if not self._mux.opened:
            raise OSError(11)
        return self._mux.opened.pop(0), ("192.168.4.2", 1024)

    def close(self):
        pass


class Radio:
    key = "ABCDEFGHJKLMNPQR"
    names = (b"passo.local",)

    def __init__(self, config):
        self._mux = Mux()

    def is_own_peer(self, peer):
        return False

    def listen(self, kind):
        return Listener(self._mux)
