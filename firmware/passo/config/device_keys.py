"""The key `inverter` of a board file: only boards that have one load this.

    rules = extended(rules)         # those of boardfile.py, in whose notation they are
    check(board)                    # raises BoardError
"""

from passo.config.board_error import BoardError
from passo.config.chip_pins import check_link

INVERTER = {
    "make": ("delta", "yl620", "h100", "nowforever"),
    "port": (str, ..., 5, 5),
    "tx": (int, ..., 0, 48),
    "rx": (int, ..., 0, 48),
    "baud": (int, 9600, 1200, 115_200),
    "parity": ("none", "even", "odd"),
    "stop_bits": (int, 1, 1, 2),
    "address": (int, 1, 1, 247),
    "poles": (int, 2, 2, 24),  # of the motor: rpm = 120 · Hz / poles
    "timeout_ms": (int, 100, 10, 1000),
    "at_speed_percent": (int, 5, 1, 50),
    "spin_up_ms": (int, 10_000, 100, 120_000),  # by then it has to be at speed
}


def extended(rules):
    """A copy of the rules of a board file, with those of this key."""
    rules = dict(rules)
    rules["inverter"] = INVERTER
    return rules


def check(board):
    _check_inverter(board)


def _check_inverter(board):
    config = board["inverter"]
    if config is None:
        return
    check_link(board["chip"], {"name": "inverter", "port": config["port"], "tx": config["tx"], "rx": config["rx"]})
    for link in board["links"]:
        if link["port"] == config["port"]:
            raise BoardError("inverter: %s is link %s's; take another" % (config["port"], link["name"]))
    if board["spindle"]["pwm"] or board["spindle"]["laser"]:
        raise BoardError("inverter: it sets the spindle's speed; leave out spindle.pwm and spindle.laser")
