"""Words, pacing, segments and the feeder: exact totals, even intervals, exact position at every word."""

from array import array

from check_kernels import terms_of
from passo.motion.integers import length_nm
from passo.options.independent.motion import IndependentAxes
from passo.motion.planner import LOOK_AHEAD
from passo.records import COUNT_MASK, ENDLESS, FEED_DEBT, HOLD_TICKS, KIND_LINE, TICKS_PER_MS, TICKS_PER_S
from passo.steps import position as asked
from passo.steps.pace_viper import pace, repay
from passo.steps.ring import Ring
from passo.steps.word import us_to_ticks
from rig import DRIVES, LEAST_TICKS, SETUP_TICKS, Rig, total_ticks

VECTOR = (("dx", -3000, 3000), ("dy", -3000, 3000))
CASES = {
    "check_pace": (("steps", 1, 255), ("ticks", 300, 250_000), ("cut", 0, 255)),
    "check_repay": (("debt", 0, 3000), ("least", 20, 60), ("gaps", "list", 60, ("gap", 60, 400))),
    "check_line_time": VECTOR + (("each", 30, 40_000), ("rest", 0, 2_097_150)),
    "check_slow_line": (("steps", 1, 4), ("ticks", 1, 200_000_000)),
    "check_wait": (("ticks", 1, 40_000_000),),
    "check_turns": (("moves", "list", 12, ("dx", -60, 60), ("dy", -60, 60)), ("each", 60, 4000)),
    "check_position_at_every_word": (
        ("drive", "choice") + tuple(sorted(DRIVES)),
        ("moves", "list", 6, ("dx", -40, 40), ("dy", -40, 40)),
        ("each", 60, 30_000),
    ),
    "check_ring_offset_changes_nothing": (("offset", 1, 4095), ("dx", -900, 900), ("dy", -900, 900)),
    "check_cancel_and_take_up": VECTOR + (("part", 0, 1000), ("each", 60, 9000)),
    "check_independent": (
        ("x", 0, 200), ("x_each", 50, 40_000), ("x_rest", 0, 6),
        ("y", 0, 200), ("y_each", 50, 40_000), ("y_rest", 0, 6),
    ),
}
RUNS = {
    "check_line_time": 40,
    "check_slow_line": 12,
    "check_position_at_every_word": 30,
    "check_cancel_and_take_up": 25,
    "check_independent": 30,
    "check_turns": 40,
    "check_ring_offset_changes_nothing": 15,
}


def check_us_to_ticks_never_short():
    for us in range(200):
        assert us_to_ticks(us) * 80 >= us * 1000 > (us_to_ticks(us) - 1) * 80 or us == 0


def check_ring_size_is_a_power_of_two():
    try:
        Ring(1000)
    except ValueError:
        return
    raise AssertionError("accepted")


def check_pace(steps, ticks, cut):
    """Two calls that share a carry make the same words as one; the total is exact, intervals differ by one tick."""
    terms = terms_of(steps, ticks, 0b100, 5)
    whole = array("I", [1] * steps)
    pace(whole, 0, steps, terms)
    parts = array("I", [1] * steps)
    cut = min(cut, steps)
    terms = terms_of(steps, ticks, 0b100, 5)
    for at, count in ((0, cut), (cut, steps - cut)):
        if count:
            pace(parts, at, count, terms)
    assert list(whole) == list(parts)
    gaps = [word >> 5 for word in whole]
    assert sum(gaps) == ticks
    assert max(gaps) - min(gaps) <= 1
    assert set([word & 31 for word in whole]) == set([0b101])


def check_repay(debt, least, gaps):
    words = array("I", [gap << 5 | 3 for gap in gaps])
    left = repay(words, 0, len(gaps), 5, debt, least)
    after = [word >> 5 for word in words]
    assert sum(gaps) - sum(after) == debt - left
    assert left == 0 or after == [least] * len(gaps)
    for gap in after:
        assert gap >= least
    assert set([word & 31 for word in words]) <= set([3])


