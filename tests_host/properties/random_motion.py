"""Random programs of lines, arcs, tiny segments and reversals on a machine of three axes, or more, and the checks of their limits.

    machine = Machine(7, "mixed")
    words = machine.run()
    hold_against_limits(machine)

The checks read each segment as the ramp cut it, and the words.
"""

from math import atan2, cos, pi, sin, sqrt

from check_circle import about
from draws import Random
from passo.motion.arc import TooSteep
from passo.motion.circle import COARSE
from passo.motion.limits import Limits
from passo.records import (
    ARC_FIELDS, ARC_PATH, ARC_PATH_FINE, ARC_TAIL_A, ARC_TAIL_B, CIRCLE_FALL, CIRCLE_PATH, CIRCLE_RISE, CIRCLE_U_AXIS,
    CIRCLE_WORDS, FEED_KIND, KIND_ARC, KIND_LINE, LINE_FALL, LINE_RISE, QUEUE_FETCHED, RAMP_STEPS, RAMP_TICKS, TICKS_PER_S,
)  # fmt: skip
from rig import Rig

MM = 1_000_000


class Machine:
    """A rig with limits, and a program for it: [(kind, deltas, …, speed nm/s)]."""

    axes = 3

    def __init__(self, seed, kind="mixed", blocks=None):
        random = Random(seed)
        self.random = random
        flat = random.choice((80_000, 100_000, 400_000))
        self.rig = self.make_rig()
        self.limited(
            [flat, flat, random.choice((flat, 400_000))],
            [random.between(10, 200) * MM for _ in range(3)],
            [random.between(50, 3000) * MM for _ in range(3)],
            random.choice((0, 10_000, 50_000)),
        )
        self.program = []
        for _ in range(blocks or random.between(1, 40)):
            self._draw(random.choice(("lines", "tiny", "reversals", "arcs")) if kind == "mixed" else kind)
        self.segments = []  # (block number, steps of path, ticks)
        self.lags = []  # of each segment: (words, how far each axis may step behind its place, how far ahead, in steps)
        self._listen()

    def make_rig(self):
        return Rig(axes=self.axes)

    def limited(self, steps_per_m, speeds, accelerations, deviation, start=0):
        self.steps_per_m, self.speeds, self.accelerations, self.deviation = steps_per_m, speeds, accelerations, deviation
        self.limits = Limits(steps_per_m, speeds, accelerations, deviation, start)
        self.rig.planner.limits(self.limits)

    def _draw(self, kind):
        random = self.random
        speed = random.between(1, 250) * MM
        if kind == "lines":
            size = random.choice((20, 400, 3000))
            self.program.append((KIND_LINE, tuple([random.between(-size, size) for _ in range(3)]), speed))
        elif kind == "tiny":
            x, y = random.between(-20, 20), random.between(-20, 20)
            for _ in range(random.between(1, 30)):
                x += random.between(-2, 2)
                y += random.between(-2, 2)
                self.program.append((KIND_LINE, (x, y, random.between(-1, 1)), speed))
        elif kind == "reversals":
            size = random.between(1, 600)
            for i in range(random.between(1, 6)):
                self.program.append((KIND_LINE, (size if i % 2 else -size, 0, 0), speed))
        else:
            start = about(random.choice((5, 60, 700)), random.between(0, 6283) / 1000)
            end = about(sqrt(start[0] ** 2 + start[1] ** 2), random.between(0, 6283) / 1000)
            rise = random.choice((0, 0, random.between(-300, 300)))
            deltas = (end[0] - start[0], end[1] - start[1], rise)
            clockwise = random.choice((False, True))
            self.program.append((KIND_ARC, deltas, speed, (-start[0], -start[1]), clockwise))

    def _listen(self):
        """Have every segment noted as it is cut."""
        ramp = self.rig.planner.ramp
        ramp.even = self._noted(ramp.even)
        self._listen_accelerated()

    def _listen_accelerated(self):
        ramp = self.rig.planner.ramp
        ramp.accelerated = self._noted(ramp.accelerated)

    def _noted(self, cut):
        def listen(*arguments):
            cut(*arguments)
            self._note(self.rig.planner.ramp)

        return listen

    def number(self):
        """Of the block under way."""
        return int(self.rig.planner.indices[QUEUE_FETCHED]) - 1

    def _note(self, ramp):
        planner = self.rig.planner
        arc = self.rig.feeder.state[FEED_KIND] == KIND_ARC
        walker = planner._circle if arc else planner._line
        steps, ticks = int(ramp.state[RAMP_STEPS]), int(ramp.state[RAMP_TICKS])
        if not steps:
            return
        path = int(walker.state[CIRCLE_PATH]) * steps / int(walker.state[CIRCLE_WORDS]) / (1 << COARSE) if arc else steps
        self.segments.append((self.number(), path, ticks))
        self.lags.append((steps,) + (arc_lags(walker, self.axes) if arc else line_lags(walker, self.axes)))

    def add(self, move):
        """Queue one move; its facts go to `facts`: (length mm, path steps, speed, acceleration, corner)."""
        planner = self.rig.planner
        before = planner.indices[0]
        if move[0] == KIND_LINE:
            planner.line(move[1], 0, False, speed_nm_s=move[2])
        else:
            try:
                planner.arc(move[1], (0, 1, 2), move[3], False, move[4], speed_nm_s=move[2])
            except TooSteep:
                return
        self.place = [self.place[axis] + move[1][axis] for axis in range(self.axes)]
        if planner.indices[0] != before:
            steps = max([abs(delta) for delta in move[1]])
            place = before % len(planner._walkers)
            if planner.rows[place * planner._stride] == KIND_LINE:  # an arc too short for a step along the circle, too
                move = (KIND_LINE, move[1], move[2])
            else:
                first = planner._walkers[place]
                plan = planner._arcs.plans[first : first + ARC_FIELDS]
                steps = plan[ARC_PATH] + plan[ARC_PATH_FINE] / (1 << 20)
                move += (abs(plan[ARC_TAIL_A]), abs(plan[ARC_TAIL_B]))
            self.facts.append(self._facts(move, steps))

    def _facts(self, move, steps):
        """(length, steps, speed, acceleration, corner): in floats, from the settings alone but for an arc's length."""
        mm = [delta / (per_m / 1000) for delta, per_m in zip(move[1], self.steps_per_m)]
        speeds = [speed / MM for speed in self.speeds]
        accelerations = [acceleration / MM for acceleration in self.accelerations]
        if move[0] == KIND_LINE:
            length = sqrt(sum([part * part for part in mm]))
            start = end = [part / length for part in mm]
            speed = min([move[2] / MM] + [speeds[i] / abs(start[i]) for i in range(self.axes) if start[i]])
            acceleration = min([accelerations[i] / abs(start[i]) for i in range(self.axes) if start[i]])
        else:
            per_mm = self.steps_per_m[0] / 1000
            flat = steps / per_mm
            length = sqrt(flat * flat + mm[2] * mm[2])
            radius = sqrt(move[3][0] ** 2 + move[3][1] ** 2) / per_mm
            speed, acceleration = self._arc_limits(move, radius, flat / length, mm[2] / length)
            start = self._tangent(move, (0, 0), flat / length, mm[2] / length)
            end = self._tangent(move, move[1], flat / length, mm[2] / length)
        corner = self._corner(start) if self.facts else 0
        self.heading = end
        return length, steps, speed, acceleration, corner

    def _arc_limits(self, move, radius, flat, rise):
        """(speed, acceleration) along an arc, from the load of each axis at each place of it: of the speed and of the
        ramp's acceleration its share along the circle, of v²/R its share across it. The two accelerations together ask no
        axis for more than √2 of its own."""
        speeds = [each / MM for each in self.speeds]
        accelerations = [each / MM for each in self.accelerations]
        shares = []  # (along, across) of X and Y at places from the start to the end
        for angle in angles_of(move):
            shares.append(((abs(sin(angle)), abs(cos(angle))), (abs(cos(angle)), abs(sin(angle)))))
        speed = inwards = acceleration = 1e9
        for axis in range(2):
            along = max([share[axis][0] for share in shares])
            across = max([share[axis][1] for share in shares])
            speed = min(speed, speeds[axis] / along)
            acceleration = min(acceleration, accelerations[axis] / along)
            inwards = min(inwards, accelerations[axis] / across)
            if move[5 + axis]:  # the last line may bring an axis half a step ahead
                speed = min(speed, speeds[axis] * max(move[5:]) / (move[5 + axis] - 0.5))
        speed = min(speed, sqrt(inwards * radius), move[2] / MM * flat)
        if rise:
            speed = min(speed, speeds[2] * flat / abs(rise))
        inwards = speed * speed / radius
        for axis in range(2):
            most = 2 * accelerations[axis] ** 2
            at_once = sqrt(max(most - inwards * inwards, 0))
            along = max([share[axis][0] for share in shares])
            across = max([share[axis][1] for share in shares])
            acceleration = min(acceleration, max(at_once, (sqrt(most) - inwards * across) / along))
            for share in shares:  # the sum of both
                assert acceleration * share[axis][0] + inwards * share[axis][1] <= sqrt(most) * 1.0001
        acceleration /= flat
        if rise:
            acceleration = min(acceleration, accelerations[2] / abs(rise))
        return speed / flat, acceleration

    def _tangent(self, move, place, flat, rise):
        x, y = place[0] - move[3][0], place[1] - move[3][1]
        radius = sqrt(x * x + y * y)
        sign = -1 if move[4] else 1
        return [-sign * y / radius * flat, sign * x / radius * flat, rise]

    def _corner(self, start):
        """The junction formula."""
        cosine = sum([a * b for a, b in zip(self.heading, start)])
        if cosine > 0.999999:
            return 1e9
        if cosine < -0.999999:
            return 0
        turn = [b - a for a, b in zip(self.heading, start)]
        size = sqrt(sum([part * part for part in turn]))
        acceleration = min([self.accelerations[i] / MM * size / abs(turn[i]) for i in range(self.axes) if abs(turn[i]) > 1e-9])
        half = sqrt((1 + cosine) / 2)
        return sqrt(acceleration * self.deviation / MM * half / (1 - half))

    def run(self, each=None):
        """Play the whole program; returns its words. `each(machine)` is called between fillings."""
        self.facts = []
        self.place = [0] * self.axes
        planner = self.rig.planner
        words = []
        todo = list(self.program)
        while todo or not planner.empty():
            while todo and planner.room():
                self.add(todo.pop(0))
            if not todo:
                planner.flush()
            if each:
                each(self)
            words += self.rig.take(125_000)
            self.rig.feeder.retire(self.rig.played)
        return words


