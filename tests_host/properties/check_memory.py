"""Large arrays made beforehand: who asks for one gets it, once; others are given back only if memory is short."""

from array import array

from passo import memory

CASES = {
    "check_each_is_handed_over_once": (("count", 1, 300), ("other", 1, 300)),
    "check_short_of_memory_what_is_kept_is_given_back": (("count", 1, 300), ("lacking", 0, 5)),
}


def check_each_is_handed_over_once(count, other):
    made = array("i", [0] * count), array("I", [0] * count)
    kept = [[None] * 9, ("I", made[1]), ("i", made[0])]
    memory.keep(kept)
    try:
        asked = memory.zeros, memory.numbers
        if other != count:
            for number in range(2):
                assert len(asked[number](other)) == other
            assert len([piece for piece in kept if piece]) == 3, "of another size: it stays"
        for number in range(2):
            assert asked[number](count) is made[number]
            again = asked[number](count)
            assert again is not made[number] and len(again) == count
        assert not any(memory.zeros(count)) and len(kept[0]) == 9
    finally:
        memory.keep([])


def check_short_of_memory_what_is_kept_is_given_back(count, lacking):
    """An array finds room when `lacking` pieces have been given back, the last first; with all of them gone it raises."""
    work, room = [None] * 9, [None] * 9
    kept = [work, ("I", array("I", [0] * 500)), ("i", array("i", [0] * 500)), room]
    calls = []
    real = memory._zeros

    def short(count):
        calls.append(count)
        if len(calls) <= lacking:
            raise MemoryError
        return real(count)

    memory._zeros = short
    memory.keep(kept)
    try:
        assert len(memory.zeros(count)) == count and lacking <= 4
        left = [bool(piece) for piece in kept]
        assert left == [place < 4 - lacking for place in range(4)]
    except MemoryError:
        assert lacking == 5 and not any(kept)
    finally:
        memory._zeros = real
        memory.keep([])
    assert bool(room) == (lacking == 0) and bool(work) == (lacking < 4), "lists are emptied, for whoever else points to them"


def check_what_a_stored_job_is_read_through_is_handed_over():
    stream, first, second = memory.spent(0), bytearray(memory.FILE_BYTES), bytearray(memory.FILE_BYTES)
    memory.keep([[None] * 9, ("d", stream), ("b", first), ("b", second)])
    try:
        assert memory.stream() is stream and memory.stream() is not stream
        rooms = [memory.FileRoom() for _ in range(3)]
        for room in rooms:
            assert room._kept is None
            room.keep()
        assert rooms[0]._kept is first and rooms[1]._kept is second and rooms[2]._kept is not None
        for room in rooms:
            room.give()
            assert room._kept is None
            room.keep()
            assert len(room._kept) == memory.FILE_BYTES
    finally:
        memory.keep([])
