"""The two-motor kit: every byte of its language, and the coils of both motors, with keys pressed at any time."""

from boards.two_motor_kit import BOARD
from check_control import copy
from passo import errors
from passo.app import App
from passo.commands import BAD, RUN
from passo.config.boardfile import BoardError, check
from passo.control.motors import RELEASED
from passo.options.independent.commands import FOREVER, REST
from passo.ports.virtual import Nothing, VirtualPort
from passo.protocols.keys import protocol as keys
from passo.protocols.keys.kit import KIT_SLOWEST, KIT_STEP_MS
from passo.protocols.keys.protocol import Keys

TICKS_PER_MS = 12_500
SETTLE_MS = 50  # from a motor's last step until its coils let go
AHEAD_MS = 50  # words made ahead, and a turn of the main loop
OFF_MS = AHEAD_MS + 2 * SETTLE_MS + 20  # from a key until coils have let go: words may end before they can say so
# LEGACY.md: half step 1000 1100 0100 0110 0010 0011 0001 1001, S1 first.
HALF = [int("".join(reversed(states)), 2) for states in "1000 1100 0100 0110 0010 0011 0001 1001".split()]
KEYS = b"CDEFGHIJ"
CASES = {
    "check_whatever_is_pressed": (
        ("presses", "list", 16, ("key", 0, 9), ("speed", 1, 127), ("ms", 1, 600)),
    ),
    "check_bytes_that_mean_nothing": (("noise", "bytes", 60),),
}
RUNS = {"check_whatever_is_pressed": 40, "check_bytes_that_mean_nothing": 25}


class Motor:
    """A unipolar motor as the documents have it: it knows no more than its four pins."""

    def __init__(self, shift):
        self._shift = shift
        self.pattern = 0
        self.phase = 0  # a drive begins there
        self.steps = []  # (tick, +1 or −1)
        self.switched = []  # (tick, on)

    def edges(self, tick, levels):
        pattern = levels >> self._shift & 15
        if pattern == self.pattern:
            return False
        if pattern == 0 or self.pattern == 0:
            self.switched.append((tick, pattern != 0))
        self.pattern = pattern
        if pattern:
            phase = HALF.index(pattern)  # ValueError: no pattern of the drive's
            delta = (phase - self.phase + 4) % 8 - 4
            assert delta in (-1, 0, 1), "coils jumped"
            if delta:
                self.steps.append((tick, delta))
            self.phase = phase
        return True


class Kit(Nothing):
    """The board of the kit, its motors and its line."""

    def __init__(self, board=None):
        self.board = check(copy(board or BOARD))
        self.motors = [Motor(0), Motor(4)]
        self.port = VirtualPort(self.board, self)
        self.app = App(self.board, self.port)
        self.controller = self.app.controller
        self.language = self.app.links[0].protocol
        self.line = self.port.lines["pc"]
        self.switched_off = []

    def press(self, data, ms=0):
        self.line.incoming += data
        self.app.poll()
        self.run_ms(ms)

    def run_ms(self, ms):
        end = self.port.now + ms * TICKS_PER_MS
        while self.port.now < end:
            self.app.poll()
            self.port.advance(min(10 * TICKS_PER_MS, end - self.port.now))

    def now_ms(self):
        return self.port.now / TICKS_PER_MS

    # --- the world

    def attach(self, tick, names, levels):
        assert names == [axis["name"] + "_s%d" % coil for axis in self.board["axes"] for coil in (1, 2, 3, 4)] + ["tool"]

    def edges(self, tick, levels, changed):
        for motor in self.motors:
            motor.edges(tick, levels)


def pressed(key, speed):
    """The bytes of one of the ten tasks."""
    return bytes((0x41 + key, speed)) if key < 2 else KEYS[key - 2 : key - 1]


