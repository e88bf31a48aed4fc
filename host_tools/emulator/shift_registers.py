"""Chains of 74HC165 and 74HC595 at the pins of an emulated Pico, edge by edge, as their data sheets have them.

    chains = Chains(pico, board["registers"], told)     # told(bit, level) as an output of the 74HC595 changes
    chains.set_input(3, 1)                              # input D of the first 74HC165

74HC165: while SH/LD is low the register follows its inputs; while it is high, a rising edge of CLK shifts towards QH. 74HC595: a rising
edge of SRCLK shifts SER in, one of RCLK shows the register at the outputs. Their outputs at power-up are undefined: here 0.
"""


class Chains:
    def __init__(self, pico, config, told):
        self._pico = pico
        self._told = told
        self._in, self._out = config["in"], config["out"]
        self._inputs = [0] * (8 * config["inputs"])
        self._loaded = [0] * len(self._inputs)  # index 0: QH of the first chip, which is shifted out first
        self._shifted = [0] * (8 * config["outputs"])  # index 0: QA of the first chip
        self.outputs = [0] * len(self._shifted)
        self._clock = self._latch = None
        self.transfers = 0
        pico.pads.add_listener(config["clock"], self._on_clock)
        pico.pads.add_listener(config["latch"], self._on_latch)

    def set_input(self, bit, level):
        """Set an input of the 74HC165 chain to 0 or 1."""
        self._inputs[bit] = level
        if self._latch == 0:
            self._load_inputs()

    def input_level(self, bit):
        """Return the level of an input of the 74HC165 chain."""
        return self._inputs[bit]

    def _load_inputs(self):
        """Load the 74HC165: H, the input of bit 7, is shifted out first."""
        self._loaded = [self._inputs[at & ~7 | 7 - at & 7] for at in range(len(self._inputs))]
        self._show_first()

    def _show_first(self):
        if self._loaded:
            self._pico.drive_pin(self._in, self._loaded[0])

    def _on_clock(self, _, state):
        """Shift the chains by one bit at the clock's rising edge, that of the 74HC165 only while the latch is high."""
        rising = state == 1 and self._clock == 0
        self._clock = state
        if not rising:
            return
        if self._shifted:
            ser = 1 if self._pico.pads.state_of(self._out) == 1 else 0
            self._shifted = [ser, *self._shifted[:-1]]
        if self._latch == 1:
            self._loaded = [*self._loaded[1:], 0] if self._loaded else []
            self._show_first()

    def _on_latch(self, _, state):
        """Load the inputs (74HC165) while the latch is low; as it rises take over the outputs (74HC595), and report each that has changed."""
        rising = state == 1 and self._latch == 0
        self._latch = state
        if state == 0:
            self._load_inputs()
        if rising:
            self.transfers += 1
            for bit, level in enumerate(self._shifted):
                if level != self.outputs[bit]:
                    self.outputs[bit] = level
                    self._told(bit, level)
