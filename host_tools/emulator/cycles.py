"""Time as it is measured on the emulated chip: in cycles of 125 MHz, whatever its clock is (see `system_clock`).

rp2040py counts nanoseconds in a float. A cycle is 8 ns, so whole cycles are exact. The patches round every alarm up to a whole
cycle, which keeps the processor in step with them. At other clocks a tick of 80 ns is ten of these cycles too.
"""

CYCLE_NS = 8
CYCLES_PER_US = 125
CYCLES_PER_TICK = 10
CYCLES_PER_S = 125_000_000
spent = [0]  # by all emulated Picos of this process and its copies


def now_cycles(clock):
    """Return the cycles since power-on, sleep included."""
    return int(clock.nanos * 0.125 + 0.501)  # a cycle of 150 MHz may end amid two, and is no exact float


def delay_ns(nanoseconds):
    """Return `nanoseconds`, rounded up to whole cycles."""
    return -(-nanoseconds // CYCLE_NS) * CYCLE_NS