def check_whatever_is_pressed(presses):
    """Legal patterns at all times (Motor checks them); each motor keeps its own speed, whatever keys the other gets; the coils of a motor that is off have
    no current, and after J none has.
    """
    kit = Kit()
    told = [[(0, "off")], [(0, "off")]]  # of each motor: (ms, what)
    on, speed, sign = [False, False], [1, 1], [1, 1]
    for key, value, ms in presses:
        for motor in range(2):
            named = (key == motor, key == 2 + motor or key == 8, key == 4 + motor or key == 9, key == 6 + motor)
            if named[0]:
                speed[motor] = value
            elif named[1]:
                on[motor] = True
            elif named[2]:
                on[motor] = False
            elif named[3]:
                sign[motor] = -sign[motor]
            if True in named:
                told[motor].append((kit.now_ms(), "turn" if named[3] or named[1] else "new"))
        first = [len(motor.steps) for motor in kit.motors]
        kit.press(pressed(key, value), ms)
        for motor in range(2):
            assert kit.language._is_turning(motor) == on[motor]
            since = kit.now_ms() - told[motor][-1][0]
            if since > AHEAD_MS:
                assert kit.motors[motor].pattern or not on[motor] or since < 4 * 127
            if since > OFF_MS and not on[motor]:
                assert kit.motors[motor].pattern == 0
            recent = [delta for tick, delta in kit.motors[motor].steps[first[motor]:]
                      if tick / TICKS_PER_MS > told[motor][-1][0] + AHEAD_MS]
            assert recent == [sign[motor]] * len(recent)
            if on[motor] and since > AHEAD_MS:
                assert abs(len(recent) - min(ms, since - AHEAD_MS) / (4 * speed[motor])) <= 2
    for motor in range(2):
        periods_hold(kit.motors[motor].steps, told[motor])
    kit.press(b"J", 600)
    assert [motor.pattern for motor in kit.motors] == [0, 0]
    assert kit.controller.machine.motors.state == RELEASED and kit.controller.state == "idle"
    steps = [sum([delta for _, delta in motor.steps]) for motor in kit.motors]
    assert kit.controller.position() == steps
    assert kit.line.outgoing == b""


def periods_hold(steps, told):
    """Every interval between two steps is within 1 % of a speed's own, unless a key for the motor came meanwhile."""
    for i in range(1, len(steps)):
        before, after = steps[i - 1][0] / TICKS_PER_MS, steps[i][0] / TICKS_PER_MS
        if not [ms for ms, what in told if what == "new" and before - AHEAD_MS <= ms <= after]:
            n = round((after - before) / 4)
            stopped = [ms for ms, what in told if before - AHEAD_MS <= ms <= after]
            assert n >= 1 and abs(after - before - 4 * n) <= 0.04 * n or stopped, (before, after)


def check_all_speeds():
    """Both motors at every speed from 1 to 127, each at another one than its neighbour, turning both ways."""
    kit = Kit()
    kit.press(b"I", 20)
    for n in range(1, 128):
        other = n % 127 + 1
        kit.press(bytes((0x41, n, 0x42, other)), AHEAD_MS)
        settled = kit.port.now
        kit.run_ms(13 * max(n, other))
        for motor, speed in zip(range(2), (n, other)):
            ticks = [tick for tick, _ in kit.motors[motor].steps if tick > settled]
            assert len(ticks) > 2, (n, motor)
            for before, after in zip(ticks[1:], ticks[2:]):
                ms = (after - before) / TICKS_PER_MS
                assert abs(ms / (4 * speed) - 1) <= 0.01, (n, motor, ms)
        kit.press(b"GH"[n % 2 : n % 2 + 1])


def check_one_motor_leaves_the_other_alone():
    """While one turns steadily, the other is switched, turned and told speeds: no interval of the first changes, no step of
    it is missing, and its pins change at no other time."""
    kit = Kit()
    kit.press(b"A\x03C", 100)
    steady = kit.motors[0]
    for data in (b"D", b"B\x02", b"H", b"F", b"D", b"B\x7f", b"H", b"H", b"F", b"F", b"D", b"B\x01", b"F"):
        kit.press(data, 83)
    kit.run_ms(200)
    ticks = [tick for tick, _ in steady.steps]
    for before, after in zip(ticks, ticks[1:]):
        assert abs(after - before - 12 * TICKS_PER_MS) <= 0.01 * 12 * TICKS_PER_MS
    assert len(steady.switched) == 1 and kit.motors[1].pattern == 0


