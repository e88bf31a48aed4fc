"""The inner loops in machine code give the same bits as their plain twins. Where there is no machine code, nothing is compared."""

from array import array

from draws import Random
from passo.drives import coils
from passo.motion import line
from passo.steps import pace, position

CASES = {
    "check_walk": (("seed", "seed"), ("axes", 1, 4)),
    "check_pace": (("seed", "seed"), ("count", 1, 500)),
    "check_repay": (("seed", "seed"), ("count", 1, 60)),
    "check_apply": (("seed", "seed"), ("axes", 1, 2), ("width", "choice", 4, 6)),
    "check_advance": (("seed", "seed"), ("axes", 1, 4)),
    "check_tally": (("seed", "seed"), ("axes", 1, 4)),
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
    for one, walk, out in zip(lines, (line.walk_plain, line.walk), outs):
        one.begin(deltas)
        one.seek(begin)
        walk(out, at, count, one._state)
        walk(out, at, 1, one._state)
    assert outs[0] == outs[1]
    assert lines[0]._state == lines[1]._state


def check_pace(seed, count):
    random = Random(seed)
    bits = random.between(3, 13)
    terms = pace.new_terms()
    pace.set_terms(terms, count, count * random.between(25, 60_000) + random.between(0, count - 1), random.between(0, 3), bits)
    others = array("i", terms)
    words = array("I", [random.between(0, (1 << bits) - 1) for _ in range(count + 9)])
    same = array("I", words)
    pace.pace_plain(words, 4, count, terms)
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
    left = pace.repay_plain(words, 4, count, bits, debt, least)
    assert pace.repay(same, 4, count, bits, debt, least) == left
    assert words == same


def check_apply(seed, axes, width):
    random = Random(seed)
    last = (3, 7)[random.between(0, 1)]
    tables = bytes([random.between(0, (1 << width) - 1) for _ in range(axes * (last + 1))])
    phases = bytearray([random.between(0, last) for _ in range(axes)])
    words = array("I", [random.between(0, 0x3FFFFFFF) for _ in range(60)])
    same, others = array("I", words), bytearray(phases)
    coils.apply_plain(words, 5, 50, axes, width, last, tables, phases)
    coils.apply(same, 5, 50, axes, width, last, tables, others)
    assert words == same
    assert phases == others


def check_advance(seed, axes):
    """Also over the end of the range, where positions wrap."""
    random = Random(seed)
    ends = (0, 0x0FFFFFF0, -0x0FFFFFF0)
    place = array("i", [ends[random.between(0, 2)] + random.between(-15, 15) for _ in range(axes)])
    made = array("i", [random.between(-500, 500) for _ in range(axes)])
    marks = array("i", [7] * 20)
    same = (array("i", place), array("i", made), array("i", marks))
    position.advance_plain(place, made, marks, 3, axes)
    position.advance(same[0], same[1], same[2], 3, axes)
    assert (place, made, marks) == same
    assert list(made) == [0] * axes


def check_tally(seed, axes):
    """Also over the ends of the ring and of the count."""
    random = Random(seed)
    words = array("I", [random.between(0, 0x3FFFFFFF) for _ in range(64)])
    first = random.between(0, 0x1FFFFFFF)
    until = (first + random.between(0, 64)) & 0x1FFFFFFF
    place = array("i", [random.between(-(1 << 28), (1 << 28) - 1) for _ in range(axes)])
    same = array("i", place)
    stepping = position.tally_plain(words, 63, first, until, axes, place)
    assert position.tally(words, 63, first, until, axes, same) == stepping
    assert place == same