def check_line_time(dx, dy, each, rest):
    """A line's words last exactly what was asked; every interval is the floor or the ceiling of the mean."""
    total = max(abs(dx), abs(dy))
    if not total:
        return
    rig = Rig()
    ticks = total * each + rest % total
    rig.planner.line((dx, dy), ticks, False)
    words = rig.run()
    steps = rig.steps_of(words)
    assert len(steps) == total
    assert total_ticks(words) - rig.feeder.state[FEED_DEBT] == ticks  # too short a line leaves part of the set-up time to the next
    place = [0, 0]
    for _, moves in steps:
        place[0] += moves[0]
        place[1] += moves[1]
    assert place == [dx, dy] == rig.feeder.position(rig.played)
    settled = 1 + SETUP_TICKS // (each - LEAST_TICKS) + 1  # the set-up time is owed by the first intervals
    for i in range(settled, total - 1):
        assert 0 <= steps[i + 1][0] - steps[i][0] - each <= 1


def check_slow_line(steps, ticks):
    """Steps many seconds apart: hold words of at most 10 ms, the total exact."""
    ticks = max(ticks, steps * LEAST_TICKS * 4)
    rig = Rig()
    rig.planner.line((steps, 0), ticks, False)
    words = rig.run()
    assert total_ticks(words) == ticks
    assert max([gap for gap, _ in words]) <= HOLD_TICKS
    assert len(rig.steps_of(words)) == steps


def check_steps_too_far_apart_are_refused():
    rig = Rig()
    rig.planner.line((1, 0), 0x1FFFFFFF, False)
    try:
        rig.planner.line((1, 0), 0x20000000, False)
    except ValueError:
        return
    raise AssertionError("accepted")


def check_wait(ticks):
    rig = Rig()
    rig.planner.wait(ticks, True)
    words = rig.run()
    assert total_ticks(words) == ticks
    for gap, levels in words:
        assert gap <= HOLD_TICKS and levels == rig.layout.tool_mask


def check_turns(moves, each):
    """Directions change in stepless words of the set-up time; nobody steps sooner after; the totals stay exact."""
    rig = Rig()
    wanted = 0
    for dx, dy in moves:
        steps = max(abs(dx), abs(dy))
        wanted += steps * each
        rig.planner.line((dx, dy), steps * each, False)
    words = rig.run()
    assert total_ticks(words) - wanted == rig.feeder.state[FEED_DEBT]
    tick = 0
    changed = [-SETUP_TICKS, -SETUP_TICKS]
    before = 0
    for ticks, levels in words:
        for axis in range(2):
            if (levels ^ before) >> (2 + axis) & 1:
                changed[axis] = tick
            if levels >> axis & 1:
                assert tick - changed[axis] >= SETUP_TICKS
        assert ticks >= LEAST_TICKS
        before = levels
        tick += ticks
    place = [0, 0]
    for _, step in rig.steps_of(words):
        place = [place[0] + step[0], place[1] + step[1]]
    assert place == [sum([move[0] for move in moves]), sum([move[1] for move in moves])]


def check_an_axis_at_rest_keeps_its_direction():
    rig = Rig()
    rig.planner.line((5, -5), 50_000, False)
    rig.planner.line((5, 0), 50_000, False)
    directions = set([levels >> 2 for _, levels in rig.run()])
    assert directions == set([0b01])


