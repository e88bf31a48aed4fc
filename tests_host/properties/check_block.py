"""The arithmetic of a block: plan_block()'s 32-bit integers equal motion's formulas, computed with exact numbers; and its machine code gives the same as its
text run as Python.
"""

from array import array
from math import sqrt

from draws import Random
from passo.motion import block_viper, look_ahead_viper, row_viper
from passo.motion.limits import MOST, TICKS_PER_S, Limits
from passo.records import (
    LIMIT_WHOLE, QUEUE_ADDED, QUEUE_FETCHED, QUEUE_FIELDS, QUEUE_FLUSHED, ROW_CORNER, ROW_FASTEST, ROW_GAIN, ROW_LIMIT, ROW_REACH, ROW_SPEED, ROW_SQUARE, ROW_STEPS, ROW_TICKS,
    ROW_TICKS_REST, ROW_TOP, ROW_UNIT, ROW_UNIT_SHIFT, SCRATCH_ASKED, SCRATCH_FEED, SCRATCH_FIELDS, SCRATCH_SIZE, SCRATCH_STRIDE,
)  # fmt: skip
from passo.steps.word import COUNT_MASK
from plain import plain

CASES = {"check_numbers": (("seed", "seed"),), "check_machine_code": (("seed", "seed"),)}
RUNS = {"check_numbers": 200, "check_machine_code": 40}


def machine(random):
    axes = random.between(1, 4)
    steps_per_m = [random.choice((5000, 48_000, 83_333, 400_000, 3_200_000)) for _ in range(axes)]
    speeds = [random.between(1, 400) * 1_000_000 for _ in range(axes)]
    accelerations = [random.between(20, 5000) * 1_000_000 for _ in range(axes)]
    return Limits(steps_per_m, speeds, accelerations, random.choice((0, 5000, 50_000)))


def draw_line(random, axes):
    size = random.choice((2, 30, 500, 20_000, 2_097_151))
    return [random.between(-size, size) for _ in range(axes)]


def queue(limits, deltas, feed, rows, scratch, number):
    at = number * (ROW_STEPS + len(deltas))
    for axis in range(len(deltas)):
        rows[at + ROW_STEPS + axis] = deltas[axis]
    scratch[SCRATCH_FEED] = min(limits.part(feed), MOST) if feed else 0
    done = block_viper.plan_block(rows, at, scratch, limits.fields)
    if done == 1:
        look_ahead_viper.corner(rows, at, scratch, limits.fields)
    return done


def new(axes, count):
    scratch = array("i", [0] * SCRATCH_FIELDS)
    scratch[SCRATCH_STRIDE], scratch[SCRATCH_SIZE] = ROW_STEPS + axes, count
    scratch[34] = scratch[35] = 4096
    return array("i", [0] * ((ROW_STEPS + axes) * count)), scratch


def direction(limits, deltas):
    parts = [delta * 1e9 / per_m for delta, per_m in zip(deltas, limits.steps_per_m)]
    length = sqrt(sum([part * part for part in parts]))
    return length, [part / length for part in parts]


def weakest(values, heading):
    return min([value / abs(part) for value, part in zip(values, heading) if part])


def corner(limits, before, after):
    """Square of the speed; the usual form of the formula."""
    turn = [b - a for a, b in zip(before, after)]
    size = sqrt(sum([part * part for part in turn]))
    if size < 0.00142:
        return None
    s = sqrt(max(0, 1 - size * size / 4))
    acceleration = weakest(limits.accelerations, [part / size for part in turn])
    return acceleration * limits.junction_deviation * s * (1 + s) / (size * size / 4)


def near(value, exact, part, grain=0.0):
    return exact * (1 - part) - grain <= value <= exact * (1 + part) + grain


