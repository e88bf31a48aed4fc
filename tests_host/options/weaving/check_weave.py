"""Weaving: the path of each shape, its speed, its dwells; in G-code and in the torch's language, the same words everywhere."""

from array import array
from hashlib import sha256
from math import atan2, cos, pi, sin, sqrt

from passo import errors
from passo.app import App
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.weaving import language_torch
from passo.options.weaving import motion as weave
from passo.ports.virtual import Nothing, VirtualPort
from passo.protocols.torch import protocol as torch
from passo.records import TICKS_PER_MS, TICKS_PER_S

from boards.router_3axis import BOARD as ROUTER
from boards.torch_manipulator import BOARD
from served_pages import OnBoard, OnCable

STEPS_PER_M = (48_000, 83_000)
CASES = {
    "check_a_line": (
        ("shape", 1, 4), ("x", -4000, 4000), ("y", -4000, 4000), ("amplitude", 100, 6000), ("pitch", 500, 9000), ("along", 0, 1),
    ),
    "check_an_arc": (
        ("shape", 1, 4), ("start", 0, 6283), ("sweep", 200, 6200), ("radius", 12_000, 60_000), ("clockwise", 0, 1), ("pitch", 1500, 9000),
    ),
}
RUNS = {"check_a_line": 60, "check_an_arc": 40}
EXAMPLES = {"check_a_line": ((1, 1920, 0, 3000, 4000, 0), (4, 0, -830, 500, 700, 1), (2, 1, 0, 3000, 9000, 0))}


def hypot(x, y):
    return sqrt(x * x + y * y)


class Pieces:
    """A planner that keeps what it gets: (steps, ticks), (None, ticks of a wait)."""

    def __init__(self):
        self.pieces = []

    def line(self, deltas, ticks, tool, tag):
        self.pieces.append((list(deltas), ticks))

    def wait(self, ticks, tool, tag):
        self.pieces.append((None, ticks))


def pieces_of(woven):
    planner = Pieces()
    while woven.left:
        woven.add(planner)
    return planner.pieces


def side_of(shape, part):
    """How far to the left, in amplitudes, `part` of a pitch lies: 0 … 1; None where it is straight across."""
    if shape == weave.SINE:
        return sin(2 * pi * part)
    points = {
        weave.ZIGZAG: ((0, 0), (0.25, 1), (0.75, -1), (1, 0)), weave.TRIANGLE: ((0, 0), (0.5, 1), (0.5, -1), (1, 0)),
        weave.TRAPEZOID: ((0, 0), (0.125, 1), (0.375, 1), (0.625, -1), (0.875, -1), (1, 0)),
    }[shape]  # fmt: skip
    for at in range(len(points) - 1):
        (since, one), (until, other) = points[at], points[at + 1]
        if since < part < until or part in (since, until) and since != until:
            return one + (other - one) * (part - since) / (until - since)
    return None


def checked(pieces, measure, shape, amplitude, pitches, pitch, dwells, nm_s, slack=1.5):
    """`measure(x, y)` in mm: (share of the seam, mm to its left). Every place lies on the shape; every speed and dwell is right.
    `pitch`: mm, where it is shortest."""
    place = [0, 0]
    waits = []
    finest = slack / 48  # mm: two roundings to steps, and a chord's quarter step; of an arc those of its ends, too
    # Along the seam it may lie as far from its place, and to the side by the shape's rise over that.
    most = finest + amplitude * finest / pitch * (4, 4, 8, 2 * pi)[shape - 1]
    for deltas, ticks in pieces:
        if deltas is None:
            waits.append((measure(place[0] / 48, place[1] / 83), ticks))
            continue
        before = place[:]
        place = [at + by for at, by in zip(place, deltas)]
        length = hypot(deltas[0] / 48, deltas[1] / 83)
        if length > 0.1:
            assert abs(length / (ticks / TICKS_PER_S) - nm_s / 1e6) <= 0.001 * nm_s / 1e6, (length, ticks)
        for share in (0.5, 1.0):
            x, y = [(one + (other - one) * share) / scale for one, other, scale in zip(before, place, (48, 83))]
            seam, left = measure(x, y)
            wanted = side_of(shape, seam * pitches % 1)
            assert abs(left) <= amplitude + finest, (seam, left)
            across = shape == weave.TRIANGLE and abs(seam * pitches % 1 - 0.5) < 2 * finest / pitch
            if not across and wanted is not None:
                assert abs(left - wanted * amplitude) <= most, (seam, left, wanted)
    assert len(waits) == 2 * pitches
    for number, ((_, left), ticks) in enumerate(waits):
        assert ticks == dwells[number % 2] * TICKS_PER_MS
        assert abs(left - (amplitude, -amplitude)[number % 2]) <= finest, (number, left)
    return place


