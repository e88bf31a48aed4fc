"""Code in flash on the emulated Pico: how much memory it leaves, and that whatever is not as expected stays in RAM."""

import tempfile
from pathlib import Path

import pytest
from emulated import READY, RUN, uf2  # noqa: F401

from host_tools import boards
from host_tools.build import mpy, tree
from host_tools.emulator import binary
from host_tools.emulator.filesystem import folder_files
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine, firmware_files, files_of
from host_tools.emulator.pico import EmulatedPico

FIRST_ANSWER_MS = 2300  # of the first start, which erases the journal's blocks; later ones take 0.3 s less
LIMIT_MS = 12_000  # a mill with everything on takes 9 s, the first time
LARGEST = 16_000
PLOTTER = b"r\0\0\0\0r", b"k"
VERSIONS = sorted((binary.CACHE / "versions").glob("RPI_PICO-*.uf2"))  # others are tested if they are there

# The start of main.py without the app: `code` redirects what is imported while it is there.
BEGIN = """
import gc, sys
from passo.ports.rp2.stock import flash_code
flash_code.begin()
code = flash_code.code
"""


class Started:
    """A machine that has answered; `said` is what it printed, `heap` as it was when its main loop began."""

    def __init__(self, board, files=None, uf2=None):
        files = dict(files or firmware_files(board))
        main = files["main.py"]
        files["main.py"] = main.replace(RUN, READY + RUN)
        assert files["main.py"] != main
        self.machine = machine = EmulatedMachine(board, files, uf2=uf2).boot()
        console = machine.pico.console
        machine.run_until(lambda: b"ready" in console.text or b">>> " in console.text, LIMIT_MS, 200)
        self.said = bytes(console.take_output()).decode()
        self.heap = Heap(machine.pico)
        link = next(iter(machine.uart_links()), None)  # None: USB
        question, answer = PLOTTER if board == "plotter_2014" else (b"?", b"<")
        while answer not in machine.take(link):
            assert machine.now_ms() < LIMIT_MS, self.said + bytes(console.text).decode()
            machine.send(question, link)
            machine.run_ms(10)
        self.answered_ms = machine.now_ms()
        console.send(b"\r")
        machine.run_ms(20)
        self.said += bytes(console.take_output()).decode()


@pytest.mark.parametrize("board, free", [("router_3axis", 70_000), ("plotter_2014", 119_000)])
def test_room_and_time(uf2, board, free, show):
    started = Started(board, uf2=uf2)
    assert "code in flash: " in started.said and "build %s" % firmware_files(board)["stamp.txt"].decode().strip() in started.said
    assert started.heap.free >= free and started.heap.largest >= LARGEST
    assert started.answered_ms <= FIRST_ANSWER_MS
    if board == "router_3axis":
        link = started.machine.uart_links()[0]
        started.machine.send(b"$I\n", link)
        started.machine.run_ms(100)
        assert b"]\r\n[MSG:code in flash: " in started.machine.take(link)
    show(
        f"{board} with its code in flash",
        f"{started.heap.free} bytes free, {started.heap.largest} in one piece, first answer after {started.answered_ms:.0f} ms",
    )


SAFE_US = 200_000


def safe_us(machine, board):
    """Microseconds from power on until every output that a board file names is driven; it must be inactive then."""
    entries = [*board["outputs"], board["tool"], board["spindle"]]
    levels = {entry["pin"]: 1 - entry.get("active", 1) for entry in entries if entry and "pin" in entry}
    pico, mask = machine.pico, sum(1 << pin for pin in levels)
    pico.run_until(lambda: pico.chip.sio.gpio_output_enable & mask == mask, 4 * SAFE_US, 500)
    assert pico.chip.sio.gpio_value & mask == sum(level << pin for pin, level in levels.items())
    return pico.now_us


def test_outputs_are_safe_before_the_firmware_is_loaded(uf2, show):
    took_us = safe_us(EmulatedMachine("router_3axis", firmware_files("router_3axis"), trace=None, uf2=uf2), boards.load("router_3axis"))
    show("safe outputs", f"{took_us / 1000:.0f} ms after power")
    assert took_us <= SAFE_US


@pytest.mark.parametrize("version", VERSIONS, ids=lambda path: path.stem)
def test_other_interpreters(version):
    started = Started("plotter_2014", uf2=version)
    assert "code in flash: " in started.said and started.heap.largest >= LARGEST


