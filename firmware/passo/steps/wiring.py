"""From a checked board file to the pins of a step word: which pin is which bit, its polarity, and how long words last."""

from passo.steps.word import us_to_ticks

COIL_WORD_TICKS = us_to_ticks(4)  # the shortest word without a pulse: what a real player needs for one


def word_pins(board):
    """Pin numbers in the order of a word's bits, the tool last. STEP/DIR: all STEPs, then all DIRs."""
    axes = board["axes"]
    if board["drive"]["kind"] == "step_dir":
        pins = [axis["pins"][0] for axis in axes] + [axis["pins"][1] for axis in axes]
    else:
        pins = [pin for axis in axes for pin in axis["pins"]]
    return pins + [board["tool"]["pin"]]


def word_times(board):
    """(ticks of a pulse, ticks of the shortest word): a pulse is as long low as it is high."""
    drive = board["drive"]
    if drive["kind"] != "step_dir":
        return 0, COIL_WORD_TICKS
    pulse_ticks = us_to_ticks(drive.get("pulse_us", 2))
    return pulse_ticks, 2 * pulse_ticks


def inverted_pins(board, layout):
    """Mask of the player's pins whose electrical level is the opposite of the word's."""
    axes = board["axes"]
    mask = 0 if board["tool"].get("active", 1) else layout.tool_mask
    if layout.kind == "step_dir":
        if not board["drive"].get("step_active", 1):
            mask |= layout.step_mask
        for axis in range(len(axes)):
            if axes[axis].get("step_inverted", False):
                mask ^= 1 << axis
            if axes[axis].get("reversed", False):
                mask |= 1 << (layout.axes + axis)
    return mask
