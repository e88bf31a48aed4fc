"""The virtual port: words become edges at exactly their ticks, whatever the turns; a halt acts inside a word."""

from draws import Random
from passo.ports import virtual
from passo.ports.virtual import CATCH_UP_TICKS, COARSE_TICKS, FINE_TICKS, IDLE_MS, Nothing, VirtualPort
from passo.steps.ring import Ring
from passo.steps.word import TICKS_PER_MS, Layout

CASES = {
    "check_edges_do_not_depend_on_the_turns": (("seed", "seed"),),
    "check_halt_anywhere": (("seed", "seed"), ("at", 0, 3000)),
}
RUNS = {"check_halt_anywhere": 200}

PULSE_TICKS = 25
BOARD = {
    "drive": {"kind": "step_dir", "pulse_us": 2},
    "axes": [{"name": "x"}, {"name": "y"}],
    "tool": {},
    "inputs": [{"name": "door", "active": 0}, {"name": "probe"}],
    "outputs": [{"name": "enable", "active": 0}],
}
X_STEP, Y_STEP, X_DIR, Y_DIR, TOOL = 1, 2, 4, 8, 16


class Recorder(Nothing):
    """A world that writes down what it sees, and does one thing at one edge."""

    def __init__(self):
        self.seen = []
        self.outputs = []
        self.events = []
        self.levels_in = {}
        self.react = None

    def attach(self, tick, names, levels):
        self.names = names
        self.levels = levels

    def edges(self, tick, levels, changed):
        assert changed == levels ^ self.levels and changed
        self.levels = levels
        self.seen.append((tick, levels))
        if self.react:
            self.react(tick)

    def output(self, tick, name, level):
        self.outputs.append((tick, name, level))

    def input(self, tick, name):
        return self.levels_in.get(name, 0)

    def next_event(self):
        return self.events[0] if self.events else None

    def run(self, tick):
        while self.events and self.events[0] <= tick:
            self.seen.append((self.events.pop(0), "event"))


class Bench:
    """A port with a player and a recorder."""

    def __init__(self, board=BOARD, mode="stepped", sleep=None):
        self.world = Recorder()
        self.port = VirtualPort(board, self.world, mode, None, sleep)
        self.ring = Ring(64)
        layout = Layout("step_dir", 2, 4, ["x_step", "y_step", "x_dir", "y_dir"], 3)
        self.player = self.port.player(self.ring, layout, board)

    def put(self, *words):
        for ticks, levels in words:
            self.ring.words[self.ring.head & self.ring.mask] = ticks << 5 | levels
            self.ring.head += 1


def random_words(random):
    words = []
    for _ in range(random.between(1, 60)):
        words.append((random.between(10, 200), random.between(0, 31)))
    return words


def expected_edges(words):
    """[(tick, levels)] as the contract has it: levels at the word's start, pulses down again later."""
    edges = []
    tick = now = 0
    for ticks, levels in words:
        if levels != now:
            edges.append((tick, levels))
        now = levels & ~3
        if levels & 3:
            edges.append((tick + min(PULSE_TICKS, ticks), now))
        tick += ticks
    return edges, tick


def check_edges_do_not_depend_on_the_turns(seed):
    random = Random(seed)
    words = random_words(random)
    edges, end = expected_edges(words)
    bench = Bench()
    bench.put(*words)
    bench.player.start()
    while bench.player.busy():
        bench.port.advance(random.between(1, 300))
    bench.port.advance(1)  # a pulse that ends with the last word falls at its end
    assert bench.world.seen == edges, (bench.world.seen, edges)
    assert bench.player.words_played() == len(words)
    assert bench.port.now >= end


def check_halt_anywhere(seed, at):
    words = random_words(Random(seed))
    edges, end = expected_edges(words)
    starts = [sum([ticks for ticks, _ in words[:i]]) for i in range(len(words))]
    bench = Bench()
    bench.put(*words)
    bench.player.start()
    if at:
        bench.port.advance(at)
    bench.player.halt()
    before = [edge for edge in edges if edge[0] < at]
    levels = before[-1][1] if before else 0
    if levels & TOOL:
        before.append((at, levels & ~TOOL))
    if levels & 3:  # the pulse lasts as long as it should
        before.append(([edge for edge in edges if edge[0] >= at][0][0], levels & ~(3 | TOOL)))
    assert bench.player.words_played() == len([start for start in starts if start < at])
    assert not bench.player.busy()
    bench.port.advance(5000)
    assert bench.world.seen == before, (bench.world.seen, before)
    # The words left are played after start(), from then on.
    left = words[bench.player.words_played() :]
    bench.player.start()
    assert bench.player.busy() == bool(left)
    bench.port.advance(20000)
    assert bench.player.words_played() == len(words) and not bench.player.busy()


def check_stop_lets_the_word_end():
    bench = Bench()
    bench.put((100, X_STEP | TOOL), (100, Y_STEP))
    bench.player.start()
    bench.port.advance(10)
    bench.player.stop()
    assert bench.player.busy() and bench.player.words_played() == 1
    bench.port.advance(300)
    assert bench.world.seen == [(0, X_STEP | TOOL), (25, TOOL)]
    assert not bench.player.busy() and bench.player.words_played() == 1


def check_world_may_stop_and_halt_inside_an_edge():
    for name, seen in (("halt", [(0, X_STEP | TOOL), (0, X_STEP), (25, 0)]), ("stop", [(0, X_STEP | TOOL), (25, TOOL)])):
        bench = Bench()
        bench.put((100, X_STEP | TOOL), (100, Y_STEP))
        act = getattr(bench.player, name)

        def react(tick):
            bench.world.react = None
            act()

        bench.world.react = react
        bench.player.start()
        bench.port.advance(300)
        assert bench.world.seen == seen, (name, bench.world.seen)
        assert bench.player.words_played() == 1 and not bench.player.busy()


