"""TMC2130 and TMC5160 drivers on SPI, with a CS each or in chains: set up and read back at the start, then watched, as in drivers/control.py.

    "spi_drivers": {"chip": "tmc5160", "sck": 10, "tx": 11, "rx": 12, "sense_mohm": 75, "motors": [{"axis": "x", "cs": 13, "current_ma": 1500}]}

SPI has no checksum: so every read is followed by the chip's version, which a wire that is off does not say, and every write has to come back as it
was. Alarms are those of drivers/control.py. A cycle of the main loop asks one driver, 1 ms.
"""

from micropython import const

from passo.options.drivers import control as drives
from passo.options.drivers.control import ASKS
from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_SILENT
from passo.options.spi_drivers import config as chip
from passo.records import COUNT_HALF, COUNT_MASK

_AGAIN_MS = const(20)


class Motors(drives.Motors):
    _kept = False  # whether those that are set up anew have been so all the while

    def _open_line(self, config):
        """Open the SPI, compute the registers of each driver, and sort the drivers into chains."""
        self._config = config
        self._line = self._machine.port.make("spi_drivers", config)
        self._registers = [chip.register_rows(motor, config) for motor in self._motors]
        self._chains = {}  # {cs: numbers of its drivers, the last first: the order in which datagrams are sent}
        for number in range(len(self._motors)):
            pin = self._motors[number]["cs"]
            self._chains[pin] = [number] + self._chains.get(pin, [])

    def _poll_driver(self, now_ms):
        """Set the next driver up, or check it, once it is due. After ASKS attempts without an answer raise an alarm."""
        if (now_ms - self._due_ms) & COUNT_MASK >= COUNT_HALF:
            return
        if not (self._check_driver(now_ms) if self.ready() else self._set_up()):
            self._tries += 1
            self._due_ms = now_ms + _AGAIN_MS
            if self._tries == ASKS:
                self._number = self._silent_driver()
                self._raise_alarm(ALARM_DRIVER_SILENT, "no answer")
        else:
            self._tries = 0

    def _send_datagram(self, data):
        """Return the driver's answer to the datagram before; the others of its chain are asked for their version."""
        pin = self._motors[self._number]["cs"]
        sent = b""
        for number in self._chains[pin]:
            sent += data if number == self._number else chip.make_datagram(chip.IOIN)
        at = chip.BYTES * self._chains[pin].index(self._number) + 1
        self._found = found = self._line.exchange(pin, sent)
        return found[at] << 24 | found[at + 1] << 16 | found[at + 2] << 8 | found[at + 3]

    def _silent_driver(self):
        """Return the number of the driver that is silent: in a chain the one nearest to `rx` of which nothing came, because it lets no reply of those
        before it through."""
        chain = self._chains[self._motors[self._number]["cs"]]
        for index in range(len(chain)):
            part = self._found[chip.BYTES * index : chip.BYTES * (index + 1)]
            if min(part) == max(part):
                return chain[index]
        return self._number

    def _read_register(self, register):
        """Return a register; None if the chip does not say its version behind it."""
        self._send_datagram(chip.make_datagram(register))
        found = self._send_datagram(chip.make_datagram(chip.IOIN))
        version = self._send_datagram(chip.make_datagram(chip.IOIN)) >> 24
        return found if version in chip.VERSIONS.values() or register == chip.IOIN and version not in (0, 255) else None

    def _set_up(self):
        """Set the driver up, and read it back. Returns True if it has answered."""
        found = self._read_register(chip.IOIN)
        if found is None:
            return False
        name = self._config["chip"]
        rows = self._registers[self._number]
        if found >> 24 != chip.VERSIONS[name]:
            self._raise_alarm(ALARM_DRIVER_DIFFERS, "version %02x" % (found >> 24))
            return True
        if name == "tmc5160" and not found & chip.STEPS:
            self._raise_alarm(ALARM_DRIVER_DIFFERS, "SD_MODE is low")
            return True
        state = self._read_register(chip.GSTAT)  # a TMC2130 forgets that it was reset
        if state is None:
            return False
        if self._kept and not self._check_power(state):
            return True
        for register, number in rows:
            self._send_datagram(chip.make_datagram(register, number))
            if self._send_datagram(chip.make_datagram(chip.IOIN)) != number:
                return False
        for register, number in rows[-2:]:
            found = self._read_register(register)
            if found is None:
                return False
            if found != number:
                self._raise_alarm(ALARM_DRIVER_DIFFERS, "register %02x is %x, not %x" % (register, found, number))
                return True
        self._set += 1
        self._number = self._set % len(self._motors)
        return True

    def _check_driver(self, now_ms):
        """Check a driver that is set up. Returns True if it has answered."""
        self._send_datagram(chip.make_datagram(chip.GSTAT))
        state = self._send_datagram(chip.make_datagram(chip.DRV_STATUS))
        status = self._send_datagram(chip.make_datagram(chip.IOIN))
        if self._send_datagram(chip.make_datagram(chip.IOIN)) >> 24 not in chip.VERSIONS.values():
            return False
        if self._check_power(state):
            self._judge_status(chip.fault_bits(status), now_ms)
        return True
