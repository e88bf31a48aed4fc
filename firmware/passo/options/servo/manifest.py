"""The key `servo`: a servo lifts the pen."""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN

RULES = {
    "servo": {
        "pin": PIN,
        "up_us": (int, 1000, 400, 2600),  # pulses
        "down_us": (int, 1500, 400, 2600),
        "up_ms": (int, 100, 0, 5000),  # all the way
        "down_ms": (int, 200, 0, 5000),
        "by_s": (bool, False, 0, 1),
    },
}


def claims(board):
    """Return the servo's pin: [(pin, who)]."""
    return [(board["servo"]["pin"], "servo pin")]


def check(board):
    """Check that tool.on_ms and tool.off_ms last as long as the servo; add the feature. Raises BoardError."""
    config = board["servo"]
    for way, wait in (("down_ms", "on_ms"), ("up_ms", "off_ms")):
        least = config[way] + 20  # until the next pulse
        if board["tool"][wait] < least:
            raise BoardError("tool.%s: the servo takes %d ms" % (wait, least))
    if board["spindle"]["pwm"] or board["spindle"]["laser"]:
        raise BoardError("servo: it is the tool; leave out spindle.pwm and spindle.laser")
    if config["by_s"] and [link for link in board["links"] if link["protocol"] != "grbl"]:
        raise BoardError("servo.by_s: only links that speak grbl know S")
    board["additions"].features["servo"] = "passo.options.servo.control", "PenServo"
