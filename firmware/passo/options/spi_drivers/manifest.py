"""The key `spi_drivers`: TMC2130 or TMC5160 drivers that are set up over SPI. Only loaded if the board file has it."""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN
from passo.options.drivers.manifest import check_motors, check_stalls, want_step_dir
from passo.options.spi_drivers.config import current_scale

SHARES = ("drivers",)  # the option whose files it shares
NO_STALL = 64
_DRIVER = {
    "axis": (str, ..., 1, 1),
    "cs": (int, ..., 0, 48),  # drivers of one pin are a chain, in this order from `tx` on
    "current_ma": (int, ..., 50, 6000),  # of a coil, RMS
    "hold_percent": (int, 50, 0, 100),  # of it, at rest
    "microsteps": (int, 16, 1, 256),
    "stealth": (bool, True, 0, 1),  # stealthChop; False: spreadCycle
    "stall": (int, NO_STALL, -64, NO_STALL),  # its axis homes by stall: SGT, which 64 is not: it does not
    "stall_ma": (int, 0, 0, 6000),  # meanwhile; 0: current_ma
}
RULES = {
    "spi_drivers": {
        "chip": ("tmc5160", "tmc2130"),
        "sck": PIN,
        "tx": PIN,  # to SDI
        "rx": PIN,  # from SDO
        "sense_mohm": (int, ..., 10, 1000),  # the resistors beside each driver
        "motors": [_DRIVER, 1, 4],
    },
}


def claims(board):
    """Return the pins of the SPI, and each CS: [(pin, who)]."""
    config = board["spi_drivers"]
    pins = [(config[key], "spi_drivers " + key) for key in ("sck", "tx", "rx")]
    return pins + [(pin, "spi_drivers cs") for pin in sorted({motor["cs"] for motor in config["motors"]})]


def check(board):
    """Check drivers and stall homing; add the features. Raises BoardError."""
    config = board["spi_drivers"]
    if board.get("drivers"):
        raise BoardError("spi_drivers: not beside drivers, which are on a UART")
    want_step_dir(board)
    check_motors(board, "spi_drivers", ("axis",), lambda current_ma: current_scale(current_ma, config))
    feel = [motor for motor in config["motors"] if motor["stall"] != NO_STALL]
    if feel:
        check_stalls(board, feel, "spi_drivers")
    board["additions"].features["drives"] = "passo.options.spi_drivers." + ("control_stall" if feel else "control"), "Motors"
