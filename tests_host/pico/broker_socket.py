"""The module `socket` of an emulated Pico W that tells a broker: a connection at whose other end one lets everybody in and, a while later, says STOP."""

import time

_STOP_MS = 8000


class Socket:
    def __init__(self):
        self._comes = b"\x20\x02\0\0"
        self._begun = time.ticks_ms()
        self._said = False

    def setblocking(self, blocks):
        assert not blocks

    def connect(self, address):
        raise OSError(115)

    def send(self, data):
        if bytes(data[-2:]) == b"\xc0\0":
            self._comes += b"\xd0\0"
        return min(len(data), 100)

    def recv(self, count):
        if not self._said and time.ticks_diff(time.ticks_ms(), self._begun) > _STOP_MS:
            self._said = True
            self._comes += b"\x30\x0c\0\x0apasso/stop"
        if not self._comes:
            raise OSError(11)
        data, self._comes = self._comes[:count], self._comes[count:]
        return data

    def close(self):
        pass


def socket():
    return Socket()


def getaddrinfo(host, port):
    return [(0, 0, 0, "", (host, port))]
