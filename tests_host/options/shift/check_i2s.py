"""The ESP32's player for shift registers, on a fake I2S with registers behind it: frames against words, bounds of buffers, stops,
and whole jobs whose path is that of the virtual board."""

import fake_esp32
import router
from boards.router_esp32 import BOARD as ROUTER
from check_control import copy
from fake_esp32 import chip
from passo.app import App
from passo.config.boardfile import BoardError, check
from passo.ports.esp32 import frames_viper
from passo.steps.ring import Ring
from passo.steps.wiring import word_pins
from passo.steps.word import Layout
from plain import plain

CASES = {
    "check_edges": (("words", "list", 60, ("ticks", 100, 9000), ("levels", 0, 31)), ("late_us", 0, 11_000), ("pulse", 1, 150)),
    "check_the_kernel_and_its_plain_twin": (("words", "list", 60, ("ticks", 1, 900), ("levels", 0, 31)), ("flip", 0, 1 << 14)),
    "check_an_under_run": (("words", "list", 60, ("ticks", 100, 9000), ("levels", 0, 31)), ("at", 0, 30), ("stall_us", 9000, 90_000)),
    "check_a_collection_in_psram": (("words", "list", 60, ("ticks", 100, 9000), ("levels", 0, 31)), ("at", 0, 30), ("stall_us", 22_000, 27_000)),
    "check_halt_anywhere": (("words", "list", 60, ("ticks", 100, 9000), ("levels", 0, 31)), ("us", 0, 60_000)),
}
RUNS = {"check_edges": 60, "check_an_under_run": 60, "check_a_collection_in_psram": 60, "check_halt_anywhere": 200}
OUTPUTS = (1, 3, 2, 4, 7)
SECTION = {"clock": 16, "latch": 17, "data": 21, "enable": -1}
SENT_US = 16_384 + 2048  # frames on their way, and time to the next pump
LATE_US = 11_000  # a pump may come this much later than after 2 ms
FRAME = 50
NOT_QUICK = ("check_words_of_every_kind",)


class Counting:
    """Counts the steps of two axes as drivers would, and writes down each level."""

    def attach(self, tick, names, levels):
        self.place = [0, 0]
        self.steps = 0

    def edges(self, tick, levels, changed):
        for axis in range(2):
            if changed & levels & 1 << axis:
                self.place[axis] += 1 if levels & 4 << axis else -1
                self.steps += 1


def bench(pulse_ticks=25, invert=0, enable=-1, layout=None, outputs=OUTPUTS, size=4096, psram=False):
    chip.reset()
    layout = layout or Layout("step_dir", 2, 4, ["x_step", "y_step", "x_dir", "y_dir"], 3)
    ring = Ring(size)
    player = fake_esp32.i2s_player.I2sPlayer(ring, layout, outputs, pulse_ticks, invert, dict(SECTION, enable=enable), psram)
    world = Counting()
    chip.wire_register(world, outputs, layout)
    return ring, player, layout, world


def put(ring, layout, words):
    for ticks, levels in words:
        ring.words[ring.head & ring.mask] = ticks << layout.bits | levels
        ring.head += 1


def run(player, us, late_us=0):
    """Let time pass, with a pump() every 2 ms and `late_us`."""
    while us > 0:
        player.pump()
        passed = min(us, 2000 + late_us)
        chip.stall(passed)
        us -= passed


def play(player, late_us=0):
    while player.busy():
        run(player, 2000 + late_us, late_us)
    run(player, 8000)


def legal(player, words):
    """Words as the feeder makes them: none shorter than the player allows, a wait as long as it is."""
    return [(max(ticks, player.min_word_ticks), levels) for ticks, levels in words]


def place_of(words):
    place = [0, 0]
    for _, levels in words:
        for axis in range(2):
            if levels & 1 << axis:
                place[axis] += 1 if levels & 4 << axis else -1
    return place


def rises(edges, mask):
    return [edges[i][0] for i in range(1, len(edges)) if edges[i][1] & ~edges[i - 1][1] & mask]


