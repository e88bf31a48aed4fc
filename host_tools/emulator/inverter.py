"""A frequency inverter at the UART of an emulated Pico.

    inverter = WiredInverter(pico, board["inverter"])
    inverter.model.hz, inverter.model.way, inverter.model.silent = …      # a SimInverter

Bytes that the Pico sends are a frame once the line has been silent for 3.5 characters, as Modbus RTU has it. Replies go back
at the wire's pace.
"""

from host_tools.emulator import cycles
from host_tools.emulator.wire import BITS_A_BYTE
from host_tools.sim.inverter import REPLY_MS, SimInverter

_GAP_CHARACTERS = 3.5


class WiredInverter:
    def __init__(self, pico, config):
        self._pico = pico
        self._baud = config["baud"]
        self.model = SimInverter(config, lambda: pico.now_us / 1000)
        self.wire = pico.uart(int(config["port"][4:]))
        self.wire.listeners.append(self._take_byte)
        self._frame = bytearray()
        self._gap = pico.chip.clock.create_alarm(self._end_frame)

    def _take_byte(self, value):
        self._frame.append(value)
        self._gap.schedule(_GAP_CHARACTERS * BITS_A_BYTE * 1_000_000_000 / self._baud)

    def _end_frame(self):
        frame, self._frame = bytes(self._frame), bytearray()
        self.model.write(frame)
        self._pico.call_at(self._pico.cycle + (REPLY_MS + 1) * 1_000_000 // cycles.CYCLE_NS, self._send_reply)

    def _send_reply(self):
        reply = self.model.read()
        if reply:
            self.wire.feed(reply, self._baud)