def check_a_rotor_settles_before_its_coils_let_go():
    """However fast it turned, alone or beside the other."""
    for speed in (1, 2, 5, 30, 127):
        for on, off in ((b"C", b"E"), (b"I", b"J"), (b"I", b"E"), (b"I", b"EF")):
            for ms in (311, 318, 327):
                kit = Kit()
                kit.press(bytes((0x41, speed, 0x42, 3)) + on, ms + 4 * speed)
                kit.press(off, OFF_MS)
                for motor in kit.motors[: 1 if off == b"E" else 2]:
                    assert motor.pattern == 0, (speed, off)
                    if motor.steps:
                        let_go = [tick for tick, on in motor.switched if not on]
                        assert len(let_go) == 1 and let_go[0] - motor.steps[-1][0] >= SETTLE_MS * TICKS_PER_MS, (speed, off)


def check_off_releases_the_coils_of_one_motor():
    kit = Kit()
    assert [motor.pattern for motor in kit.motors] == [0, 0]
    kit.press(b"C", 100)
    assert kit.motors[0].pattern and kit.motors[1].switched == []
    kit.press(b"D", 100)
    assert kit.motors[0].pattern and kit.motors[1].pattern
    kit.press(b"E", OFF_MS)
    assert kit.motors[0].pattern == 0 and kit.motors[1].pattern
    kit.press(b"C", OFF_MS)
    assert kit.motors[0].pattern and kit.motors[1].pattern
    kit.press(b"F", OFF_MS)
    assert kit.motors[0].pattern and kit.motors[1].pattern == 0
    kit.press(b"E", OFF_MS)
    assert kit.motors[0].pattern == 0 and kit.controller.machine.motors.state == RELEASED


def check_off_while_nothing_turns():
    """Switching off what is off leaves nothing behind: the other motor's coils stay without current all the time."""
    for keys_before in (b"J", b"F", b"EF"):
        kit = Kit()
        kit.press(keys_before, 1)
        kit.press(b"C", 300)
        assert kit.motors[0].steps and kit.motors[1].switched == []


def check_slow_motors_are_off_at_once():
    """The last step's interval of half a second does not keep the current on."""
    kit = Kit()
    kit.press(b"A\x7fB\x7fI", 1200)
    assert kit.motors[0].pattern and kit.motors[1].pattern
    kit.press(b"J", OFF_MS)
    assert [motor.pattern for motor in kit.motors] == [0, 0]
    kit.press(b"C", 560)
    assert kit.motors[0].pattern and kit.motors[1].pattern == 0


def check_the_state_at_the_start():
    """Off, clockwise, speed 1; keys for a motor that is off count when it is switched on."""
    kit = Kit()
    kit.press(b"C", 1000)
    assert 245 <= len(kit.motors[0].steps) <= 251 and kit.controller.position()[0] > 0 == kit.controller.position()[1]
    kit.press(b"EB\x0aH", 100)
    kit.press(b"D", 1000)
    assert -26 <= kit.controller.position()[1] <= -23


def check_every_byte():
    """The command of each of the ten, and of no other."""

    language = Keys(lambda axis: True, 3)
    for key, kind, mask in ((b"C", RUN, 1), (b"D", RUN, 2), (b"I", RUN, 3), (b"G", RUN, 1), (b"H", RUN, 2)):
        command = list(language.feed(key, 0))[0]
        assert command.kind == kind and command.unpowered == 4
        assert [1 if step else 0 for step in command.steps] == [mask & 1, mask >> 1, 0]
    assert list(language.feed(b"C", 0))[0].steps[0] == -FOREVER  # G has turned it
    for key, mask in ((b"E", 1), (b"F", 2), (b"J", 3)):
        command = list(language.feed(key, 0))[0]
        assert command.kind == REST and command.value == mask and command.unpowered == 4 | mask
    for key, motor in ((b"A", 0), (b"B", 1)):
        for n in (1, 73, 127):
            assert list(language.feed(key, 0)) == []
            command = list(language.feed(bytes((n,)), 1999))[0]
            assert command.kind == RUN and command.rates[motor] == (1, 4 * n)
        for n in (0, 128, 255):
            command = list(language.feed(key + bytes((n,)), 0))[0]
            assert command.kind == BAD and command.error == errors.NUMBER_RANGE
    for byte in range(256):
        if bytes((byte,)) not in (b"A", b"B", b"C", b"D", b"E", b"F", b"G", b"H", b"I", b"J", b"?", b"$"):
            command = list(language.feed(bytes((byte,)), 0))[0]
            assert command.kind == BAD and command.error == errors.UNKNOWN_COMMAND
    assert KIT_STEP_MS == 4 and KIT_SLOWEST == 127