def check_numbers(seed):
    """On MicroPython's unix port as on CPython floats have 53 bits: exact enough."""
    random = Random(seed)
    limits = machine(random)
    axes = len(limits.speeds)
    rows, scratch = new(axes, 2)
    before = None
    for number in range(2):
        deltas = draw_line(random, axes)
        feed = random.choice((0, random.between(1, 500) * 1_000_000, random.between(100_000, 3_000_000)))
        done = queue(limits, deltas, feed, rows, scratch, number)
        total = max([abs(delta) for delta in deltas])
        if not total:
            assert done == 0
            return
        length, heading = direction(limits, deltas)
        fastest = weakest(limits.speeds, heading)
        speed = min(feed or fastest, fastest)
        ticks = length / speed * TICKS_PER_S
        if done == -1:
            assert ticks / total > MOST * 0.999
            return
        row = rows[number * (ROW_STEPS + axes) :][: ROW_STEPS + axes]
        unit = limits.fastest / (1 << 28)
        grain = 2 * unit / speed + 1e-6 + (4e-4 if not feed or feed >= fastest * 0.9996 else 0)
        assert near(row[ROW_SPEED] * unit, speed, grain)
        assert near(row[ROW_TICKS] * total + row[ROW_TICKS_REST], ticks, grain + 3e-6, 1 + total)
        assert near(row[ROW_TICKS] + row[ROW_TICKS_REST] / total, ticks / total, grain + 3e-6, 1)
        if not row[ROW_GAIN]:
            assert row[ROW_TICKS] > 8_000_000 and scratch[24] == 0
            return
        top, squares = row[ROW_TOP], limits.fastest * limits.fastest / (1 << 28)
        acceleration = weakest(limits.accelerations, heading)
        assert near(row[ROW_SQUARE] * squares, speed * speed, 2 * grain + 1e-4, 2 * squares)
        assert near(row[ROW_FASTEST] * squares, fastest * fastest, 1e-3, 2 * squares)
        assert top <= row[ROW_LIMIT] <= min(2 * top, 32_000)
        assert near(row[ROW_LIMIT], min(fastest / speed, 2, 32_000 / top) * top, 4e-4, 1)
        gain = 2 * acceleration * length * top * top / (total * speed * speed)
        assert near(row[ROW_GAIN], max(2, min(gain, MOST)), 2e-3 + 2 * grain, 1)
        if row[ROW_GAIN] > 2:  # the ramp can gain at least the speed that the passes count on
            assert row[ROW_REACH] <= row[ROW_GAIN] * total * (row[ROW_SPEED] / 16_384 / top) ** 2 * 1.0001
            reach = min(2 * acceleration * length / squares, MOST)
            assert row[ROW_GAIN] == MOST or near(min(row[ROW_REACH], MOST), reach, 6e-3 + 2 * grain, 2)
        assert near(row[ROW_UNIT] / 2.0 ** row[ROW_UNIT_SHIFT], squares * top * top / speed / speed, 1e-3 + 2 * grain)
        if number:
            exact = corner(limits, before, heading)
            # if a line turns back, the corner's sine is near 0, and known to a part in 2²⁸ of the directions only
            turn = sum([(b - a) ** 2 for a, b in zip(before, heading)])
            grain = 30 + max(limits.accelerations) * limits.junction_deviation * 2e-4 / squares if turn > 3.99 else 30
            if exact is None:
                assert row[ROW_CORNER] == MOST * 2 + 1
            else:
                assert near(min(row[ROW_CORNER], MOST), min(exact / squares, MOST), 5e-3, grain)
        before = heading


def check_machine_code(seed):
    """Rows, work and counts of a whole look-ahead that the feeder takes from, bit for bit."""
    random = Random(seed)
    limits = machine(random)
    axes = len(limits.speeds)
    queues = []
    program = [(draw_line(random, axes), random.between(0, 400) * 1_000_000, random.between(0, 7)) for _ in range(20)]
    twin = plain(look_ahead_viper)
    twin.update(plain(block_viper))
    twin.update(plain(row_viper))
    for plan, take in ((twin["plan_lines"], twin["take"]), (look_ahead_viper.plan_lines, row_viper.take)):
        rows, scratch = new(axes, 7)
        indices = array("i", [0] * QUEUE_FIELDS)
        results = []
        for number in range(len(program)):
            deltas, feed, taken = program[number]
            if not limits.fields[LIMIT_WHOLE] and feed != scratch[SCRATCH_ASKED]:
                scratch[SCRATCH_FEED], scratch[SCRATCH_ASKED] = min(limits.part(feed), MOST) if feed else 0, feed
            batch = array("i", [0, taken, feed, 7 * number, number, 0] + deltas + [0] * 4)
            results.append(plan(batch, 0, 1, rows, scratch, indices, limits.fields))
            assert not feed or scratch[SCRATCH_FEED] == min(limits.part(feed), MOST)
            if taken == 3 or number % 5 == 4:
                indices[QUEUE_FLUSHED] = indices[QUEUE_ADDED]  # released
            while (indices[QUEUE_ADDED] - indices[QUEUE_FETCHED]) & COUNT_MASK > 5 or taken:
                results.append(take(rows, scratch, indices, 1 if taken & 1 else 0, 1 if taken & 2 else 0))
                if results[-1] < 0:
                    results.append(take(rows, scratch, indices, 1, 0))
                taken = 0
        queues.append((results, list(rows), list(scratch), list(indices)))
    assert queues[0] == queues[1]
    assert len(queues[0][0]) > 20 and max(queues[0][0]) > 1