def check_words_that_come_late_start_when_they_come():
    bench = Bench()
    bench.player.start()
    assert not bench.player.busy()
    bench.port.advance(1000)
    bench.put((100, X_DIR))
    assert bench.player.busy()
    bench.port.advance(50)
    assert bench.world.seen == [(1000, X_DIR)] and bench.player.busy()
    bench.port.advance(50)
    assert not bench.player.busy()
    bench.player.rest(X_DIR | TOOL)
    bench.player.rest(X_DIR | TOOL)
    assert bench.world.seen[1:] == [(1100, X_DIR | TOOL)]


def check_polarity():
    board = dict(BOARD)
    board["drive"] = {"kind": "step_dir", "pulse_us": 2, "step_active": 0}
    board["axes"] = [{"name": "x", "reversed": True}, {"name": "y"}]
    board["tool"] = {"active": 0}
    bench = Bench(board)
    assert bench.world.names == ["x_step", "y_step", "x_dir", "y_dir", "tool"]
    inverted = X_STEP | Y_STEP | X_DIR | TOOL
    assert bench.world.levels == inverted
    bench.put((100, X_STEP | X_DIR), (100, Y_DIR))
    bench.player.start()
    bench.port.advance(200)
    assert bench.world.seen == [
        (0, inverted ^ (X_STEP | X_DIR)),
        (25, inverted ^ X_DIR),
        (100, inverted ^ Y_DIR),
    ]


def check_inputs_and_outputs():
    bench = Bench()
    port = bench.port
    assert port.input("door") and not port.input("probe")
    bench.world.levels_in = {"door": 1, "probe": 1}
    assert not port.input("door") and port.input("probe")
    port.advance(7)
    port.output("enable", True)
    port.output("enable", False)
    assert bench.world.outputs == [(7, "enable", 0), (7, "enable", 1)]


def check_events_come_between_edges():
    bench = Bench()
    bench.world.events = [60, 150]
    bench.put((100, X_DIR), (100, 0))
    bench.player.start()
    bench.port.advance(1000)
    assert bench.world.seen == [(0, X_DIR), (60, "event"), (100, 0), (150, "event")]
    assert bench.port.now == 1000


def check_stepped_time():
    bench = Bench()
    port = bench.port
    port.wait(False)
    assert port.now == TICKS_PER_MS and port.machine_ms() == port.link_ms() == 1
    port.wait(True)
    port.wait(True, True)
    assert port.now == TICKS_PER_MS + COARSE_TICKS + FINE_TICKS


class Wall:
    """A wall clock in the place of the real one, which passes only in sleep."""

    def __init__(self, mode):
        self.ns = 5000000
        self.slept = []
        self.kept = virtual.wall_ns
        virtual.wall_ns = lambda: self.ns
        self.bench = Bench(BOARD, mode, self.sleep)

    def sleep(self, milliseconds):
        self.slept.append(milliseconds)
        self.ns += milliseconds * 1000000

    def close(self):
        virtual.wall_ns = self.kept


def check_fast_time_jumps_only_while_something_is_pending():
    wall = Wall("fast")
    try:
        port = wall.bench.port
        port.wait(True)
        assert port.now == COARSE_TICKS and not wall.slept
        wall.bench.world.events = [10 * TICKS_PER_MS]
        port.wait(False)
        assert port.now == 2 * COARSE_TICKS and not wall.slept
        port.wait(False)
        assert port.now == 2 * COARSE_TICKS and wall.slept == [IDLE_MS]
        port.wait(False)
        assert port.now == 2 * COARSE_TICKS + IDLE_MS * TICKS_PER_MS
        assert port.link_ms() == 5 + 2 * IDLE_MS
    finally:
        wall.close()


def check_real_time_follows_the_wall_and_never_skips():
    wall = Wall("real")
    try:
        port = wall.bench.port
        for _ in range(20):
            port.wait(True)
        assert port.now == sum(wall.slept[:-1]) * TICKS_PER_MS
        before = port.now
        wall.ns += 3600 * 1000000000
        port.wait(True)
        assert port.now == before + COARSE_TICKS, "motion goes on where it was"
        before, times = port.now, len(wall.slept)
        wall.ns += 40 * 1000000
        port.wait(True)
        port.wait(True)
        assert port.now == before + 2 * CATCH_UP_TICKS and len(wall.slept) == times, "it comes level by long cycles, without a sleep"
        port.wait(True, True)
        assert port.now == before + 2 * CATCH_UP_TICKS + FINE_TICKS, "not while it homes"
    finally:
        wall.close()


def check_mode_is_checked():
    try:
        VirtualPort(BOARD, None, "slow")
    except ValueError as error:
        assert "slow" in str(error)
    else:
        raise AssertionError("taken")


def check_a_board_with_nothing_wired():
    port = VirtualPort(BOARD)
    line = port.serial({"name": "pc"})
    line.incoming = b"abc"
    assert line.read() == b"abc" and line.read() == b""
    line.write(bytearray(b"k"))
    assert port.serial({"name": "pc"}).outgoing == b"k"
    ring = Ring(64)
    player = port.player(ring, Layout("step_dir", 2, 4, ["x_step", "y_step", "x_dir", "y_dir"], 3), BOARD)
    ring.words[0] = 100 << 5 | X_STEP
    ring.head += 1
    player.start()
    port.wait(True)
    port.output("enable", True)
    assert player.words_played() == 1 and player.levels() == 0 and port.input("door")
