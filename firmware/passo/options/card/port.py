"""A memory card on SPI, with MicroPython's own driver `sdcard` (micropython-lib), and its FAT file system.

    card = port.make("card", board["card"])
    card.mount()                    # at card.path from now on. Raises OSError, ImportError
    open(card.path + "/A")

Mounting takes some 0.1 s, and up to a few seconds if a card is slow to wake: only at a stand. All of it is done anew each time:
another card may have been put in.
"""

import vfs
from machine import SPI, Pin


class Select:
    """The card's chip select, as the driver uses it. The watchdog sees that there is still something going on."""

    OUT = Pin.OUT

    def __init__(self, number, feed):
        self._pin = Pin(number, Pin.OUT, value=1)
        self._feed = feed

    def init(self, mode, value):
        """Do as machine.Pin.init(), which the driver calls once."""
        self._pin.init(mode, value=value)

    def __call__(self, level):
        self._pin(level)
        self._feed()


class MemoryCard:
    path = "/sd"

    def __init__(self, port, config):
        """`config`: the key `card` of a board file; `port`: has feed_watchdog()."""
        self._config = config
        self._select = Select(config["cs"], port.feed_watchdog)

    def mount(self):
        """Mount the card that is in now, at `path`. 0.1 s, up to a few seconds. Raises OSError, ImportError."""
        from sdcard import SDCard

        try:
            vfs.umount(self.path)
        except OSError:
            pass  # the first time
        config = self._config
        spi = SPI(config["spi"], sck=Pin(config["sck"]), mosi=Pin(config["mosi"]), miso=Pin(config["miso"]))
        vfs.mount(vfs.VfsFat(SDCard(spi, self._select)), self.path)


def create(port, inputs, config):
    """Return the MemoryCard."""
    return MemoryCard(port, config)
