"""The lines of a parallel port on the chip's pins: each output bit remapped, inverted or disabled. Loaded only if asked for.

    "step_program": {…, "port_pins": [8, 5, 2, 6, 3, 7, 4, 9], "port_bits": "76543210", "port_invert": 0x00}

`port_pins` are the GPIOs of the lines D0 to D7. `port_bits` says on which of them the bits 7 to 0 appear (drives on, Z pulse, Z dir, Y
pulse, Y dir, X pulse, X dir, tool), "-" on none; `port_invert` is the mask of the bits that appear inverted. They replace the board file's
pins of axes, tool and the output `enable`; polarities there count as before, and are inverted by `port_invert`. A disabled bit has a line
that is left over, which stays low.

    board, masks = apply_pins(board)    # a raw board file; masks: of a word's levels

`inverted` and `muted` are masks of a step word's levels (passo/steps/wiring.py).
"""

from passo.config.board_error import BoardError

_DRIVES = 7
_LINES = "01234567"


def apply_pins(board):
    """Return (a copy of a raw board file with its pins by lines, {"inverted": mask, "muted": mask}). Raises BoardError."""
    board = dict(board)
    section = board["step_program"] = dict(board["step_program"])
    pins = section.pop("port_pins")
    bits = section.get("port_bits", "76543210")
    invert = section.get("port_invert", 0)
    _check_pins(board, pins, bits, invert)
    free = [line for line in _LINES if line not in bits]
    line_of = [bits[7 - bit] if bits[7 - bit] != "-" else free.pop(0) for bit in range(8)]
    pin_of = [pins[int(line)] for line in line_of]
    muted = [bits[7 - bit] == "-" for bit in range(8)]
    count = len(board["axes"])
    board["axes"] = [dict(axis, pins=[pin_of[2 * number + 2], pin_of[2 * number + 1]]) for number, axis in enumerate(board["axes"])]
    masks = {"inverted": 0, "muted": 0}
    positions = [(0, 2 * count)]  # (bit of the port, bit of a word)
    for axis in range(count):
        positions += [(2 * axis + 2, axis), (2 * axis + 1, count + axis)]
    for bit, position in positions:
        masks["inverted"] |= (invert >> bit & 1) << position
        masks["muted"] |= muted[bit] << position
    board["tool"] = dict(board["tool"], pin=pin_of[0])
    outputs = []
    for item in board.get("outputs", ()):
        if item.get("name") != "enable":
            outputs.append(item)
        elif not muted[_DRIVES]:
            outputs.append(dict(item, pin=pin_of[_DRIVES], active=item.get("active", 1) ^ invert >> _DRIVES & 1))
    board["outputs"] = outputs
    return board, masks


def _check_pins(board, pins, bits, invert):
    """Raise BoardError if the section's three keys, or the rest of the board file, do not fit each other."""
    where = "step_program.port_pins: "
    drive = board.get("drive")
    if not isinstance(drive, dict) or drive.get("kind", "step_dir") != "step_dir":
        raise BoardError(where + "the bits are those of STEP/DIR drivers")
    if str(board.get("chip", "rp2040"))[:2] != "rp" and "-" in str(bits):
        raise BoardError(where + "a bit is disabled on an RP2040 or RP2350 only")
    if not isinstance(pins, (list, tuple)) or len(pins) != 8 or len(set(pins)) != 8:
        raise BoardError(where + "eight different GPIOs are wanted, those of D0 to D7")
    left = bits.replace("-", "") if isinstance(bits, str) else "x"
    if not isinstance(bits, str) or len(bits) != 8 or len(set(left)) != len(left) or set(left) - set(_LINES):
        raise BoardError("step_program.port_bits: each of 0 … 7 once at most, and - for none, not %r" % bits)
    if not isinstance(invert, int) or not 0 <= invert <= 255:
        raise BoardError("step_program.port_invert: %r is not within 0 … 255" % invert)
    axes = board.get("axes")
    if not isinstance(axes, (list, tuple)) or not 1 <= len(axes) <= 3 or board.get("gantry"):
        raise BoardError(where + "a parallel port has bits for one motor of each of three axes")
    if not isinstance(board.get("tool"), dict) or not all([isinstance(axis, dict) for axis in axes]):
        raise BoardError(where + "the tool and the axes have to be there, but for their pins")
