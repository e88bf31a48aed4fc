"""The key `kinematics`: how motors move axes. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

RULES = {
    "kinematics": ("none", "corexy"),  # a module of motion; "none": each motor moves its own axis
    "motion": (str, "", 0, 16),  # set by check() to the module's name, "" if none. The rest of the firmware reads this key: its word is one that
    # all boards have in memory, and `kinematics` would take room in boards without it
    "queue": (str, "mapped_queue", 0, 16),  # the module of control with its queue
}


def check(board):
    kind = board["kinematics"]
    if kind == "none":
        return
    board["motion"] = kind
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
