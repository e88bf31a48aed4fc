"""Turns the records of the board's witness into times and levels, and compares them with the words.

    seen = decode_records(records, 6)                          # [(cycle, levels), …]
    found = compare_edges(seen, changes_in_words(words, layout, …), …)
"""

import itertools
from dataclasses import dataclass, field

from passo.steps.word import TICKS_PER_S

PASS = 7  # state machine cycles of a pass of the witness's program; one that writes a record takes two


def decode_records(records, width):
    """Return [(cycles since the start, levels)] of the witness's records."""
    bits = 32 - width
    mask = (1 << bits) - 1
    seen, passes, before = [], 0, mask
    for number, record in enumerate(records):
        count = record & mask
        passes += before - count & mask
        before = count
        seen.append((PASS * (passes + number), record >> bits))
    return seen


def changes_in_words(words, bits, width, step_mask, pulse_ticks):
    """Return [(tick, levels)] of each change of the lowest `width` bits that words ask for; STEPs fall after `pulse_ticks`."""
    mask = (1 << width) - 1
    tick, changes = 0, []

    def add_change(at, levels):
        if not changes or changes[-1][1] != levels:
            changes.append((at, levels))

    for word in words:
        levels = word & mask
        add_change(tick, levels)
        if levels & step_mask and pulse_ticks:
            add_change(tick + pulse_ticks, levels & ~step_mask)
        tick += word >> bits
    return changes


@dataclass
class Found:
    same: bool = False  # the same levels, one after another
    swapped: tuple = ()  # two bits that would have to be exchanged for that
    off_ns: float = 0
    pulse_ns: tuple = ()  # shortest and longest STEP
    setup_ns: float | None = None  # shortest time from a change of DIR to a STEP of the same axis
    steps: int = 0
    lateness_ns: list = field(default_factory=list)
    interval_ns: list = field(default_factory=list)  # of the first axis


def exchange_bits(levels, a, b):
    return levels & ~(1 << a | 1 << b) | (levels >> a & 1) << b | (levels >> b & 1) << a


def compare_edges(seen, changes, width, axes, motors, mhz):
    """Compare `seen`, [(cycle, levels)] that begin with the levels before the first change, with `changes`, [(tick, levels)]; return a Found.
    `motors`: 0 for coils."""
    found = Found()
    ns = 1000 / mhz
    step_mask = (1 << motors) - 1
    levels = [each for _, each in changes]
    begins = 0
    while begins < len(levels) and seen and levels[begins] == seen[0][1]:
        begins += 1  # a first word that changes nothing
    levels = levels[begins:]
    real = [each for _, each in seen[1:]]
    found.same = real == levels
    if not found.same:
        for a, b in itertools.combinations(range(width), 2):
            if [exchange_bits(each, a, b) for each in real] == levels:
                found.swapped = a, b
                break
    if found.same and levels:
        tick_ns = 1e9 / TICKS_PER_S
        pairs = list(zip(seen[1:], changes[begins:]))
        # A first word without a step lasts a microsecond longer: the player begins while the next words are still being handed over.
        pairs = pairs[next((at for at, (_seen, (_tick, each)) in enumerate(pairs) if each & step_mask), 0) :]
        origin = pairs[0][0][0] * ns - pairs[0][1][0] * tick_ns
        found.lateness_ns = [cycle * ns - tick * tick_ns - origin for (cycle, _), (tick, _) in pairs]
        found.off_ns = max(map(abs, found.lateness_ns))
    if motors:
        _measure_pulses(found, seen, axes, motors, ns)
    return found


def _measure_pulses(found, seen, axes, motors, ns):
    """Set in `found` the steps, the first axis's intervals, and the shortest and longest pulse and shortest setup time, in ns."""
    widths, setups, rises = [], [], {}
    turned = {}
    for (_, before), (cycle, levels) in zip(seen, seen[1:]):
        for axis in range(axes):
            changed = before ^ levels
            if changed >> motors + axis & 1:
                turned[axis] = cycle
            if changed >> axis & 1 == 0:
                continue
            if levels >> axis & 1:
                found.steps += 1
                if axis == 0 and 0 in rises:
                    found.interval_ns.append((cycle - rises[0]) * ns)
                rises[axis] = cycle
                if axis in turned:
                    setups.append((cycle - turned.pop(axis)) * ns)
            elif axis in rises:
                widths.append((cycle - rises[axis]) * ns)
    if widths:
        found.pulse_ns = min(widths), max(widths)
    if setups:
        found.setup_ns = min(setups)


def count_steps(seen, axes, motors):
    """Count the steps of each axis, signed, as drivers would."""
    places = [0] * axes
    for (_, before), (_, levels) in zip(seen, seen[1:]):
        for axis in range(axes):
            if (levels & ~before) >> axis & 1:
                places[axis] += 1 if levels >> motors + axis & 1 else -1
    return places