def check_edges(words, late_us, pulse):
    """Each word's levels appear within half a frame of its time, errors never add up; pulses last as long as they should, and as
    long they are low; callbacks that come up to 10 ms late change nothing."""
    ring, player, layout, world = bench(pulse)
    words = legal(player, words)
    put(ring, layout, words)
    player.start()
    play(player, late_us)
    assert player.under_runs == 0 and chip.i2s.torn == 0
    assert player.words_played() == len(words) == ring.head
    assert world.place == place_of(words)
    due = 0
    wanted = []
    for ticks, levels in words:
        wanted.append((due, levels))
        due += ticks
    for axis in range(2):
        at = [tick for tick, levels in wanted if levels & 1 << axis]
        seen = rises(chip.edges, 1 << axis)
        assert len(at) == len(seen)
        if not at:
            continue
        # The stream begins on a frame: the first word is where it should be, all others are measured from there.
        first = begin(words, chip.edges, layout)
        for i in range(len(at)):
            assert abs(seen[i] - first - at[i]) <= FRAME // 2, (i, seen[i] - first, at[i])
            assert i == 0 or seen[i] - seen[i - 1] >= player.min_word_ticks
        for i in range(1, len(chip.edges)):
            tick, levels = chip.edges[i]
            if levels & 1 << axis and not chip.edges[i - 1][1] & 1 << axis:
                low = [at for at, rest in chip.edges[i:] if not rest & 1 << axis][0]
                assert pulse <= low - tick < pulse + FRAME


