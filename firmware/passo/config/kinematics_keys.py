"""The key `kinematics`: how motors move axes. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

RULES = {
    "kinematics": ("none", "corexy"),  # a module of motion; "none": each motor moves its own axis
    "motion": (str, "", 0, 16),  # the same for the machine, "" if none: a name that no other board's firmware has to learn
}


def check(board):
    kind = board["kinematics"]
    board["motion"] = "" if kind == "none" else kind
    if kind == "none":
        return
    for other in ("gantry", "encoders", "weaving", "step_program"):
        if board[other]:
            raise BoardError("kinematics: there is no %s with it" % other)
    if board["homing"] and board["homing"]["latch"]:
        raise BoardError("kinematics: there is no homing.latch with it")
    spoken = [link["protocol"] for link in board["links"]]
    for protocol in spoken:
        if protocol not in ("grbl", "plotter"):
            raise BoardError("kinematics: the language %s moves one axis by one motor" % protocol)
    if "grbl" not in spoken:
        raise BoardError("kinematics: a link that speaks grbl is wanted")
    axes = board["axes"]
    if len(axes) < 2 or axes[0]["steps_per_m"] != axes[1]["steps_per_m"]:
        raise BoardError("kinematics: two axes with the same steps_per_m are wanted")
