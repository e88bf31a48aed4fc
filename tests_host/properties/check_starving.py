"""A stream that brings lines more slowly than the machine could play them slows it down: it does not stand and wait for more."""

from boards.laser_xy import BOARD
from passo.app import App
from passo.config.boardfile import check
from passo.ports.virtual import Nothing, VirtualPort
from passo.steps.word import TICKS_PER_MS, TICKS_PER_S

CASES = {
    "check_a_starved_stream_does_not_stand": (
        ("rate", "choice", 653, 980), ("share", 50, 150), ("what", "choice", b"lines", b"M3", b"M4"),
        ("accel_mm_s2", "choice", 1500, 5000, 20_000), ("row", "choice", 40, 100, 800), ("pause_ms", "choice", 0, 20),
    ),
}  # fmt: skip
RUNS = {"check_a_starved_stream_does_not_stand": 12}
EXAMPLES = {"check_a_starved_stream_does_not_stand": ((653, 150, b"M3", 5000, 40, 0), (980, 150, b"lines", 20_000, 800, 20))}

LINES = 400  # or as many as a row has
PAUSE_LINES = 200
STEPS_MM = 80
STAND_MS = 5
WINDOW = 127  # bytes under way of a sender that counts characters
READ = 64  # bytes that come at once
LOOK_TICKS = TICKS_PER_MS // 10  # the main loop looks at a line that has brought nothing
FEED_TICKS = 2 * TICKS_PER_MS  # between two calls of the interrupt that makes words
LEAD_TICKS = 12 * TICKS_PER_MS


class Steps(Nothing):
    """A world that keeps the ticks of all steps."""

    def __init__(self):
        self.ticks = []

    def attach(self, tick, names, levels):
        self._step = 1 << names.index("x_step") | 1 << names.index("y_step")

    def edges(self, tick, levels, changed):
        if changed & levels & self._step:
            self.ticks.append(tick)


class Chip(VirtualPort):
    """Its words are made by an interrupt, as a chip's; time passes as the main loop takes lines off the wire."""

    lead_ticks = LEAD_TICKS

    def feed_from_interrupt(self, feeder, player):
        VirtualPort.feed_from_interrupt(self, feeder, player)
        self._feeder = feeder
        self._due = 0
        return True

    def set_out(self, live):
        if self._player.words_played() == self._feeder.ring.head:
            self._feed()

    def wait(self, busy, fine=False, at_once=False):
        if not at_once and not self.lines["pc"].any():
            self.work(TICKS_PER_MS)

    def work(self, ticks):
        """Keep the main loop busy for `ticks`."""
        end = self.now + ticks
        while self.now < end:
            if self.now >= self._due:
                self._due = self.now + FEED_TICKS
                if self._feeder.open:
                    self._feed()
            self.advance(min(end, self._due) - self.now)

    def _feed(self):
        self._feeder.fill(self._player.words_played(), LEAD_TICKS)
        self._player.start()


class Wire:
    """The board's end of a line: at the other one a sender counts characters, and answers at once. The board takes a line in
    `ticks`, and collects garbage for `pause_ticks` every PAUSE_LINES."""

    def __init__(self, ticks, pause_ticks):
        self.port = None
        self.ticks = ticks
        self.pause_ticks = pause_ticks
        self._lines = []
        self._sent = self._answered = 0
        self._under_way = 0
        self._coming = b""

    def send(self, lines):
        self._lines += lines
        self._fill()

    def _fill(self):
        while self._sent < len(self._lines) and self._under_way + len(self._lines[self._sent]) <= WINDOW:
            self._coming += self._lines[self._sent]
            self._under_way += len(self._lines[self._sent])
            self._sent += 1

    def done(self):
        return self._answered == len(self._lines)

    def any(self):
        return len(self._coming)

    def read(self):
        if not self._coming:
            self.port.work(LOOK_TICKS)
        data = self._coming[:READ]
        self._coming = self._coming[READ:]
        return data

    def write(self, data):
        data = bytes(data)
        assert b"error" not in data and b"ALARM" not in data, data
        count = data.count(b"ok")
        for _ in range(count):
            self._under_way -= len(self._lines[self._answered])
            self._answered += 1
            if self._answered % PAUSE_LINES == 0:
                self.port.work(self.pause_ticks)
        self.port.work(count * self.ticks)
        self._fill()


def stream(setup, lines, rate, accel_mm_s2, pause_ms):
    """The ticks of the steps of `lines` where the board takes `rate` of them a second."""
    board = check(BOARD)
    for axis in board["axes"]:
        axis["accel_mm_s2"] = accel_mm_s2
        axis["max_mm_min"] = 20_000
    board["links"] = board["links"][:1]
    world = Steps()
    wire = Wire(TICKS_PER_S // rate, pause_ms * TICKS_PER_MS)
    port = wire.port = Chip(board, world, lines={"pc": wire})
    app = App(board, port)

    def send(lines):
        wire.send(lines)
        silent = 0
        while silent < 50:
            app.cycle()
            silent = 0 if app.controller.busy() or not wire.done() else silent + 1

    send([b"$X\n"] + setup)
    world.ticks.clear()
    send(lines)
    return world.ticks


def check_a_starved_stream_does_not_stand(rate, share, what, accel_mm_s2, row, pause_ms):
    """Rows back and forth, the lines or dots of which the machine plays at `share` % of the rate at which they come."""
    um = 200 if what == b"lines" else 100
    mm_min = rate * share * um * 60 // 100_000
    setup = [b"G21G91G1F%d\n" % mm_min, b"X-1\n"]
    if what != b"lines":
        setup.append(what + b"S0\n")
    count = max(LINES, row)
    lines = []
    for number in range(count):
        line = b"X0.%d" % (um // 100) if number // row % 2 == 0 else b"X-0.%d" % (um // 100)
        lines.append(line + (b"\n" if what == b"lines" else b"S%d\n" % (number * 397 % 999 + 1)))
    ticks = stream(setup, lines, rate, accel_mm_s2, pause_ms)
    assert len(ticks) == count * um * STEPS_MM // 1000
    longest = max([after - before for before, after in zip(ticks, ticks[1:])])
    assert longest <= STAND_MS * TICKS_PER_MS, longest / TICKS_PER_MS
    if row == count:
        mm_s = mm_min / 60
        played_s = count * um / 1000 / mm_s
        came_s = count / rate + count // PAUSE_LINES * pause_ms / 1000
        ramp_s = min(mm_s, rate * um / 1000) / accel_mm_s2
        assert (ticks[-1] - ticks[0]) / TICKS_PER_S <= 1.05 * max(played_s, came_s) + ramp_s
