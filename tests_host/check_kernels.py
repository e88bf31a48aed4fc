"""The inner loops in machine code give the same bits as their plain twins. Where there is none, nothing is compared."""

from array import array

from draws import Random
from passo.drives import coils, coils_plain
from passo.motion import line, line_plain
from passo.records import (
    FEED_AXES, FEED_BITS, FEED_HEAD, FEED_LIMIT, FEED_MASK, FEED_NEWEST, FEED_OLDEST, FEED_PLACE, FEED_SETUP,
    FEED_TICKS, MARKS, MARK_FIELDS,
)  # fmt: skip
from passo.steps import checkpoints, checkpoints_plain, pace, pace_plain, position, position_plain

CASES = {
    "check_walk": (("seed", "seed"), ("axes", 1, 4)),
    "check_pace": (("seed", "seed"), ("count", 1, 500)),
    "check_repay": (("seed", "seed"), ("count", 1, 60)),
    "check_apply": (("seed", "seed"), ("axes", 1, 2), ("width", "choice", 4, 6)),
    "check_checkpoints": (("seed", "seed"), ("axes", 1, 4)),
    "check_tally": (("seed", "seed"), ("axes", 1, 4)),
    "check_tally_of_coils": (("seed", "seed"), ("axes", 1, 2), ("width", "choice", 4, 6)),
}
LONGEST = 2_000_000


def check_walk(seed, axes):
    """Any vector, from any step on, at any place of the words."""
    random = Random(seed)
    most = (5, 400, LONGEST)[random.between(0, 2)]
    deltas = [random.between(-most, most) for _ in range(axes)]
    deltas[random.between(0, axes - 1)] = most
    lines = (line.Line(axes), line.Line(axes))
    outs = (array("I", [9] * 550), array("I", [9] * 550))
    begin = random.between(0, most - 1)
    count = random.between(1, min(500, most - begin))
    at = random.between(0, 50)
    for one, twin, out in zip(lines, (line_plain, line), outs):
        walk = twin.walk
        one.begin(deltas)
        assert twin.begin(array("i", [7] + deltas), 1, one.state) == most
        one.seek(begin)
        walk(out, at, count, one.state)
        walk(out, at, 1, one.state)
    assert outs[0] == outs[1]
    assert lines[0].state == lines[1].state


def check_pace(seed, count):
    random = Random(seed)
    bits = random.between(3, 13)
    terms = pace_plain.new_terms()
    ticks = count * random.between(25, 60_000) + random.between(0, count - 1)
    pace_plain.set_terms(terms, count, ticks, random.between(0, 3), bits)
    others = array("i", terms)
    words = array("I", [random.between(0, (1 << bits) - 1) for _ in range(count + 9)])
    same = array("I", words)
    pace_plain.pace(words, 4, count, terms)
    pace.pace(same, 4, count, others)
    assert words == same
    assert terms == others


def check_repay(seed, count):
    random = Random(seed)
    bits = random.between(3, 13)
    least = random.between(2, 50)
    words = array("I", [random.between(least, least + 9) << bits | random.between(0, 7) for _ in range(count + 9)])
    same = array("I", words)
    debt = random.between(0, 300)
    left = pace_plain.repay(words, 4, count, bits, debt, least)
    assert pace.repay(same, 4, count, bits, debt, least) == left
    assert words == same


def check_apply(seed, axes, width):
    random = Random(seed)
    last = (3, 7)[random.between(0, 1)]
    tables = bytes([random.between(0, (1 << width) - 1) for _ in range(axes * (last + 1))])
    phases = bytearray([random.between(0, last) for _ in range(axes)])
    words = array("I", [random.between(0, 0x3FFFFFFF) for _ in range(60)])
    same, others = array("I", words), bytearray(phases)
    coils_plain.apply(words, 5, 50, axes, width, last, tables, phases)
    coils.apply(same, 5, 50, axes, width, last, tables, others)
    assert words == same
    assert phases == others


