"""The step word: the only definition of its layout.

A word is 32 bits, `ticks << bits | levels`: the low bits are the pin levels that hold from the word's start, the rest
the ticks until the next word. A tick is 80 ns, so that 12.5 MHz divides 125 and 200 MHz exactly.

No word reaches 2³⁰, because a board allocates memory for a larger integer. A wait longer than HOLD_TICKS is played as
several words of the same levels.
"""

from passo.records import COUNT_MASK, HOLD_TICKS, TICKS_PER_MS, TICKS_PER_S  # noqa: F401


def us_to_ticks(us):
    """Return the ticks that last at least `us` microseconds."""
    return (us * 25 + 1) // 2


class Layout:
    """Which bit of a word is which pin.

    A segment is first paced in the *step form*, the same for every machine: bit i is a step of axis i, bit n + i its
    direction (1 = positive). STEP/DIR drives play that form as it is; a coil drive turns it into coil levels. The tool
    bit is the highest of the `bits` levels in both.
    """

    def __init__(self, kind, axes, drive_bits, pin_names, pulse_mask, motors=0):
        """`motors`: those of STEP/DIR drivers, if there are more than axes: the second one of an axis stands behind the others."""
        self.kind = kind
        self.axes = axes
        self.motors = motors or axes
        self.bits = drive_bits + 1
        self.tool_mask = 1 << drive_bits
        self.levels_mask = (1 << self.bits) - 1
        self.step_mask = (1 << axes) - 1
        self.pulse_mask = pulse_mask
        self.pin_names = pin_names + ["tool"]