def check_a_line(shape, x, y, amplitude, pitch, along):
    if not (x or y):
        return
    spec = shape, amplitude, pitch, 200, 300, along
    woven = weave.Woven([x, y], (0, 1), None, spec, 10_000_000, True, 1, STEPS_PER_M)
    pieces = pieces_of(woven)
    end_x, end_y = x / 48, y / 83
    length = hypot(end_x, end_y)
    pitches = max(int(length * 1000 / pitch + 0.5), 1)
    nm_s = 10_000_000
    if along:
        moving = sum([ticks for deltas, ticks in pieces if deltas is not None]) / TICKS_PER_S
        assert abs(moving - length / 10) <= 0.01 * length / 10 + 0.004 * pitches, (moving, length / 10)
        nm_s = woven._nm_s
        assert nm_s >= 10_000_000

    def measure(at_x, at_y):
        return (at_x * end_x + at_y * end_y) / length / length, (at_y * end_x - at_x * end_y) / length

    if length > 1:
        end = checked(pieces, measure, shape, amplitude / 1000, pitches, length / pitches, (200, 300), nm_s)
    else:
        end = [sum([deltas[axis] for deltas, _ in pieces if deltas]) for axis in (0, 1)]
    assert end == [x, y]


def check_an_arc(shape, start, sweep, radius, clockwise, pitch):
    """`radius` in µm; the circle's ends are rounded to steps."""
    sign = -1 if clockwise else 1
    first, last = start / 1000, start / 1000 + sign * sweep / 1000
    radius_mm = radius / 1000
    ends = [(round(radius_mm * cos(angle) * 48), round(radius_mm * sin(angle) * 83)) for angle in (first, last)]
    deltas = [to - at for at, to in zip(*ends)]
    centre = [-ends[0][0], -ends[0][1]]
    spec = shape, 3000, pitch, 20, 30, 0
    circle = centre, bool(clockwise), 0, sweep > 3142
    woven = weave.Woven(deltas, (0, 1), circle, spec, 10_000_000, True, 1, STEPS_PER_M)
    whole = radius_mm * sweep / 1000
    pitches = max(int(whole * 1000 / pitch + 0.5), 1)
    if abs(whole * 1000 / pitch % 1 - 0.5) < 0.02:
        return  # rounding decides how many pitches there are

    def measure(x, y):
        x, y = x + ends[0][0] / 48, y + ends[0][1] / 83
        turned = sign * (atan2(y, x) - first) % (2 * pi)
        if turned > sweep / 1000 + 0.04:
            turned -= 2 * pi
        return turned * 1000 / sweep, sign * (radius_mm - hypot(x, y))

    inside = whole / pitches * (radius_mm - 3) / radius_mm
    assert checked(pieces_of(woven), measure, shape, 3.0, pitches, inside, (20, 30), 10_000_000, 2.5) == deltas


def check_what_cannot_be_woven():
    spec = weave.ZIGZAG, 3000, 4000, 0, 0, 0
    for deltas, circle in (([0, 0], None), ([0, 0], ((480, 0), False, 0, False)), ([96, 0], ((48, 0), False, 0, False)), ([0, 0], ((0, 0), True, 0, True))):
        try:
            weave.Woven(deltas, (0, 1), circle, spec, 10_000_000, True, 1, STEPS_PER_M)
        except ValueError:
            continue
        assert False, deltas
    for change in ((0, 0), (0, 5), (1, 0), (1, 100_001), (2, 99), (3, 60_001), (4, -1), (5, 2)):
        wrong = list(spec)
        wrong[change[0]] = change[1]
        assert weave.is_out_of_range(wrong), change
    assert not weave.is_out_of_range(spec)


# --- on the whole machine


class Words(Nothing):
    """A world that adds up each change of the pins, and where the axes are by the steps."""

    def __init__(self):
        self.sum = sha256()
        self.place = [0, 0]
        self.path = []

    def attach(self, tick, names, levels):
        self.inverted = levels
        self.first = None

    def edges(self, tick, levels, changed):
        levels ^= self.inverted
        if self.first is None:
            self.first = tick
        self.sum.update(array("I", [tick - self.first & 0xFFFFFFFF, levels & 0x1F]))
        for axis in (0, 1):
            if changed & levels & 1 << axis:
                self.place[axis] += 1 if levels >> 2 + axis & 1 else -1
                self.path.append((tick, self.place[0], self.place[1]))

    def input(self, tick, name):
        return 1


