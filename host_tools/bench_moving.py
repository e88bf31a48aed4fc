"""Measurements of the emulated Pico while it moves: halts and queries. For `bench`, as those of `bench_pico`."""

from random import Random
from statistics import median

from host_tools.bench_pico import BAUD, COLLECT, rig
from host_tools.emulator import halting, traffic
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.queries import positions

STOPS, STOP_STEPS, STOP_HZ = 100, (4000, 3110, -2500), 100_000
IN_HAND, IN_HAND_STEPS, IN_HAND_HZ = 10, (16000, 12440, -10000), 400_000
RESUMED = 20
ACCEL_MM_S2 = 20_000
QUERIES_S = 0.15


def _p99(values):
    return sorted(values)[-(-len(values) * 99 // 100) - 1]


# --- halts


def stops():
    """Halting inputs at random moments, and lines taken up again."""
    rig()
    rows = [
        ("first pin", *_row(on_a_copy(lambda: _stops(halting.PLAYER_PIN)))),
        ("other pins", *_row(on_a_copy(lambda: _stops(halting.INTERRUPT_PIN)))),
        ("other pins, a word pulled but not yet out", *_row(on_a_copy(_in_hand))),
    ]
    resumed = _resumed()
    rows.append(("taken up again", len(resumed), "", "", "", sum(resumed)))
    return ("halt by", "trials", "word in hand", "last step after, µs: median", "worst", "exact"), rows


def _stops(pin):
    random = Random(pin)
    rig().wire().feed(traffic.points(60), BAUD)
    halting.set_out(rig(), STOP_STEPS, STOP_HZ, 2000, COLLECT)
    return halting.trials(rig(), pin, [random.uniform(0, 35_000) for _ in range(STOPS)])


def _row(found):
    reactions = [reaction_us for reaction_us, *_ in found]
    exact = sum(reported == counted and any(counted) for _, reported, counted, _ in found)
    held = sum(in_hand for *_, in_hand in found)
    return len(found), held, f"{median(reactions):.1f}", f"{max(reactions):.1f}", exact


def _in_hand():
    """Such a moment lasts a cycle and has to be searched for, each time from another place of the line on."""
    halting.set_out(rig(), IN_HAND_STEPS, IN_HAND_HZ, 2000)
    found = []
    for _ in range(IN_HAND):
        found.append(halting.in_hand(rig(), halting.INTERRUPT_PIN, [turn * 3 / 125 for turn in range(1000)]))
        rig().pico.run(1234.5)
    return [one for one in found if one]


def _resumed():
    random = Random(RESUMED)

    def right(wait_us):
        *_, position, _ = halting.resume(rig(), halting.INTERRUPT_PIN, STOP_STEPS, STOP_HZ, ACCEL_MM_S2, wait_us)
        return position == rig().counted() == list(STOP_STEPS)

    waits_us = [random.uniform(0, 35_000) for _ in range(RESUMED)]
    return [on_a_copy(lambda: right(wait_us)) for wait_us in waits_us]


# --- where is it?


def queries():
    """What asking for the position costs the main loop while axes step."""
    rig()
    rows = []
    for axes, hz in ((3, 100_000), (1, 400_000), (3, 400_000)):
        deltas = tuple(int(hz * QUERIES_S) * (axis < axes) for axis in range(3))
        found = on_a_copy(lambda: positions(rig(), deltas, hz))
        took_us = [us for us, _ in found]
        walked = max(words for _, words in found)
        rows.append((axes, hz // 1000, len(found), walked, round(median(took_us)), _p99(took_us), max(took_us)))
    return ("axes", "kHz", "queries", "words walked, at most", "µs, median", "p99", "worst"), rows


PARTS = {"queries": queries, "stops": stops}