@pytest.mark.parametrize("torn", ["stamp.txt", "passo/stamp.txt", "of another build"])
def test_a_torn_or_mixed_build_is_not_run(torn, uf2):
    """The torn build would start: instead the board says what is wrong, touches no pin, and the prompt comes."""
    files = dict(firmware_files("plotter_2014"))
    if torn in files:
        del files[torn]
    else:
        files["stamp.txt"] = b"0123456789ab\n"
    machine = EmulatedMachine("plotter_2014", files, uf2=uf2).boot()
    console = machine.pico.console
    machine.run_until(lambda: b">>> " in console.text, LIMIT_MS)
    said = bytes(console.take_output()).decode()
    assert "the firmware here is not whole" in said and "Traceback" not in said
    assert not machine.wiring.edge_count


EVERYTHING = {"journal": {"every_ms": 500}, "jobs": {"language": "grbl"}}


@pytest.mark.parametrize("board", [pytest.param(name, marks=pytest.mark.slow) for name in ("router_3axis", "laser_xy")] + ["mill_2004"])
def test_with_journal_jobs_and_frames_it_starts(board, uf2, show):
    """The options that take most memory: stored jobs, their journal, and frames on every link."""
    board = boards.load(board)
    board.update(EVERYTHING, links=[dict(link, frames=True) for link in board["links"]])
    started = Started(board, files_of(board), uf2)
    assert "code in flash: " in started.said and started.heap.free >= 12_000
    show(f"{board['name']} with everything", f"{started.heap.free} bytes free, {started.heap.largest} in one piece")


def rebuilt(board, module, old, new):
    """The firmware's files, one module of which was compiled with another number. A build renames, but keeps lines."""
    compiled = tree._module_bytes
    lines = (tree.FIRMWARE / module).read_text(encoding="utf-8").splitlines()
    (number,) = [number for number, line in enumerate(lines) if line.startswith(old)]
    before, after = old.partition(" = ")[2], new.partition(" = ")[2]

    def changed(text, march, path):
        if path != Path(module).with_suffix(".mpy"):
            return compiled(text, march, path)
        changing = text.splitlines(keepends=True)
        assert changing[number].count(f" = {before}") == 1
        changing[number] = changing[number].replace(before, after)
        return compiled("".join(changing), march, path)

    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(tree, "_module_bytes", changed)
        tree.build_tree(board, Path(folder))
        return folder_files(folder)


def test_the_flash_of_a_pico_w(show):
    """Its file system lies elsewhere and is smaller; its heap, too: a router does not fit."""
    found = sorted((binary.CACHE / "versions").glob("RPI_PICO_W-*.uf2"))
    if not found:
        pytest.skip("NOT TESTED: no MicroPython UF2 for the Pico W")
    started = Started("plotter_2014", uf2=found[-1])
    assert "code in flash: " in started.said and started.heap.largest >= LARGEST
    show("plotter_2014 on a Pico W", f"{started.heap.free} bytes free, {started.heap.largest} in one piece")


LOADER = "passo/ports/rp2/stock/flash_code.py"
LAYOUTS = [
    ("_CODE = const(12)", "_CODE = const(8)"),
    ("_CODE = const(12)", "_CODE = const(16)"),
    ("_MODULE = const(4)", "_MODULE = const(8)"),
    ("_CHILDREN = const(8)", "_CHILDREN = const(4)"),
    ("_KIND_SHIFT = const(16)", "_KIND_SHIFT = const(8)"),
    ("_NUMBERS = const(8)", "_NUMBERS = const(12)"),
    ("_DATA = const(12)", "_DATA = const(8)"),
    ("_LENGTH = const(8)", "_LENGTH = const(4)"),
    ("_CONSTANTS = const(12)", "_CONSTANTS = const(4)"),
]


@pytest.mark.parametrize("old, new", [pytest.param(*each, marks=pytest.mark.slow if number % 3 else ()) for number, each in enumerate(LAYOUTS)])
def test_another_layout_leaves_all_in_ram(uf2, old, new):
    files = rebuilt("plotter_2014", LOADER, old, new)
    started = Started("plotter_2014", files, uf2=uf2)
    assert "code in RAM: " in started.said, started.said
    assert "Traceback" not in started.said


