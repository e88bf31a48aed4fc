"""Measurements on the emulated Pico, for `bench`: each returns (header, rows). Times are the emulated chip's."""

from functools import lru_cache

from host_tools import boards
from host_tools.emulator import gcode as lines_of_gcode
from host_tools.emulator import halting, traffic
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLE_NS, CYCLES_PER_US
from host_tools.emulator.frozen import find_frozen, frozen_machine
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine, firmware_files
from host_tools.emulator.rig import Rig, router_board
from host_tools.emulator.sender import WINDOW, Sender, usb_rig

COLLECT = "gc.collect()"
START_HZ, START_S = 5000, 0.01
LINE_S = 0.04
BAUD = 115_200
GCODE_LINES = 800
THINK_US = 0, 1000  # that a PC takes to send more when it hears an answer
CLOCKS_MHZ = 125, 200  # of the G-code
GCODE_LINKS = {"pc": "USB", "serial": "a UART of 115 200 baud"}  # of router_3axis


@lru_cache
def boot_rig(player="pio", axes=3):
    """Boot the rig, once; measurements run on copies of it."""
    return Rig(router_board(axes, player=player, inputs=halting.INPUTS))


def constant_lines(hz, axes):
    """Return lines at a constant rate, as after a ramp; words at the full rate from rest would be made when they are due."""
    return [(tuple(int(rate * seconds) * (axis < axes) for axis in range(max(axes, 3))), rate)
            for rate, seconds in ((START_HZ, START_S), (hz, LINE_S))]


def measure_pulses():
    """Measure rates of one axis, of three and of four, while points arrive and garbage is collected without pause."""
    rows = []
    for axes, rates in ((1, (10, 50, 100, 200, 250, 480)), (3, (10, 50, 100, 200, 400, 480)), (4, (400, 480))):
        boot_rig(axes=max(axes, 3))
        for khz in rates:
            run = on_a_copy(lambda: _run_pulses(axes, khz * 1000))
            rows.append((axes, khz, run["steps"], run["off"], run["late"], run["ppm"], run["width"], run["left"]))
    return ("axes", "kHz", "steps", "edge off its word, ns", "words late", "rate error, ppm", "pulse µs", "CPU left"), rows


def _run_pulses(axes, hz):
    """Step `axes` axes at `hz` steps/s on the PIO player; return {name: figure}: steps, worst edge off its word in ns, words late, error of the rate
    in ppm, widths of pulses in µs, share of the processor left."""
    machine = boot_rig(axes=max(axes, 3))
    machine.wire().feed(traffic.move_packets(60), BAUD)
    run = machine.play(constant_lines(hz, axes), COLLECT)
    rises = [cycle for cycle, state in machine.step_edges[0] if state == 1]
    late = len(rises) // 4  # the set-up of a direction has been paid back by then
    rate = (len(rises) - 1 - late) / (rises[-1] - rises[late]) * 1e9 / CYCLE_NS
    return {
        "steps": run.steps,
        "off": run.off * CYCLE_NS,
        "late": run.late,
        "ppm": f"{(rate / hz - 1) * 1e6:.0f}",
        "width": "/".join(f"{width / CYCLES_PER_US:.2f}" for width in sorted(run.widths)),
        "left": f"{run.share_left():.0%}",
    }


TIMER_KHZ = (10, 25, 36, 50, 80, 120)
LATENESS_US = (0, 1, 2, 3, 5)  # lower ends of its classes


def measure_timer():
    """Measure how late the edges of the timer-interrupt player come while garbage is collected without pause."""
    boot_rig("timer")
    rows = [on_a_copy(lambda: _run_timer(axes, khz)) for axes in (1, 3) for khz in TIMER_KHZ]
    classes = [f"{low}–{high} µs" for low, high in zip(LATENESS_US, LATENESS_US[1:])] + [f"over {LATENESS_US[-1]} µs"]
    return ("axes", "kHz", "steps", "words late", *classes, "µs, worst", "CPU left"), rows


