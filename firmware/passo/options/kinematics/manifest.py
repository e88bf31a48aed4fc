"""The key `kinematics`: how motors move axes. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

RULES = {
    "kinematics": ("none", "corexy"),  # a module of this folder; "none": each motor moves its own axis
}


def check(board):
    """Check the axes, and that no option wants a motor for each of them; add planner and queue. Raises BoardError."""
    kind = board["kinematics"]
    if kind == "none":
        return
    additions = board["additions"]
    additions.motion, additions.queue = "passo.options.kinematics.motion", "passo.options.kinematics.control"
    additions.one_belt = True
    unfit = [other for other in ("gantry", "encoders", "weaving", "step_program", "rotary") if board.get(other)]
    if unfit:
        raise BoardError("kinematics: remove %s: it wants a motor for each axis" % unfit[0])
    spoken = [link["protocol"] for link in board["links"]]
    for protocol in spoken:
        if protocol not in ("grbl", "plotter"):
            raise BoardError("kinematics: the language %s moves one axis by one motor" % protocol)
    if "grbl" not in spoken:
        raise BoardError("kinematics: a link that speaks grbl is wanted")
    axes = board["axes"]
    if len(axes) < 2 or axes[0]["steps_per_m"] != axes[1]["steps_per_m"]:
        raise BoardError("kinematics: two axes with the same steps_per_m are wanted")