def angles_of(move):
    """Directions from the centre of places along an arc of a program, the start and the end among them, and those where it
    crosses an axis."""
    start = -move[3][0], -move[3][1]
    end = start[0] + move[1][0], start[1] + move[1][1]
    first, last = atan2(start[1], start[0]), atan2(end[1], end[0])
    sweep = (first - last if move[4] else last - first) % (2 * pi)
    if start[0] * end[1] == start[1] * end[0] and start[0] * end[0] + start[1] * end[1] > 0:
        sweep = 2 * pi
    sign = -1 if move[4] else 1
    angles = [first, last] + [first + sign * sweep * part / 64 for part in range(65)]
    for quarter in range(4):
        away = (quarter * pi / 2 - first) * sign % (2 * pi)
        if away <= sweep:
            angles.append(quarter * pi / 2)
    return angles


def reference_seconds(facts):
    """Return the seconds that a planner in floating point takes, which sees all the program: trapezoids."""
    leave = 0.0
    exits = []
    for i in range(len(facts) - 1, -1, -1):
        length, _, speed, acceleration, corner = facts[i]
        exits.append(leave)
        before = facts[i - 1][2] if i else 0
        leave = min(corner, speed, before, sqrt(leave * leave + 2 * acceleration * length))
    exits.reverse()
    seconds = 0.0
    enter = 0.0
    for fact, leave in zip(facts, exits):
        length, _, speed, acceleration, _ = fact
        leave = min(leave, sqrt(enter * enter + 2 * acceleration * length))
        peak = min(speed, sqrt((enter * enter + leave * leave) / 2 + acceleration * length))
        ramps = (2 * peak * peak - enter * enter - leave * leave) / (2 * acceleration)
        seconds += (2 * peak - enter - leave) / acceleration + max(length - ramps, 0) / peak
        enter = leave
    return seconds


