"""Lines: exact ends, fewest steps, never more than half a step off, as the closed form has it, in every octant."""

from array import array

from passo.motion.integers import isqrt, length_nm
from passo.motion.line import MAX_RUN, MAX_STEPS, Line
from passo.records import LINE_RISE

CASES = {
    "check_random_lines": (("dx", -65535, 65535), ("dy", -65535, 65535)),
    "check_three_axes": (("dx", -400, 400), ("dy", -400, 400), ("dz", -400, 400)),
    "check_seek": (("dx", -3000, 3000), ("dy", -3000, 3000), ("part", 0, 1000)),
    "check_longest": (("dy", -MAX_STEPS, MAX_STEPS), ("index", 0, MAX_STEPS - MAX_RUN)),
    "check_isqrt": (("value", 0, 1 << 58),),
}
RUNS = {"check_random_lines": 25, "check_three_axes": 60}

OUT = array("I", bytearray(4 * MAX_RUN))


def masks(line, count):
    """The masks of the next `count` steps of `line`."""
    result = []
    while count:
        run = min(count, MAX_RUN)
        line.walk(OUT, 0, run)
        result += [OUT[i] for i in range(run)]
        count -= run
    return result


def steps_of(line, axis, index):
    """Steps of `axis` after `index` dominant steps, in closed form."""
    return (line.state[LINE_RISE + axis] * index + line.total - 1) // (2 * line.total)


def offset(line, axis, index):
    return steps_of(line, axis, index) * (-1 if line.negative >> axis & 1 else 1)


def seek(line, index):
    """Stand before dominant step `index` (0 … total), as if that many had been walked."""
    line.left = line.total - index
    axes = len(line.made)
    for axis in range(axes):
        decision = line.state[LINE_RISE + axis] * (index + 1) + line.total - 2 * line.total * steps_of(line, axis, index)
        line.state[LINE_RISE + axes + axis] = decision


def walk_whole(deltas):
    """Walk a whole line and hold every step of it against the ideal one."""
    line = Line(len(deltas))
    line.begin(deltas)
    total = max([abs(delta) for delta in deltas])
    assert line.total == line.left == total
    place = [0] * len(deltas)
    step = 0
    for mask in masks(line, total):
        step += 1
        for axis in range(len(deltas)):
            if mask >> axis & 1:
                place[axis] += -1 if line.negative >> axis & 1 else 1
            assert abs(2 * (place[axis] * total - deltas[axis] * step)) <= total
    assert place == list(deltas)
    assert list(line.made) == place
    assert line.left == 0


def check_every_short_vector():
    for dx in range(-40, 41):
        for dy in range(-40, 41):
            if dx or dy:
                walk_whole((dx, dy))


def check_random_lines(dx, dy):
    if dx or dy:
        walk_whole((dx, dy))


def check_three_axes(dx, dy, dz):
    if dx or dy or dz:
        walk_whole((dx, dy, dz))


def check_tie_takes_no_minor_step():
    line = Line(2)
    line.begin((2, 1))
    assert masks(line, 2) == [0b01, 0b11]  # after one step y would be exactly half a step away: it waits


def check_seek(dx, dy, part):
    """A line walked to any index stands exactly where the closed form has it, and goes on likewise."""
    if not (dx or dy):
        return
    whole = Line(2)
    whole.begin((dx, dy))
    index = whole.total * part // 1000
    masks(whole, index)
    for axis in range(2):
        assert whole.made[axis] == offset(whole, axis, index)
    later = Line(2)
    later.begin((dx, dy))
    seek(later, index)
    assert later.left == whole.left
    for one, other in zip(masks(later, later.left), masks(whole, whole.left)):
        assert one == other  # not the lists: pytest compares thousands of items for minutes where CI is set


def check_longest(dy, index):
    """The longest line needs no integer of 2³⁰ or more while walking."""
    line = Line(2)
    line.begin((MAX_STEPS, dy))
    seek(line, index)
    rise = 2 * abs(dy)
    assert rise + 4 * MAX_STEPS < 1 << 30
    line.walk(OUT, 0, MAX_RUN)
    assert line.made[0] == MAX_RUN
    assert line.made[1] == offset(line, 1, index + MAX_RUN) - offset(line, 1, index)


def check_too_long_is_refused():
    for deltas in ((MAX_STEPS + 1, 0), (0, -MAX_STEPS - 1)):
        try:
            Line(2).begin(deltas)
        except ValueError:
            continue
        raise AssertionError("accepted")


def check_isqrt(value):
    root = isqrt(value)
    assert root * root <= value < (root + 1) * (root + 1)


def check_length():
    assert length_nm((300, 400), (10000, 10000)) == 50_000_000
    assert length_nm((48, 0), (48000, 83000)) == 1_000_000
    assert length_nm((48, -83), (48000, 83000)) == isqrt(2 * 1_000_000 * 1_000_000)
