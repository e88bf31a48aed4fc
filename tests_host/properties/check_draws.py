"""The generator of the checks keeps its own promises, and gives the same values on every interpreter."""

from draws import Random, draw

CASES = {
    "check_between": (("low", -1000000, 1000000), ("width", 0, 1000000), ("seed", "seed")),
    "check_specifications": (
        ("seed", "seed"),
        ("data", "bytes", 9),
        ("word", "choice", "half", "full"),
        ("moves", "list", 5, ("dx", -3, 3), ("dy", 0, 7)),
        ("waits", "list", 4, ("ms", 1, 2)),
    ),
}
RUNS = {"check_between": 50}


def check_between(low, width, seed):
    random = Random(seed)
    for _ in range(20):
        assert low <= random.between(low, low + width) <= low + width


def check_specifications(seed, data, word, moves, waits):
    assert 0 <= seed < 1 << 30
    assert type(data) is bytes and len(data) <= 9
    assert word in ("half", "full")
    assert len(moves) <= 5
    for dx, dy in moves:
        assert -3 <= dx <= 3 and 0 <= dy <= 7
    assert len(waits) <= 4
    for ms in waits:
        assert ms in (1, 2)


def check_same_everywhere():
    random = Random(2014)
    assert [random.between(-100, 100) for _ in range(6)] == [-38, 63, 81, 53, 47, -78]
    assert random.bytes(4) == b'\xbc\xffr\x96'


def check_every_spec_reaches_its_ends():
    random = Random(1)
    seen = set([draw(random, ("dx", -65535, 65535)) for _ in range(400)])
    for value in (-65535, 65535, 0):
        assert value in seen