def path_of(words, axes=3):
    """The stepping words' masks with their directions, in order: the path, without its times."""
    mask = (1 << axes) - 1
    return [(levels & mask, levels >> axes & (levels & mask)) for _, levels in words if levels & mask]


def end_of(words, axes=3):
    place = [0] * axes
    for steps, forward in path_of(words, axes):
        for axis in range(axes):
            if steps >> axis & 1:
                place[axis] += 1 if forward >> axis & 1 else -1
    return place


def hold_against_limits(machine, facts):
    """Check the speeds and changes of speed of all segments; return the worst change, as a part of the limit.

    A block's programmed speed is kept as the whole ticks that it lasts at that: a tick of them, in blocks that would be
    played in a few hundred, is the grain of its speed against its neighbours'.
    """
    before = None
    worst = 0.0
    for number, path, ticks in machine.segments:
        length, steps, top, acceleration, corner = facts[number]
        seconds = ticks / TICKS_PER_S
        here = path * length / steps
        speed = here / seconds
        grain = speed * 2 / ticks + 0.002 * min(top, 50)  # a tick, and the units of speed
        if steps != int(steps):
            grain += (0.006 + 0.0005 / path) * speed  # over an arc's run the true length of a step changes
        assert speed <= top * 1.001 + grain, (number, speed, top)
        blur = top / (length * TICKS_PER_S)
        if before is None:
            change, allowed = speed, acceleration * seconds
        else:
            change = abs(speed - before[0])
            allowed = max(acceleration, before[2]) * (seconds + before[1]) / 2
            if number != before[3]:  # from one block to the next, the corner lies between them
                grain += blur * speed + before[4] * before[0]
                allowed = acceleration * seconds / 2 + before[2] * before[1] / 2
                assert min(speed, before[0]) <= corner + allowed + grain
        if speed * 0.01 < change:
            worst = max(worst, (change * (1 - blur) - grain) / allowed)
        before = (speed, seconds, acceleration, number, blur)
    return worst


