"""Points in batches, from the line into the point buffer: the result is the same as by commands."""

from draws import Random
from passo.batch import Points
from passo.commands import POINT
from passo.control.point_buffer import PointBuffer
from passo.protocols.plotter.host import COMMANDS, Plotter, packet
from passo.steps.word import TICKS_PER_MS
from table import Machine

CASES = {
    "check_the_language": (("seed", "seed"), ("chunk", 1, 90)),
    "check_the_store": (("seed", "seed"), ("capacity", 1, 700)),
    "check_the_machine": (("seed", "seed"), ("chunk", 1, 90)),
}
RUNS = {"check_the_machine": 40}
GAP_MS = 5
NAMES = ("REQUEST", "SPEED", "STATUS", "RIGHT", "LINK", "STOP")


def stream(random, most):
    """Packets, nearly all of them points; most of these have no byte that repeats its neighbour, some are damaged."""
    data = b""
    for _ in range(random.between(1, 60)):
        what = random.between(0, 40)
        if what < 2:
            data += packet(COMMANDS[random.choice(NAMES)], random.between(0, 300))
            continue
        x, y = random.between(0, most), random.between(0, most)
        if what == 2:
            x = x >> 8 | x >> 8 << 8  # two bytes alike
        one = packet(COMMANDS[("MOVE", "LINE")[random.between(0, 1)]], x, y)
        if what == 3:
            at = random.between(0, 5)
            one = (one[:at] + one[at + 1 :], one[: at + 1] + one[at:], one[:at] + random.bytes(1) + one[at + 1 :])[at % 3]
        data += one
    return data


def parts(random, data, chunk):
    """(bytes, milliseconds until the next) of `data`, cut anywhere; now and then the line is quiet for a while."""
    while data:
        size = random.between(1, chunk)
        yield data[:size], (0, 0, 1, 1, GAP_MS, 3000)[random.between(0, 5)]
        data = data[size:]
    yield b"", GAP_MS
    yield b"", 3000


def meaning(command):
    return command.kind, command.target, command.tool, command.value, command.error


class Room:
    """Room for some points, or for none, as chance has it; `points` are the meanings of those that have come."""

    def __init__(self, random):
        self._random = random
        self.batch = Points(0)
        self.batch.join(self.open, self.accept, None)
        self.batch.data = bytearray(300)
        self.batch.most_x, self.batch.most_y = [random.between(60_000, 65_535) for _ in range(2)]
        self.points = []

    def open(self, batch):
        batch.begun = True
        self.batch.offset = self._random.between(0, 40)
        self.batch.room = max(0, self._random.between(-8, 50))
        return True

    def accept(self, batch):
        for at in range(batch.offset, batch.offset + 5 * batch.count, 5):
            tool, x_high, x_low, y_high, y_low = batch.data[at : at + 5]
            self.points.append((POINT, (x_high << 8 | x_low, y_high << 8 | y_low), tool == 1, 0, 0))
        self.open(batch)
        return batch.count


def check_the_language(seed, chunk):
    """Points in batches and commands are what feed() alone makes of the same bytes, however many there is room for."""
    random = Random(seed)
    room = Room(random)
    plain, batched = Plotter(GAP_MS), Plotter(GAP_MS, batch=room.batch)
    now_ms = 7
    for data, wait_ms in parts(random, stream(random, 65535), chunk):
        wanted = [meaning(command) for command in plain.feed(data, now_ms)]
        room.points = []
        answers = batched.take_batch(data, now_ms)
        room.batch.begun = False
        assert answers == b"n" * len(room.points)
        for _, place, _, _, _ in room.points:
            assert place[0] <= room.batch.most_x and place[1] <= room.batch.most_y
        assert room.points + [meaning(command) for command in batched.feed(b"", now_ms)] == wanted
        now_ms += wait_ms


def check_the_store(seed, capacity):
    """Points put into pieces are kept as single ones are, to the last one there is room for, round and round."""
    random = Random(seed)
    plain, short = PointBuffer(capacity), PointBuffer(capacity)
    for _ in range(20):
        piece = short.free_rows()
        assert (piece is None) == (plain.free() == 0)
        count = random.between(0, piece[2]) if piece else 0
        for at in range(count):
            point = random.bytes(5)
            point = bytes((point[0] & 1,)) + point[1:]
            piece[0][piece[1] + 5 * at : piece[1] + 5 * at + 5] = point
            plain.put(point[1] << 8 | point[2], point[3] << 8 | point[4], point[0] == 1)
        short.count += count
        assert short.count == plain.count and short.free() == plain.free()
        for _ in range(random.between(0, plain.count)):
            assert short.take() == plain.take()


def check_the_machine(seed, chunk):
    """Answers, log and stored points of a machine are the same, points outside its travel and a full store included."""
    random = Random(seed)
    room = random.between(10, 80)
    machines = [Machine(store_points=room), Machine(store_points=room)]
    for machine in machines:
        machine.app.controller.machine.homed = bool(seed % 5)
    machines[1].app.links[0].batch = None
    for data, wait_ms in parts(random, stream(random, 1300), chunk):
        said = []
        for machine in machines:
            machine.line.incoming += data
            said.append(machine.cycles(3))
            machine.port.advance(wait_ms * TICKS_PER_MS)
        assert said[0] == said[1]
    short, plain = [machine.app.controller for machine in machines]
    assert short.machine.log.counts == plain.machine.log.counts and short.position() == plain.position()
    stores = short.features["drawing"].points, plain.features["drawing"].points
    assert stores[0].count == stores[1].count
    while stores[0].count:
        assert stores[0].take() == stores[1].take()
