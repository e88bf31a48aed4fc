"""The key `gantry`: an axis has a motor at each side. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input

HEAP_KB = 2  # of a Pico with stock MicroPython
RULES = {
    "gantry": {
        "axis": (str, ..., 1, 1),
        "pins": (list, ..., 2, 2),  # STEP and DIR of the second motor
        "opposite": (bool, False, 0, 1),  # it turns the other way round
        "wait_steps": (int, 4, 0, 1000),  # from this lag on a move waits
        "limit_steps": (int, 20, 1, 1000),  # a lag beyond it stops the machine
        "sensor": (str, "", 0, 16),  # homing's, of the second side
        "offset_steps": (int, 0, -10_000, 10_000),  # how much farther than its sensor's edge the second side stands when square
        "rack_steps": (int, 200, 1, 10_000),  # how far homing moves one side alone
    },
}


def prepare(board):
    """Add the second motor of the axis, and the drive. Raises BoardError."""
    gantry = board["gantry"]
    axis = gantry["axis"]
    names = [item["name"] for item in board["axes"]]
    if axis not in names:
        raise BoardError("gantry.axis: there is no axis %r" % axis)
    if board["drive"]["kind"] != "step_dir":
        raise BoardError("gantry: two motors on one axis want a step_dir drive, pins [STEP, DIR]")
    motor = {"name": axis + "2", "axis": names.index(axis)}
    motor.update({key: gantry[key] for key in ("pins", "opposite", "sensor")})
    board["additions"].more_motors = [motor]
    board["additions"].drive_module = "passo.options.gantry.drive"


def claims(board):
    """Return the pins of the second motor: [(pin, who)]."""
    return [(pin, "axis %s2" % board["gantry"]["axis"]) for pin in board["gantry"]["pins"]]


def check(board):
    """Check sensor, offset and encoders; add the feature. Raises BoardError."""
    gantry = board["gantry"]
    axis = gantry["axis"]
    if gantry["sensor"] and not (board["homing"] and axis in board["homing"]["sensors"]):
        raise BoardError("gantry.sensor: axis %s has none of its own in homing.sensors" % axis)
    if gantry["sensor"]:
        want_input(board, "gantry.sensor", gantry["sensor"])
    if abs(gantry["offset_steps"]) > gantry["rack_steps"]:
        raise BoardError("gantry.offset_steps: no more than rack_steps")
    pair = [item for item in board.get("encoders", ()) if item["motor"] in (axis, axis + "2")]
    if len(pair) == 2 and (pair[0]["pulses"], pair[0]["steps"]) != (pair[1]["pulses"], pair[1]["steps"]):
        raise BoardError("encoders: those of a gantry have the same pulses and steps")
    board["additions"].features["gantry"] = "passo.options.gantry.control", "GantryWatch"
