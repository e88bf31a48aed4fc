"""A frequency inverter as the board's serial line sees it: a Modbus RTU device with the registers of its make, and a motor.

    inverter = SimInverter(board["inverter"], lambda: port.now / 12_500)
    lines["inverter"] = inverter
    inverter.hz, inverter.way           # as the motor turns now: hertz; 3 clockwise, 4 counter-clockwise, 0 not driven
    inverter.fault = 7                  # it trips: the motor runs out
    inverter.silent = True              # it does not answer any more; its motor goes on
    inverter.reply_ms = 300             # it answers after this time, one request after the other

Speed changes by RAMP_HZ_S. The test under pymodbus replaces reply_to(), so that pymodbus decodes the frames.
"""

from passo.options.inverter.config import MAKES
from passo.options.inverter import control_modbus as modbus

RAMP_HZ_S = 200
REPLY_MS = 5


class SimInverter:
    def __init__(self, config, now_ms):
        self.make = MAKES[config["make"]]
        self.address = config["address"]
        self.now_ms = now_ms
        self._hz = 0.0
        self.way = 0
        self.asked_hz = 0.0
        self.fault = 0
        self.silent = False
        self.reply_ms = REPLY_MS
        self.requests = []  # as they came
        self._then_ms = now_ms()
        self._due = []  # (ms, bytes)

    @property
    def hz(self):
        self._follow_speed()
        return self._hz

    @hz.setter
    def hz(self, hz):
        self._hz = hz

    # --- the line

    def write(self, data):
        """Take a frame of the board; its reply can be read `reply_ms` later, or never if `silent`."""
        self._follow_speed()
        self.requests.append(bytes(data))
        if not self.silent:
            reply = self.reply_to(bytes(data))
            if reply:
                self._due.append((self.now_ms() + self.reply_ms, reply))

    def read(self):
        """Return the bytes of the replies that have come by now."""
        self._follow_speed()
        data = b""
        while self._due and self._due[0][0] <= self.now_ms():
            data += self._due.pop(0)[1]
        return data

    def any(self):
        return 0

    def select_list(self):
        return []

    def close(self):
        pass

    def reply_to(self, request):
        """Return the reply to a frame, or b"" (Modbus RTU: wrong address or CRC, no reply)."""
        end = len(request) - 2
        if end < 4 or request[0] != self.address or modbus.crc16(request, end) != int.from_bytes(request[end:], "little"):
            return b""
        function = request[1]
        register = int.from_bytes(request[2:4], "big")
        if function in (modbus.READ, modbus.READ_INPUT):
            count = int.from_bytes(request[4:6], "big")
            values = [self.read_register(function, register + n) for n in range(count)]
            reply = bytes((self.address, function, 2 * count)) + b"".join(value.to_bytes(2, "big") for value in values)
        else:
            self.write_register(function, register, int.from_bytes(request[end - 2 : end], "big"))
            reply = request[:6]
        return reply + modbus.crc16(reply, len(reply)).to_bytes(2, "little")

    # --- the registers

    def write_register(self, function, register, value):
        """Write a register or coil: direction, stop or frequency."""
        for name, way in (("forward", 3), ("reverse", 4), ("stop", 0)):
            if self.make[name] == (function, register, value):
                self.way = way if not self.fault else 0
        function_of, register_of, scale = self.make["frequency"]
        if (function, register) == (function_of, register_of):
            self.asked_hz = value / scale

    def read_register(self, function, register):
        """Return the value of a register: output frequency, fault, else 0."""
        if (function, register) == self.make["output"][:2]:
            return round(self.hz * self.make["output"][3])
        if self.make["fault"] and (function, register) == self.make["fault"][:2]:
            return self.fault
        return 0

    def _follow_speed(self):
        """Move the motor's frequency on to now, by RAMP_HZ_S at most."""
        now_ms = self.now_ms()
        step = RAMP_HZ_S * (now_ms - self._then_ms) / 1000
        self._then_ms = now_ms
        if self.fault:
            self.way = 0
        target = self.asked_hz if self.way else 0.0
        self._hz = min(target, self._hz + step) if self._hz < target else max(target, self._hz - step)
