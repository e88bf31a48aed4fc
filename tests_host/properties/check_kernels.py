"""The inner loops in machine code give the same bits as the same text compiled as ordinary Python. Without machine code there is no comparison."""

from array import array

from check_line import seek
from draws import Random
from passo.options.coil_drives import drive_viper as coils_viper
from passo.motion import line, line_viper, speed_viper
from passo.records import (
    KIND_WAIT, PACE_CARRY, PACE_OVER, PACE_REST, PACE_SHORT, PACE_TICK, ROW_GAIN, ROW_KIND, ROW_SPEED, ROW_STEPS, ROW_TAG, ROW_TOP,
    SEEN_FASTEST, SEEN_FIELDS, SEEN_LINE, SEEN_MM_S, SEEN_NM_S, SEEN_PACE, SEEN_ROW, SEEN_SHIFT,
)  # fmt: skip
from passo.steps import pace_viper, position_viper
from plain import plain

CASES = {
    "check_walk": (("seed", "seed"), ("axes", 1, 4)),
    "check_pace": (("seed", "seed"), ("count", 1, 500)),
    "check_repay": (("seed", "seed"), ("count", 1, 60)),
    "check_apply": (("seed", "seed"), ("axes", 1, 2), ("width", "choice", 4, 6)),
    "check_tally": (("seed", "seed"), ("axes", 1, 4)),
    "check_along": (("seed", "seed"),),
    "check_tally_of_coils": (("seed", "seed"), ("axes", 1, 2), ("width", "choice", 4, 6)),
}
LONGEST = 2_000_000
PLAIN_LINE, PLAIN_PACE, PLAIN_POSITION, PLAIN_COILS = map(plain, (line_viper, pace_viper, position_viper, coils_viper))


def terms_of(steps, ticks, base, bits):
    """PACE_… of a segment of `steps` that last `ticks`, `base` being ORed to their levels."""
    terms = array("i", [0] * (PACE_CARRY + 1))
    terms[PACE_SHORT] = ticks // steps << bits | base
    terms[PACE_TICK] = 1 << bits
    terms[PACE_REST] = ticks % steps
    terms[PACE_OVER] = steps
    terms[PACE_CARRY] = 0
    return terms


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
    for one, twin, out in zip(lines, (PLAIN_LINE, {"begin": line_viper.begin, "walk": line_viper.walk}), outs):
        walk = twin["walk"]
        one.begin(deltas)
        assert twin["begin"](array("i", [7] + deltas), 1, one.state) == most
        seek(one, begin)
        walk(out, at, count, one.state)
        walk(out, at, 1, one.state)
    assert outs[0] == outs[1]
    assert lines[0].state == lines[1].state


def check_pace(seed, count):
    random = Random(seed)
    bits = random.between(3, 13)
    ticks = count * random.between(25, 60_000) + random.between(0, count - 1)
    terms = terms_of(count, ticks, random.between(0, 3), bits)
    others = array("i", terms)
    words = array("I", [random.between(0, (1 << bits) - 1) for _ in range(count + 9)])
    same = array("I", words)
    PLAIN_PACE["pace"](words, 4, count, terms)
    pace_viper.pace(same, 4, count, others)
    assert words == same
    assert terms == others


def check_repay(seed, count):
    random = Random(seed)
    bits = random.between(3, 13)
    least = random.between(2, 50)
    words = array("I", [random.between(least, least + 9) << bits | random.between(0, 7) for _ in range(count + 9)])
    same = array("I", words)
    debt = random.between(0, 300)
    left = PLAIN_PACE["repay"](words, 4, count, bits, debt, least)
    assert pace_viper.repay(same, 4, count, bits, debt, least) == left
    assert words == same


def check_apply(seed, axes, width):
    random = Random(seed)
    last = (3, 7)[random.between(0, 1)]
    tables = bytes([random.between(0, (1 << width) - 1) for _ in range(axes * (last + 1))])
    phases = bytearray([random.between(0, last) for _ in range(axes)])
    words = array("I", [random.between(0, 0x3FFFFFFF) for _ in range(60)])
    same, others = array("I", words), bytearray(phases)
    PLAIN_COILS["apply"](words, 5, 50, axes, width, last, tables, phases)
    coils_viper.apply(same, 5, 50, axes, width, last, tables, others)
    assert words == same
    assert phases == others


def check_tally(seed, axes):
    """Also over the ends of the ring and of the count."""
    random = Random(seed)
    words = array("I", [random.between(0, 0x3FFFFFFF) for _ in range(1024)])
    first = random.between(0, 0x1FFFFFFF)
    until = (first + random.between(0, 1024)) & 0x1FFFFFFF
    place = array("i", [random.between(-(1 << 28), (1 << 28) - 1) for _ in range(axes)])
    same = array("i", place)
    stepping = PLAIN_POSITION["tally"](words, 1023, first, until, axes, place)
    assert position_viper.tally(words, 1023, first, until, axes, same) == stepping
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
    for tally in (PLAIN_COILS["tally"], coils_viper.tally):
        found = array("i", begun)
        assert tally(words, 63, first, at, axes, width, last, tables, 15, found) == wanted
        assert found == place
    words[first & 63] = 15 | 15 << width  # no current: no step
    for tally in (PLAIN_COILS["tally"], coils_viper.tally):
        assert tally(words, 63, first, (first + 1) & 0x1FFFFFFF, axes, width, last, tables, 15, array("i", begun)) == 0


def check_along(seed):
    """The speed that a status report tells, as large integers have it."""
    random = Random(seed)
    rows = array("i", [0] * (2 * ROW_STEPS))
    at = random.between(0, ROW_STEPS)
    top = random.between(64, 16_000)
    part = random.between(1, 1 << random.between(1, 28))
    whole = random.between(1, (1 << random.between(1, 30)) - 1)
    pace = random.between(1, top)
    gain = random.between(0, 1)
    rows[at + ROW_SPEED], rows[at + ROW_TOP], rows[at + ROW_GAIN] = part, top, gain
    asked = part * whole >> 28
    speed = asked // top * pace + asked % top * pace // top if gain else asked
    assert speed_viper.along(rows, at, pace, whole) == speed
    seen = array("i", [7] * SEEN_FIELDS)
    seen[SEEN_ROW], seen[SEEN_PACE] = at, pace
    rows[at + ROW_TAG] = 5
    for fastest, shift, line, told in ((whole, 0, 5, speed), (0, 0, 5, 0), (whole, random.between(1, 6), 5, speed)):
        seen[SEEN_FASTEST], seen[SEEN_SHIFT] = fastest, shift
        speed_viper.progress(rows, seen)
        assert (seen[SEEN_LINE], 1_000_000 * seen[SEEN_MM_S] + seen[SEEN_NM_S]) == (line, told << shift)
    rows[at + ROW_KIND] = KIND_WAIT
    speed_viper.progress(rows, seen)
    assert not seen[SEEN_LINE] and not seen[SEEN_MM_S] and not seen[SEEN_NM_S]
