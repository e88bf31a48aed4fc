"""Large arrays, files and streams of the start on stock MicroPython: the first who asks for a piece made beforehand gets it, once."""

import builtins
import sys
from array import array

from passo import arrays
from passo.ports.rp2.stock import pieces, streams

CASES = {
    "check_each_is_handed_over_once": (("count", 1, 300), ("other", 1, 300)),
}


def check_each_is_handed_over_once(count, other):
    made = array("i", [0] * count), array("I", [0] * count), bytearray(count)
    pieces.offer([("I", made[1]), ("i", made[0]), ("b", made[2])])
    try:
        asked = arrays.zeros, arrays.numbers, arrays.buffer
        if other != count:
            for ask in asked:
                assert len(ask(other)) == other
        for number in range(3):
            assert asked[number](count) is made[number], "of another size: it stays"
            again = asked[number](count)
            assert again is not made[number] and len(again) == count
        assert not any(arrays.zeros(count))
    finally:
        pieces.offer([])


def check_a_file_without_memory_takes_a_piece():
    """As often as files are opened and closed; while as many are open as there are pieces, there is no further one."""
    real, opened = pieces._open_file, []

    def scarce(path, mode):
        if None not in pieces._held:  # no piece has been given up
            raise MemoryError
        opened.append(path)
        return real(path, mode)

    unhooked = builtins.open
    pieces.offer([], 2)
    pieces._open_file = scarce
    try:
        for _ in range(5):
            first, second = open(__file__, "rb"), open(__file__, "rb")
            try:
                open(__file__, "rb")
                raise AssertionError("there is no third piece")
            except MemoryError:
                pass
            assert first.read(1) == second.read(1) == b'"'
            first.close()
            open(__file__, "rb").close()
            second.close()
        assert len(opened) == 15 and len(pieces._held) == 2
    finally:
        pieces._open_file = real
        builtins.open = unhooked
        pieces._held.clear()


def check_a_stream_is_held_until_the_next():
    import deflate

    real = deflate
    streams.hold()
    try:
        import deflate

        assert deflate is streams and len(streams._held) == 1
        first = streams._held[0]
        from io import BytesIO

        made = deflate.DeflateIO(BytesIO(b"\x03\x00"), deflate.RAW, 10)
        assert streams._held == [made] and made is not first
    finally:
        sys.modules["deflate"] = real
        streams._held.clear()