def begin(words, edges, layout):
    """Tick at which the first word began: found by the first level that differs from those at rest."""
    due = 0
    for ticks, levels in words:
        if levels:
            # On the grid: rounded, half a frame up.
            return edges[1][0] - (due + FRAME // 2) // FRAME * FRAME
        due += ticks
    return edges[0][0]


def check_the_kernel_and_its_plain_twin(words, flip):
    """The same frames, and the same counts, in blocks of any length; words shorter than a frame are seen too."""
    twin = plain(frames_viper)
    ring, player, layout, _ = bench()
    put(ring, layout, words)
    from array import array

    results = []
    for make, advance in ((frames_viper.make, frames_viper.advance), (twin["make"], twin["advance"])):
        state = array("i", player._state)
        state[frames_viper.FLIP] = flip << 1 & ~player_frames(player)
        state[frames_viper.HEAD] = ring.head
        starts = array("i", [0] * ring.size)
        seen = []
        for count in (1, 7, 256, 256, 256, 64, 256):
            frames = array("i", [0] * 256)
            make(frames, 0, 0, count, state, ring.words, starts, player._table)
            advance(state, ring.words, starts, state[frames_viper.FRAME] - 100)
            seen.append((list(frames), list(state), list(starts)[: len(words)]))
        results.append(seen)
    assert results[0] == results[1]
    if words:
        shown = results[0][-1][2]
        made = results[0][-1][1][frames_viper.NEXT]
        assert all([shown[i] < shown[i + 1] for i in range(made - 1)])


def player_frames(player):
    used = 0
    for output in OUTPUTS:
        used |= fake_esp32.i2s_player.frame_of(output)
    return used


def check_an_under_run(words, at, stall_us):
    """A stall longer than the frames last: the registers get zeros, it is counted, every step comes, and none earlier after the one before than asked."""
    ring, player, layout, world = bench()
    words = legal(player, words)
    put(ring, layout, words)
    player.start()
    run(player, 2000 * at + 2000)
    playing = player.busy()
    last = player._state[frames_viper.ENDS]
    chip.stall(stall_us)
    play(player)
    assert player.words_played() == len(words)
    assert world.place == place_of(words)
    assert world.steps == sum([1 for _, levels in words for axis in range(2) if levels & 1 << axis])
    least = player.min_word_ticks
    for axis in range(2):
        seen = rises(chip.edges, 1 << axis)
        assert all([seen[i + 1] - seen[i] >= least for i in range(len(seen) - 1)])
    assert player.under_runs <= 1
    assert not (playing or last) or player.under_runs == (1 if stall_us > 18_000 else player.under_runs)
    assert stall_us > LATE_US or player.under_runs == 0


def check_a_collection_in_psram(words, at, stall_us):
    """A stall as long as a collection of garbage in PSRAM delays no word: its levels come in time."""
    seen = []
    for stall in (0, stall_us):
        ring, player, layout, world = bench(psram=True)
        legally = legal(player, words)
        put(ring, layout, legally)
        player.start()
        run(player, 2000 * at + 2000)
        chip.stall(stall)
        play(player)
        assert player.under_runs == 0 and chip.i2s.torn == 0 and player.words_played() == len(words)
        assert world.place == place_of(legally)
        seen.append(list(chip.edges))
    assert seen[0] == seen[1]


def check_halt_anywhere(words, us):
    """Words counted by the frames latched are those that the drivers have seen; nothing steps any more, tool and pulses are low;
    the machine goes on from there."""
    ring, player, layout, world = bench()
    words = legal(player, words)
    put(ring, layout, words)
    player.start()
    run(player, us)
    player.halt()
    played = player.words_played()
    assert world.place == place_of(words[:played])
    steps = world.steps
    assert not player.busy()
    run(player, 40_000)
    assert world.steps == steps and player.words_played() == played
    assert chip.edges[-1][1] & (layout.pulse_mask | layout.tool_mask) == 0
    ring.head = played
    put(ring, layout, words[played:])
    player.start()
    play(player)
    assert world.place == place_of(words) and player.words_played() == len(words)
    assert player.under_runs == 0


def check_the_count_goes_round():
    """The counter of pulses has 16 bits: back to zero at its limit, or round if that is not enabled. Minutes are the same."""
    for wraps in (32_000, 65_536):
        ring, player, layout, world = bench()
        player._counter.wraps = wraps
        words = [(60_000, 5 if i & 1 else 1) for i in range(400)]
        put(ring, layout, words)
        player.start()
        play(player)
        assert player.words_played() == 400 and world.place == [0, 0] and player.under_runs == 0


def check_back_pressure():
    """A block that the driver does not take yet waits; nothing is made twice or left out."""
    ring, player, layout, world = bench()
    words = [(100, 5)] * 3000
    put(ring, layout, words)
    player.start()
    for _ in range(50):
        player.pump()
        player.pump()
        chip.stall(300)
    assert player.under_runs == 0
    play(player)
    assert world.place == [3000, 0]
    seen = rises(chip.edges, 1)
    assert [seen[i + 1] - seen[i] for i in range(len(seen) - 1)] == [100] * 2999


def check_outputs_and_rest():
    """Levels at rest and other outputs appear within the time of the frames on their way; an output is not a motor's."""
    ring, player, layout, world = bench(enable=13)
    assert chip.level[13] == 1, "cut off until the registers hold zeros"
    run(player, SENT_US)
    assert chip.level[13] == 0
    player.rest(0b10100)
    player.output(0, 1)
    run(player, SENT_US)
    assert chip.edges[-1][1] == 0b10100 and chip.register == 1 | 1 << 2 | 1 << 7
    player.output(0, 0)
    run(player, SENT_US)
    assert chip.register == 1 << 2 | 1 << 7
    player.halt()
    assert chip.level[13] == 1
    run(player, 2 * SENT_US)
    assert chip.level[13] == 0 and chip.edges[-1][1] == 0b00100
    player.close()
    chip.stall(2 * SENT_US)
    chip.i2s.run()
    assert chip.register == 0


def check_what_zeros_would_step_is_refused():
    for invert in (1, 2, 16):
        try:
            bench(invert=invert)
        except ValueError:
            continue
        raise AssertionError("accepted")
    ring, player, layout, world = bench(invert=4)
    run(player, SENT_US)
    assert chip.edges[-1][1] == 4


def check_board_files_that_cannot_be_shifted():
    """One clear line each."""
    for path, value, words in (
        (("chip",), "esp32c3", ("shift", "esp32c3")),
        (("drive", "step_active"), 0, ("step_active", "zeros")),
        (("tool", "active"), 0, ("tool.active", "zeros")),
        (("tool", "pin"), 18, ("tool", "register", "100 … 114", "18")),
        (("axes", 0, "pins"), [4, 101], ("axis x", "register", "4")),
        (("axes", 0, "pins"), [102, 101], ("102", "axis x", "axis y")),
        (("outputs", 0, "pin"), 115, ("outputs[0].pin", "115", "114")),
        (("inputs", 0, "pin"), 111, ("inputs[0].pin", "111")),
        (("shift", "latch"), 34, ("shift.latch", "only be an input")),
        (("shift", "data"), 18, ("pin 18", "shift.clock", "shift.data")),
        (("shift", "oe"), 16, ("shift", "unknown key 'oe'")),
        (("shift",), None, ("tool.pin", "106", "48")),
        (("interlock",), {"limits": {"x+": "limit_x"}}, ("shift", "interlock")),
    ):
        board = copy(ROUTER)
        part = board
        for key in path[:-1]:
            part = part[key]
        part[path[-1]] = value
        try:
            check(board)
        except BoardError as error:
            for word in words:
                assert word in str(error), str(error)
            assert "\n" not in str(error)
            continue
        raise AssertionError("accepted: %r %r" % (path, value))
    assert check(dict(copy(ROUTER), drive={"kind": "step_dir", "setup_us": 9}))["drive"]["setup_us"] == 12


class OnRegisters:
    """The firmware on the fake chip, its motors on registers; driven as router.Machine is."""

    def __init__(self, board=None):
        chip.reset()
        data = copy(board or ROUTER)
        data["links"] = [{"name": "pc", "port": "uart2", "tx": 22, "rx": 23, "baud": 115200, "protocol": data["links"][0]["protocol"]}]
        self.board = check(data)
        self.port = fake_esp32.port.Port(self.board)
        self.app = App(self.board, self.port)
        self.player = self.app.player
        self.world = router.World()
        chip.name_inputs(self.board)
        chip.wire_register(self.world, [pin - 100 for pin in word_pins(self.board)], self.app.layout)
        self.uart = chip.uarts[2]

    def ask(self, line):
        self.uart.incoming += line.encode() + b"\n"
        turns = 40_000
        while turns and b"ok" not in self.uart.outgoing and b"error" not in self.uart.outgoing:
            self.app.cycle()
            turns -= 1
        said = self.uart.outgoing
        self.uart.outgoing = b""
        return said

    def settle(self):
        turns = 200_000
        while turns and (self.app.controller.busy() or self.player.busy()):
            self.app.cycle()
            turns -= 1
        for _ in range(20):
            self.app.cycle()


JOBS = {
    "lines": ("G1 X10 Y5 F3000", "X0 Y8", "X3 Y3 Z-1", "G0 X0 Y0 Z0"),
    "arcs": ("G1 X5 F2500", "G2 X10 Y5 I5 J0", "G3 X5 Y0 I0 J-5", "G2 X5 Y0 I-2.5 J0", "G0 X0"),
    "S-curves": ("G1 X12 F4000", "X0 Y4", "Y0"),
    "tool": ("M3 S1000", "G1 X4 F2000", "M5", "G0 X0", "M3", "G1 Y3 F1500", "M5"),
}


def path_of(machine, lines):
    machine.world.path = []
    for line in lines:
        said = machine.ask(line)
        assert b"ok" in said if isinstance(said, bytes) else "ok" in said, (line, said)
    machine.settle()
    return [row[1:] for row in machine.world.path]


def check_jobs_run_the_path_of_the_virtual_board():
    """Lines, arcs and the tool: all steps in the same order, and the same place."""
    for name in ("lines", "arcs", "tool"):
        virtual = router.Machine()
        virtual.ask("$X")
        wanted = path_of(virtual, JOBS[name])
        board = OnRegisters()
        board.ask("$X")
        found = path_of(board, JOBS[name])
        assert found == wanted and len(found) > 1500, name
        assert board.app.controller.position() == virtual.app.controller.position()
        assert board.player.under_runs == 0 and board.app.feeder.late == 0, name


class Spied:
    """Collects the words that a virtual machine's player takes from its ring, as (ticks, levels)."""

    def __init__(self, app):
        self.words = []
        player, ring, layout = app.player, app.ring, app.layout
        play = player._play

        def spy(until):
            played = player.words_played()
            play(until)
            while played != player.words_played():
                word = ring.words[played & ring.mask]
                self.words.append((word >> layout.bits, word & layout.levels_mask))
                played += 1

        player._play = spy


def check_words_of_every_kind():
    """Words that the virtual board played, of each geometry: on the registers every edge, of STEP, DIR and tool, is within half a
    frame of its word's time, and none is left out; and no step comes sooner after another, or after a DIR, than asked."""
    for name, words, layout in kinds():
        assert len(words) > 1200, name
        motors = layout.motors
        outputs = list(range(2 * motors + 1))
        ring, player, _, world = bench(50, layout=layout, outputs=outputs, size=1024)
        world.attach = world.edges = lambda *rest: None
        given = 0
        player.start()
        while given < len(words) or player.busy():
            while given < len(words) and (ring.head - player.words_played()) < 1000:
                put(ring, layout, words[given : given + 1])
                given += 1
            player.start()
            player.pump()
            chip.stall(1500)
        run(player, 24_000)
        assert player.under_runs == 0 and player.words_played() == len(words), name
        assert_edges(name, words, layout, player.min_word_ticks)


def assert_edges(name, words, layout, least):
    wanted = {}  # tick of each word at which a level rises or falls, by level; pulses only rise
    before = due = 0
    rising = {bit: [] for bit in range(layout.bits)}
    falling = {bit: [] for bit in range(layout.bits)}
    for ticks, levels in words:
        for bit in range(layout.bits):
            pulse = layout.pulse_mask >> bit & 1
            if levels >> bit & 1 and (pulse or not before >> bit & 1):
                rising[bit].append(due)
            elif not pulse and before >> bit & 1 and not levels >> bit & 1:
                falling[bit].append(due)
        before = levels
        due += ticks
    first = min([ticks[0] for ticks in rising.values() if ticks])
    start = chip.edges[1][0] - (first + FRAME // 2) // FRAME * FRAME
    turned = {}
    last = {}
    for i in range(1, len(chip.edges)):
        tick, levels = chip.edges[i]
        changed = levels ^ chip.edges[i - 1][1]
        for bit in range(layout.bits):
            if not changed >> bit & 1:
                continue
            up = levels >> bit & 1
            pulse = layout.pulse_mask >> bit & 1
            if pulse and not up:
                continue
            at = (rising if up else falling)[bit].pop(0)
            assert abs(tick - start - at) <= FRAME // 2, (name, bit, tick - start, at)
            if not pulse:
                turned[bit] = tick
            else:
                assert tick - last.get(bit, -least) >= least, name
                assert tick - turned.get(bit + layout.motors, -least) >= least, name
                last[bit] = tick
    assert not any(rising.values()) and not any(falling.values()), name


DRIVE = {"kind": "step_dir", "mode": "half", "pulse_us": 4, "setup_us": 8, "step_active": 1, "hold_ms": 100}


def kinds():
    """(name, words, layout) of lines, arcs, S-curves, the tool, axes that run on their own, and single steps written down."""
    import lpt
    from free_machine import FreeMachine

    for name, lines in JOBS.items():
        machine = router.Machine(drive=DRIVE)
        machine.ask("$X")
        if name == "S-curves":
            machine.ask("$141=20000")
        spied = Spied(machine.app)
        path_of(machine, lines)
        yield name, spied.words, machine.app.layout
    machine = FreeMachine(drive=DRIVE)
    spied = Spied(machine.app)
    assert machine.run((900, -1400), ((480, 1000), (777, 1000))) == 0
    machine.settle()
    yield "independent axes", spied.words, machine.app.layout
    before = lpt.BOARD
    lpt.BOARD = dict(before, drive=DRIVE)
    machine = lpt.Lpt()
    lpt.BOARD = before
    spied = Spied(machine.app)
    machine.play("[+1000(" + "A" * 90 + "*7" + "GHIJ" * 40 + ")+2200" + "KLMNOPQR" * 30 + "CD" * 400 + "]")
    yield "step program", spied.words, machine.app.layout


def check_a_job_with_an_under_run():
    """In the middle of a job nothing runs for 60 ms: counted as late too; the path is the virtual board's all the same."""
    virtual = router.Machine()
    virtual.ask("$X")
    wanted = path_of(virtual, JOBS["arcs"])
    board = OnRegisters()
    board.ask("$X")
    board.world.path = []
    for line in JOBS["arcs"]:
        board.ask(line)
    for turn in range(600):
        board.app.cycle()
        if turn == 300:
            assert board.player.busy()
            chip.stall(60_000)
    board.settle()
    assert [row[1:] for row in board.world.path] == wanted
    assert board.player.under_runs == 1 and board.app.feeder.late >= 1
    assert board.app.controller.position() == virtual.app.controller.position()


def check_a_hold_and_a_halt_of_the_whole_machine():
    """Feed hold takes 25 ms longer than slowing down at most, where the heap is PSRAM 42; the emergency stop's input ends the steps when its
    callback comes, and the position is that of the drivers."""
    for psram, longer_ms in (False, 25), (True, 42):
        held_and_halted(OnRegisters(dict(ROUTER, psram=psram)), longer_ms)


def held_and_halted(board, longer_ms):
    board.ask("$X")
    board.ask("G1 X40 F4800")
    for _ in range(400):
        board.app.cycle()
    assert board.player.busy()
    board.world.path = []
    board.uart.incoming += b"!"
    since = chip.now
    while not board.app.feeder.hold:
        board.app.cycle()
    for _ in range(600):
        board.app.cycle()
    # From 80 mm/s at 250 mm/s²: 320 ms.
    stopping_ms = (board.world.path[-1][0] - since * 25 // 2) // 12_500
    assert 300 < stopping_ms <= 320 + longer_ms, stopping_ms
    assert not board.player.busy()
    board.uart.incoming += b"~"
    for _ in range(200):
        board.app.cycle()
    assert board.player.busy()
    board.world.switches["stop"] = 1
    chip.irqs[14](fake_esp32.Pin(14))
    steps = board.world.steps
    for _ in range(100):
        board.app.cycle()
    assert board.world.steps == steps
    place = [place - start for place, start in zip(board.world.place, (3000, 2500, -1800))]
    assert place == board.app.controller.position()
    assert board.app.controller.machine.alarm
    assert board.world.tool == 0
