"""The board's HTTP server, real sockets, its own time: a client that does not read its answer holds a slot for a second at most."""

import socket
import time

from passo.web.files import Folder
from passo.web.http import SLOTS, Server

STOP = b"POST /stop HTTP/1.1\r\nHost: passo\r\n\r\n"
LOOKS = 20  # at a socket, 0.02 s each, while an answer is unread
GET = b"GET /big.html HTTP/1.1\r\nHost: passo\r\n\r\n"


class Open:
    """Everybody may."""

    def refusal_status(self, connection, browser):
        return 0

    def headers(self):
        return b""


def served(tmp_path):
    (tmp_path / "big.html").write_bytes(b"x" * 8_000_000)  # more than sockets hold
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    listener.bind(("127.0.0.1", 0))
    listener.listen(50)
    server = Server(listener, Folder(str(tmp_path) + "/"), Open(), None, False)
    server.calls[b"/stop"] = lambda body: b"{}"
    return server, listener.getsockname()


def connect(address, data):
    made = socket.socket()
    made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    made.connect(address)
    made.sendall(data)
    made.settimeout(0.02)
    return made


def polled(server, now_ms, count=400):
    for _ in range(count):
        server.poll(now_ms)


def stops(server, address, now_ms):
    """Whether STOP is answered."""
    asking = connect(address, STOP)
    try:
        for _ in range(LOOKS):
            polled(server, now_ms)
            try:
                return b" 200" in asking.recv(4096)
            except TimeoutError:
                continue
        return False
    finally:
        asking.close()


def test_an_answer_that_is_not_read_makes_room(tmp_path):
    server, address = served(tmp_path)
    taken = [connect(address, GET) for _ in range(SLOTS)]
    polled(server, 0)
    assert len(server.connections) == SLOTS and not stops(server, address, 500)
    assert stops(server, address, 1600), "it took nothing since 500, at the latest"
    assert stops(server, address, 1700)
    for each in taken:
        each.close()
    server.close()


def test_one_that_is_read_slowly_stays(tmp_path):
    server, address = served(tmp_path)
    reading = connect(address, GET)
    polled(server, 0)
    others = [connect(address, GET) for _ in range(SLOTS - 1)]
    for _ in range(LOOKS):  # until the sockets are full
        polled(server, 0)
        time.sleep(0.02)
    for now_ms in range(300, 3000, 300):
        assert len(reading.recv(65_536)) > 0
        polled(server, now_ms)
        if now_ms > 1100:
            assert stops(server, address, now_ms)
    assert len(reading.recv(65_536)) > 0
    for each in [reading, *others]:
        each.close()
    server.close()
