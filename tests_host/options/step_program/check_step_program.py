"""Programs: every unit once and in its order, both ways and from any place; periods exact; the place known at any word."""

from draws import Random
from passo.options.step_program.motion import DWELL, MOST, SPEED, STATION, TOOL, StepProgram, make_mark, run, count_units
from passo.options.step_program.motion_walker import StepProgramWalker
from passo.records import COUNT_MASK, ENDLESS, FEED_LEVELS, HOLD_TICKS
from rig import Rig

CASES = {
    "check_there_and_back": (("seed", "seed"),),
    "check_turned_round_anywhere": (("seed", "seed"),),
    "check_halted_anywhere": (("seed", "seed"),),
    "check_window": (("seed", "seed"),),
    "check_periods": (("mm_min", 1, 3000), ("mask", 1, 7)),
}
RUNS = {name: 8 for name in CASES}

# Steps of 12.5 µm, as on 80 steps/mm: nm × 60, by how many axes step at once.
LENGTHS = [0] + [(12500, 17678, 21651)[(bin(mask).count("1")) - 1] * 60 for mask in range(1, 8)]
TOOL_TICKS = (2_000, 300_000)


def new_program(cells=1024, tool_ticks=TOOL_TICKS):
    program = StepProgram(3, cells)
    program.clear_items(3000)
    return program, StepProgramWalker(program, LENGTHS, tool_ticks)


def random_items(random, count, speeds=(1200, 3000, 6000)):
    items = []
    for _ in range(count):
        kind = random.between(0, 9)
        if kind == 0:
            items.append(make_mark(TOOL, random.between(0, 1)))
        elif kind == 1:
            items.append(make_mark(SPEED, random.choice(speeds)))
        elif kind == 2:
            items.append(make_mark(DWELL, random.choice((0, 1, 9, 10, 25))))
        else:
            mask = random.between(1, 7)
            items.append(run(mask, random.between(0, 7) & mask, random.choice((1, 1, 2, 3, 7, 60))))
    return items


def moves_of(items):
    """[(place before it, moves, tool, speed)] of every single step, in order."""
    place = tool = 0
    speed = 3000
    steps = []
    for item in items:
        if item & 15:
            moves = [0, 0, 0]
            for axis in range(3):
                if item >> axis & 1:
                    moves[axis] = -1 if item >> 4 + axis & 1 else 1
            for _ in range(item >> 8):
                steps.append((place, moves, tool, speed))
                place += 1
        else:
            if item >> 4 & 15 == TOOL:
                tool = item >> 8 & 1
            elif item >> 4 & 15 == SPEED:
                speed = item >> 8
            place += 1
    return steps


def opposite(steps):
    return [(place, [-move for move in moves], tool, speed) for place, moves, tool, speed in steps][::-1]


class Ride:
    """A program on the bench, and the steps and marks of its words."""

    def __init__(self, program, walker):
        self.rig = Rig("step_dir", 3)
        self.program = program
        self.walker = walker
        self.tick = 0
        self.steps = []  # (tick, moves, tool)
        self.at = [0, 0, 0]

    def play(self, words):
        axes = 3
        for ticks, levels in words:
            assert ticks <= HOLD_TICKS
            if levels & 7:
                moves = [0, 0, 0]
                for axis in range(axes):
                    if levels >> axis & 1:
                        moves[axis] = 1 if levels >> axes + axis & 1 else -1
                        self.at[axis] += moves[axis]
                self.steps.append((self.tick, moves, levels >> 2 * axes & 1))
            self.tick += ticks

    def go(self, backward=False, most=ENDLESS, fills=1 << 20, lead=100_000):
        """Walk on; after `fills` fills it is held, and taken off at its stand."""
        rig = self.rig
        self.walker.begin(backward, most, bool(rig.feeder.state[FEED_LEVELS] & rig.layout.tool_mask))
        rig.planner.walk(self.walker, self.walker.tool)
        rig.planner.flush()
        while not rig.planner.empty() and fills:
            self.play(rig.take(lead))
            rig.feeder.retire(rig.played)
            fills -= 1
        if not rig.planner.empty():
            rig.feeder.hold = True
            self.play(rig.take(lead))
            assert rig.feeder.standing()
            assert rig.feeder.index(rig.played) == self.walker.index
            assert rig.feeder.cancel(rig.played) == self.at
            rig.planner.clear()
            rig.feeder.hold = False

    def check(self, steps, first=0):
        """The steps from `first` on were these, in the tool and at the periods they should have."""
        made = self.steps[first:]
        assert [(moves, tool) for _, moves, tool in made] == [(moves, tool) for _, moves, tool, _ in steps]


