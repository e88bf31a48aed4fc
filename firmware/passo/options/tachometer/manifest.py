"""The key `tachometer`: pulses of the spindle."""

from passo.commands import INPUTS
from passo.config.board_error import BoardError, want_input
from passo.records import REGISTER_BIT

RULES = {
    "tachometer": {
        "input": (str, ..., 1, 16),  # that its pulses come on
        "pulses": (int, 1, 1, 1000),  # a turn
        "at_speed_percent": (int, 10, 1, 50),
        "spin_up_ms": (int, 10_000, 100, 120_000),  # by then it has to be at speed
    },
}


def check(board):
    """Check the input and the rate of its pulses; add the feature. Raises BoardError."""
    config = board["tachometer"]
    name = config["input"]
    want_input(board, "tachometer.input", name)
    item = [item for item in board["inputs"] if item["name"] == name][0]
    named = str(board["homing"]) + str(board.get("interlock"))
    if item["pin"] >= REGISTER_BIT or item["halt"] or name in named or name in [row[0] for row in INPUTS]:
        raise BoardError("tachometer.input: %s needs a pin of its own, and no other use" % name)
    if board.get("inverter") or board["spindle"]["laser"]:
        raise BoardError("tachometer: the inverter says the speed itself; a laser has none")
    if config["pulses"] * board["spindle"]["max_rpm"] > 300_000:
        raise BoardError("tachometer.pulses: no more than 5000 a second: %d a turn" % (300_000 // board["spindle"]["max_rpm"]))
    board["additions"].features["tachometer"] = "passo.options.tachometer.control", "Tachometer"
