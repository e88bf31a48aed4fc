"""Polarity of the second motor of a gantry."""


def second(board, layout):
    """Mask of its pins whose electrical level is the opposite of the word's; of STEP: of the other STEPs'. $2 turns the pulses of both motors round, $3 the directions."""
    gantry = board["gantry"]
    names = [axis["name"] for axis in board["axes"]]
    axis = board["axes"][names.index(gantry["axis"])]
    step = 1 if axis.get("step_inverted", False) else 0
    direction = 1 if axis.get("reversed", False) != gantry["opposite"] else 0
    return step << layout.axes | direction << layout.motors + layout.axes