def fill(program, items):
    for item in items:
        assert program.append(item)
    program.open = False
    assert program.total == sum([count_units(item) for item in items])


def check_there_and_back(seed):
    random = Random(seed)
    items = random_items(random, 60)
    steps = moves_of(items)
    program, walker = new_program()
    fill(program, items)
    walker.go_to_start()
    ride = Ride(program, walker)
    ride.go()
    ride.check(steps)
    assert walker.index == program.total and walker.at_end()
    for before, after, step in zip(ride.steps, ride.steps[1:], steps):
        mask = sum([1 << axis for axis in range(3) if step[1][axis]])
        period = (LENGTHS[mask] + step[3] // 2) // step[3]
        assert after[0] - before[0] >= period * 25 // 2 - 64  # less only by the change of direction before it
    gone = len(ride.steps)
    ride.go(backward=True)
    ride.check(opposite(steps), gone)
    assert walker.index == 0 and walker.at_start() and ride.at == [0, 0, 0]


def check_turned_round_anywhere(seed):
    """Whatever is done at random places, every step has the tool and the moves of its place, and the end is the end."""
    random = Random(seed)
    items = random_items(random, 40)
    steps = moves_of(items)
    program, walker = new_program()
    fill(program, items)
    walker.go_to_start()
    ride = Ride(program, walker)
    for _ in range(30):
        before = walker.index
        gone = len(ride.steps)
        backward = random.between(0, 1) == 1
        most = random.choice((ENDLESS, ENDLESS, 1, 2, 5))
        ride.go(backward, most, random.between(1, 5), random.choice((10_000, 100_000)))
        low, high = min(before, walker.index), max(before, walker.index)
        part = [step for step in steps if low <= step[0] < high]
        ride.check(opposite(part) if backward else part, gone)
        assert most == ENDLESS or high - low <= most
    gone = len(ride.steps)
    rest = [step for step in steps if step[0] >= walker.index]
    ride.go()
    ride.check(rest, gone)
    gaps = [after[0] - before[0] for before, after in zip(ride.steps, ride.steps[1:])]
    assert min(gaps or [9999]) >= (LENGTHS[1] + 3000) // 6000 * 25 // 2 - 64  # no step ever came too early


def check_halted_anywhere(seed):
    """After a halt inside the words, the place is that of the steps which have appeared: from there come all that have not."""
    random = Random(seed)
    items = random_items(random, 30)
    steps = moves_of(items)
    program, walker = new_program()
    fill(program, items)
    for backward in (False, True):
        walker.go_to_start()
        if backward:
            Ride(program, walker).go()
        ride = Ride(program, walker)
        rig = ride.rig
        walker.begin(backward)
        rig.planner.walk(walker, walker.tool)
        rig.planner.flush()
        for _ in range(random.between(0, 6)):
            ride.play(rig.take())
        rig.feeder.fill(rig.played, 375_000)
        made = (rig.ring.head - rig.played) & COUNT_MASK
        if made:
            part = random.between(0, made)
            for _ in range(part):
                word = rig.ring.words[rig.played & rig.ring.mask]
                ride.play([(word >> rig.layout.bits, word & rig.layout.levels_mask)])
                rig.played = (rig.played + 1) & COUNT_MASK
        shown = rig.feeder.index(rig.played)
        assert rig.feeder.cancel(rig.played) == ride.at
        ended = rig.planner.empty()
        rig.planner.clear()
        if ended:
            assert shown in (None, walker.index)
            continue
        place = shown
        walker.go_to_start()
        if place:
            Ride(program, walker).go(most=place)
        assert walker.index == place
        done = opposite(steps)[: len(ride.steps)] if backward else steps[: len(ride.steps)]
        ride.check(done)
        gone = len(ride.steps)
        rest = [step for step in steps if step[0] >= place]
        ride.go()
        ride.check(rest, gone)


def check_window(seed):
    """An open program is walked as it comes, goes on where it was dry, and forgets only what lies far behind."""
    random = Random(seed)
    items = random_items(random, 150)
    program, walker = new_program(64)
    program.clear_items(3000, ring=True)
    walker.go_to_start()
    ride = Ride(program, walker)
    rig = ride.rig
    walker.begin()
    rig.planner.walk(walker, walker.tool)
    rig.planner.flush()
    queue = items[:]
    while queue:
        while queue and (program.end - walker.cell) & COUNT_MASK < program.size // 2 and random.between(0, 9):
            assert program.append(queue.pop(0))
        ride.play(rig.take(random.choice((10_000, 100_000))))
        rig.feeder.retire(rig.played)
    program.open = False
    while not rig.planner.empty():
        ride.play(rig.take())
        rig.feeder.retire(rig.played)
    steps = moves_of(items)
    ride.check(steps)
    gone = len(ride.steps)
    ride.go(backward=True)
    assert walker.index == program.start and walker.at_start()
    ride.check(opposite([step for step in steps if step[0] >= walker.index]), gone)


def check_dry_is_not_late():
    program, walker = new_program()
    program.clear_items(3000, ring=True)
    program.append(run(1, 0, 3))
    walker.go_to_start()
    ride = Ride(program, walker)
    walker.begin()
    ride.rig.planner.walk(walker, walker.tool)
    ride.rig.planner.flush()
    for _ in range(5):
        ride.play(ride.rig.take())
    late = ride.rig.feeder.late
    for _ in range(5):
        ride.play(ride.rig.take())
    assert ride.rig.feeder.late == late and len(ride.steps) == 3
    program.append(run(1, 0, 2))
    ride.play(ride.rig.take())
    assert len(ride.steps) == 5 and not ride.rig.planner.empty()


def check_periods(mm_min, mask):
    """Whole microseconds, each within a tick, and exact in the mean: 12½ ticks are a microsecond."""
    program, walker = new_program()
    fill(program, [make_mark(SPEED, mm_min), run(mask, 0, 41)])
    walker.go_to_start()
    ride = Ride(program, walker)
    ride.go()
    period_us = (LENGTHS[mask] + mm_min // 2) // mm_min
    assert walker.step_us(mask) == period_us
    for count in range(41):
        assert abs(2 * (ride.steps[count][0] - ride.steps[0][0]) - 25 * period_us * count) <= 130 - (count == 0)
    assert ride.steps[40][0] - ride.steps[0][0] in (500 * period_us, 500 * period_us - 63)


def check_live_speed():
    """A new speed is felt by the next segment, and cuts a long interval short."""
    program, walker = new_program()
    fill(program, [make_mark(SPEED, 1), run(1, 0, 4)])  # 0.75 s a step
    walker.go_to_start()
    ride = Ride(program, walker)
    walker.begin()
    ride.rig.planner.walk(walker, walker.tool)
    ride.rig.planner.flush()
    ride.play(ride.rig.take(200_000))
    walker.set_speed(1000)
    while not ride.rig.planner.empty():
        ride.play(ride.rig.take(200_000))
        ride.rig.feeder.retire(ride.rig.played)
    gaps = [after[0] - before[0] for before, after in zip(ride.steps, ride.steps[1:])]
    assert gaps[0] < 400_000 and gaps[1:] == [9375, 9375]


def check_stations():
    program, walker = new_program()
    fill(program, [run(1, 0, 5), make_mark(STATION, 7), run(1, 0, 3)])
    walker.go_to_start()
    ride = Ride(program, walker)
    ride.go()
    assert len(ride.steps) == 5 and not walker.at_end()
    ride.go()
    assert len(ride.steps) == 5
    assert walker.pass_station() == 7 and walker.pass_station() is None
    ride.go()
    assert len(ride.steps) == 8 and walker.index == 9
    ride.go(backward=True)
    assert len(ride.steps) == 16 and walker.index == 0


def check_full():
    program, walker = new_program(5)
    assert program.size == 4
    assert program.append(run(1, 0, MOST)) and program.append(run(1, 0, 1)) and program.append(run(2, 0))
    assert not program.append(make_mark(SPEED, 100)) and program.cells_used() == 3
    assert program.append(make_mark(DWELL, 100)) and not program.append(run(1, 0))
    assert program.append(run(2, 0)) is False and program.total == MOST + 3
    assert program.at == [MOST + 1, 1, 0]


def check_speed_found_late():
    """The operator's choice at a station counts there when the walk comes back."""
    program, walker = new_program()
    fill(program, [run(1, 0, 2), make_mark(STATION, 0), run(1, 0, 2), make_mark(SPEED, 600), run(1, 0, 2)])
    walker.go_to_start()
    ride = Ride(program, walker)
    ride.go()
    walker.pass_station()
    program.correct_speed(walker.cell, 1500)
    walker.set_speed(1500)
    ride.go()
    assert walker.speed == 600
    ride.go(backward=True, most=4)
    assert walker.speed == 1500
