"""The figures that Passo promises of a board, in one place. docs/reference/benchmarks.md says how each was measured; a test compares both
(tests_host/rules/test_promises.py).

    verdict(PROMISES["stop_us"], 0.1)       # BETTER, KEPT or WORSE
"""

from dataclasses import dataclass

BETTER, KEPT, WORSE = "better", "as promised", "worse"


@dataclass(frozen=True)
class Promise:
    what: str
    unit: str
    bound: float
    least: bool = False  # the bound is the least; else the most
    easy: float = 0  # from here on it is better than promised; 0: it cannot be
    advice: str = ""
    said: str = ""  # its sentence in docs/reference/benchmarks.md


PROMISES = {
    "clock_khz": Promise("system clock, off the board file's", "kHz", 50, advice="the crystal or clock_mhz is wrong: all speeds and times are off by as much"),
    "crystal_ppm": Promise("the chip's seconds, off the PC's", "ppm", 5000, advice="the crystal is wrong: all speeds and times are off by as much"),
    "erase_ms": Promise("flash: erasing a sector", "ms", 100, easy=40, advice="another flash chip: interrupts wait for each erase; keep journal and settings off while it moves", said="its blocks are erased"),
    "page_ms": Promise("flash: writing a page", "ms", 1.5, easy=0.4, advice="another flash chip: UARTs lose bytes while it writes"),
    "core_mv": Promise("core voltage", "mV", 1, least=True, advice="too little for this clock: the chip may make errors; clock_mhz of the board file"),
    "collect_ms": Promise("a collection of garbage", "ms", 40, easy=20, advice="more memory is in use than usual: leave out a link, a language or store_points", said="A collection of garbage takes 33 ms"),
    "free_bytes": Promise("memory free", "bytes", 0.9, least=True, easy=1.1, advice="something else takes memory: flash the board anew, leave out a link or a language", said="heap free, bytes"),
    "piece_bytes": Promise("memory in one piece", "bytes", 0.75, least=True, easy=1.5, advice="something else takes memory: flash the board anew", said="in one piece"),
    "pulse_ns": Promise("STEP pulse, off the board file's", "ns", 80, advice="drivers may miss steps: pulse_us of the board file is not what the pins do"),
    "setup_ns": Promise("DIR to STEP, short of the board file's", "ns", 80, advice="drivers may step the wrong way: setup_us of the board file is not kept"),
    "edge_ns": Promise("edges off their words", "ns", 80, advice="steps come late or early: an interrupt of something else, or a player that runs dry", said="80 ns, 0 words late"),
    "late_words": Promise("words late", "", 0, advice="interrupts came too late to make words: nothing but Passo may have interrupts on this board", said="0 words late"),
    "fastest_khz": Promise("three axes together, edges as their words", "kHz", 480, least=True, advice="the player does not keep up", said="480 kHz, 63 % left with the flash cache"),
    "stop_us": Promise("halting input to the last step", "µs", 25, easy=10, advice="the emergency input is late: no motor before this is understood", said="halting input to the last step: the first | 25 µs | 10 µs"),
    "halts_off": Promise("halts with a wrong position", "of 20", 0, advice="home again after each stop, and report this", said="100 of 100 positions exact"),
    "bytes_lost": Promise("bytes lost on the link", "of 16384", 0, advice="another cable or USB port; --frames sends damaged lines again", said="0 bytes lost"),
    "framed_lost": Promise("lines lost in frames, on a bad wire", "", 0, advice="another cable or USB port, and report this", said="0 bytes lost"),
    "ask_ms": Promise("`?` answered, median", "ms", 5, easy=2, advice="a slow link: another USB port, no hub"),
    "ask99_ms": Promise("`?` answered in a stream, p99", "ms", 20, easy=5, advice="a slow link: another USB port, no hub", said="p99 | 20 ms | 5 ms"),
    "lines_s": Promise("lines of 0.2 mm over the link", "a second", 500, least=True, easy=1000, advice="a slow link: another USB port, no hub", said="the same over USB, 127 bytes under way, the PC answers at once | 500 | 1000"),
    "packets_s": Promise("points over the link", "a second", 1000, least=True, easy=2000, advice="a slow link: another USB port, no hub", said="points over USB | 1000/s | 2000/s"),
    "watchdog_ms": Promise("watchdog of 1000 ms bites after", "ms", 1500, advice="a program that hangs is not ended: do not leave the machine alone"),
}  # fmt: skip

# Free and in one piece of docs/reference/benchmarks.md, "Boot and memory": stock MicroPython, Passo's UF2.
MEMORY = {
    "corexy_plotter": ((68736, 24944), (125552, 93424)),
    "laser_fast": ((61168, 23664), (118688, 86960)),
    "laser_rotary": ((58928, 21680), (117392, 87248)),
    "laser_xy": ((64112, 25488), (120960, 88960)),
    "lpt_router": ((96448, 36736), (141872, 98976)),
    "mill_2004": ((42656, 5632), (111456, 74112)),
    "plotter_2014": ((120512, 51936), (159312, 123440)),
    "plotter_pico_w": ((120400, 52272), (159328, 123440)),
    "router_3axis": ((72080, 30544), (123968, 91248)),
    "router_4axis": ((68208, 23936), (122160, 90000)),
    "router_ballscrew": ((64064, 24560), (119120, 87376)),
    "router_skr_pico": ((60768, 22992), (116352, 86112)),
    "router_tmc2209": ((65712, 23680), (119856, 88976)),
    "router_tmc5160": ((63360, 21696), (119680, 87200)),
    "torch_manipulator": ((96112, 44112), (147776, 103696)),
    "two_motor_kit": ((119776, 53152), (163104, 127376)),
}


def verdict(promise, value, whole=1):
    """Return BETTER, KEPT or WORSE for `value`. `whole`: the promise's bounds are shares of it."""
    bound, easy = promise.bound * whole, promise.easy * whole
    if promise.least:
        return WORSE if value < bound else BETTER if easy and value > easy else KEPT
    return WORSE if value > bound else BETTER if easy and value < easy else KEPT
