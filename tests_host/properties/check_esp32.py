"""The ESP32's port on a fake chip: the 2014 plotter's conversation, words and edges as on the virtual board, halts, stalls,
heartbeat, watchdog; and board files that ask of a chip what it has not."""

import fake_esp32
from boards.plotter_2014 import BOARD as PICO
from boards.laser_xy import BOARD as LASER
from boards.plotter_esp32 import BOARD
from check_control import copy
from fake_esp32 import chip
from passo import errors
from passo.app import App
from passo.config.boardfile import BoardError, check
from passo.protocols.plotter.host import COMMANDS, packet, status_from
from passo.steps.wiring import word_pins
from passo.steps.word import Layout
from table import Machine, Table

CASES = {
    "check_intervals": (
        ("words", "list", 40, ("ticks", 2500, 60_000), ("levels", 0, 31)), ("stall_at", 0, 40), ("stall_us", 0, 30_000),
    ),
    "check_halt_anywhere": (("ms", 1, 1500),),
    "check_a_halt_cuts_no_pulse_short": (("after_us", 300, 30_000),),
}
RUNS = {"check_intervals": 40, "check_halt_anywhere": 6}
SQUARE = (("MOVE", 644, 314), ("LINE", 644, 454), ("LINE", 884, 454), ("LINE", 884, 314), ("LINE", 644, 314))
EDGE_US = 25  # an edge's place against its word: the player's slack, and the clock's own questions


class Board:
    """The firmware on the fake chip, wired to the table."""

    def __init__(self, board=None, table=None):
        chip.reset()
        self.board = check(board or BOARD)
        self.port = fake_esp32.port.Port(self.board)
        self.app = App(self.board, self.port)
        self.player = self.app.player
        self.table = table or Merging()
        chip.name_inputs(self.board)
        chip.wire(self.table, word_pins(self.board), self.app.layout)
        self.uart = chip.uarts[2]

    def cycles(self, count):
        for _ in range(count):
            self.app.cycle()

    def ask(self, name, x=0, y=0, turns=100_000):
        self.uart.incoming += packet(COMMANDS[name], x, y)
        while turns and not self.uart.outgoing:
            self.app.cycle()
            turns -= 1
        data = self.uart.outgoing
        self.uart.outgoing = b""
        return data


class Merging(Table):
    """A word's pins change in two writes, a microsecond apart: one step for a rotor."""

    _last = -1000

    def edges(self, tick, levels, changed):
        before = len(self.path) if self.path is not None else 0
        Table.edges(self, tick, levels, changed)
        if before and len(self.path) > before:
            if tick - self._last < EDGE_US * 25 // 2:
                self.path.pop(-2)
            self._last = tick


class Published:
    """Collects the words that a player takes from its ring from now on."""

    def __init__(self, app):
        self.words = []
        player, ring = app.player, app.ring
        play = player._play

        def spy(*until):
            played = player.words_played()
            play(*until)
            while played != player.words_played():
                self.words.append(ring.words[played & ring.mask])
                played += 1

        player._play = spy


def square(machine, app):
    """Home, draw the square; the words of it."""
    answers = machine.ask("REQUEST") + machine.ask("ORIGIN") + machine.ask("SPEED", 1000)
    published = Published(app)
    machine.table.path = []
    for name, x, y in SQUARE:
        answers += machine.ask(name, x, y)
    answers += machine.ask("END")
    assert answers == b"kosnnnnnd"
    return published.words


