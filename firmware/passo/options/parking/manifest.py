"""The key `parking`: the axis that goes up while the door is open, and at a program's end. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input
from passo.options.parking.config import AT_END, AXIS, HEIGHT, ON, PULL_OUT, PULL_OUT_SPEED, SPEED

HEAP_KB = 5  # of a Pico with stock MicroPython
RULES = {
    "parking": {
        "axis": ("z", "x", "y"),
        "target_mm": (int, -5, -2000, 2000),  # machine coordinate, $58
        "mm_min": (int, 500, 1, 100_000),  # $59
        "pull_out_mm": (int, 5, 0, 500),  # $56
        "pull_out_mm_min": (int, 100, 1, 100_000),  # $57
        "at_end": (bool, False, 0, 1),  # M2 and M30 go to the target, too, $142
    },
}


def check(board):
    """Check axis, input and links; add the feature, $41, $42, $56 to $59 and $142. Raises BoardError."""
    config = board["parking"]
    want_input(board, "parking", "door")
    unfit = [other for other in ("encoders", "weaving", "step_program", "interlock") if board.get(other)]
    unfit += [other for other in ("backlash", "kinematics") if board.get(other, "none") not in ("none", {}, "")]
    if unfit:
        raise BoardError("parking: remove %s: it parks one axis, by its own motor" % unfit[0])
    if [link for link in board["links"] if link["protocol"] != "grbl"]:
        raise BoardError("parking: links that speak grbl, and no other, are wanted")
    names = [axis["name"] for axis in board["axes"]]
    if config["axis"] not in names or not board["homing"] or config["axis"] not in board["homing"]["sensors"]:
        raise BoardError("parking: it wants an axis %s that homes" % config["axis"])
    board["additions"].languages.append("passo.options.parking.language_grbl")
    board["additions"].features["pauses"] = "passo.options.parking.control", "Pauses"
    rules = {
        ON: ("parking", 0, 1, 0, 1),
        AXIS: ("parking_axis", 0, names.index(config["axis"]), 0, min(len(names), 3) - 1),
        PULL_OUT: ("parking_pull_out", 3, config["pull_out_mm"] * 1000, 0, 500_000),
        PULL_OUT_SPEED: ("parking_pull_out_speed", 3, config["pull_out_mm_min"] * 1000, 1, 100_000_000),
        HEIGHT: ("parking_target", 3, config["target_mm"] * 1000, -2_000_000, 2_000_000),
        SPEED: ("parking_speed", 3, config["mm_min"] * 1000, 1, 100_000_000),
        AT_END: ("parking_at_end", 0, 1 if config["at_end"] else 0, 0, 1),
    }
    board["additions"].settings.update(rules)