class Welder:
    def __init__(self, protocol, base=BOARD, **weaving):
        board = dict(base)
        board["weaving"] = weaving or None
        if base is BOARD:
            board["outputs"] = []
        link = dict(base["links"][0])
        link["protocol"] = protocol
        board["links"] = [link]
        self.world = Words()
        port = VirtualPort(check(board), self.world)
        port.eager = False  # the words do not depend on when the lines come
        self.app = App(check(board), port)
        self.line = self.app.port.lines["pc"]

    def say(self, data, cycles=20):
        self.line.incoming += data
        for _ in range(cycles):
            self.app.cycle()
        while not self.app.controller.queue.still() or self.line.incoming:
            self.app.cycle()
        said, self.line.outgoing = self.line.outgoing, b""
        return said


PROGRAM = (
    b"$X\nG21G90G1F600\n$WEAVE=1,2,3,0.1,0.2\nX30Y10\n$WEAVE=4,1.5,2\nG3X40Y20I0J10\n$WEAVE=2,2,3,0,0,1\nG1X0Y20\n"
    b"$WEAVE=0\nG0X0Y0\n$WEAVE=3,2,4,0.05,0.05\nG1X-20Y-5\n"
)
DIGEST = "77d30cd10a647329ff7611a375e3292b"


def check_the_words_are_the_same_everywhere():
    welder = Welder("grbl", steady_mm_min=1200)
    for line in PROGRAM.split(b"\n")[:-1]:
        said = welder.say(line + b"\n")
        assert said.endswith(b"ok\r\n") and b"error" not in said, (line, said)
    assert welder.world.place == [-20 * 48, -5 * 83]
    digest = "".join(["%02x" % byte for byte in welder.world.sum.digest()[:16]])
    assert digest == DIGEST, digest


def seconds_of(world, begun=0):
    return (world.path[-1][0] - world.path[begun][0]) / TICKS_PER_S


def check_path_speed_and_dwells_on_the_pins():
    """600 mm/min along the path: no ramps up to steady_mm_min. Ten pitches of 4 mm, amplitude 3: 2 · hypot(2, 6) mm each."""
    plain = Welder("grbl", steady_mm_min=1200)
    plain.say(b"$X\nG21G90G1F600\n$WEAVE=1,3,4\nX40\n")
    path = 20 * hypot(2, 6)
    assert abs(seconds_of(plain.world) - path / 10) < 0.01 * path / 10
    dwelling = Welder("grbl", steady_mm_min=1200)
    dwelling.say(b"$X\nG21G90G1F600\n$WEAVE=1,3,4,0.25,0.1\nX40\n")
    stood = seconds_of(dwelling.world) - seconds_of(plain.world)
    assert abs(stood - 10 * 0.35) < 0.0001, stood
    along = Welder("grbl", steady_mm_min=9000)
    along.say(b"$X\nG21G90G1F600\n$WEAVE=1,3,4,0,0,1\nX40\n")
    assert abs(seconds_of(along.world) - 4.0) < 0.04
    # In each stretch of half a second the path is as long as the speed says, but for the corners that it leaves out.
    steps = plain.world.path
    at = 0
    while steps[at][0] + TICKS_PER_S // 2 < steps[-1][0]:
        way, since = 0.0, at
        until = steps[at][0] + TICKS_PER_S // 2
        corner = steps[at]
        while steps[at][0] < until:
            at += 1
            if at % 25 == 0 or steps[at][0] >= until:
                way += hypot((steps[at][1] - corner[1]) / 48, (steps[at][2] - corner[2]) / 83)
                corner = steps[at]
        wanted = (steps[at][0] - steps[since][0]) / TICKS_PER_S * 10
        assert 0.96 * wanted < way < 1.02 * wanted, (way, wanted)


def check_chords_that_take_no_ramps_end():
    """More chords than the queue has room for, at a speed that is reached at once: a sine on a fine machine, and a circle as chords."""
    for second in (320, 400):
        axes = [dict(axis, steps_per_m=scale * 1000) for axis, scale in zip(ROUTER["axes"], (320, second, 400))]
        board = dict(ROUTER, homing=None, inputs=[], axes=axes)
        for program in (b"$WEAVE=4,3,4\nX8\n", b"$WEAVE=4,1.5,2\nX8\n", b"G2X8Y0I4\n", b"G2X8Y0I4P3\n"):
            welder = Welder("grbl", board, steady_mm_min=1200)
            welder.line.incoming += b"$X\nG21G90G1F600\n" + program
            queue = welder.app.controller.queue
            for cycle in range(12_000):
                welder.app.cycle()
                if cycle > 300 and not welder.line.incoming and queue.still():
                    break
            assert queue.still() and [queue.axis(0), queue.axis(1)] == [8 * 320, 0], (second, program)