def check_a_speed_that_does_not_come():
    kit = Kit()
    kit.press(b"IA", 2100)
    kit.press(b"J", 100)
    assert [motor.pattern for motor in kit.motors] == [0, 0]
    assert kit.controller.machine.log.entries[-1][1:] == (errors.GARBLED, "pc")


def check_what_was_refused_is_told_once():
    kit = Kit()
    for asked, error in ((b"?", 0), (b"A\x00?", errors.NUMBER_RANGE), (b"?", 0), (b"Z?", errors.UNKNOWN_COMMAND), (b"A?", 0), (b"?", 0)):
        kit.line.outgoing = b""
        kit.press(asked, 20)
        assert kit.line.outgoing == (b"" if asked == b"A?" else bytes((0x3F, error))), "63 is a speed behind A"
    assert kit.motors[0].switched == kit.motors[1].switched == []


def check_bytes_that_mean_nothing(noise):
    """Counted, logged, and nothing turns."""
    kit = Kit()
    data = bytes([byte for byte in noise if not 0x41 <= byte <= 0x4A and byte not in (0x3F, 0x24)])
    kit.press(data, 50)
    assert len(data) == kit.controller.machine.log.counts.get(errors.UNKNOWN_COMMAND, 0)
    assert len(kit.controller.machine.log.entries) == min(32, len(data))
    assert kit.motors[0].switched == kit.motors[1].switched == [] and kit.line.outgoing == b""


def check_other_drives():
    """Any drive turns: the places are those of the unipolar motors."""
    places = []
    for kind, pins, mode in (
        ("unipolar", ([2, 3, 4, 5], [6, 7, 8, 9]), "wave"),
        ("pbl3770a", ([2, 3, 4, 5, 6, 7], [8, 9, 10, 11, 12, 13]), "half"),
        ("step_dir", ([2, 4], [3, 5]), "half"),
    ):
        board = copy(BOARD)
        board["drive"] = {"kind": kind, "mode": mode}
        board["tool"] = {"pin": 14 if kind == "pbl3770a" else 10 if kind == "unipolar" else 6}
        board["outputs"] = [{"name": "enable", "pin": 20, "active": 0}]
        for axis, own in zip(board["axes"], pins):
            axis["pins"] = own
        kit = OtherKit(board)
        kit.press(b"B\x05I", 300)
        kit.press(b"H", 300)
        kit.press(b"E", 200)
        assert kit.enable == 0
        kit.press(b"F", 200)
        assert kit.enable == 1 and kit.controller.machine.motors.state == RELEASED
        places.append(kit.controller.position())
    assert places[0] == places[1] and abs(places[2][0] - places[0][0]) <= 6 and abs(places[2][1] - places[0][1]) <= 2


class OtherKit(Kit):
    enable = 1

    def attach(self, tick, names, levels):
        pass

    def edges(self, tick, levels, changed):
        pass

    def output(self, tick, name, level):
        self.enable = level


def check_it_wants_two_motors():
    board = copy(BOARD)
    board["axes"].pop()
    board["tool"]["pin"] = 6
    try:
        Kit(board)
    except BoardError as error:
        assert "link pc: keys wants two axes" in str(error)
        return
    raise AssertionError("accepted")


def check_the_link_that_may_not_command():
    """Switching on is refused in silence and logged; off is always allowed."""
    board = copy(BOARD)
    board["links"].append({"name": "usb", "port": "usb", "protocol": "keys"})
    kit = Kit(board)
    other = kit.port.lines["usb"]
    other.incoming += b"CI"
    kit.run_ms(100)
    assert kit.motors[0].switched == [] and other.outgoing == b""
    assert [entry[1:] for entry in kit.controller.machine.log.entries] == [(errors.COMMANDED_ELSEWHERE, "usb")] * 2
    kit.press(b"I", 100)
    other.incoming += b"J"
    kit.run_ms(100)
    assert [motor.pattern for motor in kit.motors] == [0, 0]
