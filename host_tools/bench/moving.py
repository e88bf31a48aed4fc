"""Measurements of the emulated Pico while it moves: halts, queries, answers. For `bench`, as those of `pico`."""

import copy
from functools import lru_cache
from random import Random
from statistics import median

from host_tools import boards
from host_tools.bench.pico import BAUD, COLLECT, boot_rig
from host_tools.emulator import halting, traffic
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.queries import Asking, ask_positions

STOPS, STOP_STEPS, STOP_HZ = 100, (4000, 3110, -2500), 100_000
IN_HAND, IN_HAND_STEPS, IN_HAND_HZ = 10, (16000, 12440, -10000), 400_000
RESUMED = 20
ACCEL_MM_S2 = 20_000
QUERIES_S = 0.15
CLOCKS_MHZ = 125, 200
ANSWERS = 100
SHORT_UM = 866  # on each of three axes: 1.5 mm


def _percentile_99(values):
    """Return the value that 99 % of the values do not exceed."""
    return sorted(values)[-(-len(values) * 99 // 100) - 1]


# --- halts


def measure_stops():
    """Halt at random moments by inputs, and resume lines. Returns (header, rows)."""
    boot_rig()
    rows = [
        ("first pin", *_stops_row(on_a_copy(lambda: _measure_stops(halting.PLAYER_PIN)))),
        ("other pins", *_stops_row(on_a_copy(lambda: _measure_stops(halting.INTERRUPT_PIN)))),
        ("other pins, a word pulled but not yet out", *_stops_row(on_a_copy(_in_hand))),
    ]
    resumed = _resume_after_halts()
    rows.append(("taken up again", len(resumed), "", "", "", sum(resumed)))
    return ("halt by", "trials", "word in hand", "last step after, µs: median", "worst", "exact"), rows


def _measure_stops(pin):
    """Return halting.try_halts() of STOPS halts by the input `pin`: 0 to 35 ms after 2 ms of a line, while packets arrive."""
    random = Random(pin)
    boot_rig().wire().feed(traffic.move_packets(60), BAUD)
    halting.set_out(boot_rig(), STOP_STEPS, STOP_HZ, 2000, COLLECT)
    return halting.try_halts(boot_rig(), pin, [random.uniform(0, 35_000) for _ in range(STOPS)])


def _stops_row(found):
    """Return a row's figures of halting.try_halts(): trials, words in hand, median and worst µs from the edge to the last step, and the count of
    halts whose reported position is that of the steps."""
    reactions = [reaction_us for reaction_us, *_ in found]
    exact = sum(reported == counted and any(counted) for _, reported, counted, _ in found)
    held = sum(in_hand for *_, in_hand in found)
    return len(found), held, f"{median(reactions):.1f}", f"{max(reactions):.1f}", exact


def _in_hand():
    """Halt in that moment. It lasts one cycle: search for it, each time from another position on the line."""
    halting.set_out(boot_rig(), IN_HAND_STEPS, IN_HAND_HZ, 2000)
    found = []
    for _ in range(IN_HAND):
        found.append(halting.try_in_hand(boot_rig(), halting.INTERRUPT_PIN, [turn * 3 / 125 for turn in range(1000)]))
        boot_rig().pico.run(1234.5)
    return [one for one in found if one]


def _resume_after_halts():
    """Halt an accelerating line and resume it, RESUMED times, 0 to 35 ms behind its first step; return a bool for each: True if it ends exactly at
    its target."""
    random = Random(RESUMED)

    def is_exact(wait_us):
        *_, position, _ = halting.resume_line(boot_rig(), halting.INTERRUPT_PIN, STOP_STEPS, STOP_HZ, ACCEL_MM_S2, wait_us)
        return position == boot_rig().count_steps() == list(STOP_STEPS)

    waits_us = [random.uniform(0, 35_000) for _ in range(RESUMED)]
    return [on_a_copy(lambda: is_exact(wait_us)) for wait_us in waits_us]


# --- where is it?


def measure_queries():
    """Measure the time that the main loop spends on asking for the position while axes step. Returns (header, rows)."""
    boot_rig()
    rows = []
    for axes, hz in ((3, 100_000), (1, 400_000), (3, 400_000)):
        deltas = tuple(int(hz * QUERIES_S) * (axis < axes) for axis in range(3))
        found = on_a_copy(lambda: ask_positions(boot_rig(), deltas, hz))
        took_us = [us for us, _ in found]
        walked = max(words for _, words in found)
        rows.append((axes, hz // 1000, len(found), walked, round(median(took_us)), _percentile_99(took_us), max(took_us)))
    return ("axes", "kHz", "queries", "words walked, at most", "µs, median", "p99", "worst"), rows


def measure_status():
    """Measure the time from `?` on a link to the first byte of the answer: while three axes step at 100 kHz, and while lines come as fast as the
    machine of the board file takes them. Returns (header, rows)."""
    rows = []
    for link, name in (("pc", "USB"), ("serial", "UART, 115 200 baud")):
        for mhz in CLOCKS_MHZ:
            for machine, what, lines in (
                (boot_router(link, mhz), "long lines at 3 × 100 kHz", long_lines()),
                (boot_router(link, mhz), "a stream of lines of 1.5 mm at 3 × 100 kHz", _short_lines()),
                (as_flashed(link, mhz), "a stream of lines of 0.2 mm at 50 mm/s", _tiny_lines()),
            ):
                took_ms = on_a_copy(lambda: time_answers(machine, lines))
                times = [f"{ms:.2f}" for ms in (median(took_ms), _percentile_99(took_ms), max(took_ms))]
                rows.append((name, mhz, what, len(took_ms), *times))
    return ("link", "MHz", "stepping", "answers", "ms, median", "p99", "worst"), rows


@lru_cache
def as_flashed(link, clock_mhz):
    """Boot router_3axis, and unlock it; lines come from `link`. Returns (machine, Asking)."""
    board = {**copy.deepcopy(boards.load("router_3axis")), "commands": link, "clock_mhz": clock_mhz}
    machine = EmulatedMachine(board, trace=None).boot()
    machine.pico.console.expect(b"Grbl")
    machine.run_ms(100)
    asking = Asking(machine, link)
    asking.stream_lines([b"$X\n", b"G21G91G94F3000\n"])
    machine.run_until(lambda: not asking.unanswered, 1000)
    asking.ask_status()
    return machine, asking


def _tiny_lines():
    return [b"G1X%sY0.1\n" % (b"0.2" if line % 40 < 20 else b"-0.2") for line in range(4000)]


@lru_cache
def boot_router(link, clock_mhz=200):
    """Boot the router with faster drivers; lines come from `link`. It has no homing, so it is not locked. Returns (machine, Asking)."""
    board = copy.deepcopy(boards.load("router_3axis"))
    board["commands"] = link
    board["clock_mhz"] = clock_mhz
    board["drive"]["pulse_us"] = 2
    del board["homing"]
    for axis in board["axes"]:
        axis.update(steps_per_m=400_000, travel_steps=120_000, max_mm_min=15_000, accel_mm_s2=5000)
    machine = EmulatedMachine(board, trace=None, start=(0, 0, 0)).boot()
    machine.pico.console.expect(b"Grbl")
    machine.run_ms(100)
    asking = Asking(machine, link)
    asking.stream_lines([b"G1F25981\n"])  # √3 · 15 000: each axis at 100 kHz
    machine.run_until(lambda: not asking.unanswered, 1000)
    asking.ask_status()  # as every sender does first; it makes the buffers
    return machine, asking


def long_lines():
    return [b"X290Y290Z290\n", b"X0Y0Z0\n"] * 10


def _short_lines():
    """Return lines that follow each other in a straight path, there and back."""
    stations = [*range(SHORT_UM, 290_000, SHORT_UM)]
    return [("X%.3fY%.3fZ%.3f\n" % ((um / 1000,) * 3)).encode() for um in (stations + stations[-2::-1]) * 4]


def time_answers(asked, lines, count=ANSWERS):
    """Return the milliseconds from `?` to its answer, asked at random moments while `lines` are stepped; `asked`: boot_router()."""
    machine, asking = asked
    random = Random(ANSWERS)
    asking.stream_lines(lines)
    machine.run_ms(400)
    took_ms = []
    while len(took_ms) < count:
        machine.run_ms(random.uniform(2, 12))
        took_ms.append(asking.ask_status())
    return took_ms


PARTS = {"queries": measure_queries, "status": measure_status, "stops": measure_stops}
