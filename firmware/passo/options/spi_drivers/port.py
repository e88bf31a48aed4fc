"""SPI to motor drivers, on any pins, by MicroPython's own software.

    line = port.make("spi_drivers", board["spi_drivers"])
    line.exchange(13, data)         # pin 13 low meanwhile; returns what comes back, as many bytes
"""

from machine import Pin, SoftSPI

_HZ = 1_000_000  # a driver takes 4 MHz


def create(port, inputs, config):
    """Return the SpiLine."""
    return SpiLine(config)


class SpiLine:
    def __init__(self, config):
        self._selects = {motor["cs"]: Pin(motor["cs"], Pin.OUT, value=1) for motor in config["motors"]}
        pins = [Pin(config[key]) for key in ("sck", "tx", "rx")]
        self._spi = SoftSPI(baudrate=_HZ, polarity=1, phase=1, sck=pins[0], mosi=pins[1], miso=pins[2])

    def exchange(self, pin, data):
        """Send `data` with `pin` low. Returns as many bytes, which come back meanwhile."""
        found = bytearray(len(data))
        self._selects[pin](0)
        self._spi.write_readinto(data, found)
        self._selects[pin](1)
        return found
