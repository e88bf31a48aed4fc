"""A small plotter controller behind a pty, written from the protocol's document alone: it shares no code with Passo.

    with FakePlotter() as fake:
        client = PlotterClient(fake.path)

It remembers the points it drew, can lose or spoil bytes in both directions, and draws `points_per_s`.
"""

import os
import random
import select
import struct
import threading
import time
import tty

TRAVEL = (4000, 3000)


class FakePlotter:
    def __init__(self, points_per_s=1e9, room=10000, torn_s=2.0, seed=0):
        self.points_per_s = points_per_s
        self.room = room
        self.torn_s = torn_s
        self.fault_of_packets = 0.0  # chance that one byte of a packet is dropped, doubled or flipped
        self.lose_answers = 0.0  # chance that an answer never arrives
        self.mute = False
        self.streams = False  # begins to draw as soon as its room is full, and makes room as it draws
        self.alarm = 0
        self.objects = []  # finished ones, as lists of (letter, x, y)
        self.stopped = []  # objects dropped by STOP, as far as they were drawn
        self.received = bytearray()
        self._random = random.Random(seed)
        self._pending = b""
        self._since = self._latest = 0.0
        self._points = []
        self._held = None  # a point for which there is no room yet
        self._drawn = 0.0
        self._drawing_since = None
        self._ended = False  # END has come for the object
        self._error = 0
        self._place = (0, 0)
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._running = False
        self._thread.join()
        self.unplug()

    def unplug(self):
        """The cable is out: both ends of the line are gone."""
        self._running = False
        self._thread.join()  # it finishes its object
        for end in (self._master, self._slave):
            if end is not None:
                os.close(end)
        self._master = self._slave = None

    def drawn_points(self):
        """Return the points drawn of the current object."""
        return self._points[: int(self._drawn)]

    def _run(self):
        while self._running:
            try:
                self._turn()
            except (OSError, TypeError, ValueError):
                if self._running:
                    raise  # and not the end of a line that was unplugged

    def _turn(self):
        ready, _, _ = select.select([self._master], [], [], 0.002)
        now = time.monotonic()
        if ready:
            data = os.read(self._master, 4096)
            self.received += data
            data = self._spoil(data)
            if data and not self._pending:
                self._since = now
            self._latest = now if data else self._latest
            self._pending += data
        self._parse(now)
        self._draw(now)
        if self._held and self._stored() < self.room:
            point, self._held = self._held, None
            self._obey(*point, now)

    def _spoil(self, data):
        if len(data) != 6 or self._random.random() >= self.fault_of_packets:
            return data
        at = self._random.randrange(6)
        kind = self._random.randrange(3)
        if kind == 0:
            return data[:at] + data[at + 1 :]
        if kind == 1:
            return data[: at + 1] + data[at:]
        return data[:at] + bytes([data[at] ^ 1 << self._random.randrange(8)]) + data[at + 1 :]

    def _parse(self, now):
        """A packet counts once the line is quiet and exactly six good bytes have come; all else is asked for again."""
        if not self._pending or now - self._latest < 0.004:
            return
        if len(self._pending) < 6 and now - self._since < self.torn_s:
            return
        data, self._pending = self._pending, b""
        if len(data) != 6 or sum(data[:5]) % 256 != data[5]:
            self._answer(b"r")
            return
        letter, x, y = struct.unpack(">cHH", data[:5])
        self._obey(letter.decode("latin1"), x, y, now)

    def _obey(self, letter, x, y, now):
        if letter in "lm":
            if x > TRAVEL[0] or y > TRAVEL[1]:
                self._error = 104
                return
            if self._stored() >= self.room:
                self._held = (letter, x, y)
                if self.streams and self._drawing_since is None:
                    self._drawing_since = now
                return
            if not self._points:
                self._drawn = 0.0
            self._points.append((letter, x, y))
            self._answer(b"n")
        elif letter == "e":
            self._ended = True
            if self._drawing_since is None:
                self._drawing_since = now
        elif letter == "x":
            done = int(self._drawn)
            if self._points:
                self.stopped.append(self._points[:done])
                self._place = self._points[min(done, len(self._points) - 1)][1:]
            self._points, self._drawing_since, self._ended = [], None, False
            self._answer(b"d")
        elif letter == "?":
            state = 4 if self.alarm else 0 if self._drawing_since is None else 1
            body = struct.pack(">cBBHHHH", b"?", state, self.alarm or self._error, *self._place, int(self._drawn),
                               max(0, self.room - self._stored()))
            self._error = 0
            self._answer(body + bytes([sum(body) % 256]))
        elif letter in "8426":
            dx, dy = {"8": (0, 10), "2": (0, -10), "4": (-10, 0), "6": (10, 0)}[letter]
            self._place = (self._place[0] + dx, self._place[1] + dy)
            self._answer(b"n")
        elif letter in "ros":
            if letter == "o":
                self._place = (0, 0)
            self._answer({"r": b"k", "o": b"o", "s": b"s"}[letter])

    def _stored(self):
        return len(self._points) - (int(self._drawn) if self.streams else 0)

    def _draw(self, now):
        if self._drawing_since is None or self.alarm:
            return
        self._drawn = min((now - self._drawing_since) * self.points_per_s, len(self._points))
        if self._drawn >= len(self._points) and self._ended:
            if self._points:
                self.objects.append(self._points)
                self._place = self._points[-1][1:]
            self._points, self._drawing_since, self._ended = [], None, False
            self._answer(b"d")

    def _answer(self, data):
        if not self.mute and (len(data) > 1 or self._random.random() >= self.lose_answers):
            os.write(self._master, data)


def without_repeats(points):
    """Points with those left out that repeat the one before: a packet sent twice draws nothing more."""
    return [point for index, point in enumerate(points) if not index or point != points[index - 1]]
