"""The wires between an emulated Pico and a plant.

    wiring = Wiring(pico, board, world)         # world: a Plant, or a VcdTap before one

The world sees electrical levels, by tick (ten cycles). A pin that the Pico does not drive rests at its inactive level,
as a driver's own pull resistor would hold it. Edges less than a tick apart are one event, as they are for motors.
"""

from host_tools.emulator import cycles
from host_tools.emulator.quadrature import Quadrature
from host_tools.emulator.shift_registers import Chains
from passo.machine_builder import make_drive
from passo.records import REGISTER_BIT
from passo.steps.wiring import inversion_mask, word_pins

ENCODER_COUNTS_S = 500_000  # within a step
SETTLE_CYCLES = 9  # edges of one tick at 125 MHz, from wherever they start


class Wiring:
    """`board` as `passo.config.boardfile.check` returns it."""

    def __init__(self, pico, board, world, plant):
        layout = make_drive(board)[0]
        self._pico = pico
        self._clock = pico.chip.clock
        self._world = world
        self._rest = inversion_mask(board, layout)  # levels of pins that nobody drives
        self._levels = self._seen = self._rest
        self._since = None  # tick of the first edge that the world does not know
        self.edge_count = 0
        self._flush_alarm = self._clock.create_alarm(self._flush_edges)
        self._event_alarm = self._clock.create_alarm(self._on_event)
        self._inputs = {item["name"]: item["pin"] for item in board["inputs"]}
        self._outputs = {item["pin"]: (item["name"], 1 - item["active"]) for item in board["outputs"]}
        world.attach(self.tick, layout.pin_names, self._rest)
        self._bits = {gpio: 1 << bit for bit, gpio in enumerate(word_pins(board))}
        for gpio in self._bits:
            pico.pads.add_listener(gpio, self._on_pin)
        for gpio in self._outputs:
            if gpio < REGISTER_BIT:
                pico.pads.add_listener(gpio, self._on_output)
        if board.get("servo"):
            self._servo_us = self._rose = None
            pico.pads.add_listener(board["servo"]["pin"], self._on_servo)
        self.chains = None
        if board.get("registers"):
            self.chains = Chains(pico, board["registers"], lambda bit, level: self._on_output(REGISTER_BIT + bit, level))
            self._edges = [(item["pin"], item["inputs"].split()) for item in board["registers"]["edges"]]
        self._inner = plant.pins  # told of changes before
        plant.pins = self
        for name, gpio in self._inputs.items():
            self._drive_input(gpio, world.input(self.tick, name))
        self._encoders = [
            (plant.encoders[item["motor"]], Quadrature(pico, item["pins"][0], ENCODER_COUNTS_S)) for item in board.get("encoders", ())
        ]

    @property
    def tick(self):
        """Ticks of 80 ns since power-on."""
        return cycles.now_cycles(self._clock) // cycles.CYCLES_PER_TICK

    def unplug(self):
        """Release every pin, as without power."""
        self._levels = self._rest
        self._flush_edges()

    def note_input(self, tick, name, level):
        """Take a changed input from the plant: drive its pin."""
        if self._inner is not None:
            self._inner.note_input(tick, name, level)
        self._drive_input(self._inputs[name], level)

    def _drive_input(self, gpio, level):
        """Set an input's pin, or its bit of a register and the pins that diodes connect to it."""
        if gpio >= REGISTER_BIT:
            self.chains.set_input(gpio - REGISTER_BIT, level)
            for pin, names in self._edges:  # diodes
                bits = [self._inputs[name] - REGISTER_BIT for name in names]
                if gpio - REGISTER_BIT in bits:
                    self._pico.drive_pin(pin, max(self.chains.input_level(bit) for bit in bits))
        else:
            self._pico.drive_pin(gpio, level)

    def _on_pin(self, gpio, state):
        """Note the new level of a pin of the player; edges within SETTLE_CYCLES go to the world as one."""
        bit = self._bits[gpio]
        level = bit if state == 1 else 0 if state == 0 else self._rest & bit
        levels = self._levels & ~bit | level
        if levels != self._levels:
            if self._since is None:
                self._since = self.tick
                self._flush_alarm.schedule(SETTLE_CYCLES * cycles.CYCLE_NS)
            self._levels = levels

    def _flush_edges(self):
        """Give the world the edges gathered, with the tick of the first."""
        tick, self._since = self._since, None
        changed = self._levels ^ self._seen
        if changed:
            self._seen = self._levels
            self.edge_count += 1
            self._world.edges(self.tick if tick is None else tick, self._levels, changed)
            self.turn_encoders()
            self._plan_event()

    def turn_encoders(self):
        """Turn the encoders' wires to the positions of the plant's motors, which jump by whole steps."""
        for encoder, wires in self._encoders:
            wires.turn_by(encoder.count - wires.count - wires.left)

    def _on_output(self, gpio, state):
        """Give the world the new level of an output; a released pin counts as inactive."""
        self._flush_edges()
        if gpio not in self._outputs:
            return  # a bit of a register that nothing is wired to
        name, inactive = self._outputs[gpio]
        self._world.output(self.tick, name, state if state < 2 else inactive)

    def _on_servo(self, _, state):
        """Tell the world the length of a pulse, if it is another one."""
        if state == 1:
            self._rose = cycles.now_cycles(self._clock)
        elif self._rose is not None:
            us = round((cycles.now_cycles(self._clock) - self._rose) / cycles.CYCLES_PER_US)
            self._rose = None
            if us != self._servo_us:
                self._flush_edges()
                self._servo_us = us
                self._world.servo(self.tick, us)

    def _on_event(self):
        self._flush_edges()
        self._world.run(self.tick)
        self._plan_event()

    def _plan_event(self):
        """Set the alarm for the world's next event, or cancel it if there is none."""
        due = self._world.next_event()
        if due is None:
            self._event_alarm.cancel()
        else:
            self._event_alarm.schedule(max(0.0, due * cycles.CYCLES_PER_TICK * cycles.CYCLE_NS - self._clock.nanos))
