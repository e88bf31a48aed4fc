"""From a checked board file to the pins of a step word: which pin is which bit, its polarity, and how long words last."""

from passo.steps.word import us_to_ticks

COIL_WORD_TICKS = us_to_ticks(4)  # the shortest word without a pulse: a real player needs it


def word_pins(board):
    """Return the pin numbers in the order of a word's bits, the tool last. STEP/DIR: all STEPs, then all DIRs, a second motor of an axis behind the
    axes."""
    axes = board["axes"]
    if board["drive"]["kind"] == "step_dir":
        motors = axes + getattr(board.get("additions"), "more_motors", [])
        pins = [motor["pins"][0] for motor in motors] + [motor["pins"][1] for motor in motors]
    else:
        pins = [pin for axis in axes for pin in axis["pins"]]
    return pins + [board["tool"]["pin"]]


def word_times(board):
    """Return (ticks of a pulse, ticks of the shortest word): a pulse is as long low as it is high."""
    drive = board["drive"]
    if drive["kind"] != "step_dir":
        return 0, COIL_WORD_TICKS
    pulse_ticks = us_to_ticks(drive.get("pulse_us", 2))
    return pulse_ticks, 2 * pulse_ticks


def inversion_mask(board, layout):
    """Return the mask of the word's bits whose electrical level is the opposite of the word's."""
    axes = board["axes"]
    mask = 0 if board["tool"].get("active", 1) else layout.tool_mask
    if layout.kind == "step_dir":
        if not board["drive"].get("step_active", 1):
            mask |= (1 << layout.motors) - 1
        for axis in range(len(axes)):
            if axes[axis].get("step_inverted", False):
                mask ^= 1 << axis
            if axes[axis].get("reversed", False):
                mask |= 1 << (layout.motors + axis)
        for motor in getattr(board.get("additions"), "more_motors", ()):
            axis = axes[motor["axis"]]  # of whose second motor $2 turns the pulses round as of the first, $3 the directions
            if axis.get("step_inverted", False):
                mask ^= 1 << layout.axes
            if axis.get("reversed", False) != motor["opposite"]:
                mask ^= 1 << (layout.motors + layout.axes)
        mask ^= _option_mask(board, "inverted")
    return mask


def mute_mask(board):
    """Return the mask of the word's bits that stay low, whatever a word says."""
    return _option_mask(board, "muted")


def _option_mask(board, key):
    """Return the mask of levels that the board's options add under `key`; 0: none."""
    return getattr(board.get("additions"), "levels", {}).get(key, 0)
