"""The keys `encoders` and `gantry` of a board file: only boards that have one of them load this. RULES are in the notation of
boardfile.py."""

from passo.config.board_error import BoardError, want_input

GANTRY = {
    "axis": (str, ..., 1, 1),
    "pins": (list, ..., 2, 2),  # STEP and DIR of the second motor
    "opposite": (bool, False, 0, 1),  # it turns the other way round
    "wait_steps": (int, 4, 0, 1000),  # from this lag on a move waits
    "limit_steps": (int, 20, 1, 1000),  # a lag beyond it stops the machine
    "sensor": (str, "", 0, 16),  # homing's, of the second side
    "offset_steps": (int, 0, -10_000, 10_000),  # how much farther than its sensor's edge the second side stands when square
    "rack_steps": (int, 200, 1, 10_000),  # how far homing moves one side alone
}
ENCODER = {
    "motor": (str, ..., 1, 2),  # the axis it is on
    "pins": (list, ..., 2, 2),  # A and B
    "pulses": (int, ..., 1, 5000),  # a turn: four counts each
    "steps": (int, ..., 1, 200_000),  # of the motor, a turn
    "reversed": (bool, False, 0, 1),
    "limit_steps": (int, 8, 1, 1000),  # a following error beyond it stops the machine
    "correct": (bool, False, 0, 1),  # make up for what is missing at the end of a move
    "index": (str, "", 0, 16),  # input of its index pulse
    "settle_ms": (int, 50, 1, 10_000),  # after which a motor at rest has come to rest
}
RULES = {"encoders": [ENCODER, 0, 4], "gantry": GANTRY}


def check(board):
    if board["gantry"]:
        _check_gantry(board, board["gantry"])
    _check_encoders(board)


def _check_gantry(board, gantry):
    axis = gantry["axis"]
    if axis not in [item["name"] for item in board["axes"]]:
        raise BoardError("gantry.axis: there is no axis %r" % axis)
    if board["drive"]["kind"] != "step_dir":
        raise BoardError("gantry: two motors on one axis want a step_dir drive, pins [STEP, DIR]")
    if gantry["sensor"] and not (board["homing"] and axis in board["homing"]["sensors"]):
        raise BoardError("gantry.sensor: axis %s has none of its own in homing.sensors" % axis)
    if gantry["sensor"]:
        want_input(board, "gantry.sensor", gantry["sensor"])
    if abs(gantry["offset_steps"]) > gantry["rack_steps"]:
        raise BoardError("gantry.offset_steps: no more than rack_steps")
    pair = [item for item in board["encoders"] if item["motor"] in (axis, axis + "2")]
    if len(pair) == 2 and (pair[0]["pulses"], pair[0]["steps"]) != (pair[1]["pulses"], pair[1]["steps"]):
        raise BoardError("encoders: those of a gantry have the same pulses and steps")


def _check_encoders(board):
    """Each motor has one; on an rp2 chip PIO block 1 counts them, pins side by side."""
    motors = [axis["name"] for axis in board["axes"]]
    gantry = board["gantry"]
    if gantry:
        motors.append(gantry["axis"] + "2")
    named = [item["motor"] for item in board["encoders"]]
    for item in board["encoders"]:
        motor = item["motor"]
        if motor not in motors or named.count(motor) > 1:
            raise BoardError("encoders: %r has to be one of %s, each once" % (motor, ", ".join(motors)))
        if board["drive"]["kind"] != "step_dir":
            raise BoardError("encoder %s: encoders want a step_dir drive" % motor)
        if item["index"]:
            want_input(board, "encoder " + motor, item["index"])
        a, b = item["pins"]
        if board["chip"].startswith("rp2") and b != a + 1:
            raise BoardError("encoder %s: its PIO program wants B on the pin next to A, [%d, %d]" % (motor, a, a + 1))