def _run_timer(axes, khz):
    """Step `axes` axes at `khz` kHz on the timer-interrupt player; return a row of measure_timer(). Lateness is in µs behind the earliest edge; an
    edge a period late counts as a word late."""
    run = boot_rig("timer").play(constant_lines(khz * 1000, axes), COLLECT)
    first = min(run.lateness)
    late_us = [(cycles - first) / CYCLES_PER_US for cycles in run.lateness]
    overtaken = sum(us >= 1000 / khz for us in late_us)  # the next word's time has come
    shares = [sum(low <= us < high for us in late_us) / len(late_us)
              for low, high in zip(LATENESS_US, (*LATENESS_US[1:], max(late_us) + 1))]
    return (axes, khz, run.steps, run.late + overtaken, *(f"{share:.1%}" for share in shares), f"{max(late_us):.1f}",
            f"{run.share_left():.0%}")


def measure_boot():
    """Boot each board file for a Pico on stock MicroPython, and with Passo's UF2: time from reset to the main loop, to the first answer, and the
    heap then."""
    uf2 = find_frozen("rp2040")
    rows = []
    for board in boards.names():
        config = boards.load(board)
        if config["chip"] == "rp2040" and not config.get("network"):  # that wants a Pico W
            rows.append(on_a_copy(lambda: (*_boot_stock(board), *_boot_frozen(board, uf2))))
    return (
        "board", "language", "main loop, ms after reset", "first answer, ms after reset", "heap free, bytes", "in one piece", "code in",
        "UF2: main loop", "first answer", "heap free", "in one piece"
    ), rows  # fmt: skip


_RUN = b"    main(Start, STAMP)\n"
_TOLD = b"    def told(self, app, settle=Start.settle):\n        settle(self, app)\n        print('ready')\n    Start.settle = told\n"
_FIRST = {"plotter": (b"r\0\0\0\0r", b"k"), "grbl": (b"?", b"<")}  # other languages have no question that any machine answers


def _boot_stock(board):
    """Boot a board file on stock MicroPython; return (board, language, ms from reset to the main loop, ms to the first answer, bytes of heap free,
    bytes of its largest piece, place of the code)."""
    files = dict(firmware_files(board))
    assert files["main.py"].count(_RUN) == 1
    machine = EmulatedMachine(board, dict(files, **{"main.py": files["main.py"].replace(_RUN, _TOLD + _RUN)})).boot()
    console = machine.pico.console
    machine.run_until(lambda: b"ready" in console.text, slice_us=200)
    ready_ms = machine.now_ms()
    heap = Heap(machine.pico)
    language = machine.board["links"][0]["protocol"]
    where = [line for line in bytes(console.take_output()).decode().splitlines() if line.startswith("code in ")][0]
    where = where.removeprefix("code in ").partition(", build")[0]
    return board, language, round(ready_ms), _first_ms(machine, language), heap.free, heap.largest, where


def _boot_frozen(board, uf2):
    """Boot a board file with Passo's UF2; return (ms from reset to the main loop, ms to the first answer, bytes of heap free, bytes of its largest
    piece)."""
    machine = frozen_machine(board, uf2).boot()
    console = machine.pico.console
    machine.run_until(lambda: b"code in the UF2" in console.text, slice_us=200)
    ready_ms, heap = machine.now_ms(), Heap(machine.pico, True)
    return round(ready_ms), _first_ms(machine, machine.board["links"][0]["protocol"]), heap.free, heap.largest


def _first_ms(machine, language):
    """Return the ms from power-on to the first answer, "–" if the language has no question."""
    if language not in _FIRST:
        return "–"
    question, answer = _FIRST[language]
    link = next(iter(machine.uart_links()), None)  # None: USB
    while answer not in machine.take(link):
        machine.send(question, link)
        machine.run_ms(20)
    return round(machine.now_ms())