def check_position_at_every_word(drive, moves, each):
    """Position from words played equals the position decoded step by step, for every drive, at every word."""
    rig = Rig(drive, reversed_axes=(1,))
    place = [0, 0]
    for dx, dy in moves:
        rig.planner.line((dx, dy), max(abs(dx), abs(dy)) * each, False)
        place[0] += dx
        place[1] += dy
    rig.planner.flush()
    before = rig.drive.levels() if rig.drive else 0
    seen = [0, 0]
    while True:
        rig.feeder.fill(rig.played, 100_000)
        if rig.played == rig.ring.head:
            break
        levels = rig.ring.words[rig.played & rig.ring.mask] & rig.layout.levels_mask
        rig.played = (rig.played + 1) & COUNT_MASK
        for axis in range(2):
            if rig.drive:
                seen[axis] += rig.drive.step_between(axis, before, levels)
            elif levels >> axis & 1:
                seen[axis] += 1 if levels >> 2 + axis & 1 else -1
        before = levels
        assert rig.feeder.position(rig.played) == seen
    assert seen == place


def check_position_asked_while_an_interrupt_goes_on():
    """Segments are given back, in an interrupt, just before the last mark played is looked for."""
    rig = Rig()
    rig.planner.line((300, -200), 300 * 125, False)
    rig.planner.flush()
    rig.feeder.fill(0, 20 * TICKS_PER_MS)
    find = asked.find

    def interrupted(state, marks, played, place):
        asked.find = find
        rig.feeder.retire(250)
        return find(state, marks, played, place)

    asked.find = interrupted
    position = rig.feeder.position(50)
    assert asked.find is find and position == rig.feeder.position(250) and position[0] == 249


def check_ring_offset_changes_nothing(offset, dx, dy):
    """A job's words do not depend on its place in the ring, nor on how often the ring is filled."""
    jobs = []
    for start, lead in ((0, 375_000), (offset, 60_000)):
        rig = Rig()
        rig.ring.head = rig.played = start
        rig.feeder._reset(start)
        rig.planner.line((dx, dy), max(abs(dx), abs(dy), 1) * 70, False)
        rig.planner.line((-dy, dx), max(abs(dx), abs(dy), 1) * 55, True)
        rig.planner.flush()
        words = []
        while not rig.planner.empty():
            words += rig.take(lead)
            rig.feeder.retire(rig.played)
        jobs.append(words)
    assert jobs[0] == jobs[1]


def check_cancel_and_take_up(dx, dy, part, each):
    """Halted at any word, the position is what the pins saw, and the block can be taken up to its exact end."""
    total = max(abs(dx), abs(dy))
    if not total:
        return
    rig = Rig()
    rig.planner.line((3, -2), 3 * each, False, 1)
    rig.planner.line((dx, dy), total * each, True, 2)
    rig.planner.flush()
    words = []
    stop = (total + 3) * part // 1000
    while len(words) <= stop and not rig.planner.empty():
        rig.feeder.fill(rig.played, 400_000)
        while rig.played != rig.ring.head and len(words) <= stop:
            word = rig.ring.words[rig.played & rig.ring.mask]
            words.append((word >> rig.layout.bits, word & rig.layout.levels_mask))
            rig.played = (rig.played + 1) & COUNT_MASK
        rig.feeder.retire(rig.played)
    seen = [0, 0]
    for _, moves in rig.steps_of(words):
        seen = [seen[0] + moves[0], seen[1] + moves[1]]
    assert rig.feeder.cancel(rig.played) == seen == rig.feeder.position(rig.played)
    if rig.planner.empty():
        assert seen == [3 + dx, dy - 2]


def check_look_ahead_holds_back_until_full_or_flushed():
    rig = Rig()
    for count in range(LOOK_AHEAD - 1):
        rig.planner.line((1, 0), 20_000, False)
        assert rig.planner.next() is None
    rig.planner.line((1, 0), 20_000, False)
    assert rig.planner.next().kind == KIND_LINE
    assert rig.planner.next() is None
    rig.planner.flush()
    for count in range(LOOK_AHEAD - 1):
        assert rig.planner.next() is not None
    assert rig.planner.next() is None


def check_running_dry_inside_a_block_is_counted():
    rig = Rig()
    rig.planner.line((100, 0), 100 * TICKS_PER_MS, False)
    rig.planner.flush()
    rig.take(20 * TICKS_PER_MS)
    assert rig.feeder.late == 0
    rig.take(20 * TICKS_PER_MS)
    assert rig.feeder.late == 1


