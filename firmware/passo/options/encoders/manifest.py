"""The key `encoders`: they count what the motors turn. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input

_ENCODER = {
    "motor": (str, ..., 1, 2),  # the axis it is on
    "pins": (list, ..., 2, 2),  # A and B
    "pulses": (int, ..., 1, 5000),  # a turn: four counts each
    "steps": (int, ..., 1, 200_000),  # of the motor, a turn
    "reversed": (bool, False, 0, 1),
    "limit_steps": (int, 8, 1, 1000),  # a following error beyond it stops the machine
    "correct": (bool, False, 0, 1),  # make up for missing steps at the end of a move
    "index": (str, "", 0, 16),  # input of its index pulse
    "settle_ms": (int, 50, 1, 10_000),  # after which a motor at rest has come to rest
}
HEAP_KB = 6  # of a Pico with stock MicroPython
RULES = {
    "encoders": [_ENCODER, 0, 4],
}


def claims(board):
    """Return the pins of the encoders: [(pin, who)]."""
    return [(pin, "input of encoder %s" % item["motor"]) for item in board["encoders"] for pin in item["pins"]]


def check(board):
    """Check each encoder's motor, pins and index input; add feature and port's part. Raises BoardError."""
    if not board["encoders"]:
        return
    motors = [motor["name"] for motor in board["axes"] + board["additions"].more_motors]
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
    if "grbl" in [link["protocol"] for link in board["links"]]:
        board["additions"].languages.append("passo.options.encoders.language_grbl")
    board["additions"].features["encoders"] = "passo.options.encoders.control", "EncoderWatch"
    board["additions"].parts["encoders"] = "passo.options.encoders.port_rp2" if board["chip"].startswith("rp2") else "passo.options.encoders.port_pins"
