"""The key `inverter`: the spindle's frequency inverter, over Modbus."""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN, check_link

HEAP_KB = 6  # of a Pico with stock MicroPython
RULES = {
    "inverter": {
        "make": ("delta", "yl620", "h100", "nowforever", "teco"),
        "port": (str, ..., 5, 5),
        "tx": PIN,
        "rx": PIN,
        "baud": (int, 9600, 1200, 115_200),
        "parity": ("none", "even", "odd"),
        "stop_bits": (int, 1, 1, 2),
        "address": (int, 1, 1, 247),
        "poles": (int, 2, 2, 24),  # of the motor: rpm = 120 · Hz / poles
        "timeout_ms": (int, 100, 10, 1000),
        "at_speed_percent": (int, 5, 1, 50),
        "spin_up_ms": (int, 10_000, 100, 120_000),  # by then it has to be at speed
    },
}


def claims(board):
    """Return the pins of the UART: [(pin, who)]."""
    return [(board["inverter"][key], "inverter " + key) for key in ("tx", "rx")]


def check(board):
    """Check the UART, and that nothing else sets the speed; add the feature. Raises BoardError."""
    config = board["inverter"]
    check_link(board["chip"], dict(config, name="inverter"))
    for link in board["links"]:
        if link["port"] == config["port"]:
            raise BoardError("inverter: %s is link %s's; take another" % (config["port"], link["name"]))
    if board["spindle"]["pwm"] or board["spindle"]["laser"]:
        raise BoardError("inverter: it sets the spindle's speed; leave out spindle.pwm and spindle.laser")
    board["additions"].features["inverter"] = "passo.options.inverter.control", "Inverter"