def check_the_conversation_of_2014_is_that_of_the_virtual_board():
    """Every answer, every word and every place; and each edge at its word's time."""
    virtual = Machine()
    wanted = square(virtual, virtual.app)
    board = Board()
    words = square(board, board.app)
    assert words == wanted and len(words) > 1404
    assert board.table.path == virtual.table.path and len(board.table.path) >= 1404
    assert board.app.controller.position() == [644, 314]
    assert board.player.late == 0
    due = first = 0
    before = None
    edges = settled(chip.edges)
    at = len(edges) - changes(words, board.app.layout.levels_mask)
    for word in words:
        levels = word & board.app.layout.levels_mask
        if before is not None and levels != before:
            us, seen = edges[at]
            first = first or us - due * 2 // 25
            assert seen == levels and abs(us - first - due * 2 // 25) <= EDGE_US
            at += 1
        before = levels
        due += word >> board.app.layout.bits
    assert at == len(edges)


def changes(words, mask):
    return len([i for i in range(1, len(words)) if (words[i] ^ words[i - 1]) & mask])


def settled(edges):
    """The edges, those of one word taken together."""
    kept = []
    for i in range(len(edges)):
        if i + 1 == len(edges) or edges[i + 1][0] - edges[i][0] > 5:
            kept.append(edges[i])
    return kept


def bench(pins, pulse_ticks=0, invert=0):
    """A player with a ring of its own, its levels on `pins`."""
    from passo.steps.ring import Ring

    chip.reset()
    half = len(pins) // 2
    layout = Layout("step_dir", half, 2 * half, ["p%d" % pin for pin in pins[:-1]], (1 << half) - 1)
    ring = Ring()
    player = fake_esp32.timer_player.TimerPlayer(ring, layout, pins, pulse_ticks, 100, invert)
    chip.wire(Silent(), pins, layout)
    return ring, player, layout


class Silent:
    def attach(self, tick, names, levels):
        pass

    def edges(self, tick, levels, changed):
        pass


def put(ring, layout, words):
    for ticks, levels in words:
        ring.words[ring.head & ring.mask] = ticks << layout.bits | levels
        ring.head += 1


def check_intervals(words, stall_at, stall_us):
    """Edges keep their words' times; after a stall no interval is shorter than its word, less the slack, and no level is
    left out."""
    words = [(ticks, levels) for ticks, levels in words]
    ring, player, layout = bench((4, 32, 13, 33, 2))
    seen = []
    play = player._play

    def spy():
        seen.append((chip.now, ring.words[player.words_played() & ring.mask] & 31))
        play()
        assert chip.levels() == seen[-1][1] & ~layout.pulse_mask or not player._pulse_us

    player._play = spy
    put(ring, layout, words)
    player.start()
    stalled = False
    while player.busy():
        chip.sleep_ms(1)
        if not stalled and player.words_played() >= stall_at:
            stalled = True
            chip.stall(stall_us)
    assert [levels for _, levels in seen] == [levels for _, levels in words]
    assert player.words_played() == len(words) == ring.head
    due = 0
    for i in range(1, len(seen)):
        due += words[i - 1][0]
        least = words[i - 1][0] * 2 // 25
        assert seen[i][0] - seen[i - 1][0] >= least - EDGE_US
        if not player.late:
            assert abs(seen[i][0] - seen[0][0] - due * 2 // 25) <= EDGE_US
    assert stall_us > 20 or player.late == 0


def check_pulses_and_polarity():
    """STEP pulses last as long as they should, DIR and tool keep their levels, inverted pins are the other way round."""
    for invert in (0, 0b00011, 0b10100):
        ring, player, layout = bench((18, 19, 21, 33, 32), 100, invert)
        assert chip.levels() == invert
        put(ring, layout, ((5000, 0b10111), (5000, 0b00001), (2500, 0)))
        player.start()
        while player.busy():
            chip.sleep_ms(1)
        seen = [levels ^ invert for _, levels in chip.edges]
        kept = [levels for i, levels in enumerate(seen) if i == 0 or seen[i - 1] != levels]
        high = [chip.edges[i][0] for i in range(len(seen)) if seen[i] & 1]
        assert kept[-1] == 0 and 0b10111 in kept and 0b10100 in kept and 0b00001 in kept
        low = [us for us, levels in chip.edges if us > high[0] and not (levels ^ invert) & 1]
        assert 8 <= low[0] - high[0] <= 12
        assert player.words_played() == 3
        player.rest(0b10100)
        assert chip.levels() ^ invert == 0b10100
        player.halt()
        assert chip.levels() ^ invert == 0b00100


def check_stop_hold_and_start():
    ring, player, layout = bench((18, 19, 21, 33, 32))
    put(ring, layout, [(5000, 4)] * 10)
    player.hold(True)
    player.start()
    assert not player.busy()
    player.hold(False)
    player.start()
    player.start()
    chip.sleep_ms(1)
    player.stop()
    played = player.words_played()
    chip.sleep_ms(5)
    assert not player.busy() and player.words_played() <= played + 1
    player.start()
    while player.busy():
        chip.sleep_ms(1)
    assert player.words_played() == 10
    assert chip.timers[0].callback is None or not player.busy()


def check_halt_anywhere(ms):
    """STOP at any moment: the place reported is the table's, the pen is up, and the machine goes on."""
    board = Board()
    board.ask("ORIGIN")
    zero = board.table.place[:]
    for name, x, y in (("MOVE", 50, 40), ("LINE", 50, 90), ("LINE", 110, 90)):
        assert board.ask(name, x, y) == b"n"
    board.uart.incoming += packet(COMMANDS["END"])
    board.cycles(ms)
    board.uart.outgoing = b""
    assert board.ask("STOP") == b"d"
    board.cycles(100)
    board.uart.outgoing = b""
    status = status_from(board.ask("STATUS"))
    place = [board.table.place[axis] - zero[axis] for axis in range(2)]
    assert [status["x"], status["y"]] == place == board.app.controller.position()
    assert board.table.pen == 0 and status["state"] == "idle"
    assert board.ask("LINE", 60, 60) + board.ask("END") == b"nd"
    assert board.app.controller.position() == [60, 60]


class Once:
    """A timer that fires once, as all callbacks of MicroPython do there: never within another callback."""

    period = 1 << 28

    def __init__(self, due, callback):
        self.due = due
        self.callback = lambda _: callback()


def check_nothing_is_fed_while_the_machine_is_put_together():
    board = Board()
    assert not board.app.feeder.open
    board.ask("REQUEST")
    board.uart.incoming += packet(COMMANDS["ORIGIN"], 0, 0)
    cycles = 1000
    while not board.app.feeder.open:
        board.cycles(1)
        cycles -= 1
        assert cycles, "the feeder does not open for the motion"


def check_a_halt_cuts_no_pulse_short(after_us):
    """Whenever it comes: the player makes each pulse within its own callback."""
    ring, player, layout = bench((18, 19, 21, 33, 32), 250)
    put(ring, layout, [(10_000, 0b00011), (10_000, 0b00001)] * 20)
    player.start()
    chip.timers["halt"] = Once(chip.now + after_us, player.halt)
    chip.sleep_ms(40)
    del chip.timers["halt"]
    rises, widths = {}, []
    for us, levels in chip.edges:
        for bit in (1, 2):
            if levels & bit and bit not in rises:
                rises[bit] = us
            elif not levels & bit and bit in rises:
                widths.append(us - rises.pop(bit))
    played = player.words_played()
    assert not rises and 0 < played < 40 and len(widths) == played + played // 2 + played % 2, (rises, played, widths)
    assert min(widths) >= 20


def check_a_halting_input():
    """Seen by its callback, or where that was lost by the feeder's next turn: nothing steps any more, alarm."""
    for callback in (True, False):
        data = copy(BOARD)
        data["inputs"].append({"name": "stop", "pin": 13, "active": 0, "pull": "up", "halt": True})
        board = Board(data, Switched())
        board.ask("MOVE", 900, 0)
        board.uart.incoming += packet(COMMANDS["END"])
        board.cycles(400)
        board.table.level = 0
        if callback:
            pin = fake_esp32.Pin(13)
            chip.irqs[13](pin)
            steps = board.table.steps
            chip.sleep_ms(50)
            assert board.table.steps == steps
        else:
            chip.sleep_ms(6)
            steps = board.table.steps
        board.cycles(100)
        assert board.table.steps == steps > 10
        assert board.app.controller.machine.alarm == errors.ALARM_HARD_LIMIT
        assert board.app.controller.machine.log.entries[-1][2] == "stop"


def check_an_interlock():
    """A limit that is seen by its callback acts in it, after its filter; one whose edge was lost within some cycles. The way back
    is free; a spike is counted."""
    for callback in (True, False):
        data = copy(BOARD)
        data["inputs"].append({"name": "stop", "pin": 13, "active": 0, "pull": "up", "filter_us": 100})
        data["interlock"] = {"limits": {"x+": "stop"}}
        board = Board(data, Switched())
        interlock = board.port.veto
        pin = fake_esp32.Pin(13)
        board.cycles(100)
        chip.irqs[13](pin)
        assert list(interlock.glitches) == [0, 0, 0, 1], "over by the time the callback comes"
        board.ask("MOVE", 900, 0)
        board.uart.incoming += packet(COMMANDS["END"])
        board.cycles(400)
        board.table.level = 0
        if callback:
            chip.irqs[13](pin)
            steps = board.table.steps
            chip.sleep_ms(50)
            assert board.table.steps == steps
        board.cycles(100)
        steps = board.table.steps
        board.cycles(20)
        assert board.table.steps == steps > 10
        assert board.app.controller.machine.alarm == errors.ALARM_HARD_LIMIT
        assert board.app.controller.machine.log.entries[-1][2] == "stop"
        board.uart.outgoing = b""
        board.ask("STOP")
        board.table.level = 1
        board.cycles(100)
        board.ask("ORIGIN")
        assert board.app.controller.machine.alarm == 0 and board.app.controller.position() == [0, 0]


class Switched(Table):
    level = 1

    def input(self, tick, name):
        return self.level if name == "stop" else Table.input(self, tick, name)


def laser():
    """The laser's board on this chip, its alarm taken away."""
    data = dict(copy(LASER), journal=None)
    data.update(chip="esp32", clock_mhz=0, tool={"pin": 26}, inputs=[], homing=None, outputs=[])
    data["speed"].update(default=4000, max=4000)
    for axis, pins in zip(data["axes"], ([16, 17], [18, 19])):
        axis.update(pins=pins, max_mm_min=3000)
    data["spindle"]["pin"] = 32
    data["links"] = [{"name": "pc", "port": "uart2", "tx": 27, "rx": 14, "baud": 115200, "protocol": "grbl"}]
    board = Board(data)
    board.uart.incoming += b"$X\n"
    board.cycles(300)
    return board


def check_a_laser_held_stays_dark():
    """In a feed hold the power's pin goes to 0, and neither an interrupt nor an override brings it back before the
    machine goes on."""
    board = laser()
    for mode in (b"M3", b"M4"):
        board.uart.incoming += mode + b"S500G1X100F600\n"
        board.cycles(100)
        assert 30_000 < chip.pwm[32] < 33_000, mode
        board.uart.incoming += b"!"
        board.cycles(400)
        assert board.app.controller.state == "hold" and not board.app.planner.empty() and chip.pwm[32] == 0, mode
        board.uart.incoming += b"\x9a"
        board.cycles(100)
        assert chip.pwm[32] == 0, mode
        board.uart.incoming += b"~"
        board.cycles(200)
        assert 33_000 < chip.pwm[32] < 37_000, mode
        board.uart.incoming += b"\x18"
        board.cycles(60)
        assert chip.pwm[32] == 0, mode
        board.uart.incoming += b"$X\nG92X0Y0\n"
        board.cycles(100)


def check_the_power_of_a_laser_that_stands():
    """M3 burns on: an S given at a stand, or in a word shorter than a cycle of the feeder, sets the power. M4 is dark."""
    board = laser()
    for said, level in (
        (b"G1F3000\nM3S500\n", 500), (b"S200\n", 200), (b"X5S700\n", 700), (b"X5.0125S300\n", 300), (b"G4P0.1\n", 300),
        (b"\x9a", 330), (b"\x99S100\n", 100), (b"G0X6\n", 100), (b"G1X7S400\n", 400), (b"M4\n", 0), (b"S100\n", 0),
        (b"X8S800\n", 0), (b"G4P0.1\n", 0), (b"M3S600\n", 600), (b"M5\n", 0),
    ):  # fmt: skip
        board.uart.incoming += said
        board.cycles(400)
        lit = said != b"G0X6\n" and level > 0
        assert board.app.controller.state == "idle" and chip.level.get(26, 0) == lit, said
        assert not lit or chip.pwm[32] == level * 65535 // 1000, (said, chip.pwm[32])
        assert level or chip.pwm[32] == 0, said


def check_a_main_loop_that_hangs():
    """Words end within 30 ms of the heartbeat's loss, and the watchdog resets the chip."""
    board = Board()
    board.ask("MOVE", 3000, 0)
    board.uart.incoming += packet(COMMANDS["END"])
    board.cycles(300)
    board.port.guard()
    assert board.table.steps > 20
    chip.sleep_ms(400)
    steps = board.table.steps
    chip.sleep_ms(300)
    assert board.table.steps == steps and board.app.feeder.brake
    board.cycles(2)
    assert not board.app.feeder.brake
    while board.app.controller.busy():
        board.cycles(1)
    assert board.app.controller.position() == [3000, 0]
    try:
        chip.sleep_ms(1500)
    except SystemExit:
        return
    raise AssertionError("no watchdog")


def check_the_end_lets_go():
    """After the app's end nothing plays, and the watchdog, which cannot be stopped, is fed."""
    board = Board()
    board.ask("MOVE", 3000, 0)
    board.uart.incoming += packet(COMMANDS["END"])
    board.cycles(300)
    board.port.guard()
    begin = fake_esp32.start.Start(BOARD)
    begin.end(board.app, board.port)
    steps = board.table.steps
    assert chip.levels() == 0
    for _ in range(10):
        chip.sleep_ms(1000)
    assert board.table.steps == steps


def check_the_start_is_safe():
    """Outputs inactive before anything else, whatever the board file says; the named input leads to the REPL."""
    chip.reset()
    data = copy(BOARD)
    data["outputs"] = [{"name": "enable", "pin": 13, "active": 0}, {"name": "lost"}, {"name": "nowhere", "pin": 99}, 7]
    data["tool"] = {"pin": 26, "active": 1}
    fake_esp32.start.Start(data)
    assert chip.level[13] == 1 and chip.level[26] == 0
    chip.level[0] = 0
    assert not fake_esp32.start.Start(data).ready()
    chip.level[0] = 1
    begin = fake_esp32.start.Start(data)
    assert begin.ready()
    assert isinstance(begin.port(check(BOARD)), fake_esp32.port.Port)
    fake_esp32.start.Start(None)


def check_registers_of_each_chip():
    from passo.ports.esp32 import chip as registers

    base = registers.gpio_base
    for machine, address in (
        ("ESP32S3 module (spiram) with ESP32S3", 0x60004000), ("ESP32C3 module with ESP32C3", 0x60004000),
        ("ESP32-S2 module with ESP32-S2FN4R2", 0x3F404000), ("ESP32C6 module with ESP32C6", 0x60091000),
    ):
        assert base(machine) == address
    assert base() == 0x3FF44000
    try:
        base("Raspberry Pi Pico with RP2040")
    except ValueError:
        return
    raise AssertionError("accepted")


def check_board_files_of_the_wrong_chip():
    """One clear line each, before any pin is touched."""
    for source, path, value, words in (
        (BOARD, ("chip",), "esp8266", ("chip", "esp8266", "esp32")),
        (BOARD, ("axes", 0, "pins"), [16, 17, 18, 34], ("axis x", "pin 34", "esp32", "only be an input")),
        (BOARD, ("axes", 0, "pins"), [16, 17, 18, 6], ("axis x", "no pin 6")),
        (BOARD, ("tool", "pin"), 20, ("tool", "no pin 20", "32 … 39")),
        (BOARD, ("links", 0, "port"), "uart0", ("link pc", "console", "usb")),
        (BOARD, ("links", 0, "port"), "uart3", ("link pc", "uart3", "uart2")),
        (BOARD, ("links", 0, "tx"), 35, ("link pc tx", "pin 35", "only be an input")),
        (BOARD, ("chip",), "esp32c3", ("no pin 16", "18 … 21")),
        (BOARD, ("chip",), "rp2040", ("no pin 32", "0 … 29")),
        (PICO, ("chip",), "esp32", ("no pin 6",)),
        (PICO, ("tool", "pin"), 30, ("tool", "rp2040", "no pin 30")),
        (PICO, ("links", 0, "tx"), 4, ("link pc", "tx of uart0", "12, 16 or 28", "not 4")),
        (PICO, ("links", 0, "port"), "uart2", ("link pc", "uart2", "uart1")),
    ):
        board = copy(source)
        part = board
        for key in path[:-1]:
            part = part[key]
        part[path[-1]] = value
        if path == ("links", 0, "tx"):
            board["axes"][0]["pins"] = [22, 26, 27, 20] if source is PICO else board["axes"][0]["pins"]
        try:
            check(board)
        except BoardError as error:
            for word in words:
                assert word in str(error), str(error)
            assert "\n" not in str(error)
            continue
        raise AssertionError("accepted: %r %r" % (path, value))
    board = copy(BOARD)
    board["inputs"][1]["pin"] = 34  # an input may be there
    check(board)
