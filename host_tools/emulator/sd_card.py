"""A memory card (SDHC) on a SPI of an emulated Pico, as the SD specification has it for SPI mode.

    card = SdCard(pico, board["card"], bytearray(4 << 20))     # the bytes on it, kept up to date: multiples of 512 KiB
    card.inside = False                                         # taken out: DO floats, and is pulled up

Commands 0, 8, 9, 12, 16, 17, 18, 24, 25, 55, 58 and ACMD41; checksums of commands 0 and 8, as a card checks them. A block that is
written keeps it busy for `WRITE_BYTES` bytes of clock.
"""

from collections import deque

SECTOR = 512
WRITE_BYTES = 100
_CSD_UNIT = 512 * 1024
_IDLE, _ILLEGAL, _BAD_CRC = 0x01, 0x04, 0x08
_TOKEN, _TOKEN_MANY, _TOKEN_STOP = 0xFE, 0xFC, 0xFD
_ACCEPTED = 0x05
_HIGH = 0xFF


def _crc7(data):
    """Return a command's last byte: the CRC7 of `data` in the upper seven bits, and the end bit, as the SD specification has it."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x12 if crc & 0x80 else 0)) & 0xFF
    return crc | 1


class SdCard:
    def __init__(self, pico, config, data):
        if len(data) % _CSD_UNIT or not data:
            raise ValueError("a card has a multiple of 512 KiB")
        self.data = data
        self.inside = True
        self.reads = self.writes = 0  # sectors
        self._spi = pico.chip.spi[config["spi"]]
        self._selected = False
        self._power_up()
        self._shifted = pico.chip.clock.create_alarm(self._end_byte)
        self._spi.on_transmit = self._transmit_byte
        pico.pads.add_listener(config["cs"], self._on_select)
        self._reply = _HIGH

    def _power_up(self):
        """Set the card as it is after power-up: idle, no command, no block under way."""
        self._idle = True
        self._asked = 0  # times for ACMD41
        self._application = False
        self._command = bytearray()
        self._out = deque()
        self._reading = None  # the next sector of a read of many
        self._writing = None  # the next sector to be written
        self._many = False
        self._block = None  # bytes of the block that comes

    def _on_select(self, _, state):
        self._selected = state == 0
        self._command.clear()

    def _transmit_byte(self, value):
        """Exchange a byte with the Pico, in eight SPI clocks; with no card inside or none selected it reads high bits."""
        self._reply = self._exchange_byte(value) if self.inside and self._selected else _HIGH
        if not self.inside:
            self._power_up()
        self._shifted.schedule(8e9 / self._spi.clock_frequency)

    def _end_byte(self):
        self._spi.complete_transmit(self._reply)

    def _exchange_byte(self, value):
        """Return the byte that goes out while `value` comes in."""
        if not self._out and self._reading is not None:
            self._put_block(self._read_sector(self._reading))
            self._reading += 1
        reply = self._out.popleft() if self._out else _HIGH
        if self._block is not None:
            self._take_block_byte(value)
        elif self._command or value & 0xC0 == 0x40:
            self._command.append(value)
            if len(self._command) == 6:
                self._obey_command(bytes(self._command))
                self._command.clear()
        elif self._writing is not None:
            if value == (_TOKEN_MANY if self._many else _TOKEN):
                self._block = bytearray()
            elif value == _TOKEN_STOP and self._many:
                self._writing = None
                self._out.extend([_HIGH] + [0] * WRITE_BYTES)
        return reply

    def _take_block_byte(self, value):
        """Take a byte of the block that comes; write the sector once it is whole."""
        self._block.append(value)
        if len(self._block) < SECTOR + 2:
            return
        at = self._writing * SECTOR
        self.data[at : at + SECTOR] = self._block[:SECTOR]
        self.writes += 1
        self._block = None
        self._writing = self._writing + 1 if self._many else None
        self._out.extend([0xE0 | _ACCEPTED] + [0] * WRITE_BYTES)

    def _read_sector(self, number):
        self.reads += 1
        return self.data[number * SECTOR : (number + 1) * SECTOR]

    def _put_block(self, data):
        self._out.extend([_HIGH, _TOKEN, *data, 0, 0])

    def _csd_register(self):
        """Return the card's CSD register of version 2, 16 bytes: its size in units of 512 KiB, all else 0."""
        units = len(self.data) // _CSD_UNIT - 1
        csd = bytearray(16)
        csd[0] = 0x40
        csd[7:10] = units.to_bytes(3, "big")
        return csd

    def _obey_command(self, command):
        """Queue the answer to a command of 6 bytes (number, argument, CRC7), and begin the read or write that it asks for."""
        number, argument = command[0] & 0x3F, int.from_bytes(command[1:5], "big")
        application, self._application = self._application, False
        self._reading = None
        self._out.clear()
        self._out.append(_HIGH)
        if number == 12:
            self._out.append(_HIGH)  # a byte of stuffing
        if number in (0, 8) and command[5] != _crc7(command[:5]):
            self._out.append(_BAD_CRC | self._idle)
            return
        if number == 0:
            self._power_up()
            self._out.extend([_HIGH, _IDLE])
        elif number == 8:
            self._out.extend([_IDLE, *command[1:5]])
        elif number == 55:
            self._application = True
            self._out.append(int(self._idle))
        elif number == 41 and application:
            self._asked += 1
            self._idle = self._asked < 3
            self._out.append(int(self._idle))
        elif number == 58:
            self._out.extend([int(self._idle), 0x40 if self._idle else 0xC0, 0xFF, 0x80, 0])
        elif self._idle or number not in (9, 12, 16, 17, 18, 24, 25):
            self._out.append(_ILLEGAL | self._idle)
        else:
            self._out.append(0)
            if number == 9:
                self._put_block(self._csd_register())
            elif number == 17:
                self._put_block(self._read_sector(argument))
            elif number == 18:
                self._reading = argument
            elif number in (24, 25):
                self._writing, self._many = argument, number == 25