def line_lags(line, axes=3):
    """How far behind, and how far ahead of its place on the ideal line each axis may step.

    A step is at the beginning of its word's time: the dominant axis takes the one to k when it is at k − 1. One that follows it
    takes its step to k with the first dominant step that brings it beyond k − ½, and is before it, by its share of the dominant axis's
    steps, and at k − ½ at most: ½ behind k − 1 at most, and ahead by that share less ½.
    """
    shares = [int(line.state[LINE_RISE + axis]) / int(line.state[LINE_FALL]) for axis in range(axes)]
    return [0 if share == 1 else 0.5 for share in shares], [0 if share == 1 else share - 0.5 for share in shares]


def arc_lags(circle, axes=3):
    """The same of an arc: the axis that steps in every word, and the others, whose share changes all along, up to 1."""
    state = circle.state
    leads = state[CIRCLE_U_AXIS] if state[CIRCLE_RISE] == state[CIRCLE_FALL] and not circle._ending else -1
    return [0 if axis == leads else 0.5 for axis in range(axes)], [0 if axis == leads else 0.5 for axis in range(axes)]


def hold_axes_against_limits(machine, words):
    """Over any 20 ms an axis makes no more steps than its speed × 1.01 gives, and one: the grain of counting.

    Proof that an axis at constant speed can make one, and no more: between the first and the last of n steps it goes
    n − 1 steps. One that follows the dominant axis of a line by Bresenham's method goes that far less what the first was
    late and the last early (line_lags), which together is its share of the dominant axis's steps: it can make 1 + share.
    The check allows exactly that, across blocks too. Returns the most steps beyond, without that share.
    """
    window = TICKS_PER_S // 50
    stepping = (1 << machine.axes) - 1
    late, early = [], []
    for count, behind, ahead in machine.lags:
        late += [behind] * count
        early += [ahead] * count
    worst = 0.0
    for axis in range(machine.axes):
        most = machine.speeds[axis] / 1e9 * machine.steps_per_m[axis] / 50 * 1.01
        steps = []  # (tick, number of the stepping word)
        tick = number = 0
        for gap, levels in words:
            if levels >> axis & 1:
                steps.append((tick, number))
            if levels & stepping:
                number += 1
            tick += gap
        assert number == len(late)
        first = 0
        for last in range(len(steps)):
            while steps[last][0] - steps[first][0] >= window:
                first += 1
            over = last - first + 1 - most - late[steps[first][1]][axis] - early[steps[last][1]][axis]
            assert over <= 1, (axis, last - first + 1, most, over)
            worst = max(worst, over)
    return worst
