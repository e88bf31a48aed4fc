"""Modbus RTU, as much of it as a master needs to speak to an inverter: requests, and the faults of a reply.

    request = make_request(1, READ, 0x2103, 1)        # or WRITE_COIL, WRITE, WRITE_SEVERAL with a value
    reply = bytes of reply_length(request), or of ERROR_LENGTH if the function's high bit is set
    wrong = fault_of(request, reply)                  # 0: good, then value_of(reply)

"MODBUS over serial line", V1.02, section 2.5. Only one register a request; function 16 writes one.
"""

from micropython import const

READ = const(3)  # holding registers
READ_INPUT = const(4)
WRITE_COIL = const(5)
WRITE = const(6)
WRITE_SEVERAL = const(16)

WRONG = const(1)  # CRC, address, function or echo: no reply to this request
REFUSED = const(2)  # an exception, whose code is in reply[2]
_BUSY = const(6)  # an exception code: ask again
ERROR_LENGTH = const(5)


def crc16(data, count):
    """Return the CRC of the first `count` bytes ("MODBUS over serial line" V1.02, 6.2.2); its low byte goes first on the wire."""
    crc = 0xFFFF
    for at in range(count):
        crc ^= data[at]
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc


def make_request(address, function, register, value):
    """Return the bytes of a request; `value`: the value to write, or the number of registers to read."""
    frame = bytes((address, function, register >> 8, register & 255))
    if function == WRITE_SEVERAL:
        frame += b"\x00\x01\x02"
    frame += bytes((value >> 8, value & 255))
    crc = crc16(frame, len(frame))
    return frame + bytes((crc & 255, crc >> 8))


def reply_length(request):
    """Return the bytes of the reply, if it is no exception."""
    return 5 + 2 * request[5] if request[1] in (READ, READ_INPUT) else 8


def fault_of(request, reply):
    """Return 0 for a good reply, WRONG or REFUSED. A device that is busy counts as WRONG: ask again."""
    end = len(reply) - 2
    if end < 3 or crc16(reply, end) != reply[end] | reply[end + 1] << 8 or reply[0] != request[0]:
        return WRONG
    function = request[1]
    if reply[1] == function | 0x80:
        return WRONG if reply[2] == _BUSY else REFUSED
    if reply[1] != function or len(reply) != reply_length(request):
        return WRONG
    if function in (READ, READ_INPUT):
        return 0 if reply[2] == 2 * request[5] else WRONG
    same = 4 if function == WRITE_SEVERAL else 6
    return 0 if bytes(reply[:same]) == request[:same] else WRONG


def value_of(reply):
    """Return the first register of a reply to a read."""
    return reply[3] << 8 | reply[4]
