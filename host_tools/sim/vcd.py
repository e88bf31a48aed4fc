"""Pins on a VCD file, for GTKWave or PulseView.

    world = VcdTap("job.vcd", plant)      # between a port and its plant
    port = VirtualPort(board, world)
    world.close()

Every pin is a wire with its board file's name: the player's, the outputs and the inputs. The timescale is 1 ns, the
levels are electrical.
"""

from vcd import VCDWriter

NS_PER_TICK = 80
MODULE = "passo"


class VcdTap:
    """Records the calls between a port and `plant`, and passes them on."""

    def __init__(self, path, board, plant):
        self._file = open(path, "w", encoding="ascii", newline="\n")
        self._writer = VCDWriter(self._file, timescale="1 ns", version="passo board", date="", check_values=False)
        self._plant = plant
        self._pins = []
        self._others = {}
        for item in board.get("outputs", ()):
            self._others[item["name"]] = self._add_wire(item["name"], 1 - item.get("active", 1))
        for item in board.get("inputs", ()):
            self._others[item["name"]] = self._add_wire(item["name"], plant.input(0, item["name"]))
        self._power = None
        if (board.get("spindle") or {}).get("pwm"):
            self._power = self._writer.register_var(MODULE, "power", "integer", size=16, init=0)
        self._servo = None
        if board.get("servo"):
            self._servo = self._writer.register_var(MODULE, "servo_us", "integer", size=16, init=0)
        plant.pins = self
        self.run = plant.run
        self.next_event = plant.next_event
        self.listen = plant.listen
        self.encoder = plant.encoder
        self.pulses = plant.pulses
        self._pass_edges = plant.edges

    def attach(self, tick, names, levels):
        self._pins = [(1 << bit, self._add_wire(name, levels >> bit & 1)) for bit, name in enumerate(names)]
        self._plant.attach(tick, names, levels)

    def edges(self, tick, levels, changed):
        """Pass edges on to the plant, and write the changed pins to the file."""
        # The plant first: chatter that was due before this edge goes down before it.
        self._pass_edges(tick, levels, changed)
        for mask, wire in self._pins:
            if changed & mask:
                self._write_change(tick, wire, 1 if levels & mask else 0)

    def power(self, tick, level):
        if self._power is not None:
            self._write_change(tick, self._power, level)
        self._plant.power(tick, level)

    def servo(self, tick, us):
        self._write_change(tick, self._servo, us)
        self._plant.servo(tick, us)

    def output(self, tick, name, level):
        self._write_change(tick, self._others[name], level)
        self._plant.output(tick, name, level)

    def input(self, tick, name):
        return self._plant.input(tick, name)

    def note_input(self, tick, name, level):
        """Called by the plant if an input has changed."""
        self._write_change(tick, self._others[name], level)

    def flush(self):
        self._writer.flush()

    def close(self):
        self._writer.close()
        self._file.close()

    def _add_wire(self, name, level):
        return self._writer.register_var(MODULE, name, "wire", size=1, init=level)

    def _write_change(self, tick, wire, level):
        self._writer.change(wire, tick * NS_PER_TICK, level)