def measure_links():
    """Measure points a second over UART and USB, many packets under way and one by one, idle and while three axes step."""
    rows = []
    for name, chip, baud in (("UART, 57 600 baud", boot_rig, 57_600), ("UART, 115 200 baud", boot_rig, 115_200), ("USB", usb_rig, 0)):
        machine = chip()
        for khz in (0, 100):
            for window, count in ((WINDOW, 400), (1, 150)):
                sent = on_a_copy(lambda: Sender(machine, baud).send(count, window, 1000 * khz))
                share = f"{sent.share:.0%}" if baud else ""
                rows.append((name, khz, window, round(sent.rate), share, sent.lost, sent.late))
    return ("link", "three axes, kHz", "packets under way", "points/s", "of the wire", "bytes lost", "words late"), rows


def measure_gcode():
    """Measure G-code lines a second from memory and over each link, while they are stepped; and how long a command and a feed hold wait over USB."""
    rows = [(what, mhz, *figures) for mhz in CLOCKS_MHZ for what, *figures in _gcode_rows(mhz)]
    return ("G-code on router_3axis", "MHz", "asked", "measured", "blocks ahead, least", "words late"), rows


def _gcode_rows(mhz):
    """Yield (text, asked, measured, least blocks ahead, words late) of measure_gcode() at a clock of `mhz` MHz: lines and dots a second, and times in
    ms. A figure that is not measured is ""."""
    machine = lines_of_gcode.fast_router(clock_mhz=mhz, mm_s=500, mm_s2=300_000)
    for length_mm, feed_mm_s in ((0.2, 100), (0.2, 490), (0.75, 187.5)):
        run = on_a_copy(lambda: lines_of_gcode.run_lines(machine, length_mm, feed_mm_s, GCODE_LINES))
        what = f"lines of {length_mm} mm at {feed_mm_s} mm/s from memory, a second"
        yield what, round(feed_mm_s / length_mm), round(run["lines_s"]), run["least"], run["late"]
    for link, name in GCODE_LINKS.items():
        for think_us in THINK_US:
            lines_s = on_a_copy(lambda: lines_of_gcode.lines_over(machine, link, 0.2, 490, GCODE_LINES, think_us))
            yield f"lines of 0.2 mm at 490 mm/s over {name}, the PC takes {think_us} µs, a second", 2450, round(lines_s), "", ""
    laser = lines_of_gcode.fast_router((0.1,), laser=True, clock_mhz=mhz)
    for dot_mm, feed_mm_s, mode in ((0.1, 200, "M4"), (0.1, 200, "M3")):
        run = on_a_copy(lambda: lines_of_gcode.run_raster(laser, dot_mm, feed_mm_s, GCODE_LINES, mode))
        what = f"a picture's dots of {dot_mm} mm at {feed_mm_s} mm/s, {mode}, from memory, a second"
        yield what, round(feed_mm_s / dot_mm), round(run["lines_s"]), run["least"], run["late"]
    for link, name in GCODE_LINKS.items():
        dots_s = on_a_copy(lambda: lines_of_gcode.dots_over(laser, link, 0.1, 200, GCODE_LINES))
        yield f"dots of 0.1 mm at 200 mm/s, M4, over {name}, the PC takes 0 µs, a second", 2000, round(dots_s), "", ""
    steps, holds = on_a_copy(lambda: _time_answers(mhz))
    yield "first step after a command at rest, over USB, ms", "", f"{max(steps):.1f}", "", ""
    yield "a feed hold begins to slow at 100 mm/s, over USB, ms", "", f"{max(holds):.1f}", "", ""


def _time_answers(mhz, flashed=EmulatedMachine):
    """Try first steps and holds on router_3axis, as flashed but with faster axes, at all phases of the main loop's cycle. Returns two
    lists of milliseconds: from a line to its first step, and from `!` to the first slower step."""
    machine = flashed(lines_of_gcode.fast_board((), clock_mhz=mhz, mm_s=500, mm_s2=300_000)[0], trace=None).boot()
    machine.pico.console.expect(b"Grbl")
    machine.run_ms(100)
    return lines_of_gcode.time_first_steps(machine, 30), lines_of_gcode.time_holds(machine, 40)


PARTS = {"pulses": measure_pulses, "timer": measure_timer, "links": measure_links, "gcode": measure_gcode, "boot": measure_boot}
