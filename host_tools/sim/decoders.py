"""Decodes pin levels back into motor steps, as a motor does; one class for each kind of drive.

    decoder = Unipolar("half", 0, 0, report)    # four pins from bit 0 of the levels, none inverted
    steps = decoder.decode(tick, levels, changed)

`decode` returns the steps the rotor makes at this edge, and calls `report(tick, text)` for anything a real drive could
not follow. The tables are those of the 2014 plotter's drivers (LEGACY.md, *plotter*). Coil decoders count electrical
positions in 32nds of an electrical turn: an eighth of a full step is one, a full step eight.
"""

import math

TICKS_PER_US = 12.5
RELEASED = -1
ILLEGAL = -2

# S1..S4 in the order of the half step's eight states; S1 is the lowest bit.
UNIPOLAR_STATES = ("1000", "1100", "0100", "0110", "0010", "0011", "0001", "1001")
# PBL3770A: percent of full current by I0 + 2 · I1.
PBL_CURRENTS = (100, 60, 20, 0)

TURN = 32
# 32nds of an electrical turn a step, and the first that belongs to the mode.
MODES = {"wave": (8, 0), "full": (8, 4), "half": (4, 0), "quarter": (2, 0), "eighth": (1, 0)}


class StepDir:
    """A driver with STEP and DIR inputs: steps on STEP's leading edge.

    `step_bit` and `dir_bit` number the pins, `inverted` is the mask of active-low ones. A STEP pulse shorter than
    `pulse_us`, a gap between pulses shorter than that, or a DIR edge less than `setup_us` before a STEP or during one,
    is reported; the step is counted all the same.
    """

    def __init__(self, step_bit, dir_bit, inverted, pulse_us, setup_us, report):
        self._step = 1 << step_bit
        self._dir = 1 << dir_bit
        self.mask = self._step | self._dir
        self._inverted = inverted & self.mask
        self._pulse_ticks = pulse_us * TICKS_PER_US
        self._setup_ticks = setup_us * TICKS_PER_US
        self._report = report
        self._rose = self._fell = self._turned = -(1 << 30)

    def decode(self, tick, levels, changed):
        """Return the steps (−1, 0 or 1) of the pins' `levels` at `tick`, of which the bits `changed` have changed. Reports times that the driver's
        limits forbid."""
        levels ^= self._inverted
        steps = 0
        if changed & self._dir:
            self._turned = tick
            if levels & self._step and not changed & self._step:
                self._report(tick, "DIR changed during a STEP pulse")
        if changed & self._step:
            if levels & self._step:
                if tick - self._turned < self._setup_ticks:
                    self._report(tick, "STEP too soon after DIR")
                if tick - self._fell < self._pulse_ticks:
                    self._report(tick, "STEP low for too short a time")
                self._rose = tick
                steps = 1 if levels & self._dir else -1
            else:
                if tick - self._rose < self._pulse_ticks:
                    self._report(tick, "STEP pulse too short")
                self._fell = tick
        return steps


class Coils:
    """A motor whose coil pins are driven directly: `table` maps the pins to an electrical position.

    The rotor follows to the nearest place of the same electrical position. More than one step of `mode` at once, or a
    pattern that holds the rotor nowhere in that mode, is reported. All coils off releases the rotor, which stays.
    """

    def __init__(self, mode, shift, inverted, report, table):
        self._stride, first = MODES[mode]
        allowed = range(first, TURN, self._stride)
        self._table = [state if state < 0 or state in allowed else ILLEGAL for state in table]
        self._shift = shift
        self._mask = len(table) - 1
        self.mask = self._mask << shift
        self._inverted = (inverted >> shift) & self._mask
        self._report = report
        self.phase = None  # electrical position 0..31; None until first energised
        self.released = True

    def decode(self, tick, levels, changed):
        """Return the phase steps, signed, of the coils' `levels` at `tick`. Reports patterns that the drive does not have, and jumps."""
        pattern = (levels >> self._shift) & self._mask ^ self._inverted
        state = self._table[pattern]
        if state < 0:
            if state == ILLEGAL:
                self._report(tick, f"coil pattern {self._pattern_text(pattern)} is none of the drive's")
            self.released = state == RELEASED
            return 0
        self.released = False
        before = self.phase
        self.phase = state
        if before is None or state == before:
            return 0
        delta = (state - before + TURN // 2) % TURN - TURN // 2
        if delta > self._stride or -delta > self._stride:
            self._report(tick, f"coils jumped from position {before} to {state} of {TURN}")
            if delta == -TURN // 2:  # the opposite pole pulls neither way
                return 0
        return delta // self._stride

    def _pattern_text(self, pattern):
        """Return the pattern, first pin first, as the tables print it."""
        return "".join(["01"[pattern >> bit & 1] for bit in range(8) if self._mask >> bit])


class Unipolar(Coils):
    """Four transistors S1..S4, S1 the lowest bit."""

    def __init__(self, mode, shift, inverted, report):
        table = [ILLEGAL] * 16
        table[0] = RELEASED
        for state, coils in enumerate(UNIPOLAR_STATES):
            table[int("".join(reversed(coils)), 2)] = state * TURN // 8
        super().__init__(mode, shift, inverted, report, table)


class TableCoils(Coils):
    """Coils of any other drive: which pattern is which phase its own table says, so only jumps and strange patterns are found."""

    def __init__(self, drive, mode, shift, inverted, report):
        """`drive`: the module of options/drive_KIND."""
        table = [ILLEGAL] * (1 << len(drive.PINS))
        table[getattr(drive, "OFF", 0)] = RELEASED
        stride, first = MODES[mode]
        for phase, pattern in enumerate(drive.MODES[mode]):
            table[pattern] = (first + phase * stride) % TURN
        super().__init__(mode, shift, inverted, report, table)


class Pbl3770a(Coils):
    """Two PBL3770A, pins PH I0 I1 of coil A and then of coil B, lowest bit first; PH high is positive. The rotor follows to where
    the sum of both currents points.

    `current` is the percent of full current in the stronger winding.
    """

    def __init__(self, mode, shift, inverted, report):
        table = []
        self._currents = []
        for pattern in range(64):
            a, b = self._coil_current(pattern & 7), self._coil_current(pattern >> 3)
            table.append(round(math.atan2(b, a) / math.tau * TURN) % TURN if a or b else RELEASED)
            self._currents.append(max(abs(a), abs(b)))
        self.current = 0
        super().__init__(mode, shift, inverted, report, table)

    @staticmethod
    def _coil_current(pins):
        current = PBL_CURRENTS[pins >> 1]
        return current if pins & 1 else -current

    def decode(self, tick, levels, changed):
        """Return the phase steps, signed, as Coils.decode(), and note the current of the pattern."""
        self.current = self._currents[(levels >> self._shift) & self._mask ^ self._inverted]
        return super().decode(tick, levels, changed)


_OF_2014 = {"unipolar": Unipolar, "pbl3770a": Pbl3770a}


def make_decoder(kind, mode, axis, bit, report):
    """Return the decoder of an axis's motor. `bit`: {name of a pin: its number}."""
    drive = __import__(f"passo.options.drive_{kind}.drive", None, None, ("drive",))  # MicroPython, in a tab, has no importlib
    shift = bit[f"{axis}_{drive.PINS[0]}"]
    return _OF_2014[kind](mode, shift, 0, report) if kind in _OF_2014 else TableCoils(drive, mode, shift, 0, report)
