"""Acceleration: limits kept, corners by the junction formula, ends exact, and hardly slower than a planner in floats."""

from passo.motion.planner import Planner
from passo.motion.speed_viper import spread
from passo.records import KIND_LINE
from passo.steps.word import TICKS_PER_S
from random_motion import MM, Machine, end_of, hold_against_limits, hold_axes_against_limits, path_of, reference_seconds

CASES = {
    "check_limits": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals", "arcs")),
    "check_start_speed": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "reversals", "arcs"), ("start", 1, 40)),
    "check_feeding_changes_nothing": (("seed", "seed"),),
    "check_a_live_stream": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "arcs"), ("patience", 1, 12)),
    "check_parts_of_steps_take_their_time": (("part", 0, 0x1FFFF), ("bits", 0, 28), ("each", "seed"), ("rest", 0, 127)),
}
RUNS = {"check_limits": 60, "check_start_speed": 20, "check_feeding_changes_nothing": 8, "check_a_live_stream": 20}
TURN_TICKS = 62_500


def check_limits(seed, kind):
    hold_limits(seed, kind)


def hold_limits(seed, kind, make=Machine):
    """Returns (blocks, segments, worst change of speed, worst steps too many in 20 ms, time, the reference's time)."""
    machine = make(seed, kind)
    words = machine.run()
    assert end_of(words, machine.axes) == machine.place
    if not machine.facts:
        return 0, 0, 0, 0, 0, 0
    worst = hold_against_limits(machine, machine.facts)
    assert worst <= 1, worst
    over = hold_axes_against_limits(machine, words)
    took = sum([segment[2] for segment in machine.segments]) / TICKS_PER_S
    best = reference_seconds(machine.facts)
    assert took <= best * 1.02 + 0.0005, (took, best)
    return len(machine.facts), len(machine.segments), worst, over, took, best


def check_parts_of_steps_take_their_time(part, bits, each, rest):
    """To some ticks, a step as long as it may be: a steep helix makes a hundred words of one step of its circle."""
    each = each % (1 << bits) + (1 << bits)
    whole = min((1 << 28) // each, 255)
    found = spread(whole << 17 | part, each, rest)
    exact = (whole << 17 | part) * (each * 128 + rest) / (1 << 24)
    assert abs(found - exact) <= 4 + (whole if each >= 0x80000 else 0), (found, exact)


def check_start_speed(seed, kind, start):
    """Up to the start speed, in mm/s, there is no ramp; above it all changes keep the acceleration; the path is the same."""
    plain = Machine(seed, kind)
    path = path_of(plain.run())
    machine = Machine(seed, kind)
    machine.limited(machine.steps_per_m, machine.speeds, machine.accelerations, machine.deviation, start * MM)
    assert path_of(machine.run()) == path
    took = [sum([segment[2] for segment in each.segments]) for each in (plain, machine)]
    assert took[1] <= took[0] * 1.001 + 12_500
    before = 0, 0, 0
    for number, part, ticks in machine.segments:
        length, steps, top, acceleration, _ = machine.facts[number]
        seconds = ticks / TICKS_PER_S
        speed = part * length / steps / seconds
        grain = speed * 2 / ticks + 0.002 * min(top, 50) + 0.01 * speed
        assert speed <= top * 1.001 + grain
        allowed = (acceleration * seconds + before[2] * before[1]) / 2 * 1.02 + grain
        slower, faster = min(speed, before[0]), max(speed, before[0])
        assert faster <= max(slower, start) + allowed, (number, speed, before)
        if not before[0]:
            assert speed >= min(start, top) * 0.99 - grain
        before = speed, seconds, acceleration


def check_feeding_changes_nothing(seed):
    """The words do not depend on how far ahead the queue is filled, once the look-ahead is."""
    machine = Machine(seed, "tiny", 20)
    words = machine.run()
    other = Machine(seed, "tiny", 20)
    other.rig.planner.room = lambda: Planner.room(other.rig.planner) > 10 and 1
    assert other.run() == words


def set_out(planner):
    """Start the waiting block, as Program.begin() does."""
    if planner.row() < 0 and not planner.empty():
        planner.start()


class Live:
    """A programme that arrives a few moves at a time while it is played, `patience` turns of 5 ms apart at most.

    `stands`: the blocks before which the machine stood, although they were queued when the one before them began."""

    def __init__(self, seed, kind, patience, release=set_out):
        self.machine = machine = Machine(seed, kind)
        self._planner = planner = machine.rig.planner
        self._ramp = machine.rig.feeder.ramp
        self._listen()
        self._known = 0  # blocks queued as the one under way began
        self.stands = []
        self.gone_on = self.ticks = 0
        machine.facts, machine.place = [], [0, 0, 0]
        self.words = []
        todo = list(machine.program)
        wait = 0
        while todo or not planner.empty():
            if todo and wait == 0:
                for _ in range(machine.random.between(1, 3)):
                    if todo and planner.room():
                        machine.add(todo.pop(0))
                wait = machine.random.between(1, patience)
            wait = max(wait - 1, 0)
            release(planner)
            self._play(TURN_TICKS)

    def _play(self, ticks):
        """Play one cycle: its words, or idle time if there are none."""
        rig = self.machine.rig
        words = rig.take(ticks)
        rig.feeder.retire(rig.played)
        self.words += words
        self.ticks += max(sum([word[0] for word in words]), ticks)

    def _listen(self):
        """Look at each block as its first segment is cut."""
        self._last = -1

        def listen_cut(*arguments, cut=self._ramp.accelerated):
            number = self.machine.number()
            if number != self._last:
                if 0 < number < self._known and self._could_go_on(number):
                    if self._ramp.moving():
                        self.gone_on += 1
                    else:
                        self.stands.append(number)
                self._known = len(self.machine.facts)
                self._last = number
            cut(*arguments)

        self._ramp.accelerated = listen_cut

    def _could_go_on(self, number):
        """The corner before block `number`, and the blocks on both sides, allow a hundredth of the highest speed."""
        facts = self.machine.facts
        corner = facts[number][4]
        for length, _, speed, acceleration, _ in facts[number - 1 : number + 1]:
            corner = min(corner, speed, (2 * acceleration * length) ** 0.5)
        return corner * MM > self.machine.limits.fastest / 100


def check_a_live_stream(seed, kind, patience):
    """Lines that come slowly: no limit is exceeded, no step is lost, and the machine stands only where no more had come."""
    live = Live(seed, kind, patience)
    assert path_of(live.words) == path_of(Machine(seed, kind).run())
    assert live.stands == []
    if live.machine.facts:
        hold_against_limits(live.machine, live.machine.facts)
        hold_axes_against_limits(live.machine, live.words)


def check_a_stand_in_a_live_stream_is_seen():
    """Were the queue flushed instead, the machine would stand."""
    for seed in (1, 3, 6):
        assert len(Live(seed, "lines", 4, Planner.flush).stands) > 3
        assert Live(seed, "lines", 4).gone_on > 20


def check_first_step_from_rest_is_at_once():
    machine = Machine(5, "lines", 1)
    machine.facts, machine.place = [], [0, 0, 0]
    machine.add((KIND_LINE, (1000, 0, 0), 50 * MM))
    machine.rig.planner.flush()
    words = machine.rig.take(125_000)
    before = 0
    for ticks, levels in words:
        if levels & 1:
            break
        before += ticks
    assert before < 5 * 12_500
