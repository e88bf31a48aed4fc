"""Modbus frames: requests as the standard has them, and which replies count."""

from passo.options.inverter import control_modbus as modbus
from passo.options.inverter.config import MAKES

CASES = {
    "check_only_the_right_reply_counts": (
        ("function", 3, 6), ("register", 0, 0xFFFF), ("value", 0, 0xFFFF), ("at", 0, 7), ("bit", 0, 7),
    )
}  # fmt: skip


def check_known_frames():
    """From "MODBUS over serial line" V1.02 and the manual of the VFD-VE."""
    assert modbus.make_request(1, modbus.READ, 0x2102, 2) == bytes((1, 3, 0x21, 2, 0, 2, 0x6F, 0xF7))
    assert modbus.make_request(1, modbus.READ, 0, 10) == bytes((1, 3, 0, 0, 0, 10, 0xC5, 0xCD))
    assert modbus.make_request(2, modbus.READ, 7, 1)[:2] == bytes((2, 3))
    reply = bytes((1, 3, 4, 0x17, 0x70, 0, 0, 0xFE, 0x5C))
    request = modbus.make_request(1, modbus.READ, 0x2102, 2)
    assert modbus.reply_length(request) == len(reply)
    assert modbus.fault_of(request, reply) == 0 and modbus.value_of(reply) == 6000
    refused = bytes((1, 0x86, 2, 0xC3, 0xA1))
    assert modbus.fault_of(modbus.make_request(1, modbus.WRITE, 0x2000, 1), refused) == modbus.REFUSED


def signed(frame):
    crc = modbus.crc16(frame, len(frame))
    return frame + bytes((crc & 255, crc >> 8))


def check_only_the_right_reply_counts(function, register, value, at, bit):
    read = function in (modbus.READ, modbus.READ_INPUT)
    request = modbus.make_request(1, function, register, 1 if read else value)
    reply = signed(bytes((1, function, 2, value >> 8, value & 255))) if read else request
    assert modbus.fault_of(request, reply) == 0 and len(reply) == modbus.reply_length(request)
    at = min(at, len(reply) - 1)
    wrong = bytearray(reply)
    wrong[at] ^= 1 << bit
    assert modbus.fault_of(request, wrong) == modbus.WRONG, "one bit is found by the CRC"
    assert modbus.fault_of(request, reply[:at]) == modbus.WRONG
    if at != 2 and not (read and at > 2):
        other = signed(bytes(wrong[:-2]))
        if at < len(reply) - 2 and not wrong[1] & 0x80:
            assert modbus.fault_of(request, other) == modbus.WRONG, "another's reply"
    busy = signed(bytes((1, function | 0x80, 6)))
    assert modbus.fault_of(request, busy) == modbus.WRONG


def check_makes():
    """Every make has all that is asked of it, in numbers that fit a frame."""
    for make in MAKES.values():
        for name in ("forward", "reverse", "stop"):
            function, register, value = make[name]
            assert function in (modbus.WRITE_COIL, modbus.WRITE, modbus.WRITE_SEVERAL)
            assert 0 <= register <= 0xFFFF and 0 <= value <= 0xFFFF
        assert make["frequency"][2] in (10, 100) and make["output"][3] in (10, 100)
        assert len({make[name] for name in ("forward", "reverse", "stop")}) == 3