def check_a_hold_on_a_seam_loses_nothing():
    welder = Welder("grbl", steady_mm_min=1200)
    welder.line.incoming += b"$X\nG21G90G1F600\n$WEAVE=4,3,4,0.1,0.1\nX40Y10\n"
    for _ in range(300):
        welder.app.cycle()
    welder.line.incoming += b"!"
    for _ in range(100):
        welder.app.cycle()
    assert welder.app.controller.state == "hold"
    welder.say(b"~")
    assert welder.world.place == [40 * 48, 10 * 83]


def check_the_torch_weaves():
    welder = Welder("torch", steady_mm_min=1200)
    spec = weave.TRAPEZOID, 2000, 4000, 100, 100, 0
    welder.say(language_torch.weave(spec, 48 * 20, 83 * 5, 10_000))
    assert welder.world.place == [48 * 20, 83 * 5]
    first = len(welder.world.path)
    welder.say(language_torch.weave(spec, 0, 0, 10_000, (0, 83 * 15)))
    assert welder.world.place == [48 * 20, 83 * 5] and len(welder.world.path) > first + 4000
    assert max([y for _, _, y in welder.world.path]) > 83 * 33
    welder.say(language_torch.weave((9, 1, 1, 0, 0, 0), 480, 0, 10_000))
    welder.say(torch.move(480, 480, 0, 0), 400)
    assert welder.world.place == [48 * 30, 83 * 5]


def check_a_board_without_it_refuses_the_frame():
    """And does the one behind it."""
    plain = Welder("torch")
    plain.say(language_torch.weave((1, 2000, 4000, 0, 0, 0), 480, 0, 10_000) + torch.move(480, 480, 0, 0), 400)
    assert plain.app.controller.machine.log.last == errors.UNKNOWN_COMMAND and plain.world.place == [480, 0]


def check_the_pages_of_a_board_and_of_a_pc_weave():
    seen = []
    for served in (OnBoard, OnCable):
        desk = served("torch_manipulator")
        page = desk.page()
        page.until(lambda state: state["link"])
        if desk.commands() != desk.mine:
            page.order("give", to="page")
            desk.run_ms(300)
        page.order("output", name="motors_on")
        desk.run_ms(300)
        before = desk.place()
        assert "weave" in page.hello["can"]
        assert page.order("weave", shape="sine", to={"x": 10, "y": 5}, amplitude=2, pitch=4, speed=600)["error"] == 0
        desk.run_ms(4000)
        seen.append([one - other for one, other in zip(desk.place(), before)])
    assert seen == [[480, 415]] * 2, seen


def check_what_is_refused():
    welder = Welder("grbl", steady_mm_min=0)
    welder.say(b"$X\nG21G90G1F600\n")
    for line, answer in (
        (b"$WEAVE=5,1,1", b"error:"), (b"$WEAVE=1,0,1", b"error:"), (b"$WEAVE=1,a,1", b"error:2"), (b"$WEAVE=", b"error:"), (b"$WEAVE=1,2,3", b"ok"),
        (b"G2X0.5Y0I0.25", b"error:34"), (b"G1X10", b"ok"), (b"$WEAVE=0", b"ok"), (b"X0", b"ok"),
    ):  # fmt: skip
        said = welder.say(line + b"\n")
        assert said.startswith(answer), (line, said)
    plain = dict(BOARD)
    link = dict(BOARD["links"][0])
    link["protocol"] = "grbl"
    plain["links"], plain["outputs"], plain["weaving"] = [link], [], None
    app = App(check(plain), VirtualPort(check(plain), Words()))
    app.port.lines["pc"].incoming = b"$X\n$WEAVE=1,2,3\n"
    for _ in range(30):
        app.cycle()
    assert b"error:3\r\n" in app.port.lines["pc"].outgoing
    wrong = dict(BOARD)
    wrong["weaving"] = {"steady_mm_min": -1}
    try:
        check(wrong)
    except BoardError as error:
        assert "steady_mm_min" in str(error)
    else:
        assert False
