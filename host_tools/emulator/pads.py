"""Patch: pads with two sides. An output reads back its own level, and is released at a reset.

In rp2040py a pin reads only what the outside drives: `Pin.value()` of an output, and a state machine that watches one, see
nothing. A reset tells no listener. Setting an input to the level that it has raises an edge.

    pads.drive_pin(5, 1)                # the world outside drives GPIO5 high; None lets go, and the pull decides
    pads.add_listener(2, heard)           # heard(gpio, state) at each change of what the chip drives: 0, 1 or RELEASED
"""

RELEASED = 2
PINS = 30


class Pads:
    def __init__(self, chip, loop_back=True):
        self._chip = chip
        self._outside = {}  # {gpio: level} that the world drives
        self._driven = set()  # pins that the chip drives
        self._listeners = {}
        self._loop_back = loop_back
        self._watch_pulls()
        for pin in chip.gpio:
            pin.add_listener(self._make_listener(pin))

    def _watch_pulls(self):
        """Make a pin that nobody drives follow its pull as soon as a register says so."""
        pads, first = self._chip.peripherals[0x4001C], 4
        write = pads.write_uint32

        def write_and_watch(offset, value):
            """Write a pad's register; an undriven pin then follows its new pull."""
            write(offset, value)
            gpio = offset - first >> 2
            if 0 <= gpio < PINS and gpio not in self._driven and gpio not in self._outside:
                self._let_go(self._chip.gpio[gpio])

        pads.write_uint32 = write_and_watch

    def add_listener(self, gpio, heard):
        """Call heard(gpio, state) at each change of the chip's side of a pin: 0, 1 or RELEASED."""
        self._listeners.setdefault(gpio, []).append(heard)

    def state_of(self, gpio):
        """Return the level that the chip drives: 0, 1 or RELEASED."""
        return min(int(self._chip.gpio[gpio].value), RELEASED)

    def drive_pin(self, gpio, level):
        """Drive a pin from outside to `level`; None lets go, and the pull decides."""
        if level is None:
            self._outside.pop(gpio, None)
        else:
            self._outside[gpio] = bool(level)
        if gpio not in self._driven:
            self._let_go(self._chip.gpio[gpio])

    def after_reset(self):
        """Release the chip's outputs, and tell the listeners."""
        for gpio in sorted(self._driven):
            pin = self._chip.gpio[gpio]
            pin._driven, pin._raw_input_value = gpio in self._outside, self._outside.get(gpio, False)
        let_go, self._driven = sorted(self._driven), set()
        for gpio in let_go:
            self._call_listeners(gpio, RELEASED)

    def _make_listener(self, pin):
        """Return the listener of one pin: it keeps the driven pins, loops outputs back to their inputs and calls Pads' own listeners."""
        gpio = pin.index

        def note_state(state, _):
            """Note a pin's new output state: 0 or 1 driven, above that released."""
            if state > 1:
                if gpio in self._driven:
                    self._driven.discard(gpio)
                    self._let_go(pin)
                    self._call_listeners(gpio, RELEASED)
                return
            self._driven.add(gpio)
            if self._loop_back:
                self._set_input(pin, bool(state))
            self._call_listeners(gpio, int(state))

        return note_state

    def _call_listeners(self, gpio, state):
        for heard in self._listeners.get(gpio, ()):
            heard(gpio, state)

    def _let_go(self, pin):
        """Give a released pin the level from outside if there is one, else that of its pull; without a pull, or with both, the level stays."""
        level = self._outside.get(pin.index)
        if level is not None:
            self._set_input(pin, level)
            return
        up, down = pin.pullup_enabled, pin.pulldown_enabled
        if up == down or up == bool(pin._raw_input_value):
            pin._driven = False  # the level stays
        else:
            self._set_input(pin, up)
            pin._driven = False

    def _set_input(self, pin, level):
        """Set the level that a pin reads. The PIO blocks run up to now first."""
        if pin._driven and pin._raw_input_value == level:
            return
        pios = self._chip.pio
        for pio in pios:
            pio.input_changes(pin.index)
        pin.set_input_value(level)
        for pio in pios:
            pio.input_changed()
