"""The key `backlash`: the lost motion of each axis, and the settings $160 to $163. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

MOST_UM = 2000
HEAP_KB = 6  # of a Pico with stock MicroPython
RULES = {
    "backlash": (dict, {}, 1, 4),  # by axis, in µm; 0: not known yet, see $160
}


def check(board):
    """Check the play of each axis, in µm; add $160 to $163, the planner and the queue. Raises BoardError."""
    if board.get("kinematics", "none") != "none":
        raise BoardError("backlash: remove kinematics: backlash is taken up where each motor moves its own axis")
    if board.get("rotary"):
        raise BoardError("backlash: remove rotary: a feed counts for all axes where backlash is taken up")
    unfit = [other for other in ("encoders", "weaving", "step_program") if board.get(other)]
    if unfit:
        raise BoardError("backlash: remove %s: it reckons with motors that have none" % unfit[0])
    spoken = [link["protocol"] for link in board["links"]]
    for protocol in spoken:
        if protocol not in ("grbl", "plotter"):
            raise BoardError("backlash: the language %s moves by single steps, which take up none" % protocol)
    if "grbl" not in spoken:
        raise BoardError("backlash: a link that speaks grbl is wanted")
    names = [axis["name"] for axis in board["axes"]]
    for name, um in board["backlash"].items():
        if name not in names:
            raise BoardError("backlash: there is no axis %r" % name)
        if not isinstance(um, int) or isinstance(um, bool) or not 0 <= um <= MOST_UM:
            raise BoardError("backlash.%s: %r is not within 0 … %d" % (name, um, MOST_UM))
    additions = board["additions"]
    for number in range(len(names)):
        additions.settings[160 + number] = names[number] + "_backlash", 3, board["backlash"].get(names[number], 0), 0, MOST_UM
    additions.motion, additions.queue = "passo.options.backlash.motion", "passo.options.backlash.control"
