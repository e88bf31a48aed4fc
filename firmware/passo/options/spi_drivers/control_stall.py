"""TMC2130 and TMC5160 drivers, some of which feel where their axis ends: as drivers/control_stall.py has it, by stallGuard2.

While the machine homes a motor that feels has spreadCycle, less current, and in COOLCONF the SGT at which SG_RESULT is 0 as it stalls; the driver
says so on DIAG0 and DIAG1, either of which may be wired. Both are push-pull from the start, so that the pin is low without a stall.
"""

from micropython import const

from passo.options.drivers import control_stall as stall_drives
from passo.options.drivers.control_stall import SLOWEST, TCOOLTHRS
from passo.options.spi_drivers import config as chip
from passo.options.spi_drivers import control as spi_drives

_COOLCONF = const(0x6D)
_SGT = const(0x7F)  # of it, from bit 16 on; no filter: SG_RESULT is new each full step
_TELL = const(0x180)  # of GCONF: DIAG0 and DIAG1 say that the motor stalls
_PUSH = const(0x3000)  # and push and pull, active high


class Motors(stall_drives.Motors, spi_drives.Motors):
    _stealth = False
    # MicroPython looks for a method in all that the first class is made of, and then in the second.
    _open_line = spi_drives.Motors._open_line
    _poll_driver = spi_drives.Motors._poll_driver

    def _register_rows(self, motor, feels):
        """Return the registers of a driver, with those for feeling if it may feel; the two that are read back stay the last."""
        rows = chip.register_rows(motor, self._config)
        if motor["axis"] not in self._stalls:
            return rows
        register, gconf = rows[-2]
        gconf |= _PUSH | _TELL if feels else _PUSH
        felt = (_COOLCONF, (motor["stall"] & _SGT) << 16 if feels else 0), (TCOOLTHRS, SLOWEST if feels else 0)
        return rows[:-2] + felt + ((register, gconf), rows[-1])