def test_a_router_whose_code_stays_in_ram_says_so(uf2):
    """It may be too large then: no machine, the REPL, and the reason."""
    machine = EmulatedMachine("router_3axis", rebuilt("router_3axis", LOADER, *LAYOUTS[0]), uf2=uf2).boot()
    text = machine.pico.console.text
    machine.run_until(lambda: b"code in RAM: unknown layout of functions" in text, LIMIT_MS)
    machine.run_ms(200)
    assert b"Traceback" not in text or b"MemoryError" in text and b">>> " in text


@pytest.fixture
def pico(uf2):
    files = {path: data for path, data in firmware_files("plotter_2014").items() if path != "main.py"}
    return EmulatedPico(files=files, uf2=uf2).boot()


# A module's functions are in flash if their code is; told from here, by the interpreter's own structures.
WHERE = """
from machine import mem32
def in_flash(function):
    return mem32[id(function) + 12] >> 28 == 1
"""


def test_functions_run_from_flash(pico):
    pico.exec(BEGIN + WHERE)
    assert pico.exec("print(repr(code.why))") == "''\r\n"
    pico.exec("from passo.motion import cordic, line\ncode.finish()")
    methods = "[each for each in [getattr(line.Steady, name) for name in dir(line.Steady)] if type(each) is type(in_flash)]"
    assert eval(pico.exec(f"print([in_flash(each) for each in {methods}])")) and pico.exec("print(in_flash(in_flash))") == "False\r\n"
    assert "False" not in pico.exec(f"print([in_flash(each) for each in {FUNCTIONS}])")
    assert "code in flash" in pico.exec("print(code.text())")
    pico.soft_reset()
    pico.console.expect(b">>> ")
    assert pico.exec("from passo.motion import cordic\nprint(in_flash(cordic.vector) if 'in_flash' in globals() else 1)") == "1\r\n"


# Everything that mpy-cross can make: functions in functions, generators, classes, defaults, closures, constants, machine code.
EVERYTHING_MADE = """
import micropython
def count(n):
    total = 0
    for i in range(n):
        total += i
        yield total
def outer(n, by=2):
    def inner(k):
        return [(i * k, n) for i in range(by)]
    return inner
class Thing:
    "A docstring that is longer than a name may be, and stays a text."
    text = "Ωne text with bytes of several lengths, too long for a name"
    def more(self, *rest, by=1, **named):
        return by + sum(rest) + sum(named.values()), b"bytes of a length that no name has \\0\\1", 1.5, 1 << 40
@micropython.native
def native(a, b=3):
    return a * b, [x for x in (a, b)]
@micropython.native
def native_count(n):
    while n:
        yield n
        n -= 1
@micropython.viper
def viper(a: int) -> int:
    return a * 3
LONG = "a text", ("in a tuple, which is longer than names are", 7), None
def long(a):
"""
EXPECTED = (
    "[0, 1, 3, 6] [(0, 3), (5, 3)] (16, b'bytes of a length that no name has \\x00\\x01', 1.5, 1099511627776) "
    "(12, [4, 3]) [3, 2, 1] 15 8198 True 59\r\n"
)


@pytest.mark.parametrize("native", [False, True])
def test_whatever_is_made_runs_as_the_interpreter_has_it(pico, native):
    """Loaded by the interpreter and from flash: the same answers, also after collections; a function too long for a block is copied."""
    source = EVERYTHING_MADE + "".join(f"    a += {i} - {i - 1}\n" for i in range(1, 1025)) + "    return a\n" * 1
    with tempfile.TemporaryDirectory() as folder:
        path, target = Path(folder) / "source.py", Path(folder) / "made.mpy"
        path.write_text(source, encoding="utf-8")
        tree.compile_module(path, target, "armv6m", "made.mpy")
        data = mpy.in_place(target.read_bytes(), native)
    asked = (
        "print(list(made.count(4)), made.outer(3)(5), made.Thing().more(1, 2, by=3, x=10), made.native(4), list(made.native_count(3)), "
        "made.viper(5), made.long(7174), made.LONG == ('a text', ('in a tuple, which is longer than names are', 7), None), "
        "len(made.Thing.text))"
    )
    pico.exec(f"with open('passo/made.mpy', 'wb') as file:\n    _ = file.write({data!r})")
    assert pico.exec("from passo import made\n" + asked) == EXPECTED
    pico.soft_reset()
    pico.console.expect(b">>> ")
    pico.exec(BEGIN + WHERE + "from passo import made\n")
    assert pico.exec("print(in_flash(made.outer), in_flash(made.long), in_flash(made.native), in_flash(made.viper))") == (
        f"True False {native} {native}\r\n"
    )
    for _ in range(3):
        assert pico.exec("gc.collect()\njunk = [bytearray(50) for j in range(400)]\n" + asked) == EXPECTED
    pico.exec("code.finish()\nsums = made.count(50)\nhead = [next(sums) for i in range(3)]")
    said = pico.exec(
        "for i in range(40):\n    gc.collect()\n    junk = [bytearray(50) for j in range(200)]\n    head.append(next(sums))\n"
        "print(head == [i * (i + 1) // 2 for i in range(43)])"
    )
    assert said == "True\r\n"