def check_checkpoints(seed, axes):
    """Any sequence of segments, retirements and questions, from any count on."""
    random = Random(seed)
    sides = []
    for _ in range(2):
        state = array("i", [0] * (FEED_PLACE + axes))
        state[FEED_BITS], state[FEED_AXES], state[FEED_MASK] = 2 * axes + 1, axes, 63
        state[FEED_LIMIT], state[FEED_SETUP] = 2000, 63
        marks = array("i", [0] * (MARKS * (MARK_FIELDS + axes)))
        sides.append((state, marks, array("I", [0] * 64), array("i", [0] * axes)))
    for index in (FEED_HEAD, FEED_TICKS, FEED_OLDEST):
        sides[0][0][index] = sides[1][0][index] = random.between(0, 0x1FFFFFFF)
    for index in range(axes):
        edge = (0, 0x0FFFFFF0, -0x0FFFFFF0)[random.between(0, 2)]
        sides[0][0][FEED_PLACE + index] = sides[1][0][FEED_PLACE + index] = edge
    for side in sides:
        side[0][FEED_NEWEST] = side[0][FEED_OLDEST]
    for _ in range(200):
        moving, negative = random.between(0, (1 << axes) - 1), random.between(0, (1 << axes) - 1)
        steps, ticks = random.between(0, 255), random.between(1, 0x100000)
        made = [random.between(-200, 200) for _ in range(axes)]
        ends, lead, back = random.between(0, 1), random.between(0, 4_000_000), random.between(0, 4000)
        what = random.between(0, 5)
        results = []
        for plain, (state, marks, words, steps_made) in zip((True, False), sides):
            twin = checkpoints_plain if plain else checkpoints
            call = (twin.room, twin.begin, twin.end, twin.retire, twin.find)
            result = call[0](state, marks, lead)
            if result and what:
                for axis in range(axes):
                    steps_made[axis] = made[axis]
                call[1](state, words, moving, negative, steps, ticks)
                call[2](state, marks, steps_made, steps, ticks, ends)
            played = (state[FEED_HEAD] - back) & 0x1FFFFFFF
            place = array("i", [0] * axes)
            at = call[4](state, marks, played, place)
            results.append((result, at, list(place), call[3](state, marks, played) if what < 2 else 0))
        assert results[0] == results[1]
        assert sides[0] == sides[1]


def check_tally(seed, axes):
    """Also over the ends of the ring and of the count."""
    random = Random(seed)
    words = array("I", [random.between(0, 0x3FFFFFFF) for _ in range(1024)])
    first = random.between(0, 0x1FFFFFFF)
    until = (first + random.between(0, 1024)) & 0x1FFFFFFF
    place = array("i", [random.between(-(1 << 28), (1 << 28) - 1) for _ in range(axes)])
    same = array("i", place)
    stepping = position_plain.tally(words, 1023, first, until, axes, place)
    assert position.tally(words, 1023, first, until, axes, same) == stepping
    assert place == same


def check_tally_of_coils(seed, axes, width):
    """Motors that step at random, also over the ends of the ring, the count and the tables."""
    random = Random(seed)
    last = (3, 7)[random.between(0, 1)]
    tables = bytes([phase + 1 for phase in range(last + 1)] * axes)
    first = random.between(0, 0x1FFFFFFF)
    words = array("I", [0] * 64)
    place = array("i", [random.between(-100, 100) for _ in range(axes)])
    begun, wanted, at = array("i", place), 0, first
    for _ in range(random.between(0, 64)):
        moves = [random.between(-1, 1) for _ in range(axes)]
        wanted += 1 if [move for move in moves if move] else 0
        levels = 0
        for axis in range(axes):
            place[axis] += moves[axis]
            levels |= tables[place[axis] & last] << axis * width
        words[at & 63] = levels | 1 << axes * width
        at = (at + 1) & 0x1FFFFFFF
    for tally in (coils_plain.tally, coils.tally):
        found = array("i", begun)
        assert tally(words, 63, first, at, axes, width, last, tables, 15, found) == wanted
        assert found == place
    words[first & 63] = 15 | 15 << width  # no current: no step
    for tally in (coils_plain.tally, coils.tally):
        assert tally(words, 63, first, (first + 1) & 0x1FFFFFFF, axes, width, last, tables, 15, array("i", begun)) == 0
