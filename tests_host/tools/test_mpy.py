"""Compiled modules whose functions are moved so that they can run from flash: nothing else is changed."""

import struct
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host_tools.build import mpy, tree

MICROPYTHON = Path(sys.executable).parent / "micropython"


@pytest.fixture(scope="module")
def modules(tmp_path_factory):
    """{path: bytes} of two boards' modules as mpy-cross compiles them."""
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tree, "IN_PLACE", "")
        for board in ("router_3axis", "torch_manipulator"):
            out = tmp_path_factory.mktemp(board)
            tree.build_tree(board, out)
            found |= {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*.mpy")}
    return found


def blocks_of(function, size):
    """The blocks of littlefs in which the code of a function lies."""
    starts, _ = mpy.block_starts(size)
    last = function.offset + function.length - 1
    return {number for number, (a, b) in enumerate(zip(starts, starts[1:])) if a <= last and function.offset < b}


def test_every_byte_of_a_module_is_accounted_for(modules):
    for path, data in modules.items():
        found = mpy.functions_of(data)
        assert found.end == len(data), path


def known_of(placed):
    """Return the parts of a module's end: (head, names, first, functions as tuples, texts as tuples, the call)."""
    *numbers, mark = struct.unpack("<HHBBHHH", placed[-12:])
    assert mark == mpy.MARK
    head, names, first, call, functions, texts = numbers
    at = len(placed) - 12 - call - 10 * functions - 4 * texts
    rows = list(struct.iter_unpack("<HHHBBBB", placed[at : at + 10 * functions]))
    at += 10 * functions
    return head, names, first, rows, list(struct.iter_unpack("<HBB", placed[at : at + 4 * texts])), placed[len(placed) - 12 - call : -12]


def bytes_at(placed, block, place, length):
    """As they lie in flash: in a block, behind its pointers; of block 255 in the file."""
    starts, pointers = mpy.block_starts(len(placed))
    at = place if block == 255 else starts[block] + place - pointers[block]
    assert block == 255 or pointers[block] <= place and place + length <= mpy.BLOCK_BYTES
    return placed[at : at + length]


def tables(data):
    """(how many objects a module has, whether the objects' place is in the piece of its names, two bytes each in whole words)"""
    reader = mpy._Reader(data)
    reader.at = 4
    names, objects = reader.read_number(), reader.read_number()
    return objects, objects > 0 or -(-names // 2) * 4 % 16 > 0


def test_no_module_points_behind_its_tables(modules):
    """If objects began behind names that fill a piece of the heap, the pointer would keep another piece, which the collector would never free."""
    met = 0
    for path, data in modules.items():
        placed = mpy.in_place(data)
        assert tables(placed)[1], path
        mpy.functions_of(placed)
        met += tables(placed)[0] == 1 and tables(data)[0] == 0
    assert met > 3


@pytest.mark.parametrize("native", [False, True])
def test_functions_are_the_same_and_lie_in_one_block(modules, native):
    moved = copied = 0
    for path, data in modules.items():
        placed = mpy.in_place(data, native)
        before, after = mpy.functions_of(data).functions, mpy.functions_of(placed).functions
        code = [data[f.offset : f.offset + f.length] for f in before]
        assert code == [placed[f.offset : f.offset + f.length] for f in after], path
        head, _, _, rows, *_ = known_of(placed)
        if not head:
            same = placed[:-12] == data or len(placed) - 12 == len(data) + 1 and tables(data) == (0, False) and tables(placed) == (1, True)
            assert not rows and same and (path.startswith("passo/kernels_") or len(data) <= 512)
            continue
        assert placed[head : head + 2] and after[0].begin >= head and len(rows) == len(after)
        for f, g, (place, length, prelude, block, kind, children, generator) in zip(before, after, rows):
            assert bytes_at(placed, block, place, length) == code[before.index(f)]
            assert (kind, children, prelude, generator) == (g.kind, f.children, f.prelude, f.generator)
            moved += g.offset - f.offset > 0
            copied += block == 255
            assert block != 255 or length > mpy.BLOCK_BYTES - 32 or kind != mpy.BYTECODE and not native
            assert kind == mpy.BYTECODE or block == 255 or place % 4 == 0
    assert moved and (copied or native)


def test_texts_are_where_they_are_said_to_be(modules):
    """Each with the zero that ends it; and the names of a head, one more than the module has."""
    count = 0
    for path, data in modules.items():
        placed = mpy.in_place(data)
        head, names, first, _, texts, call = known_of(placed)
        if not head:
            continue
        found = mpy.functions_of(data)
        known = {number: data[found.names + at : found.names + at + length + 1] for number, at, length in found.texts}
        for place, block, number in texts:
            text = known[number]
            assert text.endswith(b"\0") and bytes_at(placed, block, place, len(text)) == text, path
        count += len(texts)
        assert placed[:head].count(b"\x0a_load\0") == 1 + data.count(b"\x0a_load\0") and call[0] >> 3 == len(call) - 1
        reader = mpy._Reader(placed)
        reader.at = first
        for _ in range(names):
            reader.skip_name()
        assert not names or placed[: reader.at].endswith(b"\x0a_load\0"), path
    assert count > 100


def test_small_modules_get_a_block_of_their_own(modules):
    for path, data in modules.items():
        placed, found = mpy.in_place(data), mpy.functions_of(data).functions[1:]
        assert len(placed) > mpy.INLINE_BYTES or sum(each.length for each in found) < 100 or not known_of(placed)[0], path


@given(st.integers(0, 40_000), st.integers(1, 4084), st.booleans())
def test_padding(offset, length, native):
    for kind in (mpy.BYTECODE, mpy.VIPER):
        function = mpy.Function(0, offset, length, kind)
        moved = mpy.padding_before(function, offset, native)
        function.offset = offset + moved
        assert 0 <= moved < mpy.BLOCK_BYTES + 4
        assert len(blocks_of(function, 60_000)) == 1 or length > 4072
        assert kind == mpy.BYTECODE or not native or function.offset % 4 == 0


@pytest.mark.parametrize("size", [1, 512, 4096, 4097, 8188, 8189, 12276, 12277, 16368, 16369, 40_000])
def test_blocks_of_a_file_are_where_littlefs_puts_them(size):
    """Against a littlefs image: the bytes that the offsets say stand in the block that the list of pointers leads to."""
    from host_tools.emulator.filesystem import BLOCK_BYTES, make_image

    data = bytes((7 * i + (i >> 8)) & 0xFF for i in range(size))
    image = make_image({"file": data})
    starts, pointers = mpy.block_starts(size)
    block = None
    for number in range(len(starts) - 2, -1, -1):
        piece = data[starts[number] : starts[number + 1]]
        if block is None:
            if size <= mpy.INLINE_BYTES:
                return
            places = [at for at in range(0, len(image), BLOCK_BYTES) if image[at + pointers[number] :].startswith(piece)]
            assert len(places) == 1
            block = places[0]
        assert image[block + pointers[number] : block + pointers[number] + len(piece)] == piece
        block = int.from_bytes(image[block : block + 4], "little") * BLOCK_BYTES


PROGRAM = """
def outer(n):
    def inner(k):
        return [i * k for i in range(n)]
    return inner(3)
class Thing:
    value = 41
    def more(self, by=1):
        return self.value + by
print(outer(4), Thing().more(), (1, b"x", "text", 2.5, None), (lambda: 9)())
"""


@pytest.mark.skipif(not MICROPYTHON.exists(), reason="no MicroPython for a PC")
def test_the_interpreter_reads_what_was_moved(tmp_path):
    source = tmp_path / "source.py"
    for size in (1, 60, 250):  # more functions than fit into a block
        more = "".join(f"def f{i}(a, b=2):\n    return a * {i} + b, (a, '{i}'), [x for x in (a, b)]\n" for i in range(size))
        source.write_text(more + PROGRAM)
        tree.compile_module(source, tmp_path / "thing.mpy", "x64", "thing.py")
        said = [subprocess.run([MICROPYTHON, "-c", "import thing"], cwd=tmp_path, capture_output=True, text=True)]
        data = (tmp_path / "thing.mpy").read_bytes()
        placed = mpy.in_place(data)
        assert placed[: len(data)] != data or size == 1
        (tmp_path / "thing.mpy").write_bytes(placed)
        said.append(subprocess.run([MICROPYTHON, "-c", "import thing"], cwd=tmp_path, capture_output=True, text=True))
        assert said[0].stdout == said[1].stdout == "[0, 3, 6, 9] 42 (1, b'x', 'text', 2.5, None) 9\n", said[1].stderr


@pytest.mark.parametrize("data", [b"", b"M", b"M\x05\0\x1f", b"print(1)\n"])
def test_what_is_no_module_is_refused(data):
    with pytest.raises(ValueError):
        mpy.in_place(data)


def test_only_the_rp2040_gets_them(tmp_path):
    for board, with_table in (("plotter_2014", True), ("plotter_esp32", False)):
        tree.build_tree(board, tmp_path / board)
        data = (tmp_path / board / "passo" / "app.mpy").read_bytes()
        assert (int.from_bytes(data[-2:], "little") == mpy.MARK) == with_table