def check_path_speed_is_the_same_at_every_slope():
    """At every whole degree the path speed, between feet on the ideal line that share the dominant coordinate of steps
    20 apart, stays within 1 % of the one asked for; the whole line within 0.01 %."""
    from math import cos, pi, sin

    asked = 500  # steps a second along the path
    for degree in range(360):
        dx = int(round(400 * cos(degree * pi / 180)))
        dy = int(round(400 * sin(degree * pi / 180)))
        ticks = length_nm((dx, dy), (10000, 10000)) * TICKS_PER_S // (asked * 100_000)
        rig = Rig()
        rig.planner.line((dx, dy), ticks, False)
        words = rig.run()
        length = (dx * dx + dy * dy) ** 0.5
        assert abs(length / asked * TICKS_PER_S / total_ticks(words) - 1) < 0.0001
        steps = [tick for tick, _ in rig.steps_of(words)]
        foot = length / len(steps)
        for i in range(1, len(steps) - 20):  # the first interval also pays for the direction's set-up time
            speed = 20 * foot * TICKS_PER_S / (steps[i + 20] - steps[i])
            assert abs(speed / asked - 1) < 0.01


def check_independent(x, x_each, x_rest, y, y_each, y_rest):
    """Each axis steps at its own mean rate to its own count; sharing a word moves a step by less than `least`."""
    rig = Rig()
    axes = IndependentAxes(2, LEAST_TICKS)
    axes.run_axis(0, x, x_each, x_rest, 7)
    axes.run_axis(1, y, y_each, y_rest, 7, negative=True)
    rig.planner.walk(axes, False)
    words = rig.run()
    seen = [[], []]
    for tick, moves in rig.steps_of(words):
        for axis in range(2):
            if moves[axis]:
                assert moves[axis] == (1, -1)[axis]
                seen[axis].append(tick)
    for ticks, each, rest, count in ((seen[0], x_each, x_rest, x), (seen[1], y_each, y_rest, y)):
        assert len(ticks) == count
        for i in range(count):
            nominal = i * each + i * rest // 7
            assert abs(ticks[i] - ticks[0] - nominal) <= LEAST_TICKS + SETUP_TICKS
    assert rig.feeder.position(rig.played) == [x, -y]


def check_independent_for_ever_and_live():
    """Endless axes go on until a stop; a new rate counts from the next step."""
    rig = Rig("unipolar half")
    axes = IndependentAxes(2, LEAST_TICKS)
    axes.run_axis(0, ENDLESS, 50_000)
    axes.run_axis(1, ENDLESS, 6_350_000)
    rig.planner.walk(axes, False)
    rig.planner.flush()
    ticks = 0
    while ticks < 3 * 6_350_000:
        ticks += total_ticks(rig.take())
    position = rig.feeder.position(rig.played)
    assert abs(position[0] - ticks // 50_000) <= 1
    assert abs(position[1] - ticks // 6_350_000) <= 1
    axes.run_axis(1, ENDLESS, 50_000, negative=True)
    later = 0
    while later < 5_000_000:
        later += total_ticks(rig.take())
    turned = rig.feeder.position(rig.played)
    assert abs(position[1] - turned[1] - later // 50_000) <= 2
    axes.run_axis(0, 0, 50_000)
    axes.run_axis(1, 0, 50_000)
    while not rig.planner.empty():
        rig.take()
        rig.feeder.retire(rig.played)
    assert not axes.active()


def check_independent_refuses_what_it_cannot_do():
    axes = IndependentAxes(1, 50)
    for steps, each, rest, over in ((-2, 1000, 0, 1), (1, 99, 0, 1), (1, 1000, 3, 3), (1, 0x1FFFFFFF, 0, 1)):
        try:
            axes.run_axis(0, steps, each, rest, over)
        except ValueError:
            continue
        raise AssertionError("accepted")