def test_half_a_module_is_refused(pico):
    """An interrupted mpremote leaves one. The interpreter alone would read on for ever, deaf to Ctrl-C."""
    data = firmware_files("plotter_2014")["passo/motion/cordic.mpy"]
    for size in (len(data) - 1, len(data) - 5, len(data) // 2, 30, 0):
        pico.exec(f"with open('passo/half.mpy', 'wb') as file:\n    _ = file.write({data[:size]!r})")
        pico.soft_reset()
        pico.console.expect(b">>> ")
        attempt = "try:\n    import passo.half\nexcept ValueError as error:\n    print(error)\ncode.finish()\n"
        said = pico.exec(BEGIN + WHERE + "from passo.motion import cordic\n" + attempt + "print(code.why, in_flash(cordic.vector))")
        assert said == "passo/half.mpy is not whole: flash it anew\r\n True\r\n"


@pytest.mark.slow
def test_a_thousand_files_are_written_while_code_runs_from_flash(pico):
    """As settings are saved: the blocks of code stay as they are, whatever littlefs moves."""
    pico.exec(BEGIN + WHERE + REPLACE + "from passo.motion import integers, cordic\ncode.finish()\n")
    addresses = eval(pico.exec(f"print([mem32[id(each) + 12] for each in {FUNCTIONS}])"))
    used = {address - 0x10000000 & ~4095 for address in addresses if address >> 28 == 1}
    before = {at: bytes(pico.chip.flash[at : at + 4096]) for at in used}
    asked = "print([cordic.vector(3000, 4000 * i) for i in range(-3, 4)])"
    answer = pico.exec(asked)
    pico.exec("for i in range(1000):\n    replace('settings%d' % (i & 1), b'%d' % i * (i % 400))", limit_us=900_000_000)
    assert used and before == {at: bytes(pico.chip.flash[at : at + 4096]) for at in used}
    assert pico.exec("gc.collect()\n" + asked) == answer


REPLACE = """
def replace(name, data):
    with open(name, 'wb') as file:
        file.write(data)
"""
FILL = """
for i in range(400):
    try:
        replace('fill%d' % i, bytes([i & 255]) * 4000)
    except OSError:
        break
print(i)
"""
FUNCTIONS = "[getattr(cordic, name) for name in dir(cordic) if type(getattr(cordic, name)) is type(in_flash)]"


@pytest.mark.slow
def test_a_module_is_overwritten_without_a_reset(pico):
    """Its blocks are free for littlefs then, which fills the whole disk; those with code in use are not erased."""
    pico.exec(BEGIN + WHERE + "from passo.motion import integers, cordic\ncode.finish()\n")
    addresses = eval(pico.exec(f"print([mem32[id(each) + 12] for each in {FUNCTIONS}])"))
    used = {address - 0x10000000 & ~4095 for address in addresses if address >> 28 == 1}
    before = bytes(pico.chip.flash)
    asked = "print([cordic.vector(3000, 4000 * i) for i in range(-3, 4)])"
    answer = pico.exec(asked)
    pico.exec(REPLACE + "import os\nreplace('passo/motion/integers.mpy', b'x' * 3000)\nos.remove('passo/motion/cordic.mpy')\n")
    assert int(pico.exec(FILL, limit_us=400_000_000)) > 100
    changed = {at for at in range(0, len(before), 4096) if before[at : at + 4096] != pico.chip.flash[at : at + 4096]}
    assert used and len(changed) > 100 and not used & changed
    assert pico.exec(asked) == answer
    assert pico.exec("gc.collect()\n" + asked) == answer
