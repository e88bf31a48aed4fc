"""Large arrays made beforehand: the first caller that asks for one gets it, once."""

from array import array

from passo import memory

CASES = {
    "check_each_is_handed_over_once": (("count", 1, 300), ("other", 1, 300)),
}


def check_each_is_handed_over_once(count, other):
    made = array("i", [0] * count), array("I", [0] * count)
    kept = [("I", made[1]), ("i", made[0])]
    memory.keep(kept)
    try:
        asked = memory.zeros, memory.numbers
        if other != count:
            for number in range(2):
                assert len(asked[number](other)) == other
            assert len([piece for piece in kept if piece]) == 2, "of another size: it stays"
        for number in range(2):
            assert asked[number](count) is made[number]
            again = asked[number](count)
            assert again is not made[number] and len(again) == count
        assert not any(memory.zeros(count)) and not any(kept)
    finally:
        memory.keep([])


def check_what_a_stored_job_is_read_through_is_handed_over():
    stream, first, second = memory.empty_stream(0), bytearray(memory.FILE_BYTES), bytearray(memory.FILE_BYTES)
    memory.keep([("d", stream), ("b", first), ("b", second)])
    try:
        assert memory.stream() is stream and memory.stream() is not stream
        rooms = [memory.FileRoom() for _ in range(3)]
        for room in rooms:
            assert room._kept is None
            room.keep()
        assert rooms[0]._kept is first and rooms[1]._kept is second and rooms[2]._kept is not None
        for room in rooms:
            room.open(__file__, "rb").close()
            assert room._kept is None
            room.keep()
            assert len(room._kept) == memory.FILE_BYTES
    finally:
        memory.keep([])
